"""Fields that leave out most of a map's shortest paths against a plain search over all of them."""

import heapq
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from conav.geometry import distance_field
from conav.geometry.clearance import free_moves
from conav.geometry.directions import DCOL, DROW, OPPOSITE, SQRT2
from conav.geometry.distance_field import (
    FieldSpace,
    field_buffer,
    fill_distances,
    shortest_path,
)
from conav.geometry.ground import Ground


def lengths(moves: np.ndarray, starts: list[int]) -> np.ndarray:
    """Path lengths from the nearest start, by Dijkstra over numbers of straight and diagonal moves.

    Made from the two numbers, so that equal lengths are equal floats.
    """
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    found = np.full(moves.size, np.inf)
    heap = [(0.0, 0, 0, start) for start in starts]
    while heap:
        length, straight, diagonal, cell = heapq.heappop(heap)
        if length >= found[cell]:
            continue
        found[cell] = length
        for k in range(8):
            if flat[cell] >> k & 1:
                s, d = straight + (k < 4), diagonal + (k >= 4)
                other = cell + DROW[k] * cols + DCOL[k]
                heapq.heappush(heap, (s + d * SQRT2, s, d, other))
    return found


def room(rng: np.random.Generator, side: int) -> np.ndarray:
    """Moves among random walls: as on maps, or with moves taken out anywhere, both ways."""
    shape = tuple(int(n) for n in rng.integers(1, side + 1, 2))
    walls = (rng.random(shape) < rng.choice([0.0, 0.05, 0.2, 0.35])).astype(np.uint8)
    moves = np.ascontiguousarray(free_moves(walls, *shape, 1.0, 0.1)[:, :, 1])
    if rng.random() < 0.3:
        moves &= 15  # no diagonal moves
    share = rng.choice([0.0, 0.0, 0.02, 0.2])
    for r, c in np.ndindex(shape):
        for k in range(8):
            if moves[r, c] >> k & 1 and rng.random() < share:
                moves[r, c] &= ~np.uint8(1 << k)
                moves[r + DROW[k], c + DCOL[k]] &= ~np.uint8(1 << OPPOSITE[k])
    return moves


def all_moves(rows: int, cols: int) -> np.ndarray:
    """The moves of an empty room."""
    walls = np.zeros((rows, cols), np.uint8)
    return np.ascontiguousarray(free_moves(walls, rows, cols, 1.0, 0.1)[:, :, 1])


def part_of(moves: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The moves between known cells."""
    part = np.zeros_like(moves)
    for r, c in np.argwhere(known):
        for k in range(8):
            if moves[r, c] >> k & 1 and known[r + DROW[k], c + DCOL[k]]:
                part[r, c] |= np.uint8(1 << k)
    return part


def ground_of(moves: np.ndarray) -> Ground:
    ground = Ground(moves.shape)
    ground.update(moves)
    return ground


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=300, deadline=None)
@given(seeds)
@example(0)
def test_fields_are_those_of_a_plain_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moves = room(rng, 16)
    starts = rng.integers(0, moves.size, int(rng.integers(1, 4)))
    distance = np.empty(moves.size)
    fill_distances(ground_of(moves), starts, distance)
    assert np.array_equal(distance, lengths(moves, starts.tolist()))


@settings(max_examples=150, deadline=None)
@given(seeds)
def test_an_early_end_leaves_the_nearest_of_each_group_exact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moves = room(rng, 16)
    start = int(rng.integers(moves.size))
    exact = lengths(moves, [start])
    sizes = rng.integers(1, 5, int(rng.integers(1, 6)))
    places = rng.integers(0, moves.size, int(sizes.sum()))
    first = np.concatenate([[0], np.cumsum(sizes)])
    distance = np.empty(moves.size)
    fill_distances(ground_of(moves), np.array([start]), distance, first, places)
    farthest = 0.0
    for one, end in pairwise(first):
        nearest = exact[places[one:end]].min()
        assert distance[places[one:end]].min() == nearest
        farthest = max(farthest, nearest)
    assert (distance >= exact).all()
    near = exact <= farthest
    assert np.array_equal(distance[near], exact[near])


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_the_shared_buffer_leaves_nothing_behind(seed: int) -> None:
    """Short searches and long ones, one after the other, over grids of one size."""
    rng = np.random.default_rng(seed)
    moves = [part_of(all_moves(12, 12), rng.random((12, 12)) < share) for share in (0.95, 0.6)]
    for _ in range(8):
        ground = ground_of(moves[int(rng.integers(2))])
        starts = rng.integers(0, 144, int(rng.integers(1, 3)))
        buffer = field_buffer(144)
        exact = lengths(ground.moves, starts.tolist())
        if rng.random() < 0.6:
            goal = rng.integers(0, 144, 1)
            fill_distances(ground, starts, buffer, np.array([0, 1]), goal)
            assert buffer[goal[0]] == exact[goal[0]]
            assert (buffer >= exact).all()
        else:
            fill_distances(ground, starts, buffer)
            assert np.array_equal(buffer, exact)


def test_an_early_end_looks_at_less() -> None:
    moves = np.ascontiguousarray(free_moves(np.zeros((200, 200), np.uint8), 200, 200, 1.0, 0.1))
    ground = ground_of(np.ascontiguousarray(moves[:, :, 1]))
    distance = np.empty(ground.moves.size)
    start = np.array([0])
    whole = fill_distances(ground, start, distance)
    early = fill_distances(ground, start, distance, np.array([0, 1]), np.array([20 * 200 + 20]))
    assert early < whole / 5


def test_open_ground_hardly_goes_through_the_queue() -> None:
    """Of a room of 10,000 cells nothing but the diagonals from where the search starts."""
    moves = np.ascontiguousarray(free_moves(np.zeros((100, 100), np.uint8), 100, 100, 1.0, 0.1))
    ground = ground_of(np.ascontiguousarray(moves[:, :, 1]))
    distance = np.empty(ground.moves.size)
    taken = fill_distances(ground, np.array([50 * 100 + 50]), distance)
    assert taken <= 200
    assert np.isfinite(distance).all()


@settings(max_examples=120, deadline=None)
@given(seeds)
def test_a_ground_grows_into_what_it_is_made_from_at_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moves = room(rng, 14)
    ground = Ground(moves.shape)
    known = np.zeros(moves.size, dtype=bool)
    # Anywhere, or more or less from one end to the other.
    order = np.argsort(np.arange(moves.size) + rng.random(moves.size) * rng.choice([20, 1000]))
    for fresh in np.array_split(order, 5):
        known[fresh] = True
        now = part_of(moves, known.reshape(moves.shape))
        ground.update(now)
        at_once = ground_of(now)
        assert np.array_equal(ground.only, at_once.only)
        assert np.array_equal(ground.runs, at_once.runs)
        distance = np.empty(moves.size)
        fill_distances(ground, order[:1], distance)
        everything = np.arange(moves.size)
        reached = ground.reachable(everything, order[:1])
        assert np.array_equal(reached, np.flatnonzero(np.isfinite(distance)))
        fill_distances(ground, order[:3], distance)
        shuffled = rng.permutation(everything)
        reached = ground.reachable(shuffled, order[:3])
        assert np.array_equal(reached, shuffled[np.isfinite(distance[shuffled])])


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_runs_are_as_long_as_nothing_else_follows(seed: int) -> None:
    ground = ground_of(room(np.random.default_rng(seed), 12))
    flat = ground.moves.reshape(-1)
    for k in range(4):
        step = DROW[k] * ground.moves.shape[1] + DCOL[k]
        for cell in range(len(flat)):
            at, count = cell, 1
            while ground.only[at] >> k & 1 and flat[at] >> k & 1:
                at, count = at + step, count + 1
            turns = not ground.only[at] >> k & 1
            assert ground.runs[k, cell] == (count if turns else -count)


def test_a_copy_of_a_ground_goes_its_own_way() -> None:
    moves = room(np.random.default_rng(5), 12)
    ground = Ground(moves.shape)
    copy = ground.copy()
    ground.update(moves)
    assert not copy.moves.any()
    copy.update(moves)
    assert np.array_equal(copy.only, ground.only)
    assert np.array_equal(copy.runs, ground.runs)
    everywhere = np.arange(moves.size)
    for start in everywhere[::7, np.newaxis]:
        reached = ground.reachable(everywhere, start)
        assert np.array_equal(copy.reachable(everywhere, start), reached)


def test_a_queue_that_is_too_short_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    walls = (np.random.default_rng(9).random((30, 30)) < 0.3).astype(np.uint8)
    walls[:3, :3] = 0
    moves = np.ascontiguousarray(free_moves(walls, 30, 30, 1.0, 0.1)[:, :, 1])
    lists = sum(moves.shape) + 4
    distance = np.empty(moves.size)
    for small in (1, 2, 5):
        spaces = [FieldSpace(small, lists)]
        monkeypatch.setattr(distance_field, "_field_space", lambda shape, s=spaces: s[-1])
        with monkeypatch.context() as patch:
            patch.setattr(
                distance_field,
                "FieldSpace",
                lambda n, m, s=spaces: s.append(FieldSpace(n, m)) or s[-1],
            )
            fill_distances(ground_of(moves), np.array([0]), distance)
        assert len(spaces) > 1
        assert np.array_equal(distance, lengths(moves, [0]))


@settings(max_examples=150, deadline=None)
@given(seeds)
def test_paths_are_shortest_and_go_straight_first(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moves = room(rng, 14)
    start, goal = (int(cell) for cell in rng.integers(0, moves.size, 2))
    exact = lengths(moves, [start])
    path, count = shortest_path(ground_of(moves), start, goal)
    assert len(path) == count
    if np.isinf(exact[goal]):
        assert count == 0
        return
    cell = goal
    for k in path.tolist():
        fitting = [
            j
            for j in range(8)
            if moves.flat[cell] >> OPPOSITE[j] & 1
            and np.isclose(
                exact[cell - DROW[j] * moves.shape[1] - DCOL[j]] + (1 if j < 4 else SQRT2),
                exact[cell],
                rtol=0,
                atol=1e-9,
            )
        ]
        assert k == min(fitting, key=lambda j: (j < 4, j))  # seen from the goal
        cell -= DROW[k] * moves.shape[1] + DCOL[k]
    assert cell == start


def test_a_long_way_through_a_labyrinth() -> None:
    """One corridor in windings: lengths go through all lists of the queue many times."""
    walls = np.zeros((41, 41), np.uint8)
    walls[1::4, :-1] = 1
    walls[3::4, 1:] = 1
    moves = np.ascontiguousarray(free_moves(walls, 41, 41, 1.0, 0.1)[:, :, 1])
    distance = np.empty(moves.size)
    fill_distances(ground_of(moves), np.array([0]), distance)
    assert np.array_equal(distance, lengths(moves, [0]))
    assert distance[40 * 41 + 0] > 800 or distance[40 * 41 + 40] > 800
