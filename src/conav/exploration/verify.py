"""The verifier of exploration runs: re-derives every rule from the run file alone.

It imports no strategy, no belief and no simulator; its geometry is its own. What it accepts:
docs/verify.md.
"""

from dataclasses import dataclass
from typing import Any

from conav.exploration.verify_faults import check_faults, conditions
from conav.exploration.verify_knowledge import check_knowledge
from conav.exploration.verify_metrics import check_ending, check_metrics, observable_cells
from conav.exploration.verify_motion import (
    Moves,
    check_collisions,
    check_headings,
    check_speed,
    check_walls,
    well_formed,
)
from conav.exploration.verify_world import Check, read_world
from conav.runs.types import ExplorationRun

CHECKS = (
    "form",
    "walls",
    "speed",
    "headings",
    "collisions",
    "faults",
    "sight and knowledge",
    "radio",
    "messages",
    "metrics",
    "ending",
)


@dataclass(frozen=True)
class VerificationReport:
    """What the verifier found; `accepted` when no rule was broken."""

    path: str
    checks: tuple[Check, ...]
    intact: bool  # the file was neither cut short nor damaged
    finished: bool  # it tells how the run ended
    digest: str

    @property
    def accepted(self) -> bool:
        return all(check.broken == 0 for check in self.checks)

    def broken(self) -> tuple[str, ...]:
        """The names of the checks that found a breach."""
        return tuple(check.name for check in self.checks if check.broken)

    def lines(self) -> list[str]:
        """The report for people, a line a check and one per fault."""
        lines: list[str] = []
        for check in self.checks:
            mark = "ok" if check.broken == 0 else f"BROKEN {check.broken} times"
            lines.append(f"{check.name}: {mark} ({check.looked} looked at)")
            lines.extend(f"  {text}" for text in check.faults)
        if not self.intact:
            lines.append("the file was cut short or damaged; only what is whole was checked")
        if not self.finished:
            lines.append("the file does not tell how the run ended; only its steps were checked")
        verdict = "accepted" if self.accepted else "REJECTED"
        lines.append(f"{verdict}: {self.path} (digest {self.digest[:16]})")
        return lines

    def summary(self) -> dict[str, Any]:
        """The report as one JSON object."""
        return {
            "job": "verify",
            "run": self.path,
            "accepted": self.accepted,
            "intact": self.intact,
            "finished": self.finished,
            "digest": self.digest,
            "checks": {
                check.name: {
                    "looked": check.looked,
                    "broken": check.broken,
                    "faults": check.faults,
                }
                for check in self.checks
            },
        }


def verify_exploration(run: ExplorationRun) -> VerificationReport:
    """The verdict on an exploration's run file.

    Raises `InputError` when the run is of another job or its header is not one of an exploration.
    """
    world = read_world(run)
    checks = {name: Check(name) for name in CHECKS}
    if not well_formed(run, world, checks["form"]):
        return _report(run, (checks["form"],))
    moves = Moves(world)
    check_walls(run, world, checks["walls"], moves)
    found = conditions(run, world)
    check_faults(run, world, found, checks["faults"])
    check_speed(run, world, found, checks["speed"], moves)
    check_headings(run, world, checks["headings"])
    check_collisions(run, world, found, checks["collisions"])
    observable = observable_cells(world)
    total = int(observable.sum())
    seen = check_knowledge(
        run,
        world,
        found,
        observable,
        checks["sight and knowledge"],
        checks["radio"],
        checks["messages"],
    )
    if run.steps:
        check_metrics(run, world, total, seen, checks["metrics"])
        check_ending(run, world, found, total, seen, checks["ending"])
    return _report(run, tuple(checks.values()))


def _report(run: ExplorationRun, checks: tuple[Check, ...]) -> VerificationReport:
    return VerificationReport(
        path=str(run.path),
        checks=checks,
        intact=run.intact,
        finished=run.result is not None,
        digest=run.digest,
    )
