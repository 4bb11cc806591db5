"""Segmentation: cuts of maps drawn by hand, assignments by hand, and whole runs."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import conav
from conav.exploration.belief import Belief, new_scratch
from conav.exploration.catalogue import settings_of
from conav.exploration.frontier_targets import Targets
from conav.exploration.segmentation import (
    STRAIGHT_STEP,
    Segmentation,
    assign_by_segment,
    clearance,
    segments,
    spread,
)
from conav.exploration.types import TeamView
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import new_world
from conav.testing import check_strategy

EMPTY = """
###############
#.............#
#.............#
#.............#
#.............#
#.............#
#.............#
###############
"""
TWO_ROOMS = """
#####################
#.........#.........#
#.........#.........#
#.........#.........#
#...................#
#.........#.........#
#.........#.........#
#.........#.........#
#####################
"""
THREE_ROOMS = """
#####################
#.......#.....#.....#
#.......#.....#.....#
#.......#.....#.....#
#.......#.....#.....#
###.######.######.###
#...................#
#...................#
#...................#
#####################
"""
L_SHAPE = """
##############
#...##########
#...##########
#...##########
#...##########
#............#
#............#
#............#
##############
"""


def known(drawing: str, *, diagonal: bool = True) -> tuple[Belief, PlanningGrid]:
    """A belief that knows what is drawn, and nothing where a question mark is."""
    grid = parse_ascii(drawing.strip())
    plan = planning_grid(grid, diagonal=diagonal)
    belief = Belief(plan)
    seen = np.flatnonzero(grid.cells != UNKNOWN).astype(np.int32)
    belief.hear(plan, int(np.flatnonzero(plan.standable)[0]), seen, new_scratch(plan))
    return belief, plan


def cut(drawing: str, *, narrowing: float = 0.7, diagonal: bool = True) -> list[str]:
    """The segments as a drawing, letters from A on, north above."""
    belief, plan = known(drawing, diagonal=diagonal)
    labels = segments(belief, plan.lattice, narrowing)
    return ["".join("#" if v < 0 else chr(65 + v) for v in row) for row in labels[::-1].tolist()]


# --- where the map is cut -------------------------------------------------------------------------


@pytest.mark.parametrize("diagonal", [True, False])
@pytest.mark.parametrize("drawing", [EMPTY, L_SHAPE])
def test_nothing_is_cut_where_nothing_is_narrow(drawing: str, diagonal: bool) -> None:
    assert set("".join(cut(drawing, diagonal=diagonal))) == {"#", "A"}


@pytest.mark.parametrize("diagonal", [True, False])
def test_two_rooms_are_cut_at_the_door(diagonal: bool) -> None:
    rows = cut(TWO_ROOMS, diagonal=diagonal)
    assert {row[1:10] for row in rows[1:-1]} == {"A" * 9}
    assert {row[11:20] for row in rows[1:-1]} == {"B" * 9}
    assert rows[4][10] in "AB"


def test_three_rooms_and_a_corridor_are_cut_at_their_doors() -> None:
    rows = cut(THREE_ROOMS)
    parts = [{row[at] for row in rows[1:5] for at in where} for where in _ROOMS]
    parts.append({letter for row in rows[6:9] for letter in row[1:20]})
    assert all(len(part) == 1 for part in parts)
    assert len(set.union(*parts)) == 4
    # A door belongs to one of its sides.
    for at, room in zip((3, 10, 17), parts[:3], strict=True):
        assert rows[5][at] in room | parts[3]


_ROOMS = (range(1, 8), range(9, 14), range(15, 20))


def test_how_narrow_a_passage_has_to_be_is_a_setting() -> None:
    assert set("".join(cut(TWO_ROOMS, narrowing=0.0))) == {"#", "A"}
    # The door has a quarter of the rooms' clearance: 1 of 4 cells.
    assert set("".join(cut(TWO_ROOMS, narrowing=0.24))) == {"#", "A"}
    assert set("".join(cut(TWO_ROOMS, narrowing=0.26))) == {"#", "A", "B"}


def test_only_what_is_known_counts() -> None:
    """Seen through the door: the walls beyond are unknown, so the far part is wide."""
    rows = cut(TWO_ROOMS.replace(".........#\n", ".....?????\n"))
    assert rows[4][5] == "A" != rows[4][13]
    assert all(row[16] == "#" for row in rows)  # not known, so in no segment


def test_without_obstacles_there_is_one_segment() -> None:
    assert set("".join(cut("......\n......"))) == {"A"}


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), share=st.sampled_from([0.003, 0.02, 0.2]))
def test_clearance_is_the_distance_to_the_nearest_obstacle(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(3, 60, 2))
    cells = np.where(rng.random(shape) < share, OCCUPIED, FREE).astype(np.uint8)
    cells[rng.random(shape) < 0.2] = UNKNOWN
    cells[tuple(rng.integers(0, shape))] = OCCUPIED
    exact = np.asarray(distance_transform_edt(cells != OCCUPIED))
    assert np.abs(clearance(cells) / STRAIGHT_STEP - exact).max() <= 0.021 * exact.max()


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), narrowing=st.sampled_from([0.0, 0.5, 0.7, 1.0]))
def test_segments_are_connected_and_everywhere(seed: int, narrowing: float) -> None:
    """Every segment hangs together along known moves, and with 0 it is a whole component."""
    rng = np.random.default_rng(seed)
    walls = rng.random((14, 17)) < 0.25
    drawing = "\n".join("".join("#" if wall else "." for wall in row) for row in walls)
    belief, plan = known(drawing)
    labels = segments(belief, plan.lattice, narrowing)
    assert np.array_equal(labels >= 0, plan.standable == 1)
    assert sorted(set(labels[labels >= 0].tolist())) == list(range(labels.max() + 1))
    parts = components(belief.moves, labels)
    assert parts == labels.max() + 1
    if narrowing == 0.0:
        assert labels.max() == plan.labels.max()


def components(moves: NDArray[np.uint8], labels: NDArray[np.int32]) -> int:
    """How many sets of equally labelled cells hang together."""
    rows, cols = labels.shape
    left = {(r, c) for r in range(rows) for c in range(cols) if labels[r, c] >= 0}
    steps = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
    count = 0
    while left:
        count += 1
        stack = [left.pop()]
        while stack:
            r, c = stack.pop()
            for k, (down, right) in enumerate(steps):
                to = (r + down, c + right)
                if moves[r, c] >> k & 1 and to in left and labels[to] == labels[r, c]:
                    left.remove(to)
                    stack.append(to)
    return count


# --- who goes where -------------------------------------------------------------------------------


def test_robots_are_spread_before_a_segment_gets_two() -> None:
    inf = float("inf")
    near = np.array([[1.0, 50.0], [2.0, 60.0], [3.0, 70.0]])
    # One each would be 0 -> second, 1 -> first; the third shares the first: 50 + 2 + 3.
    assert spread(near).tolist() == [1, 0, 0]
    assert spread(near[:2]).tolist() == [1, 0]
    # Four robots in three segments: the far one gets its robot before a near one gets a second.
    assert sorted(spread(np.tile([1.0, 2.0, 90.0], (4, 1))).tolist()) == [0, 0, 1, 2]
    assert spread(np.array([[inf, 4.0], [inf, inf]])).tolist() == [1, -1]
    assert spread(np.full((2, 2), inf)).tolist() == [-1, -1]


def targets_of(costs: list[list[float]], piece: list[int]) -> Targets:
    cells = np.arange(100, 100 + len(piece))
    return Targets(cells, np.array(piece), max(piece) + 1, np.array(costs))


def assign(
    targets: Targets, of_target: list[int], of_robot: list[int], discount: float
) -> list[int]:
    view: TeamView = None  # type: ignore[assignment]
    where = np.array(of_target, np.int32)
    return assign_by_segment(targets, view, where, np.array(of_robot, np.int32), discount).tolist()


def test_each_room_gets_a_robot_though_one_room_is_nearer_to_both() -> None:
    targets = targets_of([[1, 2, 9], [2, 1, 8]], [0, 1, 2])
    # Rooms 0 and 1; both pieces nearest are in room 0.
    assert assign(targets, [0, 0, 1], [5, 5], 0.0) == [100, 102]


def test_a_robot_is_spared_part_of_the_cost_of_the_room_it_is_in() -> None:
    targets = targets_of([[10, 6], [12, 9]], [0, 1])
    # Together 10 + 9 = 19 against 12 + 6 = 18; with the discount robot 0 stays: 5 + 9 = 14.
    assert assign(targets, [0, 1], [0, 7], 0.0) == [101, 100]
    assert assign(targets, [0, 1], [0, 7], 0.5) == [100, 101]


def test_inside_a_room_robots_take_different_pieces() -> None:
    targets = targets_of([[1, 2, 5], [1, 2, 9], [7, 7, 1]], [0, 0, 1])
    # One room, three robots, two pieces: the shortest is 0 or 1 -> piece 0, 2 -> piece 1.
    goals = assign(targets, [3, 3, 3], [3, 3, 3], 0.5)
    assert goals == [100, -1, 102]


def test_a_piece_in_two_rooms_may_be_worked_on_from_both() -> None:
    targets = targets_of([[1, 3], [3, 1]], [0, 0])
    assert assign(targets, [0, 1], [0, 1], 0.0) == [100, 101]


def test_nobody_is_sent_where_nobody_can_go() -> None:
    inf = float("inf")
    assert assign(targets_of([[inf], [inf]], [0]), [-1], [0, 0], 0.5) == [-1, -1]


def test_robots_of_one_group_go_to_different_rooms() -> None:
    """A corridor with three open doors and three robots in it."""
    grid = parse_ascii(THREE_ROOMS.strip())
    problem, _ = exploration_problem(
        grid,
        robots=3,
        starts=[(9.5, 2.5), (10.5, 2.5), (11.5, 2.5)],
        radius_m=0.1,
        cell_m=1.0,
        range_m=4.0,
        seed=0,
    )
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Segmentation(), observable)
    engine = engine_for(state)
    visited: list[set[int]] = [set(), set(), set()]
    while int(state.covered[0]) < state.n_observable:
        events = engine.sense_and_decide(state, [])
        for robot, cell in enumerate(events.cells.tolist()):
            row, col = divmod(cell, 21)
            if row > 4:
                visited[robot].add(next(i for i, at in enumerate(_ROOMS) if col in at))
        engine.move(state, events.actions)
    assert sum(len(rooms) for rooms in visited) <= 3
    assert all(visited)


# --- whole runs -----------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["8-connected", "4-connected", "forward-turn"])
def test_passes_the_checks_of_any_strategy(motion: str) -> None:
    check_strategy(Segmentation(), motion=motion)


# [m] Coarser than by default: a quarter of the cells to verify.
_COARSE = {"maze": 0.2, "cave": 0.2, "office": 0.2}


@pytest.mark.parametrize(
    ("name", "robots", "radio"),
    [("maze", 1, None), ("three-obstacles", 4, 6.0), ("cave", 2, 6.0), ("office", 3, None)],
)
def test_finishes_and_is_accepted(
    name: str, robots: int, radio: float | None, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(
        name,
        strategy=Segmentation(),
        robots=robots,
        seed=1,
        radio=radio,
        resolution=_COARSE.get(name),
        out=path,
    )
    assert done.status == "done"
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


def test_settings_are_checked() -> None:
    assert settings_of(Segmentation()) == {"narrowing": 0.7, "discount": 0.4}
    for name in ("narrowing", "discount"):
        for bad in (-0.1, 1.1, float("nan")):
            with pytest.raises(ValueError, match=f"{name} is .*; give 0 to 1"):
                Segmentation(**{name: bad})
