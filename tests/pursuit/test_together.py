"""Drives at the same time: the rule for them is sound, and schedules get shorter in time alone."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method
from conav.pursuit.joint_drives import JointDrives
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.starts import default_start
from conav.pursuit.together import move_together
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.pursuit.verify import verify_pursuit, verify_schedule
from conav.runs.reader import read_run
from conav.runs.types import PursuitRun

from .floors import SPIDER, block_floor, in_turn, random_ways, schedule


def moves_on(floor: PolygonMap) -> ShadowMoves:
    return ShadowMoves(triangulate(floor.vertices, floor.ring_starts))


def team_for(plan: Schedule, speed: float = 1.0) -> list[Pursuer]:
    starts = [(x, y) for x, y in plan.positions[0].tolist()]
    return [Pursuer(f"pursuer_{i}", start, speed) for i, start in enumerate(starts)]


def solved(name: str, method: str, **chosen: object) -> tuple[PursuitProblem, PursuitResult]:
    floor = load_floor_plan(name)
    problem = PursuitProblem(floor, (Pursuer("pursuer_1", default_start(floor)),))
    return problem, make_method(method, settings=chosen).solve(problem)


def ways_of(plan: Schedule) -> list[list[Point]]:
    """The places each pursuer goes through, rests left out."""
    ways: list[list[Point]] = []
    for i in range(plan.positions.shape[1]):
        way = [(x, y) for x, y in plan.positions[:, i].tolist()]
        ways.append([way[0], *(b for a, b in pairwise(way) if a != b)])
    return ways


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_one_drive_is_what_the_rule_for_one_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    floor = block_floor(rng, 5, 0.05)
    shadows = moves_on(floor)
    ways = random_ways(floor, rng, 2, 2)
    others = shadows.team([ways[1][0]])
    a, b = (shadows.number(point) for point in ways[0][:2])
    if a != b:
        one, joint = shadows.links(others, a, b), JointDrives(shadows).links(others, ((a, b),))
        nothing = (0, 0)
        assert sorted(zip(*joint, strict=True)) == sorted(
            pair for pair in zip(*one, strict=True) if pair != nothing
        )


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_what_the_rule_calls_clear_is_clear(seed: int) -> None:
    """Several at once, on floors with holes: the verifier finds nobody that escapes."""
    rng = np.random.default_rng(seed)
    floor = block_floor(rng, 4, 0.05)
    shadows = moves_on(floor)
    joint = JointDrives(shadows)
    ways = random_ways(floor, rng, 3, 4)
    dirty = (1 << shadows.shadows([way[0] for way in ways]).count) - 1
    for leg in range(4):
        drives = [(way[leg], way[leg + 1]) for way in ways]
        standing = shadows.team([a for a, b in drives if a == b])
        numbers = tuple((shadows.number(a), shadows.number(b)) for a, b in drives if a != b)
        if numbers:
            whole = joint.after(standing, numbers, dirty, 0)
            dirty = joint.after(standing, numbers, dirty)
            assert dirty & ~whole == 0
        if dirty == 0:
            plan = schedule(*(way[: leg + 2] for way in ways))
            assert verify_schedule(floor, plan, (None,) * 3).verdict != "escapes"
            break


@pytest.mark.parametrize("method", ["known-map", "splitting"])
@pytest.mark.parametrize("name", ["spider:2,2,2", "streets:3", "triples:3"])
def test_time_falls_and_nothing_else(name: str, method: str) -> None:
    problem, alone = solved(name, method)
    _, both = solved(name, method, together="yes")
    before, after = alone.schedule, both.schedule
    assert after.times[-1] < before.times[-1]
    assert after.distance_m == pytest.approx(before.distance_m, rel=1e-12)
    assert ways_of(after) == ways_of(before)
    legs = np.sqrt((np.diff(after.positions, axis=0) ** 2).sum(axis=2))
    assert (legs <= np.diff(after.times)[:, None] * (1 + 1e-12)).all()
    found = verify_schedule(problem.floor, after, (None,) * len(both.pursuers))
    assert found.verdict == "captured"


def test_a_run_with_beliefs_is_accepted(tmp_path) -> None:  # type: ignore[no-untyped-def]
    problem, result = solved("streets:3", "known-map", together=True)
    moving = (np.diff(result.schedule.positions, axis=0) != 0).any(axis=2).sum(axis=1)
    assert moving.max() > 1
    path = tmp_path / "run.mcap"
    record_pursuit(path, problem, result, method="known-map", settings={}, seed=0, compute_s=0.0)
    run = read_run(path)
    assert isinstance(run, PursuitRun)
    report = verify_pursuit(run)
    assert report.accepted
    assert report.found.verdict == "captured"
    assert report.open_beliefs == 0


@pytest.mark.parametrize("name", ["triples:3"])
def test_guards_stand_until_they_may_go(name: str) -> None:
    """Were all to drive on as soon as they can, somebody would not be caught."""
    problem, result = solved(name, "known-map", together=True)
    ways = ways_of(result.schedule)
    longest = max(len(way) for way in ways)
    hasty = schedule(*([*way, *[way[-1]] * (longest - len(way))] for way in ways))
    none = (None,) * len(ways)
    assert verify_schedule(problem.floor, hasty, none).verdict != "captured"
    assert verify_schedule(problem.floor, result.schedule, none).verdict == "captured"


def test_what_the_rule_does_not_clear_stays_as_it_is() -> None:
    plan = in_turn((0, (-3.5, -4.5)), (1, (3.5, 4.5)), starts=[(-3.5, -0.5), (-0.5, 0.5)])
    assert verify_schedule(SPIDER, plan, (None, None)).verdict != "captured"
    assert move_together(plan, team_for(plan), moves_on(SPIDER)) is plan
    late = Schedule(plan.times, plan.positions, np.array([[True, False], [True, True]]))
    with pytest.raises(ValueError, match="all the time"):
        move_together(late, team_for(plan), moves_on(SPIDER))


def test_speeds_count() -> None:
    problem, result = solved("streets:3", "splitting")
    shadows = moves_on(problem.floor)
    slow, fast = (
        move_together(
            Schedule(
                result.schedule.times / speed, result.schedule.positions, result.schedule.active
            ),
            team_for(result.schedule, speed),
            shadows,
        )
        for speed in (1.0, 2.0)
    )
    assert slow.times[-1] == pytest.approx(2.0 * fast.times[-1])
