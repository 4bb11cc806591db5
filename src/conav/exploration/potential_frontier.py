"""A potential game while there is something to gain nearby, a frontier when there is not.

[Philip2014] closes with the question whether its game goes together with frontier methods. A robot
plays Algorithm 2, which looks no farther than its sensor reaches from the next two places, and so
drives about blindly where all that is known. Here it then goes to a frontier, chosen by rank as in
[Bautin2012], and plays on from there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from conav.exploration.frontier_targets import find_targets
from conav.exploration.minpos import assign_by_rank
from conav.exploration.nearest import (
    NearestMemory,
    choose_nearest,
    drive_on,
    drive_to,
    keeps_goal,
)
from conav.exploration.team_assignment import Assign
from conav.exploration.turn_sequences import (
    Tie,
    TurnMemory,
    best_of,
    check_settings,
    clear_ahead,
    explores,
    forward,
    play,
    second_step,
    sequence_gains,
    turn_from_obstacle,
)
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message

STALE_STEPS = 64
"""A game in which nobody's discoveries reached the robot for so many steps is over as well."""


@dataclass
class FrontierGameMemory(TurnMemory):
    """The sequence under way in the game, the way to a frontier outside of it."""

    driving: bool = False  # on the way to a frontier, or with nowhere left to go
    drive: NearestMemory = field(default_factory=NearestMemory)
    without: int = 0  # free steps of the game in a row in which no sequence gained anything
    known: int = -1  # cells known when that last changed in this game, -1 at its beginning
    known_since: int = -1  # the step of that
    drives: int = 0  # how often it set out for a frontier


@dataclass(frozen=True)
class PotentialFrontier:
    """Robots play Algorithm 2 of [Philip2014] while it gains something, else go to a frontier.

    The future work of that paper (section 5). In every free step of the game a robot computes the
    gains of its four sequences; if none gains anything for `patience` steps in a row, the game is
    used up. Then it goes to the frontier towards which the fewest teammates are nearer than itself,
    those that are still playing among them, by `assign_by_rank` and for itself alone, so that
    nothing has to be said. Once there, or when the frontier is resolved on the way, the game goes
    on if there is a gain, else it goes to the next.

    A step of the game costs O(sRange^2) whatever the size of the map; only setting out for a
    frontier needs searches, one from each robot it hears.
    """

    assign: ClassVar[Assign] = staticmethod(assign_by_rank)
    """The rule that gives it a frontier: ranks measured best, see benchmarks/frontier_rules.py."""

    epsilon: float = 1.0
    """Probability with which a robot may change its action in a step of the game."""
    patience: int = 1
    """Free steps in a row without a gain after which the game is used up [steps]."""
    tie: Tie = "random"
    """Who wins a tie: "random" or, to the letter of section 2.4, the "baseline"."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon, self.tie)
        if self.patience < 1:
            raise ValueError(f"patience is {self.patience}; give 1 step or more")

    def start(self, view: TeamView, rng: np.random.Generator) -> FrontierGameMemory:
        return FrontierGameMemory()

    def step(
        self,
        memory: FrontierGameMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[FrontierGameMemory, Action, Sequence[Message]]:
        if memory.driving:
            if keeps_goal(memory.drive, view):
                return memory, drive_on(memory.drive), ()
        elif second_step(memory, view):
            return memory, forward(view), ()
        gains = sequence_gains(memory, view)
        if self._used_up(memory, view, int(gains.max())):
            _set_out(memory, view, self.assign)
            return memory, drive_on(memory.drive), ()
        turn = 0
        if not clear_ahead(view):
            turn = turn_from_obstacle(gains, rng)
        elif explores(view, self.epsilon, rng):
            turn = best_of(gains, self.tie, rng)
        return memory, play(memory, view, turn, "step"), ()

    def _used_up(self, memory: FrontierGameMemory, view: TeamView, most: int) -> bool:
        """Whether to leave the game, or after a drive not to enter it."""
        if memory.driving:
            memory.driving = False
            memory.known = -1
            memory.without = 0
            if most <= 0:
                return True
        if memory.known != view.belief.known:
            memory.known = view.belief.known
            memory.known_since = view.step
        memory.without = memory.without + 1 if most <= 0 else 0
        # The baseline may promise for ever what its second step cannot reach, and with a small
        # epsilon a robot may never turn to what is beside its way.
        return memory.without >= self.patience or view.step - memory.known_since >= STALE_STEPS


def _set_out(memory: FrontierGameMemory, view: TeamView, assign: Assign) -> None:
    """Take what the rule gives it among the robots it hears, or the nearest place left."""
    memory.driving = True
    memory.drives += 1
    near = np.flatnonzero(view.in_touch)
    positions = view.heard_cell[near]
    targets = find_targets(view, positions)
    goal = -1
    if len(targets.cells):
        goals = assign(targets, view, near.tolist(), positions)
        goal = int(goals[np.searchsorted(near, view.robot)])
    if not drive_to(memory.drive, view, goal):
        choose_nearest(memory.drive, view)
