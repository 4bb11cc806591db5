"""`conav verify`."""

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from conav.exploration.verify import VerificationReport
    from conav.planning.verify import PlanReport


def verify(run: Path, /, *, json: Annotated[bool, Parameter(negative="")] = False) -> int:
    """Check a run file: that everything in it obeys the rules and its numbers are right.

    Parameters
    ----------
    run
        A run file written by conav.
    json
        Print one JSON object instead of lines.
    """
    report = _report(run)
    if json:
        print(json_module.dumps(report.summary()))
    else:
        for line in report.lines():
            print(line)
    return 0 if report.accepted else 1


def _report(path: Path) -> "VerificationReport | PlanReport":
    """The verdict of the verifier of the run's job."""
    from conav.runs.reader import read_run
    from conav.runs.types import PlanRun

    run = read_run(path)
    if isinstance(run, PlanRun):
        from conav.planning.verify import verify_plan

        return verify_plan(run)
    from conav.exploration.verify import verify_exploration
    from conav.runs.types import ExplorationRun

    assert isinstance(run, ExplorationRun)
    return verify_exploration(run)
