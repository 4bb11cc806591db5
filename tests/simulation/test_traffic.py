"""The traffic rule: nobody collides, whatever is wished; and meetings are resolved."""

from collections import deque
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.directions import DCOL, DROW, SQRT2, STAY
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.robots.motion import MOTIONS
from conav.simulation.pibt import MIN_GAP, moves_conflict
from conav.simulation.traffic import MOVED, TURNED, resolve

Place = tuple[int, int]


def nearest_square(a: Place, to_a: Place, b: Place, to_b: Place) -> Fraction:
    """The least squared distance of two robots on their straight lines at once, exactly."""
    y, x = b[0] - a[0], b[1] - a[1]
    dy = (to_b[0] - b[0]) - (to_a[0] - a[0])
    dx = (to_b[1] - b[1]) - (to_a[1] - a[1])
    length = dy * dy + dx * dx
    t = Fraction(-(y * dy + x * dx), length) if length else Fraction(0)
    t = min(max(t, Fraction(0)), Fraction(1))
    return (y + t * dy) ** 2 + (x + t * dx) ** 2


def sampled_square(a: Place, to_a: Place, b: Place, to_b: Place) -> float:
    """The same by looking often."""
    t = np.linspace(0.0, 1.0, 101)
    y = b[0] - a[0] + t * ((to_b[0] - b[0]) - (to_a[0] - a[0]))
    x = b[1] - a[1] + t * ((to_b[1] - b[1]) - (to_a[1] - a[1]))
    return float((y * y + x * x).min())


class Road:
    """A map with robots; every step is checked for everything that must never happen."""

    def __init__(
        self,
        picture: str | np.ndarray,
        cells: Sequence[int] | None = None,
        *,
        motion: str = "8-connected",
        radius: float | Sequence[float] = 0.1,
        rate: float | Sequence[float] = 1.0,
        headings: Sequence[int] | None = None,
    ) -> None:
        model = MOTIONS[motion]
        if isinstance(picture, str):
            grid = parse_ascii(picture)
            if cells is None:
                cells = [r * grid.cols + c for r, c in ascii_starts(picture).values()]
        else:
            grid = OccupancyGrid(picture, 1.0)
        assert cells is not None
        self.plan = planning_grid(grid, cell_m=1.0, radius_m=1e-3, diagonal=model.diagonal)
        self.cols = self.plan.lattice.cols
        n = len(cells)
        self.n = n
        self.step_number = 0
        self.cells = np.array(cells, np.int32)
        self.radius = np.full(n, radius, float)
        self.rate = np.full(n, rate, float)
        self.headings = np.array(headings or [0] * n, np.int8)
        self.turning = np.full(n, model.turn_costs_step, np.uint8)
        self.credit = np.zeros(n)
        self.travelled = np.zeros(n)
        self.outcome = np.zeros(n, np.uint8)
        self.paths: list[list[float]] = [[] for _ in range(n)]  # length of each step
        self.length = np.zeros(n)
        self.ahead = np.zeros(n)  # travel beyond the rate since the best step to count from

    def place(self, robot: int) -> Place:
        row, col = divmod(int(self.cells[robot]), self.cols)
        return row, col

    def step(self, wish: Sequence[int]) -> None:
        before = [self.place(robot) for robot in range(self.n)]
        heading = self.headings.copy()
        moved = resolve(
            self.step_number,
            self.cells,
            np.array(wish, np.int8),
            self.plan.moves.reshape(-1)[self.cells],
            self.cols,
            self.headings,
            self.turning,
            self.radius,
            self.rate,
            self.credit,
            self.travelled,
            self.outcome,
        )
        self.step_number += 1
        after = [self.place(robot) for robot in range(self.n)]
        assert moved == sum(a != b for a, b in zip(before, after, strict=True))
        for robot in range(self.n):
            self._check_own_move(robot, before[robot], after[robot], int(heading[robot]))
        for i, j in combinations(range(self.n), 2):
            self._check_pair(i, j, before[i], after[i], before[j], after[j])

    def _check_own_move(self, robot: int, before: Place, after: Place, heading: int) -> None:
        dr, dc = after[0] - before[0], after[1] - before[1]
        assert self.plan.standable[after]
        length = (dr * dr + dc * dc) ** 0.5
        self.paths[robot].append(length)
        self.length[robot] += length
        assert abs(self.length[robot] - self.travelled[robot]) < 1e-6
        assert (self.outcome[robot] == MOVED) == (length > 0)
        now = int(self.headings[robot])
        assert 0 <= now < 4
        if length:
            k = next(k for k in range(8) if (DROW[k], DCOL[k]) == (dr, dc))
            assert self.plan.moves[before] >> k & 1
            if self.turning[robot]:
                assert heading == now == k  # it drives where it already faced
        elif self.turning[robot]:
            assert (self.outcome[robot] == TURNED) == (heading != now)
        else:
            assert heading == now
        # Never faster than allowed, from the start and over every window.
        rate = self.rate[robot]
        assert self.travelled[robot] <= rate * self.step_number + 1e-6
        self.ahead[robot] = max(self.ahead[robot], 0.0) + length - rate
        assert self.ahead[robot] <= SQRT2 + 1e-6

    def _check_pair(self, i: int, j: int, a: Place, to_a: Place, b: Place, to_b: Place) -> None:
        gap = max(float(self.radius[i] + self.radius[j]), MIN_GAP)
        assert nearest_square(a, to_a, b, to_b) >= gap * gap - 1e-6
        assert sampled_square(a, to_a, b, to_b) >= gap * gap - 1e-6
        assert to_a != to_b
        assert (to_a, to_b) != (b, a)  # no swap
        crosses = a != to_a and b != to_b and a[0] + to_a[0] == b[0] + to_b[0]
        assert not (crosses and a[1] + to_a[1] == b[1] + to_b[1])  # nor through the same middle

    def snapshot(self) -> bytes:
        arrays = (self.cells, self.headings, self.credit, self.travelled)
        return b"".join(array.tobytes() for array in arrays)


def distances(road: Road, goal: int) -> dict[int, float]:
    """Steps to the goal over straight moves (a diagonal counts two)."""
    moves = road.plan.moves.reshape(-1)
    far = {goal: 0.0}
    queue = deque([goal])
    while queue:
        cell = queue.popleft()
        for k in range(4):
            if moves[cell] >> k & 1:
                other = cell + DROW[k] * road.cols + DCOL[k]
                if other not in far:
                    far[other] = far[cell] + 1
                    queue.append(other)
    return far


def towards(road: Road, robot: int, far: dict[int, float]) -> int:
    """The straight move that brings a robot nearer to where `far` is measured from."""
    cell = int(road.cells[robot])
    if far[cell] == 0:
        return STAY
    moves = int(road.plan.moves.reshape(-1)[cell])
    around = [(far[cell + DROW[k] * road.cols + DCOL[k]], k) for k in range(4) if moves >> k & 1]
    return min(around)[1]


def drive(road: Road, goals: dict[int, Place], bound: int) -> int:
    """The number of steps until every robot with a goal has been there; fails past the bound."""
    far = {robot: distances(road, row * road.cols + col) for robot, (row, col) in goals.items()}
    missing = set(goals)
    for count in range(bound + 1):
        missing -= {robot for robot in missing if far[robot][int(road.cells[robot])] == 0}
        if not missing:
            return count
        wish = [towards(road, i, far[i]) if i in missing else STAY for i in range(road.n)]
        road.step(wish)
    raise AssertionError(f"robots {sorted(missing)} still on their way after {bound} steps")


def apart(
    plan_cells: Sequence[int], cols: int, radii: Sequence[float], order: Sequence[int]
) -> list[int]:
    """Cells for robots, in this order, none nearer than allowed to one before."""
    chosen: list[int] = []
    for cell in order:
        if cell not in plan_cells or len(chosen) == len(radii):
            continue
        mine = radii[len(chosen)]
        if all(
            (cell // cols - o // cols) ** 2 + (cell % cols - o % cols) ** 2
            >= max(mine + radii[i], MIN_GAP) ** 2
            for i, o in enumerate(chosen)
        ):
            chosen.append(cell)
    return chosen


def crowd(rng: np.random.Generator, motion: str, side: int, most: int) -> Road | None:
    rows, cols = (int(rng.integers(1, side + 1)) for _ in range(2))
    walls = (rng.random((rows, cols)) < rng.choice([0.0, 0.2, 0.4])).astype(np.uint8)
    n = int(rng.integers(1, most + 1))
    radii = rng.choice([0.0, 0.1, 0.25, 0.35355339, 0.45, 0.6], n).tolist()
    if rng.random() < 0.5:
        radii = [radii[0]] * n
    free = np.flatnonzero(walls == 0)
    cells = apart(free.tolist(), cols, radii, rng.permutation(free).tolist())
    if not cells:
        return None
    n = len(cells)
    rate = np.ones(n) if rng.random() < 0.5 else rng.choice([1.0, 0.5, 0.3, 0.75], n)
    return Road(
        walls,
        cells,
        motion=motion,
        radius=radii[:n],
        rate=rate.tolist(),
        headings=rng.integers(0, 4, n).tolist(),
    )


@settings(max_examples=120, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(MOTIONS)))
def test_nobody_ever_collides(seed: int, motion: str) -> None:
    """Random wishes, half of them kept up for a while, possible or not."""
    rng = np.random.default_rng(seed)
    road = crowd(rng, motion, 6, 9)
    if road is None:
        return
    wish = rng.integers(-1, 8, road.n)
    for _ in range(14):
        wish = np.where(rng.random(road.n) < 0.5, wish, rng.integers(-1, 8, road.n))
        road.step(wish.tolist())


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(MOTIONS)))
def test_the_same_wishes_give_the_same_moves(seed: int, motion: str) -> None:
    rng = np.random.default_rng(seed)
    wishes = rng.integers(-1, 8, (10, 9))
    traces = []
    for _ in range(2):
        road = crowd(np.random.default_rng(seed), motion, 6, 9)
        if road is None:
            return
        trace = []
        for wish in wishes:
            road.step(wish[: road.n].tolist())
            trace.append(road.snapshot())
        traces.append(trace)
    assert traces[0] == traces[1]


MOVES = [*range(8), STAY]


@pytest.mark.parametrize("gap", [0.4, 0.5, 0.7, 0.70710678, 0.72, 0.9, 1.0, 1.2, 1.5, 2.3])
def test_conflicts_equal_their_definition(gap: float) -> None:
    """All pairs of moves of robots up to five cells apart."""
    square = gap * gap
    step = [(DROW[k], DCOL[k]) if k >= 0 else (0, 0) for k in MOVES]
    for y, x in product(range(-5, 6), range(-5, 6)):
        if (y, x) == (0, 0):
            continue
        for (k1, s1), (k2, s2) in product(zip(MOVES, step, strict=True), repeat=2):
            near = nearest_square((0, 0), s1, (y, x), (y + s2[0], x + s2[1]))
            start_is_near = y * y + x * x < square
            if start_is_near:
                continue  # not a state that can occur
            expected = near < square - 1e-9
            assert moves_conflict(0, 0, k1, y, x, k2, square) == expected


def test_swaps_and_crossings_conflict_even_for_points() -> None:
    least = MIN_GAP * MIN_GAP
    assert moves_conflict(0, 0, 0, 0, 1, 2, least)  # swap
    assert moves_conflict(0, 0, 4, 0, 1, 5, least)  # across each other's diagonal
    assert moves_conflict(0, 0, 4, 1, 1, 6, least)  # swap on a diagonal
    assert moves_conflict(0, 0, 0, 0, 2, 2, least)  # to the same cell
    assert not moves_conflict(0, 0, 0, 0, 1, 0, least)  # one behind the other
    assert not moves_conflict(0, 0, 0, 1, 0, 0, least)  # side by side
    assert not moves_conflict(0, 0, 0, 0, 1, 1, least)  # round a corner: 0.707 apart


def test_one_robot_goes_where_it_wants() -> None:
    road = Road("....\n....\na...")
    for k, expected in [(0, (0, 1)), (1, (1, 1)), (2, (1, 0)), (3, (0, 0)), (2, (0, 0))]:
        road.step([k])
        assert road.place(0) == expected
    road.step([STAY])
    assert road.place(0) == (0, 0)


def test_a_diagonal_takes_root_two_steps() -> None:
    road = Road(np.zeros((80, 80), np.uint8), [0])
    for _ in range(100):
        road.step([4])
    assert road.place(0) == (70, 70)  # 100 / 1.414
    assert road.travelled[0] == pytest.approx(70 * SQRT2)


@pytest.mark.parametrize(("rate", "expected"), [(0.5, 10), (0.3, 6), (0.75, 15), (1.0, 20)])
def test_a_slower_robot_is_slower(rate: float, expected: int) -> None:
    road = Road(np.zeros((1, 40), np.uint8), [0], rate=rate)
    for _ in range(20):
        road.step([0])
    assert road.place(0) == (0, expected)


def test_waiting_saves_no_travel_up() -> None:
    road = Road(np.zeros((3, 40), np.uint8), [0])
    for _ in range(10):
        road.step([STAY])
    road.step([4])
    assert road.place(0) == (0, 0)  # it takes two steps from a standstill
    road.step([4])
    assert road.place(0) == (1, 1)


def test_a_turn_costs_a_step() -> None:
    road = Road("....\n....\na...", motion="forward-turn", headings=[0])
    places = []
    for k in (0, 1, 1, 3, 3, 3):
        road.step([k])
        places.append((road.place(0), int(road.headings[0])))
    assert places == [
        ((0, 1), 0),
        ((0, 1), 1),
        ((1, 1), 1),
        ((1, 1), 3),
        ((0, 1), 3),
        ((0, 1), 3),  # a wall: stays and keeps facing it
    ]


def test_a_robot_may_follow_into_the_cell_another_leaves() -> None:
    road = Road("ab...")
    road.step([0, 0])
    assert [road.place(0), road.place(1)] == [(0, 1), (0, 2)]
    road = Road("ba...")  # whichever has the lower number
    road.step([0, 0])
    assert [road.place(0), road.place(1)] == [(0, 2), (0, 1)]


def test_a_train_moves_as_one() -> None:
    road = Road("abcdef....")
    for _ in range(4):
        road.step([0] * 6)
    assert [road.place(i)[1] for i in range(6)] == [4, 5, 6, 7, 8, 9]


def test_a_ring_turns() -> None:
    road = Road("dc\nab", motion="4-connected")
    road.step([0, 1, 2, 3])
    assert [road.place(i) for i in range(4)] == [(0, 1), (1, 1), (1, 0), (0, 0)]


@pytest.mark.parametrize("motion", list(MOTIONS))
def test_an_idle_robot_is_pushed_along(motion: str) -> None:
    # b does nothing in a corridor; there is room at its end.
    road = Road("#######..\na...b....\n#######..", motion=motion, headings=[0, 0])
    steps = drive(road, {0: (1, 8)}, 40)
    assert steps >= 8


@pytest.mark.parametrize("motion", list(MOTIONS))
@pytest.mark.parametrize("idle", [1, 3, 6])
def test_a_row_of_idle_robots_is_pushed_out_of_a_corridor(motion: str, idle: int) -> None:
    letters = "bcdefghijk"[:idle]
    top = "#" * (idle + 2) + "...."
    road = Road(f"{top}\na.{letters}....\n{top}", motion=motion)
    drive(road, {0: (1, idle + 5)}, 60)


@pytest.mark.parametrize("rate", [0.5, 0.3])
def test_a_slow_idle_robot_gets_out_of_the_way_too(rate: float) -> None:
    road = Road("#######..\na...b....\n#######..", motion="4-connected", rate=[1.0, rate])
    drive(road, {0: (1, 8)}, 80)


def test_an_idle_robot_in_a_dead_end_is_not_in_the_way_of_others() -> None:
    road = Road("#.#\n#b#\na..")
    drive(road, {0: (0, 2)}, 4)
    assert road.place(1) == (1, 1)


def test_a_robot_pushed_against_a_wall_stays_and_so_does_the_pusher() -> None:
    road = Road("####\n#ab#\n####")
    for _ in range(12):
        road.step([0, STAY])
    assert [road.place(0), road.place(1)] == [(1, 1), (1, 2)]


@pytest.mark.parametrize(
    ("motion", "radius"), [*((motion, 0.2) for motion in MOTIONS), ("8-connected", 0.35)]
)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("at", [1, 4, 7])
def test_head_on_in_a_corridor_with_a_side_pocket(
    motion: str, radius: float, swapped: bool, at: int
) -> None:
    pocket = "#" * at + "." + "#" * (8 - at)
    ends = "b.......a" if swapped else "a.......b"
    road = Road(f"{pocket}\n{ends}", motion=motion, radius=radius)
    left, right = (0, 0), (0, 8)
    goals = {0: left, 1: right} if swapped else {0: right, 1: left}
    drive(road, goals, 400)


@pytest.mark.parametrize("motion", list(MOTIONS))
@pytest.mark.parametrize("radius", [0.0, 0.35])
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("length", [1, 2, 5])
def test_a_standoff_at_a_dead_end_resolves_by_yielding(
    motion: str, radius: float, swapped: bool, length: int
) -> None:
    """One wants into a dead end, the other out of it; only the one outside can make room."""
    inner, outer = ("b", "a") if swapped else ("a", "b")
    wall = "#" * length
    picture = f"...{wall}#\n.{outer}.{'.' * (length - 1)}{inner}#\n...{wall}#"
    road = Road(picture, motion=motion, radius=radius)
    deep, out = (1, 2 + length), (1, 0)
    goals = {0: out, 1: deep} if inner == "a" else {0: deep, 1: out}
    drive(road, goals, 400)


@pytest.mark.parametrize("motion", list(MOTIONS))
def test_two_teams_change_sides_through_a_door(motion: str) -> None:
    road = Road("ab.#.ef\ncd...gh\n...#...", motion=motion)
    left = [(2, 0), (2, 1), (1, 0), (1, 1)]
    right = [(2, 6), (2, 5), (1, 6), (1, 5)]
    goals = dict(enumerate(right + left))
    # Those that arrived are idle and get pushed about; each has to have been there once.
    drive(road, goals, 1500)


def arrivals(road: Road, steps: int, rng: np.random.Generator) -> np.ndarray:
    """How often each robot reached one of its random goals."""
    places = np.flatnonzero(road.plan.standable)
    goal = [int(rng.choice(places)) for _ in range(road.n)]
    far = [distances(road, cell) for cell in goal]
    count = np.zeros(road.n, int)
    for _ in range(steps):
        for robot in range(road.n):
            if road.cells[robot] == goal[robot]:
                count[robot] += 1
                goal[robot] = int(rng.choice(places))
                far[robot] = distances(road, goal[robot])
        road.step([towards(road, robot, far[robot]) for robot in range(road.n)])
    return count


@pytest.mark.parametrize(("motion", "n"), [("8-connected", 30), ("forward-turn", 12)])
def test_a_crowded_room(motion: str, n: int) -> None:
    rng = np.random.default_rng(7)
    walls = np.zeros((8, 9), np.uint8)
    cells = rng.permutation(72)[:n].tolist()
    road = Road(walls, cells, motion=motion, radius=0.2)
    count = arrivals(road, 120, rng)
    assert count.min() >= 1
    assert count.mean() >= 4


def test_a_busy_narrow_map_never_locks_up() -> None:
    rng = np.random.default_rng(3)
    picture = "#.#####.#\n....a....\n#.#####.#\n#b#...#c#\n#.#.#.#.#\n..d...e..\n#.#####.#"
    road = Road(picture, motion="4-connected", radius=0.3)
    count = arrivals(road, 600, rng)
    assert count.min() >= 3


def speeds(road: Road, wishes: Callable[[int], list[int]], steps: int) -> list[list[float]]:
    for number in range(steps):
        road.step(wishes(number))
    return road.paths


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 0.5, 0.7]))
def test_speed_over_every_window(seed: int, rate: float) -> None:
    """One robot on an open field with wishes that change at will."""
    rng = np.random.default_rng(seed)
    road = Road(np.zeros((30, 30), np.uint8), [465], rate=rate)
    share = rng.choice([0.0, 0.3, 0.8])
    paths = speeds(
        road,
        lambda _: [int(rng.integers(4, 8) if rng.random() < share else rng.integers(-1, 4))],
        25,
    )
    total = np.cumsum([0.0, *paths[0]])
    for start, end in combinations(range(26), 2):
        assert total[end] - total[start] <= rate * (end - start) + SQRT2 + 1e-6
    assert all(length in (0.0, 1.0, SQRT2) for length in paths[0])
    assert all(a <= b for a, b in pairwise(total.tolist()))
