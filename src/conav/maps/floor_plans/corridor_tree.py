"""Random trees of corridors: simply connected floors with many dead ends."""

import numpy as np

from conav.maps.floor_plans.lattice import Point, cells_of_paths, floor_of_cells
from conav.maps.polygon_map import PolygonMap


def corridor_tree(segments: int, seed: int) -> PolygonMap:
    """A tree of that many corridors 1 m wide, each 2 m from node to node of a square lattice.

    Each new corridor leaves a node drawn at random from those with a free neighbour, to a free
    neighbour drawn at random.

    >>> corridor_tree(20, 3).area
    41.0
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    nodes: list[Point] = [(0, 0)]
    taken = {(0, 0)}
    paths: list[list[Point]] = []
    while len(paths) < segments:
        drawn = int(rng.integers(len(nodes)))
        x, y = nodes[drawn]
        around = [at for at in ((x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)) if at not in taken]
        if not around:
            del nodes[drawn]
            continue
        new = around[int(rng.integers(len(around)))]
        paths.append([(2 * x, 2 * y), (2 * new[0], 2 * new[1])])
        nodes.append(new)
        taken.add(new)
    name = f"corridor-tree:segments={segments},seed={seed}"
    return floor_of_cells(cells_of_paths(paths), name)
