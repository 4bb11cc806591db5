"""The best of many equilibria: answers from many starts, on the same graphs.

Which equilibrium a game ends in depends on where it starts and who answers first. Graphs grow as
with iNash; then, on the final ones, the game is played again and again from paths chosen in random
orders, in every other start by random costs, and the equilibrium with the least sum is the plan.
It is one like any other, so nobody can do better alone; the history has the sum of each, which
shows how far apart they lie. That none is better is not said: see `social-optimum`.
"""

from dataclasses import dataclass

import numpy as np

from conav.planning.best_response import LEAST_GAIN
from conav.planning.budget import Budget, OnProgress
from conav.planning.draws import Draws
from conav.planning.feasibility import Feasibility
from conav.planning.impossible import why_impossible
from conav.planning.lay_guides import lay_guides
from conav.planning.settle import choose_in_turn, play_round, settle
from conav.planning.team import GraphSettings, Team, build_team, robot_seed
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status


@dataclass(frozen=True)
class INashRestarts(GraphSettings):
    """The best of several equilibria on sampled graphs."""

    samples: int | None = 3000  # for each robot; None: until another budget ends
    iterations: int | None = None
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 200  # samples of each robot in an iteration
    starts: int = 20  # of the game on the final graphs, beside the one that grew with them
    orders: int = 4  # prioritized orders that one call for paths for all tries
    repairs: int = 50  # of it, times Luby's number of the call

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """Done when the plan is an equilibrium on the final graphs, whatever starts were made."""
        budget = Budget(self.samples, self.iterations, self.time_s, on_progress)
        team = build_team(problem, self, seed)
        reason = why_impossible(team)
        if reason is not None:
            return team.result(Status.INFEASIBLE, reason)
        lay_guides(team)
        feasibility = Feasibility(
            Draws(robot_seed(seed, "/feasibility")), self.orders, self.repairs, self.batch
        )
        while budget.growing:
            samples = budget.next_batch(self.batch)
            for robot in range(team.size):
                team.grow(robot, samples)
            active = [robot for robot in range(team.size) if team.active(robot)]
            play_round(team, active, feasibility, budget)
            team.note(budget, "game")
            team.tell(budget, "game" if active else "sampling")
        settled = settle(team, range(team.size), budget)
        team.note(budget, "last answers")
        missing = [robot for robot in range(team.size) if team.paths[robot] is None]
        if settled and not missing:
            self._restart(team, Draws(robot_seed(seed, "/starts")), budget)
        done = settled and not missing
        return team.result(
            Status.DONE if done else Status.OUT_OF_BUDGET,
            "" if done else team.what_is_missing(missing),
            np.zeros(team.size) if settled else None,
            budget.iteration,
        )

    def _restart(self, team: Team, draws: Draws, budget: Budget) -> None:
        """Plays from other starts, and leaves the team with the best equilibrium."""
        best = [(team.paths[robot], team.costs[robot].copy()) for robot in range(team.size)]
        least = float(team.costs[:, 0].sum())
        for start in range(self.starts):
            order = draws.shuffled(range(team.size))
            if budget.out_of_time:
                break
            if not choose_in_turn(team, order, draws if start % 2 else None):
                continue
            if not settle(team, order, budget):
                break
            team.count("equilibria")
            team.note(budget, "start")
            if float(team.costs[:, 0].sum()) < least - LEAST_GAIN:
                best = [(team.paths[robot], team.costs[robot].copy()) for robot in range(team.size)]
                least = float(team.costs[:, 0].sum())
        for robot, (path, costs) in enumerate(best):
            assert path is not None
            team.put(robot, path, costs)
        team.note(budget, "best start")
