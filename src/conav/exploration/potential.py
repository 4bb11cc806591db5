"""Exploration by a potential game, turning at obstacles: Algorithm 2 of [Philip2014]."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.exploration.turn_sequences import (
    Draw,
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


@dataclass(frozen=True)
class Potential:
    """Robots go forward, now and then turn to where they would discover most, and at obstacles turn
    to the best side (Algorithm 2).

    The utility of a sequence is (7), counted as (17). Ties: the paper lets the baseline win those
    it is in, which sends robots round in circles once nothing new is near, and most games then
    never end; by default ties are drawn.
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
        if not clear_ahead(view):
            turn = turn_from_obstacle(sequence_gains(memory, view), rng)
        elif explores(view, self.epsilon, rng):
            turn = best_of(sequence_gains(memory, view), self.tie, rng)
        return memory, play(memory, view, turn, self.draw), ()
