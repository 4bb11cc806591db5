"""Delegation on floors: teams clear them, are told of losses, and end; the verifier confirms."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method
from conav.pursuit.delegation import Delegation
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.splitting import Splitting
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_pursuit, verify_schedule
from conav.robots.fault import Fault
from conav.runs.reader import read_run
from conav.runs.types import PursuitRun

from .floors import block_floor


def problem_on(
    floor: PolygonMap, pursuers: int = 1, reach_m: float | None = None, **more: Any
) -> PursuitProblem:
    start = default_start(floor)
    team = tuple(Pursuer(f"pursuer_{i + 1}", start, reach_m=reach_m) for i in range(pursuers))
    return PursuitProblem(floor, team, **more)


def accepted(problem: PursuitProblem, result: PursuitResult, folder: Path) -> bool:
    """Whether the verifier accepts the run, with all that the team believed."""
    file = folder / "run.mcap"
    record_pursuit(file, problem, result, method="delegation", settings={}, seed=0, compute_s=0.0)
    run = read_run(file)
    assert isinstance(run, PursuitRun)
    report = verify_pursuit(run)
    return report.accepted and str(report.found.verdict) == "captured"


def bounded(result: PursuitResult) -> bool:
    """Whether no round of a deliberation took more messages than O(n) allows."""
    n = len(result.pursuers)
    counters = result.counters
    return counters["longest_talk"] <= 7 * (n - 1) + 1 and counters["messages"] <= (
        counters["talks"] * (7 * (n - 1) + 1) + counters["lost"] * (n - 1)
    )


GOLD = {
    # floor: pursuers in sequence and in parallel
    "comb:6": (1, 1),
    "rooms:3": (1, 1),
    "ring": (2, 2),
    "spider:2,2,2": (2, 4),
    "triples:2": (2, 4),
    "triples:3": (3, 14),
}


@pytest.mark.parametrize(("name", "sizes"), GOLD.items())
def test_gold_floors_are_captured(name: str, sizes: tuple[int, int], tmp_path: Path) -> None:
    problem = problem_on(load_floor_plan(name))
    for order, size in zip(("sequence", "parallel"), sizes, strict=True):
        result = make_method("delegation", settings={"order": order}).solve(problem)
        assert result.status == "done"
        assert len(result.pursuers) == size
        assert result.minimal_proved == (size == 1)
        assert accepted(problem, result, tmp_path)
        assert bounded(result)
        assert result.counters["deliberations"] == 0 or result.counters["messages"] > 0


def test_it_takes_no_more_pursuers_than_splitting() -> None:
    for name in ("spider:2,2,2", "ring", "triples:3"):
        problem = problem_on(load_floor_plan(name))
        teams = [len(method.solve(problem).pursuers) for method in (Delegation(), Splitting())]
        assert teams[0] <= teams[1]


def test_the_story_of_a_spider() -> None:
    """Stuck at the middle, one more is called, holds it, and three arms are cleared."""
    result = Delegation().solve(problem_on(load_floor_plan("spider:2,2,2")))
    story = [entry["what"] for entry in result.history]
    assert story[:5] == ["stuck", "joined", "comes", "holds", "helped"]
    assert story.count("cleared") == 3
    # Roles asked and told, help asked and offered, the award, and its end.
    assert result.counters["messages"] == 6


def told(result: PursuitResult, what: str) -> list[dict[str, Any]]:
    return [dict(entry) for entry in result.history if entry["what"] == what]


def test_a_lost_guard_is_told_and_its_region_cleared_again(tmp_path: Path) -> None:
    floor = load_floor_plan("spider:2,2,2")
    whole = Delegation().solve(problem_on(floor))
    guard = int(told(whole, "holds")[0]["pursuer"][-1]) - 1
    cleared = [entry["time_s"] for entry in told(whole, "cleared")]
    # After the first arm is clear.
    problem = problem_on(floor, faults=(Fault(guard, "dies", cleared[0] + 1.0),))
    result = Delegation().solve(problem)
    (loss,) = told(result, "lost")
    assert loss["recontaminated_m2"] > 4.0  # an arm
    assert len(result.pursuers) == 3
    assert result.counters["lost"] == 1
    assert not result.schedule.active[-1, guard]
    assert accepted(problem, result, tmp_path)
    # Had nobody taken its place, somebody could have slipped away.
    ends = np.flatnonzero(result.schedule.active[:, guard])[-1] + 1
    assert ends < len(result.schedule.active)


def test_a_lost_explorer_leaves_its_part_contaminated(tmp_path: Path) -> None:
    floor = load_floor_plan("rooms:3")
    problem = problem_on(floor, faults=(Fault(0, "dies", 20.0),))
    result = Delegation().solve(problem)
    assert len(result.pursuers) == 2
    assert accepted(problem, result, tmp_path)
    assert told(result, "cleared")[0]["time_s"] > 20.0


def test_when_nobody_may_follow_it_says_so() -> None:
    floor = load_floor_plan("rooms:3")
    result = Delegation().solve(problem_on(floor, most=1, faults=(Fault(0, "dies", 20.0),)))
    assert result.status == "out_of_budget"
    assert "no more pursuers may be sent" in result.reason
    assert result.counters["lost"] == 1


def test_energy_is_kept_to(tmp_path: Path) -> None:
    """Nobody drives farther than it can, and what one cannot finish another does."""
    floor = load_floor_plan("spider:2,2,2")
    unlimited = Delegation().solve(problem_on(floor))
    problem = problem_on(floor, reach_m=20.0)
    result = Delegation().solve(problem)
    assert result.status == "done"
    assert len(result.pursuers) > len(unlimited.pursuers)
    assert accepted(problem, result, tmp_path)
    legs = np.sqrt((np.diff(result.schedule.positions, axis=0) ** 2).sum(axis=2))
    assert (legs.sum(axis=0) <= 20.0 + 1e-9).all()


def test_an_empty_pursuer_is_lost(tmp_path: Path) -> None:
    floor = load_floor_plan("comb:4")
    length = Delegation().solve(problem_on(floor)).schedule.distance_m
    problem = problem_on(floor, reach_m=length)
    result = Delegation().solve(problem)
    assert result.counters["lost"] == 1
    assert len(result.pursuers) == 1
    assert accepted(problem, result, tmp_path)


def test_nobody_with_enough_energy() -> None:
    result = Delegation().solve(problem_on(load_floor_plan("triples:2"), reach_m=0.5, most=6))
    assert result.status == "out_of_budget"


def test_help_that_would_come_late_is_refused() -> None:
    floor = load_floor_plan("spider:2,2,2")
    problem = PursuitProblem(floor, (Pursuer("one", (0.0, 0.45)),), most=4)
    patient = Delegation(cut="geometry").solve(problem)
    assert patient.status == "done"
    hasty = Delegation(cut="geometry", patience_s=0.01).solve(problem)
    assert hasty.status == "out_of_budget"
    assert hasty.counters["guards"] == 0
    assert hasty.counters["talks"] == 3  # one with each new pursuer, none of whom is there in time


def test_deadlines_are_renewed() -> None:
    """Help is lost again and again; whoever joins later is still in time."""
    floor = load_floor_plan("spider:2,2,2")
    faults = tuple(Fault(i, "dies", 2.0 * i) for i in range(1, 5))
    problem = PursuitProblem(floor, (Pursuer("one", (8.0, -4.0)),), faults=faults, most=8)
    result = Delegation().solve(problem)
    assert result.status == "done"
    assert result.counters["lost"] == 4
    assert len(result.pursuers) == 6


# A floor on which a guard moves to a place from which it holds its own windows and others'.
BOTH = (26, {"cut": "stuck", "budget": 1})


def test_a_guard_may_serve_both(tmp_path: Path) -> None:
    seed, setting = BOTH
    floor = block_floor(np.random.default_rng(seed), 5, 0.05)
    problem = problem_on(floor, 2)
    result = make_method("delegation", settings=setting).solve(problem)
    assert result.counters["served_both"] > 0
    assert accepted(problem, result, tmp_path)


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    order=st.sampled_from(["sequence", "parallel"]),
    cut=st.sampled_from(["geometry", "degree", "stuck"]),
    budget=st.sampled_from([1, 3, 500]),
    deaths=st.lists(st.tuples(st.integers(0, 3), st.floats(0.0, 15.0)), max_size=2),
    reach_m=st.sampled_from([None, 8.0, 20.0]),
    pursuers=st.integers(1, 3),
)
def test_whatever_happens_it_is_never_silently_wrong(
    tmp_path_factory: pytest.TempPathFactory,
    seed: int,
    order: str,
    cut: str,
    budget: int,
    deaths: list[tuple[int, float]],
    reach_m: float | None,
    pursuers: int,
) -> None:
    floor = block_floor(np.random.default_rng(seed), 4, 0.05)
    faults = tuple(Fault(robot, "dies", at) for robot, at in dict(deaths).items())
    problem = problem_on(floor, pursuers, reach_m, faults=faults, most=8)
    method = make_method("delegation", settings={"order": order, "cut": cut, "budget": budget})
    result = method.solve(problem)
    assert result.status in ("done", "out_of_budget")
    assert len(result.pursuers) <= 8
    if result.status == "done":
        assert accepted(problem, result, tmp_path_factory.mktemp("run"))
        assert bounded(result)
    again = method.solve(problem)
    assert np.array_equal(again.schedule.positions, result.schedule.positions)


def test_the_verifier_knows_who_is_lost(tmp_path: Path) -> None:
    """A run in which somebody goes on seeing after it was lost is rejected."""
    problem = problem_on(load_floor_plan("ring"))
    result = Delegation().solve(problem)
    end = float(result.schedule.times[-1])
    for at_s, fine in ((end + 1.0, True), (end, True), (end - 1.0, False)):
        losing = problem_on(load_floor_plan("ring"), faults=(Fault(1, "dies", at_s),))
        assert accepted(losing, result, tmp_path) == fine


def test_shadows_without_a_place_are_cleared_too(tmp_path: Path) -> None:
    floor = block_floor(np.random.default_rng(1554), 4, 0.05)
    problem = problem_on(floor)
    for method in (Delegation(budget=1), Splitting(budget=1)):
        result = method.solve(problem)
        assert result.status == "done"
        assert accepted(problem, result, tmp_path)


def test_it_can_be_stopped() -> None:
    result = Delegation().solve(problem_on(load_floor_plan("ring")), lambda size, count: False)
    assert (result.status, result.reason) == ("out_of_budget", "it was stopped")


def test_what_is_refused() -> None:
    floor = load_floor_plan("ring")
    faults = (Fault(0, "dies", 3.0),)
    with pytest.raises(InputError, match="use delegation"):
        Splitting().solve(problem_on(floor, faults=faults))
    for bad, words in (
        ((Fault(0, "stalls", 3.0),), "all it can do is die"),
        ((*faults, Fault(0, "dies", 4.0)), "dies twice"),
    ):
        with pytest.raises(ValueError, match=words):
            problem_on(floor, faults=bad)
    with pytest.raises(InputError, match="limited range"):
        Delegation().solve(PursuitProblem(floor, (Pursuer("one", (1.0, 1.0), range_m=3.0),)))
    for bad in ({"weight": -1}, {"budget": 0}, {"patience_s": -1}, {"halvings": -1}):
        with pytest.raises(InputError, match="or more"):
            make_method("delegation", settings=bad)


def test_schedules_of_those_who_join_and_are_lost() -> None:
    """Who joins is not there before; who is lost is not there after."""
    floor = load_floor_plan("ring")
    result = Delegation().solve(problem_on(floor, faults=(Fault(1, "dies", 3.0),)))
    active = result.schedule.active
    assert active[:, 0].all()
    assert active[0, 1]
    assert not active[-1, 1]
    assert not active[0, 2]
    assert active[-1, 2]
    lost = np.flatnonzero(active[:, 1])[-1]
    assert result.schedule.times[lost + 1] == pytest.approx(3.0)
    verdict = verify_schedule(floor, result.schedule, (None,) * 3).verdict
    assert str(verdict) == "captured"
