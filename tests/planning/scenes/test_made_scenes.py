"""Made scenes are what they say, the same everywhere, and feasible as far as can be said."""

import hashlib
from itertools import combinations

import numpy as np
import pytest
import shapely

from conav.errors import InputError
from conav.planning.load_scene import load_scene
from conav.planning.scene_writer import scene_text
from conav.planning.scenes.catalogue import SCENES, make_scene, scene_class
from conav.planning.types import PlanningProblem, PlanningRobot

CASES = [
    ("random-discs", {}),
    ("random-discs", {"robots": 14, "obstacles": 20, "after_arrival": "stay"}),
    ("random-discs", {"robots": 3, "obstacles": 0, "side_m": 9}),
    ("intersection", {}),
    ("intersection", {"robots": 1}),
    ("intersection", {"robots": 12, "after_arrival": "stay"}),
    ("antipodal-circle", {}),
    ("antipodal-circle", {"robots": 5}),
    ("antipodal-circle", {"robots": 41}),
    ("narrow-passage", {}),
    ("narrow-passage", {"robots": 7}),
    ("narrow-passage", {"robots": 24}),
    ("narrow-passage", {"bay": True}),
    ("office-delivery", {"robots": 4}),
    ("office-delivery", {"robots": 12, "office": 5}),
]


def centre(robot: PlanningRobot, name: str) -> tuple[float, float, float]:
    disc = robot.regions[name].disc
    assert disc is not None
    return disc


def clearance(problem: PlanningProblem, x: float, y: float) -> float:
    """From walls and discs [m]; negative off the floor."""
    point = shapely.Point(x, y)
    if not problem.floor.contains((x, y)):
        return -1.0
    walls = shapely.distance(problem.floor.polygon.boundary, point)
    discs = [np.hypot(x - a, y - b) - r for a, b, r in problem.discs.tolist()]
    return min([float(walls), *discs])


@pytest.fixture(
    scope="module", params=CASES, ids=lambda case: f"{case[0]}-{case[1].get('robots', '')}"
)
def problem(request: pytest.FixtureRequest) -> PlanningProblem:
    name, settings = request.param
    return make_scene(name, settings, seed=11)


def test_robots_start_free_and_apart(problem: PlanningProblem) -> None:
    for robot in problem.robots:
        assert clearance(problem, *robot.start[:2]) >= robot.radius_m
    for a, b in combinations(problem.robots, 2):
        away = np.hypot(a.start[0] - b.start[0], a.start[1] - b.start[1])
        assert away > a.radius_m + b.radius_m


def test_goals_are_free_and_can_all_be_taken(problem: PlanningProblem) -> None:
    goals: list[tuple[float, float, float, float]] = []
    for robot in problem.robots:
        for name in robot.regions:
            x, y, radius = centre(robot, name)
            if name == "c":  # the one to keep out of
                assert np.hypot(x - robot.start[0], y - robot.start[1]) > radius
                continue
            assert clearance(problem, x, y) >= robot.radius_m
            goals.append((x, y, radius, robot.radius_m))
    for (ax, ay, a, ra), (bx, by, b, rb) in combinations(goals, 2):
        assert np.hypot(ax - bx, ay - by) >= ra + rb + a + b - 1e-9 or goals_of_one(problem, ax, bx)


def goals_of_one(problem: PlanningProblem, x: float, other: float) -> bool:
    return any(
        {x, other} <= {centre(robot, name)[0] for name in robot.regions} for robot in problem.robots
    )


def test_each_robot_alone_has_a_way(problem: PlanningProblem) -> None:
    # The floor shrunk by the radius, as 16-sided rounding draws it: a little smaller than exact.
    for robot in problem.robots:
        room = shapely.buffer(problem.floor.polygon, -robot.radius_m, quad_segs=8)
        for x, y, r in problem.discs.tolist():
            room = shapely.difference(room, shapely.Point(x, y).buffer(r + robot.radius_m))
        if "c" in robot.regions:
            x, y, r = centre(robot, "c")
            room = shapely.difference(room, shapely.Point(x, y).buffer(r))
        stops = [robot.start[:2], *(centre(robot, k)[:2] for k in robot.regions if k != "c")]
        parts = [
            [i for i, part in enumerate(shapely.get_parts(room)) if part.intersects(point)]
            for point in map(shapely.Point, stops)
        ]
        assert all(part == parts[0] and len(part) == 1 for part in parts)


def test_names_and_numbers(problem: PlanningProblem) -> None:
    assert [robot.name for robot in problem.robots] == [
        f"robot_{index}" for index in range(len(problem.robots))
    ]
    fastest = max(
        np.hypot(*(np.array(centre(robot, name)[:2]) - robot.start[:2])) / robot.speed_mps
        for robot in problem.robots
        for name in robot.regions
    )
    assert problem.horizon_s > 1.5 * fastest


def test_office_robots_can_take_turns() -> None:
    """With all others at their starts or anywhere in their places, each still gets to its own."""
    problem = make_scene("office-delivery", {"robots": 6, "office": 3}, seed=2)
    radius = problem.robots[0].radius_m
    room = shapely.buffer(problem.floor.polygon, -radius, quad_segs=8)
    blocked: list[list[shapely.Polygon]] = []
    for robot in problem.robots:
        spots = [(robot.start[0], robot.start[1], 0.0)]
        spots += [centre(robot, name) for name in robot.regions if name != "c"]
        blocked.append([shapely.Point(x, y).buffer(2 * radius + r) for x, y, r in spots])
    for index, robot in enumerate(problem.robots):
        others = [spot for k, spots in enumerate(blocked) if k != index for spot in spots]
        x, y, r = centre(robot, "c")
        left = shapely.difference(room, shapely.union_all([*others, shapely.Point(x, y).buffer(r)]))
        stops = [robot.start[:2], *(centre(robot, k)[:2] for k in robot.regions if k != "c")]
        parts = shapely.get_parts(left)
        (home,) = [part for part in parts if part.intersects(shapely.Point(stops[0]))]
        assert all(home.intersects(shapely.Point(stop)) for stop in stops)


def test_a_passage_is_for_one() -> None:
    for settings in ({}, {"bay": True}):
        problem = make_scene("narrow-passage", settings)
        radius = problem.robots[0].radius_m
        middle = shapely.LineString([(1.5, -9), (1.5, 9)])
        across = shapely.intersection(problem.floor.polygon, middle).length
        assert 2 * radius < across < 4 * radius
    bay = make_scene("narrow-passage", {"bay": True})
    x = 8 * 0.3 - 4
    across = shapely.intersection(bay.floor.polygon, shapely.LineString([(x, -9), (x, 9)])).length
    assert across >= 4 * bay.robots[0].radius_m


def test_traffic_leaves_by_every_arm_and_turns_every_way() -> None:
    problem = make_scene("intersection", {"robots": 12})
    turns = {"straight": 0, "left": 0, "right": 0}
    arms: dict[tuple[int, int], int] = {}
    for robot in problem.robots:
        x, y = robot.start[:2]
        goal_x, goal_y, _ = centre(robot, "goal")
        ahead = np.array([-np.sign(x), 0] if abs(x) > abs(y) else [0, -np.sign(y)])
        arm = [np.sign(goal_x), 0] if abs(goal_x) > abs(goal_y) else [0, np.sign(goal_y)]
        cross = ahead[0] * arm[1] - ahead[1] * arm[0]
        turns["straight" if cross == 0 else "left" if cross > 0 else "right"] += 1
        arms[(int(arm[0]), int(arm[1]))] = arms.get((int(arm[0]), int(arm[1])), 0) + 1
        # On the right of the street, in and out.
        right = np.array([ahead[1], -ahead[0]])
        assert right @ (x, y) > 0
        assert arm[1] * goal_x - arm[0] * goal_y > 0
    assert turns == {"straight": 4, "left": 4, "right": 4}
    assert set(arms.values()) == {3}


def test_the_six_of_the_paper_go_all_ways() -> None:
    assert len(make_scene("intersection").robots) == 6
    assert len(make_scene("random-discs").robots) == 8


HASHES = {
    "random-discs": "87737816ed2a21f3",
    "intersection": "68888ec5929ac8da",
    "antipodal-circle": "9490c07200ae89e7",
    "narrow-passage": "1fe45d480fd59d29",
    "office-delivery": "0f6415edc2aa58b7",
}


@pytest.mark.parametrize("name", SCENES)
def test_a_seed_makes_the_same_scene_on_every_machine(name: str) -> None:
    text = scene_text(make_scene(name, {"robots": 2}, seed=7))
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == HASHES[name]
    assert scene_text(make_scene(name, {"robots": 2}, seed=7)) == text


def test_seeds_differ_where_something_is_random() -> None:
    for name in ("random-discs", "office-delivery"):
        settings = {"robots": 2}
        assert scene_text(make_scene(name, settings, seed=1)) != scene_text(
            make_scene(name, settings, seed=2)
        )


def test_every_made_scene_says_what_it_is() -> None:
    for name in SCENES:
        first = (scene_class(name).__doc__ or "").split("\n\n")[0]
        assert first.endswith(".")
        assert len(first) < 100


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("random-disks", "did you mean random-discs?"),
        ("nothing", "is neither a scene file nor a made scene"),
        ("random-discs:8,obstacels=3", "has no such setting; did you mean obstacles?"),
        ("random-discs:8,5", "'5' is not name=value"),
        ("random-discs:many", "'many' is not name=value"),
        ("random-discs:0", "setting 'robots' of scene random-discs"),
        ("random-discs:seed=x", "'x' is not a whole number"),
        ("random-discs:seed=-1", "the seed must not be negative"),
        ("random-discs:smallest_m=2", "smallest_m is greater than largest_m"),
        ("random-discs:90", "robot_.* finds no place in the scene; ask for fewer"),
        ("random-discs:obstacles=200", "obstacle .* finds no place"),
        ("narrow-passage:3,bay=yes", "with a bay it has 2 robots, not 3"),
        ("narrow-passage:bay=yes,length_m=2", "too short for its bay"),
        ("intersection:12,arm_m=5", "do not fit into the lanes"),
        ("office-delivery:2,avoid_m=40", "finds no place for a c"),
        ("scene.toml:3", "only a number of robots"),
    ],
)
def test_mistakes_are_named(source: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_scene(source)


def test_a_name_says_robots_settings_and_seed() -> None:
    problem = load_scene("random-discs:5,obstacles=2,seed=9,after-arrival=stay", seed=1)
    assert (len(problem.robots), len(problem.discs)) == (5, 2)
    assert problem.robots[0].after_arrival == "stay"
    same = make_scene(
        "random-discs", {"robots": 5, "obstacles": 2, "after_arrival": "stay"}, seed=9
    )
    assert scene_text(problem) == scene_text(same)
    assert len(load_scene("random-discs", robots=3).robots) == 3
    assert len(load_scene("random-discs:4", robots=3).robots) == 4
