"""The uncoordinated team of [Philip2014] that shares nothing at all."""

from dataclasses import dataclass
from typing import ClassVar

from conav.exploration.uncoordinated import Uncoordinated


@dataclass(frozen=True)
class UncoordinatedAlone(Uncoordinated):
    """Algorithm 2 with an exploration rate of 1 by robots that tell each other nothing.

    Its robots' radios are off, so each knows only what it has seen itself; the team is done when
    its robots together have seen everything, which none of them can tell.
    """

    radio: ClassVar[str] = "off"
    """The radio this strategy is made for; `conav explore` switches to it."""
