"""A potential game by robots that talk now and then: tight bandwidth.

[Philip2014] closes with a game in which robots do not communicate at every step. Here a robot plays
Algorithm 2 with what it has seen and heard so far and keeps its radio off most of the time. Two
robots hear each other only when both radios are on, so when to switch on must follow from what both
know: the clock, and the places of both when they last heard each other. The second is the idea of
self-triggered coordination [Nowzari2012]: from what was heard follows how long it can serve.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from conav.exploration.potential import Potential
from conav.exploration.turn_sequences import Draw, Tie, TurnMemory, check_settings
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message

_NOBODY = np.empty(0, dtype=np.int32)


@dataclass
class QuietMemory(TurnMemory):
    """The sequence under way, and what the radio waits for."""

    heard: NDArray[np.int32] = field(default_factory=lambda: _NOBODY)  # `heard_step` a step ago
    due: NDArray[np.int32] = field(default_factory=lambda: _NOBODY)
    """The step at which each teammate might be within the radius again, shape (n_robots,)."""
    known: int = 0  # cells known when it last heard somebody
    until: int = 0  # the last step of the talk under way


@dataclass(frozen=True)
class PotentialQuiet:
    """Algorithm 2 of [Philip2014] by robots whose radios are on only at some steps.

    The future work of that paper (section 5). A radio is on at every `every`-th step, and when a
    teammate might be within `within_m`: robots that heard each other at a distance d cannot be
    nearer than the radius before (d - radius) / 2 has been driven by each, and both switch on at
    that step, again and again for as long as they do not hear each other. Through slow radios a
    talk goes on until answers had time to arrive. At other steps, and when it has discovered fewer
    than `news` cells since it last heard somebody, a robot neither sends nor hears; it decides by
    its own map.

    With a perfect radio, straight moves, and a radius of two sensor ranges and two cells nothing is
    missed that could matter for a decision: the run is that of `Potential`, step by step. A robot
    looks at most two cells and a range ahead, and a teammate has seen a range from where it was.
    """

    may_be_quiet: ClassVar[bool] = True

    epsilon: float = 0.1
    """Probability with which a robot may change its action in a step: the exploration rate."""
    tie: Tie = "random"
    """Who wins a tie: "random" or, to the letter of section 2.4, the "baseline"."""
    draw: Draw = "step"
    """Draw epsilon every "step" but in mid-turn, or once per two-step "sequence"."""
    every: int = 10
    """The radio is on at steps that are multiples of this; 0 for never by the clock [steps]."""
    within_m: float = 0.0
    """The radio is on when a teammate might be as near as this; 0 leaves it out [m]."""
    news: int = 0
    """The radio stays off before so many cells were discovered since it last heard somebody."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon, self.tie, self.draw)
        if self.every < 0:
            raise ValueError(f"every is {self.every}; give a number of steps, or 0")
        if not 0.0 <= self.within_m < float("inf"):
            raise ValueError(f"within_m is {self.within_m:g}; give metres, or 0")
        if self.news < 0:
            raise ValueError(f"news is {self.news}; give a number of cells, or 0")
        if self.every == 0 and self.within_m == 0.0:
            raise ValueError("every and within_m are both 0, so the radio would never be on")

    def start(self, view: TeamView, rng: np.random.Generator) -> QuietMemory:
        n = len(view.heard_step)
        return QuietMemory(
            heard=np.full(n, -1, dtype=np.int32),
            due=np.zeros(n, dtype=np.int32),
            until=3 * view.delay_steps,
        )

    def step(
        self,
        memory: QuietMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[QuietMemory, Action, Sequence[Message]]:
        self._hear(memory, view)
        game = Potential(self.epsilon, self.tie, self.draw)
        _, action, said = game.step(memory, view, inbox, rng)
        return memory, action._replace(quiet=not self._talks(memory, view)), said

    def _hear(self, memory: QuietMemory, view: TeamView) -> None:
        """Take note of who was heard since the last step, and where that one was."""
        heard = np.flatnonzero(view.heard_step > memory.heard).tolist()
        memory.heard = view.heard_step.copy()
        heard.remove(view.robot)
        if not heard:
            return
        memory.known = view.belief.known
        cols = view.lattice.cols
        row, col = divmod(view.cell, cols)
        for other in heard:
            r, c = divmod(int(view.heard_cell[other]), cols)
            apart = sqrt((r - row) ** 2 + (c - col) ** 2) - self.within_m / view.lattice.cell_m
            # Each earns a cell of travel in a step at most, so two come nearer by two; what a slow
            # radio brings is where the other was some steps ago.
            age = view.step - int(view.heard_step[other])
            memory.due[other] = view.step + max(ceil((apart - age) / 2), 1)

    def _talks(self, memory: QuietMemory, view: TeamView) -> bool:
        """Whether the radio is on in the next step."""
        step = view.step + 1
        if self._is_time(memory, view, step):
            # Through a slow radio a report, a request and an answer take a delay each.
            memory.until = step + 3 * view.delay_steps
        return step <= memory.until

    def _is_time(self, memory: QuietMemory, view: TeamView, step: int) -> bool:
        if view.belief.known - memory.known < self.news:
            return False
        if self.every > 0 and step % self.every == 0:
            return True
        if self.within_m == 0.0:
            return False
        due = memory.due <= step
        due[view.robot] = False
        return bool(due.any())
