"""An evader who moves on a fine grid, seen by brute force: what the verifier is compared with."""

import numpy as np
from numpy.typing import NDArray

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule


def grid_evader_escapes(
    plan: PolygonMap, schedule: Schedule, spacing: float, steps_per_leg: int, margin: float
) -> bool:
    """Whether an evader gets away who stands on grid points and changes between steps of time.

    It may be at a point that nobody sees from any place of the step, nor would if it stood a
    margin to any side; and go to a neighbour when both are such. So what it does, a real evader
    can: it is held back by grid, margin and time.
    """
    x0, y0, x1, y1 = plan.bounds
    xs = np.arange(x0 + spacing / 2, x1, spacing)
    ys = np.arange(y0 + spacing / 2, y1, spacing)
    points = np.stack(np.meshgrid(xs, ys), axis=-1)
    inside = plan.contains(points)
    for dx, dy in ((margin, 0), (-margin, 0), (0, margin), (0, -margin)):
        inside &= plan.contains(points + np.array((dx, dy)))
    # Neighbours that no wall parts.
    right = inside[:, :-1] & inside[:, 1:]
    right &= ~_crossed(plan, points[:, :-1], points[:, 1:])
    up = inside[:-1] & inside[1:]
    up &= ~_crossed(plan, points[:-1], points[1:])
    there = inside.copy()
    for leg in range(len(schedule.active)):
        for step in range(steps_per_leg):
            hidden = inside.copy()
            for share in np.linspace(step, step + 1, 3) / steps_per_leg:
                at = schedule.positions[leg] * (1 - share) + schedule.positions[leg + 1] * share
                for p in at[schedule.active[leg]]:
                    for aside in ((0, 0), (margin, 0), (-margin, 0), (0, margin), (0, -margin)):
                        rows = points[hidden] + aside
                        hidden[hidden] = _crossed(plan, rows, np.broadcast_to(p, rows.shape))
            there &= hidden
            there = _spread(there, hidden, right, up)
            if not there.any():
                return False
    return True


def _spread(
    there: NDArray[np.bool_],
    hidden: NDArray[np.bool_],
    right: NDArray[np.bool_],
    up: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    while True:
        more = there.copy()
        more[:, 1:] |= there[:, :-1] & right
        more[:, :-1] |= there[:, 1:] & right
        more[1:] |= there[:-1] & up
        more[:-1] |= there[1:] & up
        more &= hidden
        if (more == there).all():
            return there
        there = more


def _crossed(plan: PolygonMap, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether a wall properly crosses each segment; a, b (..., 2)."""
    found = np.zeros(a.shape[:-1], dtype=np.bool_)
    for x0, y0, x1, y1 in plan.segments.tolist():
        c, d = np.array((x0, y0)), np.array((x1, y1))
        found |= (_turn(a, b, c) * _turn(a, b, d) < 0) & (_turn(c, d, a) * _turn(c, d, b) < 0)
    return found


def _turn(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.sign(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
        - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )
