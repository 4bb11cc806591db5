"""Grids as floor plans."""

import math

import numpy as np
import pytest
import shapely

from conav.errors import InputError
from conav.maps.ascii_art import parse_ascii
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.occupancy_grid import FREE, OccupancyGrid
from conav.maps.polygonise import (
    CORNER_CUT,
    Polygonising,
    is_sound_simplification,
    polygonise,
)

TOUCHING = parse_ascii("#.\n.#", name="touching")


def test_free_cells_that_share_a_corner_are_one_floor_for_a_point():
    plan = polygonise(TOUCHING)
    assert plan.area == 2 + CORNER_CUT**2
    assert plan.contains([(1, 1), (0.5, 0.5), (1.5, 1.5)]).all()
    # Wide enough to pass, and no wider than the cut.
    gap = plan.polygon.intersection(shapely.LineString([(0.5, 1.5), (1.5, 0.5)])).length
    assert gap == pytest.approx(math.sqrt(2) * CORNER_CUT)


def test_they_are_apart_for_a_disc():
    plan = polygonise(TOUCHING, Polygonising(evader_radius=0.2))
    assert plan.area == 1  # the other cell is another part
    assert "largest of 2 separate parts" in plan.warnings[0]


def test_walls_that_share_a_corner_are_closed_for_a_disc():
    grid = parse_ascii(
        """
.....
.#...
..#..
.....
"""
    )
    opened, closed = polygonise(grid), polygonise(grid, Polygonising(evader_radius=0.2))
    assert (len(opened.holes), opened.area) == (2, 18 + CORNER_CUT**2)
    assert (len(closed.holes), closed.area) == (1, 18 - CORNER_CUT**2)
    tiny = polygonise(grid, Polygonising(evader_radius=1e-6))
    assert tiny.area == pytest.approx(18 - 1e-12, abs=1e-14)


def test_unknown_cells_are_floor_or_wall():
    grid = parse_ascii("..?\n..#")
    plan = polygonise(grid)
    assert plan.area == 5
    assert "20.0% of the floor are unknown cells" in plan.warnings[0]
    walled = polygonise(grid, Polygonising(unknown="wall"))
    assert (walled.area, walled.warnings) == (4, ())


def test_the_part_with_most_known_floor_is_taken():
    grid = parse_ascii("??????\n######\n#....#\n######")
    assert polygonise(grid).bounds == (1, 1, 5, 2)


ROOM_IN_A_YARD = parse_ascii(
    """
.........
.#######.
.#.....#.
.#######.
.........
"""
)


def test_an_outside_drawn_free_is_passed_over():
    plan = polygonise(ROOM_IN_A_YARD)
    assert plan.bounds == (2, 2, 7, 3)
    assert "looks like the outside" in plan.warnings[0]
    outer = polygonise(ROOM_IN_A_YARD, Polygonising(outside=True))
    assert outer.area == 24
    assert len(outer.holes) == 1


def test_a_part_by_a_point():
    assert polygonise(ROOM_IN_A_YARD, Polygonising(at=(0.5, 0.5))).area == 24
    for at, words in (((1.5, 1.5), "is not on a free cell"), ((-1, 0), "is not on the map")):
        with pytest.raises(InputError, match=words):
            polygonise(ROOM_IN_A_YARD, Polygonising(at=at))


def test_origin_and_yaw_place_the_plan():
    cells = np.array([[FREE, FREE], [FREE, 1]])
    yaw = 0.3
    grid = OccupancyGrid(cells.astype(np.uint8), 0.5, (3.0, -2.0, yaw))
    plan = polygonise(grid)
    corner = np.array([3 + math.cos(yaw) - 0 * math.sin(yaw), -2 + math.sin(yaw)])
    assert np.abs(plan.vertices - corner).sum(axis=1).min() < 1e-15
    assert plan.area == pytest.approx(0.75)
    at = (
        3 + 0.25 * math.cos(yaw) - 0.75 * math.sin(yaw),
        -2 + 0.25 * math.sin(yaw) + 0.75 * math.cos(yaw),
    )
    assert polygonise(grid, Polygonising(at=at)).area == plan.area
    quarter = polygonise(OccupancyGrid(grid.cells, 0.5, (0.0, 0.0, math.pi / 2)))
    assert quarter.bounds == (-1, 0, 0, 1)


def test_no_free_cell():
    with pytest.raises(InputError, match="has no free cell"):
        polygonise(parse_ascii("##\n??"))


@pytest.mark.parametrize(
    "settings", [{"evader_radius": -1}, {"tolerance": math.nan}, {"unknown": "maybe"}]
)
def test_settings_that_are_none(settings: dict[str, object]):
    with pytest.raises(InputError):
        Polygonising(**settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", BUILTIN)
def test_built_in_maps(name: str):
    grid = builtin_map(name)
    exact = polygonise(grid)
    cells = exact.area / grid.resolution**2
    floor = grid.cells == FREE
    touching = np.count_nonzero(
        (floor[:-1, :-1] == floor[1:, 1:])
        & (floor[:-1, 1:] == floor[1:, :-1])
        & (floor[:-1, :-1] != floor[:-1, 1:])
    )
    whole = round(cells)
    assert -1e-6 <= cells - whole <= touching * CORNER_CUT**2 + 1e-6
    assert whole <= np.count_nonzero(floor)
    # The centre of a cell is on the plan only if the cell is free.
    rows, cols = np.mgrid[0 : grid.rows, 0 : grid.cols]
    x, y, _ = grid.origin
    centres = np.stack(((cols + 0.5) * grid.resolution + x, (rows + 0.5) * grid.resolution + y), -1)
    inside = exact.contains(centres)
    assert not (inside & ~floor).any()
    assert np.count_nonzero(inside) == whole
    for tolerance in (grid.resolution, 5 * grid.resolution):
        how = Polygonising(evader_radius=tolerance, tolerance=tolerance)
        closed = polygonise(grid, Polygonising(evader_radius=tolerance))
        simple = polygonise(grid, how)
        assert is_sound_simplification(closed, simple, tolerance)
        assert len(simple.vertices) <= len(closed.vertices)
        assert not any("dents" in note for note in simple.warnings)


def test_a_tolerance_beyond_the_evader_is_said():
    plan = polygonise(ROOM_IN_A_YARD, Polygonising(tolerance=0.5, evader_radius=0.2))
    assert any("a radius of 0.5 m or more only" in note for note in plan.warnings)
