"""Functions of a trajectory: where a robot is, what it costs, parts of it, points to draw."""

from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.planning.piece import piece_length
from conav.planning.types import PIECE, Pieces, Trajectory


def positions(trajectory: Trajectory, times_s: ArrayLike) -> NDArray[np.float64]:
    """Where the robot's centre is at some times, shape (n, 2) [m]: before 0 at its start, after its
    arrival where it arrived."""
    rows, s = _rows_at(trajectory, times_s)
    x, y, vx, vy, ax, ay, turn = rows[:, 2:].T
    half = 0.5 * turn * s
    curved = turn != 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        chord = np.where(curved, 2.0 * np.sin(half) / turn, s)
    cosine, sine = np.where(curved, np.cos(half), 1.0), np.where(curved, np.sin(half), 0.0)
    return np.stack(
        [
            x + chord * (cosine * vx - sine * vy) + 0.5 * s * s * ax,
            y + chord * (sine * vx + cosine * vy) + 0.5 * s * s * ay,
        ],
        axis=-1,
    )


def velocities(trajectory: Trajectory, times_s: ArrayLike) -> NDArray[np.float64]:
    """Its velocity at some times, shape (n, 2) [m/s]; 0 before time 0 and from its arrival on.

    Where two pieces meet, that of the later.
    """
    times = np.atleast_1d(np.asarray(times_s, dtype=np.float64))
    rows, s = _rows_at(trajectory, times)
    _, _, vx, vy, ax, ay, turn = rows[:, 2:].T
    cosine, sine = np.cos(turn * s), np.sin(turn * s)
    moving = (times >= trajectory.pieces[0, 0]) & (times < trajectory.arrival_s)
    found = np.stack([cosine * vx - sine * vy + ax * s, sine * vx + cosine * vy + ay * s], axis=-1)
    return np.where(moving[:, np.newaxis], found, 0.0)


def headings(trajectory: Trajectory, times_s: ArrayLike, first: float = 0.0) -> NDArray[np.float64]:
    """Where it faces at some times, shape (n,) [rad]: where it drives, or drove last.

    `first` is where it faces until it drives.
    """
    times = np.atleast_1d(np.asarray(times_s, dtype=np.float64))
    starts = trajectory.pieces[:, 0]
    found = np.full(len(times), first)
    last = first
    for number, piece in enumerate(trajectory.pieces):
        end = starts[number + 1] if number + 1 < len(starts) else np.inf
        inside = (times >= piece[0]) & (times < end)
        t = np.append(np.minimum(times[inside], piece[1]), piece[1]) - piece[0]
        # By the turn where there is one, so that a car that stands still keeps its heading.
        vx, vy = piece[4] + piece[6] * t, piece[5] + piece[7] * t
        facing = np.where((vx != 0.0) | (vy != 0.0), np.arctan2(vy, vx) + piece[8] * t, last)
        found[inside] = facing[:-1]
        last = float(facing[-1])
    return found


def end_position(trajectory: Trajectory) -> tuple[float, float]:
    """Where it arrives, x, y [m]."""
    x, y = positions(trajectory, trajectory.arrival_s)[0].tolist()
    return x, y


def duration(trajectory: Trajectory) -> float:
    """The seconds until it arrives."""
    return trajectory.arrival_s


def length(trajectory: Trajectory) -> float:
    """The metres driven."""
    return float(sum(piece_length(piece) for piece in trajectory.pieces))


def cost(trajectory: Trajectory, components: Sequence[str]) -> NDArray[np.float64]:
    """The cost vector, shape (components,), by names of `COSTS`: length [m], duration [s]."""
    return np.array([_COST[name](trajectory) for name in components], dtype=np.float64)


_COST = {"length": length, "duration": duration}


def gaps(trajectory: Trajectory) -> NDArray[np.float64]:
    """How far it jumps and how long it is nowhere between its pieces, shape (n - 1, 2) [m, s]."""
    pieces = trajectory.pieces
    ends = np.concatenate(
        [positions(Trajectory(piece), piece[1]) for piece in pieces[:-1]] or [np.empty((0, 2))]
    )
    jumps = np.hypot(*(pieces[1:, 2:4] - ends).T)
    return np.stack([jumps, pieces[1:, 0] - pieces[:-1, 1]], axis=-1)


def cut(trajectory: Trajectory, start_s: float, end_s: float) -> Trajectory:
    """What it does from one time to another, as a trajectory from time 0.

    From the arrival on it stands. Raises `ValueError` unless 0 <= start_s < end_s.
    """
    if not 0.0 <= start_s < end_s:
        raise ValueError(f"no time from {start_s} to {end_s}")
    kept: list[NDArray[np.float64]] = []
    for piece in trajectory.pieces:
        if piece[1] <= start_s or piece[0] >= end_s:
            continue
        part = piece.copy()
        if piece[0] < start_s:
            part[2:4] = positions(trajectory, start_s)[0]
            part[4:6] = velocities(Trajectory(piece), start_s)[0]
            part[0] = start_s
        part[1] = min(piece[1], end_s)
        kept.append(part)
    arrival = max(trajectory.arrival_s, start_s)
    if arrival < end_s:
        kept.append(standing(end_position(trajectory), arrival, end_s))
    pieces = np.array(kept)
    pieces[:, :2] -= start_s
    return Trajectory(pieces)


def standing(place: tuple[float, float], start_s: float, end_s: float) -> NDArray[np.float64]:
    """The piece of a robot that stands, shape (PIECE,)."""
    piece = np.zeros(PIECE)
    piece[:4] = start_s, end_s, *place
    return piece


def straight(points: ArrayLike, times_s: ArrayLike) -> Trajectory:
    """The trajectory through points, shape (n, 2) [m], at times, shape (n,) [s], straight between.

    >>> straight([(0, 0), (3, 4)], [0, 10]).pieces[0, 4:6]
    array([0.3, 0.4])
    """
    at, times = np.asarray(points, dtype=np.float64), np.asarray(times_s, dtype=np.float64)
    pieces = np.zeros((len(at) - 1, PIECE))
    pieces[:, 0], pieces[:, 1] = times[:-1], times[1:]
    pieces[:, 2:4] = at[:-1]
    pieces[:, 4:6] = np.diff(at, axis=0) / np.diff(times)[:, np.newaxis]
    return Trajectory(pieces)


def polyline(trajectory: Trajectory, tolerance_m: float = 0.01) -> NDArray[np.float64]:
    """Points to draw it by, shape (n, 3): x, y [m], time [s].

    The line through them is nowhere further than the tolerance from the trajectory; both ends of
    every piece are among them.
    """
    points: list[NDArray[np.float64]] = []
    for piece in trajectory.pieces:
        duration = piece[1] - piece[0]
        speed = np.hypot(piece[4], piece[5])
        bend = max(abs(piece[8]) * speed, float(np.hypot(piece[6], piece[7])))
        # A chord over a time h is at most bend h^2 / 8 off.
        count = max(1, ceil(duration * (bend / (8.0 * tolerance_m)) ** 0.5))
        times = piece[0] + duration * np.arange(count + 1) / count
        points.append(np.column_stack([positions(Trajectory(piece), times), times]))
    return np.concatenate(points)


def _rows_at(trajectory: Trajectory, times_s: ArrayLike) -> tuple[Pieces, NDArray[np.float64]]:
    """The piece that holds at each time, shape (n, PIECE), and how long it has, shape (n,) [s]."""
    pieces = trajectory.pieces
    times = np.clip(
        np.atleast_1d(np.asarray(times_s, dtype=np.float64)), pieces[0, 0], pieces[-1, 1]
    )
    which = np.searchsorted(pieces[:, 0], times, side="right") - 1
    rows = pieces[which]
    return rows, np.minimum(times, rows[:, 1]) - rows[:, 0]
