"""The verifier of plans: re-derives every rule from the run file alone.

It imports no solver, no steering and no tasks; its curves, clearances, words, formulas, costs and
graphs are its own. What it accepts: docs/verify.md.
"""

from dataclasses import dataclass
from typing import Any, Literal

from conav.planning.verify_claims import (
    check_bound,
    check_costs,
    check_history,
    check_status,
    check_tasks,
)
from conav.planning.verify_clearance import NOBODY, Clearance, check_pairs, check_walls
from conav.planning.verify_couplings import check_couplings
from conav.planning.verify_equilibrium import check_equilibrium
from conav.planning.verify_motion import (
    check_arrivals,
    check_joints,
    check_speed,
    check_starts,
    check_steering,
    well_formed,
)
from conav.planning.verify_scene import Check, Scene, read_scene
from conav.runs.types import PlanRun

CHECKS = (
    "form",
    "starts",
    "continuity",
    "speed",
    "steering",
    "arrival",
    "walls",
    "collisions",
    "tasks",
    "couplings",
    "costs",
    "history",
    "status",
    "equilibrium",
    "lower bound",
)

Verdict = Literal["verified", "partly checked", "violated"]


@dataclass(frozen=True)
class PlanReport:
    """What the verifier found."""

    path: str
    checks: tuple[Check, ...]
    walls: Clearance  # the smallest of a robot from walls and obstacles
    robots: Clearance  # the smallest of two robots from each other
    planned: int  # robots that have a trajectory
    of: int  # robots
    intact: bool  # the file was neither cut short nor damaged
    finished: bool  # it tells how the run ended
    digest: str

    @property
    def verdict(self) -> Verdict:
        """`violated` when a rule was broken, `verified` when all there is was checked."""
        if any(check.broken for check in self.checks):
            return "violated"
        whole = self.intact and self.finished and not any(one.unchecked for one in self.checks)
        return "verified" if whole else "partly checked"

    @property
    def accepted(self) -> bool:
        """Whether no rule was broken."""
        return self.verdict != "violated"

    def broken(self) -> tuple[str, ...]:
        """The names of the checks that found a breach."""
        return tuple(check.name for check in self.checks if check.broken)

    def lines(self) -> list[str]:
        """The report for people, a line a check and one per violation."""
        lines: list[str] = []
        for check in self.checks:
            mark = "ok" if check.broken == 0 else f"BROKEN {check.broken} times"
            if check.looked == 0 and not check.broken:
                mark = "nothing to check"
            lines.append(f"{check.name}: {mark} ({check.looked} looked at)")
            lines += [f"  {violation}" for violation in check.violations]
            lines += [f"  not checked: {text}" for text in check.unchecked]
            lines += [f"  {text}" for text in check.notes]
        for name, clearance in (("walls", self.walls), ("robots", self.robots)):
            lines.append(f"smallest clearance from {name}: {_interval(clearance)}")
        if self.planned < self.of:
            lines.append(f"{self.of - self.planned} of {self.of} robots have no trajectory")
        if not self.intact:
            lines.append("the file was cut short or damaged; only what is whole was checked")
        if not self.finished:
            lines.append("the file does not tell how the run ended; its last plan was checked")
        lines.append(f"{self.verdict}: {self.path} (digest {self.digest[:16]})")
        return lines

    def summary(self) -> dict[str, Any]:
        """The report as one JSON object."""
        return {
            "job": "verify",
            "run": self.path,
            "verdict": self.verdict,
            "accepted": self.accepted,
            "intact": self.intact,
            "finished": self.finished,
            "digest": self.digest,
            "planned": self.planned,
            "robots": self.of,
            "clearance": {"walls": self.walls.summary(), "robots": self.robots.summary()},
            "checks": {
                check.name: {
                    "looked": check.looked,
                    "broken": check.broken,
                    "violations": [{**one._asdict(), "text": str(one)} for one in check.violations],
                    "unchecked": check.unchecked,
                    "notes": check.notes,
                }
                for check in self.checks
            },
        }


def verify_plan(run: PlanRun) -> PlanReport:
    """The verdict on a planner's run file.

    Raises `InputError` when the run is of another job or its header is not one of a plan.
    """
    scene = read_scene(run)
    checks = {name: Check(name) for name in CHECKS}
    if not well_formed(scene, checks["form"]):
        return _report(run, scene, (checks["form"],), NOBODY, NOBODY)
    check_starts(scene, checks["starts"])
    check_joints(scene, checks["continuity"])
    check_speed(scene, checks["speed"])
    check_steering(scene, checks["steering"])
    check_arrivals(scene, checks["arrival"])
    walls = check_walls(scene, checks["walls"])
    robots = check_pairs(scene, checks["collisions"])
    check_tasks(scene, checks["tasks"])
    check_couplings(run, scene, checks["couplings"])
    check_history(run, scene, checks["history"])
    if run.result is not None:
        check_costs(scene, run.result, checks["costs"])
        check_status(scene, run.result, checks["status"])
        check_equilibrium(run, scene, checks["equilibrium"])
        check_bound(scene, run.result, checks["lower bound"])
    return _report(run, scene, tuple(checks.values()), walls, robots)


def _report(
    run: PlanRun, scene: Scene, checks: tuple[Check, ...], walls: Clearance, robots: Clearance
) -> PlanReport:
    return PlanReport(
        path=str(run.path),
        checks=checks,
        walls=walls,
        robots=robots,
        planned=len(scene.ways()),
        of=len(scene.bodies),
        intact=run.intact,
        finished=run.result is not None,
        digest=run.digest,
    )


def _interval(clearance: Clearance) -> str:
    if not clearance.robots:
        return "none, nobody meets"
    who = " and ".join(clearance.robots)
    low, high = f"{clearance.low:.6f}", f"{clearance.high:.6f}"
    between = low if low == high else f"between {low} and {high}"
    return f"{between} m ({who} at {clearance.time_s:.6g} s)"
