"""The protocol of repeated auctions: what is said, and who may do what when.

A robot whose task has ended says so to its auctioneer, who calls for bids; bidders answer, and are
told what they have won.
"""

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True)
class Ended:
    """A robot tells its auctioneer that its task was completed, delayed or failed."""

    @property
    def size_bytes(self) -> int:
        """Nothing but the header: which tasks are left is in the map both hold."""
        return 0


@dataclass(frozen=True)
class Call:
    """An auctioneer puts up tasks, in the order in which it numbers them."""

    auction: int  # the step it is held in
    tasks: tuple[int, ...]  # planning cells

    @property
    def size_bytes(self) -> int:
        """The auction 4, and 4 per task [bytes]."""
        return 4 + 4 * len(self.tasks)


@dataclass(frozen=True)
class Bids:
    """A robot's path cost to each task from where it stands."""

    auction: int
    costs: tuple[float, ...]  # [planning cells] per task, inf where it cannot get there

    @property
    def size_bytes(self) -> int:
        """The auction 4, and 8 per task [bytes]."""
        return 4 + 8 * len(self.costs)


@dataclass(frozen=True)
class Award:
    """What a robot has won, in the order in which it is to be done."""

    auction: int
    tasks: tuple[int, ...]

    @property
    def size_bytes(self) -> int:
        """The auction 4, and 4 per task [bytes]."""
        return 4 + 4 * len(self.tasks)


NO_CALL = Call(-1, ())
"""Before the first."""


class Bidder(Enum):
    """A robot that has tasks done."""

    AT_WORK = "at work"
    ASKED = "asked for an auction"
    BIDDING = "waits for an award"
    AWARDED = "has got its award"


class Auctioneer(Enum):
    """A robot that holds auctions for those that hear no lower number."""

    READY = "no auction in this step yet"
    OPEN = "waits for bids"
    CLOSED = "has awarded"


BIDDER: dict[tuple[Bidder, type], Bidder] = {
    (Bidder.AT_WORK, Ended): Bidder.ASKED,  # says it
    (Bidder.AT_WORK, Call): Bidder.BIDDING,  # hears it, and answers with Bids
    (Bidder.ASKED, Call): Bidder.BIDDING,
    (Bidder.BIDDING, Award): Bidder.AWARDED,  # hears it, and begins with the first task
}
AUCTIONEER: dict[tuple[Auctioneer, type], Auctioneer] = {
    (Auctioneer.READY, Ended): Auctioneer.OPEN,  # hears it, or its own task ended; says Call
    (Auctioneer.OPEN, Bids): Auctioneer.CLOSED,  # hears them all at once; says Award to each
}
