"""Walls met against a slow count of all cells, anew and as more and more gets known; by hand."""

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration.walls_met import walls_met
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN


def believed(cells: NDArray[np.uint8]) -> Any:
    """A belief of which nothing but the cells is real."""
    return SimpleNamespace(cells=cells, derived={})


def slowly(cells: NDArray[np.uint8], range_fine: float) -> float:
    rows, cols = cells.shape
    walls = 0
    for r, c in product(range(rows), range(cols)):
        near = ((r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1))
        inside = [(y, x) for y, x in near if 0 <= y < rows and 0 <= x < cols]
        walls += cells[r, c] == OCCUPIED and any(cells[place] == FREE for place in inside)
    free = int((cells == FREE).sum())
    return walls / (free if free else 1) * 2 * range_fine


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 30.0))
def test_walls_met_against_its_twin_while_the_map_gets_known(seed: int, range_fine: float) -> None:
    rng = np.random.default_rng(seed)
    shape = rng.integers(1, rng.choice([14, 60]), 2)
    truth = rng.choice(np.array([FREE, OCCUPIED], np.uint8), shape, p=[0.7, 0.3])
    belief = believed(np.full(shape, UNKNOWN, np.uint8))
    assert walls_met(belief, range_fine) == 0.0
    for _ in range(4):
        place, reach = rng.integers(0, shape), rng.integers(1, 25)
        for r, c in np.argwhere(belief.cells == UNKNOWN):
            if abs(r - place[0]) + abs(c - place[1]) < reach:
                belief.cells[r, c] = truth[r, c]
        assert walls_met(belief, range_fine) == pytest.approx(slowly(belief.cells, range_fine))


def test_by_hand() -> None:
    def met(cells: NDArray[np.uint8]) -> float:
        return walls_met(believed(cells), 5.0)

    assert met(np.full((6, 6), UNKNOWN, dtype=np.uint8)) == 0.0
    assert met(np.full((6, 6), FREE, dtype=np.uint8)) == 0.0
    # A corridor as wide as is seen, 2 r: two cells of wall for each cell of the way.
    corridor = np.full((12, 40), OCCUPIED, dtype=np.uint8)
    corridor[1:11] = FREE
    assert met(corridor) == pytest.approx(2.0)
    corridor[1:11, 20:] = UNKNOWN  # known halfway only
    assert met(corridor) == pytest.approx(2.0)
    corridor[4:] = OCCUPIED  # and narrower
    assert met(corridor) == pytest.approx(2.0 * 10 / 3)
