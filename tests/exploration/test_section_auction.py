"""The auction, message by message, without robots or radio."""

import pickle
from collections.abc import Callable

import pytest

from conav.exploration.section_auction import (
    AUCTIONEER,
    BIDDER,
    Announce,
    Auctioneer,
    Award,
    Bid,
    Bidder,
    Bidding,
    IllegalMessage,
    Join,
    Selling,
    best_bid,
)

A, B = (0, 29), (50, 99)


def selling(*robots: int) -> Auctioneer:
    auctioneer = Auctioneer()
    for robot in robots:
        auctioneer.join(robot, 0.0)
    auctioneer.announce([A, B])
    return auctioneer


def test_utility_is_width_and_cost_is_the_way_to_the_nearest_border() -> None:
    # From strip 40: 30 wide and 11 away, 50 wide and 10 away.
    assert best_bid([A, B], [30, 50], 40) == Bid(B, 40.0)
    assert best_bid([A], [30], 40) == Bid(A, 19.0)
    # Far from the wide one the near one is worth more.
    assert best_bid([A, B], [30, 31], 30) == Bid(A, 29.0)
    assert best_bid([(0, 9), (20, 29)], [10, 10], 15) == Bid((20, 29), 5.0)
    assert best_bid([(0, 9), (21, 30)], [10, 10], 15) == Bid((0, 9), 4.0)  # a tie
    assert best_bid([], [], 3) is None


def test_an_auction_of_two_sections_among_three_robots() -> None:
    auctioneer = Auctioneer()
    for robot in (5, 2, 7):
        auctioneer.join(robot, 10.0)
    assert auctioneer.opened_s == 10.0
    assert auctioneer.announce([A, B]) == Announce((A, B))
    auctioneer.bid(2, Bid(B, 40.0))
    auctioneer.bid(7, Bid(A, 12.0))
    assert not auctioneer.complete()
    auctioneer.bid(5, Bid(B, 40.0))
    assert auctioneer.complete()
    assert auctioneer.sell() == (2, B)  # as much as robot 5 bids, and lower
    auctioneer.announce([A])
    auctioneer.bid(7, Bid(A, 12.0))
    auctioneer.join(3, 11.0)  # too late for this one
    auctioneer.bid(5, Bid(A, 13.0))
    assert auctioneer.sell() == (5, A)
    auctioneer.announce([])
    assert auctioneer.close(12.0) == [7]
    assert (auctioneer.state, auctioneer.bidders, auctioneer.opened_s) == (Selling.OPEN, [3], 12.0)


def test_who_does_not_bid_is_dropped() -> None:
    auctioneer = selling(0, 1, 2)
    auctioneer.bid(1, Bid(A, 3.0))
    auctioneer.bid(0, Bid(A, 2.0))
    assert auctioneer.sell() == (1, A)
    assert auctioneer.bidders == [0]


@pytest.mark.parametrize(
    ("auctioneer", "act"),
    [
        (Auctioneer(), lambda a: a.bid(1, Bid(A, 1.0))),
        (Auctioneer(), lambda a: a.announce([A])),
        (Auctioneer(), lambda a: a.sell()),
        (Auctioneer(), lambda a: a.close(0.0)),
        (selling(1), lambda a: a.join(1, 0.0)),
        (selling(1), lambda a: a.bid(2, Bid(A, 1.0))),
        (selling(1), lambda a: a.bid(1, Bid((1, 2), 1.0))),
        (selling(1), lambda a: a.sell()),
    ],
)
def test_an_illegal_message_changes_nothing(
    auctioneer: Auctioneer, act: Callable[[Auctioneer], object]
) -> None:
    before = pickle.dumps(auctioneer)
    with pytest.raises(IllegalMessage):
        act(auctioneer)
    assert pickle.dumps(auctioneer) == before


def test_nobody_bids_twice() -> None:
    auctioneer = selling(1, 2)
    auctioneer.bid(1, Bid(A, 1.0))
    before = pickle.dumps(auctioneer)
    with pytest.raises(IllegalMessage, match="twice"):
        auctioneer.bid(1, Bid(B, 2.0))
    assert pickle.dumps(auctioneer) == before


def test_every_row_of_the_auctioneer_s_table() -> None:
    """Each event in each state does what the table says, and nothing where it says nothing."""
    acts: dict[str, Callable[[Auctioneer], object]] = {
        "join": lambda a: a.join(9, 0.0),
        "announce": lambda a: a.announce([A]),
        "bid": lambda a: a.bid(1, Bid(A, 1.0)),
        "close": lambda a: a.close(0.0),
    }
    assert {event for _, event in AUCTIONEER} == set(acts)
    for state in Selling:
        for event, act in acts.items():
            auctioneer = Auctioneer()
            if state is not Selling.CLOSED:
                auctioneer.join(1, 0.0)
            if state is Selling.SELLING:
                auctioneer.announce([A])
            assert auctioneer.state is state
            then = AUCTIONEER.get((state, event))
            if then is None:
                before = pickle.dumps(auctioneer)
                with pytest.raises(IllegalMessage):
                    act(auctioneer)
                assert pickle.dumps(auctioneer) == before
            else:
                act(auctioneer)
                assert auctioneer.state is then


def test_every_row_of_the_bidder_s_table() -> None:
    acts: dict[str, Callable[[Bidder], object]] = {
        "join": lambda b: b.join(4, 8),
        "announce": lambda b: b.announced(4, 9),
        "award": lambda b: b.awarded(4, 9),
        "leave": lambda b: b.leave(),
    }
    assert {event for _, event in BIDDER} == set(acts)
    for state in Bidding:
        for event, act in acts.items():
            bidder = Bidder()
            if state is not Bidding.IDLE:
                bidder.join(4, 8)
            if state is Bidding.BIDDING:
                bidder.announced(4, 8)
            assert bidder.state is state
            then = BIDDER.get((state, event))
            if then is None:
                before = pickle.dumps(bidder)
                with pytest.raises(IllegalMessage):
                    act(bidder)
                assert pickle.dumps(bidder) == before
            else:
                act(bidder)
                assert bidder.state is then


def test_a_bidder_listens_to_its_auctioneer_only() -> None:
    bidder = Bidder()
    bidder.join(4, 8)
    before = pickle.dumps(bidder)
    with pytest.raises(IllegalMessage, match="not the auctioneer"):
        bidder.awarded(3, 9)
    assert pickle.dumps(bidder) == before


def test_messages_have_defined_sizes() -> None:
    assert Join().size_bytes == 0
    assert Announce((A, B)).size_bytes == 4 + 16
    assert Bid(A, 1.0).size_bytes == 16
    assert Award(A).size_bytes == Award(None).size_bytes == 8
