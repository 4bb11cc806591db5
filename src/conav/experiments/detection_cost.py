"""What frontier detection costs in explored areas of several shapes: [Philip2014] section 3.1.

The cost of reaching all explored cells by deterministic value iteration, as frontier detection
after Burgard et al. needs it; by one Dijkstra search; and a scan for frontier cells. Counters are
exact and equal on every machine; times are the best of many.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.experiments.timing import Progress, timed
from conav.geometry.clearance import free_moves
from conav.geometry.grid_search import search, search_space
from conav.geometry.value_iteration import (
    Sweeps,
    raster_order,
    there_and_back,
    value_iteration,
)
from conav.maps.builtin.maze import maze
from conav.maps.builtin.office import office
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN

AREAS = ("open", "blocks", "office", "maze", "winding")
"""Explored areas: empty; with a few rectangles; the built-in office and maze, of more rooms and
corridors the larger they are; one corridor, a cell wide, that fills the map row by row."""


class Detection(NamedTuple):
    """What one frontier detection costs in one explored area."""

    area: str
    side: int
    explored: int  # cells
    sweeps: int  # value iteration, always in raster order
    touched: int  # cells, over all sweeps
    value_iteration_ms: float
    back_sweeps: int  # the same in raster order and backwards in turn
    back_touched: int
    back_ms: float
    searched: int  # cells settled by a Dijkstra search
    search_ms: float
    frontier: int  # cells found by looking at the neighbours of every explored cell
    scan_ms: float


class Area(NamedTuple):
    """An explored area and where a robot stands in it."""

    cells: NDArray[np.uint8]  # (side, side) FREE and OCCUPIED, UNKNOWN around
    moves: NDArray[np.uint8]  # (side, side)
    start: int


def explored_area(name: str, side: int, seed: int = 1) -> Area:
    """The explored area of that name (`AREAS`) in a map of side * side cells.

    The robot stands in its middle, or at the lower end of the winding corridor. Where the area has
    no walls of its own it ends at the unknown, one cell from the border.
    """
    cells = np.full((side, side), FREE, dtype=np.uint8)
    rng = np.random.default_rng(seed)
    if name == "blocks":
        for low, left, high, right in _BLOCKS:
            span = [round(side * part / 16) for part in (low, high, left, right)]
            cells[span[0] : span[1], span[2] : span[3]] = OCCUPIED
    elif name in ("office", "maze"):
        make = office if name == "office" else maze
        cells = make(side * 0.1, side * 0.1, 0.1, rng).cells.copy()
    elif name == "winding":
        cells[:] = OCCUPIED
        cells[1:-1:2, 1:-1] = FREE
        cells[2:-2:4, -2] = FREE
        cells[4:-2:4, 1] = FREE
    elif name != "open":
        raise ValueError(f"no explored area {name!r}; there are {', '.join(AREAS)}")
    if name in ("open", "blocks"):
        cells[[0, -1], :] = UNKNOWN
        cells[:, [0, -1]] = UNKNOWN
    moves = np.ascontiguousarray(free_moves(cells, side, side, 1.0, 1e-3)[:, :, 1])
    row, col = (1, 1) if name == "winding" else _nearest_free(cells, side // 2, side // 2)
    return Area(cells, moves, row * side + col)


# Rectangles in sixteenths of the side: low row, left column, high row, right column.
_BLOCKS = ((2, 2, 5, 7), (3, 10, 9, 12), (9, 3, 13, 5), (11, 8, 13, 14), (6, 5, 7, 8))


def _nearest_free(cells: NDArray[np.uint8], row: int, col: int) -> tuple[int, int]:
    """The free cell nearest to a place."""
    rows, cols = np.nonzero(cells == FREE)
    nearest = int(np.argmin((rows - row) ** 2 + (cols - col) ** 2))
    return int(rows[nearest]), int(cols[nearest])


def detection_by_area(
    name: str,
    sides: Sequence[int],
    *,
    budget_s: float = 1.0,
    limit_s: float = 10.0,
    seed: int = 1,
    progress: Progress | None = None,
) -> list[Detection]:
    """A row for each size of an explored area, in the order given.

    Ends after the first on which one detection by value iteration takes longer than `limit_s`:
    fewer rows than sides say so, and so does `progress`.
    """
    rows: list[Detection] = []
    for side in sides:
        if progress is not None:
            progress(f"frontier detection in {name}, {side} x {side} cells")
        rows.append(detection(name, side, budget_s, seed))
        if rows[-1].value_iteration_ms > limit_s * 1e3:
            if progress is not None:
                progress(f"{name} ends here: a detection took over {limit_s:g} s")
            break
    return rows


def detection(name: str, side: int, budget_s: float = 1.0, seed: int = 1) -> Detection:
    """What one frontier detection costs in an explored area of that name and size.

    The list of explored cells is given to value iteration and scan, and not timed.
    """
    cells, moves, start = explored_area(name, side, seed)
    order = raster_order(moves, start)
    cost = np.empty(moves.size, dtype=np.float64)
    space = search_space(moves.size)
    nowhere = np.zeros_like(moves)

    def iterate(orders: NDArray[np.int32]) -> tuple[Sweeps, float]:
        return timed(lambda: value_iteration(moves, start, cost, orders), budget_s)

    work, work_s = iterate(order)
    back, back_s = iterate(there_and_back(order))
    _, search_s = timed(lambda: search(moves, start, nowhere, 255, space), budget_s)
    frontier, scan_s = timed(lambda: _scan(cells, order[0]), budget_s)
    return Detection(
        area=name,
        side=side,
        explored=order.shape[1],
        sweeps=work.sweeps,
        touched=work.touched,
        value_iteration_ms=work_s * 1e3,
        back_sweeps=back.sweeps,
        back_touched=back.touched,
        back_ms=back_s * 1e3,
        searched=int(np.count_nonzero(space.stamp[:-1] == space.stamp[-1])),
        search_ms=search_s * 1e3,
        frontier=frontier,
        scan_ms=scan_s * 1e3,
    )


@kernel
def _scan(cells: NDArray[np.uint8], explored: NDArray[np.int32]) -> int:
    """How many of the explored cells, none at the border of the map, have an unknown neighbour."""
    cols = cells.shape[1]
    flat = cells.reshape(-1)
    count = 0
    for i in range(explored.shape[0]):
        cell = explored[i]
        if (
            flat[cell + 1] == UNKNOWN
            or flat[cell - 1] == UNKNOWN
            or flat[cell + cols] == UNKNOWN
            or flat[cell - cols] == UNKNOWN
        ):
            count += 1
    return count
