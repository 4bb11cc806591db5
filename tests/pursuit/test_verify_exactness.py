"""The verifier's kernels against slow, obvious twins, and laws that motions obey."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.verify import verify_schedule
from conav.pursuit.verify_decide import Verdict
from conav.pursuit.verify_lattice import PARTS, Lattice, Point, make_lattice
from conav.pursuit.verify_range import inscribed_polygon
from conav.pursuit.verify_sight import REACH, determinant_sign, never_sees, on_floor, sees, windows
from conav.pursuit.verify_slabs import View, cells
from conav.pursuit.verify_step import Mover, Step, Stepper, halved

from .evader_on_grid import grid_evader_escapes
from .floors import RING, ROOMS, block_floor, random_ways, schedule

coordinates = st.integers(-REACH, REACH)
points = st.tuples(coordinates, coordinates)


@settings(max_examples=300, deadline=None)
@given(st.tuples(points, points), st.tuples(points, points), st.tuples(points, points), st.data())
def test_the_sign_of_a_determinant(
    one: tuple[Point, Point],
    two: tuple[Point, Point],
    three: tuple[Point, Point],
    data: st.DataObject,
) -> None:
    if data.draw(st.booleans()):
        three = (one[0], two[0])  # often nearly, sometimes quite concurrent
    rows = [_line(*pair) for pair in (one, two, three)]
    (a, b, c), (d, e, f), (g, h, i) = rows
    exact = g * (b * f - c * e) + h * (c * d - a * f) + i * (a * e - b * d)
    sign = determinant_sign(np.array(rows, dtype=np.int64), 0, 1, 2)
    assert sign == (exact > 0) - (exact < 0)


@settings(max_examples=100, deadline=None)
@given(points, points, points, st.integers(-3, 3))
def test_the_sign_of_lines_through_one_point(p: Point, q: Point, r: Point, by: int) -> None:
    # Three lines through p, or the third a lattice unit beside it.
    rows = [_line(p, q), _line(p, r), (1, by, -p[0] - by * p[1] - by)]
    (a, b, c), (d, e, f), (g, h, i) = rows
    exact = g * (b * f - c * e) + h * (c * d - a * f) + i * (a * e - b * d)
    sign = determinant_sign(np.array(rows, dtype=np.int64), 0, 1, 2)
    assert sign == (exact > 0) - (exact < 0)


def _line(p: Point, q: Point) -> tuple[int, int, int]:
    return p[1] - q[1], q[0] - p[0], p[0] * q[1] - q[0] * p[1]


@pytest.mark.parametrize("seed", range(6))
def test_sight_is_that_of_the_definition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lattice = make_lattice(block_floor(rng))
    floor = shapely.Polygon(lattice.rings[0], lattice.rings[1:])
    places = _places(lattice, rng, 30)
    for a in places:
        for b in places:
            # Small integers: shapely's predicate is exact.
            seen = sees(lattice.points, lattice.links, *a, *b)
            assert seen == floor.covers(shapely.LineString((a, b)) if a != b else shapely.Point(a))
            assert seen == sees(lattice.points, lattice.links, *b, *a)


@pytest.mark.parametrize("seed", range(4))
def test_who_never_sees_a_drive_sees_no_point_of_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lattice = make_lattice(block_floor(rng))
    places = _places(lattice, rng, 30)
    hidden = 0
    for x in places[-10:]:
        view, _ = windows(lattice.points, lattice.links, *x)
        for a in places:
            for b in places:
                if not lattice.joined(a, b):
                    continue
                never = never_sees(lattice.points, lattice.links, view, *x, *a, *b)
                some = any(
                    lattice.joined(x, at) for k in range(9) if (at := _between(a, b, k)) is not None
                )
                hidden += never
                assert not (never and some)
    assert hidden > 10


def _between(a: Point, b: Point, k: int) -> Point | None:
    x, y = (p + Fraction((q - p) * k, 8) for p, q in zip(a, b, strict=True))
    return (int(x), int(y)) if x.denominator == y.denominator == 1 else None


def _places(lattice: Lattice, rng: np.random.Generator, count: int) -> list[Point]:
    """Corners, then points of the floor: some in line with walls, some anywhere."""
    found: list[Point] = [(int(x), int(y)) for x, y in lattice.points]
    low, high = lattice.points.min(axis=0), lattice.points.max(axis=0)
    while len(found) < len(lattice.points) + count:
        x, y = (int(v) // PARTS * PARTS for v in rng.integers(low, high + 1))
        if rng.random() < 0.5:
            x = int(rng.choice(lattice.points[:, 0]))
        if on_floor(lattice.points, lattice.links, x, y):
            found.append((x, y))
    return found


def _motions(seed: int, count: int) -> Iterator[tuple[Stepper, list[Mover], bool]]:
    rng = np.random.default_rng(seed)
    jitter = 0.05 if seed % 3 == 2 else 0.0
    stepper = Stepper(make_lattice(block_floor(rng, 5, jitter)))
    lattice = stepper.lattice
    places = _places(lattice, rng, 15)
    made = 0
    while made < count:
        instant = bool(rng.random() < 0.2)
        movers: list[Mover] = []
        while len(movers) < 1 + made % 3:
            a, b = (places[k] for k in rng.integers(len(places), size=2))
            b = a if instant or rng.random() < 0.2 else b
            short = int(rng.uniform(1.0, 4.0) / lattice.grid_m * PARTS)
            range_units = short if rng.random() < 0.15 else None
            old, new = (bool(rng.random() < 0.6) if instant else True for _ in range(2))
            if lattice.joined(a, b) and (old or new or not instant):
                movers.append(Mover(a, b, range_units, old, new))
        made += 1
        yield stepper, movers, instant


@pytest.mark.parametrize("seed", range(6))
def test_hidden_regions_are_those_of_the_definition(seed: int) -> None:
    for stepper, movers, instant in _motions(seed, 3):
        step = stepper.step(movers, instant=instant)
        rings = [[(x, y) for x, y in ring.tolist()] for ring in stepper.lattice.rings]
        views = [_view(stepper, mover) for mover in movers]
        slow = cells(rings, views, instant, [], [])
        assert (slow.n_old, slow.n_new) == (step.regions.n_old, step.regions.n_new)
        # The same matrix up to the order of rows and columns.
        fast = step.regions.links
        assert _shape(np.array(slow.links, dtype=bool).reshape(fast.shape)) == _shape(fast)


def _view(stepper: Stepper, mover: Mover) -> View:
    corners = stepper.lattice.points
    reach = [
        [] if mover.range is None else inscribed_polygon(at, mover.range, corners)
        for at in (mover.before, mover.after)
    ]
    return View(
        mover.before,
        mover.after,
        reach[0],
        reach[1],
        mover.range is not None,
        mover.old,
        mover.new,
        stepper.sees_throughout(mover),
    )


def _shape(links: np.ndarray) -> list[tuple[int, ...]]:
    """What stays of a matrix of disjoint blocks when rows and columns are put in another order."""
    return sorted(
        tuple(sorted(int(links[:, j].sum()) for j in np.flatnonzero(row))) for row in links
    )


def test_a_sight_line_between_walls_parts_a_shadow() -> None:
    # A tooth from above and one from below meet the line y = 1 from both sides: behind them the
    # pursuer sees that line and nothing else.
    plan = PolygonMap(
        [
            *[(0, 0), (4, 0), (4, 1), (5, 1), (5, 0), (8, 0), (8, 2)],
            *[(3, 2), (3, 1), (2, 1), (2, 2), (0, 2)],
        ]
    )
    stepper = Stepper(make_lattice(plan))
    for y, shadows in ((1.0, 2), (1.1, 1), (0.9, 2)):
        at = stepper.lattice.snap((0.0, y))
        assert at is not None
        assert stepper.step([Mover(at, at, None)]).regions.n_old == shadows


@pytest.mark.parametrize("seed", range(9))
def test_the_way_back_is_the_transpose(seed: int) -> None:
    for stepper, movers, instant in _motions(seed, 6):
        back = [
            mover._replace(before=mover.after, after=mover.before, old=mover.new, new=mover.old)
            for mover in movers
        ]
        there = stepper.step(movers, instant=instant).regions.links
        again = stepper.step(back, instant=instant).regions.links
        assert (there == again.T).all()


@pytest.mark.parametrize("seed", range(9))
def test_halving_never_adds_contamination(seed: int) -> None:
    halvings = 0
    for stepper, movers, instant in _motions(seed, 6):
        halves = halved(movers)
        if instant or halves is None or all(one.before == one.after for one in movers):
            continue
        short = all(Stepper.sees_throughout(one) for one in movers)
        whole, first, second = (_links(stepper.step(m)) for m in (movers, *halves))
        both = (first @ second) > 0
        halvings += 1
        # Who drives farther than it can follow sees nothing throughout, but its halves may.
        assert not (both & ~(whole > 0)).any() or not short
    assert halvings > 0


def _links(step: Step) -> np.ndarray:
    return step.regions.links.astype(int)


@pytest.mark.parametrize("seed", range(10))
def test_who_gets_away_on_a_grid_is_never_called_captured(seed: int) -> None:
    rng = np.random.default_rng(seed + 300)
    plan = block_floor(rng, 4, jitter=0.05 if seed % 3 == 0 else 0.0)
    pursuers = 1 + seed % 2
    ways = random_ways(plan, rng, pursuers, int(rng.integers(2, 5)))
    found = verify_schedule(plan, schedule(*ways), (None,) * pursuers)
    if grid_evader_escapes(plan, schedule(*ways), 0.2, 8, 0.03):
        assert found.verdict is not Verdict.CAPTURED


def test_the_grid_evader_knows_its_way() -> None:
    lap = [(1.0, 1.0), (5.0, 1.0), (5.0, 5.0), (1.0, 5.0), (1.0, 1.0)]
    assert grid_evader_escapes(RING, schedule(lap), 0.4, 12, 0.03)
    assert not grid_evader_escapes(RING, schedule([(2.0, 2.0)] * 5, lap), 0.4, 12, 0.03)


def test_coordinates_in_millimetres_are_kept() -> None:
    plan = PolygonMap([(0.001, 0), (29.999, 0.007), (30, 20.003), (0, 20)])
    lattice = make_lattice(plan)
    assert np.abs(lattice.metres(lattice.points) - plan.outer).max() < 1e-12
    assert lattice.snap((12.345, 6.789)) == lattice.grid_point((12.345, 6.789))
    assert lattice.snap((-0.5, 3)) is None


@pytest.mark.parametrize("metres", [0.05, 1.0, 80.0, 3000.0])
def test_floors_of_all_sizes_fit(metres: float) -> None:
    plan = PolygonMap(ROOMS.outer * metres / 30.0)
    lattice = make_lattice(plan)
    assert np.abs(lattice.points).max() <= REACH // 2
    assert np.abs(lattice.metres(lattice.points) - plan.outer).max() <= lattice.grid_m


@pytest.mark.parametrize("radius", [0, 1, 700, 10**6, REACH, 10**9])
def test_a_polygon_of_a_range_lies_in_its_circle(radius: int) -> None:
    far = np.array([(9 * REACH, 0)], dtype=np.int64)
    centre = (12_345, -678)
    polygon = inscribed_polygon(centre, radius, far)
    assert all((x - centre[0]) ** 2 + (y - centre[1]) ** 2 <= radius**2 for x, y in polygon)
    assert all(max(abs(x), abs(y)) <= REACH for x, y in polygon)
    if 10**4 < radius < REACH:
        share = shapely.Polygon(polygon).area / (np.pi * radius**2)
        assert share > 0.998
