"""Exploration by a potential game without obstacles: Algorithm 1 of [Philip2014]."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.exploration.turn_sequences import (
    Draw,
    Tie,
    TurnMemory,
    best_of,
    check_settings,
    explores,
    forward,
    play,
    second_step,
    sequence_gains,
)
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class Potential1:
    """Robots go forward, and now and then turn to where they would discover most (Algorithm 1).

    Made for space without obstacles: in front of one a robot keeps on trying to go forward until it
    is its turn to choose, when blocked sequences are left out.
    """

    epsilon: float = 0.1
    """Probability with which a robot may change its action in a step: the exploration rate."""
    tie: Tie = "random"
    """Who wins a tie: "random" or, to the letter of section 2.4, the "baseline"."""
    draw: Draw = "step"
    """Draw epsilon every "step" but in mid-turn, or once per two-step "sequence"."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon, self.tie, self.draw)

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
        if explores(view, self.epsilon, rng):
            turn = best_of(sequence_gains(memory, view), self.tie, rng)
        return memory, play(memory, view, turn, self.draw), ()
