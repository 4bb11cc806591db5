"""What a robot's odometry would have made of its path, corrected where loops close.

The paper calls its exploration integrated, and drives rectangles with "error corrections" in mind;
it has no model of errors. This is one:

- A robot knows its start. Each stretch of d metres adds to its heading's error a normal number with
  standard deviation `heading_per_m` sqrt(d), each turn by an angle a one with `heading_per_turn`
  sqrt(a / 90 degrees), and to the distance it believes to have driven one with `distance_per_m`
  sqrt(d). It moves its estimate on by that distance, in the direction it believes to have.
- A loop closes when it comes within `near_m` of a place where it was at least `apart_s` before, and
  has not closed one for as long; with shared maps also where a teammate was. It then takes over the
  error, of position and heading, that its map has there: that of the first visit. Nothing before is
  corrected.

Noise depends on the generator and on the moves that were made, neither on waits between them nor on
what is closed, so that what closures save is compared on equal noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from conav.experiments.two_stage.paths import Path, directions, turn_between


@dataclass(frozen=True)
class Drift:
    """The errors of odometry, and when a loop closes."""

    heading_per_m: float = 0.2 * pi / 180  # [rad], per square root of metres
    heading_per_turn: float = 1.0 * pi / 180  # [rad], per square root of quarter turns
    distance_per_m: float = 0.02  # [m], per square root of metres
    near_m: float = 1.0
    apart_s: float = 250.0  # 50 m at the paper's speed


@dataclass(frozen=True)
class Drifted:
    """What came of it."""

    closures: int
    final_m: float  # error of position at the end, root mean square over robots
    mean_m: float  # error of position over the whole run, root mean square over robots and steps


def replay(
    paths: Sequence[Path],
    step_s: float,
    drift: Drift,
    generators: Sequence[np.random.Generator],
    *,
    closing: str,
) -> Drifted:
    """The errors along these paths, one generator each.

    `closing` is "none", "own" for places where a robot itself was, or "shared" for anybody's.
    """
    if closing not in ("none", "own", "shared"):
        raise ValueError(f"closing {closing!r} is none of none, own, shared")
    n = len(paths)
    steps = len(paths[0]) - 1
    driven = [directions(path) for path in paths]
    noise = [rng.standard_normal((steps, 3)) for rng in generators]
    errors = np.zeros((n, steps + 1, 3))  # x, y, heading
    places: list[dict[tuple[int, int], tuple[int, int]]] = [{} for _ in range(n)]
    if closing == "shared":
        places = [places[0]] * n
    apart = drift.apart_s / step_s
    closed_at = [0] * n
    moved = [0] * n
    facing = [-1] * n
    closures = 0
    for robot in range(n):
        _visit(places[robot], paths[robot][0], drift.near_m, 0, robot)
    for step in range(steps):
        for robot in range(n):
            k = driven[robot][step]
            if k < 0:
                errors[robot, step + 1] = errors[robot, step]
                continue
            before, now = paths[robot][step], paths[robot][step + 1]
            turned = turn_between(facing[robot], k) if facing[robot] >= 0 else 0
            facing[robot] = k
            drawn = noise[robot][moved[robot]]
            moved[robot] += 1
            error = _moved(errors[robot, step], before, now, turned, drawn, drift)
            if closing != "none" and step + 1 - closed_at[robot] >= apart:
                at = _first_visit(places[robot], paths, now, drift.near_m, step + 1 - apart)
                if at is not None:
                    error = errors[at[1], at[0]].copy()
                    closed_at[robot] = step + 1
                    closures += 1
            errors[robot, step + 1] = error
            _visit(places[robot], now, drift.near_m, step + 1, robot)
    squares = errors[:, :, 0] ** 2 + errors[:, :, 1] ** 2
    return Drifted(closures, sqrt(float(squares[:, -1].mean())), sqrt(float(squares.mean())))


def _moved(
    error: NDArray[np.float64],
    before: NDArray[np.float64],
    now: NDArray[np.float64],
    turned: int,
    noise: NDArray[np.float64],
    drift: Drift,
) -> NDArray[np.float64]:
    """The error after a move, from the error before it."""
    dx, dy = (now - before).tolist()
    length = sqrt(dx * dx + dy * dy)
    x, y, heading = error.tolist()
    a, b, c = noise.tolist()
    heading += drift.heading_per_turn * sqrt(turned / 2) * a
    heading += drift.heading_per_m * sqrt(length) * b
    scale = 1.0 + drift.distance_per_m * sqrt(length) * c / length
    x += scale * (cos(heading) * dx - sin(heading) * dy) - dx
    y += scale * (sin(heading) * dx + cos(heading) * dy) - dy
    return np.array([x, y, heading])


def _bin(place: NDArray[np.float64], near_m: float) -> tuple[int, int]:
    return int(place[0] // near_m), int(place[1] // near_m)


def _visit(
    places: dict[tuple[int, int], tuple[int, int]],
    place: NDArray[np.float64],
    near_m: float,
    step: int,
    robot: int,
) -> None:
    """Remember the first visit to each square of a place's size: (step, robot)."""
    places.setdefault(_bin(place, near_m), (step, robot))


def _first_visit(
    places: dict[tuple[int, int], tuple[int, int]],
    paths: Sequence[Path],
    place: NDArray[np.float64],
    near_m: float,
    until: float,
) -> tuple[int, int] | None:
    """The earliest of the first visits near a place that were made until a step."""
    x, y = _bin(place, near_m)
    best: tuple[int, int] | None = None
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            at = places.get((x + dx, y + dy))
            if at is None or at[0] > until or (best is not None and at >= best):
                continue
            away = paths[at[1]][at[0]] - place
            if away[0] ** 2 + away[1] ** 2 <= near_m * near_m:
                best = at
    return best
