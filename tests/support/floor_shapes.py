"""Floors for tests: rings of points, the outer one counter-clockwise, holes clockwise."""

import math
from functools import cmp_to_key

import numpy as np
from hypothesis import strategies as st

Rings = list[list[tuple[float, float]]]

L_SHAPE: Rings = [[(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]]
RING: Rings = [
    [(0, 0), (10, 0), (10, 10), (0, 10)],
    [(4, 4), (4, 6), (6, 6), (6, 4)],
]
# A corridor and three rooms above it, each with a doorway narrower than the room.
ROOMS: Rings = [
    [
        (0, 0), (24, 0), (24, 3), (21, 3), (21, 4), (23, 4), (23, 9), (17, 9), (17, 4), (19, 4),
        (19, 3), (13, 3), (13, 4), (15, 4), (15, 9), (9, 9), (9, 4), (11, 4), (11, 3), (5, 3),
        (5, 4), (7, 4), (7, 9), (1, 9), (1, 4), (3, 4), (3, 3), (0, 3),
    ]
]  # fmt: skip


def comb(teeth: int) -> Rings:
    """A corridor 1 high with teeth 1 wide and 5 deep."""
    ring: list[tuple[float, float]] = [(0, 0), (2 * teeth + 1, 0), (2 * teeth + 1, 1)]
    for k in range(teeth - 1, -1, -1):
        ring += [(2 * k + 2, 1), (2 * k + 2, 6), (2 * k + 1, 6), (2 * k + 1, 1)]
    return [[*ring, (0, 1)]]


def area(ring) -> float:
    x, y = np.array(ring, dtype=float).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def rings_of_cells(cells: np.ndarray) -> Rings:
    """The rings around the set cells, every lattice point on them kept.

    Cells that touch at a corner alone must not occur.
    """
    cells = np.pad(cells, 1)
    after = {}
    for r, c in np.argwhere(cells).tolist():
        if not cells[r - 1, c]:
            after[c, r] = (c + 1, r)
        if not cells[r, c + 1]:
            after[c + 1, r] = (c + 1, r + 1)
        if not cells[r + 1, c]:
            after[c + 1, r + 1] = (c, r + 1)
        if not cells[r, c - 1]:
            after[c, r + 1] = (c, r)
    rings = []
    while after:
        start = min(after)
        ring, at = [start], after.pop(start)
        while at != start:
            ring.append(at)
            at = after.pop(at)
        rings.append(ring)
    return sorted(rings, key=lambda ring: -area(ring))


def without_straight_points(ring):
    count = len(ring)
    return [
        ring[i] for i in range(count) if area([ring[i - 1], ring[i], ring[(i + 1) % count]]) != 0
    ]


@st.composite
def orthogonal_floors(draw, size: int = 6) -> Rings:
    """Unions of lattice cells, with holes; points on straight walls kept or not."""
    rows, cols = draw(st.integers(2, size)), draw(st.integers(2, size))
    bits = draw(st.lists(st.booleans(), min_size=rows * cols, max_size=rows * cols))
    cells = np.array(bits, dtype=bool).reshape(rows, cols)
    cells[draw(st.integers(0, rows - 1)), draw(st.integers(0, cols - 1))] = True
    # Where two cells touch at a corner alone, fill a third.
    while True:
        a, b, c, d = cells[:-1, :-1], cells[:-1, 1:], cells[1:, :-1], cells[1:, 1:]
        pinched = np.argwhere((a & d & ~b & ~c) | (b & c & ~a & ~d))
        if len(pinched) == 0:
            break
        r, k = pinched[0]
        cells[r : r + 2, k : k + 2] = True
    kept = largest_part(cells)
    rings = rings_of_cells(kept)
    if draw(st.booleans()):
        rings = [without_straight_points(ring) for ring in rings]
    return rings


def largest_part(cells: np.ndarray) -> np.ndarray:
    best = np.zeros_like(cells)
    left = cells.copy()
    while left.any():
        part = np.zeros_like(cells)
        waiting = [tuple(np.argwhere(left)[0].tolist())]
        while waiting:
            r, c = waiting.pop()
            if 0 <= r < cells.shape[0] and 0 <= c < cells.shape[1] and left[r, c]:
                left[r, c] = False
                part[r, c] = True
                waiting += [(r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)]
        if part.sum() > best.sum():
            best = part
    return best


@st.composite
def star_floors(draw, reach: int = 12) -> Rings:
    """Lattice points in different directions around the origin, with small holes near it."""
    coordinate = st.integers(-reach, reach)
    points = draw(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=24))
    points += [(reach, 1), (-reach, 2), (-1, -reach)]
    by_direction = {}
    for x, y in points:
        if max(abs(x), abs(y)) > 3:
            g = math.gcd(x, y)
            by_direction.setdefault((x // g, y // g), (x, y))

    def compare(a, b):
        upper_a, upper_b = (a[1], a[0]) > (0, 0), (b[1], b[0]) > (0, 0)
        return upper_b - upper_a or (a[1] * b[0] - a[0] * b[1])

    ring = sorted(by_direction.values(), key=cmp_to_key(compare))
    return [ring]


@st.composite
def pillar_floors(draw) -> Rings:
    """A square hall with up to nine triangular or four-cornered pillars at lattice points."""
    rings: Rings = [[(0, 0), (24, 0), (24, 24), (0, 24)]]
    offset = st.integers(1, 3)
    for i in range(3):
        for j in range(3):
            kind = draw(st.sampled_from([0, 3, 4, 4]))
            x, y = 8 * i + 4, 8 * j + 4
            a, b, c, d = (draw(offset) for _ in range(4))
            four = [(x - a, y), (x, y + b), (x + c, y), (x, y - d)]
            if draw(st.booleans()):
                four = [(x - a, y - b), (x - c, y + b), (x + c, y + d), (x + a, y - d)]
            if kind and area(four[:kind]) < 0:
                rings.append(four[:kind])
    return rings


floors = st.one_of(orthogonal_floors(), star_floors(), pillar_floors())


@st.composite
def jittered_floors(draw) -> Rings:
    """Floors turned and moved a little, so that points are nearly on lines, not exactly."""
    rings = draw(floors)
    c, s = draw(st.sampled_from([(1.0, 0.0), (0.6, 0.8), (0.8, 0.6000000000000001)]))
    noise = draw(st.sampled_from([0.0, 1e-15, 1e-12, 1e-9, 1e-3]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    moved = []
    for ring in rings:
        points = np.array(ring, dtype=float) @ np.array([[c, s], [-s, c]]) * 0.1
        points += noise * rng.uniform(-1, 1, points.shape)
        moved.append([tuple(point) for point in points.tolist()])
    return moved


def viewpoints(rings: Rings, count: int, rng: np.random.Generator):
    """Vertices, points on walls, on lines through vertices, lattice points, and any points."""
    every = np.array([point for ring in rings for point in ring], dtype=float)
    low, high = every.min(axis=0), every.max(axis=0)
    points = []
    for _ in range(count):
        kind = rng.integers(6)
        a, b = every[rng.integers(len(every), size=2)]
        ring = rings[rng.integers(len(rings))]
        k = rng.integers(len(ring))
        p, q = np.array(ring[k - 1], dtype=float), np.array(ring[k], dtype=float)
        if kind == 0:
            points.append(a)
        elif kind == 1:
            points.append((p + q) / 2)
        elif kind == 2:
            points.append((a + b) / 2)
        elif kind == 3:
            points.append(2 * q - p)
        elif kind == 4:
            points.append(np.round(rng.uniform(low, high) * 2) / 2)
        else:
            points.append(rng.uniform(low, high))
    return [(float(x), float(y)) for x, y in points]
