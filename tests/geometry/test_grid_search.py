"""The bucket search against a plain Dijkstra with a heap."""

import heapq
import threading
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.geometry.clearance import free_moves
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.grid_search import SearchSpace, path_to, search, search_space
from conav.maps.ascii_art import parse_ascii


def dijkstra(moves: np.ndarray, start: int) -> dict[int, float]:
    cols = moves.shape[1]
    final: dict[int, float] = {}
    heap = [(0.0, start)]
    while heap:
        length, cell = heapq.heappop(heap)
        if cell in final:
            continue
        final[cell] = length
        for k in range(8):
            if moves.flat[cell] >> k & 1:
                step = 1.0 if k < 4 else SQRT2
                heapq.heappush(heap, (length + step, cell + DROW[k] * cols + DCOL[k]))
    return final


def run(space: SearchSpace, moves: np.ndarray, start: int, goals: np.ndarray, mask: int = 1) -> int:
    return search(moves, start, goals, mask, space)


def inside(moves: np.ndarray) -> np.ndarray:
    """The same moves without those that leave the grid."""
    rows, cols = moves.shape
    moves = moves.copy()
    for r, c, k in product(range(rows), range(cols), range(8)):
        if not (0 <= r + DROW[k] < rows and 0 <= c + DCOL[k] < cols):
            moves[r, c] &= ~np.uint8(1 << k)
    return moves


shapes = st.tuples(st.integers(1, 10), st.integers(1, 10))
# One-way moves and all: more than maps can hold.
cases = shapes.flatmap(
    lambda shape: st.tuples(
        arrays(np.uint8, shape, elements=st.integers(0, 255)).map(inside),
        arrays(np.uint8, shape, elements=st.sampled_from([0] * 12 + [1, 4, 6])),
        st.integers(0, shape[0] * shape[1] - 1),
        st.sampled_from([1, 2, 4, 5, 7]),
    )
)


def check(
    space: SearchSpace, moves: np.ndarray, goals: np.ndarray, start: int, mask: int = 1
) -> None:
    expected = dijkstra(moves, start)
    wanted = np.flatnonzero(goals & np.uint8(mask))
    reached = [(expected[cell], cell) for cell in wanted if cell in expected]
    found = run(space, moves, start, goals, mask)
    now = space.stamp[-1]
    if not reached:
        assert found == -1
        touched = np.flatnonzero(space.stamp[:-1] == now)
        assert set(touched.tolist()) == set(expected)
        assert all(abs(space.distance[cell] - expected[cell]) < 1e-9 for cell in expected)
        return
    length = min(reached)[0]
    assert goals.flat[found] & mask
    assert abs(expected[found] - length) < 1e-9
    assert abs(space.distance[found] - length) < 1e-9
    path, count = path_to(space, moves.shape[1], found)
    assert count == len(path)
    cell, walked = start, 0.0
    for k in path[::-1].tolist():
        assert moves.flat[cell] >> k & 1
        cell += DROW[k] * moves.shape[1] + DCOL[k]
        walked += 1.0 if k < 4 else SQRT2
    assert cell == found
    assert abs(walked - length) < 1e-9


@settings(max_examples=200, deadline=None)
@given(cases)
def test_equals_dijkstra(case: tuple[np.ndarray, np.ndarray, int, int]) -> None:
    moves, goals, start, mask = case
    check(SearchSpace(moves.size), moves, goals, start, mask)


@settings(max_examples=80, deadline=None)
@given(
    shapes.flatmap(
        lambda shape: st.tuples(
            arrays(np.uint8, shape, elements=st.sampled_from([0, 0, 0, 1])),
            arrays(np.uint8, shape, elements=st.sampled_from([0] * 12 + [1])),
            st.integers(0, shape[0] * shape[1] - 1),
        )
    )
)
def test_equals_dijkstra_on_maps(case: tuple[np.ndarray, np.ndarray, int]) -> None:
    cells, goals, start = case
    moves = np.ascontiguousarray(free_moves(cells, *cells.shape, 1.0, 0.1)[:, :, 1])
    check(SearchSpace(moves.size), moves, goals, start)


@settings(max_examples=40, deadline=None)
@given(st.lists(cases, min_size=2, max_size=6))
def test_searches_leave_nothing_behind(
    several: list[tuple[np.ndarray, np.ndarray, int, int]],
) -> None:
    """One space, many searches: found or not, over other moves and from other starts."""
    shape = several[0][0].shape
    space = SearchSpace(several[0][0].size)
    for moves, goals, start, mask in several:
        resized = inside(np.resize(moves, shape))
        check(space, resized, np.resize(goals, shape), start % resized.size, mask)


def everywhere(rows: int, cols: int) -> np.ndarray:
    return inside(np.full((rows, cols), 255, np.uint8))


def goals_at(shape: tuple[int, int], *cells: int) -> np.ndarray:
    goals = np.zeros(shape, np.uint8)
    goals.flat[list(cells)] = 1
    return goals


def test_ties_go_to_the_lower_index() -> None:
    moves = everywhere(5, 5)
    space = SearchSpace(25)
    for cells in ([11, 13], [7, 11, 13, 17], [6, 8, 16, 18], [13, 17]):
        assert run(space, moves, 12, goals_at((5, 5), *cells)) == min(cells)


def test_the_diagonal_is_nearer_than_two_straight_moves() -> None:
    moves = everywhere(5, 5)
    space = SearchSpace(25)
    assert run(space, moves, 12, goals_at((5, 5), 10, 18)) == 18  # 1.41 against 2
    assert run(space, moves, 12, goals_at((5, 5), 10, 24)) == 10  # 2 against 2.83


def test_the_start_may_be_the_goal() -> None:
    space = SearchSpace(25)
    assert run(space, everywhere(5, 5), 12, goals_at((5, 5), 12)) == 12
    path, count = path_to(space, 5, 12)
    assert count == 0
    assert len(path) == 0


def test_a_lone_cell() -> None:
    space = SearchSpace(1)
    moves = np.zeros((1, 1), np.uint8)
    assert run(space, moves, 0, goals_at((1, 1))) == -1
    assert run(space, moves, 0, goals_at((1, 1), 0)) == 0


def test_an_unreachable_goal_is_not_found() -> None:
    cells = parse_ascii("...#.\n...#.\n...#.").cells
    moves = np.ascontiguousarray(free_moves(cells, 3, 5, 1.0, 0.1)[:, :, 1])
    space = SearchSpace(15)
    assert run(space, moves, 0, goals_at((3, 5), 4, 9)) == -1
    assert np.count_nonzero(space.stamp[:-1] == space.stamp[-1]) == 9


def test_the_result_does_not_change_the_path_given_out() -> None:
    moves = everywhere(4, 4)
    space = SearchSpace(16)
    goal = run(space, moves, 0, goals_at((4, 4), 15))
    path, _ = path_to(space, 4, goal)
    kept = path.copy()
    path_to(space, 4, run(space, moves, 15, goals_at((4, 4), 0)))
    assert np.array_equal(path, kept)


@pytest.mark.parametrize("sizes", [(9, 9), (9, 16)])
def test_the_shared_space_fits_the_size_asked_for(sizes: tuple[int, int]) -> None:
    first, second = search_space(sizes[0]), search_space(sizes[1])
    assert (first is second) == (sizes[0] == sizes[1])
    assert second.distance.shape == (sizes[1],)


def test_threads_do_not_share_a_space() -> None:
    here = search_space(9)
    there: list[SearchSpace] = []
    thread = threading.Thread(target=lambda: there.append(search_space(9)))
    thread.start()
    thread.join()
    assert there[0] is not here


def test_equal_lengths_by_different_orders_of_moves_tie() -> None:
    """Goals at the same number of straight and diagonal moves tie, whatever their order.

    1 + 1.414... + 1.414... and 1.414... + 1.414... + 1 are not the same float.
    """
    rng = np.random.default_rng(3)
    space = SearchSpace(144)
    for _ in range(60):
        cells = (rng.random((12, 12)) < 0.25).astype(np.uint8)
        moves = np.ascontiguousarray(free_moves(cells, 12, 12, 1.0, 0.1)[:, :, 1])
        start = int(rng.integers(144))
        exact = exact_lengths(moves, start)
        by_length: dict[tuple[int, int], list[int]] = {}
        for cell, key in exact.items():
            by_length.setdefault(key, []).append(cell)
        for cells_there in by_length.values():
            if len(cells_there) > 1:
                goals = goals_at((12, 12), *cells_there)
                assert run(space, moves, start, goals) == min(cells_there)


def exact_lengths(moves: np.ndarray, start: int) -> dict[int, tuple[int, int]]:
    """Straight and diagonal moves of a shortest path to each cell."""
    cols = moves.shape[1]
    best = {start: (0, 0)}
    queue = [start]
    while queue:
        cell = queue.pop()
        for k in range(8):
            if moves.flat[cell] >> k & 1:
                straight, diagonal = best[cell]
                longer = (straight + (k < 4), diagonal + (k >= 4))
                other = cell + DROW[k] * cols + DCOL[k]
                if other not in best or (
                    longer[0] + longer[1] * SQRT2 < best[other][0] + best[other][1] * SQRT2 - 1e-9
                ):
                    best[other] = longer
                    queue.append(other)
    return best
