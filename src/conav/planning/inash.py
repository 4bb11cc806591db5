"""iNash-trajectory [Zhu2014]: robots that answer each other until nobody can do better alone.

Every iteration each graph grows (Algorithm 2); then the active robots, those whose graph has
a path that does their task when nobody is about, one after the other choose a better path given the
newest of all others, and announce it (Algorithms 1 and 3). Graphs only grow, so nobody's cost ever
rises in this game, and on fixed graphs it ends: the sum of the costs is a potential.

Beyond the paper, each of which a setting takes away: graphs have edges in both directions of
insertion (`mode`), the answer is the best and not the first better one (`response`), new paths are
straightened (`shortcut_tries`), and no robot stays locked out while paths for all are found
(`feasibility`; only then may somebody's path get longer). At the end everybody answers on the final
graphs until nobody improves. That is what `done` and the zeros in `epsilon` say.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from conav.planning.budget import Budget, OnProgress
from conav.planning.draws import Draws
from conav.planning.feasibility import Feasibility
from conav.planning.impossible import why_impossible
from conav.planning.lay_guides import lay_guides
from conav.planning.team import GraphSettings, Team, build_team, robot_seed
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status


@dataclass(frozen=True)
class INash(GraphSettings):
    """An equilibrium on sampled graphs."""

    samples: int | None = 3000  # for each robot; None: until another budget ends
    iterations: int | None = None
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 200  # samples of each robot in an iteration; the paper's is 1
    response: Literal["best", "first"] = "best"  # better response: the best, or the first found
    order: Literal["fixed", "random"] = "fixed"  # of the robots in a round
    feasibility: bool = True  # find paths for all when somebody is locked out
    orders: int = 4  # prioritized orders that one call of it tries
    repairs: int = 50  # of it, times Luby's number of the call

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """What was found when the budget ended, or `on_progress` said False."""
        budget = Budget(self.samples, self.iterations, self.time_s, on_progress)
        team = build_team(problem, self, seed)
        reason = why_impossible(team)
        if reason is not None:
            return team.result(Status.INFEASIBLE, reason)
        lay_guides(team)
        game = _Game(self, team, budget, seed)
        while budget.growing:
            game.iterate(budget.next_batch(self.batch))
        settled = game.last_answers()
        return game.result(settled)


class _Game:
    """One run."""

    def __init__(self, settings: INash, team: Team, budget: Budget, seed: int) -> None:
        self.settings = settings
        self.team = team
        self.budget = budget
        self.draws = Draws(robot_seed(seed, "/order"))
        self.feasibility = Feasibility(
            Draws(robot_seed(seed, "/feasibility")),
            settings.orders,
            settings.repairs,
            settings.batch,
        )

    def iterate(self, samples: int) -> None:
        """Everybody samples; the active play one round; those locked out are helped."""
        team, budget = self.team, self.budget
        for robot in range(team.size):
            if budget.out_of_time:
                return
            team.grow(robot, samples)
        active = [robot for robot in range(team.size) if team.active(robot)]
        self.round(active)
        stage = "game" if active else "sampling"
        if self.settings.feasibility and any(team.paths[robot] is None for robot in active):
            stage = "feasibility"
            if self.feasibility.find(team, active, budget):
                team.note(budget, stage)
                stage = "game"
                self.round(active)
        team.note(budget, stage)
        team.tell(budget, stage)

    def round(self, active: list[int]) -> bool:
        """Whether somebody found a better path, each of the active having been asked once.

        Before it every path is announced, and each new one when it is found: two messages for each
        robot at most.
        """
        team = self.team
        messages = sum(team.paths[robot] is not None for robot in active)
        improved = False
        for robot in self.ordered(active):
            if self.budget.out_of_time:
                break
            if self.answer(robot):
                improved = True
                messages += 1
        assert messages <= 2 * team.size
        team.count("messages", messages)
        team.count("rounds")
        return improved

    def answer(self, robot: int) -> bool:
        """Whether the robot found a better path given all others'."""
        team = self.team
        heed = team.everybody()
        found = team.better_path(robot, heed, first=self.settings.response == "first")
        if found is not None:
            team.adopt(robot, found)
        straighter = team.better_path(robot, heed) if team.straighten(robot, heed) else None
        if straighter is not None:
            team.adopt(robot, straighter)
        return found is not None or straighter is not None

    def ordered(self, robots: list[int]) -> list[int]:
        """The robots in the order of a round."""
        return self.draws.shuffled(robots) if self.settings.order == "random" else robots

    def last_answers(self) -> bool:
        """Whether nobody improves any more on the final graphs, by rounds until that is so."""
        team = self.team
        active = [robot for robot in range(team.size) if team.active(robot)]
        while not self.budget.out_of_time:
            improved = False
            for robot in self.ordered(active):
                if self.budget.out_of_time:
                    return False
                # No new vertices now: on fixed graphs the rounds come to an end.
                found = team.better_path(robot, team.everybody())
                if found is not None:
                    team.adopt(robot, found)
                    improved = True
                    team.count("messages")
            team.count("last_rounds")
            team.note(self.budget, "last answers")
            team.tell(self.budget, "last answers")
            if not improved:
                return True
        return False

    def result(self, settled: bool) -> PlanningResult:
        """The outcome; `settled` when nobody can improve alone."""
        team = self.team
        missing = [robot for robot in range(team.size) if team.paths[robot] is None]
        if not missing and settled:
            status, reason = Status.DONE, ""
        else:
            status, reason = Status.OUT_OF_BUDGET, team.what_is_missing(missing)
        return team.result(
            status,
            reason,
            epsilon=np.zeros(team.size) if settled else None,
            iterations=self.budget.iteration,
        )
