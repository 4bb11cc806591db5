"""Lengths over corners alone against fields over all cells, and how much less is looked at."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from conav.geometry import jump_graph
from conav.geometry.clearance import free_moves
from conav.geometry.directions import DCOL, DROW, OPPOSITE
from conav.geometry.distance_field import fill_distances
from conav.geometry.ground import Ground
from conav.geometry.jump_graph import JumpGraph


class Groups(NamedTuple):
    """Some places of a grid in groups, and cells to measure from."""

    first: np.ndarray
    places: np.ndarray
    starts: np.ndarray


def grid(rng: np.random.Generator, side: int) -> np.ndarray:
    """Moves among random walls: as on maps, or with moves taken out anywhere, both ways."""
    rows, cols = (int(n) for n in rng.integers(1, side + 1, 2))
    walls = (rng.random((rows, cols)) < rng.choice([0.0, 0.05, 0.2, 0.35])).astype(np.uint8)
    moves = np.ascontiguousarray(free_moves(walls, rows, cols, 1.0, 0.1)[:, :, 1])
    if rng.random() < 0.3:
        moves &= 15  # no diagonal moves
    share = rng.choice([0.0, 0.0, 0.02, 0.2])
    for r, c in np.ndindex(rows, cols):
        for k in range(8):
            if moves[r, c] >> k & 1 and rng.random() < share:
                moves[r, c] &= ~np.uint8(1 << k)
                moves[r + DROW[k], c + DCOL[k]] &= ~np.uint8(1 << OPPOSITE[k])
    return moves


def groups(rng: np.random.Generator, size: int) -> Groups:
    """Groups that overlap, hold places twice, and may hold the starts."""
    sizes = rng.integers(1, 6, int(rng.integers(1, 8)))
    places = rng.integers(0, size, int(sizes.sum()))
    first = np.concatenate([[0], np.cumsum(sizes)])
    return Groups(first, places, rng.integers(0, size, 4))


def ground_of(moves: np.ndarray) -> Ground:
    ground = Ground(moves.shape)
    ground.update(moves)
    return ground


def by_fields(ground: Ground, asked: Groups) -> tuple[np.ndarray, np.ndarray]:
    """Costs and nearest places by a field over all cells from each start."""
    shape = (len(asked.starts), len(asked.first) - 1)
    costs, nearest = np.empty(shape), np.empty(shape, dtype=np.int64)
    distance = np.empty(ground.moves.size)
    for i, start in enumerate(asked.starts):
        fill_distances(ground, np.array([start]), distance)
        for j, (one, end) in enumerate(pairwise(asked.first)):
            group = asked.places[one:end]
            costs[i, j] = distance[group].min()
            nearest[i, j] = group[np.argmin(distance[group])]
    return costs, nearest


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=300, deadline=None)
@given(seeds)
@example(0)
def test_lengths_are_those_of_fields(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moves = grid(rng, 20)
    ground = ground_of(moves)
    asked = groups(rng, moves.size)
    graph = JumpGraph(ground, asked.first, asked.places)
    costs, nearest = by_fields(ground, asked)
    group = int(rng.integers(costs.shape[1]))  # searches that end early before those that do not
    for start, row in zip(asked.starts.tolist(), costs, strict=True):
        assert graph.length(start, group) == row[group]
    for _ in range(2):  # what was found stays
        found = graph.lengths(asked.starts)
        assert np.array_equal(found[0], costs)
        assert np.array_equal(found[1], nearest)


@pytest.mark.parametrize("diagonal", [True, False])
def test_rooms_and_doors(diagonal: bool) -> None:
    """Four rooms of 30 x 30 cells with doors between them: few nodes, and exact lengths."""
    walls = np.zeros((61, 61), np.uint8)
    walls[30, :] = walls[:, 30] = 1
    walls[30, [8, 50]] = walls[[12, 44], 30] = 0
    moves = np.ascontiguousarray(free_moves(walls, 61, 61, 1.0, 0.1)[:, :, 1])
    if not diagonal:
        moves &= 15
    ground = ground_of(moves)
    rng = np.random.default_rng(1)
    asked = groups(rng, moves.size)
    graph = JumpGraph(ground, asked.first, asked.places)
    costs, nearest = by_fields(ground, asked)
    found = graph.lengths(asked.starts)
    assert np.array_equal(found[0], costs)
    assert np.array_equal(found[1], nearest)
    if diagonal:
        # The starts, and at most the door and the four cells beside its corners for each door.
        assert graph.nodes <= len(asked.starts) + 4 * 5


def test_no_starts_and_no_groups() -> None:
    ground = ground_of(np.zeros((3, 4), np.uint8))
    nothing = np.empty(0, dtype=np.int64)
    costs, nearest = JumpGraph(ground, np.zeros(1, np.int64), nothing).lengths(np.array([5]))
    assert costs.shape == nearest.shape == (1, 0)
    graph = JumpGraph(ground, np.array([0, 2]), np.array([7, 5]))
    assert graph.lengths(nothing)[0].shape == (0, 1)
    costs, nearest = graph.lengths(np.array([5, 4]))
    assert costs.tolist() == [[0.0], [np.inf]]
    assert nearest.tolist() == [[5], [7]]  # the first where no path leads


@pytest.mark.parametrize("room", [1, 2, 3])
def test_room_that_is_too_small_is_made_larger(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(room)
    walls = (rng.random((20, 20)) < 0.3).astype(np.uint8)
    ground = ground_of(np.ascontiguousarray(free_moves(walls, 20, 20, 1.0, 0.1)[:, :, 1]))
    asked = groups(rng, 400)
    monkeypatch.setattr(jump_graph, "FIRST_ROOM", room)
    graph = JumpGraph(ground, asked.first, asked.places)
    costs, nearest = by_fields(ground, asked)
    found = graph.lengths(asked.starts)
    assert np.array_equal(found[0], costs)
    assert np.array_equal(found[1], nearest)
    assert graph.nodes > room
