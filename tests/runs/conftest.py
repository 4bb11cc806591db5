"""Runs on small maps, made once for all tests of run files."""

from pathlib import Path

import pytest

import conav
from conav.maps.occupancy_grid import OccupancyGrid


def small_map(origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> OccupancyGrid:
    """A maze of 6 x 6 m with a corner nobody has surveyed."""
    grid = conav.builtin_map("maze", width_m=6, height_m=6, resolution=0.2)
    cells = grid.cells.copy()
    cells[-3:, -3:] = 2
    return OccupancyGrid(cells, grid.resolution, origin=origin, name="small")


@pytest.fixture(scope="session")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a short run of two robots with a limited radio."""
    path = tmp_path_factory.mktemp("runs") / "small.mcap"
    conav.explore(small_map(), robots=2, seed=5, radio=1.5, out=path)
    return path


@pytest.fixture(scope="session")
def turned_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a run on a map that is shifted and turned in the world."""
    path = tmp_path_factory.mktemp("runs") / "turned.mcap"
    conav.explore(
        small_map((2.5, -1.25, 0.3)),
        robots=3,
        seed=3,
        motion="forward-turn",
        speed_mps=0.4,
        out=path,
    )
    return path
