"""Frontier exploration by greedy distinct assignment."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_targets import Targets
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class Greedy:
    """The robot and the piece of frontier that are nearest to each other go together, then the
    nearest pair of those left, until every robot or every piece has been given away.

    The simplest coordination: two robots never choose the same. The iterated assignment of BLE
    (Werger and Mataric 2000) and the usual baseline.
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
        return team_step(memory, view, inbox, assign_nearest_pairs)


def assign_nearest_pairs(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
) -> NDArray[np.int64]:
    """The cells of the greedy assignment; ties go to the lower robot, then the lower piece."""
    costs = targets.piece_costs()
    goals = np.full(len(robots), -1, dtype=np.int64)
    for _ in range(min(costs.shape)):
        robot, piece = divmod(int(np.argmin(costs)), costs.shape[1])
        if not np.isfinite(costs[robot, piece]):
            break
        goals[robot] = targets.nearest_in(robot, piece)
        costs[robot, :] = np.inf
        costs[:, piece] = np.inf
    return goals
