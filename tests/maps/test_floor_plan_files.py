"""Floor plan files: each format, both ways where it is written, and what is refused."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.floor_plans.catalogue import builtin_floor_plan
from conav.maps.geojson import to_geojson
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_json import to_polygon_json
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import Polygonising
from conav.maps.read_floor_plan import (
    FLOOR_PLAN_READERS,
    FloorPlanReading,
    is_floor_plan_file,
    read_floor_plan,
)
from conav.maps.write_floor_plan import write_floor_plan

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10]]
HOLE = [[2, 2], [2, 4], [4, 4], [4, 2]]
CLOSED = [[*SQUARE, SQUARE[0]], [*HOLE, HOLE[0]]]
POLYGON = {"type": "Polygon", "coordinates": CLOSED}
SMALL = {"type": "Polygon", "coordinates": [[[20, 0], [21, 0], [21, 1], [20, 0]]]}
POINT = {"type": "Point", "coordinates": [1, 1]}


def feature(geometry: object, **properties: object) -> dict[str, object]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


TEXTS = {
    "a.json": json.dumps({"outer": SQUARE, "holes": [HOLE]}),
    "verts.json": json.dumps({"verts": SQUARE, "id": "x", "room_num": 3}),
    "geo.json": json.dumps(POLYGON),
    "a.geojson": json.dumps(feature(POLYGON)),
    "collection.geojson": json.dumps(
        {"type": "FeatureCollection", "features": [feature(SMALL), feature(POLYGON), feature(None)]}
    ),
    "multi.geojson": json.dumps(
        {"type": "MultiPolygon", "coordinates": [SMALL["coordinates"], CLOSED]}
    ),
    "geometries.geojson": json.dumps(
        {"type": "GeometryCollection", "geometries": [POINT, POLYGON]}
    ),
    "a.wkt": "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (2 2, 2 4, 4 4, 4 2, 2 2))",
    "multi.wkt": "SRID=3857;MULTIPOLYGON (((20 0, 21 0, 21 1, 20 0)),"
    " ((0 0, 10 0, 10 10, 0 10, 0 0), (2 2, 2 4, 4 4, 4 2, 2 2)))",
    "z.wkt": "POLYGON Z ((0 0 1, 10 0 1, 10 10 1, 0 10 1, 0 0 1),"
    " (2 2 1, 2 4 1, 4 4 1, 4 2 1, 2 2 1))",
    "a.pol": "4 0/1 0/1 10/1 0/1 20/2 10/1 0 10\n1\n4 2/1 2/1 2 4 8/2 4/1 4 2",
    "bare.pol": "4 0/1 0/1 10/1 0/1 10/1 10/1 0/1 10/1 ",
    "a.environment": "//Outer\n0 0\n10 0\n10 10\n0 10\n//Hole\n2 2\n2 4\n4 4\n4 2\n",
    "a.dat": "0 0\n10 0\n10 10\n0 10\n",
    "a.xy": "0, 0\n10, 0\n10\t10\n0 1e1\n\n2 2\n2 4\n4 4\n4 2\n",
    "points.txt": "# two rings\n0 0\n10 0\n10 10\n0 10\n# hole\n2 2\n2 4\n4 4\n4 2\n",
    "drawn.txt": "\n".join(["." * 10] * 10),
    "drawn.ascii": "\n".join(["." * 10] * 10),
    "grid.map": "type octile\nheight 10\nwidth 10\nmap\n" + "\n".join(["." * 10] * 10) + "\n",
}


@pytest.mark.parametrize("name", TEXTS)
def test_the_same_square_in_every_format(name: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(TEXTS[name])
    plan = read_floor_plan(path)
    assert plan.bounds == (0, 0, 10, 10)
    assert plan.area == (96 if plan.holes else 100)
    assert plan.name == path.stem
    assert is_floor_plan_file(path) == (not name.startswith(("drawn", "grid")))
    odd = [note for note in plan.warnings if "largest of 2" not in note and "left out" not in note]
    assert odd == []
    assert load_floor_plan(str(path)).area == plan.area


def test_every_suffix_has_an_example():
    assert {Path(name).suffix for name in TEXTS} >= set(FLOOR_PLAN_READERS)


def test_a_part_by_number(tmp_path: Path):
    for name in ("collection.geojson", "multi.geojson", "multi.wkt"):
        path = tmp_path / name
        path.write_text(TEXTS[name])
        assert read_floor_plan(path, FloorPlanReading(part=0)).area == 0.5
        with pytest.raises(InputError, match="part 2: there are 2"):
            read_floor_plan(path, FloorPlanReading(part=2))


def test_an_indoor_map_is_its_outline_without_walls(tmp_path: Path):
    def box(x0: float, y0: float, x1: float, y1: float) -> dict[str, object]:
        ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]
        return {"type": "Polygon", "coordinates": [ring]}

    features = [
        feature(box(0, 0, 10, 10), type="building_outline"),
        feature(box(4, 0, 5, 7), type="wall"),
        feature(box(4, 8, 5, 10), type="window"),
        feature(box(4, 7, 5, 8), type="door"),
        feature(box(7, 7, 8, 8), type="inaccessible_space"),
        feature(box(1, 1, 2, 2), type="stairs"),
    ]
    path = tmp_path / "indoor.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    plan = read_floor_plan(path)
    assert plan.area == 100 - 7 - 2 - 1
    assert plan.contains([(4.5, 7.5), (1.5, 1.5), (4.5, 3), (7.5, 7.5)]).tolist() == [
        *(True, True, False, False)
    ]
    assert "1 wall, 1 window, 1 inaccessible_space; passable: door, stairs" in plan.warnings[0]


LON, LAT = -2.979, 56.462


def degrees(extent: float) -> dict[str, object]:
    ring = [[LON, LAT], [LON + extent, LAT], [LON + extent, LAT + extent], [LON, LAT]]
    return {"type": "Polygon", "coordinates": [ring]}


def test_degrees_are_laid_flat(tmp_path: Path):
    path = tmp_path / "a.geojson"
    path.write_text(json.dumps(degrees(0.001)))
    plan = read_floor_plan(path)
    # Metres in a degree, as series of WGS 84.
    phi = math.radians(LAT + 0.0005)
    east = 111412.84 * math.cos(phi) - 93.5 * math.cos(3 * phi) + 0.118 * math.cos(5 * phi)
    north = 111132.954 - 559.822 * math.cos(2 * phi) + 1.175 * math.cos(4 * phi)
    assert plan.bounds[2] - plan.bounds[0] == pytest.approx(east * 0.001, rel=1e-6)
    assert plan.bounds[3] - plan.bounds[1] == pytest.approx(north * 0.001, rel=1e-6)
    assert plan.bounds[0] == pytest.approx(-plan.bounds[2])
    assert "read as degrees, as their range suggests" in plan.warnings[0]
    metres = read_floor_plan(path, FloorPlanReading(coordinates="metres"))
    assert metres.bounds[0] == LON
    assert metres.warnings == ()


def test_what_says_degrees_or_metres(tmp_path: Path):
    path = tmp_path / "a.geojson"
    for name, expected in (("urn:ogc:def:crs:OGC:1.3:CRS84", True), ("EPSG:3857", False)):
        crs = {"type": "name", "properties": {"name": name}}
        for extent in (0.001, 1.0):
            path.write_text(json.dumps({**degrees(extent), "crs": crs}))
            found = read_floor_plan(path).warnings
            assert any("as the file says" in note for note in found) == expected
    path.write_text(json.dumps(degrees(1.0)))
    assert read_floor_plan(path).warnings == ()  # a plan of 1 m is taken for one in metres
    wkt = tmp_path / "a.wkt"
    wkt.write_text("SRID=4326;POLYGON ((10 50, 11 50, 10 51, 10 50))")
    assert "as the file says" in read_floor_plan(wkt).warnings[0]
    wkt.write_text("POLYGON ((0 0, 500 0, 0 500, 0 0))")
    with pytest.raises(InputError, match="out of range"):
        read_floor_plan(wkt, FloorPlanReading(coordinates="degrees"))


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.json", "[1, 2]", "holds no JSON object"),
        ("a.json", "{", "is not JSON in line 1"),
        ("a.json", '{"shape": [], "starts": []}', r"is no floor plan \(its keys: shape, starts\)"),
        ("a.json", '{"outer": [[0,0],[1,0],[0,1]], "hole": []}', "'hole' means nothing here"),
        ("a.json", '{"outer": [[0,0],[1,0],[0,1]], "holes": 3}', "holes is no list of rings"),
        ("a.json", '{"outer": "abc"}', "outer: holds something that is no number"),
        ("a.json", '{"verts": {"x": 1}}', "outer: holds something that is no number"),
        ("a.geojson", '{"type": "Circle"}', "type 'Circle' is not one of GeoJSON"),
        ("a.geojson", '{"type": "Point", "coordinates": [1, 2]}', "holds no polygon"),
        ("a.geojson", '{"type": "FeatureCollection"}', "has no list of features"),
        ("a.geojson", '{"type": "FeatureCollection", "features": [3]}', "'3' is no GeoJSON object"),
        ("a.geojson", '{"type": "Polygon", "coordinates": []}', "a Polygon has no rings"),
        ("a.geojson", '{"type": "Polygon", "coordinates": [[[1]]]}', "something that is no point"),
        ("a.geojson", '{"type": "Polygon", "coordinates": [[[1, 1], [2, 2]]]}', "has 2 points"),
        (
            "a.geojson",
            '{"type": "Polygon", "coordinates": [[[1, 1], [2, 2], [NaN, 3]]]}',
            "not finite",
        ),
        ("a.wkt", "POLYGON ((0 0, 1 0", "is no well-known text"),
        ("a.wkt", "LINESTRING (0 0, 1 0)", "holds no polygon"),
        ("a.wkt", "POLYGON EMPTY", "holds no polygon"),
        ("a.pol", "", "word 1 is 'nothing', not a number of points"),
        ("a.pol", "3 0 0 1 0", "ends after 4 of 6 numbers of a ring"),
        ("a.pol", "2 0 0 1 0", "word 1 is '2', not a number of points"),
        ("a.pol", "3 0 0 1 0 0 1/0", "word 7 is '1/0', not a fraction"),
        ("a.pol", "3 0 0 1 0 0 x", "word 7 is 'x', not a fraction"),
        ("a.pol", "3 0 0 1 0 0 1 1", "word 9 is 'nothing', not a number of points"),
        ("a.pol", "3 0 0 1 0 0 1 0 5", "1 words follow the last ring"),
        ("a.environment", "0 0\n1 0\nx\n", "line 3: 'x' is no point"),
        ("a.environment", "// nothing\n", "holds no point"),
        ("a.dat", "0 0 0\n", "line 1: '0 0 0' is no point"),
        ("a.sol", "3 1 1", "is a list of guards, not a floor plan; give a.pol"),
        ("a.graph", "3", ".graph is not the suffix of a floor plan or a map"),
        ("a.txt", "[1, 2]", r"line 1, column 1: '\['"),
        ("a.pol", "version https://git-lfs.github.com/spec/v1", "is a Git LFS pointer"),
    ],
)
def test_files_that_are_no_floor_plan(name: str, text: str, words: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read_floor_plan(path)
    assert caught.value.remedy


def test_bytes_that_are_no_text(tmp_path: Path):
    for name in ("a.json", "a.pol", "a.wkt", "a.dat"):
        (tmp_path / name).write_bytes(b"\xff\xfe\x00\x80")
        with pytest.raises(InputError, match="is not text"):
            read_floor_plan(tmp_path / name)
    with pytest.raises(InputError, match="does not exist"):
        read_floor_plan(tmp_path / "missing.pol")
    with pytest.raises(InputError, match="does not exist"):
        read_floor_plan(tmp_path / "missing.png")
    with pytest.raises(InputError, match="neither a file nor built in"):
        load_floor_plan("nowhere")


def test_settings_reach_grids(tmp_path: Path):
    path = tmp_path / "a.txt"
    path.write_text("..?\n...\n")
    walled = FloorPlanReading(resolution=0.5, cells=Polygonising(unknown="wall"))
    assert read_floor_plan(path, walled).area == 1.25
    assert load_floor_plan("three-obstacles").name == "three-obstacles"


coordinates = st.floats(-1e6, 1e6, allow_nan=False, allow_infinity=False)


@settings(deadline=None)
@given(st.tuples(coordinates, coordinates), st.floats(1e-3, 1e6))
def test_what_is_written_reads_back_bit_by_bit(
    tmp_path_factory: pytest.TempPathFactory, at: tuple[float, float], side: float
):
    x, y = at
    corners = [(x, y), (x + side, y), (x + side / 3, y + side * 0.7)]
    inner = [(x + side / 3, y + side * 0.1), (x + side / 3, y + side * 0.2)]
    plan = PolygonMap(corners, [[*inner, (x + side * 0.4, y + side * 0.15)]], name="a")
    folder = tmp_path_factory.mktemp("plans")
    for suffix in (".json", ".geojson"):
        back = read_floor_plan(write_floor_plan(plan, folder / f"a{suffix}"))
        assert back.warnings == ()
        assert all(np.array_equal(a, b) for a, b in zip(plan.rings, back.rings, strict=True))


def test_writing(tmp_path: Path):
    plan = builtin_floor_plan("streets:3")
    assert json.loads(to_polygon_json(plan))["name"] == "streets:3"
    geometry = json.loads(to_geojson(plan))["geometry"]
    assert [len(ring) for ring in geometry["coordinates"]] == [5, 5, 5, 5, 5]
    with pytest.raises(InputError, match=r"end the name in \.json or \.geojson"):
        write_floor_plan(plan, tmp_path / "a.wkt")
    (tmp_path / "b.json").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        write_floor_plan(plan, tmp_path / "b.json")
    with pytest.raises(InputError, match="cannot be written"):
        write_floor_plan(plan, tmp_path / "nowhere" / "a.json")
