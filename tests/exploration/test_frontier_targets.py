"""Targets, pieces and costs against the same made from scratch."""

import heapq
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import conav
from conav.exploration.belief import TARGET
from conav.exploration.frontier_targets import (
    PathsTo,
    Targets,
    find_targets,
    paths_to,
    paths_to_targets,
)
from conav.exploration.nearest import Nearest
from conav.exploration.types import TeamView
from conav.geometry.clearance import free_moves
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.grid_search import SearchSpace, path_to, search
from conav.geometry.ground import Ground
from conav.maps.occupancy_grid import FREE, UNKNOWN
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world


class Explored(NamedTuple):
    view: TeamView
    stood: set[int]  # planning cells from which robot 0 holds a scan
    state: WorldState


def explored(name: str, steps: int, **more: Any) -> Explored:
    """What robot 0 knows after some steps of `nearest`."""
    size = 20 if name == "three-obstacles" else 12
    grid = conav.builtin_map(name, width_m=size, height_m=size, seed=more.get("seed", 0))
    problem, _ = exploration_problem(grid, **({"range_m": 2.0} | more))
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Nearest(), seen)
    engine = engine_for(state)
    visited: set[int] = set()
    for _ in range(steps):
        visited.update(state.cells.tolist())
        events = engine.sense_and_decide(state, [])
        engine.move(state, events.actions)
    if problem.perfect_radio:
        stood = visited
    else:
        held = state.held[0]
        stood = {scan.cell for r in range(len(held)) for scan in state.scans[r][: held[r]]}
    view = TeamView(
        state.step,
        state.time_s,
        0,
        problem.robots[0],
        int(state.cells[0]),
        int(state.headings[0]),
        state.beliefs[0],
        problem.plan.lattice,
        state.heard_cell[0],
        state.heard_step[0],
        state.in_touch[0],
    )
    return Explored(view, stood, state)


def ground_of(moves: np.ndarray) -> Ground:
    ground = Ground(moves.shape)
    ground.update(moves)
    return ground


def made_up(wanted: np.ndarray, moves: np.ndarray, range_m: float) -> Any:
    """A view in which nothing but what targets depend on is real; cells of 1 m."""
    marks = (wanted * TARGET).astype(np.uint8)
    return SimpleNamespace(
        belief=SimpleNamespace(
            marks=marks,
            moves=moves,
            ground=ground_of(moves),
            scans=0,
            derived={},
        ),
        body=SimpleNamespace(sensor=SimpleNamespace(range_m=range_m)),
        lattice=SimpleNamespace(cell_m=1.0, cols=wanted.shape[1], rows=wanted.shape[0]),
    )


def random_views(count: int) -> list[tuple[Any, int]]:
    """Random masks of targets in rooms with random walls, and the longest piece allowed."""
    rng = np.random.default_rng(11)
    views = []
    for _ in range(count):
        shape = tuple(int(side) for side in rng.integers(3, 22, 2))
        walls = (rng.random(shape) < rng.choice([0.1, 0.4])).astype(np.uint8)
        moves = np.ascontiguousarray(free_moves(walls, *shape, 1.0, 0.1)[:, :, 1])
        wanted = rng.random(shape) < rng.choice([0.05, 0.3, 0.7])
        range_m = float(rng.choice([0.4, 1.0, 2.7, 4.0, 5.9, 100.0]))
        views.append((made_up(wanted, moves, range_m), max(int(range_m), 1)))
    return views


def positions_for(view: Any, count: int = 3, seed: int = 0) -> np.ndarray:
    size = view.belief.moves.size
    return np.random.default_rng(seed).integers(0, size, count).astype(np.int32)


def dijkstra(moves: np.ndarray, start: int) -> np.ndarray:
    """Path lengths to all cells, with a heap."""
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    cost = np.full(moves.size, np.inf)
    cost[start] = 0.0
    heap = [(0.0, start)]
    while heap:
        length, cell = heapq.heappop(heap)
        if length > cost[cell]:
            continue
        for k in range(8):
            if flat[cell] >> k & 1:
                following = cell + DROW[k] * cols + DCOL[k]
                further = length + (1.0 if k < 4 else SQRT2)
                if further < cost[following] - 1e-9:
                    cost[following] = further
                    heapq.heappush(heap, (further, following))
    return cost


def components(cells: list[tuple[int, int]], block: int | None) -> list[set[tuple[int, int]]]:
    """The 8-connected sets of cells, where steps from block to block do not count."""
    left = set(cells)
    found = []
    while left:
        part = {left.pop()}
        edge = list(part)
        while edge:
            r, c = edge.pop()
            for r2 in (r - 1, r, r + 1):
                for c2 in (c - 1, c, c + 1):
                    same = block is None or (r // block, c // block) == (r2 // block, c2 // block)
                    if (r2, c2) in left and same:
                        left.remove((r2, c2))
                        part.add((r2, c2))
                        edge.append((r2, c2))
        found.append(part)
    return found


def pieces_of(targets: Targets, cols: int) -> dict[int, list[tuple[int, int]]]:
    pieces: dict[int, list[tuple[int, int]]] = {}
    for cell, piece in zip(targets.cells.tolist(), targets.piece.tolist(), strict=True):
        pieces.setdefault(piece, []).append(divmod(cell, cols))
    return pieces


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 4.0])
@pytest.mark.parametrize("steps", [1, 12, 45])
def test_targets_are_frontiers_nobody_scanned_from(
    name: str, radio: str | float, steps: int
) -> None:
    view, stood, _ = explored(name, steps, robots=3, radio=radio, seed=steps)
    lattice = view.lattice
    known = view.belief.cells
    wanted = set()
    for r, c in np.argwhere(known == FREE):
        around = [(r, c + 1), (r, c - 1), (r + 1, c), (r - 1, c)]
        if any(
            0 <= r2 < known.shape[0] and 0 <= c2 < known.shape[1] and known[r2, c2] == UNKNOWN
            for r2, c2 in around
        ):
            wanted.add(int(lattice.row_of[r]) * lattice.cols + int(lattice.col_of[c]))
    targets = find_targets(view, np.array([view.cell], np.int32))
    assert targets.cells.tolist() == sorted(wanted - stood)
    assert len(targets.cells) > 0


@pytest.mark.parametrize("motion", ["8-connected", "4-connected"])
@pytest.mark.parametrize("name", ["office", "cave", "maze"])
def test_costs_are_those_of_dijkstra(name: str, motion: str) -> None:
    view, _, state = explored(name, 25, robots=3, radio=3.0, motion=motion, seed=4)
    # Robot 0 may not know how to reach places where others have been.
    positions = np.unique(np.concatenate([state.cells, state.problem.starts])).astype(np.int32)
    targets = find_targets(view, positions)
    assert targets.costs.shape == (len(positions), len(targets.cells))
    for position, row in zip(positions.tolist(), targets.costs, strict=True):
        slow = dijkstra(view.belief.moves, position)[targets.cells]
        assert np.array_equal(np.isinf(row), np.isinf(slow))
        assert np.allclose(row, slow, rtol=1e-12, atol=0)
    assert np.isfinite(targets.costs).any()


def test_costs_are_inf_where_no_known_way_leads() -> None:
    both = 0
    for view, _ in random_views(60):
        positions = positions_for(view)
        targets = find_targets(view, positions)
        for position, row in zip(positions.tolist(), targets.costs, strict=True):
            slow = dijkstra(view.belief.moves, position)[targets.cells]
            assert np.array_equal(np.isinf(row), np.isinf(slow))
            assert np.allclose(row, slow, rtol=1e-12, atol=0)
            both += bool(np.isinf(row).any() and np.isfinite(row).any())
    assert both > 20


def test_a_cost_is_the_length_of_the_path_that_is_driven() -> None:
    view, _, _ = explored("cave", 30, robots=2, seed=1)
    targets = find_targets(view, np.array([view.cell], np.int32))
    space = SearchSpace(view.belief.moves.size)
    for cell, cost in zip(targets.cells.tolist(), targets.costs[0].tolist(), strict=True):
        goal = np.zeros_like(view.belief.marks)
        goal.reshape(-1)[cell] = 1
        found = search(view.belief.moves, view.cell, goal, 1, space)
        assert (found == cell) == np.isfinite(cost)
        if found == cell:
            moves, _ = path_to(space, view.lattice.cols, cell)
            diagonals = int((moves >= 4).sum())
            assert cost == len(moves) - diagonals + diagonals * SQRT2


def test_costs_do_not_depend_on_what_was_asked_before() -> None:
    view, _, state = explored("office", 20, robots=3, seed=2)
    ground, cells = view.belief.ground, find_targets(view, state.cells).cells
    once = PathsTo(ground, cells).costs(state.cells)
    paths = PathsTo(ground, cells)
    last = len(cells) - 1
    assert paths.cost(int(state.cells[1]), last) == once[1, last]
    assert np.array_equal(paths.costs(state.cells[::-1].copy()), once[::-1])
    assert np.array_equal(paths.costs(state.cells), once)
    assert paths.cost(int(state.cells[0]), 0) == once[0, 0]
    assert np.array_equal(paths.costs_from(int(state.cells[2])), once[2])
    assert np.array_equal(PathsTo(ground, cells).costs_from(int(state.cells[2])), once[2])


def test_paths_to_targets_are_kept_until_a_scan_is_heard() -> None:
    view, _, state = explored("office", 20, robots=3, seed=2)
    engine = engine_for(state)
    before = paths_to_targets(view.belief)
    assert paths_to_targets(view.belief) is before
    found, which = paths_to(view.belief, tuple(before.cells[[2, 0]].tolist()))
    assert found is before
    assert which.tolist() == [2, 0]
    stood = np.flatnonzero(view.belief.stood)[:2]
    elsewhere, which = paths_to(view.belief, tuple(stood.tolist()))
    assert elsewhere is not before
    assert paths_to(view.belief, tuple(stood.tolist()))[0] is elsewhere
    assert paths_to(view.belief, (int(before.cells[1]),))[0] is before
    assert np.array_equal(elsewhere.cells[which], stood)
    for _ in range(3):
        engine.move(state, engine.sense_and_decide(state, []).actions)
    engine.sense_and_decide(state, [])
    after = paths_to_targets(state.beliefs[0])
    assert after is not before
    assert np.array_equal(after.cells, np.flatnonzero(state.beliefs[0].marks & TARGET))


def test_pieces_partition_the_targets() -> None:
    for view, _ in random_views(80):
        targets = find_targets(view, positions_for(view))
        assert np.array_equal(targets.cells, np.flatnonzero(view.belief.marks & TARGET))
        assert targets.piece.shape == targets.cells.shape
        assert sorted(set(targets.piece.tolist())) == list(range(targets.n_pieces))


def test_pieces_are_no_longer_than_the_range_and_stay_in_their_cluster() -> None:
    cut = 0
    for view, length in random_views(80):
        targets = find_targets(view, positions_for(view))
        everything = [divmod(cell, view.lattice.cols) for cell in targets.cells.tolist()]
        clusters = components(everything, None)
        cut += targets.n_pieces > len(clusters)
        for piece in pieces_of(targets, view.lattice.cols).values():
            for line in zip(*piece, strict=True):
                assert max(line) - min(line) < length
            assert any(cluster.issuperset(piece) for cluster in clusters)
    assert cut > 20


def test_neighbours_in_one_block_are_not_cut_apart() -> None:
    for view, length in random_views(80):
        targets = find_targets(view, positions_for(view))
        everything = [divmod(cell, view.lattice.cols) for cell in targets.cells.tolist()]
        piece_of = dict(zip(everything, targets.piece.tolist(), strict=True))
        for part in components(everything, length):
            assert len({piece_of[cell] for cell in part}) == 1


@pytest.mark.parametrize("seed", range(3))
def test_pieces_of_a_real_map_are_connected(seed: int) -> None:
    view, _, _ = explored("cave", 30, robots=3, seed=seed)
    targets = find_targets(view, np.array([view.cell], np.int32))
    for piece in pieces_of(targets, view.lattice.cols).values():
        assert len(components(piece, None)) == 1


def test_pieces_are_connected_where_a_cluster_leaves_a_block_and_comes_back() -> None:
    # A U whose bottom lies in the next block: its two arms are two places to go to.
    art = ["X.X.", "X.X.", "X.X.", "X.X.", "XXX.", "...."]
    wanted = np.array([[cell == "X" for cell in line] for line in art])
    view = made_up(wanted, np.zeros(wanted.shape, np.uint8), 4.0)
    targets = find_targets(view, np.array([0], np.int32))
    pieces = pieces_of(targets, 4).values()
    assert all(len(components(piece, None)) == 1 for piece in pieces)
    assert sorted(len(piece) for piece in pieces) == [3, 4, 4]


def test_a_long_wall_of_targets_is_cut_by_hand() -> None:
    wanted = np.ones((1, 10), bool)
    view = made_up(wanted, np.full((1, 10), 5, np.uint8) & [[1] + [5] * 8 + [4]], 4.9)
    view.belief.moves = np.ascontiguousarray(view.belief.moves.astype(np.uint8))
    view.belief.ground = ground_of(view.belief.moves)
    targets = find_targets(view, np.array([1, 9], np.int32))
    assert targets.n_pieces == 3
    assert targets.piece.tolist() == [0] * 4 + [1] * 4 + [2] * 2
    assert targets.costs[0].tolist() == [1, 0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert targets.piece_costs().tolist() == [[0, 3, 7], [6, 2, 0]]
    assert [targets.nearest_in(0, piece) for piece in range(3)] == [1, 4, 8]
    assert [targets.nearest_in(1, piece) for piece in range(3)] == [3, 7, 9]


def test_a_piece_costs_what_its_nearest_target_costs() -> None:
    ties = 0
    for view, _ in random_views(60):
        positions = positions_for(view)
        targets = find_targets(view, positions)
        costs = targets.piece_costs()
        assert costs.shape == (len(positions), targets.n_pieces)
        for robot in range(len(positions)):
            for piece in range(targets.n_pieces):
                inside = [
                    (cost, cell)
                    for cost, cell, of in zip(
                        targets.costs[robot].tolist(),
                        targets.cells.tolist(),
                        targets.piece.tolist(),
                        strict=True,
                    )
                    if of == piece
                ]
                assert costs[robot, piece] == min(inside)[0]
                assert targets.nearest_in(robot, piece) == min(inside)[1]
                lowest = [cost for cost, _ in inside if cost == min(inside)[0]]
                ties += len(lowest) > 1
    assert ties > 100


def test_no_targets() -> None:
    view = made_up(np.zeros((3, 4), bool), np.zeros((3, 4), np.uint8), 2.0)
    targets = find_targets(view, np.array([0, 5], np.int32))
    assert targets.n_pieces == 0
    assert targets.costs.shape == (2, 0)
    assert targets.piece_costs().shape == (2, 0)
