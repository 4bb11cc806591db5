"""Lanes over a map and the pieces of them that are unknown, against slow twins and by hand."""

from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration.lane_pieces import (
    Lanes,
    Piece,
    find_pieces,
    lay_lanes,
    looks_like_wall,
    wanted_cells,
)
from conav.exploration.rectangle_drive import half_footprint
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import Lattice, planning_grid

RATIOS = (1.0, 2.5, 3.0)
SEEDS = st.integers(0, 2**32 - 1)


def lattice_of(rows: int, cols: int, ratio: float = 1.0) -> Lattice:
    """Map cells are 1 m."""
    grid = OccupancyGrid(np.zeros((rows, cols), dtype=np.uint8), 1.0)
    return planning_grid(grid, cell_m=ratio).lattice


def no_cuts(lanes: Lanes) -> list[list[int]]:
    return [[] for _ in lanes.middle]


def along_is_row(lanes: Lanes, wanted: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return wanted if lanes.axis == 0 else wanted.T


worlds = st.tuples(
    st.sampled_from(RATIOS), st.integers(4, 70), st.integers(4, 70), st.sampled_from((0, 1))
)


# --- lanes ------------------------------------------------------------------------------------


@settings(deadline=None)
@given(worlds, st.floats(0.0, 20.0))
def test_lanes_cover_every_strip_once(
    world: tuple[float, int, int, int], range_fine: float
) -> None:
    ratio, rows, cols, axis = world
    lattice = lattice_of(rows, cols, ratio)
    lanes = lay_lanes(axis, range_fine, lattice)
    strip_of = lattice.col_of if axis == 0 else lattice.row_of
    fine_of = lattice.fine_col if axis == 0 else lattice.fine_row
    most = 2 * half_footprint(range_fine, lattice) + 1
    assert lanes.edges[0] == 0
    assert lanes.edges[-1] == len(strip_of)
    strips: list[int] = []
    widths: list[int] = []
    for lane, middle in enumerate(lanes.middle.tolist()):
        inside = sorted(set(strip_of[lanes.edges[lane] : lanes.edges[lane + 1]].tolist()))
        assert 1 <= len(inside) <= most
        assert middle in inside
        assert abs((inside[0] + inside[-1]) / 2 - middle) <= 0.5
        assert lanes.fine_middle[lane] == fine_of[middle]
        strips += inside
        widths.append(len(inside))
    assert strips == list(range(len(fine_of)))  # each once, and whole
    assert max(widths) - min(widths) <= 1
    assert lanes.width == max(b - a for a, b in zip(lanes.edges, lanes.edges[1:], strict=False))
    if ratio == 1.0:
        assert len(widths) == -(-len(fine_of) // most)


@settings(deadline=None)
@given(worlds, st.floats(0.0, 20.0))
def test_all_of_a_lane_is_seen_from_its_middle_line(
    world: tuple[float, int, int, int], range_fine: float
) -> None:
    """Unless it is a single strip: with a range less than that nothing helps."""
    ratio, rows, cols, axis = world
    lattice = lattice_of(rows, cols, ratio)
    lanes = lay_lanes(axis, range_fine, lattice)
    centres = lattice.fine_row if axis == 0 else lattice.fine_col
    strips = lattice.cols if axis == 0 else lattice.rows
    if len(lanes.middle) == strips:
        return
    along = np.arange(rows if axis == 0 else cols)
    nearest = np.abs(along[:, None] - centres[None, :]).min(axis=1)
    for lane, middle in enumerate(lanes.fine_middle.tolist()):
        side = np.abs(np.arange(lanes.edges[lane], lanes.edges[lane + 1]) - middle)
        assert (nearest[:, None] ** 2 + side[None, :] ** 2 <= range_fine**2).all()


def test_lanes_by_hand() -> None:
    # 20 strips and lanes of at most 2 * 4 + 1 = 9: three of 6, 7 and 7.
    lanes = lay_lanes(0, 4.0, lattice_of(11, 20))
    assert lanes.edges.tolist() == [0, 6, 13, 20]
    assert lanes.middle.tolist() == [2, 9, 16]
    assert lanes.fine_middle.tolist() == [2, 9, 16]
    assert lanes.limits.tolist() == [4, 3, 3, 2, 0]
    assert lanes.width == 7
    assert lanes.beside(5) == [0, 1]  # nearer to 2 than to 9
    assert lanes.beside(10) == [0, 1, 2]
    assert lanes.beside(19) == [1, 2]


def test_edges_of_a_lane_are_seen_between_centres() -> None:
    # A range of 7 sees 15 cells, five strips of 3. But at 7 to the side it sees one row only, and a
    # robot looks from every third: lanes of five strips, and of four, would leave the others out.
    lanes = lay_lanes(0, 7.0, lattice_of(12, 30, 3.0))
    assert np.diff(lanes.edges).tolist() == [6, 9, 6, 9]
    lanes = lay_lanes(0, 7.1, lattice_of(12, 30, 3.0))  # 7 and 1 away is seen
    assert np.diff(lanes.edges).tolist() == [15, 15]


# --- what is wanted ---------------------------------------------------------------------------


def flood(cells: NDArray[np.uint8], starts: list[int]) -> set[int]:
    rows, cols = cells.shape
    seen = set(starts)
    left = list(starts)
    while left:
        r, c = divmod(left.pop(), cols)
        for r2, c2 in ((r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)):
            there = r2 * cols + c2
            if not (0 <= r2 < rows and 0 <= c2 < cols) or there in seen:
                continue
            if cells[r2, c2] != OCCUPIED:
                seen.add(there)
                left.append(there)
    return seen


def random_cells(seed: int, most: int = 14) -> tuple[np.random.Generator, NDArray[np.uint8]]:
    rng = np.random.default_rng(seed)
    shape = rng.integers(1, most, 2)
    weights = rng.dirichlet([1.0, 1.0, 1.0])
    values = np.array([FREE, OCCUPIED, UNKNOWN], dtype=np.uint8)
    return rng, rng.choice(values, size=shape, p=weights)


@settings(deadline=None)
@given(SEEDS)
def test_wanted_is_unknown_reachable_and_not_given_up(seed: int) -> None:
    rng, cells = random_cells(seed)
    free = np.flatnonzero(cells.reshape(-1) == FREE)
    if len(free) == 0:
        return
    starts = rng.choice(free, size=2).tolist()
    given_up = (rng.random(cells.shape) < 0.3).astype(np.uint8)
    wanted = wanted_cells(cells, starts, given_up).reshape(-1)
    reached = flood(cells, starts)
    for cell in range(cells.size):
        expected = (
            cell in reached
            and cells.reshape(-1)[cell] == UNKNOWN
            and not given_up.reshape(-1)[cell]
        )
        assert wanted[cell] == expected


def test_what_is_walled_off_is_not_wanted() -> None:
    cells = np.full((5, 9), UNKNOWN, dtype=np.uint8)
    cells[2, 0] = FREE
    cells[:, 4] = OCCUPIED
    given_up = np.zeros_like(cells)
    given_up[0, :2] = 1
    wanted = wanted_cells(cells, [18], given_up)
    assert wanted[:, 4:].sum() == 0
    assert wanted[:, :4].sum() == 20 - 1 - 2
    cells[0, 4] = UNKNOWN  # a gap that may be there
    assert wanted_cells(cells, [18], given_up)[:, 5:].sum() == 20


def slow_looks_like_wall(
    cells: NDArray[np.uint8], row: int, col: int, around: int, least: int
) -> bool:
    def at(r: int, c: int) -> int:
        inside = 0 <= r < cells.shape[0] and 0 <= c < cells.shape[1]
        return int(cells[r, c]) if inside else -1

    for r, c in product(
        range(row - around, row + around + 1), range(col - around, col + around + 1)
    ):
        if at(r, c) != UNKNOWN:
            continue
        faces = [
            (dr, dc) for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)) if at(r + dr, c + dc) == FREE
        ]
        ends = [
            all(at(r + i * sign * dc, c + i * sign * dr) == OCCUPIED for i in range(1, least + 1))
            for dr, dc in faces
            for sign in (1, -1)
        ]
        if faces and not any(ends):
            return False
    return True


@settings(deadline=None)
@given(SEEDS)
def test_looks_like_wall_against_its_twin(seed: int) -> None:
    rng, cells = random_cells(seed)
    if rng.random() < 0.5:  # walls are long
        cells[int(rng.integers(cells.shape[0]))] = OCCUPIED
        cells[rng.random(cells.shape) < 0.05] = UNKNOWN
    r, c = (int(rng.integers(size)) for size in cells.shape)
    around, least = int(rng.integers(0, 5)), int(rng.integers(1, 5))
    expected = slow_looks_like_wall(cells, r, c, around, least)
    assert looks_like_wall(cells, r, c, around, least) == expected


def test_the_end_of_a_wall_and_the_door_beside_it() -> None:
    cells = np.full((6, 12), FREE, dtype=np.uint8)
    cells[4] = OCCUPIED
    cells[5] = UNKNOWN  # behind the wall
    cells[4, 10:] = UNKNOWN  # seen from the lane so far
    cells[3, 11] = UNKNOWN
    assert not looks_like_wall(cells, 4, 10, 2, 4)  # (3, 11) is no wall's
    cells[3, 11] = OCCUPIED
    assert looks_like_wall(cells, 4, 10, 2, 4)
    assert not looks_like_wall(cells, 4, 10, 2, 11)  # not so long a wall
    cells[4, 10] = FREE
    cells[4, 11] = OCCUPIED
    assert not looks_like_wall(cells, 4, 10, 2, 4)  # a door: unknown beyond it
    assert looks_like_wall(cells, 0, 0, 2, 4)  # nothing unknown there


# --- pieces -----------------------------------------------------------------------------------


def looked_at(lanes: Lanes, pieces: list[Piece], lattice: Lattice, range_fine: float) -> NDArray:
    """What a disc sensor sees in all drives from begin to end, along the lanes as rows."""
    fine_along = lattice.fine_row if lanes.axis == 0 else lattice.fine_col
    shape = (lattice.fine_rows, lattice.fine_cols)
    along, across = np.indices(shape if lanes.axis == 0 else shape[::-1])
    seen = np.zeros(along.shape, dtype=bool)
    for piece in pieces:
        for place in range(piece.begin, piece.end + 1):
            off = (along - fine_along[place]) ** 2
            off = off + (across - lanes.fine_middle[piece.lane]) ** 2
            # Each lane by itself: nothing is left to neighbours.
            strip = slice(lanes.edges[piece.lane], lanes.edges[piece.lane + 1])
            seen[:, strip] |= off[:, strip] <= range_fine**2
    return seen


@settings(max_examples=150, deadline=None)
@given(worlds, st.floats(2.5, 12.0), SEEDS)
def test_driving_all_pieces_shows_all_that_is_wanted(
    world: tuple[float, int, int, int], range_fine: float, seed: int
) -> None:
    ratio, rows, cols, axis = world
    lattice = lattice_of(rows, cols, ratio)
    rng = np.random.default_rng(seed)
    lanes = lay_lanes(axis, range_fine, lattice)
    if len(lanes.middle) == (lattice.cols if axis == 0 else lattice.rows):
        return  # strips may be wider than is seen
    wanted = (rng.random((rows, cols)) < rng.choice([0.02, 0.3, 1.0])).astype(np.uint8)
    for _ in range(int(rng.integers(0, 4))):  # known discs
        r, c = rng.integers(rows), rng.integers(cols)
        row, col = np.indices(wanted.shape)
        wanted[(row - r) ** 2 + (col - c) ** 2 <= rng.uniform(1, 15) ** 2] = 0
    before = wanted.copy()
    length = lattice.rows if axis == 0 else lattice.cols
    cuts = [rng.integers(0, length, int(rng.integers(0, 3))).tolist() for _ in lanes.middle]
    most = int(rng.integers(1, length + 2))
    pieces = find_pieces(lanes, wanted, lattice, cuts, most)

    oriented, seen = along_is_row(lanes, wanted), looked_at(lanes, pieces, lattice, range_fine)
    assert not (oriented.astype(bool) & ~seen).any()
    assert (wanted <= before).all()
    longest = max(int(most * ratio), lanes.width)
    last: dict[int, int] = {}
    for piece in pieces:
        assert 0 <= piece.low <= piece.high < length
        assert 0 <= piece.begin <= piece.end < length
        assert (piece.high - piece.low - 1) * ratio <= longest
        assert last.get(piece.lane, -1) < piece.low  # they share no planning cell
        last[piece.lane] = piece.high
    assert [piece.lane for piece in pieces] == sorted(piece.lane for piece in pieces)
    # Every wanted row is in a piece of its lane; rows taken out are in none.
    along_of = lattice.row_of if axis == 0 else lattice.col_of
    for lane in range(len(lanes.middle)):
        strip = slice(lanes.edges[lane], lanes.edges[lane + 1])
        for row in np.flatnonzero(oriented[:, strip].any(axis=1)):
            inside = [p for p in pieces if p.lane == lane and p.low <= along_of[row] <= p.high]
            assert inside


@settings(deadline=None)
@given(worlds, st.floats(2.5, 12.0), SEEDS)
def test_runs_of_less_than_a_row_are_taken_out_and_no_others(
    world: tuple[float, int, int, int], range_fine: float, seed: int
) -> None:
    ratio, rows, cols, axis = world
    lattice = lattice_of(rows, cols, ratio)
    rng = np.random.default_rng(seed)
    lanes = lay_lanes(axis, range_fine, lattice)
    wanted = (rng.random((rows, cols)) < 0.03).astype(np.uint8)
    before = along_is_row(lanes, wanted).copy()
    find_pieces(lanes, wanted, lattice, no_cuts(lanes), 100)
    after = along_is_row(lanes, wanted)
    for lane in range(len(lanes.middle)):
        strip = slice(lanes.edges[lane], lanes.edges[lane + 1])
        runs: list[list[int]] = []
        for row in np.flatnonzero(before[:, strip].any(axis=1)).tolist():
            if runs and row - runs[-1][-1] <= lanes.width:
                runs[-1].append(row)
            else:
                runs.append([row])
        for run in runs:
            part = before[run[0] : run[-1] + 1, strip]
            expected = part if part.sum() >= lanes.width else np.zeros_like(part)
            assert np.array_equal(after[run[0] : run[-1] + 1, strip], expected)


def one_lane() -> tuple[Lanes, Lattice]:
    """A lane of 9 cells along 40 rows, and a range of 5: chords of 5, 4, 4, 4 and 3."""
    lattice = lattice_of(40, 9)
    lanes = lay_lanes(0, 5.0, lattice)
    assert lanes.middle.tolist() == [4]
    assert lanes.limits.tolist() == [5, 4, 4, 4, 3, 0]
    return lanes, lattice


def pieces_of(rows: slice, cols: slice, cuts: list[int] = [], most: int = 100) -> list[Piece]:  # noqa: B006
    lanes, lattice = one_lane()
    wanted = np.zeros((40, 9), dtype=np.uint8)
    wanted[rows, cols] = 1
    return find_pieces(lanes, wanted, lattice, [cuts], most)


def test_chords_by_hand() -> None:
    # A whole lane: its corners are seen from 3 before the ends.
    assert pieces_of(slice(0, 40), slice(0, 9)) == [Piece(0, 0, 39, 3, 36)]
    # Only what is near the middle line: from 5 before.
    assert pieces_of(slice(10, 31), slice(4, 5)) == [Piece(0, 10, 30, 15, 25)]
    # To one side, 3 and 2 away: from 4.
    assert pieces_of(slice(10, 31), slice(6, 8)) == [Piece(0, 10, 30, 14, 26)]
    # Eight rows are seen from one place in the middle, nine from one too, as 14 + 5 is seen twice.
    assert pieces_of(slice(10, 12), slice(0, 9)) == [Piece(0, 10, 11, 10, 10)]
    assert pieces_of(slice(10, 17), slice(0, 9)) == [Piece(0, 10, 16, 13, 13)]
    assert pieces_of(slice(10, 18), slice(0, 9)) == [Piece(0, 10, 17, 13, 14)]


def test_the_first_row_may_be_near_the_middle_and_the_second_at_the_side() -> None:
    lanes, lattice = one_lane()
    wanted = np.zeros((40, 9), dtype=np.uint8)
    wanted[10, 4] = 1
    wanted[11:30, 0] = 1
    wanted[30, 4] = 1
    # Row 10 is seen from 15 on, row 11 from 14 only; row 30 from 25, row 29 from 26.
    assert find_pieces(lanes, wanted, lattice, [[]], 100) == [Piece(0, 10, 30, 14, 26)]


def test_gaps_cuts_and_equal_parts() -> None:
    lanes, lattice = one_lane()
    wanted = np.zeros((40, 9), dtype=np.uint8)
    wanted[0:5] = 1
    wanted[13:18] = 1  # 9 after row 4: as far as the lane is wide
    wanted[27:40] = 1  # 10 after row 17
    found = find_pieces(lanes, wanted, lattice, [[]], 100)
    assert [(piece.low, piece.high) for piece in found] == [(0, 17), (27, 39)]
    # Cuts stay, but for those that would leave less than half a width.
    found = find_pieces(lanes, wanted, lattice, [[13, 2, 33, 36]], 100)
    assert [(p.low, p.high) for p in found] == [(0, 4), (13, 17), (27, 32), (33, 39)]
    # 40 rows in parts of at most 15: three of 13, 13 and 14.
    found = pieces_of(slice(0, 40), slice(0, 9), most=15)
    assert [(p.low, p.high) for p in found] == [(0, 12), (13, 25), (26, 39)]
    # Shorter than the lane is wide they are not made.
    assert len(pieces_of(slice(0, 36), slice(0, 9), most=1)) == 4


def test_planning_cells_larger_than_map_cells() -> None:
    """Centres are at map rows 1, 4, 7, ...: a drive starts at one from which the first is seen."""
    lattice = lattice_of(60, 9, 3.0)
    lanes = lay_lanes(0, 5.0, lattice)
    assert lanes.fine_middle.tolist() == [4]
    wanted = np.zeros((60, 9), dtype=np.uint8)
    wanted[9:51] = 1
    # Row 9 is seen at the sides from 12 on: from the centre at 10, not from 13. Row 50 from 47 on:
    # from the centre at 49, not from 46.
    assert find_pieces(lanes, wanted, lattice, [[]], 100) == [Piece(0, 3, 16, 3, 16)]


def test_axis_1_is_axis_0_turned() -> None:
    rng = np.random.default_rng(5)
    wanted = (rng.random((37, 53)) < 0.2).astype(np.uint8)
    turned = np.ascontiguousarray(wanted.T)
    one, two = lattice_of(37, 53, 2.5), lattice_of(53, 37, 2.5)
    first, second = lay_lanes(0, 6.0, one), lay_lanes(1, 6.0, two)
    cuts = [[2 * lane + 1] for lane in range(len(first.middle))]
    assert find_pieces(first, wanted, one, cuts, 7) == find_pieces(second, turned, two, cuts, 7)
    assert np.array_equal(wanted.T, turned)


def test_nothing_wanted_no_pieces() -> None:
    assert pieces_of(slice(0, 0), slice(0, 0)) == []
    assert pieces_of(slice(7, 8), slice(0, 8)) == []  # less than a row
    assert pieces_of(slice(7, 8), slice(0, 9)) == [Piece(0, 7, 7, 7, 7)]
