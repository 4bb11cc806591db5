"""Epsilon found anew: on graphs of the solver, on small ones by trying all paths, and tampered."""

import random
from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import pairwise
from math import hypot, inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conav.planning.catalogue import make_solver, settings_of
from conav.planning.graph_arrays import EDGES
from conav.planning.plan import plan
from conav.planning.recorder import PlanRecorder
from conav.planning.team import build_team
from conav.planning.trajectory import straight
from conav.planning.types import PlanningProblem, PlanningResult, PlanningRobot, Region
from conav.planning.verify import verify_plan
from conav.planning.verify_backward import backward_table
from conav.planning.verify_claims import costs_of
from conav.planning.verify_equilibrium import region_arrays, rule_of, shapes_around
from conav.planning.verify_graph import edges_of, line_word
from conav.planning.verify_scene import read_scene
from conav.planning.verify_task import names_in, read_formula, satisfied
from conav.runs.reader import read_plan
from conav.runs.types import PlanRun

from .hand_plan import hand_problem


def crossing(costs: tuple[str, ...] = ("length",), after: Any = "stay") -> PlanningProblem:
    """Two robots whose ways cross, one of which has to go by a polygon first."""
    goal = Region("goal", disc=(9.0, 3.0, 0.6))
    home = Region("home", disc=(1.0, 3.0, 0.6))
    lawn = Region("lawn", polygon=np.array([(6.5, 4.2), (9.5, 4.2), (9.5, 5.8), (6.5, 5.8)]))
    robots = (
        PlanningRobot("ann", (1, 3), "F goal & G !lawn", {"goal": goal, "lawn": lawn}, 0.3),
        PlanningRobot("bob", (9, 3), "!home U lawn & F home", {"home": home, "lawn": lawn}, 0.4),
    )
    robots = tuple(replace(robot, after_arrival=after) for robot in robots)
    return hand_problem(robots=robots, costs=costs, margin_m=0.05)


def recorded(
    path: Path, problem: PlanningProblem, result: PlanningResult, settings: dict[str, Any]
) -> PlanRun:
    with PlanRecorder(path, problem, solver="inash", settings=settings, seed=1) as recorder:
        recorder.finish(result, compute_s=0.0)
    return read_plan(path)


@pytest.fixture(scope="module", params=["forward", "paper", "two costs", "vanish"])
def solved(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> PlanRun:
    problem = crossing(
        ("length", "duration") if request.param == "two costs" else ("length",),
        "vanish" if request.param == "vanish" else "stay",
    )
    mode = "paper" if request.param == "paper" else "forward"
    solver = make_solver("inash", {"samples": 600, "mode": mode})
    result = solver.solve(problem, 4)
    path = tmp_path_factory.mktemp("solved") / "run.mcap"
    return recorded(path, problem, result, settings_of(solver))


def test_what_the_solver_says_is_so(solved: PlanRun) -> None:
    report = verify_plan(solved)
    assert report.verdict == "verified", report.lines()
    assert solved.result is not None
    if solved.result["epsilon"] is not None:
        assert next(one for one in report.checks if one.name == "equilibrium").looked == 2


def test_edges_are_those_of_the_solver(solved: PlanRun) -> None:
    scene = read_scene(solved)
    found = 0
    unsure = 0
    for number, body in enumerate(scene.bodies):
        names = sorted(names_in(read_formula(body.task)), key=lambda n: body.areas[n].disc is None)
        shapes = shapes_around(scene, body)
        edges = edges_of(
            solved.graphs[number], rule_of(solved, scene, body), body.speed, shapes,
            *region_arrays([body.areas[name] for name in names]),
        )  # fmt: skip
        found += len(edges.tails)
        unsure += int((~edges.sure).sum())
    assert solved.result is not None
    counted = solved.result["counters"]["edges"]
    assert found - unsure <= counted <= found
    assert unsure <= 0.02 * found


def told(run: PlanRun) -> str:
    (found,) = (one for one in verify_plan(run).checks if one.name == "equilibrium")
    return "\n".join(map(str, found.violations))


def test_another_epsilon(solved: PlanRun) -> None:
    assert solved.result is not None
    run = replace(solved, result={**solved.result, "epsilon": [0.0, 0.1]})
    assert "bob: could gain no more than" in told(run)


def test_a_vertex(solved: PlanRun) -> None:
    if solved.result is None or solved.result["epsilon"] is None:
        pytest.skip("this solver did not settle")
    pieces = solved.pieces(0)
    assert pieces is not None
    vertices = solved.graphs[0].copy()
    on_path = np.abs(vertices - [*pieces[1, 2:4], pieces[1, 0]]).max(axis=1) < 1e-6
    vertices[on_path, 0] += 0.01  # there can be several
    run = replace(solved, graphs={**solved.graphs, 0: vertices})
    assert "ann: is at" in told(run)
    assert "no vertex of its graph" in told(run)
    vertices = solved.graphs[0].copy()
    lonely = next(k for k in range(1, len(vertices)) if not touches(vertices[k], pieces))
    vertices[lonely] = [50.0, 50.0, 1.0]
    assert f"ann: vertex {lonely} at (50, 50)" in told(
        replace(solved, graphs={**solved.graphs, 0: vertices})
    )
    vertices = solved.graphs[1].copy()
    vertices[0, 2] = 0.5
    assert "bob: has a graph that does not begin" in told(
        replace(solved, graphs={**solved.graphs, 1: vertices})
    )
    assert "ann: has no graph" in told(replace(solved, graphs={1: solved.graphs[1]}))


def touches(vertex: np.ndarray, pieces: np.ndarray) -> bool:
    return bool((np.abs(pieces[:, :2] - vertex[2]) < 1e-9).any())


def test_a_worse_path_of_the_same_graph_is_no_equilibrium(tmp_path: Path) -> None:
    """A robot waits at its start though it need not: its duration could be less."""
    problem = replace(crossing(("duration",)), robots=crossing().robots[:1])
    settings = asdict(make_solver("inash", {"samples": 400}))
    result = plan(problem, "inash", 2, settings=settings)
    assert result.status == "done"
    vertices = result.graphs[0]
    track = result.trajectories[0]
    assert track is not None
    late = track.pieces.copy()
    late[:, :2] += 2.0
    late = np.vstack([[0, 2, 1, 3, 0, 0, 0, 0, 0], late])
    states = np.column_stack([late[:, 2:4], late[:, 0]])
    end = [*late[-1, 2:4] + (late[-1, 1] - late[-1, 0]) * late[-1, 4:6], late[-1, 1]]
    graph = np.vstack([vertices, states[1:], [end]])
    slower = replace(
        result,
        trajectories=(replace(track, pieces=late),),
        costs=np.array([[late[-1, 1]]]),
        graphs=(graph,),
    )
    run = recorded(tmp_path / "late.mcap", problem, slower, settings)
    report = verify_plan(run)
    assert report.broken() == ("equilibrium",), report.lines()
    assert "ann: could gain 2 alone, and epsilon is 0" in told(run)


# --- against all paths of small graphs ----------------------------------------------------------


def all_paths(vertices: np.ndarray, edges: dict[int, list[int]], at: int) -> Iterator[list[int]]:
    yield [at]
    for head in edges.get(at, ()):
        for rest in all_paths(vertices, edges, head):
            yield [at, *rest]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("costs", [("length",), ("duration",), ("length", "duration")])
def test_gains_against_all_paths(seed: int, costs: tuple[str, ...], tmp_path: Path) -> None:
    """Ten random vertices, no automaton, no search: the best of all paths by definition."""
    rng = random.Random(seed)
    problem = crossing(costs)
    problem = replace(problem, robots=problem.robots[:1], horizon_s=12.0)
    body = problem.robots[0]
    vertices = [(1.0, 3.0, 0.0), (4.0, 1.4, 3.5), (6.0, 1.4, 5.6), (8.8, 3.0, 8.9)]
    while len(vertices) < 10:
        vertices.append((rng.uniform(0.5, 9.5), rng.uniform(0.5, 5.5), rng.uniform(0.5, 12)))
    graph = np.array(vertices)
    settings = {**settings_of(make_solver("inash")), "eta_m": 20.0, "gamma_m": 100.0}
    present = straight([(1, 3), (1, 3), (4, 1.2), (6, 1.2), (8.8, 3.0)], [0, 0.2, 4, 6.5, 11])
    track = [(1.0, 3.0, 0.2), (4.0, 1.2, 4.0), (6.0, 1.2, 6.5), (8.8, 3.0, 11.0)]
    graph = np.vstack([graph, track])
    result = PlanningResult(
        "done", "", (present,), np.array([costs_of(present.pieces, costs)]), np.zeros(1),
        None, None, {}, (graph,),
    )  # fmt: skip
    run = recorded(tmp_path / "small.mcap", problem, result, settings)
    scene = read_scene(run)
    formula = read_formula(body.task)
    discs, rings, sides = region_arrays([scene.bodies[0].areas[name] for name in ("goal", "lawn")])
    shapes = shapes_around(scene, scene.bodies[0])
    found = edges_of(graph, rule_of(run, scene, scene.bodies[0]), 1.0, shapes, discs, rings, sides)
    while lonely := set(range(1, len(graph))) - set(found.heads.tolist()):
        # Such vertices are no part of a graph.
        graph = graph[[k for k in range(len(graph)) if k not in lonely]]
        run = replace(run, graphs={0: graph})
        found = edges_of(
            graph, rule_of(run, scene, scene.bodies[0]), 1.0, shapes, discs, rings, sides
        )
    heads: dict[int, list[int]] = {}
    for tail, head in zip(found.tails.tolist(), found.heads.tolist(), strict=True):
        heads.setdefault(tail, []).append(head)
    said = costs_of(present.pieces, costs)
    best = 0.0
    for path in all_paths(graph, heads, 0):
        word = [frozenset[str]()]
        for tail, head in pairwise(path):
            for k in range(1, 201):  # by sampling
                x, y = graph[tail, :2] + k / 200 * (graph[head, :2] - graph[tail, :2])
                letter = set()
                if hypot(x - 9, y - 3) <= 0.6:
                    letter.add("goal")
                if 6.5 <= x <= 9.5 and 4.2 <= y <= 5.8:
                    letter.add("lawn")
                if word[-1] != letter:
                    word.append(frozenset(letter))
        if not satisfied(formula, word):
            continue
        values = {
            "length": sum(hypot(*(graph[b, :2] - graph[a, :2])) for a, b in pairwise(path)),
            "duration": float(graph[path[-1], 2]),
        }
        gain = [a - values[name] for a, name in zip(said, costs, strict=True)]
        if min(gain) >= -1e-9:
            best = max(best, *gain)
    assert best > 0
    for epsilon, good in ((best, True), (best + 0.01, False), (best - 0.01, False)):
        assert run.result is not None
        changed = replace(run, result={**run.result, "epsilon": [epsilon]})
        assert (told(changed) == "") == good, (told(changed), best)


# --- parts --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    ["F a", "G !a & F b", "!b U a", "a R b", "a W b", "X a | WX b", "F (a & F b)", "a <-> F b",
     "G (a -> F b)", "coverage(a, b) & avoid(a & b)", "true", "!(a U b) | false"],
)  # fmt: skip
def test_backwards_is_as_forwards(text: str) -> None:
    formula = read_formula(text)
    table = backward_table(formula, ["a", "b"], [0, 1, 2, 3])
    letters = [frozenset[str](), frozenset("a"), frozenset("b"), frozenset("ab")]
    rng = random.Random(1)
    for _ in range(300):
        word = [rng.randrange(4) for _ in range(rng.randint(1, 7))]
        state = int(table.ends[word[-1]])
        for letter in reversed(word[:-1]):
            state = int(table.before[state, letter])
        assert bool(table.good[state]) == satisfied(formula, [letters[k] for k in word])


def test_a_line_throughregion_arrays() -> None:
    discs = np.array([[2.0, 0.0, 1.0]])
    square = np.array([(3, -1), (5, -1), (5, 1), (3, 1.0)])
    sides = np.hstack([square, np.roll(square, -1, axis=0)])
    rings = np.array([[0, 4]])
    letters = np.empty(256, np.int64)

    def word(ax: float, ay: float, bx: float, by: float) -> tuple[list[int], bool]:
        times = np.empty(256)
        count, clear = line_word(ax, ay, bx, by, discs, rings, sides, times, letters)
        return letters[:count].tolist(), clear

    # Where the disc touches the square both are met together: entered first, left then.
    assert word(0, 0, 6, 0) == ([1, 3, 2, 0], True)
    assert word(0, 0.5, 6, 0.5) == ([1, 0, 2, 0], True)
    assert word(0, 0.5, 2, 0.5) == ([1], True)
    assert word(2, 0, 2.5, 0) == ([], True)
    assert not word(0, 1, 6, 1)[1]  # grazes both
    assert not word(4, 0, 6, 2)[1]  # through a corner


def test_paths_for_robots_that_have_none(tmp_path: Path) -> None:
    problem = replace(crossing(), robots=crossing().robots[:1])
    settings = asdict(make_solver("inash", {"samples": 300}))
    result = plan(problem, "inash", 2, settings=settings)
    without = replace(
        result, trajectories=(None,), costs=np.full((1, 1), inf), status="out_of_budget"
    )
    run = recorded(tmp_path / "none.mcap", problem, without, settings)
    assert "ann: has no path, and there is one on its graph" in told(run)


def test_the_solver_counts_as_the_verifier(tmp_path: Path) -> None:
    """A graph of the start alone has no edges in both."""
    problem = crossing()
    team = build_team(problem, make_solver("inash"), 0)
    assert [int(graph.arrays.counts[EDGES]) for graph in team.graphs] == [0, 0]
