"""Decision-theoretic coordination: Burgard, Moors, Stachniss, Schneider (T-RO 2005)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_targets import Targets
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.exploration.utility_reduction import Seen, assign_by_utility
from conav.messages.message import Message


@dataclass
class DecisionMemory(TeamMemory):
    """The drive under way, and where teammates were last sent."""

    sent: dict[int, int] = field(default_factory=dict[int, int])  # robot -> planning cell


@dataclass(frozen=True)
class DecisionTheoretic:
    """Robots go where utility less cost is highest; a target given away makes its surroundings
    less useful, by P(d) = 1 - d / range within the sensor's range.

    Costs are path lengths in sensor ranges, so beta means the same on every map. Robots that hear
    each other make a team of their own; the last targets of teammates that are not heard any more
    go on making what is near them less useful, as far as the robot that assigns had sent them there
    itself, and for `silence_s`: who is silent for longer may be broken.
    """

    beta: float = 1.0
    """Weight of the cost of reaching a target against its utility."""
    silence_s: float = 120.0
    """The target of a robot not heard for longer than this is nobody's [s]."""

    def __post_init__(self) -> None:
        check_beta(self.beta)
        if not 0.0 <= self.silence_s < float("inf"):
            raise ValueError(f"silence_s is {self.silence_s:g}; give 0 or more")

    def start(self, view: TeamView, rng: np.random.Generator) -> DecisionMemory:
        return DecisionMemory()

    def step(
        self,
        memory: DecisionMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        return team_step(memory, view, inbox, partial(self._assign, memory))

    def _assign(
        self,
        memory: DecisionMemory,
        targets: Targets,
        view: TeamView,
        robots: Sequence[int],
        positions: NDArray[np.int32],
    ) -> NDArray[np.int64]:
        reach = max(view.body.sensor.range_m / view.lattice.cell_m, 1.0)
        limit = self.silence_s * view.step / view.time_s if view.step else 0.0
        lost = [
            cell
            for robot, cell in memory.sent.items()
            if robot not in robots
            and cell >= 0
            and view.step - int(view.heard_step[robot]) <= limit
        ]
        goals = assign_by_utility(
            targets,
            targets.costs / reach,
            self.beta,
            view.lattice.cols,
            Seen(reach, np.ones(1), slope=1.0),
            np.array(lost, dtype=np.int64),
        )
        memory.sent.update(zip(robots, goals.tolist(), strict=True))
        return goals


def check_beta(beta: float) -> None:
    """Raise `ValueError` unless it weighs a cost."""
    if not 0.0 <= beta <= 1e6:
        raise ValueError(f"beta is {beta:g}; give 0 to 1e6")
