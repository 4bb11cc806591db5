"""The verifier's rules of sight, knowledge and radio.

Written from the rules in docs/verify.md alone: what a sensor shows, what reports and transfers a
radio carries, and that nobody uses what it cannot know.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration import verify_geometry as geometry
from conav.exploration.verify_world import Check, World
from conav.messages.message import HEADER_BYTES, report_bytes, scan_bytes
from conav.runs.types import Run, StepRecord

MAX_ROUNDS = 32  # of transfers within one step


class Seen(NamedTuple):
    """What the events say was seen, of the observable cells."""

    covered: list[int]  # by the team after the looks of each step
    sensed: NDArray[np.int64]  # (n,) by each robot
    discovered: NDArray[np.int64]  # (n,) new to each robot when it saw it


class Knowledge:
    """A bit per robot and fine cell; robots with a perfect radio share one."""

    def __init__(self, shape: tuple[int, ...], n: int) -> None:
        self._bits = np.zeros(((n + 7) // 8, *shape), dtype=np.uint8)

    def of(self, robot: int) -> tuple[NDArray[np.uint8], int]:
        """The array with the robot's bit, shape (fine rows, fine cols), and the bit."""
        return self._bits[robot // 8], 1 << (robot % 8)

    def add(self, robot: int, cells: NDArray[np.int64]) -> None:
        """The robot knows these flat cells from now on."""
        bits, mark = self.of(robot)
        bits.reshape(-1)[cells] |= np.uint8(mark)

    def has(self, robot: int, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the robot knows each of these flat cells."""
        bits, mark = self.of(robot)
        return (bits.reshape(-1)[cells] & mark) != 0


def check_knowledge(
    run: Run,
    world: World,
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
    air = _Air(n)
    quiet = np.zeros(n, dtype=np.bool_)  # whose radio is off in this step
    for number, step in enumerate(run.steps):
        fresh = [eyes.look(step, robot, known, owner[robot], sight) for robot in range(n)]
        for robot, cells in enumerate(fresh):
            if cells is not None:
                known.add(owner[robot], cells)
        eyes.close_step()
        if world.all_to_all:
            expected = _all_to_all(n, fresh)
        else:
            air.take(fresh)
            expected = air.exchange(_links(step, world, quiet), known)
        _compare_told(step, expected, radio)
        _check_quiet(step, quiet, world, radio)
        quiet = step.quiet != 0
        messages.looked += 1
        said = step.said.astype(np.int64).reshape(-1, 3)  # by minds, on top of the exchange
        count = expected.messages + len(said)
        size = expected.bytes + int(said[:, 2].sum())
        if (step.messages, step.bytes) != (count, size):
            messages.fault(
                f"step {step.step} counts {step.messages} messages, {step.bytes} bytes; "
                f"it takes {count} and {size}"
            )
        if bool((said[:, :2] >= n).any()) or bool((said[:, 2] < HEADER_BYTES).any()):
            messages.fault(f"step {step.step} has messages of nobody, to nobody or of no size")
        following = run.steps[number + 1] if number + 1 < len(run.steps) else None
        for robot in range(n):
            _check_use(step, following, world, known, owner[robot], robot, sight)
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
        missed, fresh = geometry.look_around(
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

    def close_step(self) -> None:
        """Note how much the team has seen."""
        self.covered.append(self._count)


class _Traffic(NamedTuple):
    """What the radio carries in one step."""

    told: list[tuple[int, int, int, int]]  # receiver, sender, origin, scans of origin then held
    messages: int
    bytes: int


def _all_to_all(n: int, fresh: list[NDArray[np.int64] | None]) -> _Traffic:
    """With a perfect radio everybody reports to everybody, its new scan included."""
    own = sum(scan_bytes(len(cells)) for cells in fresh if cells is not None)
    return _Traffic([], n * (n - 1), (n - 1) * (n * report_bytes(n) + own))


def _check_quiet(step: StepRecord, quiet: NDArray[np.bool_], world: World, check: Check) -> None:
    """No mind speaks while its radio is off, and none goes silent where all tell all."""
    for sender in sorted({int(sender) for sender in step.said[::3]}):
        if sender < len(quiet) and quiet[sender]:
            check.fault(f"robot {sender} speaks at step {step.step} with its radio off")
    if world.all_to_all and step.quiet.any():
        check.fault(f"a radio is switched off at step {step.step} though all tell all")


def _links(step: StepRecord, world: World, quiet: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Who hears whom, shape (n, n): both radios are on and reach as far as they are apart."""
    place = world.places(step.cells)
    square = ((place[:, None] - place[None, :]) ** 2).sum(axis=2)
    reach = np.array([np.inf if limit is None else limit for limit in world.radio])
    reach = np.minimum(reach[:, None], reach[None, :])
    linked = (square <= reach**2) & (reach > 0)
    linked &= ~quiet[:, None] & ~quiet[None, :]
    np.fill_diagonal(linked, False)
    return linked


class _Air:
    """Scans as they spread. `held[i, r]` of robot r's scans, the first ones, are with robot i."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.held = np.zeros((n, n), dtype=np.int64)
        self.scans: list[list[NDArray[np.int64]]] = [[] for _ in range(n)]
        self.sizes: list[list[int]] = [[0] for _ in range(n)]  # bytes of the first k scans

    def take(self, fresh: list[NDArray[np.int64] | None]) -> None:
        """Every robot holds its own new scan."""
        for robot, cells in enumerate(fresh):
            if cells is not None:
                self.scans[robot].append(cells)
                self.sizes[robot].append(self.sizes[robot][-1] + scan_bytes(len(cells)))
                self.held[robot, robot] += 1

    def exchange(self, linked: NDArray[np.bool_], known: Knowledge) -> _Traffic:
        """What is told in this step; brings what is held and known up to date.

        Everybody reports to everybody it hears. Then, round by round, each robot gets what it lacks
        from the neighbour that holds most, the lower number first, and reports what it got to the
        neighbours that, as far as it can tell, lack it.
        """
        near = [np.flatnonzero(row) for row in linked]
        report = report_bytes(self.n)
        before = self.held.copy()
        messages = int(linked.sum())
        size = messages * report
        told: list[tuple[int, int, int, int]] = []
        believed: dict[tuple[int, int], NDArray[np.int64]] = {}  # (who believes, of whom)
        for _ in range(MAX_ROUNDS):
            got = self._round(near)
            if not got:
                break
            told.extend(got)
            pairs = {(receiver, sender) for receiver, sender, _, _ in got}
            messages += len(pairs)
            size += report * len(pairs)
            for receiver, sender, origin, upto in got:
                since = int(self.held[receiver, origin])
                size += self.sizes[origin][upto] - self.sizes[origin][since]
                for cells in self.scans[origin][since:upto]:
                    known.add(receiver, cells)
                self.held[receiver, origin] = upto
                belief = believed.setdefault((sender, receiver), before[receiver].copy())
                belief[origin] = upto
            for sender in sorted({receiver for receiver, _, _, _ in got}):
                for receiver in map(int, near[sender]):
                    belief = believed.get((sender, receiver), before[receiver])
                    if (self.held[sender] > belief).any():
                        messages += 1
                        size += report
                    believed[receiver, sender] = self.held[sender].copy()
        return _Traffic(told, messages, size)

    def _round(self, near: list[NDArray[np.intp]]) -> list[tuple[int, int, int, int]]:
        """The transfers of one round: all that robots lack of what their neighbours hold."""
        got: list[tuple[int, int, int, int]] = []
        for receiver, around in enumerate(near):
            if len(around) == 0:
                continue
            offers = self.held[around]
            most = offers.max(axis=0)
            for origin in map(int, np.flatnonzero(most > self.held[receiver])):
                sender = int(around[np.argmax(offers[:, origin])])
                got.append((receiver, sender, origin, int(most[origin])))
        return got


def _compare_told(step: StepRecord, expected: _Traffic, check: Check) -> None:
    """The transfers of a step are those the radio makes, in their order."""
    check.looked += 1
    said = [tuple(map(int, row)) for row in step.told.reshape(-1, 4)]
    if said == expected.told:
        return
    right, claimed = set(expected.told), set(said)
    for receiver, sender, origin, upto in (row for row in said if row not in right):
        check.fault(
            f"at step {step.step} robot {sender} tells {receiver} the first {upto} scans of "
            f"{origin}, which it cannot or need not"
        )
    for receiver, _, origin, _ in (row for row in expected.told if row not in claimed):
        check.fault(
            f"at step {step.step} robot {receiver} is not told of {origin}'s scans it could hear of"
        )
    if right == claimed:
        check.fault(f"at step {step.step} transfers are doubled or out of order")


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
