"""Prioritized planning [Erdmann1987]: one after the other, past those before.

Every robot builds its own graph with the whole budget; then, in the order of the problem, each
takes its best path past the paths of the robots before it. Later robots carry all the burden, and
may be left without a path. There is no promise of an equilibrium.
"""

from dataclasses import dataclass

from conav.planning.budget import Budget, OnProgress
from conav.planning.impossible import why_impossible
from conav.planning.lay_guides import lay_guides
from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status

_PASSES = 3.0
"""A robot chooses, chooses again when its path is straight, and says what it could gain."""


@dataclass(eq=False)
class _Choosing:
    """How long everybody's choice will take, where a budget of time asks: known from a rehearsal.

    There is one whenever the graphs have twice the edges they had at the last.
    """

    team: Team
    budget: Budget
    edges: int = 0  # at the last rehearsal
    took_s: float = 0.0

    def rehearse(self) -> None:
        """Everybody chooses with nobody about, if it is time for that."""
        edges = self._all_edges()
        if self.budget.time_s is None or edges < 2 * self.edges:
            return
        left_s = self.budget.left_s
        for robot in range(self.team.size):
            self.team.best_path(robot, self.team.only([]))
        self.edges, self.took_s = edges, left_s - self.budget.left_s

    def expected_s(self) -> float:
        """The time that all choices will take on the graphs as they are."""
        return _PASSES * self.took_s * self._all_edges() / max(self.edges, 1)

    def _all_edges(self) -> int:
        return sum(graph.edges for graph in self.team.graphs)


@dataclass(frozen=True)
class Prioritized(GraphSettings):
    """The standard method the paper compares with."""

    samples: int | None = 3000  # for each robot
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 500  # samples between two looks at the clock

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """Done when every robot has a path."""
        budget = Budget(self.samples, None, self.time_s, on_progress)
        team = build_team(problem, self, seed)
        reason = why_impossible(team)
        if reason is not None:
            return team.result(Status.INFEASIBLE, reason)
        lay_guides(team)
        choosing = _Choosing(team, budget)
        while budget.growing and budget.left_s > choosing.expected_s():
            samples = budget.next_batch(self.batch)
            for robot in range(team.size):
                team.grow(robot, samples)
            choosing.rehearse()
            team.tell(budget, "sampling")
        for robot in range(team.size):
            before = team.only(range(robot))
            found = team.best_path(robot, before)
            if found is not None:
                team.adopt(robot, found)
                if team.straighten(robot, before):
                    straighter = team.better_path(robot, before)
                    if straighter is not None:
                        team.adopt(robot, straighter)
                team.count("messages")
            team.note(budget, "choosing")
        missing = [robot for robot in range(team.size) if team.paths[robot] is None]
        status = Status.OUT_OF_BUDGET if missing else Status.DONE
        reason = team.what_is_missing(missing) if missing else ""
        return team.result(status, reason, team.gains(), budget.iteration)
