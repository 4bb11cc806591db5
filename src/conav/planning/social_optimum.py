"""iOptimalControl: the plan with the least sum of costs on graphs that grow [Zhu2014].

In each iteration every robot's graph grows, and a central solver looks for the social optimum over
all choices of paths. The paper goes through the product of the sets of paths; here it is conflict-
based search (`conav.planning.graph_optimum`), exact too, which ends when the optimum is proved or
its nodes are used up. On the final graphs of a team of `joint_robots` at most, a search through the
product of the graphs follows if need be (`conav.planning.joint_search`).

The plan before is on the grown graphs as well, so no iteration makes the sum greater. When a search
has no answer within its nodes, the plan is what iNash's way gave: paths for all, and answers until
nobody improves. It is then an equilibrium and no proved optimum.

Costs of several components have a set of optima: all sums that none dominates. They are found by
`conav.planning.joint_search`, on the final graphs alone, for small teams. The plan is then the
first of them, in the order of components, and the history has all sums.

`done` says that the optimum on the final graphs is proved, and `graph_bound` is its cost; otherwise
`graph_bound` is what no plan on these graphs is below. Neither is a bound for other graphs. A
social optimum is an equilibrium (Lemma 1), so `epsilon` is zero then.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.best_response import LEAST_GAIN, Response
from conav.planning.budget import Budget, OnProgress
from conav.planning.conflict_search import conflict_based_search
from conav.planning.draws import Draws
from conav.planning.feasibility import Feasibility
from conav.planning.graph_optimum import GraphModel
from conav.planning.impossible import why_impossible
from conav.planning.joint_search import joint_search
from conav.planning.lay_guides import lay_guides
from conav.planning.settle import play_round, settle
from conav.planning.team import GraphSettings, Team, build_team, robot_seed
from conav.planning.types import SINGLE_INTEGRATOR, PlanningProblem, PlanningResult
from conav.status import Status


@dataclass(frozen=True)
class SocialOptimum(GraphSettings):
    """The optimum on sampled graphs."""

    samples: int | None = 500  # for each robot; None: until another budget ends
    iterations: int | None = None
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 100  # samples of each robot in an iteration; the paper's is 1
    nodes: int = 100  # of the search in an iteration
    last_nodes: int = 2000  # of the search on the final graphs
    joint_robots: int = 3  # greatest team whose product is searched
    labels: int = 20_000  # of that search
    orders: int = 4  # prioritized orders that one call for paths for all tries
    repairs: int = 50  # of it, times Luby's number of the call

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """Done when the optimum on the final graphs is proved.

        Raises `InputError` for robots that do not drive straight: branches are for those alone.
        """
        for robot in problem.robots:
            if robot.motion != SINGLE_INTEGRATOR:
                raise InputError(
                    f"robot {robot.name}",
                    f"social-optimum plans straight motions, not {robot.motion}",
                    "use inash, or the motion single-integrator",
                )
        budget = Budget(self.samples, self.iterations, self.time_s, on_progress)
        team = build_team(problem, self, seed)
        reason = why_impossible(team)
        if reason is not None:
            return team.result(Status.INFEASIBLE, reason)
        lay_guides(team)
        feasibility = Feasibility(
            Draws(robot_seed(seed, "/feasibility")), self.orders, self.repairs, self.batch
        )
        scalar = len(problem.costs) == 1
        while budget.growing:
            samples = budget.next_batch(self.batch)
            for robot in range(team.size):
                team.grow(robot, samples)
            active = [robot for robot in range(team.size) if team.active(robot)]
            if not active:
                team.tell(budget, "sampling")
                continue
            play_round(team, active, feasibility, budget)
            if scalar:
                _search(team, active, self.nodes, 0, budget)
            team.note(budget, "social optimum")
            team.tell(budget, "social optimum")
        active = [robot for robot in range(team.size) if team.active(robot)]
        missing = [robot for robot in range(team.size) if robot not in active]
        if missing:
            return team.result(
                Status.OUT_OF_BUDGET, team.what_is_missing(missing), None, budget.iteration
            )
        settled = settle(team, active, budget)
        if scalar:
            labels = self.labels if team.size <= self.joint_robots else 0
            bound, proved = _search(team, active, self.last_nodes, labels, budget)
        else:
            bound, proved = None, _pareto(team, self.labels, budget)
        team.note(budget, "social optimum")
        return _result(team, budget, bound, proved, settled)


def _search(
    team: Team, active: list[int], nodes: int, labels: int, budget: Budget
) -> tuple[float | None, bool]:
    """What no plan of the active robots is below, and whether theirs is the optimum now.

    Infeasibility on the graphs is no bound: None. Labels of 0: no search through the product.
    """
    known = float(team.costs[active, 0].sum())
    model = GraphModel(team, active)
    found = conflict_based_search(model, nodes, known, LEAST_GAIN, lambda: budget.out_of_time)
    team.count("nodes", found.nodes)
    bound, proved = found.lower_bound, found.proved
    if found.paths is not None:
        _take(team, active, [driven.path for driven in found.paths])
    elif not proved and labels:
        joint = joint_search(team, active, labels, known, lambda: budget.out_of_time)
        team.count("labels_of_all", joint.labels)
        bound, proved = max(bound, joint.bound), joint.proved
        if joint.plans:
            _take(team, active, joint.plans[0].paths)
    return (bound, proved) if bound < np.inf else (None, False)


def _take(team: Team, robots: Sequence[int], paths: Sequence[NDArray[np.int64]]) -> None:
    """Gives robots these paths, by ranks."""
    for robot in robots:
        team.drop(robot)
    for robot, path in zip(robots, paths, strict=True):
        vertices = team.roads_of(robot)[0].arranged.vertices[path]
        team.adopt(robot, Response(vertices, 0.0, 0))


def _pareto(team: Team, labels: int, budget: Budget) -> bool:
    """Whether all sums that none dominates were found; the first is the plan then."""
    found = joint_search(team, range(team.size), labels, out_of_time=lambda: budget.out_of_time)
    team.count("labels_of_all", found.labels)
    team.count("optima", len(found.plans))
    if not found.proved or not found.plans:
        return False
    _take(team, range(team.size), found.plans[0].paths)
    for plan in found.plans:
        team.history.append(
            {
                "stage": "optima",
                "iteration": budget.iteration,
                "samples": budget.drawn,
                "costs": team.costs.tolist(),
                "sum": list(plan.total),
            }
        )
    return True


def _result(
    team: Team, budget: Budget, bound: float | None, proved: bool, settled: bool
) -> PlanningResult:
    missing = [robot for robot in range(team.size) if team.paths[robot] is None]
    if proved and not missing:
        status, reason = Status.DONE, ""
    else:
        status = Status.OUT_OF_BUDGET
        reason = _why(team, missing, bound)
    epsilon = np.zeros(team.size) if (proved or settled) and not missing else None
    result = team.result(status, reason, epsilon, budget.iteration)
    return replace(result, graph_bound=bound)


def _why(team: Team, missing: list[int], bound: float | None) -> str:
    """What was not reached, in words."""
    if missing:
        return team.what_is_missing(missing)
    if bound is None:
        return "the labels ended before all optima were found; raise labels"
    total = float(team.costs[:, 0].sum())
    return (
        f"the nodes ended before the optimum on these graphs was proved: the plan costs {total:.6g}"
        f" and none costs less than {bound:.6g}; raise last_nodes"
    )
