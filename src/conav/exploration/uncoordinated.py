"""The uncoordinated team of [Philip2014] with a shared map: every robot decides at every step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.exploration.potential import Potential
from conav.exploration.turn_sequences import Tie, TurnMemory, check_settings
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class Uncoordinated:
    """Algorithm 2 with an exploration rate of 1, as section 2.4 defines uncoordinated robots.

    The paper does not say whether they know of each other's discoveries. Here they do, as the
    definition changes nothing but epsilon; `uncoordinated-alone` is the other reading.
    """

    tie: Tie = "random"
    """Who wins a tie: "random" or, to the letter of section 2.4, the "baseline"."""

    def __post_init__(self) -> None:
        check_settings(1.0, self.tie)

    def start(self, view: TeamView, rng: np.random.Generator) -> TurnMemory:
        return TurnMemory()

    def step(
        self,
        memory: TurnMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TurnMemory, Action, Sequence[Message]]:
        return Potential(epsilon=1.0, tie=self.tie).step(memory, view, inbox, rng)
