"""Occupancy grids as polygonal floor plans.

The floor is a connected part of the free cells, drawn exactly along the sides of the cells. What
that promises an evader of radius r, and those who look for it:

- r = 0, the default: the floor of the plan contains the free cells of the part, so no place and no
  gap an evader has in the grid is lost. Two free cells that share only a corner are connected
  there: the point is widened by a cut with legs of `CORNER_CUT` cells into both walls. Nothing else
  differs from the grid, and a line of sight leaves the free cells only in such a cut. (In the
  closed floor a line may pass through the corner point itself.)
- r > 0: such corners are closed, by a cut of the same size, at most r, into both free cells. The
  floor of the plan lies in the free cells, so nothing is seen in the plan that is not in sight in
  the grid, and it contains every place where the evader's centre can be.
- `tolerance` t > 0: walls take in corners, dents and steps up to t deep. They only grow, so the
  second promise about sight holds, and every point farther than t from all walls stays. That loses
  nothing to an evader of radius t or more. For a smaller one no simpler floor can keep both
  promises: one that is larger shows too much, one that is smaller loses hiding places.

Cells of which nothing is known count as floor, because somebody may hide there; sight through them
is then taken for granted. `unknown="wall"` takes them for walls.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.errors import InputError
from conav.geometry.corner_cutting import cut_corners
from conav.geometry.outline import label_parts, trace_rings
from conav.geometry.turned import cosine_and_sine
from conav.maps.image import percent
from conav.maps.occupancy_grid import FREE, UNKNOWN, OccupancyGrid
from conav.maps.polygon_map import PolygonMap
from conav.maps.rings import Ring, turns

CORNER_CUT = 1.0 / 1024.0  # [cells] exact in binary, and far below what a map knows
INSIDE_SHARE = 10  # an inside of a tenth of the floor is preferred to a larger outside


@dataclass(frozen=True)
class Polygonising:
    """What to make of a grid's cells.

    Raises `InputError` for a radius or tolerance that is negative or not finite.
    """

    evader_radius: float = 0.0  # [m] with 0 corners where free cells touch are open
    unknown: Literal["free", "wall"] = "free"  # what unknown cells are
    tolerance: float = 0.0  # [m] how deep dents may be that walls take in
    outside: bool = False  # take the largest part even where it looks like the outside
    at: tuple[float, float] | None = None  # [m] a point of the part to take

    def __post_init__(self) -> None:
        for name in ("evader_radius", "tolerance"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(name, f"is {value}", "give metres, 0 or more")
        if self.unknown not in ("free", "wall"):
            raise InputError("unknown", f"is {self.unknown!r}", "give free or wall")


def polygonise(grid: OccupancyGrid, how: Polygonising | None = None) -> PolygonMap:
    """The floor plan of a connected part of a grid's free cells, in the grid's map frame.

    The part is the one at `how.at`, or the one with most cells known to be free; when that touches
    the border of the map it is passed over for an inner one with a tenth of them, as
    `default_start_area` does, unless `how.outside`. See above for what is promised.

    Raises `InputError` when there is no free cell, or none at `how.at`.

    >>> from conav.maps.ascii_art import parse_ascii
    >>> plan = polygonise(parse_ascii('''
    ...     ...
    ...     .#.
    ...     ...
    ... '''.replace(' ', '')))
    >>> plan.area, len(plan.holes), plan.holes[0].tolist()
    (8.0, 1, [[2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0]])
    """
    how = Polygonising() if how is None else how
    open_corners = how.evader_radius == 0
    floor = grid.cells == FREE
    if how.unknown == "free":
        floor |= grid.cells == UNKNOWN
    labels = label_parts(floor.astype(np.uint8), open_corners)
    part, notes = _choose(grid, labels, how)
    chosen = labels == part
    cut = CORNER_CUT if open_corners else min(CORNER_CUT, how.evader_radius / grid.resolution)
    rings = trace_rings(chosen.astype(np.uint8), open_corners, cut)
    notes += _notes(grid, chosen, how)
    if how.tolerance > 0:
        # In cells, where corners are multiples of the cut and orientations come out exact. A cut
        # into free cells has used up its part of the tolerance.
        deep = how.tolerance / grid.resolution - (0.0 if open_corners else cut)
        rings = _without_small_corners(rings, max(deep, 0.0))
    placed = [_placed(grid, ring) for ring in rings]
    return PolygonMap(placed[0], placed[1:], grid.name, (*grid.warnings, *notes))


def simplified(plan: PolygonMap, tolerance: float) -> PolygonMap:
    """The plan with fewer corners: walls take in dents up to `tolerance` [m] deep, and only grow.

    The new floor lies in the old one and has every point of it farther than `tolerance` from all
    walls, so it is sound for evaders of that radius or more; `is_sound_simplification` checks it.

    >>> stairs = PolygonMap([(0, 0), (9, 0), (9, 1), (8, 1), (8, 2), (7, 2), (7, 3), (0, 3)])
    >>> simplified(stairs, 0.8).outer.tolist()
    [[0.0, 0.0], [9.0, 0.0], [7.0, 2.0], [7.0, 3.0], [0.0, 3.0]]
    """
    tolerance = Polygonising(tolerance=tolerance).tolerance
    rings = _without_small_corners(list(plan.rings), tolerance)
    return PolygonMap(rings[0], rings[1:], plan.name, plan.warnings)


def is_sound_simplification(exact: PolygonMap, simple: PolygonMap, tolerance: float) -> bool:
    """Whether `simple` lies in `exact` and lacks no point of it over `tolerance` [m] from walls.

    Up to a nanometre, since coordinates are rounded, and up to 0.2 percent of `tolerance`, because
    the round corners of the walls' neighbourhood are drawn with 128 sides.
    """
    around = shapely.buffer(exact.polygon, 1e-9, join_style="mitre")
    if not shapely.covers(around, simple.polygon):
        return False
    near = shapely.buffer(exact.polygon.boundary, tolerance * 1.002, quad_segs=32)
    lost = shapely.difference(exact.polygon, simple.polygon)
    return bool(shapely.is_empty(lost) or shapely.covers(near, lost))


def _without_small_corners(rings: list[Ring], tolerance: float) -> list[Ring]:
    rings = [ring[turns(ring) != 0] for ring in rings]
    starts = np.cumsum([0, *(len(ring) for ring in rings)], dtype=np.int64)
    kept = cut_corners(np.concatenate(rings), starts, tolerance)
    left = [ring[keep] for ring, keep in zip(rings, np.split(kept, starts[1:-1]), strict=True)]
    return [ring[turns(ring) != 0] for ring in left]


def _choose(
    grid: OccupancyGrid, labels: NDArray[np.int32], how: Polygonising
) -> tuple[int, list[str]]:
    """The part that is the floor, and what there is to say about the choice."""
    known = labels[grid.cells == FREE]
    if len(known) == 0:
        raise InputError(grid.name, "has no free cell", "give another map")
    if how.at is not None:
        return _part_at(grid, labels, how.at), []
    sizes = np.bincount(known, minlength=int(labels.max()) + 1)
    border = np.zeros(len(sizes), dtype=np.bool_)
    for side in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        border[side[side >= 0]] = True
    part = int(np.argmax(sizes))
    total = int(sizes.sum())
    inner = np.where(border, 0, sizes)
    if border[part] and not how.outside and int(inner.max()) * INSIDE_SHARE >= total:
        outer, part = part, int(np.argmax(inner))
        return part, [
            f"the largest part ({percent(sizes[outer] / total)} of the free cells) touches the"
            " border of the map and looks like the outside of a building; the floor is the largest"
            f" part inside ({percent(sizes[part] / total)}); use --outside for the largest part"
        ]
    count = int(np.count_nonzero(sizes))
    if count == 1:
        return part, []
    return part, [
        f"the floor is the largest of {count} separate parts"
        f" ({percent(sizes[part] / total)} of the free cells)"
    ]


def _part_at(grid: OccupancyGrid, labels: NDArray[np.int32], at: tuple[float, float]) -> int:
    x, y, yaw = grid.origin
    cosine, sine = cosine_and_sine(yaw)
    dx, dy = at[0] - x, at[1] - y
    col = int(np.floor((dx * cosine + dy * sine) / grid.resolution))
    row = int(np.floor((dy * cosine - dx * sine) / grid.resolution))
    inside = 0 <= row < grid.rows and 0 <= col < grid.cols
    if not inside or labels[row, col] < 0:
        where = "is not on the map" if not inside else "is not on a free cell"
        raise InputError(
            f"{grid.name}: at {at[0]:g}, {at[1]:g}", where, "give a point of the floor"
        )
    return int(labels[row, col])


def _notes(grid: OccupancyGrid, chosen: NDArray[np.bool_], how: Polygonising) -> list[str]:
    notes: list[str] = []
    unknown = np.count_nonzero(grid.cells[chosen] == UNKNOWN) / np.count_nonzero(chosen)
    if unknown > 0:
        notes.append(
            f"{percent(float(unknown))} of the floor are unknown cells, where somebody may hide and"
            " through which sight is taken for granted; use --unknown wall to take them for walls"
        )
    if how.tolerance > how.evader_radius:
        notes.append(
            f"walls took in dents up to {how.tolerance:g} m deep: nobody is looked for there, which"
            f" is right for evaders of a radius of {how.tolerance:g} m or more only"
        )
    return notes


def _placed(grid: OccupancyGrid, ring: Ring) -> Ring:
    """A ring of cell corners in the map frame [m]."""
    x, y, yaw = grid.origin
    scaled = ring * grid.resolution
    if yaw != 0.0:
        cosine, sine = cosine_and_sine(yaw)
        u, v = scaled.T
        scaled = np.column_stack((u * cosine - v * sine, u * sine + v * cosine))
    return scaled + np.array([x, y])
