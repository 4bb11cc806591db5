"""What pursuers say to each other when one is stuck, and how many bytes that takes.

Every body names whose deliberation it is part of, and which round of it (4 bytes each).
"""

from dataclasses import dataclass
from enum import StrEnum

from conav.pursuit.shadow_moves import Point

Segment = tuple[Point, Point]


class Role(StrEnum):
    """What a pursuer does for the team, [Pellier2005] section 3.4."""

    EXPLORER = "explorer"
    GUARD = "guard"
    IDLE = "idle"
    STUCK = "stuck"


@dataclass(frozen=True)
class Request:
    """What a stuck pursuer asks for: that somebody holds these windows from a time on."""

    post: Point  # a place from which they are held [m]
    windows: tuple[Segment, ...]  # [m]
    deadline_s: float  # when the helper must have come


@dataclass(frozen=True)
class Body:
    """A message about one round of one pursuer's deliberation."""

    owner: int  # who is stuck
    round: int

    @property
    def size_bytes(self) -> int:
        return 8


@dataclass(frozen=True)
class AskRole(Body):
    """State 1: what do you do?"""


@dataclass(frozen=True)
class TellRole(Body):
    """The answer: a role (1 byte)."""

    role: Role

    @property
    def size_bytes(self) -> int:
        return 9


@dataclass(frozen=True)
class AskHelp(Body):
    """States 3, 4 and 6: a request; post and deadline (24 bytes), windows (32 each)."""

    request: Request

    @property
    def size_bytes(self) -> int:
        return 32 + 32 * len(self.request.windows)


@dataclass(frozen=True)
class Bid(Body):
    """What help would cost (16 bytes)."""

    distance_m: float
    recontaminated_m2: float

    @property
    def size_bytes(self) -> int:
        return 24


@dataclass(frozen=True)
class Refuse(Body):
    """No help from here."""


@dataclass(frozen=True)
class Award(Body):
    """The acknowledgment: come."""


@dataclass(frozen=True)
class Nack(Body):
    """Somebody else comes, or nobody is needed any more."""


@dataclass(frozen=True)
class EndOfTask(Body):
    """The helper has come: the windows are held."""


@dataclass(frozen=True)
class TaskEnded(Body):
    """An explorer that was counted on is no longer one; owner and round are of who counts."""


@dataclass(frozen=True)
class Lost(Body):
    """A pursuer did not come to the barrier, so what it held may be contaminated (4 bytes)."""

    pursuer: int

    @property
    def size_bytes(self) -> int:
        return 12
