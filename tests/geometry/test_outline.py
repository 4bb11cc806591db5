"""Parts and rings of sets of cells, against their definitions."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from conav.geometry.outline import label_parts, trace_rings
from conav.maps.rings import find_fault

CUT = 1 / 16

masks = st.tuples(st.integers(1, 7), st.integers(1, 7)).flatmap(
    lambda shape: arrays(np.uint8, shape, elements=st.integers(0, 1))
)


def slow_parts(mask: NDArray[np.uint8], open_corners: bool) -> list[set[tuple[int, int]]]:
    left = {(int(r), int(c)) for r, c in np.argwhere(mask)}
    parts: list[set[tuple[int, int]]] = []
    for start in sorted(left):
        if start not in left:
            continue
        part, edge = {start}, [start]
        while edge:
            r, c = edge.pop()
            for r2, c2 in left - part:
                apart = abs(r2 - r) + abs(c2 - c)
                corner = open_corners and abs(r2 - r) == abs(c2 - c) == 1
                if apart == 1 or corner:
                    part.add((r2, c2))
                    edge.append((r2, c2))
        left -= part
        parts.append(part)
    return parts


@settings(deadline=None)  # the first call compiles
@given(masks, st.booleans())
def test_parts_are_connected_components(mask: NDArray[np.uint8], open_corners: bool):
    labels = label_parts(mask, open_corners)
    parts = slow_parts(mask, open_corners)
    assert ((labels < 0) == (mask == 0)).all()
    for number, part in enumerate(parts):
        assert {(int(r), int(c)) for r, c in np.argwhere(labels == number)} == part
    assert int(labels.max(initial=-1)) == len(parts) - 1


def corner_touches(mask: NDArray[np.uint8]) -> int:
    a, b, c, d = mask[:-1, :-1], mask[:-1, 1:], mask[1:, :-1], mask[1:, 1:]
    return int(np.count_nonzero((a == d) & (b == c) & (a != b)))


@settings(deadline=None)  # the first call compiles
@given(masks, st.booleans())
def test_rings_bound_the_cells_but_for_the_cuts(mask: NDArray[np.uint8], open_corners: bool):
    for part in slow_parts(mask, open_corners):
        only = np.zeros_like(mask)
        for cell in part:
            only[cell] = 1
        rings = trace_rings(only, open_corners, CUT)
        assert find_fault(rings) is None  # simple, apart, outer first, each the right way round
        cells = shapely.union_all([shapely.box(c, r, c + 1, r + 1) for r, c in part])
        floor = shapely.Polygon(rings[0], rings[1:])
        cuts = 2 * corner_touches(only) * CUT * CUT / 2
        assert floor.symmetric_difference(cells).area == pytest.approx(cuts, abs=1e-12)
        assert floor.area == pytest.approx(cells.area + (cuts if open_corners else -cuts))


def test_a_touching_corner_opened_and_closed():
    mask = np.array([[1, 0], [0, 1]], dtype=np.uint8)
    (ring,) = trace_rings(mask, True, 0.125)
    assert ring.tolist() == [
        *([1, 0], [1, 0.875], [1.125, 1], [2, 1], [2, 2]),
        *([1, 2], [1, 1.125], [0.875, 1], [0, 1], [0, 0]),
    ]
    first, second = trace_rings(mask, False, 0.125)
    assert first.tolist() == [[1, 0], [1, 0.875], [0.875, 1], [0, 1], [0, 0]]
    assert second.tolist() == [[2, 1], [2, 2], [1, 2], [1, 1.125], [1.125, 1]]
