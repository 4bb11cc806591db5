"""Planning cells over a map: where a robot of some radius can stand and which moves it can make."""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.geometry.clearance import components, free_moves
from conav.geometry.directions import ALL, STRAIGHT
from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

MAX_CELLS = 100_000_000


@dataclass(frozen=True, eq=False)
class Lattice:
    """Where planning cells lie over the fine cells of a map; says nothing about walls.

    Flat indices of planning cells count row by row from the lower left. The grid's own frame has
    its origin at the lower left corner of the map and leaves out the map's yaw.
    """

    fine_rows: int
    fine_cols: int
    resolution: float  # [m] side of a fine cell
    rows: int
    cols: int
    cell_m: float  # [m] side of a planning cell
    fine_row: NDArray[np.int32]  # (rows,) fine row of a planning cell's centre
    fine_col: NDArray[np.int32]  # (cols,) fine column of a planning cell's centre
    row_of: NDArray[np.int32]  # (fine_rows,) planning row a fine row lies in
    col_of: NDArray[np.int32]  # (fine_cols,) planning column a fine column lies in

    def __setstate__(self, state: dict[str, Any]) -> None:
        _restore_locked(self, state)

    @property
    def ratio(self) -> float:
        """Fine cells per side of a planning cell."""
        return self.cell_m / self.resolution

    def position(self, cell: int) -> tuple[float, float]:
        """The centre x, y [m] of a planning cell (flat index) in the grid's own frame."""
        return (
            (cell % self.cols + 0.5) * self.cell_m,
            (cell // self.cols + 0.5) * self.cell_m,
        )

    def cell_at(self, x: float, y: float) -> int:
        """The flat index of the planning cell around a point of the grid's own frame [m].

        Strips at the far borders too narrow for a cell of their own belong to the last one; -1 for
        points off the map.
        """
        if not (0 <= x <= self.fine_cols * self.resolution):
            return -1
        if not (0 <= y <= self.fine_rows * self.resolution):
            return -1
        col = min(int(x / self.cell_m), self.cols - 1)
        row = min(int(y / self.cell_m), self.rows - 1)
        return row * self.cols + col


@dataclass(frozen=True, eq=False)
class PlanningGrid:
    """The truth a simulation runs on: fine cells for sight, planning cells for motion.

    Sight and coverage live on the map's own fine cells; robots stand at the centres of planning
    cells, whose side need not be a whole multiple of the map's resolution. Moves were tested with
    the robot's disc swept along the straight line over the fine cells.
    """

    grid: OccupancyGrid
    lattice: Lattice
    radius_m: float  # [m] of the robot's disc
    diagonal: bool  # whether diagonal moves are among the moves
    walls: NDArray[np.uint8]  # (fine rows, fine cols) FREE or OCCUPIED; unknown counts as a wall
    moves: NDArray[np.uint8]  # (rows, cols) bit k: the move in direction k is possible
    standable: NDArray[np.uint8]  # (rows, cols) 1 where the disc fits at the centre
    labels: NDArray[np.int32]  # (rows, cols) connected part, -1 where the disc does not fit

    def __setstate__(self, state: dict[str, Any]) -> None:
        _restore_locked(self, state)

    @property
    def radius_fine(self) -> float:
        """The robot's radius in fine cells, floored at a thousandth of a cell."""
        return max(self.radius_m / self.grid.resolution, 1e-3)


def default_cell(resolution: float, radius_m: float) -> float:
    """The default side of a planning cell [m]: the smallest multiple of the resolution that lets
    robots follow each other round a corner without touching, which takes 2 sqrt(2) radii.
    """
    wanted = 2.0 * 2.0**0.5 * radius_m
    pixels = max(int(np.ceil(wanted / resolution - 1e-9)), 1)
    return round(pixels * resolution, 12)  # 3 * 0.1 without its rounding error


def planning_grid(
    grid: OccupancyGrid,
    *,
    cell_m: float | None = None,
    radius_m: float = 0.0,
    diagonal: bool = True,
) -> PlanningGrid:
    """The planning cells of a map for robots of one radius.

    `cell_m` defaults to `default_cell`. Without `diagonal` only straight moves are kept. Unknown
    cells are opaque walls.

    Raises `InputError` when no planning cell would remain or there would be absurdly many.
    """
    cell = default_cell(grid.resolution, radius_m) if cell_m is None else float(cell_m)
    if not (np.isfinite(cell) and cell > 0):
        raise InputError(f"cell {cell}", "is not a positive length", "give --cell in metres")
    if not (np.isfinite(radius_m) and radius_m >= 0):
        raise InputError(
            f"radius {radius_m}", "is not a length", "give --radius in metres, 0 or more"
        )
    ratio = cell / grid.resolution
    # Planning cells whose centre lies on the map.
    rows = int(np.ceil(grid.rows / ratio - 0.5 - 1e-9))
    cols = int(np.ceil(grid.cols / ratio - 0.5 - 1e-9))
    if (rows < 1 or cols < 1) and cell_m is None:
        raise InputError(
            f"radius {radius_m:g} m",
            f"is too large for the map {grid.name} ({grid.width_m:g} x {grid.height_m:g} m)",
            "give a smaller --radius",
        )
    if rows < 1 or cols < 1:
        raise InputError(
            f"cell {cell:g} m",
            f"is larger than the map {grid.name} ({grid.width_m:g} x {grid.height_m:g} m)",
            "give a smaller --cell",
        )
    if rows * cols > MAX_CELLS:
        raise InputError(
            f"cell {cell:g} m",
            f"makes {rows} x {cols} planning cells on the map {grid.name}",
            f"give a larger --cell, for example {grid.resolution:g}",
        )
    walls = np.where(grid.cells == FREE, FREE, OCCUPIED).astype(np.uint8)
    radius = max(radius_m / grid.resolution, 1e-3)
    both = free_moves(walls, rows, cols, ratio, radius)
    moves = np.ascontiguousarray(both[:, :, 1]) & np.uint8(ALL if diagonal else STRAIGHT)
    standable = np.ascontiguousarray(both[:, :, 0])
    labels = components(moves, standable)
    lattice = Lattice(
        fine_rows=grid.rows,
        fine_cols=grid.cols,
        resolution=grid.resolution,
        rows=rows,
        cols=cols,
        cell_m=cell,
        fine_row=_locked(np.minimum(_centres(rows, ratio), grid.rows - 1)),
        fine_col=_locked(np.minimum(_centres(cols, ratio), grid.cols - 1)),
        row_of=_locked(np.minimum(_centres(grid.rows, 1.0 / ratio), rows - 1)),
        col_of=_locked(np.minimum(_centres(grid.cols, 1.0 / ratio), cols - 1)),
    )
    return PlanningGrid(
        grid=grid,
        lattice=lattice,
        radius_m=float(radius_m),
        diagonal=diagonal,
        walls=_locked(walls),
        moves=_locked(moves),
        standable=_locked(standable),
        labels=_locked(labels),
    )


def _centres(count: int, ratio: float) -> NDArray[np.int32]:
    return ((np.arange(count) + 0.5) * ratio).astype(np.int32)


@dataclass(frozen=True)
class StartArea:
    """The part of a map robots start in: its label, its planning cells, and what was odd."""

    label: int
    cells: NDArray[np.int32]  # flat indices, ascending
    warnings: tuple[str, ...]


def default_start_area(plan: PlanningGrid, *, outside: bool = False) -> StartArea:
    """The largest connected part robots can move in, leaving out an outside that is drawn free.

    A part that touches the border of the picture is passed over when another part, one that does
    not touch it, has at least a tenth of the standable area: floor plans often have the world
    around the building drawn free. `outside` keeps the largest part whatever it touches.

    Raises `InputError` when the robot fits nowhere.
    """
    labels = plan.labels
    count = int(labels.max()) + 1 if labels.size else 0
    if count == 0:
        free = plan.grid.area_m2(FREE)
        problem = (
            "has no free cell"
            if free == 0
            else f"has no place where a robot of radius {plan.radius_m:g} m fits"
        )
        raise InputError(plan.grid.name, problem, "give a smaller --radius or another map")
    sizes = np.bincount(labels[labels >= 0].ravel(), minlength=count)
    largest = int(np.argmax(sizes))
    chosen = largest
    warnings: list[str] = []
    if not outside:
        border = _labels_at_border(plan)
        inner = [label for label in np.argsort(-sizes, kind="stable") if int(label) not in border]
        if largest in border and inner and sizes[inner[0]] * 10 >= int(sizes.sum()):
            chosen = int(inner[0])
            warnings.append(
                f"the largest free part ({_share(sizes, largest)}) touches the border of the map "
                f"and looks like the outside of a building drawn free; robots start in the largest "
                f"part inside ({_share(sizes, chosen)}); use --outside to start in the largest part"
            )
    cells = np.flatnonzero(labels.ravel() == chosen).astype(np.int32)
    return StartArea(label=chosen, cells=cells, warnings=tuple(warnings))


def _share(sizes: NDArray[np.int64], label: int) -> str:
    return f"{100 * int(sizes[label]) / int(sizes.sum()):.0f} % of the standable area"


def _labels_at_border(plan: PlanningGrid) -> set[int]:
    """Parts with a planning cell as near to the picture's border as the robot's disc allows."""
    depth = int(plan.radius_m / plan.lattice.cell_m) + 1
    labels = plan.labels
    edge = np.concatenate(
        [
            labels[:depth].ravel(),
            labels[-depth:].ravel(),
            labels[:, :depth].ravel(),
            labels[:, -depth:].ravel(),
        ]
    )
    return {int(label) for label in np.unique(edge) if label >= 0}


Array = TypeVar("Array", bound=np.ndarray[Any, Any])


def _locked(array: Array) -> Array:
    array.flags.writeable = False
    return array


def _restore_locked(item: object, state: dict[str, Any]) -> None:
    """Unpickling gives back writable arrays; these stay locked."""
    item.__dict__.update(state)
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
