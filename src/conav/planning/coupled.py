"""Plans for two or three robots that have something to do with each other: couplings.

Graphs grow as with every solver here. On the final ones a search through their product
(`conav.planning.joint_search`) finds the least sum of costs of all plans that keep the couplings
(`conav.planning.coupling_rule`). It is exact there, and its labels grow exponentially with the
robots. In each iteration before, a search that minds what remains `haste` times as much looks for a
plan or a better one, around which graphs grow denser.

Robots that have to meet in a region get it into their tasks, F region, which the coupling implies:
so they draw samples there, and know what their ways cost at least.

`done` says that the plan is the optimum of the final graphs, `graph_bound` is its cost. It is no
equilibrium of a game: what a robot may do alone is not free of what it has agreed to.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.best_response import Response
from conav.planning.budget import Budget, OnProgress
from conav.planning.coupling_rule import CouplingRule, coupling_rule
from conav.planning.impossible import why_impossible
from conav.planning.joint_search import JointResult, joint_search
from conav.planning.lay_guides import lay_guides
from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.types import (
    SINGLE_INTEGRATOR,
    PlanningProblem,
    PlanningResult,
    PlanningRobot,
    Region,
)
from conav.status import Status

MOST_ROBOTS = 3


@dataclass(frozen=True)
class Coupled(GraphSettings):
    """The optimum with couplings on sampled graphs of small teams."""

    samples: int | None = 300  # for each robot; None: until another budget ends
    iterations: int | None = None
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 100  # samples of each robot in an iteration
    labels: int = 100_000  # of the search on the final graphs
    hasty_labels: int = 10_000  # of the search in an iteration
    haste: float = 3.0  # how much more what remains counts in that one

    def __post_init__(self) -> None:
        if self.haste < 1.0:
            raise ValueError("haste must be at least 1")

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """Done when the optimum on the final graphs is proved.

        Raises `InputError` for more than three robots, and for robots that do not drive straight.
        """
        _check(problem)
        budget = Budget(self.samples, self.iterations, self.time_s, on_progress)
        rule = coupling_rule(problem)
        uncoupled = build_team(replace(problem, couplings=()), self, seed)
        team = build_team(_with_meetings(problem), self, seed)
        for each in (uncoupled, team):
            reason = why_impossible(each)
            if reason is not None:
                return each.result(Status.INFEASIBLE, reason)
        team.least_lengths = uncoupled.least_lengths  # a bound on plans that need not meet, too
        lay_guides(team)
        known = float("inf")
        hasty = self.haste > 1.0 and len(problem.costs) == 1
        while budget.growing:
            samples = budget.next_batch(self.batch)
            for robot in range(team.size):
                team.grow(robot, samples)
            team.tell(budget, "sampling")
            if hasty and all(team.active(robot) for robot in range(team.size)):
                first = _search(team, rule, self.hasty_labels, known, budget, self.haste)
                known = min([known, *(found.total[0] for found in first.plans)])
        missing = [robot for robot in range(team.size) if not team.active(robot)]
        if missing:
            return team.result(
                Status.OUT_OF_BUDGET, team.what_is_missing(missing), None, budget.iteration
            )
        last = _search(team, rule, self.labels, known, budget, 1.0)
        return _result(team, budget, last)


def _search(
    team: Team, rule: CouplingRule, labels: int, known: float, budget: Budget, weight: float
) -> JointResult:
    """What is found that costs less than what is known; it is the plan from then on."""
    found = joint_search(
        team, range(team.size), labels, known, lambda: budget.out_of_time, rule, weight
    )
    team.count("labels_of_all", found.labels)
    if found.plans:
        _take(team, found.plans[0].paths)
        team.note(budget, "coupled")
        team.tell(budget, "coupled")
    return found


_NO_PLAN = "no plan on these graphs keeps the couplings; raise the samples, if they can be kept"


def _result(team: Team, budget: Budget, last: JointResult) -> PlanningResult:
    planned = all(path is not None for path in team.paths)
    if planned and last.proved:
        status, reason = Status.DONE, ""
    elif last.proved:
        status, reason = Status.OUT_OF_BUDGET, _NO_PLAN
    else:
        status = Status.OUT_OF_BUDGET
        reason = (
            "the labels ended before the optimum on these graphs was proved; raise labels"
            if planned
            else "the labels ended before a plan was found; raise labels"
        )
    result = team.result(status, reason, None, budget.iteration)
    return replace(result, graph_bound=last.bound if np.isfinite(last.bound) else None)


def _check(problem: PlanningProblem) -> None:
    if len(problem.robots) > MOST_ROBOTS:
        raise InputError(
            problem.name, f"has {len(problem.robots)} robots, and coupled plans for "
            f"{MOST_ROBOTS} at most", "leave robots out, or plan without couplings",
        )  # fmt: skip
    for robot in problem.robots:
        if robot.motion != SINGLE_INTEGRATOR:
            raise InputError(
                f"robot {robot.name}", f"coupled plans straight motions, not {robot.motion}",
                f"use the motion {SINGLE_INTEGRATOR}",
            )  # fmt: skip


def _with_meetings(problem: PlanningProblem) -> PlanningProblem:
    """The problem without couplings, the regions of meetings in the tasks of those who meet."""
    robots: list[PlanningRobot] = []
    for robot in problem.robots:
        task, regions = robot.task, dict(robot.regions)
        for number, coupling in enumerate(problem.couplings):
            if coupling.kind == "meet" and robot.name in coupling.robots:
                assert coupling.region is not None
                name = f"meet {number}"
                while name in regions:
                    name += "+"
                regions[name] = Region(name, coupling.region.disc, coupling.region.polygon)
                task = f'({task}) & F "{name}"'
        robots.append(replace(robot, task=task, regions=regions))
    return replace(problem, robots=tuple(robots), couplings=())


def _take(team: Team, paths: Sequence[NDArray[np.int64]]) -> None:
    """Gives robots these paths, by ranks."""
    for robot in range(team.size):
        team.drop(robot)
    for robot, path in enumerate(paths):
        vertices = team.roads_of(robot)[0].arranged.vertices[path]
        team.adopt(robot, Response(vertices, 0.0, 0))
