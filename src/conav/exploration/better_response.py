"""Better response by one random sequence: section 2.1.3 of [Philip2014], after Lindsay (2011)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.exploration.turn_sequences import (
    BLOCKED,
    Draw,
    TurnMemory,
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


@dataclass(frozen=True)
class BetterResponse:
    """A robot that may change its action draws one sequence and plays it if it is better.

    The better response of Definition 2.1 with the utility (7) of potential games, as a weakly
    acyclic game is played. It is drawn from the sequences that are not blocked, the baseline among
    them. At an obstacle a robot turns to the best side, as in Algorithm 2: the paper says nothing
    of obstacles here, and so the two differ in nothing but the response.
    """

    epsilon: float = 0.1
    """Probability with which a robot may change its action in a step: the exploration rate."""
    draw: Draw = "step"
    """Draw epsilon every "step" but in mid-turn, or once per two-step "sequence"."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon, draw=self.draw)

    def start(self, view: TeamView, rng: np.random.Generator) -> TurnMemory:
        return TurnMemory()

    def step(
        self,
        memory: TurnMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TurnMemory, Action, Sequence[Message]]:
        if second_step(memory, view):
            return memory, forward(view), ()
        turn = 0
        if not clear_ahead(view):
            turn = turn_from_obstacle(sequence_gains(memory, view), rng)
        elif explores(view, self.epsilon, rng):
            gains = sequence_gains(memory, view)
            possible = np.flatnonzero(gains != BLOCKED)
            tried = int(possible[int(rng.random() * len(possible))])
            turn = tried if gains[tried] > gains[0] else 0
        return memory, play(memory, view, turn, self.draw), ()
