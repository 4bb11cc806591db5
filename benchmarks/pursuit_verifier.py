"""What the verifier of pursuits takes per motion: docs/pursuit-verifier.md, Speed.

    python benchmarks/pursuit_verifier.py
    python benchmarks/pursuit_verifier.py --random 200     # verdicts on random drives

Floors are corridors with rooms at both sides, of about 30 to 400 corners, some with blocks in the
corridor as holes. Pursuers drive at random between places in sight of each other. Per floor and
team: the least time over the repetitions of one motion, views of its ends included, then with views
remembered, as they are when a motion follows another; and of the whole verdict on a schedule.

With `--random` floors are made of unit squares, and one or two pursuers drive two to five times
between corners and places on a lattice of half units.
"""

import argparse
from collections import Counter
from time import perf_counter

import numpy as np
import shapely

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule
from conav.pursuit.verify import verify_schedule
from conav.pursuit.verify_lattice import Point, make_lattice
from conav.pursuit.verify_step import Mover, Stepper


def rooms(pairs: int, blocks: int) -> PolygonMap:
    """A corridor 3 m wide with so many pairs of rooms, 8 corners each, and blocks along it."""
    upper: list[tuple[float, float]] = []
    lower: list[tuple[float, float]] = []
    for k in range(pairs):
        x = 10.0 * k
        shape = [(4, 3), (4, 5), (1, 5), (1, 11), (9, 11), (9, 5), (6, 5), (6, 3)]
        upper += [(x + dx, y) for dx, y in shape]
        lower += [(x + 1 + dx, 3.0 - y) for dx, y in shape]
    end = 10.0 * pairs + 1.0
    outer = [(0.0, 0.0), *lower, (end, 0.0), (end, 3.0), *upper[::-1], (0.0, 3.0)]
    at = [end * (k + 0.5) / blocks for k in range(blocks)]
    holes = [[(x, 1.2), (x, 1.8), (x + 0.6, 1.8), (x + 0.6, 1.2)] for x in at]
    return PolygonMap(outer, holes)


def drives(
    stepper: Stepper, rng: np.random.Generator, pursuers: int, legs: int
) -> list[list[Point]]:
    """Places of each pursuer, each in sight of the one before."""
    lattice = stepper.lattice
    places = [(int(x), int(y)) for x, y in lattice.points]
    low, high = lattice.points.min(axis=0), lattice.points.max(axis=0)
    while len(places) < 2 * len(lattice.points):
        x, y = rng.integers(low, high + 1) // 256 * 256
        if lattice.snap(lattice.metres(np.array((x, y)))) == (x, y):
            places.append((int(x), int(y)))
    ways: list[list[Point]] = []
    for _ in range(pursuers):
        way = [places[rng.integers(len(places))]]
        while len(way) <= legs:
            to = places[rng.integers(len(places))]
            if to != way[-1] and lattice.joined(way[-1], to):
                way.append(to)
        ways.append(way)
    return ways


def block_floor(rng: np.random.Generator, size: int = 5) -> PolygonMap:
    """The largest part of a random pattern of unit squares."""
    while True:
        cells = np.argwhere(rng.random((size, size)) < 0.62).tolist()
        parts = shapely.get_parts(
            shapely.union_all([shapely.box(x, y, x + 1, y + 1) for y, x in cells])
        )
        floor = shapely.geometry.polygon.orient(max(parts, key=shapely.area).simplify(0.0), 1.0)
        rings = [np.array(ring.coords)[:-1] for ring in (floor.exterior, *floor.interiors)]
        try:
            plan = PolygonMap(rings[0], rings[1:])
        except InputError:  # rings that touch
            continue
        if len(plan.vertices) >= 8:
            return plan


def random_verdicts(count: int) -> None:
    """Print how often each verdict comes out."""
    verdicts: Counter[str] = Counter()
    for seed in range(count):
        rng = np.random.default_rng(seed)
        plan = block_floor(rng)
        places = [tuple(corner) for corner in plan.vertices.tolist()]
        places += [(x / 2, y / 2) for x in range(11) for y in range(11)]
        places = [place for place in places if plan.contains(place)]
        ways: list[list[tuple[float, ...]]] = []
        for _ in range(1 + seed % 2):
            way = [places[rng.integers(len(places))]]
            while len(way) < 3 + seed % 4:
                to = places[rng.integers(len(places))]
                if to != way[-1] and plan.polygon.covers(shapely.LineString((way[-1], to))):
                    way.append(to)
            ways.append(way)
        positions = np.array(ways).transpose(1, 0, 2)
        active = np.ones((len(positions) - 1, len(ways)), dtype=np.bool_)
        schedule = Schedule(np.arange(float(len(positions))), positions, active)
        verdicts[str(verify_schedule(plan, schedule, (None,) * len(ways)).verdict)] += 1
    print(", ".join(f"{number} {verdict}" for verdict, number in sorted(verdicts.items())))


def main() -> None:
    parser = argparse.ArgumentParser(description="Times of the verifier of pursuits")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--random", type=int, default=0)
    arguments = parser.parse_args()
    if arguments.random:
        random_verdicts(arguments.random)
        return
    repeat = arguments.repeat
    print("corners holes pursuers  new views ms  known views ms  verdict ms  motions")
    for pairs, blocks, pursuers in (
        (2, 0, 1),
        (3, 0, 1),
        (3, 2, 2),
        (6, 0, 1),
        (6, 4, 3),
        (25, 0, 1),
        (25, 0, 3),
    ):
        plan = rooms(pairs, blocks)
        legs = 20
        rng = np.random.default_rng(pairs)
        stepper = Stepper(make_lattice(plan))
        ways = drives(stepper, rng, pursuers, legs)
        motions = [[Mover(way[m], way[m + 1], None) for way in ways] for m in range(legs)]
        stepper.step(motions[0])
        fresh, known = [], []
        for _ in range(repeat):
            stepper = Stepper(stepper.lattice)
            for times in (fresh, known):
                begin = perf_counter()
                for movers in motions:
                    stepper.step(movers)
                times.append((perf_counter() - begin) / legs * 1e3)
        places = stepper.lattice.metres(np.array(ways)).transpose(1, 0, 2)
        active = np.ones((legs, pursuers), dtype=np.bool_)
        schedule = Schedule(np.arange(legs + 1.0), places, active)
        verdict, found = [], None
        for _ in range(repeat):
            begin = perf_counter()
            found = verify_schedule(plan, schedule, (None,) * pursuers)
            verdict.append((perf_counter() - begin) * 1e3)
        assert found is not None
        print(
            f"{len(plan.vertices):7d} {len(plan.holes):5d} {pursuers:8d} {min(fresh):13.3f} "
            f"{min(known):15.3f} {min(verdict):11.1f}  {len(found.pieces)} ({found.verdict})"
        )


if __name__ == "__main__":
    main()
