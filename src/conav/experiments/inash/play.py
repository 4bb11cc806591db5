"""One plan, watched while it is made and looked over by the verifier's functions."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from math import isfinite
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.experiments.inash.world import ON_PAPER_GRAPHS, Case, Effort, problem_of, settings_of
from conav.planning.budget import Progress
from conav.planning.catalogue import make_solver
from conav.planning.plan import plan
from conav.planning.types import PlanningProblem, PlanningResult
from conav.planning.verify_claims import check_tasks
from conav.planning.verify_clearance import check_pairs, check_walls
from conav.planning.verify_equilibrium import check_equilibrium
from conav.planning.verify_motion import check_arrivals, check_joints, check_speed, check_starts
from conav.planning.verify_scene import Area, Body, Check, Scene
from conav.runs.types import PlanRun

Numbers = tuple[float | None, ...]


@dataclass(frozen=True)
class Played:
    """What is kept of a plan; one number for each robot where there are several."""

    status: str
    length_m: Numbers  # None without a path
    solo_m: Numbers  # the least on the robot's own graph with nobody about
    gain_m: Numbers  # what it could still gain alone on its graph; None: a path instead of none
    settled: bool  # gains are known
    gains_checked: bool  # the verifier found the same gains on the graphs
    clearance_m: float | None  # the least between two robots; None where no two meet
    broken: tuple[str, ...]  # rules the verifier found broken
    iterations: int
    messages: int
    most_messages: int  # in one iteration, counted from the costs it began and ended with
    rises: int  # iterations after which a robot's cost had risen or its path was lost
    checks: int  # edges and rests that were tested against the others' paths

    @staticmethod
    def read(content: dict[str, Any]) -> "Played":
        """The plan that was kept. Raises `TypeError` for what is none."""
        if set(content) != {item.name for item in fields(Played)}:
            raise TypeError("no plan")
        values: dict[str, Any] = {
            name: tuple(cast("list[Any]", value)) if isinstance(value, list) else value
            for name, value in content.items()
        }
        return Played(**values)

    @property
    def reached(self) -> tuple[bool, ...]:
        """Which robots have a path to their goal."""
        return tuple(length is not None for length in self.length_m)

    @property
    def ratios(self) -> Numbers:
        """Lengths over solo lengths."""
        return tuple(
            None if length is None or not solo else length / solo
            for length, solo in zip(self.length_m, self.solo_m, strict=True)
        )

    @property
    def in_equilibrium(self) -> bool:
        """Whether no robot can do better alone on its graph, a path where it has none included."""
        return self.settled and all(gain is not None and gain <= 1e-9 for gain in self.gain_m)


@dataclass(eq=False)
class Watch:
    """What costs say after each iteration of a planner."""

    costs: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    most: int = 0
    sent: int = 0
    rises: int = 0

    def __call__(self, progress: Progress) -> None:
        """Every path is announced before a round, and each new one in it."""
        now = progress.costs[:, 0]
        before = self.costs if len(self.costs) else np.full(len(now), np.inf)
        new = int((np.isfinite(now) & (now != before)).sum())
        old = int(np.isfinite(before).sum()) if progress.stage != "last answers" else 0
        self.most = max(self.most, old + new)
        self.sent += old + new
        self.rises += bool((now > before).any())
        self.costs = now.copy()


def play(case: Case, effort: Effort) -> Played:
    """What is kept of a case."""
    problem = problem_of(case)
    solver, settings = settings_of(case, effort)
    watch = Watch()
    found = plan(problem, solver, seed=case.trial, settings=settings, on_progress=watch)
    gains = found.epsilon
    # The graphs of ours have twenty times the edges, which to build again takes the verifier long.
    again = case.method in ON_PAPER_GRAPHS and gains is not None and bool(np.isfinite(gains).all())
    graph_settings = asdict(cast("Any", make_solver(solver, settings))) if again else None
    clearance, broken = looked_over(problem, found, graph_settings)
    return Played(
        status=str(found.status),
        length_m=_numbers(found.costs[:, 0]),
        solo_m=_numbers(
            found.solo[:, 0] if found.solo is not None else np.full(case.robots, np.inf)
        ),
        gain_m=_numbers(gains if gains is not None else np.full(case.robots, np.inf)),
        settled=gains is not None,
        gains_checked=again and "equilibrium" not in broken,
        clearance_m=clearance,
        broken=broken,
        iterations=found.counters["iterations"],
        messages=found.counters.get("messages", 0),
        most_messages=watch.most,
        rises=watch.rises,
        checks=found.counters["collision_checks"],
    )


def looked_over(
    problem: PlanningProblem,
    found: PlanningResult,
    graph_settings: Mapping[str, Any] | None = None,
) -> tuple[float | None, tuple[str, ...]]:
    """The least clearance between two robots [m], and the rules that are broken.

    Starts, joints, speeds, arrivals, walls, pairs and tasks, by the functions of `conav verify`,
    which share nothing with the planners; with all settings of the planner also what each robot
    could gain alone on its graph. Robots without a path are not there.
    """
    scene = _scene(problem, found)
    checks = [
        Check(name)
        for name in ("starts", "joints", "speed", "arrivals", "tasks", "walls", "collisions")
    ]
    for check, look in zip(
        checks, (check_starts, check_joints, check_speed, check_arrivals, check_tasks), strict=False
    ):
        look(scene, check)
    check_walls(scene, checks[-2])
    pairs = check_pairs(scene, checks[-1])
    if graph_settings is not None:
        checks.append(Check("equilibrium"))
        check_equilibrium(_run(found, graph_settings), scene, checks[-1])
    least = pairs.low if isfinite(pairs.low) else None
    return least, tuple(check.name for check in checks if check.broken or check.unchecked)


def _scene(problem: PlanningProblem, found: PlanningResult) -> Scene:
    """The plan in the verifier's terms."""
    bodies = tuple(
        Body(
            name=robot.name,
            motion=robot.motion,
            start=robot.start,
            task=robot.task,
            areas={
                name: Area(region.disc, region.polygon) for name, region in robot.regions.items()
            },
            radius=robot.radius_m,
            speed=robot.speed_mps,
            acceleration=robot.acceleration_mps2,
            turning_radius=robot.turning_radius_m,
            stays=robot.after_arrival == "stay",
        )
        for robot in problem.robots
    )
    return Scene(
        walls=np.ascontiguousarray(problem.floor.segments),
        discs=problem.discs,
        area_m2=problem.floor.area,
        horizon=problem.horizon_s,
        margin=problem.margin_m,
        costs=problem.costs,
        bodies=bodies,
        tracks=tuple(
            None if way is None else np.ascontiguousarray(way.pieces) for way in found.trajectories
        ),
    )


def _run(found: PlanningResult, graph_settings: Mapping[str, Any]) -> PlanRun:
    """What the verifier needs of a run to find gains: the rule of edges, gains and vertices.

    It takes the rule from a run of inash; the other methods' graphs have the same.
    """
    return PlanRun(
        path=Path("plan"),
        header={"solver": "inash", "settings": dict(graph_settings)},
        result={"epsilon": None if found.epsilon is None else found.epsilon.tolist()},
        timing={},
        digest="",
        intact=True,
        history=[],
        trajectories=[],
        graphs=dict(enumerate(found.graphs)),
    )


def _numbers(values: NDArray[np.float64]) -> Numbers:
    return tuple(value if isfinite(value) else None for value in values.tolist())
