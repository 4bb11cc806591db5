"""Trajectories are whole, and each robot can drive its own."""

from collections.abc import Iterator
from itertools import pairwise
from math import atan2, cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_curves import place_at, velocity_at
from conav.planning.verify_scene import LARGEST, TOLERANCE, Body, Check, Scene, Violation

Track = NDArray[np.float64]


def well_formed(scene: Scene, check: Check) -> bool:
    """Whether all trajectories are rows of finite numbers in the order of time."""
    good = True
    for _, body, track in scene.ways():
        check.looked += 1
        if not (np.abs(track) <= LARGEST).all():
            problem = "has pieces that are no numbers, or too large ones"
        elif (track[:, 1] < track[:, 0]).any():
            problem = "has a piece that ends before it begins"
        elif ((track[:, 8] != 0.0) & (track[:, 6:8] != 0.0).any(axis=1)).any():
            problem = "has a piece that turns and accelerates"
        else:
            continue
        check.fault(Violation(problem, (body.name,)))
        good = False
    return good


def check_starts(scene: Scene, check: Check) -> None:
    """Everybody begins at time 0 in the state the problem says."""
    for _, body, track in scene.ways():
        check.looked += 1
        x, y = track[0, 2:4].tolist()
        if abs(track[0, 0]) > TOLERANCE:
            check.fault(Violation("begins late", (body.name,), float(track[0, 0]), (x, y)))
        off = hypot(x - body.start[0], y - body.start[1])
        if off > TOLERANCE:
            check.fault(Violation(f"begins {off:.3g} m from its start", (body.name,), 0.0, (x, y)))
        if body.motion == "double-integrator":
            vx, vy = track[0, 4:6].tolist()
            off = hypot(vx - body.start[2], vy - body.start[3])
            if off > TOLERANCE:
                text = f"begins {off:.3g} m/s off its velocity"
                check.fault(Violation(text, (body.name,), 0.0, (x, y)))


def check_joints(scene: Scene, check: Check) -> None:
    """No gap and no jump between pieces; no jump of the velocity where it cannot jump."""
    for _, body, track in scene.ways():
        for before, after in pairwise(track):
            check.looked += 1
            t = float(after[0])
            x, y = after[2:4].tolist()
            gap = t - float(before[1])
            if abs(gap) > TOLERANCE:
                check.fault(Violation(f"is nowhere for {gap:.3g} s", (body.name,), t, (x, y)))
            ax, ay = place_at(before, before[1])
            jump = hypot(x - ax, y - ay)
            if jump > TOLERANCE:
                check.fault(Violation(f"jumps {jump:.3g} m", (body.name,), t, (x, y)))
            if body.motion == "double-integrator":
                vx, vy = velocity_at(before, before[1])
                jump = hypot(after[4] - vx, after[5] - vy)
                if jump > TOLERANCE:
                    text = f"velocity jumps {jump:.3g} m/s"
                    check.fault(Violation(text, (body.name,), t, (x, y)))


def check_speed(scene: Scene, check: Check) -> None:
    """Nobody is faster than it can be."""
    for body, piece in _pieces(scene, check):
        for t in (piece[0], piece[1]):  # the speed of a piece is greatest at an end
            speed = hypot(*velocity_at(piece, t))
            if speed > body.speed + TOLERANCE:
                text = f"drives {speed:.6g} m/s of {body.speed:g}"
                x, y = place_at(piece, t)
                check.fault(Violation(text, (body.name,), float(t), (float(x), float(y))))
                break


def check_steering(scene: Scene, check: Check) -> None:
    """Double integrators keep their acceleration, cars their turning radius and their heading."""
    for body, piece in _pieces(scene, check):
        t, x, y = float(piece[0]), float(piece[2]), float(piece[3])
        speed = hypot(piece[4], piece[5])
        if body.motion == "double-integrator":
            norm = hypot(piece[6], piece[7]) + abs(piece[8]) * speed
            if norm > body.acceleration + TOLERANCE:
                text = f"accelerates {norm:.6g} m/s^2 of {body.acceleration:g}"
                check.fault(Violation(text, (body.name,), t, (x, y)))
        if body.motion == "dubins-car" and speed > TOLERANCE and piece[8] != 0.0:
            radius = speed / abs(piece[8])
            if radius < body.turning_radius - TOLERANCE:
                text = f"turns with a radius of {radius:.6g} m, at least {body.turning_radius:g}"
                check.fault(Violation(text, (body.name,), t, (x, y)))
    for _, body, track in scene.ways():
        if body.motion == "dubins-car":
            _check_headings(body, track, check)


def check_arrivals(scene: Scene, check: Check) -> None:
    """Everybody arrives by the horizon, and who stays can stop."""
    for _, body, track in scene.ways():
        check.looked += 1
        t = float(track[-1, 1])
        x, y = (float(number) for number in place_at(track[-1], t))
        if t > scene.horizon + TOLERANCE:
            text = f"arrives after the horizon of {scene.horizon:g} s"
            check.fault(Violation(text, (body.name,), t, (x, y)))
        if body.motion == "double-integrator" and body.stays:
            speed = hypot(*velocity_at(track[-1], t))
            if speed > TOLERANCE:
                text = f"stays where it arrives, with {speed:.3g} m/s"
                check.fault(Violation(text, (body.name,), t, (x, y)))


def _check_headings(body: Body, track: Track, check: Check) -> None:
    """A car drives forwards along its heading, which changes with its turns alone."""
    heading = body.start[2]
    for piece in track:
        duration = float(piece[1] - piece[0])
        first = velocity_at(piece, piece[0])
        last = velocity_at(piece, piece[1])
        off, side = 0.0, 0.0
        for number, (vx, vy) in enumerate((first, last)):
            ahead = heading + number * float(piece[8]) * duration
            along = vx * cos(ahead) + vy * sin(ahead)
            side = max(side, abs(vy * cos(ahead) - vx * sin(ahead)))
            off = min(off, along)
        if max(side, -off) > TOLERANCE:
            text = "drives backwards" if off < -TOLERANCE else "drives where it does not face"
            place = (float(piece[2]), float(piece[3]))
            check.fault(Violation(text, (body.name,), float(piece[0]), place))
        if hypot(*last) > TOLERANCE:
            heading = atan2(last[1], last[0])
        elif hypot(*first) > TOLERANCE:
            heading = atan2(first[1], first[0]) + float(piece[8]) * duration


def _pieces(scene: Scene, check: Check) -> Iterator[tuple[Body, Track]]:
    for _, body, track in scene.ways():
        check.looked += len(track)
        for piece in track:
            yield body, piece
