"""The way of edges and rests among others, against a look at every piece of everybody."""

import random
from math import hypot

import numpy as np
import pytest
from numpy.typing import NDArray

from conav.planning.verify_scene import Area, Body, Scene
from conav.planning.verify_traffic import (
    CLEAR,
    MEETS,
    PERHAPS,
    crowd_around,
    way_of_edges,
    way_of_rests,
)

HORIZON = 20.0


def scene_of(tracks: list[NDArray[np.float64]], stays: list[bool]) -> Scene:
    bodies = tuple(
        Body(f"r{i}", "single-integrator", (0.0, 0.0), "F a", {"a": Area((0, 0, 1), None)},
             0.2 + 0.1 * (i % 3), 1.0, 1.0, 0.5, stay)
        for i, stay in enumerate(stays)
    )  # fmt: skip
    return Scene(
        np.empty((0, 4)), np.empty((0, 3)), 100.0, HORIZON, 0.05, ("length",), bodies, tuple(tracks)
    )


def walk(rng: random.Random, curved: bool) -> NDArray[np.float64]:
    """Pieces one after the other, some of which bend."""
    rows: list[list[float]] = []
    t, x, y = 0.0, rng.uniform(0, 10), rng.uniform(0, 10)
    while t < HORIZON - 6 and (not rows or rng.random() < 0.9):
        dt = rng.uniform(0.05, 5.0)
        vx, vy = rng.uniform(-1, 1), rng.uniform(-1, 1)
        ax, ay = (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5)) if curved else (0.0, 0.0)
        rows.append([t, t + dt, x, y, vx, vy, ax, ay, 0.0])
        t, x, y = t + dt, x + vx * dt + ax * dt * dt / 2, y + vy * dt + ay * dt * dt / 2
    return np.array(rows)


def place(row: NDArray[np.float64], t: float) -> tuple[float, float]:
    s = t - row[0]
    return row[2] + (row[4] + row[6] * s / 2) * s, row[3] + (row[5] + row[7] * s / 2) * s


def nearest(scene: Scene, number: int, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """The least that is left between somebody on the way from a to b and anybody else, sampled."""
    least = np.inf
    me = scene.bodies[number]
    for other, body, track in scene.ways():
        if other == number:
            continue
        rows = list(track)
        end = track[-1, 1]
        if body.stays and end < HORIZON:
            rows.append(np.array([end, HORIZON, *place(track[-1], end), 0, 0, 0, 0, 0]))
        for t in np.linspace(a[2], b[2], 400):
            s = (t - a[2]) / (b[2] - a[2])
            x, y = a[:2] + s * (b[:2] - a[:2])
            for row in rows:
                if row[0] <= t <= row[1]:
                    u, v = place(row, t)
                    least = min(least, hypot(x - u, y - v) - me.radius - body.radius - 0.05)
    return least


@pytest.mark.parametrize("seed", range(4))
def test_as_a_look_at_every_piece(seed: int) -> None:
    rng = random.Random(seed)
    tracks = [walk(rng, curved=seed % 2 == 1 and i % 2 == 1) for i in range(7)]
    scene = scene_of(tracks, [rng.random() < 0.6 for _ in tracks])
    number = 3
    crowd = crowd_around(scene, number)
    vertices = np.array([
        (rng.uniform(0, 10), rng.uniform(0, 10), rng.uniform(0, HORIZON)) for _ in range(14)
    ])  # fmt: skip
    pairs = [(i, j) for i in range(14) for j in range(14) if vertices[i, 2] < vertices[j, 2]]
    tails, heads = np.array(pairs).T
    seen = {CLEAR: 0, MEETS: 0}
    for (i, j), way in zip(pairs, way_of_edges(vertices, tails, heads, crowd, 1e-9), strict=True):
        left = nearest(scene, number, vertices[i], vertices[j])
        if abs(left) > 0.02:  # what sampling may miss
            assert way == (CLEAR if left > 0 else MEETS), (i, j, left)
            seen[int(way)] += 1
    for vertex, way in zip(vertices, way_of_rests(vertices, HORIZON, crowd, 1e-9), strict=True):
        left = nearest(scene, number, vertex, np.array([*vertex[:2], HORIZON]))
        if abs(left) > 0.02:
            assert way == (CLEAR if left > 0 else MEETS), (vertex, left)
    assert min(seen.values()) > 10


def test_what_the_margin_decides() -> None:
    """Somebody stands; who passes as near as it may is clear, perhaps, or not."""
    still = np.array([[0.0, 1.0, 5.0, 5.0, 0, 0, 0, 0, 0]])
    scene = scene_of([still, still], [True, True])
    crowd = crowd_around(scene, 1)
    needed = 0.2 + 0.3 + 0.05
    for off, way in ((1e-3, CLEAR), (1e-7, CLEAR), (0.0, PERHAPS), (-1e-7, MEETS), (-1e-3, MEETS)):
        y = 5.0 + needed + off
        vertices = np.array([(1.0, y, 2.0), (9.0, y, 12.0), (5.0, y, 3.0)])
        edge = way_of_edges(vertices, np.array([0]), np.array([1]), crowd, 1e-9)
        assert edge.tolist() == [way]
        assert way_of_rests(vertices, HORIZON, crowd, 1e-9).tolist() == [CLEAR, CLEAR, way]


def test_nobody_else() -> None:
    still = np.array([[0.0, 1.0, 5.0, 5.0, 0, 0, 0, 0, 0]])
    crowd = crowd_around(scene_of([still], [True]), 0)
    vertices = np.array([(1.0, 1.0, 2.0), (9.0, 1.0, 12.0)])
    assert way_of_edges(vertices, np.array([0]), np.array([1]), crowd, 1e-9).tolist() == [CLEAR]
    assert way_of_rests(vertices, HORIZON, crowd, 1e-9).tolist() == [CLEAR, CLEAR]
