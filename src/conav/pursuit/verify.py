"""The verifier of pursuits: re-derives every rule, and who could escape, from the run file alone.

It imports no planner and none of the geometry they use. What it checks and why it may be believed:
docs/pursuit-verifier.md.
"""

from dataclasses import dataclass
from typing import Any

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule
from conav.pursuit.verify_beliefs import check_beliefs, check_explored
from conav.pursuit.verify_certificate import certificate
from conav.pursuit.verify_decide import Verdict, decide
from conav.pursuit.verify_escape import escape_path
from conav.pursuit.verify_escape_check import EvaderPath
from conav.pursuit.verify_lattice import Lattice, make_lattice
from conav.pursuit.verify_motion import (
    check_knowledge,
    check_result,
    check_speed,
    check_starts,
    check_walls,
)
from conav.pursuit.verify_problem import Check, read_problem, read_schedule
from conav.pursuit.verify_step import Stepper
from conav.pursuit.verify_timeline import Piece, Ranges, Unverifiable, timeline
from conav.runs.types import PursuitRun

CHECKS = ("form", "starts", "walls", "speed", "reach", "knowledge", "capture", "beliefs", "result")


@dataclass(frozen=True, eq=False)
class PursuitVerdict:
    """Whether an evader of unbounded speed can stay unseen, with what shows it."""

    verdict: Verdict
    reason: str  # why it is unknown
    pieces: tuple[Piece, ...]  # the motions that were looked at
    escape: EvaderPath | None  # of ESCAPES
    certificate: dict[str, Any] | None  # of CAPTURED; `certificate_faults` checks it
    grid_m: float  # [m] to which places were rounded


@dataclass(frozen=True, eq=False)
class PursuitReport:
    """What the verifier found; `accepted` when no rule was broken."""

    path: str
    checks: tuple[Check, ...]
    intact: bool  # the file was neither cut short nor damaged
    finished: bool  # it tells how the run ended
    digest: str
    found: PursuitVerdict
    open_beliefs: int  # beliefs neither refuted nor confirmed

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
        if self.open_beliefs:
            lines.append(f"{self.open_beliefs} beliefs could be neither refuted nor confirmed")
        if not self.intact:
            lines.append("the file was cut short or damaged; only what is whole was checked")
        if not self.finished:
            lines.append("the file does not tell how the run ended; only its legs were checked")
        found = self.found
        what = {
            Verdict.CAPTURED: "captured: nobody can stay unseen",
            Verdict.ESCAPES: "escapes: somebody can stay unseen",
            Verdict.UNKNOWN: f"unknown: {found.reason}",
        }[found.verdict]
        lines.append(f"{what} ({len(found.pieces)} motions, places to {found.grid_m:g} m)")
        verdict = "accepted" if self.accepted else "REJECTED"
        lines.append(f"{verdict}: {self.path} (digest {self.digest[:16]})")
        return lines

    def summary(self) -> dict[str, Any]:
        """The report as one JSON object."""
        escape = self.found.escape
        return {
            "job": "verify",
            "run": self.path,
            "accepted": self.accepted,
            "intact": self.intact,
            "finished": self.finished,
            "digest": self.digest,
            "verdict": str(self.found.verdict),
            "reason": self.found.reason,
            "motions": len(self.found.pieces),
            "grid_m": self.found.grid_m,
            "open_beliefs": self.open_beliefs,
            "escape": None
            if escape is None
            else {"times_s": escape.times.tolist(), "places_m": escape.places.tolist()},
            "checks": {
                check.name: {
                    "looked": check.looked,
                    "broken": check.broken,
                    "faults": check.faults,
                }
                for check in self.checks
            },
        }


def verify_pursuit(run: PursuitRun) -> PursuitReport:
    """The verdict on a pursuit's run file.

    Raises `InputError` when its header is not one of a pursuit, or its floor has walls nearer to
    each other than the verifier tells apart.
    """
    problem = read_problem(run)
    checks = {name: Check(name) for name in CHECKS}
    lattice = make_lattice(problem.plan)
    schedule = read_schedule(run, problem, checks["form"])
    if schedule is None:
        nothing = _unknown("the legs do not make a schedule", lattice)
        return _report(run, (checks["form"],), nothing, 0)
    check_starts(problem, schedule, checks["starts"])
    check_walls(problem, schedule, lattice, checks["walls"])
    check_speed(problem, schedule, checks["speed"], checks["reach"])
    check_knowledge(problem, schedule, lattice, checks["knowledge"])
    stepper = Stepper(lattice)
    found = _verdict(problem.plan, schedule, problem.ranges, stepper, run.digest)
    done = run.result is not None and run.result.get("status") == "done"
    if done:
        text = f"the run says that nobody is hidden, which is {found.verdict}"
        checks["capture"].look(found.verdict is Verdict.CAPTURED, text)
    open_beliefs = 0
    if run.beliefs and found.pieces:
        check = checks["beliefs"]
        open_beliefs = check_beliefs(
            run.beliefs, schedule, found.pieces, stepper, problem.known, check
        )
        last = run.beliefs.get(len(run.legs) - 1)
        if done and last is not None:
            text = "the run says that nobody is hidden, and the team that somebody may be"
            check.look(all(one.clear for one in last), text)
    if run.result is not None and not problem.known and found.pieces:
        check_explored(run.result, found.pieces, stepper, checks["knowledge"])
    if run.result is not None:
        check_result(run.result, problem, schedule, checks["result"])
    return _report(run, tuple(checks.values()), found, open_beliefs)


def verify_schedule(plan: PolygonMap, schedule: Schedule, ranges: Ranges) -> PursuitVerdict:
    """Whether a schedule lets an evader of unbounded speed stay unseen; `ranges` [m] as in
    `Pursuer`.

    Raises `InputError` where the floor has walls nearer to each other than the verifier tells
    apart.
    """
    return _verdict(plan, schedule, ranges, Stepper(make_lattice(plan)), "")


def _verdict(
    plan: PolygonMap, schedule: Schedule, ranges: Ranges, stepper: Stepper, digest: str
) -> PursuitVerdict:
    grid_m = stepper.lattice.grid_m
    try:
        pieces = timeline(schedule, ranges, stepper.lattice)
    except Unverifiable as error:
        return _unknown(str(error), stepper.lattice)
    decision = decide(pieces, stepper)
    if decision.verdict is Verdict.CAPTURED:
        proof = certificate(decision, stepper, schedule, digest)
        return PursuitVerdict(Verdict.CAPTURED, "", decision.pieces, None, proof, grid_m)
    if decision.verdict is Verdict.ESCAPES:
        path = escape_path(decision, stepper, plan, schedule, ranges)
        if path is not None:
            return PursuitVerdict(Verdict.ESCAPES, "", decision.pieces, path, None, grid_m)
        reason = "an evader seems to escape, but no path was found that holds in every detail"
        return PursuitVerdict(Verdict.UNKNOWN, reason, decision.pieces, None, None, grid_m)
    return PursuitVerdict(Verdict.UNKNOWN, decision.reason, decision.pieces, None, None, grid_m)


def _unknown(reason: str, lattice: Lattice) -> PursuitVerdict:
    return PursuitVerdict(Verdict.UNKNOWN, reason, (), None, None, lattice.grid_m)


def _report(
    run: PursuitRun, checks: tuple[Check, ...], found: PursuitVerdict, open_beliefs: int
) -> PursuitReport:
    return PursuitReport(
        path=str(run.path),
        checks=checks,
        intact=run.intact,
        finished=run.result is not None,
        digest=run.digest,
        found=found,
        open_beliefs=open_beliefs,
    )
