"""The verifier's rules of the radio: who hears whom, what is told, what is counted.

Written from the rules in docs/verify.md and docs/faults.md alone.
"""

from math import log10
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration.verify_world import Budget, Check, Knowledge, World
from conav.messages.message import HEADER_BYTES, report_bytes, scan_bytes
from conav.runs.types import StepRecord

MAX_ROUNDS = 32  # of transfers within one step


class Traffic(NamedTuple):
    """What the radio carries in one step."""

    told: list[tuple[int, int, int, int]]  # receiver, sender, origin, scans of origin then held
    messages: int
    bytes: int


def all_to_all(n: int, fresh: list[NDArray[np.int64] | None]) -> Traffic:
    """With a perfect radio everybody reports to everybody, its new scan included."""
    own = sum(scan_bytes(len(cells)) for cells in fresh if cells is not None)
    return Traffic([], n * (n - 1), (n - 1) * (n * report_bytes(n) + own))


def check_silence(step: StepRecord, quiet: NDArray[np.bool_], world: World, check: Check) -> None:
    """No mind speaks while its radio is off, and none goes silent where all tell all."""
    for sender in sorted({int(sender) for sender in step.said[::3]}):
        if sender < len(quiet) and quiet[sender]:
            check.fault(f"robot {sender} speaks at step {step.step} with its radio off")
    if world.all_to_all and step.quiet.any():
        check.fault(f"a radio is switched off at step {step.step} though all tell all")


class Links:
    """Who hears whom; remembers what lies between two cells."""

    def __init__(self, world: World) -> None:
        self.world = world
        reach = np.array([np.inf if limit is None else limit for limit in world.radio])
        self._reach = np.minimum(reach[:, None], reach[None, :])
        self._between: dict[tuple[int, int], tuple[float, float]] = {}

    def at(self, step: StepRecord, silent: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Who hears whom, shape (n, n): both radios are on and reach as far as they are apart."""
        world = self.world
        place = world.places(step.cells)
        square = ((place[:, None] - place[None, :]) ** 2).sum(axis=2)
        linked = (square <= self._reach**2) & (self._reach > 0)
        linked &= ~silent[:, None] & ~silent[None, :]
        np.fill_diagonal(linked, False)
        if any(budget is not None for budget in world.budgets):
            for i, j in np.argwhere(np.triu(linked)).tolist():
                lengths = self._lengths(int(step.cells[i]), int(step.cells[j]))
                budgets = (world.budgets[i], world.budgets[j])
                if not all(budget is None or _gets_across(budget, *lengths) for budget in budgets):
                    linked[i, j] = linked[j, i] = False
        return linked

    def _lengths(self, one: int, other: int) -> tuple[float, float]:
        """The metres through the open and through walls between two planning cells."""
        key = (min(one, other), max(one, other))
        if key not in self._between:
            world = self.world
            a, b = np.array(world.fine(key[0])), np.array(world.fine(key[1]))
            length = float(((b - a) ** 2).sum()) ** 0.5 * (world.cell_m / world.ratio)
            inside, whole = wall_share(world.walls, a, b)
            self._between[key] = (length * ((whole - inside) / whole), length * (inside / whole))
        return self._between[key]


def wall_share(
    walls: NDArray[np.uint8], a: NDArray[np.int64], b: NDArray[np.int64]
) -> tuple[int, int]:
    """The part of the segment between two cells' centres inside walls, as a fraction.

    All places where it crosses a line of the grid, sorted, and the cell in the middle of each two.
    """
    dr, dc = (abs(int(b[0] - a[0])), abs(int(b[1] - a[1])))
    whole = 2 * max(dr, 1) * max(dc, 1)
    cuts = [0, whole]
    for steps in (dr, dc):
        if steps:
            cuts += [(2 * k + 1) * (whole // (2 * steps)) for k in range(steps)]
    at = np.unique(np.array(cuts, dtype=np.int64))
    # The middle of a piece lies at (at[k] + at[k+1]) / (2 whole) of the way.
    middle = at[:-1] + at[1:]
    rows = a[0] + np.sign(b[0] - a[0]) * ((2 * dr * middle + 2 * whole) // (4 * whole))
    cols = a[1] + np.sign(b[1] - a[1]) * ((2 * dc * middle + 2 * whole) // (4 * whole))
    return int(np.diff(at)[walls[rows, cols] != 0].sum()), whole


def _gets_across(budget: Budget, free_m: float, wall_m: float) -> bool:
    """Whether enough of a signal is left."""
    wall, free = wall_m / budget.unit_m, free_m / budget.unit_m
    loss = budget.reference_db
    if wall > 0.0:
        loss += max(0.0, 10.0 * budget.wall_exponent * round(log10(wall), 12))
        loss += budget.wall_shadow_db
    if free >= budget.reference_distance:
        loss += 10.0 * budget.free_exponent * round(log10(free / budget.reference_distance), 12)
        loss += budget.free_shadow_db
    return budget.transmit_dbm - round(loss, 12) > budget.threshold_dbm


class Air:
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

    def exchange(self, linked: NDArray[np.bool_], known: Knowledge) -> Traffic:
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
        return Traffic(told, messages, size)

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


def compare_told(step: StepRecord, expected: Traffic, check: Check) -> None:
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


class SlowAir:
    """What is told where messages may be late or lost: nothing that could not be."""

    def __init__(self, world: World, air: Air) -> None:
        self.world = world
        self.air = air
        self.linked: list[NDArray[np.bool_]] = []  # of every step
        self.held: list[NDArray[np.int64]] = []  # at the end of every step's exchange
        self.floor: list[int] = []  # bytes that each step's exchange takes at least

    def exchange(
        self,
        step: StepRecord,
        linked: NDArray[np.bool_],
        silent: NDArray[np.bool_],
        fresh: list[NDArray[np.int64] | None],
        known: Knowledge,
        check: Check,
    ) -> Traffic:
        """The reports of this step; checks what it says was told, and takes it in."""
        air, delay = self.air, self.world.delay
        air.take(fresh)
        self.linked.append(linked)
        check.looked += 1
        sent = step.step - delay
        reports = int(linked.sum())
        own = [scan_bytes(len(cells)) if cells is not None else 0 for cells in fresh]
        pushed = int((linked.sum(axis=1) * np.array(own)).sum())
        self.floor.append(reports * report_bytes(air.n) + pushed)
        for row in step.told.reshape(-1, 4).tolist():
            receiver, sender, origin, upto = map(int, row)
            where = f"at step {step.step} robot {sender} tells {receiver}"
            if max(receiver, sender, origin) >= air.n:
                check.fault(f"{where} of {origin}; there are {air.n} robots")
                continue
            if sent < 0:
                check.fault(f"{where} sooner than a message takes")
                continue
            if not self.linked[sent][sender, receiver]:
                check.fault(f"{where} without a link at step {sent}")
            if silent[receiver]:
                check.fault(f"{where}, whose radio is off")
            held = self.held[sent] if delay else air.held
            since = int(air.held[receiver, origin])
            if upto > held[sender, origin]:
                check.fault(f"{where} the first {upto} scans of {origin}, which it did not hold")
            elif upto <= since:
                check.fault(f"{where} what it knew of {origin}")
            else:
                for cells in air.scans[origin][since:upto]:
                    known.add(receiver, cells)
                air.held[receiver, origin] = upto
                if origin != sender:  # scans of one's own may come with a report
                    self.floor[sent] += air.sizes[origin][upto] - air.sizes[origin][since]
        self.held.append(air.held.copy())
        return Traffic([], reports, 0)

    def check_counts(self, steps: list[StepRecord], check: Check) -> None:
        """What arrived was counted when it was sent."""
        for step, floor in zip(steps, self.floor, strict=True):
            said = int(step.said.astype(np.int64)[2::3].sum())
            if step.bytes < floor + said:
                check.fault(f"step {step.step} counts {step.bytes} bytes; it takes {floor + said}")


def count_traffic(step: StepRecord, traffic: Traffic, world: World, check: Check) -> None:
    """Messages and bytes are those of the exchange and of minds; no fewer where radios are slow."""
    n = world.n
    check.looked += 1
    said = step.said.astype(np.int64).reshape(-1, 3)  # by minds, on top of the exchange
    count = traffic.messages + len(said)
    size = traffic.bytes + int(said[:, 2].sum())
    if world.slow:
        # Besides reports there are answers: one at most for each.
        good = count <= step.messages <= count + n * (n - 1)
    else:
        good = (step.messages, step.bytes) == (count, size)
    if not good:
        check.fault(
            f"step {step.step} counts {step.messages} messages, {step.bytes} bytes; "
            f"it takes {count} and {size}"
        )
    if bool((said[:, :2] >= n).any()) or bool((said[:, 2] < HEADER_BYTES).any()):
        check.fault(f"step {step.step} has messages of nobody, to nobody or of no size")
