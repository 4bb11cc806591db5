"""The polygonal floor plan."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from conav.errors import InputError
from conav.maps.rings import Ring, find_fault, ring_name, segments_of, signed_area, turns

T = TypeVar("T", bound=np.generic)


@dataclass(frozen=True, eq=False)
class PolygonMap:
    """A floor: what lies inside the outer ring and outside the holes, borders included.

    `outer` runs counter-clockwise, each hole clockwise, so the floor is on the left of every edge;
    the first point of a ring is not repeated at its end. Rings are simple, holes lie inside the
    outer ring, and no two rings touch. Points on straight walls are allowed
    (`without_collinear_points` removes them). The arrays are copied and locked.

    Raises `InputError`, with ring and coordinates, for rings that are not so; `repair_polygon_map`
    makes a map of them where it can.

    >>> PolygonMap([(0, 0), (4, 0), (4, 3), (0, 3)]).area
    12.0
    """

    outer: Ring  # (n, 2) [m], counter-clockwise
    holes: tuple[Ring, ...] = ()  # each (m, 2) [m], clockwise
    name: str = "floor plan"
    warnings: tuple[str, ...] = ()  # what a reader found odd or repaired, for people

    def __init__(
        self,
        outer: ArrayLike,
        holes: Sequence[ArrayLike] = (),
        name: str = "floor plan",
        warnings: tuple[str, ...] = (),
    ) -> None:
        rings = [_ring(name, index, points) for index, points in enumerate((outer, *holes))]
        fault = find_fault(rings)
        if fault is not None:
            raise InputError(f"{name}: {ring_name(fault.ring)}", fault.problem, fault.remedy)
        object.__setattr__(self, "outer", rings[0])
        object.__setattr__(self, "holes", tuple(rings[1:]))
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "warnings", tuple(warnings))

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        # Through the constructor, so that an unpickled map is locked again.
        return (PolygonMap, (self.outer, self.holes, self.name, self.warnings))

    @property
    def rings(self) -> tuple[Ring, ...]:
        """The outer ring, then the holes."""
        return (self.outer, *self.holes)

    @cached_property
    def vertices(self) -> NDArray[np.float64]:
        """The points of all rings, shape (n, 2) [m]."""
        return _locked(np.concatenate(self.rings))

    @cached_property
    def ring_starts(self) -> NDArray[np.int64]:
        """Ring i is `vertices[ring_starts[i] : ring_starts[i + 1]]`, shape (rings + 1,)."""
        return _locked(np.cumsum([0, *(len(ring) for ring in self.rings)], dtype=np.int64))

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """The walls, shape (n, 4): x0, y0, x1, y1 [m], the floor on the left; i leaves vertex i."""
        return _locked(segments_of(self.rings))

    @cached_property
    def turns(self) -> NDArray[np.int8]:
        """The exact turn at each vertex, shape (n,): 1 convex, 0 straight, -1 reflex."""
        return _locked(np.concatenate([turns(ring) for ring in self.rings]))

    @property
    def area(self) -> float:
        """Of the floor [m^2]."""
        return sum(signed_area(ring) for ring in self.rings)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The least and greatest coordinates: x0, y0, x1, y1 [m]."""
        (x0, y0), (x1, y1) = self.outer.min(axis=0).tolist(), self.outer.max(axis=0).tolist()
        return x0, y0, x1, y1

    @cached_property
    def polygon(self) -> shapely.Polygon:
        """The floor as shapely knows it."""
        polygon = shapely.Polygon(self.outer, self.holes)
        shapely.prepare(polygon)
        return polygon

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point, shape (..., 2) [m], is on the floor or on its border."""
        at = np.asarray(points, dtype=np.float64)
        return np.asarray(shapely.intersects_xy(self.polygon, at[..., 0], at[..., 1]))


def without_collinear_points(plan: PolygonMap) -> PolygonMap:
    """The same floor without the points at which a wall goes straight on, exactly.

    >>> len(without_collinear_points(PolygonMap([(0, 0), (1, 0), (2, 0), (0, 2)])).outer)
    3
    """
    rings = [ring[turns(ring) != 0] for ring in plan.rings]
    return PolygonMap(rings[0], rings[1:], plan.name, plan.warnings)


def _ring(name: str, index: int, points: ArrayLike) -> Ring:
    place = f"{name}: {ring_name(index)}"
    try:
        # Adding zero turns -0.0 into 0.0.
        ring = np.array(points, dtype=np.float64, order="C", copy=True) + 0.0
    except (TypeError, ValueError) as error:
        raise InputError(place, "holds something that is no number", "give (x, y) rows") from error
    if ring.ndim != 2 or ring.shape[1] != 2:
        raise InputError(place, f"has the shape {ring.shape}", "give an array of (x, y) rows")
    return _locked(ring)


def _locked(array: NDArray[T]) -> NDArray[T]:
    array.flags.writeable = False
    return array
