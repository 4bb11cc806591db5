"""The optimum on sampled graphs, against all choices of paths of small random graphs."""

import math
from dataclasses import replace
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.barred_path import END, Place, Way, barred_path
from conav.planning.best_response import LEAST_GAIN
from conav.planning.conflict_search import conflict_based_search
from conav.planning.graph_optimum import GraphModel
from conav.planning.joint_search import joint_search
from conav.planning.plan import plan
from conav.planning.team import GraphSettings, build_team
from conav.planning.types import PlanningProblem, PlanningRobot, Region
from conav.status import Status
from conav.tasks.automaton import INITIAL

FLOOR = PolygonMap([(0, 0), (10, 0), (10, 10), (0, 10)])
HORIZON = 14.0


def small_team(seed, robots, after="stay", costs=("length",)):
    """Robots with graphs of a few vertices, all in each other's way."""
    rng = np.random.default_rng(seed)
    made = []
    for i in range(robots):
        x, y = rng.uniform(1, 9, 2).round(2)
        u, v = (10 - x, 10 - y) if rng.random() < 0.8 else rng.uniform(1, 9, 2)
        goal = {"goal": Region("goal", disc=(float(u), float(v), 0.6))}
        radius = float(rng.uniform(0.2, 0.8))
        made.append(
            PlanningRobot(
                f"r{i}", (float(x), float(y)), "F goal", goal, radius, after_arrival=after
            )
        )
    problem = PlanningProblem(FLOOR, tuple(made), HORIZON, costs=costs)
    team = build_team(problem, GraphSettings(eta_m=30.0, gamma_m=1000.0), seed)
    for robot in range(robots):
        goal = made[robot].regions["goal"].disc
        size = int(rng.integers(3, 7))
        rows = [rng.uniform((1, 1, 1), (9, 9, HORIZON), (size, 3))]
        # Arrivals of several speeds.
        away = math.dist(made[robot].start, goal[:2])
        times = np.minimum(away * rng.uniform(1.01, 1.8, 3) + 0.1, HORIZON)
        rows.append(np.column_stack([np.tile(goal[:2], (3, 1)), times]))
        team.graphs[robot].insert(np.vstack(rows))
    return team


def all_paths(team, robot):
    """Every path of a robot by ranks, with its cost vector."""
    roads = team.roads_of(robot)
    arranged, automaton = roads[0].arranged, roads[0].automaton
    out = {}
    for head in range(len(arranged.letters)):
        for edge in range(arranged.starts[head], arranged.starts[head + 1]):
            out.setdefault(int(arranged.sources[edge]), []).append((edge, head))
    found = []
    start = int(automaton.transition[INITIAL, arranged.letters[0]])
    stack = [([0], start, np.zeros(len(roads)))]
    while stack:
        path, state, cost = stack.pop()
        if automaton.accepting[state]:
            found.append((path, cost))
        for edge, head in out.get(path[-1], []):
            after = state
            word = arranged.words[edge]
            if word >= 0:
                count = arranged.letters_of_words[word]
                for letter in arranged.letters_of_words[word + 1 : word + 1 + count]:
                    after = int(automaton.transition[after, letter])
            elif arranged.letters[path[-1]] != arranged.letters[head]:
                after = int(automaton.transition[state, arranged.letters[head]])
            more = np.array([each.costs[edge] for each in roads])
            stack.append(([*path, head], after, cost + more))
    return found


def track(team, robot, path):
    rows = team.roads_of(robot)[0].arranged.states[path][:, [2, 0, 1]]
    if team.traffic.stays[robot] and rows[-1, 0] < HORIZON:
        rows = np.vstack([rows, [HORIZON, *rows[-1, 1:]]])
    return rows


def collide(a, b, distance):
    """Whether two robots come nearer than `distance`, both being there."""
    last = min(a[-1, 0], b[-1, 0])
    times = np.unique(np.concatenate([a[:, 0], b[:, 0]]))
    times = times[times <= last]

    def between(t):
        return np.array(
            [np.interp(t, a[:, 0], a[:, k]) - np.interp(t, b[:, 0], b[:, k]) for k in (1, 2)]
        )

    points = [between(t) for t in times]
    if len(points) == 1:
        return math.hypot(*points[0]) < distance
    for p, q in pairwise(points):
        d = q - p
        share = 0.0 if not d.any() else min(max(-(p @ d) / (d @ d), 0.0), 1.0)
        if math.hypot(*(p + share * d)) < distance:
            return True
    return False


def brute_force(team):
    """All sums of plans without collisions, as rows."""
    paths = [all_paths(team, robot) for robot in range(team.size)]
    tracks = [[track(team, i, p) for p, _ in own] for i, own in enumerate(paths)]
    bodies = team.traffic.bodies
    bad = {
        (i, j): [[collide(a, b, bodies[i] + bodies[j]) for b in tracks[j]] for a in tracks[i]]
        for i, j in combinations(range(team.size), 2)
    }
    sums = [
        sum(paths[i][p][1] for i, p in enumerate(profile))
        for profile in product(*(range(len(own)) for own in paths))
        if not any(bad[i, j][profile[i]][profile[j]] for i, j in combinations(range(team.size), 2))
    ]
    return np.array(sums).reshape(len(sums), len(team.problem.costs))


def pareto(sums):
    return sorted(
        {
            tuple(np.round(row, 7))
            for row in sums
            if not any(
                (other <= row + LEAST_GAIN).all() and (other < row - LEAST_GAIN).any()
                for other in sums
            )
        }
    )


def few_paths(team, most=60):
    return all(0 < len(all_paths(team, robot)) <= most for robot in range(team.size))


def check_scalar(team):
    """1 if the optimum costs more than everybody alone, which makes the check worth something."""
    sums = brute_force(team)
    everybody = range(team.size)
    found = conflict_based_search(GraphModel(team, everybody), 3000)
    joint = joint_search(team, everybody, 100_000)
    if not len(sums):
        assert found.paths is None
        assert not found.proved or math.isinf(found.lower_bound)
        assert joint.proved
        assert not joint.plans
        assert math.isinf(joint.bound)
        return 1
    best = float(sums.min())
    assert joint.proved
    assert joint.plans[0].total[0] == pytest.approx(best, abs=1e-9)
    assert found.lower_bound <= best + 1e-9
    if found.proved:
        assert found.cost == pytest.approx(best, abs=1e-9)
        tracks = [track(team, i, driven.path) for i, driven in enumerate(found.paths)]
        bodies = team.traffic.bodies
        for i, j in combinations(everybody, 2):
            assert not collide(tracks[i], tracks[j], bodies[i] + bodies[j])
    # What is known already is not found again, and what is better is.
    known = conflict_based_search(GraphModel(team, everybody), 3000, best, LEAST_GAIN)
    assert known.paths is None
    if known.proved:
        assert known.lower_bound == pytest.approx(best, abs=1e-8)
    assert joint_search(team, everybody, 100_000, best).bound == pytest.approx(best, abs=1e-8)
    return best > float(team.solo()[:, 0].sum()) + 1e-9


def test_optimum_is_that_of_all_choices():
    hard = proved = teams = 0
    for seed in range(50):
        team = small_team(seed, 2 + seed % 2, "vanish" if seed % 5 == 0 else "stay")
        if not few_paths(team, 60 if team.size == 2 else 25):
            continue
        teams += 1
        hard += check_scalar(team)
        proved += conflict_based_search(GraphModel(team, range(team.size)), 3000).proved
    assert teams > 12
    assert hard > 5
    assert proved >= 0.9 * teams


@given(seed=st.integers(1000, 2**31), robots=st.integers(2, 3), stay=st.booleans())
@settings(max_examples=25, deadline=None)
def test_optimum_of_random_teams(seed, robots, stay):
    team = small_team(seed, robots, "stay" if stay else "vanish")
    if few_paths(team, 30 if robots == 2 else 15):
        check_scalar(team)


def test_pareto_set_is_that_of_all_choices():
    several = teams = 0
    for seed in range(300, 350):
        team = small_team(seed, 2, costs=("length", "duration"))
        if not few_paths(team):
            continue
        teams += 1
        expected = pareto(brute_force(team))
        found = joint_search(team, range(2), 100_000)
        assert found.proved
        assert sorted(tuple(np.round(p.total, 7)) for p in found.plans) == expected
        for one in found.plans:
            tracks = [track(team, i, path) for i, path in enumerate(one.paths)]
            assert not collide(*tracks, team.traffic.bodies.sum())
        several += len(expected) > 1
    assert teams > 10
    assert several > 2


def test_barred_path_is_the_cheapest_within_the_bars():
    rng = np.random.default_rng(8)
    checked = 0
    for seed in range(60):
        team = small_team(seed, 1)
        roads = team.roads_of(0)[0]
        limits = team.graphs[0].surroundings.limits
        paths = all_paths(team, 0)
        if not 1 < len(paths) < 200:
            continue
        bars = []
        for _ in range(int(rng.integers(1, 4))):
            some = track(team, 0, paths[int(rng.integers(len(paths)))][0])
            t = float(rng.uniform(0.5, HORIZON))
            x, y = (float(np.interp(t, some[:, 0], some[:, k])) for k in (1, 2))
            bars.append(Place(t, x, y, float(rng.uniform(0.1, 1.0))))
        path = paths[int(rng.integers(len(paths)))][0]
        k = int(rng.integers(len(path)))
        bars.append(Way(path[k], path[k + 1] if k + 1 < len(path) else END))

        def allowed(path, bars=bars, team=team):
            rows = track(team, 0, path)
            for bar in bars:
                if isinstance(bar, Way):
                    pairs = [*pairwise(path), (path[-1], END)]
                    if tuple(bar) in pairs:
                        return False
                elif bar.time <= rows[-1, 0]:
                    x, y = (np.interp(bar.time, rows[:, 0], rows[:, c]) for c in (1, 2))
                    if math.hypot(x - bar.x, y - bar.y) <= bar.radius:
                        return False
            return True

        costs = [cost[0] for path, cost in paths if allowed(path)]
        found = barred_path(roads, limits, True, HORIZON, tuple(bars))
        if not costs:
            assert found is None
            continue
        assert found is not None
        assert allowed(found[0].tolist())
        assert found[1] == pytest.approx(min(costs), abs=1e-12)
        checked += 1
    assert checked > 15


def test_solver_proves_an_optimum_that_is_an_equilibrium(scenes):
    problem = scenes.antipodal(2, radius=0.6)
    found = plan(problem, "social-optimum", seed=2, samples=40, guide=False, labels=30_000)
    scenes.check(problem, found)
    assert found.status == Status.DONE, found.reason
    assert found.graph_bound == pytest.approx(float(found.costs.sum()), abs=1e-6)
    assert found.epsilon.tolist() == [0.0, 0.0]
    again = plan(problem, "social-optimum", seed=2, samples=40, guide=False, labels=30_000)
    assert np.array_equal(found.costs, again.costs)
    totals = [sum(row[0] for row in entry["costs"]) for entry in found.history]
    finite = [total for total in totals if math.isfinite(total)]
    assert all(b <= a + 1e-9 for a, b in pairwise(finite))


def test_solver_gives_a_gap_when_its_budget_ends(scenes):
    problem = scenes.antipodal(4)
    found = plan(problem, "social-optimum", seed=1, samples=100, nodes=5, last_nodes=5)
    scenes.check(problem, found)
    assert found.status == Status.OUT_OF_BUDGET
    assert found.graph_bound < found.costs.sum()
    assert "last_nodes" in found.reason


def test_solver_with_several_costs(scenes):
    problem = replace(scenes.antipodal(2, radius=0.6), costs=("length", "duration"))
    found = plan(problem, "social-optimum", seed=3, samples=20, delays=2)
    scenes.check(problem, found)
    assert found.status == Status.DONE, found.reason
    sums = [entry["sum"] for entry in found.history if entry["stage"] == "optima"]
    assert len(sums) == found.counters["optima"] > 0
    assert found.costs.sum(axis=0).tolist() == pytest.approx(sums[0])
    assert all(a[0] < b[0] and a[1] > b[1] for a, b in pairwise(sums))
    short = plan(problem, "social-optimum", seed=3, samples=20, delays=2, labels=5)
    assert short.status == Status.OUT_OF_BUDGET
    assert "labels" in short.reason


def test_optimum_in_seconds_of_more_robots(scenes):
    problem = replace(scenes.antipodal(4), costs=("duration",))
    found = plan(problem, "social-optimum", seed=1, samples=200)
    scenes.check(problem, found)
    assert found.status == Status.DONE, found.reason
    assert found.solo.sum() < found.graph_bound == pytest.approx(found.costs.sum(), abs=1e-6)


def test_solver_proves_that_a_goal_in_a_wall_is_infeasible(scenes):
    robot = PlanningRobot("a", (2.0, 2.0), "F goal", scenes.disc("goal", 30, 30), 0.4)
    problem = PlanningProblem(scenes.square, (robot,), 60.0)
    assert plan(problem, "social-optimum").status == Status.INFEASIBLE


def test_other_motions_are_refused(scenes):
    robot = replace(scenes.antipodal(2).robots[0], start=(2.0, 2.0, 0.0), motion="dubins-car")
    problem = PlanningProblem(scenes.square, (robot,), 60.0)
    with pytest.raises(InputError, match="plans straight motions"):
        plan(problem, "social-optimum")
