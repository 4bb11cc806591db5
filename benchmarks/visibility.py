"""What a visibility polygon costs: triangulation once, then microseconds a viewpoint.

    python benchmarks/visibility.py            # about a minute, kernels compiled before

Floors of four families at several numbers of vertices n. `queries` are points drawn uniformly on
the floor. `us` is one query in a compiled loop, the point located, predicates exact, the best of
several repetitions; `call` is one call from Python with its arrays. `corners` is the mean size of a
polygon. `build` is the triangulation with its grid.

A second table has calls from Python: `sees` for two random points, `pairs` who sees whom among all
vertices, `hidden` the hidden regions of a viewpoint whose polygon is known, and the cells of two
and of three such viewpoints; `overlay` is the floor less two polygons by shapely on a grid of
1e-8.
"""

import argparse
import sys
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.hidden_regions import hidden_regions
from conav.geometry.sight_lines import sees, vertex_visibility
from conav.geometry.triangulation import Triangulation, triangulate
from conav.geometry.view_cells import view_cells
from conav.geometry.visibility import (
    VisibilityPolygon,
    expand,
    polygon_size,
    visibility_polygon,
)

Rings = list[list[tuple[float, float]]]


def comb(n: int) -> Rings:
    """A corridor with deep teeth."""
    teeth = max((n - 4) // 4, 1)
    top = [(0.0, 0.0), (2.0 * teeth + 1.0, 0.0), (2.0 * teeth + 1.0, 2.0)]
    for k in range(teeth - 1, -1, -1):
        x = 2.0 * k + 1.0
        top += [(x + 0.5, 2.0), (x + 0.5, 12.0), (x, 12.0), (x, 2.0)]
    return [[*top, (0.0, 2.0)]]


def star(n: int, rng: np.random.Generator) -> Rings:
    """Random radii at even angles around the centre."""
    angle = 2.0 * np.pi * np.arange(n) / n
    radius = rng.uniform(5.0, 50.0, n)
    return [list(zip(radius * np.cos(angle), radius * np.sin(angle), strict=True))]


def pillars(n: int, rng: np.random.Generator) -> Rings:
    """A square hall with a grid of quadrilateral pillars, each a little different."""
    side = max(int(((n - 4) / 4) ** 0.5), 1)
    rings: Rings = [[(0.0, 0.0), (3.0 * side, 0.0), (3.0 * side, 3.0 * side), (0.0, 3.0 * side)]]
    for i in range(side):
        for j in range(side):
            x, y = 3.0 * i + 1.5, 3.0 * j + 1.5
            corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            rings.append([(x + a * rng.uniform(0.3, 0.9), y + b * rng.uniform(0.3, 0.9))
                          for a, b in corners])  # fmt: skip
    return rings


def office(n: int, rng: np.random.Generator) -> Rings:
    """Corridors between blocks of rooms with a door each, and a pillar in every second room.

    Right angles and round numbers: many points lie on one line. Walls are 0.2 m thick.
    """
    blocks = max(round((n / 34) ** 0.5 / 2), 1)
    per_block = max(round(n / (2.0 * blocks * 2 * 10)), 1)
    width = 4.0 * per_block * 1.0
    # Rooms hang on horizontal corridors which a vertical one joins on the left.
    height = 12.0
    ring: list[tuple[float, float]] = []
    x0, x1 = 2.0, 2.0 + width
    ring += [(0.0, 0.0), (2.0, 0.0)]
    holes: Rings = []
    total = 2 * blocks
    for level in range(total):
        y = height * level + 5.0  # the corridor from y to y + 2
        ring.append((2.0, y))
        for room in range(per_block):  # rooms below, left to right
            a = x0 + 4.0 * room + 0.2
            b = a + 3.8
            d = a + float(rng.integers(2, 26)) / 10.0
            ring += [(d, y), (d, y - 0.2), (a, y - 0.2), (a, y - 4.8), (b, y - 4.8), (b, y - 0.2),
                     (d + 0.9, y - 0.2), (d + 0.9, y)]  # fmt: skip
            if (room + level) % 2:
                holes.append([(a + 1.5, y - 3.0), (a + 1.5, y - 2.5), (a + 2.0, y - 2.5),
                              (a + 2.0, y - 3.0)])  # fmt: skip
        ring += [(x1 + 0.2, y), (x1 + 0.2, y + 2.0)]
        for room in range(per_block - 1, -1, -1):  # rooms above, right to left
            a = x0 + 4.0 * room + 0.2
            b = a + 3.8
            d = a + float(rng.integers(2, 26)) / 10.0
            ring += [(d + 0.9, y + 2.0), (d + 0.9, y + 2.2), (b, y + 2.2), (b, y + 6.8),
                     (a, y + 6.8), (a, y + 2.2), (d, y + 2.2), (d, y + 2.0)]  # fmt: skip
        ring.append((2.0, y + 2.0))
    top = height * total
    ring += [(2.0, top), (0.0, top)]
    return [ring, *holes]


def floor_of(rings: Rings) -> Triangulation:
    starts = np.cumsum([0] + [len(ring) for ring in rings])
    return triangulate([point for ring in rings for point in ring], starts)


def points_on(floor: Triangulation, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    a, b, c = (floor.vertices[floor.triangles[:, k]] for k in range(3))
    areas = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    chosen = rng.choice(len(areas), count, p=areas / areas.sum())
    u, v = rng.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b[chosen] - a[chosen]) + v * (c[chosen] - a[chosen])


@kernel
def look_around(
    vertices: NDArray[np.float64],
    corners: NDArray[np.int64],
    twins: NDArray[np.int64],
    wall_ends: NDArray[np.int64],
    frame: NDArray[np.float64],
    starts: NDArray[np.int64],
    entries: NDArray[np.int64],
    points: NDArray[np.float64],
    out: NDArray[np.float64],
    facts: NDArray[np.int64],
) -> int:
    total = 0
    for i in range(points.shape[0]):
        total += expand(
            vertices, corners, twins, wall_ends, frame, starts, entries, points[i, 0], points[i, 1],
            out, facts,
        )[1]  # fmt: skip
    return total


def measure(name: str, rings: Rings, queries: int, repeat: int, rng: np.random.Generator) -> None:
    floor = floor_of(rings)
    points = points_on(floor, queries, rng)
    size = polygon_size(len(floor.vertices))
    arguments = (
        floor.vertices, floor.triangles.reshape(-1), floor.twins.reshape(-1), floor.wall_ends,
        floor.grid.frame, floor.grid.starts, floor.grid.triangles, points,
        np.empty((size, 3)), np.empty((size, 4), np.int64),
    )  # fmt: skip
    total = look_around(*arguments)
    # In chunks short enough not to be interrupted, each at its best: others use the machine too.
    chunks = [points[i : i + 50] for i in range(0, queries, 50)]
    loop_s = sum(
        best(lambda c=chunk: look_around(*arguments[:7], c, *arguments[8:]), repeat)
        for chunk in chunks
    )
    calls = chunks[:6]
    call_s = sum(
        best(lambda c=chunk: [visibility_polygon(floor, x, y) for x, y in c], repeat)
        for chunk in map(np.ndarray.tolist, calls)
    )
    build_s = best(lambda: floor_of(rings), repeat)
    print(
        f"| {name} | {len(floor.vertices):,} | {len(rings) - 1} | {1e6 * loop_s / queries:.2f} "
        f"| {1e6 * call_s / (50 * len(calls)):.1f} | {total / queries:.1f} | {1e3 * build_s:.1f} |"
    )


def best(task: Callable[[], object], repeat: int) -> float:
    """The least time of a task [s]."""
    times = []
    for _ in range(repeat):
        begin = time.perf_counter()
        task()
        times.append(time.perf_counter() - begin)
    return min(times)


def measure_more(name: str, rings: Rings, repeat: int, rng: np.random.Generator) -> None:
    floor = floor_of(rings)
    points = points_on(floor, 60, rng).tolist()
    views = [visibility_polygon(floor, x, y) for x, y in points]
    sees_s = best(lambda: [sees(floor, a, b) for a, b in pairwise(points)], repeat) / 59
    pairs_s = best(lambda: vertex_visibility(floor), min(repeat, 3))
    hidden_s = best(lambda: [hidden_regions(floor, view) for view in views], repeat) / 60
    row = f"| {name} | {len(floor.vertices):,} | {1e6 * sees_s:.1f} | {1e3 * pairs_s:.1f} "
    row += f"| {1e6 * hidden_s:.0f} "
    for team in (2, 3):
        groups = [views[i : i + team] for i in range(0, 60, team)]
        cells_s = sum(best(lambda g=g: view_cells(floor, g), repeat) for g in groups) / len(groups)
        row += f"| {1e6 * cells_s:.0f} "
    print(row + f"| {overlay(rings, views, repeat)} |")


def overlay(rings: Rings, views: list[VisibilityPolygon], repeat: int) -> str:
    whole = shapely.Polygon(rings[0], rings[1:])
    polygons = [shapely.make_valid(shapely.Polygon(view.corners)) for view in views]

    def subtract(a: shapely.Geometry, b: shapely.Geometry) -> object:
        return shapely.difference(whole, shapely.union(a, b, grid_size=1e-8), grid_size=1e-8)

    pairs = list(zip(polygons[::2], polygons[1::2], strict=True))
    return f"{1e6 * sum(best(lambda p=p: subtract(*p), repeat) for p in pairs) / len(pairs):.0f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--queries", type=int, default=2000)
    parser.add_argument("--repeat", type=int, default=7)
    options = parser.parse_args()
    print("| floor | n | holes | us | call us | corners | build ms |")
    print("|" + "---|" * 7)
    rng = np.random.default_rng(1)
    for n in (50, 500, 1000, 2000):
        for name, rings in (
            ("office", office(n, rng)),
            ("comb", comb(n)),
            ("radial star", star(n, rng)),
            ("pillars", pillars(n, rng)),
        ):
            measure(name, rings, options.queries, options.repeat, rng)
            sys.stdout.flush()
    print("\n| floor | n | sees us | pairs ms | hidden us | 2 views us | 3 views us | overlay us |")
    print("|" + "---|" * 8)
    for n in (100, 500, 2000):
        for name, rings in (
            ("office", office(n, rng)),
            ("comb", comb(n)),
            ("radial star", star(n, rng)),
            ("pillars", pillars(n, rng)),
        ):
            measure_more(name, rings, options.repeat, rng)
            sys.stdout.flush()


if __name__ == "__main__":
    main()
