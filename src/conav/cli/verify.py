"""`conav verify`."""

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from conav.exploration.verify import VerificationReport
    from conav.planning.verify import PlanReport
    from conav.planning.verify_execution import ExecutionReport
    from conav.pursuit.verify import PursuitReport
    from conav.runs.types import PursuitRun


def verify(
    run: Path,
    /,
    *,
    json: Annotated[bool, Parameter(negative="")] = False,
    certificate: Path | None = None,
    png: Path | None = None,
) -> int:
    """Check a run file: that everything in it obeys the rules and its numbers are right.

    Parameters
    ----------
    run
        A run file written by conav.
    json
        Print one JSON object instead of lines.
    certificate
        Of a pursuit: write the proof that nobody can stay unseen to this file (JSON).
    png
        Of a pursuit: draw the floor, the pursuers' ways and an evader's escape to this file.
    """
    report = _report(run, certificate, png)
    if json:
        print(json_module.dumps(report.summary()))
    else:
        for line in report.lines():
            print(line)
    return 0 if report.accepted else 1


def _report(
    path: Path, certificate: Path | None, png: Path | None
) -> "VerificationReport | PlanReport | ExecutionReport | PursuitReport":
    """The verdict of the verifier of the run's job."""
    from conav.errors import InputError
    from conav.runs.reader import read_run
    from conav.runs.types import ExecutionRun, ExplorationRun, PlanRun, PursuitRun

    run = read_run(path)
    if isinstance(run, PursuitRun):
        return _pursuit(run, certificate, png)
    for option, given in (("--certificate", certificate), ("--png", png)):
        if given is not None:
            raise InputError(option, "is for runs of pursuits", "leave it out")
    if isinstance(run, PlanRun):
        from conav.planning.verify import verify_plan

        return verify_plan(run)
    if isinstance(run, ExecutionRun):
        from conav.planning.verify_execution import verify_execution

        return verify_execution(run)
    from conav.exploration.verify import verify_exploration

    assert isinstance(run, ExplorationRun)
    return verify_exploration(run)


def _pursuit(run: "PursuitRun", certificate: Path | None, png: Path | None) -> "PursuitReport":
    from conav.errors import InputError
    from conav.pursuit.verify import verify_pursuit

    report = verify_pursuit(run)
    if certificate is not None:
        if report.found.certificate is None:
            raise InputError(
                certificate,
                f"is not written: the verdict is {report.found.verdict}, and only a capture has "
                "a certificate",
                "leave out --certificate",
            )
        try:
            text = json_module.dumps(report.found.certificate, sort_keys=True)
            certificate.write_text(text + "\n", encoding="utf-8")
        except OSError as error:
            raise InputError(
                certificate, f"cannot be written ({error.strerror})", "name another file"
            ) from None
    if png is not None:
        from conav.pictures.pursuit_still import save_pursuit_still

        save_pursuit_still(run, png, report.found.escape)
    return report
