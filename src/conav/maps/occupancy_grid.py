"""The occupancy grid: truth and belief alike."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FREE = 0
OCCUPIED = 1
UNKNOWN = 2


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A grid of square cells, each free, occupied or unknown.

    `cells[row, col]` has row 0 at the bottom: x grows with the column, y with the row. `origin` is
    the pose (x [m], y [m], yaw [rad]) of the lower left corner of cell (0, 0) in the map frame
    (ROS REP-103). The array is copied and locked.

    Raises `ValueError` when the array is not two-dimensional, is empty, or holds another value
    than `FREE`, `OCCUPIED`, `UNKNOWN`, or when the resolution is not a positive number.
    """

    cells: NDArray[np.uint8]  # (rows, cols), row 0 at the bottom
    resolution: float  # [m] side of a cell
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)  # x [m], y [m], yaw [rad]
    name: str = "map"
    warnings: tuple[str, ...] = field(default=())  # what a reader found odd, for people

    def __post_init__(self) -> None:
        cells = np.array(self.cells, dtype=np.uint8, order="C", copy=True)
        if cells.ndim != 2 or cells.size == 0:
            raise ValueError(f"cells must be a non-empty (rows, cols) array, not {cells.shape}")
        if int(cells.max()) > UNKNOWN:
            raise ValueError("cells may hold only FREE (0), OCCUPIED (1) and UNKNOWN (2)")
        if not (np.isfinite(self.resolution) and self.resolution > 0):
            raise ValueError(f"resolution must be a positive number, not {self.resolution}")
        if not all(np.isfinite(value) for value in self.origin):
            raise ValueError(f"origin must be finite numbers, not {self.origin}")
        cells.flags.writeable = False
        object.__setattr__(self, "cells", cells)

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        # Through the constructor, so that an unpickled grid is locked again.
        return (OccupancyGrid, (self.cells, self.resolution, self.origin, self.name, self.warnings))

    @property
    def rows(self) -> int:
        return self.cells.shape[0]

    @property
    def cols(self) -> int:
        return self.cells.shape[1]

    @property
    def width_m(self) -> float:
        """Extent along the map's x axis [m]."""
        return self.cols * self.resolution

    @property
    def height_m(self) -> float:
        """Extent along the map's y axis [m]."""
        return self.rows * self.resolution

    def area_m2(self, value: int) -> float:
        """The area of the cells with that value [m^2]."""
        return int(np.count_nonzero(self.cells == value)) * self.resolution * self.resolution
