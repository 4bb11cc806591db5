"""The verifier's rules of sight, knowledge and radio.

Written from the rules in docs/verify.md alone: what a sensor shows, what reports and transfers a
radio carries, and that nobody uses what it cannot know.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration import verify_geometry as geometry
from conav.exploration import verify_sight as sight
from conav.exploration.verify_faults import DEAD
from conav.exploration.verify_radio import (
    Air,
    Links,
    SlowAir,
    all_to_all,
    check_silence,
    compare_told,
    count_traffic,
)
from conav.exploration.verify_world import Check, Knowledge, World
from conav.runs.types import ExplorationRun, StepRecord


class Seen(NamedTuple):
    """What the events say was seen, of the observable cells."""

    covered: list[int]  # by the team after the looks of each step
    sensed: NDArray[np.int64]  # (n,) by each robot
    discovered: NDArray[np.int64]  # (n,) new to each robot when it saw it


def check_knowledge(
    run: ExplorationRun,
    world: World,
    found: NDArray[np.uint8],
    observable: NDArray[np.uint8],
    sight: Check,
    radio: Check,
    messages: Check,
) -> Seen:
    """Robots see what their sensor shows, all of it, tell it as the radio allows, and use no other
    knowledge. Returns what was seen.
    """
    n = world.n
    eyes = _Eyes(world, observable)
    known = Knowledge(world.walls.shape, 1 if world.all_to_all else n)
    owner = [0 if world.all_to_all else robot for robot in range(n)]
    air = Air(n)
    slow = SlowAir(world, air)
    links = Links(world)
    off = np.zeros(n, dtype=np.bool_)  # whose radio its mind switched off for this step
    for number, step in enumerate(run.steps):
        gone = found[number] >= DEAD
        fresh = [
            None if gone[robot] else eyes.look(step, robot, known, owner[robot], sight)
            for robot in range(n)
        ]
        for robot, cells in enumerate(fresh):
            if cells is not None:
                known.add(owner[robot], cells)
        silent = off | gone
        linked = links.at(step, silent)
        if world.all_to_all:
            traffic = all_to_all(n, fresh)
        elif world.slow:
            traffic = slow.exchange(step, linked, silent, fresh, known, radio)
        else:
            air.take(fresh)
            traffic = air.exchange(linked, known)
        eyes.close_step(known if world.mortal else None, found[number] != DEAD)
        if not world.slow:
            compare_told(step, traffic, radio)
        check_silence(step, off, world, radio)
        off = step.quiet != 0
        count_traffic(step, traffic, world, messages)
        following = run.steps[number + 1] if number + 1 < len(run.steps) else None
        for robot in range(n):
            _check_use(step, following, world, known, owner[robot], robot, sight)
    if world.slow:
        slow.check_counts(run.steps, messages)
    return Seen(eyes.covered, eyes.sensed, eyes.discovered)


class _Eyes:
    """What robots see, and what of it counts."""

    def __init__(self, world: World, observable: NDArray[np.uint8]) -> None:
        self.world = world
        self.observable = observable
        self.covered: list[int] = []
        self.sensed = np.zeros(world.n, dtype=np.int64)
        self.discovered = np.zeros(world.n, dtype=np.int64)
        self._seen = Knowledge(world.walls.shape, world.n)
        self._claimed = np.zeros(world.walls.shape, dtype=np.uint8)
        self._team = np.zeros(world.walls.size, dtype=np.bool_)
        self._count = 0
        self._last = np.full(world.n, -1, dtype=np.int64)
        self._visited: list[set[int]] = [set() for _ in range(world.n)]

    def look(
        self, step: StepRecord, robot: int, known: Knowledge, owner: int, check: Check
    ) -> NDArray[np.int64] | None:
        """The robot's scan in this step, checked; `None` when it made none."""
        check.looked += 1
        cell = int(step.cells[robot])
        cells, occupied = step.scan(robot)
        looked = bool(step.looked[robot])
        where = f"robot {robot} at step {step.step}"
        if looked != (cell != self._last[robot]):
            check.fault(f"{where} {'looks twice' if looked else 'is blind'}")
        if not looked:
            if len(cells):
                check.fault(f"{where} sees without looking")
            return None
        self._last[robot] = cell
        if ((self.world.walls.reshape(-1)[cells] != 0) != occupied).any():
            check.fault(f"{where} takes a wall for free or free for a wall")
        if len(np.unique(cells)) != len(cells) or known.has(owner, cells).any():
            check.fault(f"{where} reports as new what it knew")
        missed = self._view(robot, cell, cells, known, owner)
        if missed:
            check.fault(f"{where} misses {missed} cells it sees")
        unseen = int((~self._seen.has(robot, cells)).sum())
        if unseen:
            check.fault(f"{where} claims {unseen} cells it cannot see")
        self._take(robot, cells)
        return cells

    def _view(
        self, robot: int, cell: int, cells: NDArray[np.int64], known: Knowledge, owner: int
    ) -> int:
        """How many cells in view are neither known nor among these."""
        if cell in self._visited[robot]:
            return 0  # it has seen everything that is seen from here
        self._visited[robot].add(cell)
        claimed = self._claimed.reshape(-1)
        claimed[cells] = 1
        missed, fresh = sight.look_around(
            self.world.walls,
            *known.of(owner),
            self._claimed,
            *self._seen.of(robot),
            self.observable,
            *self.world.fine(cell),
            float(self.world.squares[robot]),
            self.world.occlusion[robot],
        )
        claimed[cells] = 0
        self.sensed[robot] += fresh
        return missed

    def _take(self, robot: int, cells: NDArray[np.int64]) -> None:
        wanted = cells[self.observable.reshape(-1)[cells] == 1]
        self.discovered[robot] += len(wanted)
        self._count += len(np.unique(wanted[~self._team[wanted]]))
        self._team[wanted] = True

    def close_step(self, known: Knowledge | None, alive: NDArray[np.bool_]) -> None:
        """Note how much the team has seen: where robots die, what those alive know."""
        if known is None:
            self.covered.append(self._count)
            return
        held = known.anybody(np.flatnonzero(alive).tolist()).reshape(-1)
        self.covered.append(int((held & (self.observable.reshape(-1) == 1)).sum()))


def _check_use(
    step: StepRecord,
    following: StepRecord | None,
    world: World,
    known: Knowledge,
    owner: int,
    robot: int,
    check: Check,
) -> None:
    """A robot's goal and its next move need only what it knows."""
    bits, mark = known.of(owner)
    goal = int(step.goals[robot])
    if goal >= 0:
        row, col = world.fine(goal)
        if not bits[row, col] & mark:
            check.fault(f"robot {robot} at step {step.step} heads for a place it cannot know")
    if following is None:
        return
    here, there = int(step.cells[robot]), int(following.cells[robot])
    if here != there and geometry.unknown_in_sweep(
        bits,
        mark,
        world.ratio,
        float(world.radii[robot]),
        *divmod(here, world.cols),
        *divmod(there, world.cols),
    ):
        check.fault(f"robot {robot} at step {step.step} drives into the unknown")
