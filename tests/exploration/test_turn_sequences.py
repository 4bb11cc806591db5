"""Two-step sequences and their gains, against the equations of [Philip2014] written out plainly."""

from collections.abc import Sequence
from itertools import product
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration.potential import Potential
from conav.exploration.turn_sequences import (
    BLOCKED,
    LEFT_OUT,
    TurnMemory,
    best_of,
    check_settings,
    explores,
    play,
    points_in_square,
    predicted_positions,
    second_step,
    sequence_gains,
    turn_from_obstacle,
)
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW, STAY
from conav.geometry.sight import segment_is_clear
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import new_world

Point = tuple[int, int]
SEEDS = st.integers(0, 2**32 - 1)
NOTHING = np.empty((0, 0), np.uint8)


# --- the paper, written out -------------------------------------------------------------------


class Scene(NamedTuple):
    """A robot at a planning cell with a heading and knowledge of its own."""

    view: TeamView
    cells: NDArray[np.uint8]
    row: int
    col: int
    heading: int
    s_range: float
    ratio: float


def scene(
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    heading: int,
    s_range: float,
    *,
    cell_m: float = 1.0,
    occlusion: bool = False,
    motion: str = "forward-turn",
    step: int = 5,
) -> Scene:
    """A view by hand. It can make every straight move to a known free neighbour."""
    lattice = planning_grid(OccupancyGrid(np.zeros_like(cells), 1.0), cell_m=cell_m).lattice
    moves = np.zeros((lattice.rows, lattice.cols), np.uint8)
    for k in range(4):
        r, c = row + DROW[k], col + DCOL[k]
        if 0 <= r < lattice.rows and 0 <= c < lattice.cols:
            ok = cells[lattice.fine_row[r], lattice.fine_col[c]] == FREE
            moves[row, col] |= ok << k
    body = Robot("robot_0", motion=MOTIONS[motion], sensor=Sensor("any", occlusion, s_range))
    belief: Any = SimpleNamespace(cells=cells, moves=moves)
    heard = np.zeros(1, np.int32)
    cell = row * lattice.cols + col
    view = TeamView(
        step, float(step), 0, body, cell, heading, belief, lattice, heard, heard, heard == 0
    )
    return Scene(view, cells, row, col, heading, s_range, cell_m)


def fine(at: Scene, row: int, col: int) -> Point | None:
    """The point at the centre of a planning cell, None where an obstacle or nothing is."""
    lattice = at.view.lattice
    if not (0 <= row < lattice.rows and 0 <= col < lattice.cols):
        return None
    rows, cols = at.cells.shape
    point = (min(int((row + 0.5) * at.ratio), rows - 1), min(int((col + 0.5) * at.ratio), cols - 1))
    return None if at.cells[point] == OCCUPIED else point


def locations(at: Scene, turn: int) -> list[Point] | None:
    """loc(t+1) and loc(t+2), the second only where no obstacle is known; None: not to be played."""
    k = (at.heading + turn) % 4
    near = fine(at, at.row + DROW[k], at.col + DCOL[k])
    if near is None or at.cells[near] == UNKNOWN:
        return None
    here = fine(at, at.row, at.col)
    assert here is not None
    if turn:
        return [here, near]
    far = fine(at, at.row + 2 * DROW[k], at.col + 2 * DCOL[k])
    return [near] if far is None else [near, far]


def near(a: Point, b: Point, s_range: float) -> bool:
    """||a - b|| <= sRange."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 <= s_range**2


def utility(
    at: Scene, turn: int, own: set[Point], others: set[Point], predicted: Sequence[Point] = ()
) -> int | None:
    """(7): the sum of f over all grid points; with predicted teammates (18), C2 with <=."""
    places = locations(at, turn)
    if places is None:
        return None
    total = 0
    for pt in product(*map(range, at.cells.shape)):
        if pt in own:
            total += 1
            continue
        in_reach = any(near(pt, place, at.s_range) for place in places)
        taken = any(near(pt, other, at.s_range) for other in predicted)
        total += in_reach and pt not in others and not taken
    return total


def agrees(at: Scene, own: set[Point], others: set[Point], gains: NDArray[np.int64], *more: Any):
    """Gains are utilities less the same constant, and so have the same best sequences."""
    expected = [utility(at, turn, own, others, *more) for turn in range(4)]
    found = [None if gain == BLOCKED else int(gain) + len(own) for gain in gains]
    assert found == expected


def random_scene(rng: np.random.Generator, s_range: float, **how: Any) -> Scene:
    """Knowledge as robots get it: discs, one of them around the robot; also some lone points."""
    rows, cols = (int(rng.integers(3, 14)) for _ in range(2))
    ratio = how.get("cell_m", 1.0)
    rows, cols = max(rows, int(2 * ratio + 1)), max(cols, int(2 * ratio + 1))
    truth = (rng.random((rows, cols)) < rng.choice([0.0, 0.15, 0.3])).astype(np.uint8)
    lattice = planning_grid(OccupancyGrid(truth * 0, 1.0), cell_m=ratio).lattice
    row, col = int(rng.integers(lattice.rows)), int(rng.integers(lattice.cols))
    here = (int(lattice.fine_row[row]), int(lattice.fine_col[col]))
    truth[here] = FREE
    y, x = np.mgrid[:rows, :cols]
    known = rng.random((rows, cols)) < rng.choice([0.0, 0.3, 0.9])
    for r, c in [here, *rng.integers(0, [rows, cols], (int(rng.integers(3)), 2)).tolist()]:
        known |= (y - r) ** 2 + (x - c) ** 2 <= s_range**2
    cells = np.where(known, truth, UNKNOWN).astype(np.uint8)
    return scene(cells, row, col, int(rng.integers(4)), s_range, **how)


def split(rng: np.random.Generator, known: set[Point]) -> tuple[set[Point], set[Point]]:
    """Who discovered what: each known point belongs to the robot, to others, or to both."""
    kind = {point: int(rng.integers(3)) for point in sorted(known)}
    own = {point for point in known if kind[point] != 1}
    return own, {point for point in known if kind[point] != 0}


def points(mask: NDArray[np.bool_]) -> set[Point]:
    return {(int(r), int(c)) for r, c in np.argwhere(mask)}


# --- (17) and its cost ------------------------------------------------------------------------


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.sampled_from([1.0, 2.0, 3.0, 4.0, 5.0, 1.5, 2.9]))
def test_17_equals_7(seed: int, s_range: float) -> None:
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range)
    own, others = split(rng, points(at.cells != UNKNOWN))
    memory = TurnMemory()
    agrees(at, own, others, sequence_gains(memory, at.view))
    s = int(s_range)
    assert memory.points_checked <= 20 * (s * s + s)
    assert memory.decisions == 1


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.sampled_from([0.5, 0.7, 1.3, 1.7, 2.0, 2.5, 3.3]), st.sampled_from([2.5, 4.0]))
def test_any_planning_cell_size_agrees(seed: int, cell_m: float, s_range: float) -> None:
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range, cell_m=cell_m)
    own, others = split(rng, points(at.cells != UNKNOWN))
    agrees(at, own, others, sequence_gains(TurnMemory(), at.view))


def test_a_second_position_beyond_the_first_ones_range_counts_itself() -> None:
    # Planning cells three points wide and a range of two: what the robot plans on it heard of.
    cells = np.full((3, 9), UNKNOWN, np.uint8)
    cells[:, :5] = FREE
    # From (1, 4) it would see (0, 5), (1, 5), (1, 6) and (2, 5), and from (1, 7) nine more.
    at = scene(cells, 0, 0, 0, 2.0, cell_m=3.0)
    assert locations(at, 0) == [(1, 4), (1, 7)]
    assert sequence_gains(TurnMemory(), at.view).tolist() == [12, BLOCKED, BLOCKED, BLOCKED]
    assert utility(at, 0, points(cells != UNKNOWN), set()) == 15 + 12


@pytest.mark.parametrize("s", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("heading", range(4))
def test_away_from_borders_a_decision_takes_its_20_s2_plus_20_s_checks(
    s: int, heading: int
) -> None:
    assert points_in_square(s) == 4 * s * s + 4 * s
    for side in (2 * s + 5, 60):  # whatever the size of the map
        cells = np.zeros((side, side), np.uint8)
        memory = TurnMemory()
        for _ in range(2):
            sequence_gains(memory, scene(cells, s + 2, s + 2, heading, s).view)
        assert memory.points_checked == 2 * 20 * (s * s + s)
        assert memory.decisions == 2


def test_checks_and_gains_do_not_depend_on_the_map_around() -> None:
    rng = np.random.default_rng(3)
    small = rng.integers(0, 3, (15, 15)).astype(np.uint8)
    small[7, 6:9] = small[6:9, 7] = FREE
    large = np.full((400, 300), UNKNOWN, np.uint8)
    large[200:215, 100:115] = small
    memories = TurnMemory(), TurnMemory()
    one = sequence_gains(memories[0], scene(small, 7, 7, 0, 5.0).view)
    other = sequence_gains(memories[1], scene(large, 207, 107, 0, 5.0).view)
    assert one.tolist() == other.tolist()
    assert memories[0] == memories[1]


def test_figure_1() -> None:
    # Points 2 and 1 straight on, 3 to the left, 4 behind, 5 to the right of a robot facing north.
    assert predicted_positions(5, 5, 1) == (((6, 5), (7, 5)), ((5, 4),), ((4, 5),), ((5, 6),))
    assert predicted_positions(5, 5, 0) == (((5, 6), (5, 7)), ((6, 5),), ((5, 4),), ((4, 5),))
    assert predicted_positions(5, 5, 2) == (((5, 4), (5, 3)), ((4, 5),), ((5, 6),), ((6, 5),))
    assert predicted_positions(5, 5, 3) == (((4, 5), (3, 5)), ((5, 6),), ((6, 5),), ((5, 4),))


def test_gains_by_hand() -> None:
    # Range 1, the disc around the robot known. One step shows three new points, two show six.
    cells = np.full((9, 9), UNKNOWN, np.uint8)
    cells[4, 3:6] = cells[3:6, 4] = FREE
    gains = sequence_gains(TurnMemory(), scene(cells, 4, 4, 0, 1.0).view)
    assert gains.tolist() == [6, 3, 3, 3]
    cells[4, 6] = OCCUPIED  # straight on the second step is shut, and its point known
    assert sequence_gains(TurnMemory(), scene(cells, 4, 4, 0, 1.0).view).tolist() == [2, 3, 3, 3]
    cells[4, 5] = OCCUPIED
    gains = sequence_gains(TurnMemory(), scene(cells, 4, 4, 0, 1.0).view)
    assert gains.tolist() == [BLOCKED, 3, 3, 3]
    assert sequence_gains(TurnMemory(), scene(cells, 4, 4, 2, 1.0).view)[2] == BLOCKED


def test_at_the_border_of_the_map() -> None:
    cells = np.full((3, 3), UNKNOWN, np.uint8)
    cells[0, :2] = cells[1, 0] = FREE
    memory = TurnMemory()
    gains = sequence_gains(memory, scene(cells, 0, 0, 0, 1.0).view)
    # East two steps: (0, 2), (1, 1) and (1, 2); north one: (1, 1) and (2, 0).
    assert gains.tolist() == [3, 2, BLOCKED, BLOCKED]
    assert memory.points_checked == 5 + 3 + 5


# --- walls that block sight, and predicted teammates --------------------------------------------


def gains_in_sight(at: Scene, predicted: Sequence[Point] = ()) -> list[int]:
    """What could be seen from the new positions if everything unknown were clear."""
    result = []
    for turn in range(4):
        places = locations(at, turn)
        if places is None:
            result.append(BLOCKED)
            continue
        count = 0
        for pt in points(at.cells == UNKNOWN):
            count += any(
                near(pt, place, at.s_range) and segment_is_clear(at.cells, *place, *pt)
                for place in (places[1:] if turn else places)
            ) and not any(near(pt, other, at.s_range) for other in predicted)
        result.append(count)
    return result


@settings(max_examples=80, deadline=None)
@given(SEEDS, st.sampled_from([1.0, 1.6, 2.0, 2.5]), st.sampled_from([2.5, 3.0, 6.0]))
def test_behind_walls_nothing_counts(seed: int, cell_m: float, s_range: float) -> None:
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range, cell_m=cell_m, occlusion=True)
    assert sequence_gains(TurnMemory(), at.view).tolist() == gains_in_sight(at)
    others = rng.integers(0, at.cells.shape, (2, 2)).astype(np.int32)
    gains = sequence_gains(TurnMemory(), at.view, NOTHING, others)
    assert gains.tolist() == gains_in_sight(at, others.tolist())


def test_a_wall_hides_what_the_disc_would_count() -> None:
    cells = parse_ascii("?????\n#####\n.....\n.....").cells
    assert sequence_gains(TurnMemory(), scene(cells, 0, 2, 1, 2.0).view)[0] == 1
    hidden = scene(cells, 0, 2, 1, 2.0, occlusion=True)
    assert sequence_gains(TurnMemory(), hidden.view).tolist() == [0, 0, BLOCKED, 0]


def robots_ahead(rng: np.random.Generator, at: Scene) -> NDArray[np.int32]:
    """Where one to three teammates are predicted after one and after two steps forward."""
    places = []
    for _ in range(int(rng.integers(1, 4))):
        r, c = rng.integers(0, at.cells.shape).tolist()
        k = int(rng.integers(4))
        places += [(r + DROW[k], c + DCOL[k]), (r + 2 * DROW[k], c + 2 * DCOL[k])]
    return np.array(places, np.int32)


@settings(max_examples=120, deadline=None)
@given(SEEDS, st.sampled_from([1.0, 2.0, 3.0, 4.0]))
def test_points_near_predicted_teammates_do_not_count(seed: int, s_range: float) -> None:
    """(18), with the first clause of its C2 put right."""
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range)
    own, others = split(rng, points(at.cells != UNKNOWN))
    ahead = robots_ahead(rng, at)
    gains = sequence_gains(TurnMemory(), at.view, NOTHING, ahead)
    agrees(at, own, others, gains, [tuple(place) for place in ahead.tolist()])


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.sampled_from([1.0, 2.0, 3.0]))
def test_points_left_out_farther_on_count_as_undiscovered(seed: int, s_range: float) -> None:
    """Points somebody saw and nobody has in its set, none of them in range already."""
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range)
    state = random_states(rng, at, s_range)
    own, others = split(rng, points((at.cells != UNKNOWN) & (state != LEFT_OUT)))
    agrees(at, own, others, sequence_gains(TurnMemory(), at.view, state))


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.sampled_from([1.0, 2.0, 3.0]))
def test_points_left_out_anywhere_count_as_undiscovered(seed: int, s_range: float) -> None:
    """Also those in range already, which is what a robot that left them out itself has.

    The robot may come to stand on one, and while it turns it sees those around it once more: C1.
    """
    rng = np.random.default_rng(seed)
    at = random_scene(rng, s_range)
    state = random_states(rng, at, -1.0)
    own, others = split(rng, points((at.cells != UNKNOWN) & (state != LEFT_OUT)))
    agrees(at, own, others, sequence_gains(TurnMemory(), at.view, state))


def random_states(rng: np.random.Generator, at: Scene, spared: float) -> NDArray[np.uint8]:
    """What is known is discovered or left out, but not left out so near to the robot."""
    y, x = np.indices(at.cells.shape)
    state = rng.choice([1, LEFT_OUT], at.cells.shape).astype(np.uint8)
    state[np.hypot(y - at.row, x - at.col) <= spared] = 1
    state[at.cells == UNKNOWN] = 0
    return state


@pytest.mark.parametrize("occlusion", [False, True])
def test_a_point_left_out_counts_where_the_robot_would_stand_on_it(occlusion: bool) -> None:
    cells = np.zeros((5, 5), np.uint8)
    state = np.ones((5, 5), np.uint8)
    state[3, 2] = LEFT_OUT
    at = scene(cells, 2, 2, 0, 1.0, occlusion=occlusion)
    assert sequence_gains(TurnMemory(), at.view, state)[1] == 1


# --- choosing ---------------------------------------------------------------------------------


class Even:
    """Stands in for a generator: n numbers at even distances, so that shares come out exactly."""

    def __init__(self, n: int) -> None:
        self.numbers = ((i + 0.5) / n for i in range(n))

    def random(self) -> float:
        return next(self.numbers)


class Never:
    """A generator nobody may draw from."""

    def random(self) -> float:
        raise AssertionError("nothing is to be drawn")


def shares(gains: Sequence[int], tie: Any, n: int = 120, rng: Any = None) -> dict[int, int]:
    rng = rng or Even(n)
    drawn = [best_of(np.array(gains, np.int64), tie, rng) for _ in range(n)]
    return {turn: drawn.count(turn) for turn in sorted(set(drawn))}


@pytest.mark.parametrize("tie", ["random", "baseline"])
def test_the_best_is_played(tie: str) -> None:
    for best in range(4):
        gains = np.array([3, 3, 3, 3])
        gains[best] = 4
        assert best_of(gains, tie, Never()) == best  # type: ignore[arg-type]
    assert best_of(np.full(4, BLOCKED), tie, Never()) == -1  # type: ignore[arg-type]
    assert best_of(np.array([BLOCKED, BLOCKED, 0, BLOCKED]), tie, Never()) == 2  # type: ignore[arg-type]


def test_random_ties_are_even() -> None:
    assert shares([5, 5, 5, 5], "random") == {0: 30, 1: 30, 2: 30, 3: 30}
    assert shares([5, 4, 5, 5], "random") == {0: 40, 2: 40, 3: 40}
    assert shares([0, 0, BLOCKED, BLOCKED], "random") == {0: 60, 1: 60}
    assert shares([1, 5, 4, 5], "random") == {1: 60, 3: 60}
    # And with a true generator, within five standard deviations.
    for count in shares([5, 5, 5, 5], "random", 4000, np.random.default_rng(1)).values():
        assert abs(count - 1000) < 5 * 27.4


def test_the_baseline_wins_the_ties_it_is_in() -> None:
    assert best_of(np.array([5, 5, 5, 5]), "baseline", Never()) == 0  # type: ignore[arg-type]
    assert best_of(np.array([0, 0, BLOCKED, 0]), "baseline", Never()) == 0  # type: ignore[arg-type]
    assert shares([4, 5, 5, 5], "baseline") == {1: 40, 2: 40, 3: 40}
    assert shares([BLOCKED, 5, 4, 5], "baseline") == {1: 60, 3: 60}


def test_at_an_obstacle_one_of_the_turns_is_played() -> None:
    gains = np.array([9, 2, 2, 1])
    rng: Any = Even(100)
    drawn = [turn_from_obstacle(gains, rng) for _ in range(100)]
    assert (drawn.count(1), drawn.count(2)) == (50, 50)
    assert gains.tolist() == [9, 2, 2, 1]  # what it was given stays
    none = np.array([0, BLOCKED, BLOCKED, BLOCKED])
    assert turn_from_obstacle(none, Never()) == -1  # type: ignore[arg-type]


def test_how_often_a_robot_explores() -> None:
    cells = np.zeros((5, 5), np.uint8)
    view = scene(cells, 2, 2, 0, 1.0).view
    for epsilon in (0.0, 0.1, 0.25, 1.0):
        rng: Any = Even(1000)
        assert sum(explores(view, epsilon, rng) for _ in range(1000)) == 1000 * epsilon
    generator = np.random.default_rng(2)
    often = sum(explores(view, 0.1, generator) for _ in range(10_000))
    assert abs(often - 1000) < 5 * 30
    never: Any = Never()
    assert not explores(scene(cells, 2, 2, 0, 1.0, step=0).view, 1.0, never)


def test_epsilon_is_a_probability() -> None:
    for epsilon in (0.0, 0.5, 1.0):
        check_settings(epsilon)
    for epsilon in (-0.01, 1.01, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="a probability is 0 to 1"):
            check_settings(epsilon)


# --- in the middle of a sequence ----------------------------------------------------------------


def test_a_turn_binds_the_next_step() -> None:
    cells = np.zeros((5, 5), np.uint8)
    at = scene(cells, 2, 2, 0, 1.0).view
    for turn, heading in ((1, 1), (2, 2), (3, 3)):
        memory = TurnMemory()
        assert not second_step(memory, at)
        assert play(memory, at, turn, "step").direction == heading
        assert (memory.turns, memory.free_steps) == (1, 1)
        turned = scene(cells, 2, 2, heading, 1.0).view
        assert second_step(memory, turned)
        assert second_step(memory, turned)  # it was too slow to move, or somebody is in its way
        gone = scene(cells, 2 + DROW[heading], 2 + DCOL[heading], heading, 1.0).view
        assert not second_step(memory, gone)
        assert memory.free_steps == 2


def test_a_turn_undone_by_a_push_does_not_bind() -> None:
    cells = np.zeros((5, 5), np.uint8)
    at = scene(cells, 2, 2, 0, 1.0).view
    # Pushed on before it had turned; pushed to the side; turned, and then an obstacle is there.
    for row, col, heading, wall in ((2, 3, 0, None), (2, 1, 1, None), (2, 2, 1, (3, 2))):
        memory = TurnMemory()
        play(memory, at, 1, "step")
        after = cells.copy()
        if wall:
            after[wall] = OCCUPIED
        assert not second_step(memory, scene(after, row, col, heading, 1.0).view)
        assert memory.free_steps == 1


def test_a_forward_sequence_binds_where_it_is_asked_to() -> None:
    cells = np.zeros((5, 5), np.uint8)
    at = scene(cells, 2, 2, 0, 1.0).view
    memory = TurnMemory()
    assert play(memory, at, 0, "step").direction == 0
    assert not second_step(memory, at)
    assert play(memory, at, 0, "sequence").direction == 0
    assert second_step(memory, at)  # it could not move yet
    assert second_step(memory, scene(cells, 2, 3, 0, 1.0).view)
    assert not second_step(memory, scene(cells, 2, 4, 0, 1.0).view)
    assert play(memory, at, -1, "sequence").direction == STAY
    assert not second_step(memory, at)
    assert memory.turns == 0


def test_turning_for_free_takes_one_step() -> None:
    cells = np.zeros((5, 5), np.uint8)
    memory = TurnMemory()
    assert play(memory, scene(cells, 2, 2, 0, 1.0, motion="4-connected").view, 1, "step")[0] == 1
    assert not second_step(memory, scene(cells, 2, 2, 1, 1.0, motion="4-connected").view)
    assert not second_step(memory, scene(cells, 3, 2, 1, 1.0, motion="4-connected").view)


def test_pushed_robots_keep_their_books() -> None:
    """A crowd under the traffic rule: a robot is bound where its turn held, and only there."""
    grid = parse_ascii(
        "\n".join(["#########", *["#.......#"] * 3, "####.####", "#.......#", "#" * 9])
    )
    problem, _ = exploration_problem(
        grid, robots=9, range_m=1.0, motion="forward-turn", cell_m=1.0, seed=1, radius_m=0.3
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Potential(epsilon=0.5), seen)
    engine = engine_for(state)
    undone = held = 0
    for _ in range(150):
        before = [
            (memory.heading, memory.bound_at, memory.free_steps) if memory else (-1, (), 0)
            for memory in state.memories
        ]
        events = engine.sense_and_decide(state, [])
        for robot, (turned_to, bound_at, free) in enumerate(before):
            heading, cell = int(events.headings[robot]), int(events.cells[robot])
            stands = turned_to == heading and cell in bound_at
            bound = stands and state.beliefs[robot].moves.item(cell) >> heading & 1
            assert state.memories[robot].free_steps == free + (not bound)
            if bound:
                assert events.actions[robot].direction == heading
            went = cell not in bound_at and heading == turned_to
            undone += bool(bound_at) and not stands and not went
            held += bool(bound)
        engine.move(state, events.actions)
    assert undone > 0
    assert held > 50


# --- the claims about the game ------------------------------------------------------------------


@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_claims_1_and_2(seed: int) -> None:
    """A change of one robot's sequence changes phi, (9), by what it changes its utility.

    It holds for any utility that does not look at what the others play, as (7) and (18) do not:
    the others' headings, wherever they turn to next, change nothing, nor does who stands where.
    """
    rng = np.random.default_rng(seed)
    at = random_scene(rng, 2.0)
    lattice = at.view.lattice
    places = np.argwhere(at.cells == FREE)
    team = [
        scene(at.cells, *map(int, places[rng.integers(len(places))]), int(rng.integers(4)), 2.0)
        for _ in range(3)
    ]
    ahead = robots_ahead(rng, at)
    for others in (np.empty((0, 2), np.int32), ahead):
        tables = []
        for profile in product(range(4), repeat=3):
            # What the others play shows in where they were last heard, at the most.
            heard = rng.integers(0, lattice.rows * lattice.cols, 3).astype(np.int32)
            views = [one.view._replace(heard_cell=heard) for one in team]
            gains = [sequence_gains(TurnMemory(), view, NOTHING, others) for view in views]
            tables.append((profile, [int(g[a]) for g, a in zip(gains, profile, strict=True)]))
        utilities = dict(tables)
        for profile, mine in utilities.items():
            for player, action in product(range(3), range(4)):
                other = (*profile[:player], action, *profile[player + 1 :])
                change = utilities[other][player] - mine[player]
                assert sum(utilities[other]) - sum(mine) == change


def utility_4(here: Point, following: Point, own: set[Point], others: set[Point]) -> int:
    """(4) for sRange 1 on a row of ten points."""
    row = [(0, c) for c in range(10)]
    found = {pt for pt in row if near(pt, here, 1.0) or near(pt, following, 1.0)}
    return len(own | (found - others))


def test_the_utility_is_no_wonderful_life_utility() -> None:
    """(3) does not hold for (4) with (8) where discs overlap.

    Robot 1 at 2 and robot 2 at 3, both about to go right on a row of points; sRange 1. What each
    has discovered is the disc around it.
    """
    first, second = {(0, c) for c in (1, 2, 3)}, {(0, c) for c in (2, 3, 4)}
    u_1 = utility_4((0, 2), (0, 3), first, others=second)
    u_2 = utility_4((0, 3), (0, 4), second, others=first)
    assert (u_1, u_2) == (3, 4)  # 4 is robot 2's, so robot 1 gains nothing; robot 2 gains 5
    phi = u_1 + u_2
    phi_without_2 = utility_4((0, 2), (0, 3), first, others=set())
    assert phi_without_2 == 4  # alone robot 1 discovers 4
    assert phi - phi_without_2 == 3
    assert phi - phi_without_2 != u_2
    # With discs apart it does hold.
    far = {(0, c) for c in (6, 7, 8)}
    apart = utility_4((0, 2), (0, 3), first, others=far)
    u_far = utility_4((0, 7), (0, 8), far, others=first)
    assert apart + u_far - phi_without_2 == u_far
