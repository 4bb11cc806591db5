"""A maze: a spanning tree of corridors and a few openings more."""

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

_CORRIDOR_M = 1.0  # [m] clear width between walls
_WALL_M = 0.1  # [m] wall thickness, but one cell at least and two at most
_BRANCH = 10  # one place in so many is followed by a branch from elsewhere
_PLACES_PER_LOOP = 30  # one opening beyond the tree for so many places


def maze(
    width_m: float, height_m: float, resolution: float, rng: np.random.Generator
) -> OccupancyGrid:
    """A maze of corridors about 1 m wide: all connected, with dead ends and some loops.

    Sizes in metres, rounded to whole cells; at least 12 cells a side. The size is shared out
    among the corridors, whose widths differ by one cell at most, so that the maze fills the map.
    """
    rows, cols = round(height_m / resolution), round(width_m / resolution)
    wall = min(2, max(1, round(_WALL_M / resolution)))
    corridor = max(1, round(_CORRIDOR_M / resolution))
    high, wide = _places(rows, wall, corridor), _places(cols, wall, corridor)
    east, north = _tree(high, wide, rng)
    # Drawn with one cell for each stripe (wall, place, wall, ..., wall) along each axis; then
    # every stripe takes its thickness.
    drawn = np.full((2 * high + 1, 2 * wide + 1), OCCUPIED, np.uint8)
    drawn[1::2, 1::2] = FREE
    drawn[1::2, 2:-1:2][east] = FREE
    drawn[2:-1:2, 1::2][north] = FREE
    _add_loops(drawn, max(1, high * wide // _PLACES_PER_LOOP), rng)
    drawn = np.repeat(drawn, _stripes(rows, wall, high), axis=0)
    cells = np.repeat(drawn, _stripes(cols, wall, wide), axis=1)
    return OccupancyGrid(cells, resolution, name="maze")


def _places(cells: int, wall: int, corridor: int) -> int:
    """How many corridors of that width, with walls between and at the ends, fit in `cells`."""
    return max(1, (cells - wall) // (corridor + wall))


def _stripes(cells: int, wall: int, places: int) -> NDArray[np.int64]:
    """Thickness of each stripe in cells, (2 * places + 1,), adding up to `cells`."""
    starts = np.arange(places + 1, dtype=np.int64) * (cells - wall) // places
    thickness = np.full(2 * places + 1, wall, np.int64)
    thickness[1::2] = np.diff(starts) - wall
    return thickness


def _tree(
    high: int, wide: int, rng: np.random.Generator
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Walls opened by a spanning tree: to the east (high, wide - 1), to the north (high - 1, wide).

    The "growing tree": go on from the newest place into any new neighbour, step back where there
    is none, and now and then go on from some older place: long winding corridors that branch.
    """
    # A frame of places that count as seen spares the loop every test of the border.
    line = wide + 2
    seen = np.ones((high + 2, line), np.bool_)
    seen[1:-1, 1:-1] = False
    seen = bytearray(seen.tobytes())
    east, north = bytearray(len(seen)), bytearray(len(seen))
    ways: tuple[
        tuple[int, bytearray, int], ...
    ] = (  # step, where the opening is noted, at which offset
        (1, east, 0),
        (line, north, 0),
        (-1, east, -1),
        (-line, north, -line),
    )
    orders = list(permutations(ways))
    order: list[int] = rng.integers(0, len(orders), len(seen)).tolist()
    branch: list[int] = rng.integers(0, _BRANCH, len(seen)).tolist()
    elsewhere: list[int] = rng.integers(0, 2**31, len(seen)).tolist()

    place = int(rng.integers(1, high + 1)) * line + int(rng.integers(1, wide + 1))
    seen[place] = True
    active = [place]
    while active:
        place = active[-1]
        for step, opened, offset in orders[order[place]]:
            new = place + step
            if not seen[new]:
                seen[new] = True
                opened[place + offset] = True
                active.append(new)
                if branch[new] == 0:
                    other = elsewhere[new] % len(active)
                    active[-1], active[other] = active[other], active[-1]
                break
        else:
            active.pop()

    def inside(opened: bytearray) -> NDArray[np.bool_]:
        return np.frombuffer(opened, np.bool_).reshape(high + 2, line)[1:-1, 1:-1].copy()

    return inside(east)[:, :-1], inside(north)[:-1, :]


def _add_loops(drawn: NDArray[np.uint8], loops: int, rng: np.random.Generator) -> None:
    """Opens up to that many closed walls more, in place.

    A wall is opened only where each of its ends keeps another wall, so that no post is left
    standing alone in the middle of a crossing.
    """
    row, col = np.ogrid[: drawn.shape[0], : drawn.shape[1]]
    inner = (row > 0) & (row < drawn.shape[0] - 1) & (col > 0) & (col < drawn.shape[1] - 1)
    walls = np.argwhere((drawn == OCCUPIED) & inner & ((row + col) % 2 == 1))
    for row, col in walls[rng.permutation(len(walls))].tolist():
        if loops == 0:
            return
        down, left = (1, 0) if col % 2 == 0 else (0, 1)  # along the wall, to its two ends
        ends = ((row + down, col + left), (row - down, col - left))
        if all(_walls_at(drawn, *end) > 1 for end in ends):
            drawn[row, col] = FREE
            loops -= 1


def _walls_at(drawn: NDArray[np.uint8], row: int, col: int) -> int:
    """How many walls meet at a post; the map's border counts."""
    rows, cols = drawn.shape
    around = ((row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1))
    return sum(not (0 <= r < rows and 0 <= c < cols) or drawn[r, c] == OCCUPIED for r, c in around)
