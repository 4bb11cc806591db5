"""Any-time prioritized planning, the paper's second method of comparison [Zhu2014].

Graphs grow in iterations. Whenever a robot finds a better path past the robots before it, every
robot after it, in order, must choose its best path anew past those before it, and may lose the one
it had. Paths get better with time for the first robots, but neither for all nor to an equilibrium.
"""

from dataclasses import dataclass

from conav.planning.budget import Budget, OnProgress
from conav.planning.impossible import why_impossible
from conav.planning.lay_guides import lay_guides
from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status


@dataclass(frozen=True)
class AnytimePrioritized(GraphSettings):
    """Prioritized planning that goes on while graphs grow."""

    samples: int | None = 3000  # for each robot; None: until another budget ends
    iterations: int | None = None
    time_s: float | None = None  # [s] of wall time; then runs differ
    batch: int = 200  # samples of each robot in an iteration

    def solve(
        self, problem: PlanningProblem, seed: int = 0, on_progress: OnProgress | None = None
    ) -> PlanningResult:
        """Done when every robot has a path at the end."""
        budget = Budget(self.samples, self.iterations, self.time_s, on_progress)
        team = build_team(problem, self, seed)
        reason = why_impossible(team)
        if reason is not None:
            return team.result(Status.INFEASIBLE, reason)
        lay_guides(team)
        while budget.growing:
            samples = budget.next_batch(self.batch)
            for robot in range(team.size):
                team.grow(robot, samples)
            choose_in_order(team)
            team.note(budget, "choosing")
            team.tell(budget, "choosing")
        missing = [robot for robot in range(team.size) if team.paths[robot] is None]
        status = Status.OUT_OF_BUDGET if missing else Status.DONE
        reason = team.what_is_missing(missing) if missing else ""
        return team.result(status, reason, team.gains(), budget.iteration)


def choose_in_order(team: Team) -> None:
    """One iteration's choices."""
    must_choose = False
    for robot in range(team.size):
        before = team.only(range(robot))
        if must_choose:
            team.drop(robot)
            found = team.best_path(robot, before)
        else:
            found = team.better_path(robot, before)
        if found is None:
            continue
        must_choose = True
        team.adopt(robot, found)
        if team.straighten(robot, before):
            straighter = team.better_path(robot, before)
            if straighter is not None:
                team.adopt(robot, straighter)
        team.count("messages")
