"""Where a team starts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.directions import ALL, DCOL, DROW
from conav.maps.planning_grid import PlanningGrid, StartArea
from conav.robots.robot import Robot
from conav.simulation.pibt import MIN_GAP


def start_together(
    plan: PlanningGrid, area: StartArea, robots: Sequence[Robot], rng: np.random.Generator
) -> tuple[int, ...]:
    """A start cell for each robot: the first at a random place of the area, the others as near as
    they fit, by path length.

    Raises `InputError` when the area cannot hold the team.
    """
    first = int(area.cells[int(rng.integers(len(area.cells)))])
    width = plan.lattice.cols
    starts: list[int] = []
    for cell in map(int, _breadth_first(plan.moves, first)):
        if not _too_near(cell, starts, robots, plan):
            starts.append(cell)
            if len(starts) == len(robots):
                return tuple(starts)
    raise InputError(
        plan.grid.name,
        f"has room for {len(starts)} of {len(robots)} robots around column {first % width}, "
        f"row {first // width}",
        "use fewer --robots, a smaller --radius, a smaller --cell or give --starts",
    )


def starts_at(
    plan: PlanningGrid,
    points: Sequence[tuple[float, float]],
    robots: Sequence[Robot],
    *,
    apart: bool = True,
) -> tuple[int, ...]:
    """The planning cells around points given in the map frame [m], one per robot.

    Without `apart` robots may stand on one another. Raises `InputError` for a point off the map, in
    a wall or too near another robot.
    """
    if len(points) != len(robots):
        raise InputError(
            "starts", f"{len(points)} points for {len(robots)} robots", "give one x,y per robot"
        )
    x0, y0, yaw = plan.grid.origin
    starts: list[int] = []
    for robot, (x, y) in zip(robots, points, strict=True):
        place = f"start {x:g},{y:g} of {robot.name}"
        cos, sin = float(np.cos(yaw)), float(np.sin(yaw))
        u = cos * (x - x0) + sin * (y - y0)
        v = -sin * (x - x0) + cos * (y - y0)
        cell = plan.lattice.cell_at(u, v)
        if cell < 0:
            raise InputError(
                place,
                f"is off the map, which reaches from {x0:g},{y0:g} by {plan.grid.width_m:g} x "
                f"{plan.grid.height_m:g} m",
                "give metres in the map frame",
            )
        if not plan.standable.reshape(-1)[cell]:
            near = nearest_standable(plan, cell)
            nx, ny = plan.lattice.position(near)
            wx, wy = x0 + cos * nx - sin * ny, y0 + sin * nx + cos * ny
            raise InputError(
                place,
                f"is in a wall or too near one for a robot of radius {plan.radius_m:g} m",
                f"the nearest place that fits is {wx:.2f},{wy:.2f}",
            )
        if apart and _too_near(cell, starts, robots, plan):
            raise InputError(place, "is too near another robot", "move it further away")
        starts.append(int(cell))
    return tuple(starts)


def nearest_standable(plan: PlanningGrid, cell: int) -> int:
    """The standable planning cell nearest to another in a straight line."""
    at = np.flatnonzero(plan.standable.reshape(-1))
    if len(at) == 0:
        raise InputError(
            plan.grid.name, "has no place where a robot fits", "use a smaller --radius"
        )
    row, col = np.divmod(at, plan.lattice.cols)
    r, c = divmod(cell, plan.lattice.cols)
    return int(at[np.argmin((row - r) ** 2 + (col - c) ** 2)])


def _too_near(
    cell: int, others: Sequence[int], robots: Sequence[Robot], plan: PlanningGrid
) -> bool:
    width = plan.lattice.cols
    row, col = divmod(cell, width)
    mine = robots[len(others)].radius_m
    for robot, other in zip(robots, others, strict=False):
        gap = max((mine + robot.radius_m) / plan.lattice.cell_m, MIN_GAP)
        r, c = divmod(other, width)
        if (row - r) ** 2 + (col - c) ** 2 < gap * gap - 1e-9:
            return True
    return False


@kernel
def _breadth_first(moves: NDArray[np.uint8], first: int) -> NDArray[np.int32]:
    """The cells reachable from `first` in order of the number of moves."""
    cols = moves.shape[1]
    seen = np.zeros(moves.size, dtype=np.uint8)
    queue = np.empty(moves.size, dtype=np.int32)
    queue[0] = first
    seen[first] = 1
    head = 0
    tail = 1
    while head < tail:
        cell = queue[head]
        head += 1
        bits = moves[cell // cols, cell % cols] & ALL
        for k in range(8):
            if bits & (1 << k):
                other = cell + DROW[k] * cols + DCOL[k]
                if seen[other] == 0:
                    seen[other] = 1
                    queue[tail] = other
                    tail += 1
    return queue[:tail]
