"""`conav verify`."""

import json as json_module
from pathlib import Path
from typing import Annotated, Any, Protocol

from cyclopts import Parameter


class _Report(Protocol):
    """What the verifiers of all jobs hand back."""

    @property
    def accepted(self) -> bool: ...
    def lines(self) -> list[str]: ...
    def summary(self) -> dict[str, Any]: ...


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
    from conav.runs.reader import read_run
    from conav.runs.types import PursuitRun

    read = read_run(run)
    if isinstance(read, PursuitRun):
        report = _pursuit(read, certificate, png)
    else:
        if certificate is not None or png is not None:
            from conav.errors import InputError

            option = "--certificate" if certificate is not None else "--png"
            raise InputError(option, "is for runs of pursuits", "leave it out")
        report = _report(read)
    if json:
        print(json_module.dumps(report.summary()))
    else:
        for line in report.lines():
            print(line)
    return 0 if report.accepted else 1


def _report(run: Any) -> _Report:
    """The verdict of the verifier of the run's job, an exploration's or a plan's."""
    from conav.runs.types import ExplorationRun, PlanRun

    if isinstance(run, PlanRun):
        from conav.planning.verify import verify_plan

        return verify_plan(run)
    from conav.exploration.verify import verify_exploration

    assert isinstance(run, ExplorationRun)
    return verify_exploration(run)


def _pursuit(run: Any, certificate: Path | None, png: Path | None) -> _Report:
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
