"""`python -m conav`."""

from conav.cli import main

if __name__ == "__main__":
    main()
