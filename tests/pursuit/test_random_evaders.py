"""Random evaders: what can be computed by hand, and what must hold of every schedule."""

import numpy as np
import pytest

from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.random_evaders import CaptureTimes, random_evader_capture_times
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, Schedule

from .floors import LAP, RING, schedule

L_SHAPE = PolygonMap([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)])


def times_of(floor: PolygonMap, plan: Schedule, **chosen: float) -> np.ndarray:
    settings = {"speed_mps": 1.0, "evaders": 200, "seed": 0, **chosen}
    ranges = (None,) * plan.positions.shape[1]
    return random_evader_capture_times(floor, plan, ranges, **settings).times  # type: ignore[arg-type]


def test_where_all_is_seen_everybody_is_seen_at_once() -> None:
    square = PolygonMap([(0, 0), (4, 0), (4, 3), (0, 3)])
    stand = schedule([(1, 1), (1, 1)])
    assert (times_of(square, stand) == 0.0).all()


def test_standing_evaders_are_seen_with_the_floor() -> None:
    """From (4, 0.5) the arm upwards is seen below the line through the corner (1, 1)."""
    plan = schedule([(4, 0.5), (1, 0.5), (0.5, 0.5)])
    found = times_of(L_SHAPE, plan, speed_mps=0.0, evaders=2000)
    assert np.isfinite(found).all()
    # Above y = 1 a triangle with legs 1 along y = 1 and 1/6 upwards is seen at once.
    expected = (4.0 + 1.0 / 12.0) / 7.0
    assert abs((found == 0.0).mean() - expected) < 4.0 * (expected * (1 - expected) / 2000) ** 0.5
    # At (1, 0.5) all is seen.
    assert found.max() <= 1.0


def test_range_counts() -> None:
    square = PolygonMap([(0, 0), (4, 0), (4, 4), (0, 4)])
    stand = schedule([(2, 2), (2, 2)])
    found = random_evader_capture_times(square, stand, (1.0,), speed_mps=0.0, evaders=2000, seed=3)
    share = np.pi / 16.0
    assert abs(found.caught / 2000 - share) < 4.0 * (share * (1 - share) / 2000) ** 0.5


def test_steps_tell_when_and_not_where() -> None:
    fine, coarse = (
        times_of(RING, schedule(LAP), step_s=step, evaders=60, speed_mps=3.0)
        for step in (0.0625, 0.25)
    )
    assert (fine <= coarse).all()
    assert (fine < coarse).any()
    seen = np.isfinite(coarse)
    assert seen.any()


@pytest.mark.parametrize("speed", [0.0, 0.7, 5.0])
def test_whoever_is_captured_is_seen_in_time(speed: float) -> None:
    floor = load_floor_plan("rooms:3")
    team = (Pursuer("pursuer_1", default_start(floor)),)
    plan = ClearKnownMap().solve(PursuitProblem(floor, team)).schedule
    found = times_of(floor, plan, speed_mps=speed, evaders=100, step_s=0.05)
    assert np.isfinite(found).all()
    assert found.max() <= plan.times[-1]
    again = times_of(floor, plan, speed_mps=speed, evaders=50, step_s=0.05)
    assert np.array_equal(again, found[:50])
    other = times_of(floor, plan, speed_mps=speed, evaders=50, step_s=0.05, seed=1)
    assert not np.array_equal(again, other)


def test_who_does_not_see_yet_sees_nobody() -> None:
    square = PolygonMap([(0, 0), (4, 0), (4, 3), (0, 3)])
    places = np.array([[(1, 1), (3, 1)]] * 3, dtype=np.float64)
    late = Schedule(np.array([5.0, 7.0, 8.0]), places, np.array([[False, False], [True, False]]))
    assert (times_of(square, late) == 2.0).all()


def test_means() -> None:
    some = CaptureTimes(np.array([1.0, 3.0, np.inf]))
    assert (some.caught, some.mean_s) == (2, 2.0)
    assert some.standard_error_s == pytest.approx(1.0)
    nobody = CaptureTimes(np.array([np.inf]))
    assert (nobody.caught, nobody.mean_s, nobody.standard_error_s) == (0, None, None)


@pytest.mark.parametrize(
    ("name", "value"), [("speed_mps", -1.0), ("evaders", 0), ("seed", -1), ("step_s", 0.0)]
)
def test_bad_numbers(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        times_of(L_SHAPE, schedule([(1, 1), (1, 1)]), **{name: value})
