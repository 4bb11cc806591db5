"""The verifier's rules of form and motion: walls, speed, headings, collisions."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.exploration import verify_geometry as geometry
from conav.exploration.verify_world import STEPS, Check, World
from conav.runs.types import ExplorationRun, StepRecord

MIN_GAP = 0.4  # [cells] nearer than this even robots of no size may not come
SLACK = 1e-9  # [cells] of travel


class Moves:
    """Which moves between neighbouring planning cells the map allows each robot; remembers."""

    def __init__(self, world: World) -> None:
        self._world = world
        bodies = list(zip(world.radii.tolist(), world.diagonal, strict=True))
        self._kind = [bodies.index(body) for body in bodies]
        self._known: dict[tuple[int, int, int], bool] = {}

    def fits(self, robot: int, a: int, b: int) -> bool:
        """Whether the robot may go from planning cell a to b, or stay."""
        key = (self._kind[robot], a, b)
        fits = self._known.get(key)
        if fits is None:
            world = self._world
            fits = self._known[key] = geometry.move_fits(
                world.walls,
                world.ratio,
                float(world.radii[robot]),
                world.diagonal[robot],
                *divmod(a, world.cols),
                *divmod(b, world.cols),
            )
        return fits

    def towards(self, robot: int, cell: int, direction: int) -> int:
        """The cell that direction leads the robot to, -1 where it cannot go."""
        if direction < 0:
            return -1
        row, col = divmod(cell, self._world.cols)
        row, col = row + STEPS[direction][0], col + STEPS[direction][1]
        if not (0 <= row < self._world.rows and 0 <= col < self._world.cols):
            return -1
        there = row * self._world.cols + col
        return there if self.fits(robot, cell, there) else -1


def well_formed(run: ExplorationRun, world: World, check: Check) -> bool:
    """Whether steps count up from 0 and every array has its length and its range."""
    for text in world.odd:
        check.fault(text)
    for number, step in enumerate(run.steps):
        check.looked += 1
        if step.step != number or not _step_is_well_formed(step, world):
            check.fault(f"step {number} is not of the form a run has")
            return False
    if run.steps and not np.array_equal(run.steps[0].cells, world.starts):
        check.fault("robots do not begin at their starts")
    if run.result is not None and not run.steps:
        check.fault("a result without a step")
        return False
    return True


def _step_is_well_formed(step: StepRecord, world: World) -> bool:
    n = world.n
    size = world.rows * world.cols
    per_robot = (
        step.cells,
        step.headings,
        step.looked,
        step.scan_ends,
        step.wishes,
        step.goals,
        step.finished,
        step.quiet,
        step.condition,
    )
    return (
        all(len(part) == n for part in per_robot)
        and len(step.told) % 4 == 0
        and len(step.said) % 3 == 0
        and bool((np.diff(step.scan_ends.astype(np.int64)) >= 0).all())
        and int(step.scan_ends[-1]) == len(step.scans)
        and bool((step.cells < size).all())
        and bool(((step.goals >= -1) & (step.goals < size)).all())
        and bool(((step.wishes >= -1) & (step.wishes < len(STEPS))).all())
        and bool((step.headings < 4).all())
        and bool((step.looked < 2).all())
        and bool((step.finished < 2).all())
        and bool((step.quiet < 2).all())
        and bool((step.condition < 4).all())
        and all(bool((step.scan(robot)[0] < world.walls.size).all()) for robot in range(n))
    )


def check_walls(run: ExplorationRun, world: World, check: Check, moves: Moves) -> None:
    """No robot stands or drives where its disc touches a wall."""
    for robot in range(world.n):
        start = int(world.starts[robot])
        path = [start] + [int(step.cells[robot]) for step in run.steps]
        for number, (a, b) in enumerate(pairwise(path)):
            check.looked += 1
            if not moves.fits(robot, a, b):
                check.fault(f"robot {robot} drives into a wall or leaps before step {number}")


def check_speed(
    run: ExplorationRun, world: World, found: NDArray[np.uint8], check: Check, moves: Moves
) -> None:
    """Every move was paid for: a robot that can drive earns its speed each step.

    It saves up while it waits for the move it asks for; one that just stands keeps no more than a
    slow robot lacks for a straight move.
    """
    for robot in range(world.n):
        rate = float(world.rates[robot])
        credit = 0.0
        for number, (now, then) in enumerate(pairwise(run.steps)):
            check.looked += 1
            if found[number, robot]:
                credit = 0.0
                continue
            a, b = int(now.cells[robot]), int(then.cells[robot])
            dr, dc = world.change(a, b)
            credit += rate
            if dr or dc:
                length = (dr * dr + dc * dc) ** 0.5
                if credit < length - SLACK or max(abs(dr), abs(dc)) > 1:
                    check.fault(f"robot {robot} is too fast at step {number}")
                credit = max(credit - length, 0.0)
                continue
            turned = world.turning[robot] and now.headings[robot] != then.headings[robot]
            wish = int(now.wishes[robot])
            price = 2.0**0.5 if wish >= 4 else 1.0
            waits = moves.towards(robot, a, wish) >= 0 and credit < price - SLACK
            if turned:
                credit = 0.0
            elif not waits:
                credit = min(credit, 1.0 - rate)


def check_headings(run: ExplorationRun, world: World, check: Check) -> None:
    """A robot faces where it last drove straight; one that has to turn takes a step for that."""
    for robot in range(world.n):
        for number, (now, then) in enumerate(pairwise(run.steps)):
            check.looked += 1
            move = world.change(int(now.cells[robot]), int(then.cells[robot]))
            before, after = int(now.headings[robot]), int(then.headings[robot])
            if world.turning[robot]:
                if move != (0, 0) and (before != after or move != STEPS[after]):
                    check.fault(f"robot {robot} moves without having turned at step {number}")
            elif after != (STEPS.index(move) if move in STEPS[:4] else before):
                check.fault(f"robot {robot} faces another way than it drove at step {number}")


def check_collisions(
    run: ExplorationRun, world: World, found: NDArray[np.uint8], check: Check
) -> None:
    """No two robots that can drive touch, at a step or between, unless the problem lets them."""
    n = world.n
    if not world.apart or n < 2 or not run.steps:
        return
    reach = (world.radii[:, None] + world.radii[None, :]) / world.ratio
    gap = np.maximum(reach, MIN_GAP)
    upper = np.triu(np.ones((n, n), dtype=bool), 1)
    last = run.steps[-1]
    for number, (now, then) in enumerate((*pairwise(run.steps), (last, last))):
        check.looked += n * (n - 1) // 2
        a = world.places(now.cells).astype(float)
        drive = world.places(then.cells) - a
        start = a[:, None] - a[None, :]
        change = drive[:, None] - drive[None, :]
        speed = (change**2).sum(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            t = np.where(speed > 0, -(start * change).sum(axis=2) / speed, 0.0)
        nearest = start + np.clip(t, 0.0, 1.0)[:, :, None] * change
        drives = found[number] == 0
        near = upper & drives[:, None] & drives[None, :]
        near &= (nearest**2).sum(axis=2) < gap**2 - 1e-6
        for i, j in np.argwhere(near):
            check.fault(f"robots {i} and {j} touch after step {now.step}")
