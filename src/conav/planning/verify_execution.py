"""The verifier of executions: whether robots drove what they say, and touched nobody but as said.

It shares nothing with what drives: distances, curves and clearances are those of the verifier of
plans. That somebody touched is no breach; saying otherwise is one. See docs/execution.md.
"""

from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.verify_claims import check_tasks
from conav.planning.verify_clearance import Clearance, check_pairs, check_walls
from conav.planning.verify_curves import place_at
from conav.planning.verify_deviation import deviation
from conav.planning.verify_motion import check_joints, well_formed
from conav.planning.verify_scene import TOLERANCE, Check, Scene, Violation, is_number, read_scene
from conav.runs.types import ExecutionRun, PlanRun, TrajectoryRecord

CHECKS = ("form", "starts", "continuity", "lags", "deviations", "clearances")


@dataclass(frozen=True)
class ExecutionReport:
    """What the verifier found."""

    path: str
    checks: tuple[Check, ...]
    walls: Clearance | None  # of the robots as they are; None: the run has no form
    robots: Clearance | None
    tasks: Check  # whose task was not done as driven: told, and no breach
    intact: bool
    finished: bool
    digest: str

    @property
    def verdict(self) -> str:
        """`violated` when a rule was broken, `verified` when all there is was checked."""
        if any(check.broken for check in self.checks):
            return "violated"
        whole = self.intact and self.finished and not any(one.unchecked for one in self.checks)
        return "verified" if whole else "partly checked"

    @property
    def accepted(self) -> bool:
        """Whether no rule was broken."""
        return self.verdict != "violated"

    def lines(self) -> list[str]:
        """The report for people."""
        lines: list[str] = []
        for check in self.checks:
            mark = "ok" if check.broken == 0 else f"BROKEN {check.broken} times"
            lines.append(f"{check.name}: {mark} ({check.looked} looked at)")
            lines += [f"  {violation}" for violation in check.violations]
            lines += [f"  not checked: {text}" for text in check.unchecked]
        for name, found in (("walls", self.walls), ("robots", self.robots)):
            if found is not None and isfinite(found.high):
                touched = "touched: " if found.high < -TOLERANCE else ""
                who = " and ".join(found.robots)
                lines.append(f"smallest clearance from {name}: {touched}{found.high:.6f} m ({who})")
        lines += [f"as driven, {violation}" for violation in self.tasks.violations]
        if not self.intact:
            lines.append("the file was cut short or damaged; only what is whole was checked")
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
            "clearance": {
                "walls": None if self.walls is None else self.walls.summary(),
                "robots": None if self.robots is None else self.robots.summary(),
            },
            "tasks_missed": [list(one.robots) for one in self.tasks.violations],
            "checks": {
                check.name: {
                    "looked": check.looked,
                    "broken": check.broken,
                    "violations": [{**one._asdict(), "text": str(one)} for one in check.violations],
                    "unchecked": check.unchecked,
                }
                for check in self.checks
            },
        }


def verify_execution(run: ExecutionRun) -> ExecutionReport:
    """The verdict on the run of robots that drove a plan.

    Raises `InputError` when its header is not one of an execution.
    """
    bounds = _bounds(run)
    scene = read_scene(_as_plan(run))
    checks = {name: Check(name) for name in CHECKS}
    tasks = Check("tasks")
    planned = scene._replace(tracks=tuple(_rows(run.planned, i) for i in range(len(scene.bodies))))
    if not (well_formed(planned, checks["form"]) and well_formed(scene, checks["form"])):
        return _report(run, (checks["form"],), None, None, tasks)
    _check_pairs_of_ways(planned, scene, checks["form"])
    _check_starts(scene, checks["starts"])
    check_joints(scene, checks["continuity"])
    lags = _check_lags(run, planned, scene, bounds["delay_s"], checks["lags"])
    farthest = _check_deviations(
        planned, scene, lags, bounds["tracking_error_m"], checks["deviations"]
    )
    walls = check_walls(scene, wall_check := Check("walls"))
    robots = check_pairs(scene, pair_check := Check("robots"))
    check_tasks(scene, tasks)
    if run.result is not None:
        _check_claims(
            run.result, (robots, pair_check), (walls, wall_check), farthest, checks["clearances"]
        )
    return _report(run, tuple(checks.values()), walls, robots, tasks)


def _bounds(run: ExecutionRun) -> dict[str, float]:
    if run.header.get("job") != "execute":
        raise InputError(
            run.path, f"is a run of job {run.header.get('job')!r}", "give an execution"
        )
    found: dict[str, float] = {}
    for name in ("tracking_error_m", "delay_s", "slack_m"):
        value = run.header.get(name)
        if not is_number(value) or value < 0.0:
            raise InputError(run.path, f"has a {name} of {value!r}", "the file is damaged")
        found[name] = float(value)
    return found


def _as_plan(run: ExecutionRun) -> PlanRun:
    """The driven ways as those of a plan."""
    return PlanRun(
        path=run.path,
        header={"job": "plan", "problem": run.header.get("problem")},
        result=None,
        timing={},
        digest=run.digest,
        intact=run.intact,
        history=[],
        trajectories=[TrajectoryRecord(i, 0, pieces) for i, pieces in run.driven.items()],
        graphs={},
    )


def _rows(ways: dict[int, NDArray[np.float64]], robot: int) -> NDArray[np.float64] | None:
    pieces = ways.get(robot)
    return pieces if pieces is not None and len(pieces) else None


def _check_pairs_of_ways(planned: Scene, driven: Scene, check: Check) -> None:
    """Who has a plan drives, and nobody else."""
    for body, plan, way in zip(driven.bodies, planned.tracks, driven.tracks, strict=True):
        if (plan is None) != (way is None):
            what = "has a plan and does not drive" if way is None else "drives without a plan"
            check.fault(Violation(what, (body.name,)))


def _check_starts(scene: Scene, check: Check) -> None:
    """Everybody is at its start at time 0."""
    for _, body, track in scene.ways():
        check.looked += 1
        x, y = track[0, 2:4].tolist()
        off = float(np.hypot(x - body.start[0], y - body.start[1]))
        if abs(track[0, 0]) > TOLERANCE or off > TOLERANCE:
            check.fault(Violation("does not begin at its start", (body.name,), 0.0, (x, y)))


def _check_lags(
    run: ExecutionRun, planned: Scene, driven: Scene, delay: float, check: Check
) -> list[float]:
    """Each robot ends its way by its lag after the plan, and no lag is above the bound."""
    claimed = run.result.get("lags_s") if run.result is not None else None
    lags: list[float] = []
    for i, (body, plan, way) in enumerate(
        zip(driven.bodies, planned.tracks, driven.tracks, strict=True)
    ):
        if plan is None or way is None:
            lags.append(0.0)
            continue
        check.looked += 1
        lag = float(way[-1, 1] - plan[-1, 1])
        lags.append(lag)
        if not -TOLERANCE <= lag <= delay + TOLERANCE:
            text = f"is {lag:.6g} s behind its plan, and {delay:g} at most is said"
            check.fault(Violation(text, (body.name,)))
        said = claimed[i] if isinstance(claimed, list) and i < len(claimed) else lag
        if not is_number(said) or abs(said - lag) > TOLERANCE:
            check.fault(Violation(f"is said to be {said} s late, and is {lag:.6g}", (body.name,)))
    return lags


def _check_deviations(
    planned: Scene, driven: Scene, lags: list[float], bound: float, check: Check
) -> tuple[float, float]:
    """Nobody is farther from its late plan than the bound; bounds on the farthest."""
    low = high = 0.0
    for body, plan, way, lag in zip(
        driven.bodies, planned.tracks, driven.tracks, lags, strict=True
    ):
        if plan is None or way is None:
            continue
        check.looked += 1
        late = _late(plan, lag)
        least, most, when = deviation(late, way)
        low, high = max(low, least), max(high, most)
        if most > bound + TOLERANCE:
            text = f"is {most:.6g} m from its late plan, and {bound:g} at most is said"
            check.fault(Violation(text, (body.name,), float(when)))
    return low, high


def _late(plan: NDArray[np.float64], lag: float) -> NDArray[np.float64]:
    """A plan that waits at its start first, and at its end for a moment, should rounding ask."""
    late = plan.copy()
    late[:, :2] += lag
    wait, rest = np.zeros(9), np.zeros(9)
    wait[:4] = 0.0, late[0, 0], late[0, 2], late[0, 3]
    rest[:4] = late[-1, 1], late[-1, 1] + 1.0, *place_at(late[-1], late[-1, 1])
    return np.vstack([wait, late, rest])


def _check_claims(
    result: dict[str, Any],
    pairs: tuple[Clearance, Check],
    walls: tuple[Clearance, Check],
    farthest: tuple[float, float],
    check: Check,
) -> None:
    """What the run says of clearances, touches and deviations is so, but for its tolerance."""
    tolerance = result.get("tolerance_m")
    if not is_number(tolerance) or not 0.0 <= tolerance <= 1e-2:
        check.fault(Violation(f"the tolerance is said to be {tolerance!r}"))
        return
    for name, (found, each), list_name in (
        ("clearance_m", pairs, "touches"), ("wall_clearance_m", walls, "wall_touches"),
    ):  # fmt: skip
        check.looked += 1
        said, listed = result.get(name), result.get(list_name)
        if (said is None) != (found.high == inf):
            check.fault(Violation(f"{name} is said to be {said}"))
            continue
        if said is not None and not (
            is_number(said) and found.low - tolerance - TOLERANCE <= said <= found.high + TOLERANCE
        ):
            check.fault(Violation(f"{name} is said to be {said}, and is {found.high:.9g}"))
        count = len(listed) if isinstance(listed, list) else -1
        # Overlaps of less than the tolerances may count or not.
        if count < each.broken or (count > each.broken and found.low > tolerance):
            check.fault(Violation(f"{list_name} are said to be {count}, and are {each.broken}"))
    touched = bool(result.get("touches")) or bool(result.get("wall_touches"))
    if result.get("touched") is not touched:
        check.fault(Violation(f"touched is said to be {result.get('touched')!r}"))
    said = result.get("deviation_m")
    check.looked += 1
    if not is_number(said) or not 0.9 * farthest[0] - TOLERANCE <= said <= farthest[1] + TOLERANCE:
        check.fault(
            Violation(f"the deviation is said to be {said}, and is {farthest[0]:.9g} m at least")
        )


def _report(
    run: ExecutionRun,
    checks: tuple[Check, ...],
    walls: Clearance | None,
    robots: Clearance | None,
    tasks: Check,
) -> ExecutionReport:
    return ExecutionReport(
        str(run.path), checks, walls, robots, tasks, run.intact, run.result is not None, run.digest
    )
