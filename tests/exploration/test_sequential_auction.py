"""Path costs between tasks: what is found without a search is what a search finds."""

from collections.abc import Callable
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.exploration.belief import Belief, new_scratch
from conav.exploration.sequential_auction import TaskPaths, goes_straight, sequential_auctions
from conav.geometry.grid_search import search, search_space
from conav.maps.ascii_art import parse_ascii
from conav.maps.planning_grid import planning_grid

SIDE = 9


def belief_of(rows: list[str], *, diagonal: bool) -> Belief:
    """A belief that knows all of a map."""
    plan = planning_grid(parse_ascii("\n".join(rows)), radius_m=0.1, diagonal=diagonal)
    belief = Belief(plan)
    belief.hear(plan, 0, np.arange(plan.walls.size, dtype=np.int32), new_scratch(plan))
    return belief


def searched(belief: Belief, start: int, goal: int) -> float:
    wanted = np.zeros_like(belief.marks)
    wanted.reshape(-1)[goal] = 1
    space = search_space(belief.moves.size)
    found = search(belief.moves, start, wanted, 1, space)
    return float(space.distance[found]) if found >= 0 else inf


@settings(max_examples=150, deadline=None)
@given(
    walls=st.sets(st.integers(0, SIDE * SIDE - 1), max_size=25),
    diagonal=st.booleans(),
    start=st.integers(0, SIDE * SIDE - 1),
    goal=st.integers(0, SIDE * SIDE - 1),
)
def test_path_costs_are_those_of_a_search(
    walls: set[int], diagonal: bool, start: int, goal: int
) -> None:
    walls = walls - {start, goal}
    rows = [
        "".join("#" if row * SIDE + col in walls else "." for col in range(SIDE))
        for row in reversed(range(SIDE))  # the last line is row 0
    ]
    belief = belief_of(rows, diagonal=diagonal)
    paths = TaskPaths(belief, (start, goal))
    expected = searched(belief, start, goal)
    assert paths.between(0, 1) == expected
    assert paths.least[0, 1] <= expected


def test_straight_ways_by_hand() -> None:
    """On the empty grid every pair; with a wall on one of the two ways, the other one."""
    empty = belief_of(["....."] * 5, diagonal=True)
    assert all(goes_straight(empty.moves, a, b) for a in range(25) for b in range(25))
    # From (row 0, col 0) to (row 1, col 4): the diagonal move first meets the wall, last it does
    # not.
    walled = belief_of([".....", ".#...", "....."], diagonal=True)
    assert goes_straight(walled.moves, 0, 9)
    both = belief_of([".....", ".#...", "..#.."], diagonal=True)
    assert not goes_straight(both.moves, 0, 9)


def plain(costs: list[list[float]], between: Callable[[int, int], float]) -> list[tuple[int, int]]:
    """The auctions with every bid worked out."""
    ends = [-1] * len(costs)
    awards: list[tuple[int, int]] = []
    n = len(costs[0])
    for task in sorted(range(n), key=lambda t: (min(row[t] for row in costs), t)):
        bids = [
            row[task] if end < 0 else between(end, task)
            for row, end in zip(costs, ends, strict=True)
        ]
        winner = bids.index(min(bids))
        ends[winner] = task
        awards.append((task, winner))
    return awards


@pytest.mark.parametrize("seed", range(5))
def test_bids_left_out_would_have_lost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = ["".join(rng.choice(list("....#"), 12)) for _ in range(12)]
    belief = belief_of(rows, diagonal=True)
    start = int(np.argmax((belief.marks & 1).reshape(-1)))
    reached = [
        cell
        for cell in range(144)
        if belief.marks.item(cell) & 1 and searched(belief, start, cell) < inf
    ]
    tasks = tuple(int(task) for task in rng.choice(reached, 10, replace=False))
    bidders = [int(bidder) for bidder in rng.choice(reached, 3, replace=False)]
    costs = [[searched(belief, bidder, task) for task in tasks] for bidder in bidders]
    paths = TaskPaths(belief, tasks)
    found = sequential_auctions(np.array(costs), paths.between, paths.least)
    assert found == plain(costs, lambda one, other: searched(belief, tasks[one], tasks[other]))
