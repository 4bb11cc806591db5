"""Beliefs kept up to date scan by scan against the same layers made from scratch."""

import pickle
from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from conav.exploration.belief import BLOCK, OPEN, STOOD, TARGET, Belief, new_scratch
from conav.exploration.nearest import Nearest
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import (
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
    visible_cells,
)
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import new_world


class Scan(NamedTuple):
    cell: int
    seen: np.ndarray


def looks(plan: PlanningGrid, cells: list[int], reach: float) -> list[Scan]:
    """What a range sensor sees from each planning cell; repeated cells taken out."""
    limits = lateral_limits(reach)
    out = np.zeros(sight_buffer_size(limits), np.int32)
    scans = []
    for cell in cells:
        row, col = divmod(cell, plan.lattice.cols)
        count = visible_cells(
            plan.walls,
            int(plan.lattice.fine_row[row]),
            int(plan.lattice.fine_col[col]),
            limits,
            new_gap_space(limits),
            new_gap_space(limits),
            out,
        )
        scans.append(Scan(cell, np.unique(out[:count]).astype(np.int32)))
    return scans


def believe(plan: PlanningGrid, scans: list[Scan]) -> Belief:
    belief = Belief(plan)
    scratch = new_scratch(plan)
    for scan in scans:
        before = int(np.count_nonzero(belief.cells != UNKNOWN))
        fresh = belief.hear(plan, scan.cell, scan.seen, scratch)
        after = int(np.count_nonzero(belief.cells != UNKNOWN))
        assert fresh == after - before
    return belief


def gap_square(px: float, py: float, a: tuple[float, float], b: tuple[float, float]) -> float:
    """The squared distance from a point to the segment, by its foot."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = dx * dx + dy * dy
    t = ((px - a[0]) * dx + (py - a[1]) * dy) / length if length else 0.0
    t = min(max(t, 0.0), 1.0)
    return (a[0] + t * dx - px) ** 2 + (a[1] + t * dy - py) ** 2


def check(plan: PlanningGrid, belief: Belief, scans: list[Scan]) -> None:
    """Every layer from scratch, slowly."""
    lattice = plan.lattice
    ratio, radius = lattice.ratio, plan.radius_fine
    known = np.zeros(plan.walls.shape, bool)
    for scan in scans:
        known.reshape(-1)[scan.seen] = True
    cells = np.where(known, plan.walls, UNKNOWN)
    assert np.array_equal(belief.cells, cells)
    assert belief.known == known.sum()

    frontier = np.zeros_like(cells)
    for r, c in np.argwhere(cells == FREE):
        around = [(r, c + 1), (r, c - 1), (r + 1, c), (r - 1, c)]
        frontier[r, c] = any(
            0 <= r2 < cells.shape[0] and 0 <= c2 < cells.shape[1] and cells[r2, c2] == UNKNOWN
            for r2, c2 in around
        )
    assert np.array_equal(belief.frontier, frontier)

    # Frontier cells in the planning cells that the disc at a centre reaches into.
    reach = int(np.ceil(max(0.0, radius - 0.5 * ratio) / ratio))
    count = np.zeros(plan.moves.shape, int)
    for r, c in np.argwhere(frontier):
        r2, c2 = lattice.row_of[r], lattice.col_of[c]
        count[max(r2 - reach, 0) : r2 + reach + 1, max(c2 - reach, 0) : c2 + reach + 1] += 1
    assert np.array_equal(belief.frontier_count, count)

    stood = np.zeros(plan.moves.shape, bool)
    stood.reshape(-1)[[scan.cell for scan in scans]] = True
    assert np.array_equal(belief.marks & STOOD != 0, stood)
    assert np.array_equal(belief.stood, stood)
    assert np.array_equal(belief.marks & TARGET != 0, (count > 0) & ~stood)

    hidden = [(c + 0.5, r + 0.5) for r, c in np.argwhere(~known)]

    def swept_known(a: tuple[float, float], b: tuple[float, float]) -> bool:
        return all(gap_square(x, y, a, b) > radius * radius for x, y in hidden)

    def centre(r: int, c: int) -> tuple[float, float]:
        return (c + 0.5) * ratio, (r + 0.5) * ratio

    opened = np.zeros(plan.moves.shape, bool)
    for r, c in np.argwhere(plan.standable):
        here = known[lattice.fine_row[r], lattice.fine_col[c]]
        opened[r, c] = here and swept_known(centre(r, c), centre(r, c))
    assert np.array_equal(belief.marks & OPEN != 0, opened)
    assert belief.opened == opened.sum()
    assert not (belief.marks & ~np.uint8(OPEN | STOOD | TARGET)).any()

    moves = np.zeros_like(plan.moves)
    for (r, c), k in product(np.argwhere(opened), range(8)):
        if not plan.moves[r, c] >> k & 1:
            continue
        r2, c2 = r + DROW[k], c + DCOL[k]
        corners = k < 4 or (opened[r2, c] and opened[r, c2])
        if opened[r2, c2] and corners and swept_known(centre(r, c), centre(r2, c2)):
            moves[r, c] |= 1 << k
    assert np.array_equal(belief.moves, moves)


def random_plan(
    rng: np.random.Generator, ratio: float, radius: float, *, side: int = 9
) -> PlanningGrid:
    rows, cols = (int(rng.integers(2, side + 1)) for _ in range(2))
    cells = (rng.random((rows, cols)) < 0.2).astype(np.uint8)
    diagonal = bool(rng.integers(2))
    return planning_grid(
        OccupancyGrid(cells, 1.0), cell_m=ratio, radius_m=radius, diagonal=diagonal
    )


# Discs smaller and larger than the cell; ratios with and without a common measure.
bodies = st.sampled_from(
    [
        (1.0, 0.1),
        (1.0, 0.5),
        (1.0, 0.75),
        (1.0, 1.6),
        (2.0, 0.75),
        (2.0, 1.25),
        (3.0, 0.75),
        (3.0, 1.4),
        (1.7, 0.61),
        (1.7, 1.3),
    ]
)
# Planning cells smaller than the map's.
small = st.sampled_from([(0.5, 0.1), (0.5, 0.3), (0.5, 1.1), (0.75, 0.1), (0.6, 0.29), (0.3, 0.2)])


@settings(max_examples=120, deadline=None)
@given(st.integers(0, 2**32 - 1), bodies)
def test_layers_after_random_scans(seed: int, body: tuple[float, float]) -> None:
    """Scans of any fine cells whatever, so that every kind of gap occurs."""
    check_random_scans(seed, body)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), small)
def test_layers_over_small_planning_cells(seed: int, body: tuple[float, float]) -> None:
    check_random_scans(seed, body, side=5)


def check_random_scans(seed: int, body: tuple[float, float], *, side: int = 9) -> None:
    rng = np.random.default_rng(seed)
    plan = random_plan(rng, *body, side=side)
    scans = []
    for _ in range(int(rng.integers(1, 5))):
        shown = np.flatnonzero(rng.random(plan.walls.size) < rng.choice([0.05, 0.4, 0.9]))
        scans.append(Scan(int(rng.integers(plan.moves.size)), shown.astype(np.int32)))
        check(plan, believe(plan, scans), scans)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), bodies, st.sampled_from([1.0, 2.5, 6.0]))
def test_layers_after_looks(seed: int, body: tuple[float, float], reach: float) -> None:
    rng = np.random.default_rng(seed)
    plan = random_plan(rng, *body)
    places = np.flatnonzero(plan.standable)
    if len(places) == 0:
        return
    scans = looks(plan, rng.choice(places, 4).tolist(), reach)
    check(plan, believe(plan, scans), scans)


@pytest.mark.parametrize("ratio", [0.3, 0.25, 0.2, 0.1])
def test_layers_where_many_planning_cells_lie_in_one_fine_cell(ratio: float) -> None:
    plan = planning_grid(
        parse_ascii("#####\n#...#\n#...#\n#####"), cell_m=ratio, radius_m=0.02 * ratio
    )
    everything = [Scan(0, np.arange(plan.walls.size, dtype=np.int32))]
    belief = believe(plan, everything)
    assert np.array_equal(belief.marks & OPEN, plan.standable)
    assert np.array_equal(belief.moves, plan.moves)
    scans = looks(plan, [int(np.flatnonzero(plan.standable)[0])], 1.5)
    check(plan, believe(plan, scans), scans)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), bodies)
@example(0, (1.0, 0.1))
@example(0, (0.5, 0.1))
def test_the_order_of_scans_does_not_matter(seed: int, body: tuple[float, float]) -> None:
    rng = np.random.default_rng(seed)
    plan = random_plan(rng, *body)
    scans = [
        Scan(
            int(rng.integers(plan.moves.size)),
            np.flatnonzero(rng.random(plan.walls.size) < 0.3).astype(np.int32),
        )
        for _ in range(4)
    ]
    one = believe(plan, scans)
    other = believe(plan, [scans[i] for i in rng.permutation(4)])
    assert content(one) == content(other)


def test_what_is_heard_twice_is_not_new() -> None:
    plan = planning_grid(parse_ascii("....\n....\n...."))
    scratch = new_scratch(plan)
    belief = Belief(plan)
    assert belief.hear(plan, 0, np.array([0, 1, 4], np.int32), scratch) == 3
    assert belief.hear(plan, 1, np.array([1, 2], np.int32), scratch) == 1
    assert belief.hear(plan, 1, np.array([0, 1, 2, 4], np.int32), scratch) == 0
    assert belief.known == 4


def test_a_scan_without_news_still_counts_as_a_look() -> None:
    plan = planning_grid(parse_ascii("...."))
    belief = Belief(plan)
    scratch = new_scratch(plan)
    belief.hear(plan, 0, np.array([0, 1], np.int32), scratch)
    assert belief.marks[0, 1] & TARGET
    belief.hear(plan, 1, np.empty(0, np.int32), scratch)
    assert not belief.marks[0, 1] & TARGET
    assert belief.marks[0, 1] & STOOD
    assert belief.marks[0, 1] & OPEN


def test_by_hand() -> None:
    """A corridor of five cells, the left three known."""
    plan = planning_grid(parse_ascii("....."), diagonal=False)
    belief = Belief(plan)
    assert (belief.cells == UNKNOWN).all()
    assert belief.opened == belief.known == 0
    belief.hear(plan, 0, np.array([0, 1, 2], np.int32), new_scratch(plan))
    assert belief.cells.tolist() == [[0, 0, 0, 2, 2]]
    assert belief.frontier.tolist() == [[0, 0, 1, 0, 0]]
    assert belief.marks.tolist() == [[OPEN | STOOD, OPEN, OPEN | TARGET, 0, 0]]
    assert belief.moves.tolist() == [[1, 5, 4, 0, 0]]
    assert belief.opened == belief.known == 3


def test_one_scratch_serves_many_beliefs() -> None:
    rng = np.random.default_rng(4)
    plan = random_plan(rng, 1.0, 0.1)
    scratch = new_scratch(plan)
    beliefs = [Belief(plan) for _ in range(3)]
    heard: list[list[Scan]] = [[], [], []]
    for turn in range(12):
        scan = Scan(
            int(rng.integers(plan.moves.size)),
            np.flatnonzero(rng.random(plan.walls.size) < 0.15).astype(np.int32),
        )
        beliefs[turn % 3].hear(plan, scan.cell, scan.seen, scratch)
        heard[turn % 3].append(scan)
    for belief, scans in zip(beliefs, heard, strict=True):
        check(plan, belief, scans)


def content(belief: Belief) -> tuple[object, ...]:
    arrays = (belief.cells, belief.frontier, belief.frontier_count, belief.marks, belief.moves)
    return (
        *((array.dtype.str, array.shape, array.tobytes()) for array in arrays),
        belief.opened,
        belief.known,
    )


def half_known(plan: PlanningGrid) -> Belief:
    belief = Belief(plan)
    belief.hear(plan, 0, np.arange(plan.walls.size // 2, dtype=np.int32), new_scratch(plan))
    return belief


def test_a_copy_is_independent() -> None:
    plan = planning_grid(parse_ascii("....\n.#..\n...."))
    original = half_known(plan)
    copy = original.copy()
    before = content(original)
    assert content(copy) == before
    copy.hear(plan, 5, np.arange(plan.walls.size, dtype=np.int32), new_scratch(plan))
    assert content(original) == before
    changed = content(copy)
    original.hear(plan, 2, np.arange(8, dtype=np.int32), new_scratch(plan))
    assert content(copy) == changed


def test_pickling_keeps_everything() -> None:
    plan = planning_grid(parse_ascii("....\n.#..\n...."))
    original = half_known(plan)
    restored = pickle.loads(pickle.dumps(original))
    assert content(restored) == content(original)
    rest = np.arange(plan.walls.size, dtype=np.int32)
    for belief in (original, restored):
        belief.hear(plan, 3, rest, new_scratch(plan))
    assert content(restored) == content(original)
    everything = [Scan(0, np.arange(plan.walls.size // 2)), Scan(3, rest)]
    check(plan, restored, everything)


def test_pickling_keeps_who_shares() -> None:
    belief = half_known(planning_grid(parse_ascii("....")))
    one, other = pickle.loads(pickle.dumps([belief, belief]))
    assert one is other


@pytest.mark.parametrize(
    "make", [lambda b: b, Belief.copy, lambda b: pickle.loads(pickle.dumps(b))]
)
def test_minds_cannot_write(make) -> None:
    belief = make(half_known(planning_grid(parse_ascii("...."))))
    for layer in (
        belief.cells,
        belief.frontier,
        belief.frontier_count,
        belief.marks,
        belief.moves,
    ):
        with pytest.raises(ValueError, match="read-only"):
            layer[0, 0] = 1


def test_the_arrays_handed_out_stay_current() -> None:
    plan = planning_grid(parse_ascii("...."))
    belief = Belief(plan)
    cells = belief.cells
    belief.hear(plan, 0, np.array([0], np.int32), new_scratch(plan))
    assert cells[0, 0] == FREE


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1.5, 3.0, 6.0]))
def test_frontiers_of_merged_beliefs(seed: int, radio: float) -> None:
    """Robots that part and meet again: each one's frontier is that of the scans it holds."""
    rng = np.random.default_rng(seed)
    rows, cols = (int(rng.integers(5, 14)) for _ in range(2))
    cells = (rng.random((rows, cols)) < 0.2).astype(np.uint8)
    cells[0, :3] = 0
    grid = OccupancyGrid(cells, 1.0)
    starts = [(0.5, 0.5), (1.5, 0.5), (2.5, 0.5)]
    options = {"robots": 3, "starts": starts, "cell_m": 1.0, "radius_m": 0.1, "range_m": 2.5}
    problem, _ = exploration_problem(grid, radio=radio, seed=seed, **options)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Nearest(), seen)
    engine = engine_for(state)
    for _ in range(25):
        events = engine.sense_and_decide(state, [])
        for robot, belief in enumerate(state.beliefs):
            known = np.zeros(cells.shape, bool)
            for origin, count in enumerate(state.held[robot]):
                for scan in state.scans[origin][:count]:
                    known.reshape(-1)[scan.seen] = True
            frontier = np.zeros(cells.shape, np.uint8)
            for r, c in np.argwhere(known & (problem.plan.walls == FREE)):
                around = [(r, c + 1), (r, c - 1), (r + 1, c), (r - 1, c)]
                frontier[r, c] = any(
                    0 <= r2 < rows and 0 <= c2 < cols and not known[r2, c2] for r2, c2 in around
                )
            assert np.array_equal(belief.cells != UNKNOWN, known)
            assert np.array_equal(belief.frontier, frontier)
        engine.move(state, events.actions)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), bodies)
def test_changes_are_counted_where_they_happen(seed: int, body: tuple[float, float]) -> None:
    """A block whose number has not grown shows the same cells, open places and scans."""
    rng = np.random.default_rng(seed)
    ratio, radius = body
    grid = OccupancyGrid((rng.random((70, 70)) < 0.05).astype(np.uint8), 1.0)
    plan = planning_grid(grid, cell_m=ratio, radius_m=radius)
    belief = Belief(plan)
    scratch = new_scratch(plan)
    lattice = plan.lattice
    fine = np.arange(70) // BLOCK
    rows, cols = lattice.fine_row // BLOCK, lattice.fine_col // BLOCK
    still = 0
    for _ in range(5):
        before = belief.copy()
        corner = rng.integers(0, 60, 2)
        seen = np.zeros((70, 70), bool)
        seen[corner[0] : corner[0] + 20, corner[1] : corner[1] + 20] = True
        place = int(rng.integers(plan.moves.size))
        belief.hear(plan, place, np.flatnonzero(seen).astype(np.int32), scratch)
        assert (belief.changes >= before.changes).all()
        for r, c in np.argwhere(belief.changes == before.changes):
            still += 1
            inside = np.ix_(fine == r, fine == c)
            assert np.array_equal(belief.cells[inside], before.cells[inside])
            places = np.ix_(rows == r, cols == c)
            both = np.uint8(OPEN | STOOD)
            assert np.array_equal(belief.marks[places] & both, before.marks[places] & both)
    assert still > 0
