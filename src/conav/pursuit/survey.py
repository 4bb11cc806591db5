"""What a team knows of a floor: the union of what it has seen, walls and frontiers told apart.

The known region is a floor plan of its own. Its sides are pieces of walls, or frontiers: windows
behind which nobody has looked. Corners of the floor keep the coordinates they were seen with; where
a window ends at a wall, or two windows cross, coordinates are rounded. When no frontier is left the
known region is the floor, point for point.
"""

from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.errors import InputError
from conav.geometry.triangulation import Triangulation, triangulate
from conav.geometry.visibility import exact_coordinate
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.sensor import Point, Scan

_NEAR = 1e-9  # of the known region's size: computed points nearer to each other are one
_PARTED = 100.0  # times that: how far rings that would touch are drawn apart

Ring = list[Point]


@dataclass(frozen=True, eq=False)
class Survey:
    """What was seen up to now; `add` makes the next one.

    `visited` are the places somebody looked from, apart from what was seen from them.
    """

    known: PolygonMap
    frontiers: NDArray[np.bool_]  # (n,) whether the side from each vertex of `known` is one
    critical: tuple[Point, ...]  # the reflex corners known to be such, sorted
    visited: tuple[Point, ...]  # in the order of their first look
    labels: dict[Point, frozenset[int]] = field(repr=False)
    """Corners, and ends of windows at walls: the walls they are known to lie on."""
    corners: frozenset[Point] = field(repr=False)  # corners of the floor
    windows: dict[Point, tuple[Point, ...]] = field(repr=False)
    """Critical vertices nobody visited: the far ends of windows that hang on them."""
    mesh: Triangulation = field(repr=False)  # of `known`

    @property
    def complete(self) -> bool:
        """Whether nothing is left to explore."""
        return not self.frontiers.any()

    @property
    def frontier_segments(self) -> NDArray[np.float64]:
        """The frontiers, shape (f, 2, 2) [m]."""
        return self.known.segments[self.frontiers].reshape(-1, 2, 2)

    def unexplored(self) -> tuple[Point, ...]:
        """Critical vertices on whose windows there still is a frontier, sorted.

        [Pellier2005] explores every vertex that was not visited; one round which all has been seen
        from elsewhere is left out here, as nothing is to be found there. None of those on a
        frontier was visited: from the near end of a window both sides of it are seen. Raises
        `InputError` where rounding hides what there is to explore.
        """
        if self.complete:
            return ()
        middles = self.frontier_segments.mean(axis=1)
        tolerance = 2.0 * _PARTED * _NEAR * float(np.ptp(self.known.outer))
        found: list[Point] = []
        for near, ends in sorted(self.windows.items()):
            lines = shapely.linestrings([(near, end) for end in ends])
            apart = shapely.distance(lines[:, None], shapely.points(middles)[None, :])
            if (apart <= tolerance).any():
                found.append(near)
        if not found:
            # Where a passage is narrower than the tolerance its window's ends are one. The corners
            # beside it are left.
            ends = {(x, y) for x, y in self.frontier_segments.reshape(-1, 2).tolist()}
            found = sorted((ends & self.corners) - set(self.visited))
        if not found:
            raise InputError(
                "the floor",
                f"has walls nearer to each other than a survey tells apart, {tolerance:.1g} m",
                "part them, or close the gap",
            )
        return tuple(found)

    def add(self, scan: Scan) -> "Survey":
        """The survey with another scan, itself where the scan is from a visited place."""
        if scan.place in self.visited:
            return self
        return _surveyed(self, scan)


def begin_survey(scan: Scan) -> Survey:
    """The survey of one scan."""
    return _surveyed(None, scan)


def _surveyed(old: Survey | None, scan: Scan) -> Survey:
    labels = {} if old is None else dict(old.labels)
    corners = set() if old is None else set(old.corners)
    critical = set() if old is None else set(old.critical)
    reach = float(np.ptp(scan.corners, axis=0).max())
    tolerance = _NEAR * max(reach, 0.0 if old is None else float(np.ptp(old.known.outer)))
    ring = _recognised(scan, labels, corners, tolerance)
    windows = {} if old is None else dict(old.windows)
    visited = (*(() if old is None else old.visited), scan.place)
    for i in np.flatnonzero(scan.walls < 0).tolist():
        one, two = ring[i], ring[(i + 1) % len(ring)]
        near, far = (
            (one, two) if _squared(one, scan.place) < _squared(two, scan.place) else (two, one)
        )
        windows[near] = (*windows.get(near, ()), far)
    for place in visited:
        windows.pop(place, None)
    seen = shapely.make_valid(shapely.Polygon(ring))
    whole = seen if old is None else shapely.union(old.known.polygon, seen)
    rings = _rings(whole, labels, corners, tolerance)
    critical |= windows.keys()
    rings = _apart_rings(rings, labels, tolerance)
    known = PolygonMap(np.array(rings[0]), [np.array(hole) for hole in rings[1:]], "known region")
    frontiers = np.concatenate([_frontiers(one, labels) for one in rings])
    walls = ~frontiers & ~np.concatenate([np.roll(_frontiers(one, labels), 1) for one in rings])
    reflex = known.vertices[walls & (known.turns < 0)].tolist()
    critical |= {(x, y) for x, y in reflex} & corners
    return Survey(
        known,
        frontiers,
        tuple(sorted(critical)),
        visited,
        labels,
        frozenset(corners),
        windows,
        triangulate(known.vertices, known.ring_starts),
    )


def _squared(a: Point, b: Point) -> float:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2


def _recognised(
    scan: Scan, labels: dict[Point, frozenset[int]], corners: set[Point], tolerance: float
) -> Ring:
    """The corners of a scan, ends of windows that were known already as they were known.

    Enters what is new into `labels` and `corners`.
    """
    ends: dict[int, list[Point]] = {}
    for point, walls in labels.items():
        for wall in walls:
            ends.setdefault(wall, []).append(point)
    ring: Ring = []
    for i, (x, y) in enumerate(scan.corners.tolist()):
        point = (exact_coordinate(x), exact_coordinate(y))
        walls = {int(scan.walls[i]), int(scan.walls[i - 1]), int(scan.on_wall[i])} - {-1}
        if scan.at_vertex[i]:
            corners.add(point)
        else:
            for other in ends.get(int(scan.on_wall[i]), ()):
                if max(abs(other[0] - x), abs(other[1] - y)) <= tolerance:
                    point = other
                    break
        labels[point] = labels.get(point, frozenset()) | walls
        ring.append(point)
    return ring


def _rings(
    whole: shapely.Geometry,
    labels: dict[Point, frozenset[int]],
    corners: set[Point],
    tolerance: float,
) -> list[Ring]:
    """The rings of a union, computed points replaced by the known ones they stand for."""
    parts = [part for part in shapely.get_parts(whole) if isinstance(part, shapely.Polygon)]
    largest = shapely.geometry.polygon.orient(max(parts, key=shapely.area), 1.0)
    names = list(labels)
    tree = shapely.STRtree([shapely.Point(point) for point in names])
    rings: list[Ring] = []
    for line in (largest.exterior, *largest.interiors):
        at = shapely.get_coordinates(line)[:-1]
        points: Ring = [(exact_coordinate(x), exact_coordinate(y)) for x, y in at.tolist()]
        found, near = tree.query(shapely.points(at), predicate="dwithin", distance=tolerance)
        for i, j in zip(found.tolist(), near.tolist(), strict=True):
            # The end of a window may lie on a corner, but for rounding.
            if points[i] not in corners and (points[i] not in labels or names[j] in corners):
                points[i] = names[j]
        points = _plain(points, labels, corners, tolerance)
        if len(points) >= 3:
            ring = np.array(points)
            x, y = (ring - ring[0]).T
            area = abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))) / 2.0
            if area > tolerance * float(np.ptp(ring, axis=0).max()):
                rings.append(points)
    return rings


def _plain(
    points: Ring, labels: dict[Point, frozenset[int]], corners: set[Point], tolerance: float
) -> Ring:
    """A ring without points met twice in a row, spikes, and points within a wall or frontier."""
    none: frozenset[int] = frozenset()
    changed = True
    while changed and len(points) >= 3:
        changed = False
        for i in range(len(points)):
            before, here, after = points[i - 1], points[i], points[(i + 1) % len(points)]
            walls = labels.get(here, none)
            within = here not in corners and (
                bool(walls & labels.get(before, none) & labels.get(after, none))
                or _apart(here, before, after) <= tolerance
            )
            spike = (
                before == after
                or _apart(after, before, here) <= tolerance
                or _apart(before, here, after) <= tolerance
            )
            if here in (before, after) or spike or within:
                del points[i]
                changed = True
                break
    return points


def _apart_rings(
    rings: list[Ring], labels: dict[Point, frozenset[int]], tolerance: float
) -> list[Ring]:
    """Rings that do not touch: where an unknown pocket does, it is drawn a little smaller.

    A pocket may touch a wall or another pocket in a point. Walls of the floor do not touch, so what
    lies that near to the point is floor.
    """
    lines = [shapely.linearrings(np.array(ring)) for ring in rings]
    if len(rings) == 1:
        return rings
    parted: list[Ring] = []
    for number, ring in enumerate(rings):
        frontiers = _frontiers(ring, labels)
        others = shapely.MultiLineString([one for i, one in enumerate(lines) if i != number])
        moved = list(ring)
        for i in np.flatnonzero(frontiers & np.roll(frontiers, 1)).tolist():
            at = np.array(ring[i])
            if shapely.distance(shapely.Point(at), others) <= tolerance:
                sides = np.array([ring[i - 1], ring[(i + 1) % len(ring)]]) - at
                towards = (sides / np.sqrt((sides**2).sum(axis=1))[:, None]).sum(axis=0)
                x, y = (at + _PARTED * tolerance * towards).tolist()
                moved[i] = (x, y)
        parted.append(moved)
    return parted


def _apart(point: Point, a: Point, b: Point) -> float:
    """How far a point is from the line through two others [m]; inf where it is not between."""
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], point[0] - a[0], point[1] - a[1]
    squared, along = ux * ux + uy * uy, ux * vx + uy * vy
    if not 0.0 < along < squared:
        return float("inf")
    return abs(ux * vy - uy * vx) / squared**0.5


def _frontiers(ring: Ring, labels: dict[Point, frozenset[int]]) -> NDArray[np.bool_]:
    """Which sides of a ring are frontiers: those whose ends lie on no common wall."""
    none: frozenset[int] = frozenset()
    walls = [labels.get(point, none) for point in ring]
    return np.array([not (walls[i] & walls[(i + 1) % len(ring)]) for i in range(len(ring))])
