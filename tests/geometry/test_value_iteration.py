"""Value iteration against the bucket search, and its counters by hand."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.geometry.clearance import free_moves
from conav.geometry.directions import DCOL, DROW, OPPOSITE, SQRT2
from conav.geometry.grid_search import SearchSpace, search
from conav.geometry.value_iteration import (
    DIAGONAL,
    Sweeps,
    raster_order,
    there_and_back,
    value_iteration,
)
from conav.maps.ascii_art import parse_ascii


def both_ways(moves: np.ndarray) -> np.ndarray:
    """Those of the moves that stay on the grid and can also be made the other way."""
    rows, cols = moves.shape
    kept = np.zeros_like(moves)
    for r, c, k in product(range(rows), range(cols), range(8)):
        r2, c2 = r + DROW[k], c + DCOL[k]
        if 0 <= r2 < rows and 0 <= c2 < cols:
            kept[r, c] |= (moves[r, c] >> k & moves[r2, c2] >> OPPOSITE[k] & 1) << k
    return kept


def moves_on(art: str) -> np.ndarray:
    cells = parse_ascii(art).cells
    return np.ascontiguousarray(free_moves(cells, *cells.shape, 1.0, 0.1)[:, :, 1])


def solve(
    moves: np.ndarray, start: int, orders: np.ndarray | None = None
) -> tuple[np.ndarray, Sweeps]:
    cost = np.full(moves.size, -1.0)
    if orders is None:
        orders = raster_order(moves, start)
    return cost, value_iteration(moves, start, cost, orders)


def check(moves: np.ndarray, start: int) -> None:
    space = SearchSpace(moves.size)
    assert search(moves, start, np.zeros_like(moves), 255, space) == -1
    reached = space.stamp[:-1] == space.stamp[-1]
    order = raster_order(moves, start)
    cost, work = solve(moves, start, order)
    explored = np.zeros(moves.size, np.bool_)
    explored[order[0]] = True
    assert (reached <= explored).all()
    assert np.array_equal(np.isfinite(cost) & explored, reached)
    assert np.allclose(cost[reached], space.distance[reached], rtol=1e-11, atol=0)
    assert (cost[~explored] == -1.0).all()
    assert work.touched == work.sweeps * explored.sum()
    assert work.lowered >= reached.sum() - 1
    # The same, to the last bit, in whatever order.
    rng = np.random.default_rng(work.touched)
    shuffled = np.stack([rng.permutation(order[0]) for _ in range(3)]).astype(np.int32)
    for orders in (there_and_back(order), shuffled):
        assert np.array_equal(solve(moves, start, orders)[0], cost)


shapes = st.tuples(st.integers(1, 10), st.integers(1, 10))


@settings(max_examples=150, deadline=None)
@given(
    shapes.flatmap(
        lambda shape: st.tuples(
            arrays(np.uint8, shape, elements=st.integers(0, 255)).map(both_ways),
            st.integers(0, shape[0] * shape[1] - 1),
        )
    )
)
def test_equals_the_search_on_any_moves(case: tuple[np.ndarray, int]) -> None:
    check(*case)


@settings(max_examples=100, deadline=None)
@given(
    shapes.flatmap(
        lambda shape: st.tuples(
            arrays(np.uint8, shape, elements=st.sampled_from([0, 0, 0, 1])),
            st.integers(0, shape[0] * shape[1] - 1),
        )
    )
)
def test_equals_the_search_on_maps(case: tuple[np.ndarray, int]) -> None:
    cells, start = case
    check(np.ascontiguousarray(free_moves(cells, *cells.shape, 1.0, 0.1)[:, :, 1]), start)


def test_a_larger_map() -> None:
    rng = np.random.default_rng(5)
    cells = (rng.random((90, 110)) < 0.3).astype(np.uint8)
    check(np.ascontiguousarray(free_moves(cells, 90, 110, 1.0, 0.1)[:, :, 1]), 45 * 110 + 55)


def test_costs_by_hand() -> None:
    # Row 0 is the lowest line. From the lower left corner, round the wall in the middle.
    moves = moves_on("....\n.##.\n....")
    cost, _ = solve(moves, 0)
    inf = np.inf
    # No corner may be cut, so no move is diagonal.
    assert cost.reshape(3, 4).tolist()[0] == [0.0, 1.0, 2.0, 3.0]
    assert cost.reshape(3, 4).tolist()[1] == [1.0, -1.0, -1.0, 4.0]
    assert cost.reshape(3, 4).tolist()[2] == [2.0, 3.0, 4.0, 5.0]
    cost, _ = solve(moves_on("..#.\n..#."), 0)
    assert cost.reshape(2, 4).tolist() == [[0.0, 1.0, -1.0, inf], [1.0, DIAGONAL, -1.0, inf]]


@pytest.mark.parametrize("across", [True, False])
@pytest.mark.parametrize("n", [2, 3, 8])
def test_a_corridor_along_and_against_the_raster(n: int, across: bool) -> None:
    moves = moves_on("." * n if across else "\n".join("." * n))
    # Along: one sweep finds all, a second one finds nothing more.
    assert solve(moves, 0)[1] == Sweeps(2, 2 * n, n - 1)
    # Against: one cell a sweep.
    assert solve(moves, n - 1)[1] == Sweeps(n, n * n, n - 1)
    # From the middle: the longer of the two, and the one to no avail.
    assert solve(moves, n // 2)[1] == Sweeps(n // 2 + 1, (n // 2 + 1) * n, n - 1)


@pytest.mark.parametrize("n", [3, 8])
def test_there_and_back_needs_three_sweeps_in_a_corridor(n: int) -> None:
    moves = moves_on("." * n)
    # The first one gets to the neighbour, the second one everywhere, the third one is to no avail.
    work = solve(moves, n - 1, there_and_back(raster_order(moves, n - 1)))[1]
    assert work == Sweeps(3, 3 * n, n - 1)


@pytest.mark.parametrize("half", [1, 2, 5])
def test_an_open_square_takes_a_sweep_per_row_against_the_raster(half: int) -> None:
    side = 2 * half + 1
    moves = moves_on("\n".join(["." * side] * side))
    start = half * side + half
    assert solve(moves, start)[1].sweeps == half + 1
    assert solve(moves, 0)[1].sweeps == 2
    assert solve(moves, side * side - 1)[1].sweeps == side


def test_a_winding_corridor_takes_a_sweep_per_cell_against_the_raster() -> None:
    # Up from the lower left; of the three long stretches the middle one leads to the left.
    moves = moves_on("......\n.#####\n......\n#####.\n......")
    cost, work = solve(moves, 0)
    assert np.nanmax(cost) == 19.0
    # The first sweep goes to the right end and up; then come the 5 cells to the left one by one,
    # with the last of them all the rest, and one more sweep finds nothing.
    assert work == Sweeps(7, 7 * 20, 19)


def test_a_lone_start() -> None:
    cost, work = solve(np.zeros((2, 3), np.uint8), 4)
    assert cost.tolist() == [-1.0, -1.0, -1.0, -1.0, 0.0, -1.0]
    assert work == Sweeps(1, 1, 0)


def test_what_cannot_be_reached_is_swept_all_the_same() -> None:
    moves = moves_on("..#...")
    cost, work = solve(moves, 0)
    assert cost.tolist() == [0.0, 1.0, -1.0, np.inf, np.inf, np.inf]
    assert work == Sweeps(2, 10, 1)


def test_nothing_is_left_of_an_earlier_call() -> None:
    moves = moves_on("......\n.#####\n......")
    cost, _ = solve(moves, 3)
    first = cost.copy()
    value_iteration(moves, 12, cost, raster_order(moves, 12))
    value_iteration(moves, 3, cost, raster_order(moves, 3))
    assert np.array_equal(cost, first)


def test_the_diagonal_is_exact_in_sums() -> None:
    assert abs(DIAGONAL - SQRT2) < 1.2e-11
    total = 0.0
    for k in range(3000):
        total += DIAGONAL if k % 3 else 1.0
    assert total == 1000 + 2000 * DIAGONAL
