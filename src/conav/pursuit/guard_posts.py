"""Posts from which standing guards see the whole floor: a team that always suffices.

Posts are chosen so that they see a set of witness points. Where they leave part of the floor
unseen, exactly decided, a point in each unseen region becomes a witness too, and posts are chosen
anew. So the fewest posts for the witnesses of the last round are the fewest for the floor
[Couto2011].
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.geometry.inner_point import inner_point
from conav.geometry.mutual_sight import mutual_sight
from conav.geometry.triangulation import Triangulation
from conav.geometry.view_cells import MOST_VIEWS, ViewCells, cell_border, view_cells
from conav.geometry.view_cells import shadows as shadows_of
from conav.geometry.visibility import visibility_polygon

Point = tuple[float, float]
Floats = NDArray[np.float64]
Sight = NDArray[np.bool_]


@dataclass(frozen=True)
class Posts:
    """Places by number that together see all of the floor."""

    places: tuple[int, ...]
    least: int  # fewer of the places do not see all of it; 1 where that was not asked


def guard_posts(
    mesh: Triangulation, places: Sequence[Point], *, exact: bool = False
) -> Posts | None:
    """Posts among places [m], greedily, or, if `exact`, the fewest.

    None where more than 62 are needed or the places do not see all. Critical vertices do together:
    cut from each reflex vertex along one of its walls, a floor falls into convex parts, each with a
    critical vertex on its border. The fewest posts are found by integer programming; which ones of
    several sets is up to the solver.
    """
    at = np.array(places, dtype=np.float64)
    witnesses = mesh.vertices[mesh.triangles].mean(axis=1)
    sight = mutual_sight(mesh, at, witnesses)
    while True:
        chosen = _fewest(sight) if exact else _greedy(sight)
        if chosen is None or len(chosen) > MOST_VIEWS:
            return None
        cells = view_cells(mesh, [visibility_polygon(mesh, *places[post]) for post in chosen])
        unseen = _points_of_shadows(mesh, cells)
        if len(unseen) == 0:
            return Posts(tuple(chosen), len(chosen) if exact else 1)
        more = mutual_sight(mesh, at, unseen)
        if more[chosen].any(axis=0).all():
            return None  # too thin for a point inside
        sight = np.hstack((sight, more))


def _points_of_shadows(mesh: Triangulation, cells: ViewCells) -> Floats:
    """A point inside the largest cell of each shadow, shape (shadows, 2) [m]."""
    labels = shadows_of(cells)
    points: list[Point] = []
    for shadow in range(int(labels.max()) + 1):
        inside = np.flatnonzero(labels == shadow)
        largest = int(inside[np.argmax(cells.areas[inside])])
        x, y, _ = inner_point(cell_border(mesh, cells, largest))
        points.append((x, y))
    return np.array(points).reshape(-1, 2)


def _greedy(sight: Sight) -> list[int] | None:
    """Rows that together see every column: the one that sees most more first, none needlessly."""
    left = np.ones(sight.shape[1], np.bool_)
    chosen: list[int] = []
    while left.any():
        gains = sight[:, left].sum(axis=1)
        best = int(np.argmax(gains))
        if gains[best] == 0:
            return None
        chosen.append(best)
        left &= ~sight[best]
    for post in list(chosen):
        others = [other for other in chosen if other != post]
        if others and sight[others].any(axis=0).all():
            chosen = others
    return chosen


def _fewest(sight: Sight) -> list[int] | None:
    """As few rows as see every column."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    count = len(sight)
    found = cast(
        "Any",
        milp(
            np.ones(count),
            integrality=np.ones(count),
            bounds=Bounds(0, 1),
            constraints=LinearConstraint(sight.T.astype(np.float64), lb=1.0),
        ),
    )
    if found.x is None:
        return None
    return np.flatnonzero(np.asarray(found.x) > 0.5).tolist()
