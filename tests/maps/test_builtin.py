"""Built-in maps: the same on every machine, connected at any size, refused where absurd."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from conav.errors import InputError
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.builtin.maze import _places, _stripes
from conav.maps.builtin.office_furniture import Site
from conav.maps.builtin.office_rooms import draw_row
from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

WALLED = ["office", "cave", "maze", "field"]
CORNERS = np.ones((3, 3), np.bool_)  # neighbours across corners count too
RESOLUTIONS = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0]

# A change here changes every result on these maps: make it on purpose.
DIGESTS = {
    "office": "0843cfe2dfd80b73",
    "cave": "914a6d251f372bc8",
    "maze": "d351c1869420d427",
    "field": "a3c20738ceb4acd0",
    "three-obstacles": "fec68ce3acdd696e",
}


def parts(mask: NDArray[np.bool_]) -> int:
    return int(ndimage.label(mask)[1])


def within(grid: OccupancyGrid, radius_m: float) -> NDArray[np.bool_]:
    """Cells where a disc of that radius around the middle stays clear of occupied cells."""
    away = ndimage.distance_transform_edt(np.pad(grid.cells == FREE, 1))[1:-1, 1:-1]
    return away - 0.5 >= radius_m / grid.resolution - 1e-9


def runs(line: NDArray[np.bool_]) -> list[int]:
    """Lengths of the runs of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
    return [int(end - start) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def has_wall(grid: OccupancyGrid) -> bool:
    cells = grid.cells
    border = np.concatenate([cells[0], cells[-1], cells[:, 0], cells[:, -1]])
    return bool(np.all(border == OCCUPIED))


def small(name: str, seed: int) -> OccupancyGrid:
    return builtin_map(name, width_m=24.0, height_m=16.0, resolution=0.2, seed=seed)


@pytest.mark.parametrize("name", BUILTIN)
def test_defaults_of_the_catalogue(name: str) -> None:
    entry, grid = BUILTIN[name], builtin_map(name)
    assert grid.name == name == entry.name
    assert grid.origin == (0.0, 0.0, 0.0)
    assert grid.resolution == entry.resolution
    assert grid.cells.shape == (
        round(entry.height_m / entry.resolution),
        round(entry.width_m / entry.resolution),
    )
    assert set(np.unique(grid.cells)) == {FREE, OCCUPIED}
    assert entry.description


@pytest.mark.parametrize("name", BUILTIN)
def test_digest(name: str) -> None:
    digest = hashlib.sha256(small(name, 3).cells.tobytes()).hexdigest()[:16]
    assert digest == DIGESTS[name]


@pytest.mark.parametrize("name", BUILTIN)
def test_seed_alone_decides(name: str) -> None:
    first = small(name, 11).cells
    assert np.array_equal(first, small(name, 11).cells)
    assert not np.array_equal(first, small(name, 12).cells)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", WALLED)
def test_default_is_reached_everywhere(name: str, seed: int) -> None:
    grid = builtin_map(name, seed=seed)
    assert has_wall(grid)
    assert parts(grid.cells == FREE) == 1
    assert parts(within(grid, 0.2)) == 1


@settings(max_examples=120, deadline=None)
@given(
    name=st.sampled_from(list(BUILTIN)),
    resolution=st.sampled_from(RESOLUTIONS),
    across=st.floats(12, 160),
    ratio=st.floats(0.2, 5.0),
    seed=st.integers(0, 2**63),
)
def test_connected_at_any_size(
    name: str, resolution: float, across: float, ratio: float, seed: int
) -> None:
    width_m = max(3.0, across * resolution)
    height_m = max(3.0, 12 * resolution, min(160 * resolution, width_m * ratio))
    grid = builtin_map(name, width_m=width_m, height_m=height_m, resolution=resolution, seed=seed)
    assert grid.cells.shape == (round(height_m / resolution), round(width_m / resolution))
    assert parts(grid.cells == FREE) == 1
    if name in WALLED:
        assert has_wall(grid)
        assert parts(within(grid, 0.2)) == 1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("width_m", "height_m"), [(60.0, 12.0), (6.0, 30.0), (15.0, 3.0)])
@pytest.mark.parametrize("name", BUILTIN)
def test_long_and_narrow(name: str, width_m: float, height_m: float, seed: int) -> None:
    grid = builtin_map(name, width_m=width_m, height_m=height_m, resolution=0.1, seed=seed)
    assert parts(grid.cells == FREE) == 1
    if name in WALLED:
        assert parts(within(grid, 0.2)) == 1


@pytest.mark.parametrize(
    ("side_m", "resolution"), [(3.0, 0.25), (3.0, 0.05), (12.0, 1.0), (60.0, 5.0)]
)
@pytest.mark.parametrize("name", BUILTIN)
def test_smallest_maps(name: str, side_m: float, resolution: float) -> None:
    for seed in range(5):
        grid = builtin_map(name, width_m=side_m, height_m=side_m, resolution=resolution, seed=seed)
        assert parts(grid.cells == FREE) == 1
        assert np.count_nonzero(grid.cells == FREE) >= 10


@pytest.mark.parametrize("resolution", [0.02, 0.05, 0.1, 0.2, 0.25, 0.5, 1.0])
def test_office_doors(resolution: float) -> None:
    for seed in range(5):
        site = Site(resolution, np.random.Generator(np.random.PCG64(seed)))
        row = np.full((site.cells(4.5), site.cells(30.0)), OCCUPIED, np.uint8)
        draw_row(row, site, (0, row.shape[1]))
        doors = runs(row[0] == FREE)
        assert len(doors) >= 4
        for door in doors:
            if resolution <= 0.25:
                assert 0.8 - 1e-9 <= door * resolution <= 1.0 + 1e-9
                assert door >= 2
            else:
                assert door >= 1


@pytest.mark.parametrize("seed", range(6))
def test_office_has_wide_corridors_in_a_loop(seed: int) -> None:
    grid = builtin_map("office", seed=seed)
    # Too wide for a door, not for a corridor: what is left of the corridors is one ring.
    labels, count = ndimage.label(within(grid, 0.7))
    rings = [labels == label for label in range(1, count + 1)]
    enclosed = [np.count_nonzero(ndimage.binary_fill_holes(ring) & ~ring) for ring in rings]
    assert max(enclosed) * grid.resolution**2 > 20.0


@pytest.mark.parametrize("seed", range(4))
def test_maze_is_a_tree_and_some_loops(seed: int) -> None:
    grid = builtin_map("maze", seed=seed)
    # Walls that hang together with the border close no loop; every other piece of wall does.
    loops = int(ndimage.label(grid.cells == OCCUPIED, CORNERS)[1]) - 1
    assert 1 <= loops <= 18 * 18 // 30
    clear = [run for line in grid.cells for run in runs(line == FREE)]
    assert min(clear) * grid.resolution >= 1.0 - 1e-9


@given(cells=st.integers(12, 3000), corridor=st.integers(1, 40), wall=st.integers(1, 2))
def test_maze_fills_any_size(cells: int, corridor: int, wall: int) -> None:
    places = _places(cells, wall, corridor)
    stripes = _stripes(cells, wall, places)
    assert stripes.sum() == cells
    assert np.all(stripes[::2] == wall)
    assert np.ptp(stripes[1::2]) <= 1
    assert places == 1 or stripes[1::2].min() >= corridor


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("resolution", [0.1, 0.5])
def test_field_is_open_with_convex_obstacles(seed: int, resolution: float) -> None:
    grid = builtin_map("field", resolution=resolution, seed=seed)
    assert grid.area_m2(FREE) > 0.95 * 100 * 100
    labels, count = ndimage.label(grid.cells == OCCUPIED, CORNERS)
    assert 10 <= count - 1 <= 60
    wall = labels[0, 0]
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        if label != wall:
            piece = labels[box] == label
            assert all(len(runs(line)) == 1 for line in (*piece, *piece.T))


@pytest.mark.parametrize("side", [12, 20, 40, 73])
def test_three_obstacles(side: int) -> None:
    for seed in range(30):
        grid = builtin_map("three-obstacles", width_m=side, height_m=side, seed=seed)
        labels, count = ndimage.label(grid.cells == OCCUPIED, CORNERS)
        assert count == 3
        for label, box in enumerate(ndimage.find_objects(labels), start=1):
            assert np.all(labels[box] == label)
        assert np.all(grid.cells[:4, :4] == FREE)
        border = (grid.cells[0], grid.cells[-1], grid.cells[:, 0], grid.cells[:, -1])
        assert all(np.all(line == FREE) for line in border)


def test_unknown_name_is_answered_with_near_ones() -> None:
    with pytest.raises(InputError, match=r"did you mean 'office'.*three-obstacles"):
        builtin_map("ofice")
    with pytest.raises(InputError, match="known: office, cave, maze, field, three-obstacles"):
        builtin_map("xyzzy")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"width_m": float("nan")}, "width must be a positive"),
        ({"height_m": float("inf")}, "height must be a positive"),
        ({"width_m": -5.0}, "width must be a positive"),
        ({"height_m": 0.0}, "height must be a positive"),
        ({"resolution": 0.0}, "resolution must be a positive"),
        ({"resolution": -0.1}, "resolution must be a positive"),
        ({"resolution": float("nan")}, "resolution must be a positive"),
        ({"resolution": float("inf")}, "resolution must be a positive"),
        ({"width_m": 2.9}, "too small; ask for at least 3 m"),
        ({"width_m": 5.0, "resolution": 1.0}, "too few cells; ask for a resolution of 0.417 m"),
        ({"resolution": 0.0001}, "over 100,000,000 cells; ask for a coarser"),
        ({"resolution": 1e-320}, "over 100,000,000 cells"),
        ({"width_m": 1e300, "height_m": 1e300}, "over 100,000,000 cells"),
        ({"seed": -1}, "seed must not be negative"),
    ],
)
def test_absurd_sizes_are_refused(asked: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        builtin_map("office", **asked)  # pyright: ignore[reportArgumentType]
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("seed", [None, 0.5])
def test_seed_must_be_a_whole_number(seed: object) -> None:
    with pytest.raises(TypeError):
        builtin_map("maze", seed=seed)  # pyright: ignore[reportArgumentType]


def test_whole_numbers_are_sizes_too() -> None:
    assert np.array_equal(
        builtin_map("cave", width_m=10, height_m=8).cells,
        builtin_map("cave", width_m=10.0, height_m=8.0).cells,
    )


def test_catalogue_imports_nothing_heavy() -> None:
    code = (
        "import sys, conav.maps.builtin.catalogue\n"
        "heavy = {'scipy', 'numba', 'PIL', 'shapely', 'pydantic'} & set(sys.modules)\n"
        "drawn = [name for name in sys.modules if name.startswith('conav.maps.builtin.')]\n"
        "assert not heavy, heavy\n"
        "assert drawn == ['conav.maps.builtin.catalogue'], drawn\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
