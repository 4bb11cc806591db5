"""A floor from an outline and walls that stand in it or across its border."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from conav.errors import InputError
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import Polygonising, polygonise
from conav.planning.types import PlanningRobot

WELD_M = 1e-6
"""Half the side of the squares that close places where walls touch in a single point [m]."""


def floor_between(
    outline: ArrayLike,
    holes: Sequence[ArrayLike] = (),
    walls: Sequence[ArrayLike] = (),
    *,
    robots: Sequence[PlanningRobot] = (),
    name: str = "floor plan",
) -> PolygonMap:
    """The floor inside an outline, outside the holes and the walls: rings of (x, y) [m].

    Rings may run in either direction; walls may overlap each other, the holes and the outline.
    Without walls the rings are taken as they are. Where walls cut the floor into parts, it is the
    part on which the `robots` start, and the largest when none starts on any.
    Two walls that touch in one point are joined there by a square of side 2 `WELD_M`, for the rings
    of a floor do not touch; no disc comes through there anyway.

    Raises `InputError` for rings that cross themselves, when nothing is left of the floor, and when
    robots start on different parts.
    """
    if not len(walls):
        return PolygonMap(turned(outline, 1), [turned(hole, -1) for hole in holes], name)
    blocked = [_polygon(f"{name}: walls[{i}]", wall) for i, wall in enumerate(walls)]
    whole = _polygon(f"{name}: outline", outline)
    blocked += [_polygon(f"{name}: holes[{i}]", hole) for i, hole in enumerate(holes)]
    free = _cut(whole, blocked)
    part = _part(free, robots, name)
    rings = [np.asarray(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)]
    return PolygonMap(turned(rings[0], 1), [turned(ring, -1) for ring in rings[1:]], name)


def floor_of_grid(grid: OccupancyGrid, robots: Sequence[PlanningRobot]) -> PolygonMap:
    """The floor along the sides of a grid's cells, in its map frame, for at least one robot.

    Unknown cells are walls, and so is where two walls share a corner. It is the part of the first
    robot that starts on a free cell, and the largest, as `polygonise` chooses it, when none does.
    """
    smallest = min(robot.radius_m for robot in robots)
    how = Polygonising(evader_radius=smallest, unknown="wall")
    for robot in robots:
        try:
            return polygonise(grid, replace(how, at=(robot.start[0], robot.start[1])))
        except InputError:
            continue  # a start in a wall is for the planner to tell
    return polygonise(grid, how)


def _cut(whole: shapely.Polygon, blocked: list[shapely.Polygon]) -> list[shapely.Polygon]:
    """The parts of a polygon outside others; no two rings of a part touch."""
    while True:
        free = shapely.difference(whole, shapely.union_all(blocked))
        parts = [part for part in shapely.get_parts(free) if part.area > 0.0]
        touching = np.concatenate([np.empty((0, 2)), *(_touches(part) for part in parts)])
        if not len(touching):
            return parts
        blocked += [
            shapely.box(x - WELD_M, y - WELD_M, x + WELD_M, y + WELD_M)
            for x, y in touching.tolist()
        ]


def _touches(part: shapely.Polygon) -> NDArray[np.float64]:
    """Where rings of a polygon meet, shape (n, 2); overlays put a vertex of both there."""
    points = np.concatenate([np.asarray(r.coords)[:-1] for r in (part.exterior, *part.interiors)])
    found, count = np.unique(points, axis=0, return_counts=True)
    return found[count > 1]


def _part(
    parts: list[shapely.Polygon], robots: Sequence[PlanningRobot], name: str
) -> shapely.Polygon:
    if not parts:
        raise InputError(name, "the walls leave nothing of the floor", "make them smaller")
    first: tuple[str, int] | None = None
    for robot in robots:
        for index, part in enumerate(parts):
            if not shapely.intersects_xy(part, robot.start[0], robot.start[1]):
                continue
            if first is not None and first[1] != index:
                raise InputError(
                    name,
                    f"{first[0]} and {robot.name} start on parts of the floor that no way joins",
                    "open a way between them, or make a scene of each part",
                )
            first = first or (robot.name, index)
            break
    return max(parts, key=lambda part: part.area) if first is None else parts[first[1]]


def _polygon(place: str, ring: ArrayLike) -> shapely.Polygon:
    polygon = shapely.Polygon(np.asarray(ring, dtype=np.float64))
    if not polygon.is_valid or polygon.area == 0.0:
        raise InputError(
            place, f"is no polygon ({shapely.is_valid_reason(polygon).lower()})",
            "give the corners in order, without crossing",
        )  # fmt: skip
    return polygon


def turned(ring: ArrayLike, direction: int) -> NDArray[np.float64]:
    """The ring, shape (n, 2), running counter-clockwise (1) or clockwise (-1)."""
    points = np.asarray(ring, dtype=np.float64)
    x, y = points[:, 0], points[:, 1]
    # Twice the area about the first point; its sign is all that is asked.
    doubled = float(((x - x[0]) * (np.roll(y, -1) - np.roll(y, 1))).sum())
    return points if doubled * direction >= 0 else points[::-1]
