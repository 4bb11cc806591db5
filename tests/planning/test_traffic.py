"""Distances between moving discs."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.maps.polygon_map import PolygonMap
from conav.planning.traffic import build_traffic, hits, pieces_apart
from conav.planning.types import PIECE, PlanningProblem, PlanningRobot, Region

FLOOR = PolygonMap([(0, 0), (20, 0), (20, 20), (0, 20)])
WHOLE = st.integers(-5, 5)


def piece(t0, t1, x, y, vx, vy):
    return np.array([[t0, t1, x, y, vx, vy, 0.0, 0.0, 0.0]], dtype=float)


@given(st.tuples(*[WHOLE] * 8), st.integers(0, 4), st.integers(1, 5), st.integers(1, 6))
@settings(max_examples=400, deadline=None)
def test_the_least_distance_is_exact(numbers, late, lasts, distance) -> None:
    x, y, vx, vy, u, v, wx, wy = numbers
    mine = piece(0, 6, x, y, vx, vy)
    theirs = piece(late, late + lasts, u, v, wx, wy)
    begin, end = Fraction(late), Fraction(min(6, late + lasts))
    expected = True
    if begin <= end:
        px, py = x + vx * begin - u, y + vy * begin - v
        dx, dy = Fraction(vx - wx), Fraction(vy - wy)
        square = dx * dx + dy * dy
        after = Fraction(0)
        if square:
            after = min(max(-(px * dx + py * dy) / square, Fraction(0)), end - begin)
        least = (px + dx * after) ** 2 + (py + dy * after) ** 2
        if abs(least - distance**2) < Fraction(1, 10**9) and least != distance**2:
            return
        expected = least >= distance**2
        if least == distance**2 and square:
            return  # touching exactly where both move: rounding decides
    assert pieces_apart(mine, 0, theirs, 0, float(distance)) == expected
    assert pieces_apart(theirs, 0, mine, 0, float(distance)) == expected


def problem(count: int, stays: list[str], margin: float = 0.0) -> PlanningProblem:
    goal = {"goal": Region("goal", disc=(1.0, 1.0, 0.5))}
    robots = tuple(
        PlanningRobot(f"r{i}", (1.0, 1.0), "F goal", goal, 0.3 + 0.1 * i, after_arrival=stays[i])
        for i in range(count)
    )
    return PlanningProblem(FLOOR, robots, 20.0, margin_m=margin)


def walk(random: np.random.Generator) -> np.ndarray:
    times = np.concatenate([[0.0], np.sort(random.uniform(0.1, 18.0, random.integers(1, 9)))])
    at = random.uniform(2, 18, (len(times), 2))
    rows = np.zeros((len(times) - 1, PIECE))
    rows[:, 0], rows[:, 1] = times[:-1], times[1:]
    rows[:, 2:4] = at[:-1]
    rows[:, 4:6] = (at[1:] - at[:-1]) / np.diff(times)[:, None]
    return rows


@pytest.mark.parametrize("seed", range(10))
def test_hits_are_those_of_all_pairs_of_pieces(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = 4
    stays = ["stay" if random.uniform() < 0.5 else "vanish" for _ in range(count)]
    traffic = build_traffic(problem(count, stays, margin=0.1))
    for robot in range(1, count):
        traffic.put(robot, walk(random))
    heed = np.ones(count, np.bool_)
    some = 0
    for _ in range(200):
        t0 = random.uniform(0, 18)
        x, y = random.uniform(2, 18, 2)
        mine = piece(t0, t0 + random.uniform(0.01, 2.0), x, y, *random.uniform(-1, 1, 2))
        expected = [False] * count
        for other in range(1, count):
            needed = 0.3 + 0.3 + 0.1 * other + 0.1
            expected[other] = not all(
                pieces_apart(mine, 0, traffic.tracks[other], k, needed)
                for k in range(traffic.sizes[other])
            )
        assert hits(*traffic.arrays, 0, heed, mine, 1, 99) == sum(expected)
        assert hits(*traffic.arrays, 0, heed, mine, 1, 1) == min(sum(expected), 1)
        only = np.array([False, True, False, False])
        assert hits(*traffic.arrays, 0, only, mine, 1, 99) == expected[1]
        some += any(expected)
    assert some > 5


def test_who_stays_is_in_the_way_and_who_vanishes_is_not() -> None:
    for after, expected in (("stay", True), ("vanish", False)):
        traffic = build_traffic(problem(2, ["vanish", after]))
        traffic.put(1, piece(0, 5, 2.0, 2.0, 1.0, 0.0))  # arrives at (7, 2) at 5 s
        traffic.put(0, piece(0, 10, 7.0, 7.0, 0.0, -1.0))  # is at (7, 2) at 5 s and goes on
        assert traffic.conflicts(0)[1]
        traffic.put(0, piece(0, 10, 7.0, 12.0, 0.0, -1.0))  # is there at 10 s
        assert bool(traffic.conflicts(0)[1]) == expected
        assert bool(traffic.conflicts(1)[0]) == expected
        traffic.remove(1)
        assert not traffic.conflicts(0).any()
