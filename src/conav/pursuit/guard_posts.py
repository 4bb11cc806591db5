"""Posts from which standing guards see the whole floor: a team that always suffices."""

import numpy as np

from conav.geometry.view_cells import MOST_VIEWS, view_cells
from conav.pursuit.roadmap import Roadmap
from conav.pursuit.shadow_moves import ShadowMoves


def guard_posts(roadmap: Roadmap, shadows: ShadowMoves) -> tuple[int, ...] | None:
    """Places of a roadmap that together see all of the floor, chosen greedily by area [m^2].

    None where more than 62 would be needed. Critical vertices see everything together: cut from
    each reflex vertex along one of its walls, a floor falls into convex parts, each with a
    critical vertex on its border.
    """
    points = roadmap.points
    chosen: list[int] = []
    hidden = np.inf
    floor_size = shadows.view(points[0]).area
    while len(chosen) < MOST_VIEWS:
        best, best_hidden = -1, hidden
        for place in range(len(points)):
            if place in chosen:
                continue
            views = [shadows.view(points[other]) for other in (*chosen, place)]
            cells = view_cells(shadows.floor, views)
            left = float(cells.areas[cells.seen_by == 0].sum())
            if not (cells.seen_by == 0).any():
                return (*chosen, place)
            if left < best_hidden - 1e-12 * floor_size:
                best, best_hidden = place, left
        if best < 0:
            return None
        chosen.append(best)
        hidden = best_hidden
    return None
