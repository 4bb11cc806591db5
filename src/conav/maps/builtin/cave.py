"""A natural cave: chambers joined by winding passages."""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

_PITCH_M = 0.25  # [m] the layout is made on a lattice about this fine, whatever the cells are
_REACH_M = 0.55  # [m] rock is cleared at least this far around the layout
_SWELL_M = 0.45  # [m] and up to so much farther, so that passages widen and narrow
_SWELL_WIDTH_M = 0.7  # [m] how fast that changes along a wall
_ROBOT_M = 0.2  # [m] radius of the robots that can reach all of the cave
_MARGIN_M = 0.2  # [m] rock left at the border
_CHAMBERS = 15  # [%] of the lattice laid out as chambers
_PASSAGES = 11  # [%] of the lattice laid out as passages
_LEAST_PART_M2 = 0.6  # [m^2] smaller parts of the layout are dropped, not connected
_LEAST_PILLAR_M2 = 0.15  # [m^2] smaller pieces of rock are cleared


def cave(
    width_m: float, height_m: float, resolution: float, rng: np.random.Generator
) -> OccupancyGrid:
    """A cave whose chambers are joined by passages at least 0.8 m wide.

    Sizes in metres, rounded to whole cells; at least 12 cells a side. There are chambers where one
    smooth random field is high and passages where another crosses its middle; parts that stay
    apart are joined by tunnels. This layout is where the centre of a wide robot can be, and the
    cave is all that is near it: thus it is connected and its passages are nowhere narrow. In cells
    above 0.5 m everything is larger, so that passages stay several cells wide.
    """
    rows, cols = round(height_m / resolution), round(width_m / resolution)
    step = max(1, int(_PITCH_M / resolution))  # cells from one lattice point to the next
    shape = (rows - 1) // step + 2, (cols - 1) // step + 2  # the last points lie outside the map
    # Lengths below are in units of 1 m, or of two lattice points where these are wider apart.
    pitch = min(0.5, step * resolution)
    layout = _layout(shape, (rows, cols), step, pitch, rng)
    swell_m = _SWELL_M * np.clip(_smooth(shape, _SWELL_WIDTH_M / pitch, rng) + 0.5, 0.0, 1.0)
    away_m = _distance(layout) * pitch - swell_m
    free = _upsampled(away_m, step, (rows, cols)) <= _REACH_M
    free = _without_specks(free, round(_LEAST_PILLAR_M2 / (resolution * resolution)))
    free = _within_reach(free, _ROBOT_M / resolution)
    return OccupancyGrid(np.where(free, FREE, OCCUPIED), resolution, name="cave")


def _layout(
    shape: tuple[int, int],
    cells: tuple[int, int],
    step: int,
    pitch: float,
    rng: np.random.Generator,
) -> NDArray[np.bool_]:
    """Lattice points on which the cave is built: one 4-connected part, clear of the border."""
    chambers = _smooth(shape, 2.4 / pitch, rng) + 0.2 * _smooth(shape, 0.8 / pitch, rng)
    passages = np.abs(_smooth(shape, 2.0 / pitch, rng))
    margin = max(1, int((_MARGIN_M + _REACH_M + _SWELL_M) / pitch) + 1)
    last = [(size - 1) // step + 1 - margin for size in cells]
    inside = np.zeros(shape, np.bool_)
    inside[margin : last[0], margin : last[1]] = True
    if not inside.any():
        inside[shape[0] // 2, shape[1] // 2] = True
    layout = np.zeros(shape, np.bool_)
    layout[inside] = _lowest(-chambers[inside], _CHAMBERS) | _lowest(passages[inside], _PASSAGES)
    return _joined(layout, round(_LEAST_PART_M2 / (pitch * pitch)))


def _smooth(shape: tuple[int, int], width: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A random field with middle 0 and middle half 1 high; hills are about 3 `width` apart."""
    side = max(1, round(width))
    grown = shape[0] + 3 * (side - 1), shape[1] + 3 * (side - 1)
    field = rng.integers(0, 256, grown)
    # Three running sums along each axis are near to a Gaussian, and exact in integers.
    for _ in range(3):
        field = _running_sum(_running_sum(field, side).T, side).T
    low, middle, high = (_ranked(field, percent) for percent in (25, 50, 75))
    return (field.astype(np.float64) - middle) / max(1.0, high - low)


def _running_sum(field: NDArray[np.int64], side: int) -> NDArray[np.int64]:
    """Sums of so many rows that follow each other, (rows - side + 1, cols)."""
    total = np.zeros((field.shape[0] + 1, field.shape[1]), np.int64)
    np.cumsum(field, axis=0, out=total[1:])
    return total[side:] - total[:-side]


def _ranked(values: NDArray[np.generic], percent: int) -> int | float:
    """The value that so many percent of the values are below."""
    flat = values.ravel()
    at = (len(flat) - 1) * percent // 100
    return np.partition(flat, at)[at].item()


def _lowest(values: NDArray[np.float64], percent: int) -> NDArray[np.bool_]:
    """Which values are among the lowest so many percent; one at least."""
    return values <= _ranked(values, percent)


def _joined(layout: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """The layout without its parts below `least` points, the others joined by straight tunnels.

    The tunnels are a shortest spanning tree among neighbours: parts that points next to each other
    are nearest to.
    """
    from scipy import ndimage
    from scipy.sparse import coo_array, csgraph

    labels, sizes = _labelled(layout)
    layout = ((sizes >= least) | (sizes == sizes.max()))[labels]
    away, site = ndimage.distance_transform_edt(~layout, return_indices=True)
    nearest = labels[site[0], site[1]]

    # Where two parts meet: two neighbouring points, by flat index, the lower label first.
    flat = np.arange(layout.size).reshape(layout.shape)
    pairs = [(flat[1:, :], flat[:-1, :]), (flat[:, 1:], flat[:, :-1])]
    one, other = (np.concatenate([pair[i].ravel() for pair in pairs]) for i in (0, 1))
    label = nearest.ravel()
    meet = label[one] != label[other]
    one, other = one[meet], other[meet]
    swap = label[one] > label[other]
    one, other = np.where(swap, other, one), np.where(swap, one, other)

    # Of the meetings of the same two parts only the nearest counts, in order of length. Ranks are
    # the weights: with no two equal there is one shortest tree, however it is found.
    length = away.ravel()[one] + away.ravel()[other]
    order = np.argsort(length, kind="stable")
    code = label[one].astype(np.int64) * len(sizes) + label[other]
    order = order[np.sort(np.unique(code[order], return_index=True)[1])]
    one, other = one[order], other[order]
    graph = coo_array(
        (np.arange(1, len(one) + 1), (label[one], label[other])), shape=(len(sizes), len(sizes))
    )
    chosen = np.sort(csgraph.minimum_spanning_tree(graph.tocsr()).data).astype(np.int64) - 1
    ends: list[list[int]] = [
        axis.ravel()[point[chosen]].tolist() for point in (one, other) for axis in site
    ]
    for row, col, to_row, to_col in zip(*ends, strict=True):
        steps = max(abs(to_row - row), abs(to_col - col))
        along = np.arange(steps + 1, dtype=np.int64)
        rows = (row * (steps - along) + to_row * along) // steps
        cols = (col * (steps - along) + to_col * along) // steps
        layout[rows, cols] = True
        layout[rows[:-1], cols[1:]] = True  # so that a slanted line is 4-connected
    return layout


def _labelled(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The 4-connected parts: a label for each place, 0 outside, and the size of each label.

    The size of label 0 is given as 0, so that it is never the largest.
    """
    from scipy import ndimage

    labels = cast("NDArray[np.int32]", ndimage.label(mask)[0])
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return labels, sizes


def _distance(layout: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Distance of each lattice point from the layout, in lattice points."""
    from scipy import ndimage

    return ndimage.distance_transform_edt(~layout)


def _upsampled(
    field: NDArray[np.float64], step: int, cells: tuple[int, int]
) -> NDArray[np.float64]:
    """The field at each cell, between the lattice points that are `step` cells apart."""
    for axis in (0, 1):
        at = np.arange(cells[axis])
        shape = (-1, 1) if axis == 0 else (1, -1)
        part = (at % step / step).reshape(shape)
        low, high = field.take(at // step, axis), field.take(at // step + 1, axis)
        field = low * (1.0 - part) + high * part
    return field


def _without_specks(free: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """The free cells and the pieces of rock of fewer cells than `least`."""
    labels, sizes = _labelled(~free)
    return free | ((sizes < least) & (sizes > 0))[labels]


def _within_reach(free: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """What a disc of that radius in cells can sweep while it stays free, its largest part.

    Without this, cracks in the walls end in pockets into which no robot gets.
    """
    from scipy import ndimage

    reach = radius + 0.5  # from the middle of a cell to the middle of the nearest rock
    labels, sizes = _labelled(_distance(~free) >= reach)
    places = labels == np.argmax(sizes)
    while True:
        free = _distance(places) < reach
        labels, sizes = _labelled(_distance(~free) >= reach)
        if np.count_nonzero(sizes) == 1:
            return free
        # Sweeping has opened a place that is next to none of the others: widen the way to it.
        apart = (labels > 0) & (labels != np.argmax(sizes))
        places |= ndimage.binary_dilation(apart, np.ones((3, 3), np.bool_))
