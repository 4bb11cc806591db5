"""`conav repair`."""

from pathlib import Path


def repair(run: Path, /, *, out: Path) -> int:
    """Copy what is whole of a damaged run file into a new one that every tool opens.

    Parameters
    ----------
    run
        The damaged file, for example of a run that was killed.
    out
        The file to write.
    """
    from conav.runs.reader import repair_run

    count = repair_run(run, out)
    print(f"{out}: {count} messages saved")
    return 0
