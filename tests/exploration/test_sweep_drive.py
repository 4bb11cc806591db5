"""Sweeps driven in small worlds: along the lane, round what is in the way, and given up."""

import pickle
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration import sweep_drive
from conav.exploration.belief import OPEN, Belief, new_scratch
from conav.exploration.rectangle_drive import half_footprint
from conav.exploration.sweep_drive import (
    PATIENCE,
    Sweep,
    SweepDrive,
    next_move,
    place_of,
    presumed_moves,
    swept,
)
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW, OPPOSITE
from conav.geometry.sight import segment_is_clear
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor

SEEDS = st.integers(0, 2**32 - 1)


@dataclass
class World:
    """One robot that looks and drives by hand; everything is in planning cells."""

    plan: PlanningGrid
    body: Robot
    belief: Belief
    row: int
    col: int
    step: int = 0

    @property
    def cell(self) -> int:
        return self.row * self.plan.lattice.cols + self.col

    def look(self) -> None:
        lattice, walls = self.plan.lattice, self.plan.walls
        r, c = int(lattice.fine_row[self.row]), int(lattice.fine_col[self.col])
        reach = self.body.sensor.range_m / lattice.resolution
        seen = [
            y * lattice.fine_cols + x
            for y, x in np.ndindex(walls.shape)
            if (y - r) ** 2 + (x - c) ** 2 <= reach**2 and segment_is_clear(walls, y, x, r, c)
        ]
        self.belief.hear(
            self.plan, self.cell, np.array(seen, dtype=np.int32), new_scratch(self.plan)
        )

    def view(self) -> TeamView:
        here = np.array([self.cell], dtype=np.int32)
        now = np.array([self.step], dtype=np.int32)
        return TeamView(
            self.step,
            float(self.step),
            0,
            self.body,
            self.cell,
            0,
            self.belief,
            self.plan.lattice,
            here,
            now,
            np.ones(1, dtype=np.bool_),
        )

    def go(self, k: int) -> None:
        assert self.belief.moves[self.row, self.col] >> k & 1
        self.row += DROW[k]
        self.col += DCOL[k]
        self.step += 1
        self.look()

    def drive(self, drive: SweepDrive, most: int = 400) -> list[tuple[int, int]]:
        """Where it came by until the sweep was over."""
        places = [(self.row, self.col)]
        for _ in range(most):
            k = next_move(drive, self.view())
            if k < 0:
                return places
            self.go(k)
            places.append((self.row, self.col))
        raise AssertionError("it drives for ever")


def world(
    walls: NDArray[np.uint8],
    row: int,
    col: int,
    *,
    range_m: float = 3.0,
    cell_m: float = 1.0,
    radius_m: float = 0.1,
    motion: str = "8-connected",
) -> World:
    """Map cells are 1 m."""
    model = MOTIONS[motion]
    plan = planning_grid(
        OccupancyGrid(walls, 1.0), cell_m=cell_m, radius_m=radius_m, diagonal=model.diagonal
    )
    body = Robot("robot_0", radius_m=radius_m, motion=model, sensor=Sensor("range", True, range_m))
    made = World(plan, body, Belief(plan), row, col)
    made.look()
    return made


def empty(rows: int = 30, cols: int = 20) -> NDArray[np.uint8]:
    return np.zeros((rows, cols), dtype=np.uint8)


def turned(cells: NDArray[np.uint8], axis: int) -> NDArray[np.uint8]:
    return cells if axis == 0 else np.ascontiguousarray(cells.T)


def place(axis: int, along: int, across: int) -> tuple[int, int]:
    return (along, across) if axis == 0 else (across, along)


# --- in the open ------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["8-connected", "4-connected"])
@pytest.mark.parametrize(("begin", "end"), [(5, 25), (25, 5), (12, 12)])
@pytest.mark.parametrize("axis", [0, 1])
def test_to_where_it_begins_and_on_to_the_end(axis: int, begin: int, end: int, motion: str) -> None:
    made = world(turned(empty(), axis), *place(axis, 9, 3), motion=motion)
    sweep = Sweep(axis, 12, begin, end, min(begin, end) - 2, max(begin, end) + 2)
    drive = SweepDrive(sweep)
    places = made.drive(drive)
    first = places.index(place(axis, begin, 12))
    heading = 1 if end >= begin else -1
    assert places[first:] == [
        place(axis, along, 12) for along in range(begin, end + heading, heading)
    ]
    down, right = abs(begin - 9), 9
    assert first == (max(down, right) if motion == "8-connected" else down + right)
    assert drive.sweeping
    assert place_of(drive, made.view()) == made.cell
    assert swept(drive, made.view()) == sweep


@pytest.mark.parametrize("axis", [0, 1])
def test_it_heads_for_the_last_place_it_knows_on_its_way(axis: int) -> None:
    made = world(turned(empty(), axis), *place(axis, 5, 3), motion="4-connected")
    drive = SweepDrive(Sweep(axis, 9, 5, 12, 5, 12))
    aims: list[tuple[int, int]] = []
    while (k := next_move(drive, made.view())) >= 0:
        aims.append(divmod(place_of(drive, made.view()), made.plan.lattice.cols))
        row, col = aims[-1]
        assert made.belief.marks[row, col] & OPEN
        made.go(k)
    # It sees 3 ahead, first across to where it begins, then along the lane.
    across = [place(axis, 5, min(col, 9)) for col in range(6, 12)]
    assert aims == across + [place(axis, min(along, 12), 9) for along in range(8, 15)]


def test_it_begins_at_once_where_it_stands() -> None:
    made = world(empty(), 5, 9)
    assert made.drive(SweepDrive(Sweep(0, 9, 5, 8, 5, 8))) == [(5, 9), (6, 9), (7, 9), (8, 9)]
    assert made.drive(SweepDrive(Sweep(0, 9, 8, 8, 6, 9))) == [(8, 9)]


def test_a_drive_pickles_in_the_middle() -> None:
    made = world(empty(), 9, 3)
    drive = SweepDrive(Sweep(0, 12, 5, 25, 3, 27))
    for _ in range(4):
        made.go(next_move(drive, made.view()))
    again = pickle.loads(pickle.dumps((made, drive)))
    assert again[0].drive(again[1]) == made.drive(drive)


def test_it_goes_on_as_it_does_when_ordered_the_same() -> None:
    made = world(empty(), 5, 9)
    sweep = Sweep(0, 9, 5, 20, 2, 22)
    drive = SweepDrive(sweep)
    assert not drive.goes_on_as(sweep)  # on the way to where it begins it may go elsewhere
    made.go(next_move(drive, made.view()))
    assert drive.goes_on_as(sweep)
    assert drive.goes_on_as(replace(sweep, begin=6, low=6))  # the rest of it
    assert not drive.goes_on_as(replace(sweep, end=19))
    assert not drive.goes_on_as(replace(sweep, across=8))
    assert not drive.goes_on_as(replace(sweep, axis=1))
    assert sweep.size_bytes == 21


# --- in the way -------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["8-connected", "4-connected"])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("begin", [2, 27])
def test_round_an_obstacle_and_back_to_the_lane(begin: int, axis: int, motion: str) -> None:
    cells = empty()
    cells[12:15, 8:12] = OCCUPIED
    end = 29 - begin
    made = world(turned(cells, axis), *place(axis, begin, 10), motion=motion)
    drive = SweepDrive(Sweep(axis, 10, begin, end, min(begin, end), max(begin, end)))
    places = made.drive(drive)
    assert places[-1] == place(axis, end, 10)
    for along in (*range(2, 10), *range(17, 28)):  # off the lane near the obstacle only
        assert place(axis, along, 10) in places
    assert len(places) <= 26 + (4 if motion == "8-connected" else 8)


def test_round_a_wall_that_is_longer_than_it_looks() -> None:
    cells = empty()
    cells[12, 1:] = OCCUPIED  # one gap, at the far end
    made = world(cells, 2, 15)
    places = made.drive(SweepDrive(Sweep(0, 15, 2, 25, 2, 25)))
    assert (12, 0) in places
    assert places[-1] == (25, 15)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("back", [False, True])
def test_blocked_for_good(axis: int, back: bool) -> None:
    cells = empty()
    cells[12] = OCCUPIED
    begin, end = (27, 2) if back else (2, 27)
    made = world(turned(cells, axis), *place(axis, begin, 10))
    sweep = Sweep(axis, 10, begin, end, 0, 29)
    drive = SweepDrive(sweep)
    made.drive(drive)
    along = made.row if axis == 0 else made.col
    half = half_footprint(3.0, made.plan.lattice)
    assert half == 3
    told = swept(drive, made.view())
    expected = replace(sweep, low=along - half) if back else replace(sweep, high=along + half)
    assert told == expected
    assert abs(along - 12) <= 2
    # What it could not get to is not swept, so somebody else may come from the other side.
    assert told.low >= 9 if back else told.high <= 15


def test_what_was_swept_never_reaches_beyond_the_piece() -> None:
    made = world(empty(), 15, 9)
    sweep = Sweep(0, 9, 5, 17, 4, 17)
    drive = SweepDrive(sweep, sweeping=True)
    assert swept(drive, made.view()) == replace(sweep, high=17)
    back = Sweep(0, 9, 20, 13, 13, 24)
    assert swept(SweepDrive(back, sweeping=True), made.view()) == replace(back, low=13)
    # Given up before it began, all of it is done with.
    assert swept(SweepDrive(sweep), made.view()) == sweep


@pytest.mark.parametrize(("begin", "end"), [(10, 25), (14, 2)])
def test_where_it_begins_is_a_wall(begin: int, end: int) -> None:
    cells = empty()
    cells[9:16, 7:14] = OCCUPIED
    made = world(cells, 12, 3)
    drive = SweepDrive(Sweep(0, 10, begin, end, min(begin, end), max(begin, end)))
    places = made.drive(drive)
    first = 16 if end > begin else 8
    heading = 1 if end > begin else -1
    assert drive.sweep.begin == first
    on_lane = [row for row, col in places if col == 10]
    assert on_lane[-abs(end - first) - 1 :] == list(range(first, end + heading, heading))
    assert places[-1] == (end, 10)


def test_all_of_it_is_a_wall() -> None:
    cells = empty()
    cells[9:16, 7:14] = OCCUPIED
    made = world(cells, 12, 3, range_m=8.0)
    sweep = Sweep(0, 10, 10, 14, 9, 15)
    drive = SweepDrive(sweep)
    made.drive(drive)
    assert not drive.sweeping
    assert swept(drive, made.view()) == replace(sweep, begin=drive.sweep.begin)


def test_shut_in() -> None:
    cells = empty()
    cells[4:11, 4:11] = OCCUPIED
    cells[5:10, 5:10] = FREE
    made = world(cells, 7, 7, range_m=6.0)
    sweep = Sweep(0, 15, 3, 20, 3, 20)
    drive = SweepDrive(sweep)
    assert next_move(drive, made.view()) == -1
    assert swept(drive, made.view()) == sweep


# --- others -----------------------------------------------------------------------------------


def test_pushed_off_the_path_it_makes_another() -> None:
    made = world(empty(), 9, 3)
    drive = SweepDrive(Sweep(0, 12, 5, 25, 3, 27))
    for _ in range(4):
        made.go(next_move(drive, made.view()))
    made.go(3)  # not where it was heading
    made.go(2)
    places = made.drive(drive)
    assert (5, 12) in places
    assert places[-1] == (25, 12)


def test_pushed_off_the_lane_it_comes_back() -> None:
    made = world(empty(), 5, 12)
    drive = SweepDrive(Sweep(0, 12, 5, 25, 3, 27))
    for _ in range(4):
        made.go(next_move(drive, made.view()))
    made.go(0)
    made.go(0)
    places = made.drive(drive)
    assert places[-1] == (25, 12)
    assert len(places) <= 25 - 9 + 2
    assert sum(col != 12 for _, col in places) <= 2


def test_patience() -> None:
    made = world(empty(), 5, 12)
    drive = SweepDrive(Sweep(0, 12, 5, 25, 3, 27))
    made.go(next_move(drive, made.view()))
    moves = [next_move(drive, made.view()) for _ in range(PATIENCE + 2)]  # nobody lets it pass
    assert moves[: PATIENCE + 1] == [1] * (PATIENCE + 1)
    assert moves[-1] == -1
    assert swept(drive, made.view()).high == 6 + 3
    # A move in between begins it anew.
    drive = SweepDrive(Sweep(0, 12, 6, 25, 3, 27))
    for _ in range(3):
        for _ in range(PATIENCE):
            k = next_move(drive, made.view())
        made.go(k)
    assert made.row == 9


# --- what may be possible ---------------------------------------------------------------------


def part_known(seed: int) -> World:
    """A random world some way known, with robots of any size."""
    rng = np.random.default_rng(seed)
    while True:
        cells = (rng.random(rng.integers(4, 16, 2)) < rng.choice([0.0, 0.1, 0.3])).astype(np.uint8)
        cells *= OCCUPIED
        ratio = float(rng.choice([1.0, 1.5, 2.0, 2.5]))
        motion = str(rng.choice(["8-connected", "4-connected"]))
        radius = float(rng.choice([0.1, 0.45, 0.7, 1.2]))
        try:
            plan = planning_grid(
                OccupancyGrid(cells, 1.0),
                cell_m=ratio,
                radius_m=radius,
                diagonal=motion == "8-connected",
            )
        except Exception:
            continue
        where = np.argwhere(plan.standable == 1)
        if len(where):
            break
    body = Robot(
        "robot_0",
        radius_m=radius,
        motion=MOTIONS[motion],
        sensor=Sensor("range", True, float(rng.uniform(1.0, 5.0))),
    )
    made = World(plan, body, Belief(plan), 0, 0)
    for _ in range(int(rng.integers(1, 5))):
        made.row, made.col = where[rng.integers(len(where))].tolist()
        made.look()
    return made


def presumed(made: World) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    return presumed_moves(
        made.belief, made.plan.lattice, made.body.radius_m, made.body.motion.diagonal
    )


def slow_presumed(made: World) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    belief, lattice = made.belief, made.plan.lattice
    reach = int(made.body.radius_m / lattice.resolution + 0.5)
    opened = belief.marks & OPEN == OPEN
    possible = opened.copy()
    for r, c in np.ndindex(possible.shape):
        y, x = int(lattice.fine_row[r]), int(lattice.fine_col[c])
        around = belief.cells[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
        possible[r, c] |= (around == UNKNOWN).any() and not (around == OCCUPIED).any()
    moves = belief.moves.copy()
    for r, c, k in product(range(lattice.rows), range(lattice.cols), range(8)):
        r2, c2 = r + DROW[k], c + DCOL[k]
        if k >= 4 and not made.body.motion.diagonal:
            continue
        if not (0 <= r2 < lattice.rows and 0 <= c2 < lattice.cols):
            continue
        passed = [(r, c), (r2, c2)] + ([(r, c2), (r2, c)] if k >= 4 else [])
        if all(possible[p] for p in passed) and not (opened[r, c] and opened[r2, c2]):
            moves[r, c] |= 1 << k
    return moves, possible.astype(np.uint8)


@settings(deadline=None)
@given(SEEDS)
def test_presumed_moves_against_their_twin(seed: int) -> None:
    made = part_known(seed)
    moves, possible = presumed(made)
    slow_moves, slow_possible = slow_presumed(made)
    assert np.array_equal(possible, slow_possible)
    assert np.array_equal(moves, slow_moves)


@settings(deadline=None)
@given(SEEDS)
def test_presumed_moves_hold_what_is_known_and_nothing_that_is_known_not_to_be(seed: int) -> None:
    made = part_known(seed)
    moves, possible = presumed(made)
    belief, lattice = made.belief, made.plan.lattice
    assert (moves & belief.moves == belief.moves).all()
    known = belief.cells[np.ix_(lattice.fine_row, lattice.fine_col)]
    for r, c in np.ndindex(moves.shape):
        for k in range(8):
            if not moves[r, c] >> k & 1:
                continue
            r2, c2 = r + DROW[k], c + DCOL[k]
            assert possible[r, c]
            assert possible[r2, c2]
            assert known[r2, c2] != OCCUPIED
            assert moves[r2, c2] >> OPPOSITE[k] & 1
            if k >= 4:
                assert made.body.motion.diagonal
                assert known[r, c2] != OCCUPIED
                assert known[r2, c] != OCCUPIED


def test_nothing_known_everything_presumed() -> None:
    made = world(empty(8, 9), 4, 4)
    made.belief = Belief(made.plan)
    moves, possible = presumed(made)
    assert possible.all()
    assert np.array_equal(moves, made.plan.moves)


def test_all_known_nothing_presumed() -> None:
    cells = empty(12, 12)
    cells[3:5, 2:9] = OCCUPIED
    made = world(cells, 1, 1, range_m=30.0)
    made.belief.hear(
        made.plan, made.cell, np.arange(cells.size, dtype=np.int32), new_scratch(made.plan)
    )
    moves, possible = presumed(made)
    assert np.array_equal(moves, made.belief.moves)
    assert np.array_equal(possible, made.plan.standable)


@pytest.mark.parametrize("seed", range(4))
def test_kernels_do_what_their_source_says(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made = part_known(seed)
    compiled = presumed(made)
    kernel: Any = sweep_drive._presume
    monkeypatch.setattr(sweep_drive, "_presume", kernel.python)
    for one, two in zip(compiled, presumed(made), strict=True):
        assert np.array_equal(one, two)


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_any_sweep_in_any_world_ends_by_known_moves(seed: int) -> None:
    """`World.go` refuses moves that are not known; `World.drive` ones without end."""
    made = part_known(seed)
    rng = np.random.default_rng(seed)
    axis = int(rng.integers(2))
    lattice = made.plan.lattice
    along, across = (lattice.rows, lattice.cols) if axis == 0 else (lattice.cols, lattice.rows)
    begin, end = rng.integers(0, along, 2).tolist()
    sweep = Sweep(axis, int(rng.integers(across)), begin, end, min(begin, end), max(begin, end))
    drive = SweepDrive(sweep)
    made.drive(drive)
    told = swept(drive, made.view())
    assert sweep.low <= told.low
    assert told.high <= sweep.high
    assert (told.axis, told.across) == (sweep.axis, sweep.across)
