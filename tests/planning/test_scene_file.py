"""Scene files: what they say, what is wrong with them, and that they can be written."""

import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import conav.planning
from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.scene_file import read_scene_file
from conav.planning.scene_format import scene_schema_text
from conav.planning.scene_writer import scene_text, write_scene
from conav.planning.types import COSTS, PLANNING_MOTIONS, PlanningProblem, PlanningRobot, Region

SCENE = """
name = "yard"
horizon_s = 40
margin_m = 0.1
costs = ["length", "duration"]
[floor]
box = [0, 0, 10, 8]
[[walls]]
box = [4, 0, 5, 5]
[[walls]]
disc = [7, 6, 0.5]
[regions]
dock = { box = [9, 2, 8, 1] }
mud = { polygon = [[1, 6], [1, 7], [2, 7]] }
far = { disc = [1, 1, 0.5] }
[defaults]
radius_m = 0.3
task = "F dock"
[[robots]]
start = [1, 3]
[[robots]]
name = "second"
start = [2, 3]
task = "F dock & G !mud & F home"
speed_mps = 2
after_arrival = "vanish"
regions = { home = { disc = [3, 3, 1] }, unused = { disc = [3, 3, 1] } }
[[robots]]
start = [6, 1, 0.5]
motion = "dubins-car"
turning_radius_m = 0.7
goal = [8, 7, 0.2]
"""


def read(folder: Path, text: str, name: str = "scene.toml") -> PlanningProblem:
    path = folder / name
    path.write_text(text)
    return read_scene_file(path)


def test_a_scene_is_read_as_it_says(tmp_path: Path) -> None:
    problem = read(tmp_path, SCENE)
    assert (problem.name, problem.horizon_s, problem.margin_m) == ("yard", 40.0, 0.1)
    assert problem.costs == ("length", "duration")
    assert problem.floor.area == 80.0 - 5.0
    assert problem.discs.tolist() == [[7.0, 6.0, 0.5]]
    first, second, third = problem.robots
    assert (first.name, second.name, third.name) == ("robot_0", "second", "robot_2")
    assert (first.task, list(first.regions)) == ("F dock", ["dock"])
    # Of the regions of the scene those the task names; its own all.
    assert sorted(second.regions) == ["dock", "home", "mud", "unused"]
    assert (first.radius_m, second.speed_mps, second.after_arrival) == (0.3, 2.0, "vanish")
    dock = first.regions["dock"].polygon
    assert dock is not None
    assert dock.tolist() == [[8, 1], [9, 1], [9, 2], [8, 2]]
    mud = second.regions["mud"].polygon
    assert mud is not None
    assert shapely.Polygon(mud).exterior.is_ccw
    # `goal` is short for a region, and its task is not that of the defaults.
    assert third.task == "F dock"
    assert third.regions["goal"].disc == (8.0, 7.0, 0.2)
    assert (third.start, third.motion, third.turning_radius_m) == ((6, 1, 0.5), "dubins-car", 0.7)


def test_goal_alone_is_a_task(tmp_path: Path) -> None:
    text = (
        "horizon_s = 9\n[floor]\nbox = [0, 0, 4, 4]\n[[robots]]\nstart = [1, 1]\ngoal = [3, 3, 0.2]"
    )
    (robot,) = read(tmp_path, text).robots
    assert (robot.task, robot.regions["goal"].disc) == ("F goal", (3.0, 3.0, 0.2))


def test_json_says_the_same(tmp_path: Path) -> None:
    import tomllib

    text = json.dumps(tomllib.loads(SCENE))
    assert scene_text(read(tmp_path, text, "scene.json")) == scene_text(read(tmp_path, SCENE))


def test_velocities_and_headings_left_out_are_zero(tmp_path: Path) -> None:
    for motion, start in (
        ("single-integrator", (6.0, 1.0)),
        ("double-integrator", (6.0, 1.0, 0.0, 0.0)),
        ("dubins-car", (6.0, 1.0, 0.0)),
    ):
        text = SCENE.replace("[6, 1, 0.5]", "[6, 1]").replace("dubins-car", motion)
        assert read(tmp_path, text).robots[2].start == start


def test_maps_are_relative_to_the_scene(tmp_path: Path) -> None:
    folder = tmp_path / "maps"
    folder.mkdir()
    (folder / "room.txt").write_text("#####\n#...#\n#.#.#\n#...#\n#####\n")
    scene = 'horizon_s = 9\n[floor]\nmap = "maps/room.txt"\nresolution = 2.0\n'
    scene += "[[robots]]\nstart = [3, 3]\ngoal = [7, 7, 0.2]"
    problem = read(tmp_path, scene)
    assert problem.floor.bounds == (2.0, 2.0, 8.0, 8.0)
    assert problem.floor.area == 32.0
    # A wall through the room leaves the part the robot starts in.
    cut = read(tmp_path, scene + "\n[[walls]]\nbox = [5, 0, 6, 10]")
    assert cut.floor.bounds == (2.0, 2.0, 5.0, 8.0)


def test_builtin_maps_have_their_settings(tmp_path: Path) -> None:
    scene = 'horizon_s = 9\n[floor]\nmap = "maze"\nsize = [12, 9]\nseed = 4\n'
    problem = read(tmp_path, scene + "[[robots]]\nstart = [1, 1]\ngoal = [5, 5, 0.2]")
    assert problem.floor.bounds[2] < 12.0
    assert problem.floor.name == "maze"


MISTAKES = [
    ('name = "yard"', 'nmae = "yard"', ["nmae: there is no key nmae at the top", "mean name?"]),
    ("horizon_s = 40", "horizon = 40", ["no key horizon at the top", "did you mean horizon_s?"]),
    ("radius_m = 0.3", "radius = 0.3", ["defaults.radius", "did you mean radius_m?"]),
    ("speed_mps = 2", "speed = 2", ["robots[1].speed", "did you mean speed_mps?"]),
    ("margin_m = 0.1", "wals = 1", ["did you mean walls?"]),
    ("disc = [7, 6, 0.5]", "disk = [7, 6, 0.5]", ["walls[1].disk", "in walls[1]", "mean disc?"]),
    ("box = [0, 0, 10, 8]", "bocks = 3", ["floor.bocks: there is no key bocks in floor", "box?"]),
    ("horizon_s = 40", "", ["the key horizon_s is missing", "horizon_s = 60"]),
    ("horizon_s = 40", "horizon_s = -1", ["horizon_s: input should be greater than 0, got -1"]),
    ("horizon_s = 40", "horizon_s = nan", ["horizon_s", "neither inf nor nan"]),
    ("horizon_s = 40", 'horizon_s = "40"', ["horizon_s", "write a number without quotes"]),
    ("horizon_s = 40", "horizon_s = 40 s", ["is no TOML", "line 3", "mend that line"]),
    ('"length", "duration"', '"legnth"', ["costs[0]: 'legnth' is none", "did you mean length?"]),
    ("dubins-car", "dubins", ["robots[2].motion", "did you mean dubins-car?"]),
    ("[6, 1, 0.5]", "[6, 1, 0.5, 1]", ["robots[2].start", "starts at x, y or x, y, heading"]),
    ("[1, 3]", "[1]", ["robots[0].start", "at least 2 items"]),
    ("{ disc = [1, 1, 0.5] }", "{}", ["regions.far", "exactly one of disc, box and polygon"]),
    ("[4, 0, 5, 5]", "[4, 0, 4, 5]", ["walls[0]", "is no polygon"]),
    ("[4, 0, 5, 5]", "[-1, -1, 11, 9]", ["leave nothing of the floor"]),
    ("[4, 0, 5, 5]", "[4, 0, 5, 8]", ["robot_0 and robot_2 start on parts of the floor"]),
    ('"second"', '"robot_0"', ["robots[1].name", "robots[0] is called robot_0 too"]),
    ("G !mud", "G !mut", ["robots[1].task", "there is no region 'mut'", "did you mean mud?"]),
    ('task = "F dock"', "", ["robots[0].task", "robot_0 has nothing to do"]),
    ("unused", "goal", []),
    ("box = [0, 0, 10, 8]", 'map = "offise"', ["floor.map", "did you mean office?"]),
    ("box = [0, 0, 10, 8]", 'map = "no.yaml"', ["no.yaml: does not exist"]),
    ("box = [0, 0, 10, 8]", 'map = "office"\nholes = [[[0,0],[1,0],[0,1]]]', ["holes is for a"]),
    ("box = [0, 0, 10, 8]", "box = [0, 0, 10, 8]\nseed = 1", ["floor", "seed is for a map"]),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "said"), MISTAKES, ids=[new for _, new, _ in MISTAKES])
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, said: list[str]) -> None:
    assert old in SCENE
    text = SCENE.replace(old, new, 1)
    if not said:
        read(tmp_path, text)
        return
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "scene.toml")) or "no.yaml" in message
    for part in said:
        assert part in message


def test_mistakes_of_json(tmp_path: Path) -> None:
    for text, said in (
        ("[]", "holds no table"),
        ('{"a": 1,}', "is no JSON"),
        ('{"name": "a", "name": "b"}', "has the key name twice"),
        ("{}", "the key"),
        ("[" * 100_000, "nested too deep"),
    ):
        with pytest.raises(InputError, match=said):
            read(tmp_path, text, "scene.json")
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe4"')
    with pytest.raises(InputError, match="not UTF-8"):
        read_scene_file(tmp_path / "latin.toml")


def test_the_published_schema_is_that_of_the_types() -> None:
    published = Path(conav.planning.__path__[0]) / "scene.schema.json"
    assert published.read_text() == scene_schema_text(), (
        'python -c "from conav.planning.scene_format import scene_schema_text as t; '
        "print(t(), end='')\" > src/conav/planning/scene.schema.json"
    )


# Round trip

numbers = st.floats(-1e6, 1e6, allow_nan=False)
positive = st.floats(1e-3, 1e3)
names = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=8)
plain_names = st.from_regex(r"[a-z][a-z_0-9]{1,6}", fullmatch=True).filter(
    lambda name: (
        name not in {"true", "false", "not", "and", "or", "always", "until", "release"}
        and name not in {"coverage", "sequence", "avoid", "eventually"}
    )
)
discs = st.tuples(numbers, numbers, positive)
START_LENGTH = {"single-integrator": 2, "double-integrator": 4, "dubins-car": 3}


@st.composite
def regions(draw: st.DrawFn, name: str) -> Region:
    if draw(st.booleans()):
        return Region(name, disc=draw(discs))
    x, y, side = draw(numbers), draw(numbers), draw(st.floats(1, 100))
    return Region(name, polygon=np.array([(x, y), (x + side, y), (x + side, y + side)]))


@st.composite
def robots(draw: st.DrawFn, name: str) -> PlanningRobot:
    motion = draw(st.sampled_from(PLANNING_MOTIONS))
    called = draw(st.lists(plain_names, min_size=1, max_size=3, unique=True))
    return PlanningRobot(
        name=name,
        start=tuple(draw(numbers) for _ in range(START_LENGTH[motion])),
        task=f"F {called[0]}",
        regions={one: draw(regions(one)) for one in called},
        radius_m=draw(positive),
        speed_mps=draw(positive),
        acceleration_mps2=draw(positive),
        turning_radius_m=draw(positive),
        motion=motion,
        after_arrival=draw(st.sampled_from(["stay", "vanish"])),
    )


@st.composite
def problems(draw: st.DrawFn) -> PlanningProblem:
    x, y, side = draw(numbers), draw(numbers), draw(st.floats(10, 1000))
    outer = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    hole = [
        (x + side / 4, y + side / 4),
        (x + side / 4, y + side / 2),
        (x + side / 2, y + side / 4),
    ]
    called = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    return PlanningProblem(
        floor=PolygonMap(outer, [hole] if draw(st.booleans()) else [], draw(names)),
        robots=tuple(draw(robots(name)) for name in called),
        horizon_s=draw(positive),
        discs=np.array(draw(st.lists(discs, max_size=2)), dtype=np.float64).reshape(-1, 3),
        costs=draw(st.sampled_from([COSTS, COSTS[:1], COSTS[::-1]])),
        margin_m=draw(st.floats(0, 10)),
        name=draw(names),
    )


def equal_regions(a: Region, b: Region) -> bool:
    if a.polygon is None or b.polygon is None:
        return (a.name, a.disc, a.polygon) == (b.name, b.disc, b.polygon)
    return a.name == b.name and np.array_equal(a.polygon, b.polygon)


@settings(max_examples=60, deadline=None)
@given(problem=problems())
def test_what_is_written_is_read_again(
    problem: PlanningProblem, tmp_path_factory: pytest.TempPathFactory
) -> None:
    again = read_scene_file(write_scene(problem, tmp_path_factory.mktemp("scene") / "scene.toml"))
    for name in ("horizon_s", "costs", "margin_m", "name"):
        assert getattr(again, name) == getattr(problem, name)
    assert again.floor.name == problem.floor.name
    assert np.array_equal(again.discs, problem.discs)
    assert len(again.floor.rings) == len(problem.floor.rings)
    for ours, theirs in zip(again.floor.rings, problem.floor.rings, strict=True):
        assert np.array_equal(ours, theirs)
    for mine, other in zip(again.robots, problem.robots, strict=True):
        for name in ("name", "start", "task", "radius_m", "speed_mps", "acceleration_mps2"):
            assert getattr(mine, name) == getattr(other, name)
        for name in ("turning_radius_m", "motion", "after_arrival"):
            assert getattr(mine, name) == getattr(other, name)
        assert list(mine.regions) == list(other.regions)
        assert all(equal_regions(mine.regions[k], other.regions[k]) for k in mine.regions)


def test_writing_needs_a_name_that_fits(tmp_path: Path) -> None:
    problem = read(tmp_path, SCENE)
    with pytest.raises(InputError, match="end the name in"):
        write_scene(problem, tmp_path / "scene.json")
    with pytest.raises(InputError, match="cannot be written"):
        write_scene(problem, tmp_path / "no" / "scene.toml")
