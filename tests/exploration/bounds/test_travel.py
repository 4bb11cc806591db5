"""Travel is never overestimated: against the simulation's own rule and a search over it."""

from math import inf

import numpy as np
import pytest

from conav.exploration.bounds.travel import most_travel, travel_from, turn_cost, whole_steps
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.motion import MOTIONS
from conav.simulation.no_traffic import pass_through


def open_plan(rows: int, cols: int, *, diagonal: bool) -> PlanningGrid:
    return planning_grid(
        OccupancyGrid(np.zeros((rows, cols), dtype=np.uint8), 1.0),
        cell_m=1.0,
        radius_m=0.1,
        diagonal=diagonal,
    )


def random_plan(seed: int, *, diagonal: bool) -> PlanningGrid:
    rng = np.random.default_rng(seed)
    cells = (rng.random((7, 8)) < 0.25).astype(np.uint8)
    return planning_grid(OccupancyGrid(cells, 1.0), cell_m=1.0, radius_m=0.1, diagonal=diagonal)


def drive(plan: PlanningGrid, start: int, moves: list[int], rate: float, *, turning: bool) -> int:
    """The step at which a robot alone has made all moves, by the simulation's rule."""
    cells = np.array([start], dtype=np.int32)
    heading = np.array([moves[0] % 4], dtype=np.int8)
    credit = np.zeros(1)
    steps = made = 0
    while made < len(moves):
        ways = plan.moves.reshape(-1)[cells]
        before = int(cells[0])
        pass_through(
            cells,
            np.array([moves[made]], dtype=np.int8),
            ways,
            plan.lattice.cols,
            heading,
            np.array([turning], dtype=np.uint8),
            np.array([rate]),
            credit,
            np.zeros(1),
            np.zeros(1, dtype=np.uint8),
        )
        steps += 1
        made += int(cells[0]) != before
    return steps


@pytest.mark.parametrize("rate", [1.0, 0.6, 0.5, 1 / 3, 0.1, 0.07])
def test_the_first_whole_step_is_the_one_of_the_simulation(rate: float) -> None:
    plan = open_plan(40, 40, diagonal=True)
    rng = np.random.default_rng(0)
    for straight, diagonal in rng.integers(0, 15, size=(30, 2)).tolist():
        if straight + diagonal == 0:
            continue
        moves = [0] * straight + [4] * diagonal
        rng.shuffle(moves)
        steps = drive(plan, 0, moves, rate, turning=False)
        assert whole_steps((straight + diagonal * SQRT2) / rate) <= steps
        if diagonal == 0:
            assert whole_steps(straight / rate) == steps


def test_two_diagonals_take_three_steps() -> None:
    plan = open_plan(4, 4, diagonal=True)
    assert drive(plan, 0, [4, 4], 1.0, turning=False) == 3 == whole_steps(2 * SQRT2)
    assert drive(plan, 0, [4], 1.0, turning=False) == 2 == whole_steps(SQRT2)


@pytest.mark.parametrize("rate", [1.0, 0.6, 0.25])
def test_turns_take_a_step_whatever_the_speed(rate: float) -> None:
    plan = open_plan(9, 9, diagonal=False)
    moves = [0, 0, 1, 1, 0, 3]
    steps = drive(plan, 9, moves, rate, turning=True)
    turn = turn_cost(MOTIONS["forward-turn"], rate)
    assert turn == rate
    assert whole_steps((len(moves) + 3 * turn) / rate) <= steps
    goal = 9 + 4 * 1 + 9 * 2  # two up and four along: one turn
    far = travel_from(plan.moves, np.array([9]), turn)
    assert far[goal] == pytest.approx(6 + turn)


def test_whole_steps_round_up_and_forgive_rounding() -> None:
    assert [whole_steps(x) for x in (0.0, 1e-12, 0.5, 1.0, 1.0 + 1e-12, 1.01)] == [0, 0, 1, 1, 1, 2]
    assert whole_steps(3 * 0.1 / 0.3) == 1
    assert whole_steps(inf) == inf
    for steps in (0, 1, 7, 1000):
        for rate in (1.0, 0.3):
            # What can be driven in k steps is not over before step k, nor after it.
            assert whole_steps(most_travel(steps, rate) / rate) == steps


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rate", [1.0, 0.4])
@pytest.mark.parametrize("motion", MOTIONS)
def test_travel_by_relaxing_until_nothing_changes(seed: int, motion: str, rate: float) -> None:
    model = MOTIONS[motion]
    plan = random_plan(seed, diagonal=model.diagonal)
    turn = turn_cost(model, rate)
    free = np.flatnonzero(plan.standable)
    sources = free[:: max(len(free) // 2, 1)]
    cols = plan.lattice.cols
    least = np.full((plan.moves.size, 4), np.inf)  # per heading; turning may cost nothing
    least[sources] = 0.0
    changed = True
    while changed:
        before = least.copy()
        for cell in free.tolist():
            least[cell] = np.minimum(least[cell], least[cell].min() + turn)
            for k in range(8):
                if plan.moves.reshape(-1)[cell] & (1 << k):
                    other = cell + DROW[k] * cols + DCOL[k]
                    here = least[cell, k] if k < 4 else least[cell].min()
                    length = here + (1.0 if k < 4 else SQRT2)
                    ends = [k] if k < 4 else range(4)
                    for h in ends:
                        least[other, h] = min(least[other, h], length)
        changed = not np.array_equal(before, least)
    assert travel_from(plan.moves, sources, turn) == pytest.approx(least.min(axis=1))
