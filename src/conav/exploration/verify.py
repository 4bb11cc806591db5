"""The verifier of exploration runs: re-derives every rule from the run file alone.

It imports no strategy, no belief and no simulator; its geometry is its own. What it accepts:
docs/verify.md.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.exploration import verify_geometry as geometry
from conav.messages.message import report_bytes, scan_bytes
from conav.runs.types import Run, StepRecord

# How a robot may step, E N W S NE NW SW SE, written out again on purpose.
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
MIN_GAP = 0.4  # [cells] nearer than this even robots of no size may not come
SHOWN = 3  # faults told in full per check


@dataclass
class Check:
    """One rule: how often it was looked at and where it was broken."""

    name: str
    looked: int = 0
    broken: int = 0
    faults: list[str] = field(default_factory=list[str])

    def fault(self, text: str) -> None:
        """Note a breach."""
        self.broken += 1
        if len(self.faults) < SHOWN:
            self.faults.append(text)


@dataclass(frozen=True)
class VerificationReport:
    """What the verifier found; `accepted` when no rule was broken."""

    path: str
    checks: tuple[Check, ...]
    intact: bool
    digest: str

    @property
    def accepted(self) -> bool:
        return all(check.broken == 0 for check in self.checks)

    def lines(self) -> list[str]:
        """The report for people, a line a check and one per fault."""
        lines: list[str] = []
        for check in self.checks:
            mark = "ok" if check.broken == 0 else f"BROKEN {check.broken} times"
            lines.append(f"{check.name}: {mark} ({check.looked} looked at)")
            lines.extend(f"  {text}" for text in check.faults)
        if not self.intact:
            lines.append("the file was cut short; only what is in it was checked")
        verdict = "accepted" if self.accepted else "REJECTED"
        lines.append(f"{verdict}: {self.path} (digest {self.digest[:16]})")
        return lines

    def summary(self) -> dict[str, Any]:
        """The report as one JSON object."""
        return {
            "job": "verify",
            "run": self.path,
            "accepted": self.accepted,
            "intact": self.intact,
            "digest": self.digest,
            "checks": {
                check.name: {
                    "looked": check.looked,
                    "broken": check.broken,
                    "faults": check.faults,
                }
                for check in self.checks
            },
        }


class _World(NamedTuple):
    """What the header says, in the verifier's own terms."""

    walls: NDArray[np.uint8]  # (fine rows, fine cols) 1 where a robot cannot be or see through
    rows: int
    cols: int
    ratio: float  # fine cells per planning cell
    radii: NDArray[np.float64]  # (n,) [fine cells]
    rates: NDArray[np.float64]  # (n,) cells a step
    squares: NDArray[np.float64]  # (n,) squared sensor range [fine cells^2]
    occlusion: list[bool]
    diagonal: list[bool]
    turning: list[bool]
    radio: list[float | None]  # (n,) [planning cells]
    starts: NDArray[np.int64]
    step_s: float
    cell_m: float

    @property
    def n(self) -> int:
        return len(self.occlusion)

    def fine(self, cell: int) -> tuple[int, int]:
        """The fine cell at a planning cell's centre."""
        row, col = divmod(cell, self.cols)
        return (
            min(int((row + 0.5) * self.ratio), self.walls.shape[0] - 1),
            min(int((col + 0.5) * self.ratio), self.walls.shape[1] - 1),
        )


def verify_exploration(run: Run) -> VerificationReport:
    """The verdict on an exploration's run file.

    Raises `InputError` when the run is of another job or its header is not one of an exploration.
    """
    world = _world(run)
    form = Check("form")
    if not _well_formed(run, world, form):
        return VerificationReport(str(run.path), (form,), run.intact, run.digest)
    checks = [form]
    for name, check in (
        ("walls", _check_walls),
        ("speed", _check_speed),
        ("collisions", _check_collisions),
        ("sight and knowledge", _check_knowledge),
        ("messages", _check_messages),
        ("metrics", _check_metrics),
    ):
        result = Check(name)
        cast("Callable[[Run, _World, Check], None]", check)(run, world, result)
        checks.append(result)
    return VerificationReport(str(run.path), tuple(checks), run.intact, run.digest)


def _world(run: Run) -> _World:
    header = run.header
    if header.get("job") != "explore":
        raise InputError(
            run.path, f"is a run of job {header.get('job')!r}", "verify takes explorations"
        )
    try:
        robots = cast("list[dict[str, Any]]", header["robots"])
        cell_m = float(header["cell_m"])
        ratio = cell_m / run.resolution
        top = max(float(robot["speed_mps"]) for robot in robots)
        limits = [robot["radio"]["range_m"] for robot in robots]
        return _World(
            walls=(run.cells != 0).astype(np.uint8),
            rows=int(np.ceil(run.cells.shape[0] / ratio - 0.5 - 1e-9)),
            cols=int(np.ceil(run.cells.shape[1] / ratio - 0.5 - 1e-9)),
            ratio=ratio,
            radii=np.array(
                [max(float(robot["radius_m"]) / run.resolution, 1e-3) for robot in robots]
            ),
            rates=np.array([float(robot["speed_mps"]) / top for robot in robots]),
            squares=np.array(
                [(float(robot["sensor"]["range_m"]) / run.resolution) ** 2 for robot in robots]
            ),
            occlusion=[bool(robot["sensor"]["occlusion"]) for robot in robots],
            diagonal=[bool(robot["motion"]["diagonal"]) for robot in robots],
            turning=[bool(robot["motion"]["turn_costs_step"]) for robot in robots],
            radio=[None if limit is None else float(limit) / cell_m for limit in limits],
            starts=np.array([int(cell) for cell in header["starts"]], dtype=np.int64),
            step_s=float(header["step_s"]),
            cell_m=cell_m,
        )
    except (KeyError, TypeError, ValueError, ZeroDivisionError) as error:
        raise InputError(
            run.path, f"has a header that cannot be used ({error!r})", "the file is damaged"
        ) from None


def _well_formed(run: Run, world: _World, check: Check) -> bool:
    """Whether steps count up from 0 and every array has its length and its range."""
    n = world.n
    size = world.rows * world.cols
    fine = world.walls.size
    for number, step in enumerate(run.steps):
        check.looked += 1
        lengths = (
            step.cells,
            step.headings,
            step.looked,
            step.scan_ends,
            step.wishes,
            step.goals,
            step.finished,
        )
        good = (
            step.step == number
            and all(len(part) == n for part in lengths)
            and len(step.told) % 4 == 0
            and bool((np.diff(step.scan_ends.astype(np.int64)) >= 0).all())
            and (n == 0 or int(step.scan_ends[-1]) == len(step.scans))
            and bool((step.cells < size).all())
            and bool((step.goals < size).all())
            and bool((step.headings < 4).all())
            and all(bool((step.scan(robot)[0] < fine).all()) for robot in range(n))
        )
        if not good:
            check.fault(f"step {number} is not of the form a run has")
            return False
    if len(world.starts) != n:
        check.fault(f"{len(world.starts)} starts for {n} robots")
    elif run.steps and not np.array_equal(run.steps[0].cells, world.starts):
        check.fault("robots do not begin at their starts")
    if run.result is None and run.intact:
        check.fault("the file is whole but has no result")
    return check.broken == 0


def _pairs(run: Run) -> Iterator[tuple[StepRecord, StepRecord]]:
    return pairwise(run.steps)


def _check_walls(run: Run, world: _World, check: Check) -> None:
    """No robot stands or drives where its disc touches a wall."""
    known: dict[tuple[int, int, int], bool] = {}
    for robot in range(world.n):
        radius = float(world.radii[robot])
        diagonal = world.diagonal[robot]
        here = int(world.starts[robot])
        path = [here] + [int(step.cells[robot]) for step in run.steps]
        for number, (a, b) in enumerate(pairwise(path)):
            check.looked += 1
            key = (robot if len(set(world.radii.tolist())) > 1 else 0, a, b)
            if key not in known:
                r1, c1 = divmod(a, world.cols)
                r2, c2 = divmod(b, world.cols)
                known[key] = geometry.move_fits(
                    world.walls, world.ratio, radius, diagonal, r1, c1, r2, c2
                )
            if not known[key]:
                check.fault(f"robot {robot} drives into a wall or leaps before step {number}")


def _check_speed(run: Run, world: _World, check: Check) -> None:
    """No robot is faster than allowed, over any stretch of time; turns take their step."""
    for robot in range(world.n):
        rate = float(world.rates[robot])
        ahead = 0.0  # travel beyond what was earned since the best moment to start counting
        for number, (now, then) in enumerate(_pairs(run)):
            check.looked += 1
            a, b = int(now.cells[robot]), int(then.cells[robot])
            dr = b // world.cols - a // world.cols
            dc = b % world.cols - a % world.cols
            length = (dr * dr + dc * dc) ** 0.5
            ahead = max(ahead, 0.0) + length - rate
            # While it waits for a move's time to pass, a robot saves up less than a diagonal.
            if ahead > 2.0**0.5 + 1e-6 or max(abs(dr), abs(dc)) > 1:
                check.fault(f"robot {robot} is too fast at step {number}")
                ahead = 0.0
            if world.turning[robot]:
                facing = STEPS[int(then.headings[robot])]
                turned = int(now.headings[robot]) != int(then.headings[robot])
                if (dr or dc) and (turned or (dr, dc) != facing):
                    check.fault(f"robot {robot} moves without having turned at step {number}")


def _check_collisions(run: Run, world: _World, check: Check) -> None:
    """No two robots touch, at a step or between two."""
    n = world.n
    if n < 2:
        return
    reach = (world.radii[:, None] + world.radii[None, :]) / world.ratio
    gap = np.maximum(reach, MIN_GAP)
    np.fill_diagonal(gap, 0.0)
    upper = np.triu(np.ones((n, n), dtype=bool), 1)
    last = run.steps[-1] if run.steps else None
    pairs = [*_pairs(run), (last, last)] if last is not None else []
    for now, then in pairs:
        a = np.stack(np.divmod(now.cells.astype(np.int64), world.cols), axis=1).astype(float)
        b = np.stack(np.divmod(then.cells.astype(np.int64), world.cols), axis=1).astype(float)
        start = a[:, None] - a[None, :]
        change = (b - a)[:, None] - (b - a)[None, :]
        speed = (change**2).sum(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            t = np.where(speed > 0, -(start * change).sum(axis=2) / speed, 0.0)
        nearest = start + np.clip(t, 0.0, 1.0)[:, :, None] * change
        near = upper & ((nearest**2).sum(axis=2) < gap**2 - 1e-6)
        check.looked += n * (n - 1) // 2
        for i, j in np.argwhere(near):
            check.fault(f"robots {i} and {j} touch after step {now.step}")


def _check_knowledge(run: Run, world: _World, check: Check) -> None:
    """Robots see what their sensor shows, all of it, and know and use nothing else."""
    n = world.n
    perfect = all(limit is None for limit in world.radio)
    # With a perfect radio all know the same after every step, so one map of the known is enough.
    known = [np.zeros(world.walls.shape, dtype=np.uint8) for _ in range(1 if perfect else n)]
    scans: list[list[NDArray[np.int64]]] = [[] for _ in range(n)]
    held = np.zeros((n, n), dtype=np.int64)
    flat_walls = world.walls.reshape(-1)
    last = np.full(n, -1, dtype=np.int64)
    for number, step in enumerate(run.steps):
        fresh: list[NDArray[np.int64] | None] = []
        for robot in range(n):
            check.looked += 1
            mine = known[0 if perfect else robot]
            cell = int(step.cells[robot])
            cells, occupied = step.scan(robot)
            looked = bool(step.looked[robot])
            if looked != (cell != last[robot]):
                check.fault(f"robot {robot} {'looks twice' if looked else 'is blind'} at {number}")
            if not looked:
                if len(cells):
                    check.fault(f"robot {robot} sees without looking at step {number}")
                fresh.append(None)
                continue
            last[robot] = cell
            row, col = world.fine(cell)
            if bool((flat_walls[cells] != occupied).any()):
                check.fault(f"robot {robot} takes a wall for free or free for a wall at {number}")
            if len(np.unique(cells)) != len(cells) or mine.reshape(-1)[cells].any():
                check.fault(f"robot {robot} reports as new what it knew at step {number}")
            wrong = geometry.false_claims(
                world.walls, cells, row, col, float(world.squares[robot]), world.occlusion[robot]
            )
            if wrong:
                check.fault(f"robot {robot} claims {wrong} cells it cannot see at step {number}")
            fresh.append(cells)
        for robot, cells in enumerate(fresh):
            if cells is not None:
                held[robot, robot] += 1
                scans[robot].append(cells)
                known[0 if perfect else robot].reshape(-1)[cells] = 1
        if perfect:
            if len(step.told):
                check.fault(f"transfers are listed for a perfect radio at step {number}")
        else:
            _replay_told(step, world, scans, held, known, check)
        for robot in range(n):
            mine = known[0 if perfect else robot]
            if fresh[robot] is not None:
                row, col = world.fine(int(step.cells[robot]))
                missed = geometry.missed_cells(
                    world.walls,
                    mine,
                    row,
                    col,
                    float(world.squares[robot]),
                    world.occlusion[robot],
                )
                if missed:
                    check.fault(f"robot {robot} misses {missed} cells it sees at step {number}")
            goal = int(step.goals[robot])
            if goal >= 0:
                row, col = world.fine(goal)
                if not mine[row, col]:
                    check.fault(f"robot {robot} heads for a place it cannot know at step {number}")
            if number + 1 < len(run.steps):
                here = divmod(int(step.cells[robot]), world.cols)
                there = divmod(int(run.steps[number + 1].cells[robot]), world.cols)
                if here != there and geometry.unknown_in_sweep(
                    mine, world.ratio, float(world.radii[robot]), *here, *there
                ):
                    check.fault(f"robot {robot} drives into the unknown at step {number}")


def _replay_told(
    step: StepRecord,
    world: _World,
    scans: list[list[NDArray[np.int64]]],
    held: NDArray[np.int64],
    known: list[NDArray[np.uint8]],
    check: Check,
) -> None:
    """Transfers between robots: only over links that exist, only of what the sender holds."""
    place = np.stack(np.divmod(step.cells.astype(np.int64), world.cols), axis=1)
    for receiver, sender, origin, upto in step.told.astype(np.int64).reshape(-1, 4):
        where = f"told by {sender} to {receiver} at step {step.step}"
        if max(receiver, sender, origin) >= world.n:
            check.fault(f"{where}: no such robot")
            continue
        square = float(((place[receiver] - place[sender]) ** 2).sum())
        limits = [world.radio[receiver], world.radio[sender]]
        if receiver == sender or any(limit is not None and square > limit**2 for limit in limits):
            check.fault(f"{where}: they cannot hear each other")
        if upto > held[sender, origin] or upto <= held[receiver, origin]:
            check.fault(f"{where}: scans the sender does not hold or the receiver has")
        for cells in scans[origin][int(held[receiver, origin]) : int(upto)]:
            known[receiver].reshape(-1)[cells] = 1
        held[receiver, origin] = max(held[receiver, origin], upto)


def _check_messages(run: Run, world: _World, check: Check) -> None:
    """Message and byte counts: exact with a perfect radio, else at least what was transferred."""
    n = world.n
    perfect = all(limit is None for limit in world.radio)
    sizes: list[list[int]] = [[] for _ in range(n)]
    held = np.zeros((n, n), dtype=np.int64)
    for step in run.steps:
        check.looked += 1
        own = 0
        for robot in range(n):
            if step.looked[robot]:
                size = scan_bytes(len(step.scan(robot)[0]))
                own += size
                sizes[robot].append(size)
                held[robot, robot] += 1
        if perfect:
            messages = n * (n - 1)
            size = (n - 1) * (n * report_bytes(n) + own)
            if (step.messages, step.bytes) != (messages, size):
                check.fault(
                    f"step {step.step} counts {step.messages} messages, {step.bytes} bytes; "
                    f"it takes {messages} and {size}"
                )
            continue
        messages, size = _least_traffic(step, world, sizes, held)
        if step.messages < messages or step.bytes < size:
            check.fault(f"step {step.step} counts fewer messages or bytes than were needed")


def _least_traffic(
    step: StepRecord, world: _World, sizes: list[list[int]], held: NDArray[np.int64]
) -> tuple[int, int]:
    """One report over each link, and every transferred scan."""
    n = world.n
    place = np.stack(np.divmod(step.cells.astype(np.int64), world.cols), axis=1)
    square = ((place[:, None] - place[None, :]) ** 2).sum(axis=2)
    reach = np.array([np.inf if limit is None else limit for limit in world.radio])
    linked = square <= np.minimum(reach[:, None], reach[None, :]) ** 2
    links = int(linked.sum()) - n
    size = links * report_bytes(n)
    for receiver, _, origin, upto in step.told.astype(np.int64).reshape(-1, 4):
        if max(receiver, origin) < n:
            size += sum(sizes[origin][int(held[receiver, origin]) : int(upto)])
            held[receiver, origin] = max(held[receiver, origin], upto)
    return links, size


def _check_metrics(run: Run, world: _World, check: Check) -> None:
    """Coverage and everything reported in the result, computed again from the events."""
    if run.result is None:
        return
    try:
        metrics = cast("dict[str, Any]", run.result["metrics"])
        status = str(run.result["status"])
        observable_said = int(run.result["observable"])
    except (KeyError, TypeError, ValueError):
        check.fault("the result has not the form of a result")
        return
    n = world.n
    observable = _observable(world)
    total = int(observable.sum())
    wanted = observable.reshape(-1)
    seen_by = np.zeros((n, *world.walls.shape), dtype=np.uint8)
    team = np.zeros(wanted.size, dtype=bool)
    discovered = np.zeros(n)
    lengths = np.zeros(n)
    covered: list[int] = []
    for number, step in enumerate(run.steps):
        for robot in range(n):
            cells = step.scan(robot)[0]
            discovered[robot] += wanted[cells].sum()
            team[cells] = True
            if step.looked[robot]:
                row, col = world.fine(int(step.cells[robot]))
                geometry.add_free_view(
                    world.walls,
                    seen_by[robot],
                    row,
                    col,
                    float(world.squares[robot]),
                    world.occlusion[robot],
                )
            if number:
                a, b = int(run.steps[number - 1].cells[robot]), int(step.cells[robot])
                dr, dc = b // world.cols - a // world.cols, b % world.cols - a % world.cols
                lengths[robot] += (dr * dr + dc * dc) ** 0.5 * world.cell_m
        covered.append(int((team & (wanted == 1)).sum()) if step.looked.any() else covered[-1])
    sensed = np.array([int((seen & observable).sum()) for seen in seen_by])
    final = covered[-1] if covered else 0
    last = max(len(covered) - 1, 0)
    expected: dict[str, Any] = {
        "steps": last,
        "time_s": last * world.step_s,
        "coverage": final / total if total else 1.0,
        "path_m": lengths.tolist(),
        "overlap": sensed.sum() / final - 1.0 if final else 0.0,
        "balance": {"seen": _spread(discovered), "path": _spread(lengths)},
        "messages": sum(step.messages for step in run.steps),
        "bytes": sum(step.bytes for step in run.steps),
    }
    for share in (90, 95, 99, 100):
        reached = [k for k, count in enumerate(covered) if 100 * count >= share * total]
        expected[f"t{share}_s"] = reached[0] * world.step_s if reached else None
    check.looked += len(expected) + 2
    if observable_said != total:
        check.fault(f"the result says {observable_said} observable cells; there are {total}")
    for key, value in expected.items():
        if not _close(metrics.get(key), value):
            check.fault(f"the result says {key} {metrics.get(key)}; the events say {value}")
    if (status == "done") != (final == total):
        check.fault(f"the result says {status} with {final} of {total} cells seen")


def _observable(world: _World) -> NDArray[np.uint8]:
    reached = np.zeros((world.rows, world.cols), dtype=np.uint8)
    reached |= geometry.reachable_cells(
        world.walls,
        world.rows,
        world.cols,
        world.ratio,
        float(world.radii[0]),
        world.diagonal[0],
        world.starts,
    )
    places = np.zeros(world.walls.shape, dtype=np.uint8)
    for cell in np.flatnonzero(reached):
        places[world.fine(int(cell))] = 1
    if world.occlusion[0]:
        owner = geometry.nearest_places(world.walls, places)
        return geometry.observable_from_nearest(world.walls, owner, float(world.squares[0]))
    return geometry.within_range(world.walls, places, float(world.squares[0]))


def _spread(values: NDArray[np.float64]) -> float:
    total = float(values.sum())
    return float(np.std(values / total)) if total else 0.0


def _close(said: Any, value: Any) -> bool:
    if isinstance(value, dict):
        parts = cast("dict[str, Any]", value)
        return isinstance(said, dict) and all(
            _close(cast("dict[str, Any]", said).get(key), part) for key, part in parts.items()
        )
    if isinstance(value, list):
        items = cast("list[Any]", value)
        return (
            isinstance(said, list)
            and len(cast("list[Any]", said)) == len(items)
            and all(_close(a, b) for a, b in zip(cast("list[Any]", said), items, strict=True))
        )
    if value is None or said is None:
        return said is value
    if not isinstance(said, int | float):
        return False
    return abs(float(said) - float(value)) <= 1e-6 * max(1.0, abs(float(value)))
