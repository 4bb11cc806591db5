"""`conav verify`."""

import json as json_module
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def verify(run: Path, /, *, json: Annotated[bool, Parameter(negative="")] = False) -> int:
    """Check a run file: that everything in it obeys the rules and its numbers are right.

    Parameters
    ----------
    run
        A run file written by conav.
    json
        Print one JSON object instead of lines.
    """
    from conav.exploration.verify import verify_exploration
    from conav.runs.reader import read_exploration

    report = verify_exploration(read_exploration(run))
    if json:
        print(json_module.dumps(report.summary()))
    else:
        for line in report.lines():
            print(line)
    return 0 if report.accepted else 1
