"""Robots on a grid: unit steps and waits, and the game they play there.

Time is in steps. A robot goes to one of the four neighbours of its cell or waits; it arrives when
it enters its goal for the last time, and from then on it is there. Its cost is the number of steps
until it arrives. Two robots are never in one cell, and never change places in one step. This is
multi-agent path finding with its sum of costs [Stern2019], so what is found here can be held
against its solvers; the answers are those of the sampled graphs, by the same dynamic programme in
the order of time.
"""

import os
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.movingai import read_movingai
from conav.maps.occupancy_grid import FREE
from conav.planning.foreign.movingai_scenario import map_path, read_entries

Cells = NDArray[np.int64]  # (steps + 1,) numbers of cells at times 0, 1, ...

UNREACHED = 1 << 40
"""More steps than any path has."""


@dataclass(frozen=True, eq=False)
class GridProblem:
    """A grid with a start and a goal for each robot.

    `free` has shape (rows, cols); cells are numbered row * cols + col. `horizon` is the last step
    by which everybody has arrived. Raises `InputError` for cells that are not free or are shared.
    """

    free: NDArray[np.bool_]
    starts: tuple[int, ...]
    goals: tuple[int, ...]
    horizon: int
    name: str = "grid"

    def __post_init__(self) -> None:
        free = np.array(self.free, dtype=np.bool_)
        free.flags.writeable = False
        object.__setattr__(self, "free", free)
        if len(self.starts) != len(self.goals) or not self.starts:
            raise InputError("grid problem", "each robot needs a start and a goal")
        flat = free.ravel()
        for what, cells in (("start", self.starts), ("goal", self.goals)):
            for robot, cell in enumerate(cells):
                if not 0 <= cell < flat.size or not flat[cell]:
                    raise InputError(f"robot {robot}", f"its {what}, cell {cell}, is not free")
            if len(set(cells)) < len(cells):
                raise InputError("grid problem", f"two robots have the same {what}")

    @property
    def size(self) -> int:
        """The number of robots."""
        return len(self.starts)


def grid_of_text(text: str, horizon: int, name: str = "grid") -> GridProblem:
    """The problem in a drawing: `#` is a wall, `a` where a robot starts and `A` where it goes.

    Where robots start on each other's goals a second drawing, after an empty line, has the goals.

        >>> swap = grid_of_text("a.b\\n#.#\\n\\nB.A\\n#.#", horizon=9)
        >>> swap.starts, swap.goals
        ((0, 2), (2, 0))
    """
    drawings = ["".join(part.split()) for part in text.strip().split("\n\n")]
    rows = text.strip().split("\n\n")[0].split()
    first, last = drawings[0], drawings[-1]
    if len({len(row) for row in rows}) != 1 or len(first) != len(last):
        raise InputError(f"drawing of {name}", "has rows of different lengths")
    names = sorted(letter for letter in first if letter.islower())
    for letter in names:
        if first.count(letter) != 1 or last.count(letter.upper()) != 1:
            raise InputError(f"drawing of {name}", f"robot {letter} needs one start and one goal")
    return GridProblem(
        np.array([[letter != "#" for letter in row] for row in rows]),
        tuple(first.index(letter) for letter in names),
        tuple(last.index(letter.upper()) for letter in names),
        horizon,
        name,
    )


def read_grid_scenario(
    path: str | os.PathLike[str], robots: int, horizon: int | None = None
) -> GridProblem:
    """The problem of the first entries of a MovingAI `.scen` file, on the map that it names.

    The first row of the map is row 0. `horizon` is by default four times the longest shortest path,
    and 64 more. Raises `InputError` for what does not fit.
    """
    path = Path(path)
    entries = read_entries(path)
    if not 1 <= robots <= len(entries):
        raise InputError(path, f"has {len(entries)} entries, not {robots}")
    entries = entries[:robots]
    grid = read_movingai(map_path(path, entries[0]))
    free = grid.cells[::-1] == FREE
    starts = tuple(entry.start[1] * grid.cols + entry.start[0] for entry in entries)
    goals = tuple(entry.goal[1] * grid.cols + entry.goal[0] for entry in entries)
    if horizon is None:
        ways = [distances(free, goal)[start] for start, goal in zip(starts, goals, strict=True)]
        horizon = 4 * max(ways) + 64
    return GridProblem(free, starts, goals, horizon, path.stem)


def neighbours(free: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Where a robot can be a step later, (cells, 5): here, below, above, left, right.

    `cells` in place of a cell that is not there or not free.
    """
    rows, cols = free.shape
    missing = free.size
    numbers = np.full((rows + 2, cols + 2), missing, np.int64)
    numbers[1:-1, 1:-1] = np.where(free, np.arange(free.size).reshape(rows, cols), missing)
    views = (
        numbers[1:-1, 1:-1],
        numbers[:-2, 1:-1],
        numbers[2:, 1:-1],
        numbers[1:-1, :-2],
        numbers[1:-1, 2:],
    )
    return np.stack([view.ravel() for view in views], axis=1)


def distances(free: NDArray[np.bool_], goal: int) -> list[int]:
    """The steps from each cell to a goal with nobody about; `UNREACHED` where there is no way."""
    near = neighbours(free).tolist()
    steps = [UNREACHED] * free.size
    steps[goal] = 0
    queue = deque([goal])
    while queue:
        cell = queue.popleft()
        for other in near[cell]:
            if other < free.size and steps[other] == UNREACHED:
                steps[other] = steps[cell] + 1
                queue.append(other)
    return steps


def at(path: Cells, step: int) -> int:
    """The cell at a step; after its arrival a robot is at its goal."""
    return int(path[min(step, len(path) - 1)])


def cost(path: Cells) -> int:
    """The steps until arrival."""
    return len(path) - 1


def apart(a: Cells, b: Cells) -> bool:
    """Whether two robots never share a cell and never change places."""
    for step in range(max(len(a), len(b))):
        if at(a, step) == at(b, step):
            return False
        if step and at(a, step) == at(b, step - 1) and at(a, step - 1) == at(b, step):
            return False
    return True
