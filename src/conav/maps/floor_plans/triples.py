"""Spiders and nested triples: trees of bent corridors that need any number of searchers.

The tree of `triples(k)` is the complete ternary one of depth k - 1, its edges are corridors with
two bends, its leaves the cells at the corridors' ends. It takes k searchers as a graph
[Parsons1976]. On floors searchers see along corridors, and the argument is this.

Call C(k) the floor of a copy up to its own junction, and Z(k) all points that see a point of C(k).
At a junction with copies a, b and c let D be C of a, C of c and the corridors that join them
through the junction, and let no point of Z of b see a point of D; likewise for the other two.

Claim: from C(k) fully contaminated, C(k) is never clear while no more than k - 1 searchers at a
time are in Z(k), wherever others are. For k = 1 nobody sees C(1). For k + 1 call a time an event of
b when k searchers are in Z of b: then nobody sees D, which is connected, so D is all clear or all
contaminated. Between its own events a contaminated copy is not cleared, because fewer than k
searchers are in its zone. At the first event, of b say, the other copies were never cleared, so all
of D is contaminated. At the next event of another copy, say c, copy a still is not clear, because
it had no event since; so C of a and C of b are contaminated all over. And so on: at each event the
two other copies are contaminated, and after the last one they stay so.

Hence `triples(k)` needs k searchers or more. The tests check the condition on sight.
"""

from conav.maps.floor_plans.lattice import Path, Point, cells_of_paths, floor_of_cells
from conav.maps.polygon_map import PolygonMap

LEG = 4  # [m] between bends, four corridor widths


def spider(first: int, second: int, third: int) -> PolygonMap:
    """Three corridors 1 m wide from one junction, to the east, north and west, with so many bends.

    The parts between bends are 4 m long. `spider(2, 2, 2)` is `triples(2)`.

    >>> len(spider(2, 2, 2).outer)
    20
    """
    east = _arm(first)
    north = [(y, x) for x, y in _arm(second, turn=1)]
    west = [(-x, y) for x, y in _arm(third)]
    cells = cells_of_paths([east, north, west])
    return floor_of_cells(cells, f"spider:{first},{second},{third}", corner=(-0.5, -0.5))


def _arm(bends: int, turn: int = -1) -> Path:
    """From the origin to the east, then turning to and fro: to the south for turn -1."""
    path = [(0, 0)]
    for part in range(bends + 1):
        x, y = path[-1]
        path.append((x, y + turn * LEG) if part % 2 else (x + LEG, y))
    return path


def triples(depth: int) -> PolygonMap:
    """The nested triples P_depth, corridors 1 m wide: three copies of P_(depth - 1) at a junction.

    P_1 is one corridor with two bends. At least `depth` searchers are needed.

    >>> [len(triples(depth).outer) for depth in (1, 2, 3)]
    [8, 20, 80]
    """
    paths = triple_paths(depth)
    cells = cells_of_paths(paths)
    return floor_of_cells(cells, f"triples:{depth}", corner=(-0.5, -0.5))


def triple_paths(depth: int) -> list[Path]:
    """The centre lines of the corridors of P_depth, each from a junction to a copy's junction."""
    if depth == 1:
        return [_connector(0)]
    return _copies(depth - 1)


def triple_extent(depth: int) -> int:
    """How far the corridors of P_depth without its exit reach from its junction along x and y."""
    return 0 if depth == 1 else 3 * triple_extent(depth - 1) + 2 * LEG


def _copies(depth: int) -> list[Path]:
    """Three copies of P_depth and the corridors that join them at the origin; room to the south."""
    extent = triple_extent(depth)
    connector = _connector(extent)
    x, y = connector[-1]
    copy: list[Path] = [] if depth == 1 else _copies(depth - 1)
    north = [connector, *([(a + x, b + y) for a, b in path] for path in copy)]
    east = [[(b, -a) for a, b in path] for path in north]
    west = [[(-a, b) for a, b in path] for path in east]
    return [*north, *east, *west]


def _connector(extent: int) -> Path:
    """From the origin north, to the east, and north to the junction of a copy of that extent."""
    leg = extent + LEG
    points: list[Point] = [(0, 0), (0, leg), (LEG, leg), (LEG, 2 * leg)]
    return points
