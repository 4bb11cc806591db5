"""iNash-trajectory [Zhu2014]: an equilibrium of robots that each answer the others."""

from dataclasses import dataclass

import numpy as np

from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status


@dataclass(frozen=True)
class INash(GraphSettings):
    samples: int = 3000
    batch: int = 200

    def solve(self, problem: PlanningProblem, seed: int = 0) -> PlanningResult:
        team = build_team(problem, self, seed)
        drawn = 0
        while drawn < self.samples:
            for robot in range(team.size):
                team.grow(robot, self.batch)
            drawn += self.batch
            round_of_responses(team)
        while round_of_responses(team):
            pass
        found = all(path is not None for path in team.paths)
        eps = np.array([0.0 if path is not None else np.inf for path in team.paths])
        solo = np.array([[team.roads_of(i).alone] for i in range(team.size)])
        return team.result(
            Status.DONE if found else Status.OUT_OF_BUDGET,
            "",
            epsilon=eps,
            solo=solo,
            lower_bound=None,
        )


def round_of_responses(team: Team) -> bool:
    improved = False
    for robot in range(team.size):
        if not team.active(robot):
            continue
        response = team.response(robot, team.everybody())
        if response is not None:
            team.adopt(robot, response)
            improved = True
            if team.straighten(robot, team.everybody()):
                response = team.response(robot, team.everybody())
                if response is not None:
                    team.adopt(robot, response)
    return improved
