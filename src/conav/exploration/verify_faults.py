"""The verifier's own account of which robots are in order, and what the others may not do."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.exploration.verify_world import Check, World
from conav.runs.types import ExplorationRun

ACTIVE, STALLED, DEAD, ABSENT = range(4)
NAMES = ("in order", "stalled", "dead", "absent")
MIN_GAP = 0.4  # [cells] nearer than this even robots of no size may not come


def conditions(run: ExplorationRun, world: World) -> NDArray[np.uint8]:
    """The condition of every robot in every step, shape (steps, n), from faults and batteries."""
    n = world.n
    now = np.full(n, ACTIVE, dtype=np.uint8)
    now[[fault.robot for fault in world.faults if fault.kind == "joins"]] = ABSENT
    found = np.zeros((len(run.steps), n), dtype=np.uint8)
    if not world.breakable:
        return found
    driven = [0.0] * n  # [cells]
    since = [0] * n
    for number, step in enumerate(run.steps):
        if number:
            before = run.steps[number - 1]
            for robot in range(n):
                dr, dc = world.change(int(before.cells[robot]), int(step.cells[robot]))
                driven[robot] += float(dr * dr + dc * dc) ** 0.5
        for robot in range(n):
            if now[robot] < DEAD and _is_empty(world, robot, driven[robot], number - since[robot]):
                now[robot] = DEAD
        for fault in world.faults:
            if fault.kind == "dies" and number >= fault.at:
                now[fault.robot] = DEAD
        for robot in range(n):
            if now[robot] == DEAD or _waits(world, robot, number):
                continue
            was = now[robot]
            if _stalls(world, robot, number):
                now[robot] = STALLED
            elif was != ACTIVE and _has_room(world, step.cells, robot, now):
                now[robot] = ACTIVE
            if was == ABSENT and now[robot] != ABSENT:
                since[robot] = number
        found[number] = now
    return found


def _is_empty(world: World, robot: int, driven: float, steps: int) -> bool:
    battery = world.batteries[robot]
    if battery.energy_j is None:
        return False
    spent = battery.drive_j_per_m * (driven * world.cell_m) + battery.on_w * (steps * world.step_s)
    return round(spent, 9) >= battery.energy_j


def _waits(world: World, robot: int, number: int) -> bool:
    return any(
        fault.robot == robot and fault.kind == "joins" and number < fault.at
        for fault in world.faults
    )


def _stalls(world: World, robot: int, number: int) -> bool:
    return any(
        fault.robot == robot
        and fault.kind == "stalls"
        and fault.at <= number
        and (fault.until is None or number < fault.until)
        for fault in world.faults
    )


def _has_room(world: World, cells: NDArray[np.uint32], robot: int, now: NDArray[np.uint8]) -> bool:
    """Whether no robot that can drive is where this one would be."""
    if not world.apart:
        return True
    places = world.places(cells)
    reach = np.maximum((world.radii + world.radii[robot]) / world.ratio, MIN_GAP)
    near = ((places - places[robot]) ** 2).sum(axis=1) < reach**2 - 1e-9
    near[robot] = False
    return not bool((near & (now == ACTIVE)).any())


def check_faults(run: ExplorationRun, world: World, found: NDArray[np.uint8], check: Check) -> None:
    """Robots are in the condition they must be in, and do nothing they cannot do in it."""
    for step, now in zip(run.steps, found, strict=True):
        check.looked += world.n
        for robot in np.flatnonzero(step.condition != now).tolist():
            check.fault(
                f"robot {robot} is {NAMES[int(step.condition[robot])]} at step {step.step}; it is "
                f"{NAMES[int(now[robot])]}"
            )
        for robot in np.flatnonzero(now >= DEAD).tolist():
            what = f"robot {robot}, {NAMES[int(now[robot])]},"
            if step.looked[robot]:
                check.fault(f"{what} looks around at step {step.step}")
            decided = (step.wishes[robot], step.goals[robot])
            if decided != (-1, -1) or step.finished[robot] or step.quiet[robot]:
                check.fault(f"{what} decides something at step {step.step}")
            if robot in step.said[::3]:
                check.fault(f"{what} speaks at step {step.step}")
    for number, (now, then) in enumerate(pairwise(run.steps)):
        moved = (now.cells != then.cells) | (now.headings != then.headings)
        for robot in np.flatnonzero(moved & (found[number] != ACTIVE)).tolist():
            name = NAMES[int(found[number, robot])]
            check.fault(f"robot {robot}, {name}, moves after step {number}")
