"""Couplings: the search against all choices of paths, the verifier, and scene files."""

import math
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.catalogue import SOLVERS, make_solver
from conav.planning.coupling_rule import CouplingRule, coupling_rule, spans_in
from conav.planning.joint_search import joint_search
from conav.planning.load_scene import load_scene
from conav.planning.plan import plan
from conav.planning.recorder import PlanRecorder
from conav.planning.scene_file import read_scene_file
from conav.planning.scene_writer import scene_text
from conav.planning.trajectory import straight
from conav.planning.types import Coupling, PlanningProblem, PlanningRobot, Region
from conav.planning.verify import verify_plan
from conav.planning.verify_couplings import check_couplings
from conav.planning.verify_scene import Check, read_scene
from conav.runs.reader import read_plan
from conav.runs.types import PlanRun, TrajectoryRecord
from conav.status import Status

from .test_social_optimum import all_paths, collide, small_team, track

FLOOR = PolygonMap([(0, 0), (10, 0), (10, 6), (0, 6)])
SHOP = Region("shop", disc=(5.0, 4.5, 0.8))
GATE = Region("gate", polygon=np.array([(4.0, 0.0), (6.0, 0.0), (6.0, 1.5), (4.0, 1.5)]))


def two(*couplings: Coupling, costs: tuple[str, ...] = ("duration",)) -> PlanningProblem:
    robots = (
        PlanningRobot(
            "ann", (1.0, 3.0), "F goal", {"goal": Region("goal", disc=(9, 3, 0.3))}, 0.3,
            after_arrival="vanish",
        ),
        PlanningRobot(
            "bob", (9.0, 1.0), "F goal", {"goal": Region("goal", disc=(1, 1, 0.3))}, 0.3,
            after_arrival="vanish",
        ),
    )  # fmt: skip
    return PlanningProblem(FLOOR, robots, 40.0, costs=costs, couplings=couplings)


def beside(*couplings: Coupling) -> PlanningProblem:
    """Two drive side by side, ann at half bob's speed."""
    ann, bob = two().robots
    bob = replace(bob, start=(1.0, 1.5), regions={"goal": Region("goal", disc=(9, 1.5, 0.3))})
    return replace(two(*couplings), robots=(replace(ann, speed_mps=0.5), bob))


def run_of(problem: PlanningProblem, tracks: list[np.ndarray]) -> PlanRun:
    """A run as the verifier reads it, of ways as pieces."""
    from conav.planning.recorded import problem_record

    return PlanRun(
        path=Path("plan"),
        header={"job": "plan", "problem": problem_record(problem)},
        result=None,
        timing={},
        digest="",
        intact=True,
        history=[],
        trajectories=[TrajectoryRecord(i, 0, pieces) for i, pieces in enumerate(tracks)],
        graphs={},
    )


def kept(problem: PlanningProblem, tracks: list[np.ndarray]) -> bool:
    """What the verifier says of couplings."""
    run = run_of(problem, tracks)
    check = Check("couplings")
    check_couplings(run, read_scene(run), check)
    assert check.looked == len(problem.couplings)
    return check.broken == 0


def pieces_through(rows: np.ndarray) -> np.ndarray:
    """Pieces of a path whose rows are t, x, y."""
    return straight(rows[:, 1:], rows[:, 0]).pieces.copy()


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10_000),
    kinds=st.lists(st.sampled_from(["meet", "not-before", "near"]), min_size=1, max_size=2),
    robots=st.sampled_from([2, 2, 3]),
    after=st.sampled_from(["stay", "vanish"]),
    weight=st.sampled_from([1.0, 2.0]),
)
def test_the_search_is_all_choices_of_paths(
    seed: int, kinds: list[str], robots: int, after: str, weight: float
) -> None:
    team = small_team(seed, robots, after, ("duration",))
    rng = np.random.default_rng(seed + 1)
    couplings = []
    for kind in kinds:
        pair = rng.permutation(robots)[:2]
        names = tuple(f"r{i}" for i in pair.tolist())
        x, y = rng.uniform(2, 8, 2).tolist()
        region = (
            Region("x", disc=(x, y, float(rng.uniform(1.0, 3))))
            if rng.random() < 0.5
            else Region("x", polygon=np.array([(x - 2, y - 2), (x + 2, y - 1), (x, y + 2)]))
        )
        near = float(rng.uniform(2, 6)) if kind == "meet" else float(rng.uniform(4, 9))
        couplings.append(
            Coupling(
                kind, names, None if kind == "near" else region,
                within_m=None if kind == "not-before" else near,
            )
        )  # fmt: skip
    problem = replace(team.problem, couplings=tuple(couplings))
    found = joint_search(team, range(robots), 200_000, rule=coupling_rule(problem), weight=weight)
    paths = [all_paths(team, robot) for robot in range(robots)]
    if math.prod(map(len, paths)) > 6_000:
        return
    tracks = [[track(team, i, p) for p, _ in own] for i, own in enumerate(paths)]
    bodies = team.traffic.bodies
    bad = {
        (i, j): {
            (a, b)
            for a, b in product(range(len(paths[i])), range(len(paths[j])))
            if collide(tracks[i][a], tracks[j][b], bodies[i] + bodies[j])
        }
        for i, j in combinations(range(robots), 2)
    }
    # The verifier lets robots that stay rest until the horizon itself.
    own_rows = [
        [pieces_through(team.roads_of(i)[0].arranged.states[p][:, [2, 0, 1]]) if len(p) > 1
         else np.array([[0, 0, *team.problem.robots[i].start, 0, 0, 0, 0, 0]], dtype=float)
         for p, _ in own]
        for i, own in enumerate(paths)
    ]  # fmt: skip
    best = math.inf
    for choice in product(*(range(len(own)) for own in paths)):
        total = sum(paths[i][c][1][0] for i, c in enumerate(choice))
        if total >= best or any((choice[i], choice[j]) in bad[i, j] for i, j in bad):
            continue
        if kept(problem, [own_rows[i][c] for i, c in enumerate(choice)]):
            best = total
    if math.isinf(best):
        assert not found.plans
        return
    (joint,) = found.plans
    ways = [own_rows[i][[list(p) for p, _ in own].index(joint.paths[i].tolist())]
            for i, own in enumerate(paths)]  # fmt: skip
    assert kept(problem, ways)
    if weight == 1.0:
        assert found.proved
        assert joint.total[0] == pytest.approx(best)
    else:
        assert best - 1e-9 <= joint.total[0] <= weight * best + 1e-9


def test_small_teams_have_couplings_that_matter() -> None:
    """The test above is one of something: with and without the rule optima differ, now and then."""
    dearer = 0
    for seed in range(12):
        team = small_team(seed, 2, "vanish", ("duration",))
        region = Region("x", disc=(5.0, 5.0, 2.0))
        rule = CouplingRule((Coupling("meet", ("r0", "r1"), region, within_m=2.0),), ((0, 1),))
        free = joint_search(team, range(2), 100_000)
        bound = joint_search(team, range(2), 100_000, rule=rule)
        if free.plans and bound.plans:
            assert bound.plans[0].total[0] >= free.plans[0].total[0] - 1e-9
        dearer += bool(free.plans) and (
            not bound.plans or bound.plans[0].total[0] > free.plans[0].total[0] + 1e-6
        )
    assert dearer >= 3


@pytest.mark.parametrize("kind", ["meet", "not-before"])
def test_a_rule_knows_nothing_of_graphs_before_they_grew(kind: str) -> None:
    region = Region("x", disc=(5.0, 5.0, 2.0))
    coupling = Coupling(kind, ("r0", "r1"), region, within_m=2.0 if kind == "meet" else None)
    rule, differs = CouplingRule((coupling,), ((0, 1),)), 0
    for seed in range(8):
        team = small_team(seed, 2, "vanish", ("duration",))
        found = joint_search(team, range(2), 100_000, rule=rule)
        fresh = CouplingRule((coupling,), ((0, 1),))
        again = joint_search(team, range(2), 100_000, rule=fresh)
        assert [one.total for one in found.plans] == [one.total for one in again.plans]
        differs += found.labels > 1
    assert differs


def test_spans_by_hand() -> None:
    piece = straight([(0, 0), (10, 0)], [2, 12]).pieces[0]
    ((a, b),) = spans_in(piece, Region("r", disc=(5.0, 3.0, 5.0)))
    assert (a, b) == pytest.approx((3.0, 11.0))
    hollow = np.array([(2, -1), (8, -1), (8, 1), (6, 1), (6, -0.5), (4, -0.5), (4, 1), (2, 1)])
    spans = spans_in(piece, Region("u", polygon=hollow.astype(float)))
    assert [pytest.approx(span) for span in spans] == [(4.0, 6.0), (8.0, 10.0)]
    assert spans_in(piece, Region("r", disc=(5.0, 3.0, 2.9))) == []
    rest = np.array([4.0, 9.0, 5.0, 0.0, 0, 0, 0, 0, 0])
    assert spans_in(rest, Region("r", disc=(5.0, 0.5, 0.6))) == [(4.0, 9.0)]


def meeting(within: float = 1.0) -> Coupling:
    return Coupling("meet", ("ann", "bob"), SHOP, within_m=within)


def test_the_verifier_by_hand() -> None:
    """Two cross the shop at 5 s, 0.4 m apart; ann is in it from 4.2 s, bob from 4.4 s."""
    ann = straight([(0, 4.3), (10, 4.3)], [0, 10]).pieces
    bob = straight([(10, 4.7), (0, 4.7)], [0, 10]).pieces
    entered = 5.0 - math.sqrt(0.8**2 - 0.2**2)

    def holds(*couplings: Coupling) -> bool:
        return kept(two(*couplings), [ann, bob])

    assert holds(meeting(0.41))
    assert not holds(meeting(0.39))
    assert not holds(Coupling("meet", ("ann", "bob"), GATE, within_m=9.0))
    assert holds(Coupling("near", ("ann", "bob"), within_m=math.hypot(10, 0.4) + 1e-9))
    assert not holds(Coupling("near", ("ann", "bob"), within_m=9.9))
    assert entered == pytest.approx(4.2254, abs=1e-4)
    late = bob.copy()
    late[:, :2] += 0.5
    waits = np.vstack([[0, 0.5, 10, 4.7, 0, 0, 0, 0, 0], late])
    assert kept(two(Coupling("not-before", ("bob", "ann"), SHOP)), [ann, waits])
    assert not kept(two(Coupling("not-before", ("ann", "bob"), SHOP)), [ann, waits])
    # Who never gets there need not wait; who waits for one that never comes must not be there.
    assert kept(two(Coupling("not-before", ("ann", "bob"), GATE)), [ann, waits])
    assert not kept(two(Coupling("not-before", ("ann", "bob"), SHOP, GATE)), [ann, waits])


@pytest.mark.parametrize(
    "problem",
    [
        two(meeting()),
        two(Coupling("not-before", ("bob", "ann"), GATE, SHOP), meeting()),
        beside(Coupling("near", ("ann", "bob"), within_m=3.0)),
    ],
    ids=["meet", "not-before", "near"],
)
def test_plans_keep_their_couplings_and_are_verified(
    problem: PlanningProblem, tmp_path: Path
) -> None:
    found = plan(problem, "coupled", seed=1, samples=60, batch=30)
    assert found.status == Status.DONE, found.reason
    assert found.graph_bound == pytest.approx(found.costs[:, 0].sum())
    path = tmp_path / "plan.mcap"
    with PlanRecorder(path, problem, solver="coupled", settings={}, seed=1) as recorder:
        recorder.finish(found, compute_s=0.0)
    report = verify_plan(read_plan(path))
    assert report.verdict == "verified", report.lines()
    alone = replace(problem, couplings=())
    free = plan(alone, "coupled", seed=1, samples=60, batch=30)
    assert found.costs[:, 0].sum() >= free.costs[:, 0].sum() - 1.0  # of other graphs
    # The plan without couplings does not keep them by chance, and the verifier says so.
    assert not kept(problem, [way.pieces for way in free.trajectories if way is not None])


def test_impossible_couplings_are_not_planned() -> None:
    found = plan(two(Coupling("near", ("ann", "bob"), within_m=2.0)), "coupled", samples=30)
    assert found.status == Status.OUT_OF_BUDGET
    assert "couplings" in found.reason
    assert found.trajectories == (None, None)


def test_few_labels_leave_a_plan_or_say_so() -> None:
    few = plan(two(meeting()), "coupled", seed=1, samples=60, labels=3)
    assert few.status == Status.OUT_OF_BUDGET
    assert "labels" in few.reason


@pytest.mark.parametrize("solver", [name for name in SOLVERS if name != "coupled"])
def test_other_solvers_refuse_couplings(solver: str) -> None:
    with pytest.raises(InputError, match="coupled"):
        make_solver(solver).solve(two(meeting()))


def test_what_coupled_cannot_do_is_refused() -> None:
    problem = load_scene("antipodal-circle:4")
    with pytest.raises(InputError, match="4 robots"):
        plan(problem, "coupled")
    unknown = two(Coupling("near", ("ann", "eve"), within_m=3.0))
    with pytest.raises(InputError, match="eve"):
        plan(unknown, "coupled")
    car = replace(two().robots[0], motion="dubins-car", start=(1.0, 3.0, 0.0))
    with pytest.raises(InputError, match="dubins-car"):
        plan(replace(two(meeting()), robots=(car, two().robots[1])), "coupled")
    with pytest.raises(InputError, match="haste"):
        make_solver("coupled", {"haste": 0.5})


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "meet", "robots": ("a", "b"), "within_m": 1.0},
        {"kind": "near", "robots": ("a", "b")},
        {"kind": "near", "robots": ("a", "b"), "within_m": 1.0, "region": SHOP},
        {"kind": "not-before", "robots": ("a", "b")},
        {"kind": "not-before", "robots": ("a", "a"), "region": SHOP},
    ],
)
def test_couplings_have_what_they_need(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"needs|different"):
        Coupling(**wrong)


SCENE = """
horizon_s = 40
[floor]
box = [0, 0, 10, 6]
[regions]
shop = { disc = [5, 4.5, 0.8] }
[[robots]]
name = "ann"
start = [1, 3]
goal = [9, 3, 0.3]
[[robots]]
name = "bob"
start = [9, 1]
goal = [1, 1, 0.3]
"""
MEET = '[[couplings]]\nkind = "meet"\nrobots = ["ann", "bob"]\nregion = "shop"\nwithin_m = 1\n'
WAIT = (
    '[[couplings]]\nkind = "not-before"\nrobots = ["bob", "ann"]\n'
    'region = { box = [4, 0, 6, 1.5] }\nother_region = "shop"\n'
)


def test_scene_files_are_read_written_and_read_again(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE + MEET + WAIT)
    problem = read_scene_file(path)
    meet, wait = problem.couplings
    assert (meet.kind, meet.robots, meet.within_m) == ("meet", ("ann", "bob"), 1.0)
    assert meet.region is not None
    assert meet.region.disc == (5.0, 4.5, 0.8)
    assert wait.other_region is not None
    assert wait.other_region.disc == meet.region.disc
    path.write_text(scene_text(problem))
    again = read_scene_file(path)
    assert scene_text(again) == scene_text(problem)
    assert again.couplings[1].region is not None
    assert np.array_equal(again.couplings[1].region.polygon, wait.region.polygon)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (MEET.replace("bob", "bop"), "did you mean bob"),
        (MEET.replace('"shop"', '"shpo"'), "did you mean shop"),
        (MEET.replace("within_m", "withinm"), "did you mean within_m"),
        (MEET.replace('"meet"', '"meets"'), "did you mean meet"),
        (MEET.replace("within_m = 1\n", ""), "needs within_m"),
        (MEET.replace('"bob"', '"ann"'), "different"),
        (MEET.replace('kind = "meet"', 'kind = "near"'), "near has no region"),
    ],
)
def test_mistakes_in_scene_files_are_named(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE + text)
    with pytest.raises(InputError) as error:
        read_scene_file(path)
    assert "couplings[0]" in str(error.value)
    assert words in str(error.value)


def test_robots_that_are_coupled_are_not_left_out(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE + MEET)
    with pytest.raises(InputError, match="couples ann and bob"):
        load_scene(path, robots=1)
