"""Frontier exploration by optimal assignment (Kuhn 1955, the Hungarian method)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from conav.exploration.frontier_targets import Targets
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class Hungarian:
    """Robots are assigned to pieces of frontier so that the paths together are shortest.

    Every robot gets another piece while there are enough; the rest go to the nearest. The
    assignment itself is scipy's.
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
        return team_step(memory, view, inbox, assign_shortest)


def assign_shortest(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
) -> NDArray[np.int64]:
    """The cells of an assignment of shortest total length that leaves out as few as possible."""
    costs = targets.piece_costs()
    # What cannot be reached costs more than everything else together.
    finite = costs[np.isfinite(costs)]
    never = 1.0 + (float(finite.max()) if len(finite) else 0.0) * (len(costs) + 1)
    chosen = linear_sum_assignment(np.where(np.isfinite(costs), costs, never))
    goals = np.full(len(robots), -1, dtype=np.int64)
    for robot, piece in zip(*chosen, strict=True):
        if np.isfinite(costs[robot, piece]):
            goals[robot] = targets.nearest_in(int(robot), int(piece))
    return goals
