"""The command line: parse, call one function, print."""

import sys
from collections.abc import Sequence
from io import TextIOWrapper

DONE = 0
NOT_DONE = 1
BAD_INPUT = 2
INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and leave with its exit code: 0 done, 1 not done, 2 bad input."""
    if isinstance(sys.stdout, TextIOWrapper):
        # A map's name may hold what the terminal's encoding does not.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        code = run(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of our output went away, as in `conav maps | head`; nothing is left to say.
        sys.stderr.close()
        code = DONE
    sys.exit(code)


def run(arguments: Sequence[str] | None = None) -> int:
    """The exit code of the command with these arguments."""
    from cyclopts import CycloptsError

    from conav.cli.app import app
    from conav.cli.interrupts import Interrupted
    from conav.errors import InputError

    tokens = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        return code if isinstance(code, int) else DONE
    except CycloptsError as error:
        text = " ".join(str(error).split())
        link = " Try" if text.endswith((".", "?", "!")) else "; try"
        print(f"conav: {text}{link} conav --help", file=sys.stderr)
        return BAD_INPUT
    except InputError as error:
        print(f"conav: {error}", file=sys.stderr)
        return BAD_INPUT
    except MemoryError:
        print("conav: not enough memory; use a larger --cell or a smaller map", file=sys.stderr)
        return BAD_INPUT
    except (KeyboardInterrupt, Interrupted):
        print("conav: interrupted", file=sys.stderr)
        return INTERRUPTED
