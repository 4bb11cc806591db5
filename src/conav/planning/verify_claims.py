"""What the result says: costs, their sum, the status, and what is claimed beyond."""

from math import asinh, hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_bound import derived_bound
from conav.planning.verify_regions import words
from conav.planning.verify_scene import LARGEST, TOLERANCE, Check, Scene, Violation, is_number
from conav.planning.verify_task import Unreadable, names_in, read_formula, satisfied
from conav.runs.types import PlanRun


def check_tasks(scene: Scene, check: Check) -> None:
    """The word of each trajectory satisfies the robot's formula."""
    for _, body, track in scene.ways():
        check.looked += 1
        try:
            formula = read_formula(body.task)
        except Unreadable as error:
            check.fault(Violation(f"has a task that cannot be read: {error}", (body.name,)))
            continue
        names = names_in(formula)
        unknown = sorted(names - set(body.areas))
        if unknown:
            text = f"has a task about {', '.join(unknown)}, and no such region"
            check.fault(Violation(text, (body.name,)))
            continue
        readings = words(track, {name: body.areas[name] for name in sorted(names)})
        good = [satisfied(formula, word) for word in readings]
        if not any(good):
            check.fault(
                Violation(
                    f"does not do its task {body.task!r}; its word is {shown(readings[0])}",
                    (body.name,),
                    float(track[-1, 1]),
                )
            )
        elif not good[0]:
            check.notes.append(f"{body.name} does its task, by less than the tolerance")


def costs_of(track: NDArray[np.float64], components: tuple[str, ...]) -> list[float]:
    """The cost vector of a trajectory."""
    values = {"length": sum(map(_length, track)), "duration": float(track[-1, 1])}
    return [values[name] for name in components]


def check_costs(scene: Scene, result: dict[str, Any], check: Check) -> None:
    """The costs are those of the trajectories."""
    claimed = result.get("costs")
    if not isinstance(claimed, list) or len(claimed) != len(scene.bodies):
        check.fault(Violation("there is no cost for every robot"))
        return
    for body, track, said in zip(scene.bodies, scene.tracks, claimed, strict=True):
        check.looked += 1
        found = [None] * len(scene.costs) if track is None else costs_of(track, scene.costs)
        if not isinstance(said, list) or len(said) != len(found):
            check.fault(Violation("has costs of another form", (body.name,)))
            continue
        for name, a, b in zip(scene.costs, said, found, strict=True):
            if a is None and b is None:
                continue
            if b is None or not is_number(a) or not same(a, b):
                shown_b = "none, without a trajectory" if b is None else f"{b:.9g}"
                check.fault(Violation(f"{name} is said to be {a}, and is {shown_b}", (body.name,)))


def check_history(run: PlanRun, scene: Scene, check: Check) -> None:
    """On the way nobody who had a trajectory got a worse one, but while paths for all were sought.

    Of iNash alone, and of improvements the history says the game has made.
    """
    if run.header.get("solver") != "inash":
        return
    last: dict[int, tuple[list[float], int]] = {}
    for record in run.trajectories:
        if record.robot >= len(scene.bodies) or not (np.abs(record.pieces) <= LARGEST).all():
            check.fault(Violation(f"has a trajectory of robot {record.robot}, which is none"))
            continue
        check.looked += 1
        name = scene.bodies[record.robot].name
        before, since = last.pop(record.robot, (None, 0))
        if len(record.pieces):
            costs = costs_of(record.pieces, scene.costs)
            last[record.robot] = costs, record.improvement
        between = run.history[since : record.improvement]
        if before is None or any(entry.get("stage") == "feasibility" for entry in between):
            continue
        after, _ = last.get(record.robot, (None, 0))
        if after is None:
            check.fault(Violation("loses its trajectory in the game", (name,)))
        elif any(b > a + TOLERANCE for a, b in zip(before, after, strict=True)):
            check.fault(Violation(f"gets worse in the game, from {before} to {after}", (name,)))


def check_status(scene: Scene, result: dict[str, Any], check: Check) -> None:
    """Who is done has a trajectory for everybody, and no gain for anybody."""
    check.looked += 1
    status = result.get("status")
    if status not in ("done", "infeasible", "out_of_budget", "stuck"):
        check.fault(Violation(f"the status is {status!r}"))
    if status == "infeasible":
        check.skip("that the problem is infeasible")
    if status != "done":
        return
    for body, track in zip(scene.bodies, scene.tracks, strict=True):
        if track is None:
            check.fault(Violation("is said to be done and has no trajectory", (body.name,)))
    epsilon = result.get("epsilon")
    for body, gain in zip(scene.bodies, epsilon if isinstance(epsilon, list) else [], strict=False):
        if not is_number(gain) or gain > TOLERANCE:
            check.fault(Violation(f"is said to be done and could gain {gain}", (body.name,)))


def check_bound(scene: Scene, result: dict[str, Any], check: Check) -> None:
    """A lower bound is not above what was found, nor above what is derived anew."""
    bound = result.get("lower_bound")
    if bound is None:
        return
    check.looked += 1
    found = [costs_of(track, scene.costs)[0] for _, _, track in scene.ways()]
    everybody = len(found) == len(scene.bodies)
    if not is_number(bound):
        check.fault(Violation(f"the lower bound is {bound!r}"))
        return
    if everybody and bound > sum(found) + TOLERANCE:
        check.fault(Violation(f"the lower bound {bound:.9g} is above the plan's {sum(found):.9g}"))
        return
    try:
        derived = derived_bound(scene)
    except ValueError as error:
        check.skip(f"the lower bound: {error}")
        return
    if bound > derived + TOLERANCE:
        check.skip(f"the lower bound {bound:.9g}; {derived:.9g} is sure")


def same(a: float, b: float) -> bool:
    """Whether two numbers are equal but for rounding."""
    return abs(a - b) <= TOLERANCE * max(1.0, abs(a), abs(b))


def shown(word: tuple[frozenset[str], ...]) -> str:
    """A word for people."""
    return " ".join("{" + ", ".join(sorted(letter)) + "}" for letter in word)


def _length(piece: NDArray[np.float64]) -> float:
    """The length of a piece by its primitive, which has an inverse hyperbolic sine."""
    t0, t1, _, _, vx, vy, ax, ay, _ = piece.tolist()
    duration, speed, a = t1 - t0, hypot(vx, vy), hypot(ax, ay)
    if a * duration <= 1e-6 * speed or a == 0.0:
        # To second order in the acceleration, with which the next term is 1e-18 of the length.
        along = 0.0 if speed == 0.0 else (vx * ax + vy * ay) / speed
        across = 0.0 if speed == 0.0 else (vx * ay - vy * ax) / speed
        second = 0.0 if speed == 0.0 else across * across * duration**3 / (6.0 * speed)
        return speed * duration + along * duration**2 / 2.0 + second
    u, k = (vx * ax + vy * ay) / a / a, abs(vx * ay - vy * ax) / a / a

    def primitive(s: float) -> float:
        # What is lost when squared adds nothing, and s / k would overflow.
        return s * hypot(s, k) + (k * k * asinh(s / k) if k * k > 0.0 else 0.0)

    return a * (primitive(u + duration) - primitive(u)) / 2.0
