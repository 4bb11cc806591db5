"""Proofs that a problem has no solution, with the robot and the reason.

Nothing is called impossible that is not: every test errs on the side of hope. What no test here
sees, walls that only a finer look tells to be too close or robots that would have to pass each
other where there is no room, ends as out of budget.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.clearance import point_segment_square
from conav.planning.graph_arrays import LETTER
from conav.planning.labels import Regions, in_polygon
from conav.planning.letters import Task
from conav.planning.lower_bound import shortest_length
from conav.planning.obstacles import point_free
from conav.planning.team import Team
from conav.planning.types import DOUBLE_INTEGRATOR, PlanningProblem, PlanningRobot
from conav.tasks.automaton import INITIAL

ROUNDING = 1e-9  # [m or s] by which something must be wrong to be called so

MAX_CELLS = 1 << 20
MAX_NODES = 1 << 25  # cells times letters times states that are searched

OUTSIDE, INSIDE, MAYBE = range(3)


def why_impossible(team: Team) -> str | None:
    """The reason why no solver can succeed, None when none is known.

    Leaves each robot's least length in `team.least_lengths`.
    """
    problem = team.problem
    for robot, at in enumerate(problem.robots):
        reason = _start_in_the_way(team, robot)
        if reason is None:
            reason = _too_fast(at)
        if reason is None:
            reason = _too_far(team, robot)
        if reason is None:
            reason = _no_way(team, robot)
        if reason is not None:
            return f"robot {at.name}: {reason}"
    return _starts_overlap(problem)


def _start_in_the_way(team: Team, robot: int) -> str | None:
    at = team.problem.robots[robot]
    x, y = at.start[:2]
    grid, starts, items, shapes = team.graphs[robot].surroundings.obstacles
    smaller = shapes.copy()
    smaller[:, 4] -= ROUNDING
    if point_free(grid, starts, items, smaller, float(x), float(y)):
        return None
    return (
        f"its start ({x:g}, {y:g}) is off the floor, or nearer to a wall or disc than its radius "
        f"of {at.radius_m:g} m"
    )


def _too_fast(robot: PlanningRobot) -> str | None:
    if robot.motion != DOUBLE_INTEGRATOR:
        return None
    speed = math.hypot(*robot.start[2:])
    if speed <= robot.speed_mps + ROUNDING:
        return None
    return f"it starts at {speed:g} m/s, and its top speed is {robot.speed_mps:g} m/s"


def _starts_overlap(problem: PlanningProblem) -> str | None:
    robots = problem.robots
    for i, a in enumerate(robots):
        for b in robots[:i]:
            away = math.dist(a.start[:2], b.start[:2])
            needed = a.radius_m + b.radius_m + problem.margin_m
            if away < needed - ROUNDING:
                return (
                    f"robots {b.name} and {a.name}: their starts are {away:g} m apart and must be "
                    f"{needed:g} m at least"
                )
    return None


def _too_far(team: Team, robot: int) -> str | None:
    """The task cannot be done at all, or not within the horizon even without walls."""
    at = team.problem.robots[robot]
    task = team.tasks[robot]
    letter = int(team.graphs[robot].arrays.links[0, LETTER])
    automaton = task.automaton
    if not automaton.satisfiable:
        return f"its task {at.task!r} cannot be done with the regions as they lie"
    if automaton.sink[automaton.transition[INITIAL, letter]]:
        return f"its task {at.task!r} is lost at the start already"
    length = shortest_length(at, task, letter)
    team.least_lengths[robot] = length
    needed = length / at.speed_mps
    if needed > team.problem.horizon_s + ROUNDING:
        return (
            f"its task takes {length:.3f} m even without walls, {needed:.3f} s at "
            f"{at.speed_mps:g} m/s, and the horizon is {team.problem.horizon_s:g} s"
        )
    return None


def _no_way(team: Team, robot: int) -> str | None:
    """No way through the floor does the task, for a robot of this radius."""
    at = team.problem.robots[robot]
    task = team.tasks[robot]
    surroundings = team.graphs[robot].surroundings
    bounds = team.problem.floor.bounds
    cell = at.radius_m / 3.0
    while ((bounds[2] - bounds[0]) / cell + 1) * ((bounds[3] - bounds[1]) / cell + 1) > MAX_CELLS:
        cell *= 2.0
    columns = int((bounds[2] - bounds[0]) / cell) + 1
    rows = int((bounds[3] - bounds[1]) / cell) + 1
    blocked = _blocked(surroundings.obstacles.shapes, bounds[0], bounds[1], cell, columns, rows)
    sides = _region_sides(surroundings.regions, task, bounds, cell, columns, rows)
    column = min(int((at.start[0] - bounds[0]) / cell), columns - 1)
    row = min(int((at.start[1] - bounds[1]) / cell), rows - 1)
    letters, states = len(task.masks), task.automaton.n_states
    if columns * rows * letters * states > MAX_NODES:
        return None
    start_letter = int(team.graphs[robot].arrays.links[0, LETTER])
    done, reached = _search(
        blocked,
        sides,
        task.masks,
        task.automaton.transition,
        task.automaton.accepting,
        task.automaton.sink,
        row * columns + column,
        start_letter,
        int(task.automaton.transition[INITIAL, start_letter]),
    )
    if done:
        return None
    for bit, region in enumerate(task.regions):
        if not (reached & (sides[bit].ravel() != OUTSIDE)).any():
            where = f"region {region.name!r} cannot be reached from its start"
            return f"{where} by a robot of radius {at.radius_m:g} m"
    return f"no way over the floor does its task {at.task!r} for a radius of {at.radius_m:g} m"


def _region_sides(
    regions: Regions,
    task: Task,
    bounds: tuple[float, float, float, float],
    cell: float,
    columns: int,
    rows: int,
) -> NDArray[np.uint8]:
    """Whether each cell is outside, inside or maybe in each region, (regions, rows, columns)."""
    sides = np.zeros((len(task.regions), rows, columns), np.uint8)
    _fill_sides(*regions, bounds[0], bounds[1], cell, sides)
    return sides


@kernel
def _blocked(
    shapes: NDArray[np.float64], left: float, low: float, cell: float, columns: int, rows: int
) -> NDArray[np.uint8]:
    """The cells in which the robot's centre cannot be anywhere, (rows, columns)."""
    blocked = np.zeros((rows, columns), np.uint8)
    for item in range(len(shapes)):
        ax, ay, bx, by, reach = shapes[item]
        # All of a cell is in reach when its centre is, by more than half a diagonal.
        within = reach - 0.7072 * cell - ROUNDING
        if within <= 0.0:
            continue
        first_column = max(0, int((min(ax, bx) - reach - left) / cell) - 1)
        last_column = min(columns - 1, int((max(ax, bx) + reach - left) / cell) + 1)
        first_row = max(0, int((min(ay, by) - reach - low) / cell) - 1)
        last_row = min(rows - 1, int((max(ay, by) + reach - low) / cell) + 1)
        for row in range(first_row, last_row + 1):
            for column in range(first_column, last_column + 1):
                x = left + (column + 0.5) * cell
                y = low + (row + 0.5) * cell
                if point_segment_square(x, y, ax, ay, bx, by) < within * within:
                    blocked[row, column] = 1
    return blocked


@kernel
def _fill_sides(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    edges: NDArray[np.float64],
    left: float,
    low: float,
    cell: float,
    sides: NDArray[np.uint8],
) -> None:
    half = 0.7072 * cell + ROUNDING
    for region in range(len(sides)):
        for row in range(sides.shape[1]):
            for column in range(sides.shape[2]):
                x = left + (column + 0.5) * cell
                y = low + (row + 0.5) * cell
                if region < len(discs):
                    dx = x - discs[region, 0]
                    dy = y - discs[region, 1]
                    away = math.sqrt(dx * dx + dy * dy) - discs[region, 2]
                    if away > half:
                        sides[region, row, column] = OUTSIDE
                    elif away < -half:
                        sides[region, row, column] = INSIDE
                    else:
                        sides[region, row, column] = MAYBE
                    continue
                ring = region - len(discs)
                if (
                    x < rings[ring, 2] - half
                    or y < rings[ring, 3] - half
                    or x > rings[ring, 4] + half
                    or y > rings[ring, 5] + half
                ):
                    sides[region, row, column] = OUTSIDE
                    continue
                near = np.inf
                for side in range(int(rings[ring, 0]), int(rings[ring, 1])):
                    x0, y0, x1, y1 = edges[side]
                    near = min(near, point_segment_square(x, y, x0, y0, x1, y1))
                if near <= half * half:
                    sides[region, row, column] = MAYBE
                elif in_polygon(rings, edges, ring, x, y):
                    sides[region, row, column] = INSIDE
                else:
                    sides[region, row, column] = OUTSIDE


@kernel
def _search(
    blocked: NDArray[np.uint8],
    sides: NDArray[np.uint8],
    masks: NDArray[np.int64],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    sink: NDArray[np.bool_],
    start: int,
    start_letter: int,
    start_state: int,
) -> tuple[bool, NDArray[np.bool_]]:
    """Whether some way over cells could do the task, and which cells were reached.

    A robot may go from a cell to any that touches it and have any label there that the cell allows,
    one after the other; real ways are among these.
    """
    rows, columns = blocked.shape
    letters = len(masks)
    states = len(accepting)
    cells = rows * columns
    reached = np.zeros(cells, np.bool_)
    seen = np.zeros((cells, letters, states), np.bool_)
    room = 1024
    stack = np.empty(room, np.int64)
    used = 1
    stack[0] = (start * letters + start_letter) * states + start_state
    seen[start, start_letter, start_state] = True
    while used > 0:
        used -= 1
        node = stack[used]
        state = node % states
        letter = node // states % letters
        cell = node // states // letters
        reached[cell] = True
        if accepting[state]:
            return True, reached
        row = cell // columns
        column = cell % columns
        for v in range(max(row - 1, 0), min(row + 1, rows - 1) + 1):
            for u in range(max(column - 1, 0), min(column + 1, columns - 1) + 1):
                if blocked[v, u] and (v != row or u != column):
                    continue
                next_cell = v * columns + u
                for to in range(letters):
                    allowed = True
                    for region in range(len(sides)):
                        inside = (masks[to] >> region) & 1
                        side = sides[region, v, u]
                        if (side == INSIDE and not inside) or (side == OUTSIDE and inside):
                            allowed = False
                            break
                    if not allowed:
                        continue
                    after = state if to == letter else transition[state, to]
                    if sink[after] or seen[next_cell, to, after]:
                        continue
                    seen[next_cell, to, after] = True
                    if used == room:
                        longer = np.empty(2 * room, np.int64)
                        longer[:room] = stack
                        stack = longer
                        room *= 2
                    stack[used] = (next_cell * letters + to) * states + after
                    used += 1
    return False, reached
