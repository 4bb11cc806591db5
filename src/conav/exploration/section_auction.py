"""The auction of sections: sequential, one item at a time, without input or output.

Rules of this file: whether a message is legal is decided by the two tables and the three conditions
beside them, and nowhere else; an illegal message raises `IllegalMessage` and changes nothing. What
the sections are is the caller's business, and so is sending: methods return who gets what.

A free robot joins. The first to join opens an auction period, in which others may join. After it
the auctioneer announces the sections on offer; every bidder bids for the one worth most to it; the
highest bid gets its section, the rest go on with what is then on offer, until all bidders or all
sections are gone. Who joins while that goes on waits for the next auction.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeVar

S = TypeVar("S", bound=StrEnum)
Interval = tuple[int, int]  # first and last strip of a section


class IllegalMessage(ValueError):
    """A message that the protocol does not allow now."""


@dataclass(frozen=True)
class Join:
    """A free robot asks to take part."""

    @property
    def size_bytes(self) -> int:
        """Nothing but the header."""
        return 0


@dataclass(frozen=True)
class Announce:
    """The sections on offer."""

    sections: tuple[Interval, ...]

    @property
    def size_bytes(self) -> int:
        """A count of 4 bytes and 8 per section."""
        return 4 + 8 * len(self.sections)


@dataclass(frozen=True)
class Bid:
    """What a section is worth to a robot: its width less the way to it."""

    section: Interval
    value: float  # [strips]

    @property
    def size_bytes(self) -> int:
        """Section and value, 8 bytes each."""
        return 16


@dataclass(frozen=True)
class Award:
    """A robot gets a section, or is told that there is none."""

    section: Interval | None

    @property
    def size_bytes(self) -> int:
        """A section, 8 bytes; none is an empty one."""
        return 8


class Selling(StrEnum):
    """The states of an auctioneer."""

    CLOSED = "closed"
    OPEN = "open"
    SELLING = "selling"


class Bidding(StrEnum):
    """The states of a bidder."""

    IDLE = "idle"
    WAITING = "waiting"
    BIDDING = "bidding"


AUCTIONEER: dict[tuple[Selling, str], Selling] = {
    (Selling.CLOSED, "join"): Selling.OPEN,
    (Selling.OPEN, "join"): Selling.OPEN,
    (Selling.OPEN, "announce"): Selling.SELLING,
    (Selling.SELLING, "join"): Selling.SELLING,
    (Selling.SELLING, "bid"): Selling.SELLING,
    (Selling.SELLING, "announce"): Selling.SELLING,
    (Selling.SELLING, "close"): Selling.CLOSED,
}
"""(state, event) -> state of an auctioneer; what is not here is illegal."""

BIDDER: dict[tuple[Bidding, str], Bidding] = {
    (Bidding.IDLE, "join"): Bidding.WAITING,
    (Bidding.WAITING, "announce"): Bidding.BIDDING,
    (Bidding.BIDDING, "announce"): Bidding.BIDDING,
    (Bidding.BIDDING, "award"): Bidding.IDLE,
    (Bidding.WAITING, "award"): Bidding.IDLE,
    (Bidding.WAITING, "leave"): Bidding.IDLE,
    (Bidding.BIDDING, "leave"): Bidding.IDLE,
}
"""(state, event) -> state of a bidder; what is not here is illegal."""


@dataclass
class Auctioneer:
    """One robot's part as an auctioneer."""

    state: Selling = Selling.CLOSED
    opened_s: float = 0.0
    bidders: list[int] = field(default_factory=list[int])
    waiting: list[int] = field(default_factory=list[int])  # for the next auction
    sections: tuple[Interval, ...] = ()
    bids: dict[int, Bid] = field(default_factory=dict[int, Bid])

    def join(self, robot: int, time_s: float) -> None:
        """Take a robot among the bidders of this auction, or of the next while this one sells."""
        state = _next(AUCTIONEER, self.state, "join")
        if robot in self.bidders or robot in self.waiting:
            raise IllegalMessage(f"robot {robot} has joined already")
        if self.state is Selling.CLOSED:
            self.opened_s = time_s
        if self.state is Selling.SELLING:
            self.waiting.append(robot)
        else:
            self.bidders.append(robot)
        self.state = state

    def announce(self, sections: Sequence[Interval]) -> Announce:
        """The next announcement, for all bidders."""
        self.state = _next(AUCTIONEER, self.state, "announce")
        self.sections = tuple(sections)
        self.bids = {}
        return Announce(self.sections)

    def bid(self, robot: int, bid: Bid) -> None:
        """Note a bid."""
        state = _next(AUCTIONEER, self.state, "bid")
        if robot not in self.bidders:
            raise IllegalMessage(f"robot {robot} bids and has not joined")
        if robot in self.bids:
            raise IllegalMessage(f"robot {robot} bids twice")
        if bid.section not in self.sections:
            raise IllegalMessage(f"robot {robot} bids for {bid.section}, which is not on offer")
        self.bids[robot] = bid
        self.state = state

    def complete(self) -> bool:
        """Whether every bidder has bid."""
        return self.state is Selling.SELLING and len(self.bids) == len(self.bidders)

    def sell(self) -> tuple[int, Interval]:
        """The winner of the item and its section; ties go to the lower robot.

        It leaves the bidders; those who did not bid are dropped, as they are out of reach. Raises
        `IllegalMessage` when there is no bid.
        """
        if self.state is not Selling.SELLING or not self.bids:
            raise IllegalMessage("nobody has bid")
        winner = min(self.bids, key=lambda robot: (-self.bids[robot].value, robot))
        section = self.bids[winner].section
        self.bidders = [robot for robot in self.bidders if robot in self.bids and robot != winner]
        self.bids = {}
        return winner, section

    def close(self, time_s: float) -> list[int]:
        """Who gets nothing; opens the next auction when robots wait for it."""
        self.state = _next(AUCTIONEER, self.state, "close")
        empty, waiting = self.bidders, self.waiting
        self.bidders, self.waiting, self.sections, self.bids = [], [], (), {}
        for robot in waiting:
            self.join(robot, time_s)
        return empty


@dataclass
class Bidder:
    """One robot's part as a bidder."""

    state: Bidding = Bidding.IDLE
    auctioneer: int = -1
    since_step: int = -1  # the last step it heard of the auction

    def join(self, auctioneer: int, step: int) -> Join:
        """The message to the auctioneer."""
        self.state = _next(BIDDER, self.state, "join")
        self.auctioneer = auctioneer
        self.since_step = step
        return Join()

    def announced(self, sender: int, step: int) -> None:
        """Note that sections are on offer."""
        self._hear(sender, "announce", step)

    def awarded(self, sender: int, step: int) -> None:
        """Note the end of it."""
        self._hear(sender, "award", step)

    def leave(self) -> None:
        """Give up an auction nobody is heard of any more."""
        self.state = _next(BIDDER, self.state, "leave")

    def _hear(self, sender: int, event: str, step: int) -> None:
        state = _next(BIDDER, self.state, event)
        if sender != self.auctioneer:
            raise IllegalMessage(f"robot {sender} is not the auctioneer")
        self.state = state
        self.since_step = step


def best_bid(sections: Sequence[Interval], widths: Sequence[float], strip: int) -> Bid | None:
    """The bid for the section worth most to a robot at `strip`; ties go to the first.

    The utility of a section is its width, the cost the distance to its nearest border; "minimizing
    utility minimize cost" is read as maximising utility minus cost.
    """
    best: Bid | None = None
    for section, width in zip(sections, widths, strict=True):
        cost = min(abs(strip - section[0]), abs(strip - section[1]))
        value = float(width - cost)
        if best is None or value > best.value:
            best = Bid(section, value)
    return best


def _next(table: dict[tuple[S, str], S], state: S, event: str) -> S:
    following = table.get((state, event))
    if following is None:
        raise IllegalMessage(f"{event} is not allowed while {state}")
    return following
