"""Frontier exploration by rank of position: MinPos (Bautin, Simonin, Charpillet 2012)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_targets import Targets
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class MinPos:
    """A robot goes to the frontier towards which the fewest others are nearer than itself.

    The rank of a robot towards a frontier is the number of robots strictly nearer to it; among its
    frontiers of lowest rank it takes the nearest. So robots spread in all directions; several go to
    one frontier where each is nearest to no other. The paper computes this in
    every robot for itself from the positions it hears, with wavefronts that start at the frontiers;
    here the robot that computes does it for all, from the same distances.
    """

    def start(self, view: TeamView, rng: np.random.Generator) -> TeamMemory:
        return TeamMemory()

    def step(
        self,
        memory: TeamMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        return team_step(memory, view, inbox, assign_by_rank)


def assign_by_rank(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
) -> NDArray[np.int64]:
    """The nearest of each robot's frontiers of lowest rank; ties go to the lower piece."""
    costs = targets.piece_costs()
    goals = np.full(len(robots), -1, dtype=np.int64)
    for robot, mine in enumerate(costs):
        rank = (costs < mine).sum(axis=0)
        reachable = np.isfinite(mine)
        if not reachable.any():
            continue
        lowest = rank[reachable].min()
        goals[robot] = targets.nearest_in(
            robot, int(np.argmin(np.where(reachable & (rank == lowest), mine, np.inf)))
        )
    return goals
