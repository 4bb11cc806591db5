"""A map alone, as a picture and as text."""

import os
from pathlib import Path

import numpy as np

from conav.errors import InputError
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

SHADES = {FREE: 255, OCCUPIED: 30, UNKNOWN: 170}


def save_map(grid: OccupancyGrid, path: str | os.PathLike[str], *, max_pixels: int = 1200) -> None:
    """Draw the map to a PNG: free white, occupied black, unknown grey, north up.

    Small maps are enlarged by whole factors. Raises `InputError` when it cannot be written.
    """
    from PIL import Image

    path = Path(path)
    if path.suffix.lower() != ".png":
        raise InputError(path, "is no .png file name", "end it in .png")
    table = np.array([SHADES[FREE], SHADES[OCCUPIED], SHADES[UNKNOWN]], dtype=np.uint8)
    picture = Image.fromarray(table[grid.cells[::-1]])
    factor = max(max_pixels // max(grid.rows, grid.cols), 1)
    picture = picture.resize((grid.cols * factor, grid.rows * factor), Image.Resampling.NEAREST)
    try:
        picture.save(path, format="PNG", optimize=True)
    except OSError as error:
        raise InputError(
            path, f"cannot be written ({error.strerror})", "choose another --png"
        ) from None


def sketch(grid: OccupancyGrid, *, width: int) -> list[str]:
    """The map in characters, at most `width` wide, north up: # wall, ? unknown, blank free.

    A character stands for a block of cells twice as high as wide and shows a wall where there is
    one in its middle rows or columns.
    """
    across = -(-grid.cols // min(width, grid.cols))
    down = 2 * across
    lines: list[str] = []
    for top in range(grid.rows, 0, -down):
        line = ""
        for left in range(0, grid.cols, across):
            block = grid.cells[max(top - down, 0) : top, left : left + across]
            walls = np.count_nonzero(block == OCCUPIED)
            if walls >= max(min(block.shape), 1):
                line += "#"
            else:
                line += "?" if np.count_nonzero(block == UNKNOWN) * 2 > block.size else " "
        lines.append(line.rstrip())
    return lines
