"""Scenes in other people's formats: small ones written here, and all of the published ones."""

import json
import os
from itertools import combinations, pairwise
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
import shapely

from conav.errors import InputError
from conav.planning.foreign.cells import DISC_CELLS
from conav.planning.foreign.cgshop import read_cgshop
from conav.planning.foreign.db_cbs import read_db_cbs
from conav.planning.foreign.movingai_scenario import read_movingai_scenario
from conav.planning.load_scene import load_scene
from conav.planning.plan import plan
from conav.planning.recorder import PlanRecorder
from conav.planning.types import PlanningProblem, PlanningRobot
from conav.planning.verify import verify_plan
from conav.runs.reader import read_plan

DB_CBS = """
environment:
  min: [0, -1]
  max: [4, 2]
  obstacles:
    - {type: box, center: [2, 0.5], size: [1, 2]}
robots:
  - {type: double_integrator_0, start: [1, 1, 0, 0], goal: [3, 1, 0, 0]}
  - {type: unicycle_first_order_0, start: [1, 0, 3.1], goal: [3, 0, 0]}
"""


def goal(robot: PlanningRobot) -> tuple[float, float, float]:
    disc = robot.regions["goal"].disc
    assert disc is not None
    return disc


def read_yaml(folder: Path, text: str) -> PlanningProblem:
    path = folder / "scene.yaml"
    path.write_text(text)
    return read_db_cbs(path)


def test_db_cbs_robots_are_discs_in_an_area_for_centres(tmp_path: Path) -> None:
    problem = read_yaml(tmp_path, DB_CBS)
    first, second = problem.robots
    assert (first.radius_m, second.radius_m) == (0.15, sqrt(0.25**2 + 0.125**2))
    assert (first.start, goal(first)) == ((1.0, 1.0), (3.0, 1.0, 0.1))
    assert (first.task, first.speed_mps, first.after_arrival) == ("F goal", 0.5, "stay")
    assert problem.floor.bounds == (-0.15, -1.15, 4.15, 2.15)
    assert problem.floor.area == pytest.approx(4.3 * 3.3 - 2)
    assert problem.horizon_s == 60.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("double_integrator_0", "quadrotor_0", r"robots\[0\].type: 'quadrotor_0' is no robot"),
        ("[1, 1, 0, 0]", "[1, 1]", r"robots\[0\].start: is \[1, 1\], not 4 numbers"),
        ("[1, 1, 0, 0]", "[1, one, 0, 0]", r"robots\[0\].start"),
        ("[1, 1, 0, 0]", "[1, .nan, 0, 0]", "give finite numbers"),
        ("[1, 1, 0, 0]", "[1, true, 0, 0]", r"robots\[0\].start"),
        ("type: box", "type: ball", r"environment.obstacles\[0\].type: 'ball' is not read"),
        ("size: [1, 2]", "size: [1, -2]", "is not positive"),
        ("max: [4, 2]", "max: [4, -2]", "max is not beyond min"),
        ("robots:", "robuts:", "robots: there is none"),
        ("environment:", "environ:", "environment: is missing"),
        ("  - {type: double", "  - [type: double", "is no yaml, line"),
    ],
)
def test_db_cbs_mistakes_are_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_yaml(tmp_path, DB_CBS.replace(old, new, 1))


def test_cgshop_cells_are_square_metres(tmp_path: Path) -> None:
    path = tmp_path / "a.instance.json"
    content = {"name": "a", "starts": [[0, 0], [1, 0]], "targets": [[1, 2], [0, 2]]}
    path.write_text(json.dumps({**content, "obstacles": [[0, 1], [1, 2]]}))
    problem = load_scene(path)
    assert problem.floor.bounds == (-5.5, -5.5, 6.5, 7.5)
    # Two cells that share a corner: one hole, and no way through between them.
    assert len(problem.floor.holes) == 1
    assert problem.robots[0].start == (0.0, 0.0)
    assert goal(problem.robots[1]) == (0.0, 2.0, 0.1)
    assert problem.name == "a"


def test_cgshop_mistakes_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    whole = {"starts": [[0, 0]], "targets": [[1, 2]], "obstacles": []}
    for change, said in (
        ({"targets": []}, "there are 0 for 1 starts"),
        ({"starts": [[0, 0.5]]}, r"starts\[0\]: \[0, 0.5\] is no cell"),
        ({"obstacles": 3}, "obstacles: is no list of cells"),
    ):
        path.write_text(json.dumps({**whole, **change}))
        with pytest.raises(InputError, match=said):
            read_cgshop(path)
    path.write_text(json.dumps({"instance": "b", "steps": []}))
    with pytest.raises(InputError, match=r"is a solution, not a problem; give the instance, b\."):
        load_scene(path)
    path.write_text("{}")
    with pytest.raises(InputError, match="is no CG:SHOP instance"):
        read_cgshop(path)


MAP = "type octile\nheight 3\nwidth 4\nmap\n....\n.@..\n....\n"
SCEN = "version 1\n0\tfolder/a.map\t4\t3\t0\t0\t3\t2\t5.0\n0\tfolder/a.map\t4\t3\t2\t1\t0\t2\t2.4\n"


def read_scen(folder: Path, scen: str = SCEN, **options: int) -> PlanningProblem:
    (folder / "a.map").write_text(MAP)
    (folder / "a.scen").write_text(scen)
    return read_movingai_scenario(folder / "a.scen", **options)


def test_movingai_rows_count_from_the_top(tmp_path: Path) -> None:
    problem = read_scen(tmp_path)
    assert problem.floor.bounds == (0.0, 0.0, 4.0, 3.0)
    assert problem.floor.area == 11.0
    assert problem.robots[0].start == (0.5, 2.5)
    assert goal(problem.robots[0])[:2] == (3.5, 0.5)
    assert problem.robots[1].start == (2.5, 1.5)
    assert len(read_scen(tmp_path, robots=1).robots) == 1
    assert len(load_scene(f"{tmp_path / 'a.scen'}:1").robots) == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("version 1", "version 2", "line 1: is not 'version 1'"),
        ("\t5.0", "", "line 2: is no entry; its nine columns"),
        ("\t4\t3\t0", "\t4\tthree\t0", "line 2: is no entry"),
        ("folder/a.map\t4\t3\t0", "folder/b.map\t4\t3\t0", "line 2: its map folder/b.map is not"),
        ("folder/a.map\t4\t3\t2", "folder/b.map\t4\t3\t2", "line 3: is on folder/b.map, not"),
        ("\t4\t3\t2\t1", "\t4\t5\t2\t1", "line 3: says 4 x 5, and the map is 4 x 3"),
        ("\t2\t1\t0\t2", "\t1\t1\t0\t2", "line 3: its start 1, 1 is not free"),
        ("\t2\t1\t0\t2", "\t2\t1\t0\t7", "line 3: its goal 0, 7 is not free"),
    ],
)
def test_movingai_mistakes_are_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in SCEN
    with pytest.raises(InputError, match=said):
        read_scen(tmp_path, SCEN.replace(old, new, 1))
    with pytest.raises(InputError, match="has 2 entries, not 3"):
        read_scen(tmp_path, robots=3)


def test_discs_are_small_enough_for_every_plan_from_cell_to_cell() -> None:
    # One robot leaves a cell at a right angle while another enters it, both at the same speed.
    t = np.linspace(0.0, 1.0, 20_001)
    leaving, entering = np.stack([t, 0 * t]), np.stack([0 * t, t - 1])
    least = np.sqrt(((leaving - entering) ** 2).sum(axis=0)).min()
    assert 2 * DISC_CELLS < least < 2 * DISC_CELLS + 0.01


# Published scenes

DATA = os.environ.get("CONAV_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="CONAV_DATA names no folder of published scenes")


def published(pattern: str) -> list[Path]:
    return sorted(Path(DATA).glob(pattern)) if DATA else []


def faults(problem: PlanningProblem) -> set[str]:
    """What keeps the robots from being at their starts, or all at their goals."""
    found: set[str] = set()
    border = problem.floor.polygon.boundary
    for robot in problem.robots:
        for what, (x, y) in (("start", robot.start[:2]), ("goal", goal(robot)[:2])):
            free = bool(problem.floor.contains((x, y)))
            if not free or shapely.distance(border, shapely.Point(x, y)) < robot.radius_m - 1e-9:
                found.add(f"{what} in a wall")
    for a, b in combinations(problem.robots, 2):
        reach = a.radius_m + b.radius_m
        if np.hypot(a.start[0] - b.start[0], a.start[1] - b.start[1]) < reach:
            found.add("starts too near")
        (ax, ay, ar), (bx, by, br) = goal(a), goal(b)
        if np.hypot(ax - bx, ay - by) + ar + br < reach:
            found.add("goals too near")
    return found


@needs_data
@pytest.mark.parametrize("path", published("mrmp/**/*.*"), ids=lambda path: path.name)
def test_every_published_multi_robot_scene_reads_or_says_why(path: Path) -> None:
    if ".solution." in path.name:
        with pytest.raises(InputError, match="is a solution, not a problem"):
            load_scene(path)
        return
    problem = load_scene(path)
    # The file says so itself: two robots have one goal.
    assert faults(problem) == ({"goals too near"} if path.stem == "infeasible_0" else set())


@needs_data
@pytest.mark.parametrize("path", published("mrmp/**/gen_p10_n4_0_unicycle_sphere.yaml"))
@pytest.mark.parametrize("solver", ["inash", "prioritized", "anytime-prioritized"])
def test_plans_of_a_tight_published_scene_are_verified(
    path: Path, solver: str, tmp_path: Path
) -> None:
    problem = load_scene(path)
    found = plan(problem, solver, seed=1, samples=1000)
    with PlanRecorder(
        tmp_path / "plan.mcap", problem, solver="by-hand", settings={}, seed=1
    ) as record:
        record.finish(found, compute_s=0.0)
    report = verify_plan(read_plan(tmp_path / "plan.mcap"))
    assert report.accepted, report.lines()
    assert report.planned == 4


@needs_data
@pytest.mark.parametrize("path", published("movingai/mapf/*-*-1.scen"), ids=lambda path: path.name)
def test_published_scenarios_of_many_robots_start_free_and_apart(path: Path) -> None:
    problem = load_scene(f"{path}:20")
    assert len(problem.robots) == 20
    assert faults(problem) == set()


@needs_data
def test_published_entries_for_one_robot_read_too() -> None:
    for path in published("movingai/**/*.map.scen"):
        assert faults(load_scene(f"{path}:1")) == set()


@needs_data
@pytest.mark.parametrize("name", ["small_000_10x10_20_10", "small_free_001_10x10_40_40"])
def test_published_plans_from_cell_to_cell_are_plans_of_the_discs(name: str) -> None:
    """Replayed at unit speed, discs touch nothing and nobody: the scenes are solvable."""
    folder = Path(str(DATA)) / "mrmp/cgshop2021"
    problem = load_scene(folder / f"{name}.instance.json")
    steps = json.loads((folder / f"{name}.solution.json").read_text())["steps"]
    moves = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}
    places = [np.array([robot.start[:2] for robot in problem.robots])]
    for step in steps:
        place = places[-1].copy()
        for robot, direction in step.items():
            place[int(robot)] += moves[direction]
        places.append(place)
    goals = np.array([goal(robot)[:2] for robot in problem.robots])
    assert np.array_equal(places[-1], goals)
    radius = problem.robots[0].radius_m
    border = problem.floor.polygon.boundary
    pairs = np.triu_indices(len(problem.robots), 1)
    for before, after in pairwise(places):
        ways = shapely.linestrings(np.stack([before, after], axis=1))
        assert problem.floor.contains(after).all()
        assert shapely.distance(ways, border).min() >= radius
        # The least distance of two that move straight over the same time.
        gap = (before[:, None] - before)[pairs]
        drift = (after[:, None] - after)[pairs] - gap
        square = (drift**2).sum(axis=1)
        at = np.clip(-(gap * drift).sum(axis=1) / np.where(square > 0, square, 1), 0, 1)
        least = np.sqrt(((gap + drift * at[:, None]) ** 2).sum(axis=1)).min()
        assert least >= 2 * radius
