"""Floor plans, art galleries and maps that people made and published, read as they are.

The expected numbers are those of the tables in `SOURCES.md` of the data, which names the origin of
each file.
"""

import os
from fractions import Fraction
from pathlib import Path

import pytest
import shapely

from conav.errors import InputError
from conav.maps.polygonise import Polygonising, is_sound_simplification, polygonise
from conav.maps.read_floor_plan import FloorPlanReading, read_floor_plan
from conav.maps.read_map import read_map

DATA = Path(os.environ.get("CONAV_DATA") or "/nonexistent")
ROOMS = ("floorplans", "agp", "maps")
SAMPLE = 60  # of the files of a folder, evenly

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason="CONAV_DATA does not name the folder of published floor plans"
)


def sampled(room: str) -> list[Path]:
    files = sorted(path for path in (DATA / room).rglob("*") if path.is_file())
    # A picture with a yaml beside it is read through that.
    files = [
        path for path in files if path.suffix == ".yaml" or not path.with_suffix(".yaml").exists()
    ]
    step = -(-len(files) // SAMPLE) if files else 1
    return files[::step]


FILES = [path for room in ROOMS for path in sampled(room)]
NO_PLAN = {".sol": "is a list of guards", ".graph": ".graph is not the suffix"}
NO_PLAN_NAMES = {
    "initial_poses.txt": "means nothing here",
    "loop.yaml": "set image: loop.pgm",
}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(DATA)))
def test_every_file_is_a_floor_plan_or_one_clear_error(path: Path):
    words = NO_PLAN_NAMES.get(path.name, NO_PLAN.get(path.suffix))
    reading = FloorPlanReading(resolution=None if path.suffix != ".png" else 0.05)
    if path.name == "willow-full.pgm":
        reading = FloorPlanReading(resolution=0.1)
    if words is not None:
        with pytest.raises(InputError, match=words) as caught:
            read_floor_plan(path, reading)
        assert str(path.parent) in str(caught.value)
        assert caught.value.remedy
        return
    plan = read_floor_plan(path, reading)
    assert plan.area > 0
    x0, y0, x1, y1 = plan.bounds
    assert plan.area <= (x1 - x0) * (y1 - y0) * (1 + 1e-12)


# Of the HouseExpo contours: vertices, area [m2]
HOUSES = {
    "houseexpo/d8ea04edeb54f2f87a9b721c9667e9a5": (29, 31.4),
    "houseexpo/cc12041361ef5979f858a6dca93d3a8e": (47, 199.9),
    "houseexpo/d4a34f570341f863d822c93f02abc3b8": (548, 150.7),
    "houseexpo/82168e56a39bf090abc31108339b65c3": (1969, 319.4),
    "houseexpo_invalid/b0e60abed94918306c3c45649b7e4135": (464, 156.8),
    "houseexpo_invalid/00d57cd4450896c314a4c711aed411e1": (238, 530.5),
    "houseexpo_invalid/4a8dcf09ddbbf8f63a652dac85e28639": (2854, 583.7),
}


@pytest.mark.parametrize("name", HOUSES)
def test_house_expo(name: str):
    vertices, area = HOUSES[name]
    plan = read_floor_plan(DATA / f"floorplans/{name}_withSimStats.json")
    assert plan.area == pytest.approx(area, abs=0.06)
    assert plan.warnings[-1 if "invalid" not in name else 1].startswith("turned round")
    if "invalid" in name:
        assert vertices - 20 < len(plan.vertices) < vertices
        assert "left out" in plan.warnings[0]
    else:
        assert len(plan.vertices) == vertices


# Of the galleries: outer vertices, holes, all vertices
GALLERIES = {
    "with_solution/random-20-8": (20, 0, 20),
    "simple/randsimple-500-1": (500, 0, 500),
    "holes_simple/gB_simple-simple_75_300v-30h_1": (75, 30, 300),
    "holes_ortho/gD_ortho-ortho_120_500v-50h_1": (120, 50, 500),
    "spike/spike200n1": (112, 21, 212),
    "minarea/min-102-1": (102, 0, 102),
}


@pytest.mark.parametrize("name", GALLERIES)
def test_galleries(name: str):
    plan = read_floor_plan(DATA / f"agp/{name}.pol")
    assert (len(plan.outer), len(plan.holes), len(plan.vertices)) == GALLERIES[name]


def test_guards_of_the_solutions_are_on_the_floor():
    solutions = sorted((DATA / "agp/with_solution").glob("*.sol"))
    assert len(solutions) == 10
    for path in solutions:
        words = path.read_text().split("\n", 1)[1].split()
        values = [float(Fraction(word)) for word in words[1:]]
        guards = list(zip(values[::2], values[1::2], strict=True))
        assert len(guards) == int(words[0])
        plan = read_floor_plan(path.with_suffix(".pol"))
        # A guard may stand on a wall, where its rounded coordinates are beside it.
        assert shapely.distance(plan.polygon, shapely.points(guards)).max() < 1e-12


def test_westport_house():
    plan = read_floor_plan(DATA / "floorplans/wrld_westport_house/westport-house-floor-4.geojson")
    assert "read as degrees, as the file says" in plan.warnings[0]
    assert "without 41 wall, 38 window, 16 inaccessible_space" in plan.warnings[1]
    assert 1100 < plan.area < 1200
    office = read_floor_plan(DATA / "floorplans/wrld_westport_house/example-office-floor-g.geojson")
    assert len(office.vertices) == 4


SIMPLIFIED = [
    "maps/aws_small_house/map.yaml",
    "maps/patrolling_sim/cumberland.yaml",
    "movingai/mapf/Berlin_1_256.map",
    "movingai/mapf/den312d.map",
    "movingai/mapf/random-64-64-20.map",
]


@pytest.mark.parametrize("name", SIMPLIFIED)
def test_simplification_keeps_its_promise_on_real_maps(name: str):
    grid = read_map(DATA / name)
    radius = 3 * grid.resolution
    exact = polygonise(grid, Polygonising(evader_radius=radius, unknown="wall"))
    how = Polygonising(evader_radius=radius, tolerance=radius, unknown="wall")
    simple = polygonise(grid, how)
    assert is_sound_simplification(exact, simple, radius)
    assert len(simple.vertices) < len(exact.vertices)
