"""Verdicts known by hand, and that they do not hang on rounding."""

import numpy as np
import pytest

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule
from conav.pursuit.verify import PursuitVerdict, verify_schedule
from conav.pursuit.verify_certificate_check import certificate_faults
from conav.pursuit.verify_decide import Verdict
from conav.pursuit.verify_escape_check import escape_faults

from .floors import (
    DOORS,
    LAP,
    LEFT,
    LEFT_TO_RIGHT,
    MIDDLE,
    NINE,
    RIGHT,
    RING,
    ROOMS,
    SPIDER,
    Way,
    in_turn,
    schedule,
)

SQUARE = PolygonMap([(0, 0), (4, 0), (4, 4), (0, 4)])


def verdict(plan: PolygonMap, plan_of: Schedule, ranges: tuple[float | None, ...] = ()) -> Verdict:
    """The verdict, its certificate or path checked once more by what shares no code with it."""
    ranges = ranges or (None,) * plan_of.positions.shape[1]
    found = verify_schedule(plan, plan_of, ranges)
    _check(plan, plan_of, ranges, found)
    return found.verdict


def _check(
    plan: PolygonMap, plan_of: Schedule, ranges: tuple[float | None, ...], found: PursuitVerdict
) -> None:
    if found.verdict is Verdict.CAPTURED:
        assert found.certificate is not None
        assert certificate_faults(found.certificate) == []
    elif found.verdict is Verdict.ESCAPES:
        assert found.escape is not None
        assert escape_faults(plan, plan_of, ranges, found.escape) == []


def test_rooms_from_left_to_right_are_cleared() -> None:
    assert verdict(ROOMS, schedule(LEFT_TO_RIGHT)) is Verdict.CAPTURED


def test_rooms_from_right_to_left_are_cleared() -> None:
    assert verdict(ROOMS, schedule(LEFT_TO_RIGHT[::-1])) is Verdict.CAPTURED


def test_the_middle_room_left_out() -> None:
    assert verdict(ROOMS, schedule([LEFT, DOORS, (25, 1.5), RIGHT])) is Verdict.ESCAPES


def test_the_middle_room_last() -> None:
    way: Way = [LEFT, DOORS, (25, 1.5), RIGHT, (25, 1.5), (14, 1.5), MIDDLE]
    assert verdict(ROOMS, schedule(way)) is Verdict.ESCAPES


@pytest.mark.parametrize("upto", range(2, len(LEFT_TO_RIGHT)))
def test_rooms_not_gone_through_to_the_end(upto: int) -> None:
    assert verdict(ROOMS, schedule(LEFT_TO_RIGHT[:upto])) is Verdict.ESCAPES


def test_a_lap_round_a_block_catches_nobody() -> None:
    assert verdict(RING, schedule(LAP)) is Verdict.ESCAPES


@pytest.mark.parametrize("way", [LAP, [(2, 2), (4, 2), (4, 4), (2, 4), (2, 2)]])
def test_a_guard_and_a_walker_round_a_block(way: Way) -> None:
    assert verdict(RING, schedule([(2, 2)] * 5, way)) is Verdict.CAPTURED


def test_a_guard_who_leaves_too_soon() -> None:
    both = schedule([(2, 2)] * 5, LAP)
    active = both.active.copy()
    active[1:, 0] = False
    left = Schedule(both.times, both.positions, active)
    assert verdict(RING, left) is Verdict.ESCAPES


def test_all_walls_seen_is_not_all_seen() -> None:
    guards: list[Way] = [[at] * 2 for at in ((-5, 0), (4.5, -4.3301), (3.5, 6.0622))]
    assert verdict(NINE, schedule(*guards)) is Verdict.ESCAPES
    more: list[Way] = [*guards, [(0.7, 0.5)] * 2]
    assert verdict(NINE, schedule(*more)) is Verdict.CAPTURED


def test_a_look_round_a_room_without_corners_is_enough() -> None:
    once = Schedule(np.zeros(2), np.ones((2, 1, 2)), np.ones((1, 1), dtype=np.bool_))
    assert verdict(SQUARE, once) is Verdict.CAPTURED


def test_nobody_ever_looks() -> None:
    asleep = Schedule(np.arange(3.0), np.ones((3, 1, 2)), np.zeros((2, 1), dtype=np.bool_))
    assert verdict(SQUARE, asleep) is Verdict.ESCAPES


def test_one_pursuer_does_not_clear_a_spider() -> None:
    arms: Way = [(0, 0), (0, 4), (4, 4), (4, 8), (4, 4), (0, 4), (0, 0), (4, 0), (4, -4), (8, -4)]
    rest: Way = [(4, -4), (4, 0), (0, 0), (-4, 0), (-4, -4), (-8, -4)]
    assert verdict(SPIDER, schedule([*arms, *rest])) is Verdict.ESCAPES


def test_two_pursuers_clear_a_spider() -> None:
    # One keeps the middle in sight while the other goes down each arm and back.
    middle = (0.0, 0.0)
    arms: list[Way] = [
        [(0, 4), (4, 4), (4, 8)],
        [(4, 0), (4, -4), (8, -4)],
        [(-4, 0), (-4, -4), (-8, -4)],
    ]
    moves = [(1, place) for arm in arms for place in [*arm, *arm[-2::-1], middle]]
    assert verdict(SPIDER, in_turn(*moves, starts=[middle, middle])) is Verdict.CAPTURED


def test_a_hole_lets_hidden_places_meet_while_a_pursuer_passes() -> None:
    # Behind both ends of a block one is hidden from both ends of the drive past it, and can change
    # over behind it in between: comparing the ends of the drive would miss that.
    hall = PolygonMap([(0, 0), (10, 0), (10, 4), (0, 4)], [[(3, 2), (3, 3), (7, 3), (7, 2)]])
    assert verdict(hall, schedule([(0.5, 1), (9.5, 1)])) is Verdict.ESCAPES
    # With somebody in the gap behind the block nobody gets across.
    assert verdict(hall, schedule([(0.5, 1), (9.5, 1)], [(5, 3.5)] * 2)) is Verdict.CAPTURED


def test_short_sight() -> None:
    assert verdict(SQUARE, schedule([(2, 2)] * 2), (2.9,)) is Verdict.CAPTURED
    assert verdict(SQUARE, schedule([(2, 2)] * 2), (2.8,)) is Verdict.ESCAPES  # corners at 2.83
    # A corridor as wide as what is seen can be swept, a wider one cannot.
    hall = PolygonMap([(0, 0), (10, 0), (10, 2), (0, 2)])
    assert verdict(hall, schedule([(0, 1), (10, 1)]), (1.2,)) is Verdict.CAPTURED
    assert verdict(hall, schedule([(0, 1), (10, 1)]), (0.9,)) is Verdict.ESCAPES
    assert verdict(hall, schedule([(0, 1), (10, 1)]), (1000.0,)) is Verdict.CAPTURED


def test_who_comes_and_goes_at_the_same_moment() -> None:
    # Two take turns at the same place; the one who comes sees at the moment the other goes.
    positions = np.array([[(2, 2), (2, 2)]] * 6, dtype=np.float64)
    positions[:, 1] = [*LAP, LAP[-1]]
    times = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 4.0])
    both = Schedule(times, positions, np.ones((5, 2), dtype=np.bool_))
    assert verdict(RING, both) is Verdict.CAPTURED
    three = np.concatenate((positions, positions[:, :1]), axis=1)
    active = np.array([[1, 1, 0], [0, 1, 1], [0, 1, 1], [0, 1, 1], [0, 1, 1]], dtype=np.bool_)
    assert verdict(RING, Schedule(times, three, active)) is Verdict.CAPTURED
    # With two seconds between them somebody gets round.
    active[1:3, 2] = False
    assert verdict(RING, Schedule(times, three, active)) is Verdict.ESCAPES


@pytest.mark.parametrize("seed", range(3))
def test_a_jitter_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plan = PolygonMap(ROOMS.outer + rng.normal(0.0, 0.02, ROOMS.outer.shape))
    way = np.array(LEFT_TO_RIGHT) + rng.normal(0.0, 0.02, (len(LEFT_TO_RIGHT), 2))
    assert verdict(plan, schedule(way.tolist())) is Verdict.CAPTURED
    assert verdict(plan, schedule(way[:-1].tolist())) is Verdict.ESCAPES


def test_places_on_walls_at_corners_and_in_line_with_walls() -> None:
    # From door corner to door corner, along walls and past them.
    way: Way = [(4, 5), (4, 3), (13, 0), (13, -2), (13, 0), (24, 3), (24, 5)]
    assert verdict(ROOMS, schedule(way)) in (Verdict.CAPTURED, Verdict.ESCAPES)
    along: Way = [(6, 5), (6, 3), (24, 3), (24, 5)]
    assert verdict(ROOMS, schedule(along)) is Verdict.ESCAPES
    assert verdict(RING, schedule([(2, 2)] * 3, [(4, 2), (4, 4), (2, 4)])) is Verdict.CAPTURED


@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("mirror", [1, -1])
def test_turned_and_mirrored_floors_have_the_same_verdicts(turn: int, mirror: int) -> None:
    angle = np.array([[0, -1], [1, 0]])
    move = np.linalg.matrix_power(angle, turn) @ np.diag([mirror, 1])

    def moved(points: object) -> list[tuple[float, float]]:
        return (np.array(points) @ move.T).tolist()

    plan = PolygonMap(moved(ROOMS.outer)[::mirror])
    assert verdict(plan, schedule(moved(LEFT_TO_RIGHT))) is Verdict.CAPTURED
    assert verdict(plan, schedule(moved(LEFT_TO_RIGHT[:-1]))) is Verdict.ESCAPES
    ring = PolygonMap(moved(RING.outer)[::mirror], [moved(RING.holes[0])[::mirror]])
    assert verdict(ring, schedule(moved([(2, 2)] * 5), moved(LAP))) is Verdict.CAPTURED
    assert verdict(ring, schedule(moved(LAP))) is Verdict.ESCAPES
