"""Repeated auctions: auctions by hand, the protocol row by row, and whole runs."""

import pickle
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.exploration.auction_protocol import (
    AUCTIONEER,
    BIDDER,
    Auctioneer,
    Award,
    Bidder,
    Bids,
    Call,
    Ended,
)
from conav.exploration.belief import Belief, new_scratch
from conav.exploration.catalogue import settings_of
from conav.exploration.frontier_targets import Targets
from conav.exploration.repeated_auction import (
    RepeatedAuction,
    task_cells,
)
from conav.exploration.sequential_auction import sequential_auctions
from conav.exploration.types import Action, TeamView
from conav.exploration.verify import verify_exploration
from conav.geometry.directions import STAY
from conav.maps.ascii_art import parse_ascii
from conav.maps.planning_grid import planning_grid
from conav.messages.message import HEADER_BYTES, Message
from conav.robots.radio import radio
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world
from conav.testing import check_strategy

RNG = np.random.default_rng(0)


# --- the auctions, by hand ------------------------------------------------------------------------


def on_a_line(bidders: Sequence[float], tasks: Sequence[float]) -> list[tuple[int, int]]:
    """The awards when bidders and tasks lie on a line."""
    where = np.array(tasks, dtype=float)
    return sequential_auctions(
        np.abs(np.array(bidders, dtype=float)[:, None] - where),
        lambda one, other: abs(float(where[one] - where[other])),
    )


def test_the_task_nearest_to_anybody_is_sold_first() -> None:
    # Bidders at 0 and 10. Lowest costs of the tasks: 4 to 0, 1 to 10, 2 to 0.
    assert on_a_line([0, 10], [4, 9, 2]) == [(1, 1), (2, 0), (0, 0)]


def test_bids_count_from_the_end_of_what_was_won() -> None:
    # Bidder 0 wins -3 (3 against 13), so it bids 7 for 4 and loses against 6; from where it stands
    # it would have bid 4. Bidder 1 ends at 4 then and bids 1 for 5, against 8.
    assert on_a_line([0, 10], [-3, 4, 5]) == [(0, 0), (1, 1), (2, 1)]


def test_ties_go_to_the_lower_task_and_the_lower_bidder() -> None:
    assert on_a_line([0, 2], [1, 1]) == [(0, 0), (1, 0)]


def test_what_nobody_can_reach_is_not_sold() -> None:
    costs = np.array([[inf, 3.0, inf], [inf, inf, 1.0]])

    def between(one: int, other: int) -> float:
        raise AssertionError("nobody competes")

    assert sequential_auctions(costs, between) == [(2, 1), (1, 0)]


@settings(max_examples=200, deadline=None)
@given(
    bidders=st.lists(st.integers(0, 30), min_size=1, max_size=4),
    tasks=st.lists(st.integers(0, 30), max_size=8),
)
def test_awards_are_those_of_plain_auctions(bidders: list[int], tasks: list[int]) -> None:
    """The bids that are not worked out would all have lost."""
    ends = list(bidders)
    expected: list[tuple[int, int]] = []
    order = sorted(range(len(tasks)), key=lambda t: (min(abs(b - tasks[t]) for b in bidders), t))
    for task in order:
        bids = [abs(end - tasks[task]) for end in ends]
        winner = bids.index(min(bids))
        ends[winner] = tasks[task]
        expected.append((task, winner))
    assert on_a_line(bidders, tasks) == expected


def test_task_of_a_piece_is_its_cell_nearest_to_a_robot() -> None:
    targets = Targets(
        cells=np.array([3, 4, 8, 9, 12]),
        piece=np.array([0, 0, 1, 1, 2]),
        n_pieces=3,
        costs=np.array([[5.0, 4.0, 7.0, 7.0, inf], [6.0, 6.0, 9.0, 7.0, inf]]),
    )
    nearest = targets.costs.min(axis=0)
    assert task_cells(targets.cells, targets.piece, 3, nearest).tolist() == [4, 8]


# --- the protocol ---------------------------------------------------------------------------------


def test_tables_lead_from_the_head_to_the_end_and_nowhere_back() -> None:
    for table in (BIDDER, AUCTIONEER):
        rank = {state: number for number, state in enumerate(type(next(iter(table))[0]))}
        assert all(rank[after] > rank[before] for (before, _), after in table.items())


def test_sizes() -> None:
    assert Ended().size_bytes == 0
    assert Call(3, (5, 6, 7)).size_bytes == 4 + 3 * 4
    assert Bids(3, (1.0, 2.0, inf)).size_bytes == 4 + 3 * 8
    assert Award(3, (5, 6)).size_bytes == 4 + 2 * 4
    assert Message(0, 1, 0.0, Call(3, (5,))).size_bytes == HEADER_BYTES + 8


def corridor(robot: int, cell: int, *, heard: dict[int, int], step: int = 7) -> TeamView:
    """A view of a corridor of 20 cells of which 5 to 14 are known; targets are 5 and 14."""
    grid = parse_ascii("." * 20)
    plan = planning_grid(grid)
    belief = Belief(plan)
    scratch = new_scratch(plan)
    for place in (8, 9, 10, 11):
        belief.hear(plan, place, np.arange(5, 15, dtype=np.int32), scratch)
    cells = np.full(4, -1, np.int32)
    steps = np.full(4, -1, np.int32)
    for other, place in {**heard, robot: cell}.items():
        cells[other], steps[other] = place, step
    body = Robot(f"robot_{robot}", sensor=Sensor("any", True, 3.0), radio=radio("limited", 9.0))
    return TeamView(
        step, float(step), robot, body, cell, 0, belief, plan.lattice, cells, steps, steps == step
    )


class Mind:
    """A robot's mind, driven by hand."""

    def __init__(self, view: TeamView, wait: float = 0.0) -> None:
        self.strategy = RepeatedAuction(wait)
        self.view = view
        self.memory = self.strategy.start(view, RNG)
        self.action = Action()

    def step(self, *inbox: tuple[int, Any]) -> list[tuple[int, Any]]:
        """What it says to whom, given bodies and their senders."""
        robot = self.view.robot
        messages = [Message(sender, robot, 0.0, body) for sender, body in inbox]
        self.memory, self.action, said = self.strategy.step(self.memory, self.view, messages, RNG)
        assert all(message.sender == robot for message in said)
        return [(message.receiver, message.body) for message in said]

    def state(self) -> bytes:
        """All it remembers, and what it does."""
        return pickle.dumps((self.memory, self.action))


def test_an_auction_message_by_message() -> None:
    """Robots 0 and 1 stand at 8 and 9; tasks are cells 5 and 14, costs 3, 6 and 4, 5."""
    first = Mind(corridor(0, 8, heard={1: 9}))
    second = Mind(corridor(1, 9, heard={0: 8}))
    assert first.step() == [(1, Call(7, (5, 14)))]
    assert second.step() == [(0, Ended())]
    assert second.step((0, Call(7, (5, 14)))) == [(0, Bids(7, (4.0, 5.0)))]
    assert first.step((1, Bids(7, (4.0, 5.0)))) == [(1, Award(7, (14,)))]
    assert (first.memory.tasks, first.action) == ((5,), Action(2, 5))
    assert second.step((0, Award(7, (14,)))) == []
    assert (second.memory.tasks, second.action) == ((14,), Action(0, 14))


def test_alone_it_auctions_to_itself() -> None:
    mind = Mind(corridor(2, 11, heard={}), wait=5.0)
    assert mind.step() == []
    assert mind.memory.tasks == (14, 5)
    assert mind.action == Action(0, 14)


def test_bidders_stand_still_for_the_auction() -> None:
    second = Mind(corridor(1, 9, heard={0: 8}), wait=2.0)
    second.step()
    second.step((0, Call(7, (5, 14))))
    second.step((0, Award(7, (14,))))
    for step in (7, 8):
        second.view = second.view._replace(step=step, time_s=float(step))
        assert second.step() == []
        assert second.action == Action(STAY, 14)
    second.view = second.view._replace(step=9, time_s=9.0)
    assert second.step() == []
    assert second.action == Action(0, 14)


def test_a_move_under_way_is_finished_before_the_wait() -> None:
    """A robot that takes longer than a step to the next cell gets there although others auction."""
    second = Mind(corridor(1, 9, heard={0: 8}), wait=2.0)
    second.step()
    second.step((0, Call(7, (5, 14))))
    second.step((0, Award(7, (14,))))
    second.view = second.view._replace(step=9, time_s=9.0)  # the wait is over
    second.step()
    assert second.action == Action(0, 14)
    # It has not arrived when there is another auction.
    heard = np.where(second.view.heard_step >= 0, 10, -1).astype(np.int32)
    second.view = second.view._replace(step=10, time_s=10.0, heard_step=heard)
    second.step()
    second.step((0, Call(10, (5, 14))))
    second.step((0, Award(10, (14,))))
    assert second.action == Action(0, 14)
    # Once there it stands still, until two seconds after the auction.
    second.view = second.view._replace(step=11, time_s=11.0, cell=10)
    second.step()
    assert second.action == Action(STAY, 14)
    second.view = second.view._replace(step=12, time_s=12.0)
    second.step()
    assert second.action == Action(0, 14)


def test_who_wins_nothing_waits_until_it_loses_the_others() -> None:
    second = Mind(corridor(1, 9, heard={0: 8}))
    second.step()
    second.step((0, Call(7, (5, 14))))
    second.step((0, Award(7, ())))
    assert second.action == Action(STAY)
    second.view = corridor(1, 9, heard={0: 7}, step=8)
    assert second.step() == []
    assert second.action == Action(STAY)
    second.view = corridor(1, 9, heard={}, step=9)
    second.step()
    assert second.memory.tasks == (5, 14)


def bidder_in(state: Bidder) -> Mind:
    """Robot 1 in a state, its auctioneer being robot 0."""
    mind = Mind(corridor(1, 9, heard={0: 8, 2: 10}))
    mind.step()
    if state in (Bidder.BIDDING, Bidder.AWARDED):
        mind.step((0, Call(7, (5, 14))))
    if state is Bidder.AWARDED:
        mind.step((0, Award(7, (14,))))
    if state is Bidder.AT_WORK:
        mind.step((0, Call(7, (5, 14))))
        mind.step((0, Award(7, (14,))))
        mind.view = mind.view._replace(step=8, time_s=8.0, heard_step=mind.view.heard_step + 1)
        mind.step()
    assert mind.memory.bidder is state
    return mind


@pytest.mark.parametrize(
    ("state", "sender", "body"),
    [
        (Bidder.AT_WORK, 0, Award(8, (14,))),  # nobody has bid
        (Bidder.AT_WORK, 0, Award(7, (5,))),  # of the auction before
        (Bidder.AT_WORK, 0, Call(7, (5, 14))),  # late
        (Bidder.AT_WORK, 2, Call(8, (5, 14))),  # not its auctioneer
        (Bidder.AT_WORK, 0, Call(8, (5, 999))),  # no such place
        (Bidder.AT_WORK, 0, Call(8, (-1,))),
        (Bidder.ASKED, 0, Award(7, (14,))),
        (Bidder.ASKED, 0, Call(6, (5, 14))),
        (Bidder.ASKED, 2, Call(7, (5, 14))),
        (Bidder.BIDDING, 0, Call(7, (5, 14))),  # a second one
        (Bidder.BIDDING, 2, Award(7, (14,))),
        (Bidder.BIDDING, 0, Award(6, (14,))),
        (Bidder.BIDDING, 0, Award(7, (6,))),  # was not put up
        (Bidder.AWARDED, 0, Award(7, (5,))),
        (Bidder.AWARDED, 0, Call(7, (5, 14))),
        (Bidder.AWARDED, 0, Bids(7, (1.0, 1.0))),  # it called nobody
    ],
)
def test_what_a_bidder_must_not_be_told_changes_nothing(
    state: Bidder, sender: int, body: Any
) -> None:
    mind = bidder_in(state)
    before = mind.state()
    assert mind.step((sender, body)) == []
    assert mind.state() == before


def auctioneer_in(state: Auctioneer) -> Mind:
    """Robot 0 in a state, with robots 1 and 2 in reach."""
    mind = Mind(corridor(0, 8, heard={1: 9, 2: 10}))
    mind.step()
    if state in (Auctioneer.CLOSED, Auctioneer.READY):
        mind.step((1, Bids(7, (4.0, 5.0))), (2, Bids(7, (5.0, 4.0))))
    if state is Auctioneer.READY:
        mind.view = mind.view._replace(step=8, time_s=8.0, heard_step=mind.view.heard_step + 1)
        mind.step()
    assert mind.memory.auctioneer is state
    return mind


@pytest.mark.parametrize(
    ("state", "body"),
    [
        (Auctioneer.READY, Bids(8, (1.0, 1.0))),
        (Auctioneer.READY, Bids(7, (1.0, 1.0))),  # of the auction before
        (Auctioneer.READY, Award(7, (5,))),
        (Auctioneer.READY, Call(8, (5,))),  # it hears nobody lower
        (Auctioneer.OPEN, Ended()),  # its tasks are being put up already
        (Auctioneer.OPEN, Bids(6, (1.0, 1.0))),
        (Auctioneer.OPEN, Bids(7, (1.0,))),  # not for every task
        (Auctioneer.OPEN, Bids(7, (1.0, float("nan")))),
        (Auctioneer.OPEN, Bids(7, (1.0, -1.0))),
        (Auctioneer.CLOSED, Bids(7, (1.0, 1.0))),  # late
        (Auctioneer.CLOSED, Ended()),
    ],
)
def test_what_an_auctioneer_must_not_be_told_changes_nothing(state: Auctioneer, body: Any) -> None:
    mind = auctioneer_in(state)
    before = mind.state()
    assert mind.step((1, body)) == []
    assert mind.state() == before


def test_an_ended_task_opens_an_auction_of_all_tasks() -> None:
    mind = auctioneer_in(Auctioneer.READY)
    assert mind.memory.tasks == (5,)  # which it is busy with: it did not ask itself
    call = Call(8, (5, 14))
    assert mind.step((1, Ended()), (2, Ended())) == [(1, call), (2, call)]


def test_tasks_are_put_up_again_when_one_is_completed() -> None:
    mind = auctioneer_in(Auctioneer.CLOSED)
    cells = np.arange(3, 6, dtype=np.int32)
    plan = planning_grid(parse_ascii("." * 20))
    mind.view.belief.hear(plan, 8, cells, new_scratch(plan))
    mind.view = mind.view._replace(step=8, time_s=8.0, heard_step=mind.view.heard_step + 1)
    call = Call(8, (3, 14))  # 5 has been seen; behind it lies 3
    assert mind.step() == [(1, call), (2, call)]


# --- whole runs -----------------------------------------------------------------------------------


def world(strategy: RepeatedAuction, **problem: Any) -> WorldState:
    made, _ = exploration_problem("office", **problem)
    return new_world(
        made, strategy, observable_cells(made.plan, made.starts, made.robots[0].sensor)
    )


def test_no_more_than_five_rounds_in_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine may ask 32 times; a protocol that needs more would be cut off."""
    asked: dict[tuple[int, int], int] = {}
    honest = RepeatedAuction.step

    def counting(self: RepeatedAuction, memory: Any, view: TeamView, *rest: Any) -> Any:
        key = (view.step, view.robot)
        asked[key] = asked.get(key, 0) + 1
        return honest(self, memory, view, *rest)

    monkeypatch.setattr(RepeatedAuction, "step", counting)
    state = world(RepeatedAuction(), robots=4, seed=3, radio=6.0)
    engine = engine_for(state)
    sizes: dict[str, int] = {}
    for _ in range(150):
        events = engine.sense_and_decide(state, [])
        for message in events.said:
            kind = type(message.body).__name__
            sizes[kind] = sizes.get(kind, 0) + 1
        engine.move(state, events.actions)
        assert not state.in_flight
    assert max(asked.values()) <= 5
    assert set(sizes) == {"Ended", "Call", "Bids", "Award"}
    assert sizes["Bids"] == sizes["Award"] <= sizes["Call"]


def test_no_two_robots_of_a_group_drive_to_one_task() -> None:
    state = world(RepeatedAuction(), robots=4, seed=1)
    engine = engine_for(state)
    for _ in range(150):
        events = engine.sense_and_decide(state, [])
        if any(isinstance(message.body, Award) for message in events.said):
            goals = [memory.tasks[0] for memory in state.memories if memory.tasks]
            assert len(set(goals)) == len(goals)
        engine.move(state, events.actions)


@pytest.mark.parametrize("motion", ["8-connected", "4-connected", "forward-turn"])
def test_passes_the_checks_of_any_strategy(motion: str) -> None:
    check_strategy(RepeatedAuction(auction_wait_s=3.0), motion=motion)


# [m] Coarser than by default: a quarter of the cells to verify.
_COARSE = {"maze": 0.2, "cave": 0.2, "office": 0.2}


@pytest.mark.parametrize(
    ("name", "robots", "reach"),
    [("three-obstacles", 1, None), ("maze", 4, None), ("cave", 3, 6.0), ("office", 2, 6.0)],
)
def test_finishes_and_is_accepted(
    name: str, robots: int, reach: float | None, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(
        name,
        strategy=RepeatedAuction(),
        robots=robots,
        seed=robots % 2,
        radio=reach,
        resolution=_COARSE.get(name),
        out=path,
    )
    assert done.status == "done"
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


def test_waiting_for_auctions_costs_time() -> None:
    times = [
        conav.explore(
            "three-obstacles", strategy=RepeatedAuction(auction_wait_s=wait), robots=2, seed=0
        ).metrics.t100_s
        for wait in (0.0, 5.0)
    ]
    assert None not in times
    assert times[1] > 1.5 * times[0]  # type: ignore[operator]


def test_settings_are_checked() -> None:
    assert settings_of(RepeatedAuction()) == {"auction_wait_s": 0.0, "give_up_s": 60.0}
    for bad in (-1.0, inf, float("nan")):
        with pytest.raises(ValueError, match="give 0 or more"):
            RepeatedAuction(bad)
    for bad in (0.0, -1.0, inf, float("nan")):
        with pytest.raises(ValueError, match="give more than 0"):
            RepeatedAuction(give_up_s=bad)
