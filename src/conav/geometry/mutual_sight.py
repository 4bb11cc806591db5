"""Which points of one set see which of another, all pairs in one kernel."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.point_grid import OUTSIDE, locate
from conav.geometry.sight_lines import REACHED, follow
from conav.geometry.triangulation import Triangulation

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def mutual_sight(floor: Triangulation, viewpoints: Floats, targets: Floats) -> NDArray[np.bool_]:
    """Whether each viewpoint sees each target, as `sees` decides, shape (viewpoints, targets).

    Both have shape (k, 2) [m] and coordinates that are 0 or of at least 1e-60 m.
    """
    seen = np.zeros((len(viewpoints), len(targets)), np.bool_)
    _see_all(
        floor.vertices, floor.triangles.reshape(-1), floor.twins.reshape(-1), *floor.grid,
        viewpoints, targets, seen,
    )  # fmt: skip
    return seen


@kernel
def _see_all(
    vertices: Floats, corners: Ints, twins: Ints, frame: Floats, cell_starts: Ints,
    cell_triangles: Ints, viewpoints: Floats, targets: Floats, seen: NDArray[np.bool_],
) -> None:  # fmt: skip
    for i in range(viewpoints.shape[0]):
        ax, ay = viewpoints[i]
        place, start = locate(vertices, corners, frame, cell_starts, cell_triangles, ax, ay)
        if place == OUTSIDE:
            continue
        for j in range(targets.shape[0]):
            bx, by = targets[j]
            if ax == bx and ay == by:
                seen[i, j] = True
                continue
            kind, _, _ = follow(vertices, corners, twins, place, start, ax, ay, bx, by, True)
            seen[i, j] = kind == REACHED
