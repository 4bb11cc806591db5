"""Nearest frontier without coordination (Yamauchi 1998)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import STOOD, TARGET, Belief
from conav.exploration.types import Action, TeamView
from conav.exploration.viewpoints import beside_frontier, nearest_viewpoint
from conav.geometry.directions import DCOL, DROW
from conav.geometry.distance_field import (
    field_buffer,
    fill_distances,
    shortest_path,
    walk_back,
)
from conav.geometry.grid_search import path_to, search, search_space
from conav.maps.occupancy_grid import UNKNOWN
from conav.messages.message import Message

_NO_PATH = np.empty(0, dtype=np.int8)


@dataclass
class NearestMemory:
    """Where the robot is going."""

    goal: int = -1  # planning cell, -1 for none
    looks_for: int = -1  # unknown fine cell the goal may see, -1 when the goal has a frontier near
    path: NDArray[np.int8] = field(default_factory=lambda: _NO_PATH)  # moves, the last one first
    beside: bool = False  # the frontier is in a neighbour of the goal
    left: int = 0  # moves of the path still to make
    here: int = -1  # planning cell from which they start
    idle_since: int = -1  # cells known when nothing was left to do


@dataclass(frozen=True)
class Nearest:
    """Every robot goes to the frontier nearest to itself, by path length over what it knows.

    Frontiers are shared through the map, goals are not, so several robots may choose the same one:
    this is the uncoordinated method with shared scans of Yamauchi (Agents 1998), who takes the
    nearest accessible, unvisited frontier. Differences: a goal is given up as soon as it is no
    frontier any more, because with a sensor that sees far most are resolved on the way; and where
    no frontier cell can be stood on, the robot goes to the nearest place from which an unknown cell
    beside a frontier may be seen, which takes the place of the paper's list of inaccessible
    frontiers and lets it finish.
    """

    keep_goal: bool = False
    """Drive up to the goal even when its frontier has been resolved on the way."""

    def start(self, view: TeamView, rng: np.random.Generator) -> NearestMemory:
        return NearestMemory()

    def step(
        self,
        memory: NearestMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[NearestMemory, Action, Sequence[Message]]:
        if not keeps_goal(memory, view, self.keep_goal):
            choose_nearest(memory, view)
        return memory, drive_on(memory), ()


def drive_on(memory: NearestMemory) -> Action:
    """The next move of the plan in memory; without a plan the robot is finished."""
    if memory.goal < 0:
        return Action(finished=True)
    return Action(int(memory.path[memory.left - 1]), memory.goal)


def keeps_goal(memory: NearestMemory, view: TeamView, to_the_end: bool = False) -> bool:
    """Whether the plan in memory still holds; advances it when its next move was made.

    With `to_the_end` it holds although its frontier has been resolved on the way.
    """
    goal = memory.goal
    belief = view.belief
    if goal < 0:
        return memory.idle_since == belief.known
    if view.cell != memory.here:
        direction = int(memory.path[memory.left - 1])
        if view.cell != memory.here + DROW[direction] * view.lattice.cols + DCOL[direction]:
            return False  # pushed off the path
        memory.here = view.cell
        memory.left -= 1
    if memory.left == 0 or belief.marks.item(goal) & STOOD:
        return False
    return to_the_end or _wanted(memory, belief)


def off_path(memory: NearestMemory, view: TeamView) -> bool:
    """Whether a goal that was not kept still promises something new, and is somewhere else."""
    goal = memory.goal
    if goal < 0 or view.cell in (goal, memory.here) or view.belief.marks.item(goal) & STOOD:
        return False
    return _wanted(memory, view.belief)


def _wanted(memory: NearestMemory, belief: Belief) -> bool:
    """Whether the goal still promises something new."""
    if memory.looks_for >= 0:
        return belief.cells.item(memory.looks_for) == UNKNOWN
    if belief.marks.item(memory.goal) & TARGET:
        return True
    row, col = divmod(memory.goal, belief.marks.shape[1])
    around = belief.frontier_count[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
    return memory.beside and bool(around.any())


def drive_to(memory: NearestMemory, view: TeamView, goal: int, looks_for: int = -1) -> bool:
    """Whether the robot can get to that planning cell from elsewhere; then the plan is to do so.

    `looks_for` is an unknown fine cell that may be seen from there, -1 where the goal has frontier.
    """
    if goal < 0 or goal == view.cell:
        return False
    path, left = shortest_path(view.belief.ground, view.cell, goal)
    if left == 0:
        return False
    memory.goal = goal
    memory.looks_for = looks_for
    memory.beside = False
    memory.here = view.cell
    memory.path, memory.left = path, left
    return True


Route = tuple[int, NDArray[np.int8], int]
"""A goal, -1 for none, the moves to it, the last one first, and how many they are."""
NO_ROUTE: Route = (-1, _NO_PATH, 0)


class Find(Protocol):
    """A way to find the nearest cell whose `goals` share a bit with `mask`, the lower of equals."""

    def __call__(self, belief: Belief, start: int, goals: NDArray[np.uint8], mask: int) -> Route:
        """The route to it over known moves."""
        ...


def by_search(belief: Belief, start: int, goals: NDArray[np.uint8], mask: int) -> Route:
    """The route that a search from the robot outwards comes by first."""
    # A search that finds nothing goes everywhere; often a look at the map tells before.
    if not _may_be_reached(goals, mask, belief.moves, start):
        return NO_ROUTE
    space = search_space(belief.moves.size)
    goal = search(belief.moves, start, goals, mask, space)
    if goal < 0:
        return NO_ROUTE
    return (goal, *path_to(space, belief.moves.shape[1], goal))


def by_field(belief: Belief, start: int, goals: NDArray[np.uint8], mask: int) -> Route:
    """The route of `shortest_path`; several times faster, and of equal paths often another one."""
    if not _may_be_reached(goals, mask, belief.moves, start):
        return NO_ROUTE
    cells = np.flatnonzero((goals & mask) != 0)
    distance = field_buffer(belief.moves.size)
    one_group = np.array([0, len(cells)])
    fill_distances(belief.ground, np.array([start]), distance, one_group, cells)
    goal = int(cells[np.argmin(distance[cells])])
    if distance[goal] == np.inf:
        return NO_ROUTE
    return (goal, *walk_back(belief.ground, distance, goal))


def choose_nearest(memory: NearestMemory, view: TeamView, find: Find = by_search) -> None:
    """Set the nearest goal and the path to it, or none."""
    belief = view.belief
    memory.looks_for = -1
    memory.beside = False
    goal, path, left = find(belief, view.cell, belief.marks, TARGET)
    if goal < 0 and belief.frontier_count.any():
        memory.beside = True
        goal, path, left = find(belief, view.cell, beside_frontier(belief), 1)
        if goal < 0:
            distance = field_buffer(belief.moves.size)
            fill_distances(belief.ground, np.array([view.cell]), distance)
            there, memory.looks_for = nearest_viewpoint(
                belief, view.lattice, view.body.sensor, distance
            )
            if there >= 0:
                only = np.zeros_like(belief.marks)
                only.reshape(-1)[there] = 1
                goal, path, left = find(belief, view.cell, only, 1)
    memory.goal = goal
    if goal < 0:
        memory.idle_since = belief.known
        return
    memory.here = view.cell
    memory.path, memory.left = path, left


@kernel
def _may_be_reached(
    goals: NDArray[np.uint8], mask: int, moves: NDArray[np.uint8], start: int
) -> bool:
    """Whether one of the goals is the start, or has any move."""
    wanted = goals.reshape(-1)
    flat = moves.reshape(-1)
    if wanted[start] & mask:
        return True
    found = False
    for i in range(wanted.shape[0]):
        if wanted[i] & mask and flat[i] != 0:
            found = True
            break
    return found
