"""What the decisions of assignment strategies cost over whole runs: docs/performance.md, Decisions.

    python benchmarks/decisions.py                 # 8 robots, four built-in maps of 500 x 500 cells
    python benchmarks/decisions.py --big           # 64 robots, 1000 x 1000 cells, pocket-assignment
    python benchmarks/decisions.py --growth        # with robots, area and range
    python benchmarks/decisions.py MAP ...         # map files, at planning cells of their own size
    python benchmarks/decisions.py --all MAP ...   # all of these, one after the other

A round is a step in which somebody computes an assignment; its time is that of all minds in the
step. Of it, `fields` is the time spent on path lengths, `paths` that on the drives to what was
assigned and, until a robot is told, to what is nearest; the rest is everything else. Every run is
played twice, as the first also loads the kernels; `--repeat` plays it more often, and the medians
over the repetitions are shown with the lowest and the highest. `run` is a hash of all that the
robots did: equal hashes are equal runs.

Above every table stands what a fixed piece of work took just before it, compiled and in Python: by
that, tables of different days and machines can be compared.
"""

import argparse
import hashlib
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from time import perf_counter, perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

import conav
from conav.compiled import kernel
from conav.exploration import repeated_auction, team_assignment
from conav.exploration.catalogue import make_strategy
from conav.exploration.types import Action, ExplorationProblem, Strategy, TeamView
from conav.geometry.jump_graph import JumpGraph
from conav.maps.occupancy_grid import OccupancyGrid
from conav.messages.message import Message
from conav.simulation import engine as engine_module
from conav.simulation.engine import Engine, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import new_world

STRATEGIES = (
    "greedy",
    "hungarian",
    "minpos",
    "frontier-dp",
    "decision-theoretic",
    "repeated-auction",
    "pocket-assignment",
    "lanes-and-pockets",
)
MAPS = ("office", "cave", "maze", "field")

now_ns = perf_counter_ns


@dataclass
class Clock:
    """Nanoseconds and calls by what they went into."""

    ns: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    calls: dict[str, int] = field(default_factory=lambda: defaultdict(int))

    def timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **more: Any) -> Any:
            start = now_ns()
            try:
                return function(*args, **more)
            finally:
                self.ns[name] += now_ns() - start
                self.calls[name] += 1

        return call


@dataclass
class Timed:
    """A strategy with a clock on each step."""

    strategy: Strategy
    clock: Clock
    rounds: dict[int, list[int]] = field(default_factory=dict)  # step -> ns: all, fields, paths; n

    def start(self, view: TeamView, rng: np.random.Generator) -> Any:
        return self.strategy.start(view, rng)

    def step(
        self, memory: Any, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[Any, Action, Sequence[Message]]:
        before = computed(memory)
        fields, paths = self.clock.ns["fields"], self.clock.ns["paths"]
        start = now_ns()
        answer = self.strategy.step(memory, view, inbox, rng)
        took = now_ns() - start
        row = self.rounds.setdefault(view.step, [0, 0, 0, 0])
        row[0] += took
        row[1] += self.clock.ns["fields"] - fields
        row[2] += self.clock.ns["paths"] - paths
        row[3] += computed(memory) - before
        return answer


def computed(memory: Any) -> int:
    """How many assignments a robot has computed."""
    return getattr(memory, "assignments", 0) + getattr(memory, "auctions", 0)


@dataclass
class Played:
    """One run."""

    status: str
    steps: int
    digest: str
    wall_s: float
    rounds: np.ndarray  # (n_rounds, 3) [ms]: all, fields, paths
    clock: Clock


def play(
    problem: ExplorationProblem,
    name: str,
    observable: np.ndarray,
    limit: int | None = None,
    tell: bool = False,
) -> Played:
    """A run to its end, with clocks on all there is."""
    clock = Clock()
    mind = Timed(make_strategy(name), clock)
    state = new_world(problem, mind, observable)
    engine = engine_for(state)
    patched: list[tuple[Any, str, Any]] = []

    def patch(where: Any, attribute: str, label: str) -> None:
        patched.append((where, attribute, getattr(where, attribute)))
        setattr(where, attribute, clock.timed(label, getattr(where, attribute)))

    for method in ("__init__", "lengths", "length"):
        patch(JumpGraph, method, "fields")
    patch(team_assignment, "drive_to", "paths")
    patch(repeated_auction, "shortest_path", "paths")
    patch(team_assignment, "choose_nearest", "paths")
    patch(repeated_auction, "choose_nearest", "paths")
    patch(Engine, "_sense", "sense")
    patch(engine_module, "exchange", "radio")
    patch(Engine, "_decide", "decide")
    patch(Engine, "move", "traffic")
    digest = hashlib.sha256()
    status = "out of budget"
    start = perf_counter()
    try:
        while True:
            events = engine.sense_and_decide(state, [])
            digest.update(np.array([action[:2] for action in events.actions], np.int64).tobytes())
            digest.update(
                repr([(m.sender, m.receiver, m.size_bytes) for m in events.said]).encode()
            )
            if state.covered[0] == state.n_observable:
                status = "done"
                break
            if state.finished.all() and not state.in_flight:
                status = "stuck"
                break
            if limit is not None and state.step >= limit:
                break
            engine.move(state, events.actions)
            if tell and state.step % 100 == 0:
                print(
                    f"    step {state.step}, {state.covered[0] / state.n_observable:.1%}, "
                    f"{perf_counter() - start:.0f} s",
                    file=sys.stderr,
                    flush=True,
                )
    finally:
        for where, attribute, before in reversed(patched):
            setattr(where, attribute, before)
    wall = perf_counter() - start
    rows = [row[:3] for row in mind.rounds.values() if row[3]]
    rounds = np.array(rows, np.float64).reshape(-1, 3) / 1e6
    return Played(status, state.step, digest.hexdigest()[:12], wall, rounds, clock)


COLUMNS = (
    "mean",
    "p50",
    "p99",
    "max",
    "fields mean",
    "fields p99",
    "paths mean",
    "paths p99",
    "rest mean",
    "rest p99",
)


def figures(rounds: np.ndarray) -> list[float]:
    """The numbers of one run in the order of `COLUMNS` [ms]."""
    if len(rounds) == 0:
        return [0.0] * len(COLUMNS)
    whole, fields, paths = rounds.T
    rest = whole - fields - paths
    return [
        float(number)
        for number in (
            whole.mean(),
            np.percentile(whole, 50),
            np.percentile(whole, 99),
            whole.max(),
            fields.mean(),
            np.percentile(fields, 99),
            paths.mean(),
            np.percentile(paths, 99),
            rest.mean(),
            np.percentile(rest, 99),
        )
    ]


def measure(grid: Any, name: str, repeat: int, warm: bool, **options: Any) -> dict[str, Any]:
    problem, _ = exploration_problem(grid, **options)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    if warm:
        play(problem, name, observable)
    runs = [play(problem, name, observable) for _ in range(repeat)]
    assert len({run.digest for run in runs}) == 1
    table = np.array([figures(run.rounds) for run in runs])
    return {
        "map": problem.plan.grid.name,
        "strategy": name,
        "status": runs[0].status,
        "steps": runs[0].steps,
        "rounds": len(runs[0].rounds),
        "fields": runs[0].clock.calls["fields"],
        "run": runs[0].digest,
        "wall_s": median(run.wall_s for run in runs),
        **{
            column: [median(values), min(values), max(values)]
            for column, values in zip(COLUMNS, table.T.tolist(), strict=True)
        },
    }


@kernel
def reference_work(table: NDArray[np.int32]) -> int:
    """A sum of 2^20 entries of a table of 2^20, in an order without a pattern for a cache."""
    mask = table.shape[0] - 1
    total = 0
    at = 1
    for _ in range(table.shape[0]):
        at = (at * 1664525 + 1013904223) & mask
        if table[at] & 1:
            total += table[at]
        else:
            total -= 1
    return total


def reference_work_in_python() -> int:
    """A sum over 50,000 turns of a loop with a table of 1,000 entries."""
    table = {index: index * index % 1009 for index in range(1000)}
    total = 0
    for index in range(50_000):
        total += table[index % 1000] if index & 1 else -len(str(index))
    return total


def calibration(repeat: int = 15) -> str:
    """What fixed work takes on this machine at this moment, in a line."""
    table = (np.arange(1 << 20, dtype=np.int64) * 48271 % 65537).astype(np.int32)
    reference_work(table)
    cells: list[str] = []
    for name, work in (
        ("compiled", lambda: reference_work(table)),
        ("Python", reference_work_in_python),
    ):
        took: list[float] = []
        for _ in range(repeat):
            start = now_ns()
            work()
            took.append((now_ns() - start) / 1e6)
        cells.append(f"{name} {median(took):.2f} ({min(took):.2f} to {max(took):.2f})")
    return f"Fixed work of reference: {', '.join(cells)} ms."


def print_head(first: str) -> None:
    print(f"{calibration()}\n")
    print(f"| {first} | steps | rounds | {' | '.join(COLUMNS)} | run |")
    print("|" + "---|" * (len(COLUMNS) + 4))


def print_row(first: str, row: dict[str, Any]) -> None:
    cells = []
    for column in COLUMNS:
        middle, low, high = row[column]
        spread = f" ({low:.2f} to {high:.2f})" if high > low else ""
        cells.append(f"{middle:.2f}{spread}")
    ended = "" if row["status"] == "done" else f" ({row['status']})"
    print(
        f"| {first} | {row['steps']:,}{ended} | {row['rounds']:,} | {' | '.join(cells)} "
        f"| {row['run']} |",
        flush=True,
    )


def built_in(name: str, side: int) -> OccupancyGrid:
    return conav.builtin_map(name, width_m=side * 0.1, height_m=side * 0.1, resolution=0.1)


def big(robots: int, side: int, names: Sequence[str], cell_m: float | None, strategy: str) -> None:
    """Whole runs of many robots on a large map, and where their time goes."""
    print(f"\n{calibration()}\n")
    for name in names:
        radius = 0.035 if cell_m is not None else 0.1
        options = {"robots": robots, "cell_m": cell_m, "radius_m": radius, "seed": 1}
        problem, _ = exploration_problem(built_in(name, side), **options)
        seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
        play(problem, strategy, seen, limit=3)  # loads the kernels
        run = play(problem, strategy, seen, tell=True)
        parts = ", ".join(
            f"{part} {run.clock.ns[part] / 1e9:.1f} s"
            for part in ("sense", "radio", "decide", "traffic")
        )
        print(
            f"{name}, {side} x {side} cells at 0.1 m, planning cells of "
            f"{problem.plan.lattice.cell_m:g} m, {robots} robots, {strategy}: {run.status} after "
            f"{run.steps:,} steps, {len(run.rounds):,} rounds, {run.wall_s:.1f} s: {parts}; "
            f"of decide, fields {run.clock.ns['fields'] / 1e9:.1f} s, "
            f"paths {run.clock.ns['paths'] / 1e9:.1f} s; run {run.digest}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*", help="map files; without, the built-in maps")
    parser.add_argument("--strategies", nargs="+", default=STRATEGIES)
    parser.add_argument(
        "--builtin", nargs="+", default=None, help="of the built-in maps only these"
    )
    parser.add_argument("--side", type=int, default=500, help="cells of a built-in map's side")
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--cell", type=float, default=None, help="planning cell [m], 0 the default")
    parser.add_argument("--cold", action="store_true", help="do not play each run once before")
    parser.add_argument("--json", type=Path, help="file for one line of JSON per row")
    parser.add_argument("--big", action="store_true")
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--cpu", action="store_true", help="processor time instead of the clock")
    given = parser.parse_args()
    if given.cpu:
        global now_ns
        now_ns = thread_time_ns
    cell_m = None if given.cell == 0 else given.cell

    def row(first: str, grid: Any, name: str, **options: Any) -> None:
        found = measure(grid, name, given.repeat, not given.cold, seed=1, **options)
        print_row(first, found)
        if given.json is not None:
            with given.json.open("a") as file:
                file.write(json.dumps(found | {"options": repr(options)}) + "\n")

    planning: dict[str, Any] = {"radius_m": 0.035, "cell_m": cell_m or 0.1}
    if given.cell == 0:
        planning = {"radius_m": 0.1, "cell_m": None}
    if given.all or not (given.big or given.growth):
        grids: list[tuple[str, Any]] = [(item, item) for item in given.maps]
        if given.all or not grids:
            names = given.builtin or MAPS
            grids = [(name, built_in(name, given.side)) for name in names] + grids
        for label, grid in grids:
            print(f"\n{label}, {given.robots} robots\n")
            print_head("strategy")
            options = dict(planning)
            if isinstance(grid, str):
                options["cell_m"] = cell_m or conav.read_map(Path(grid)).resolution
            for name in given.strategies:
                row(name, grid, name, robots=given.robots, **options)
    if given.all or given.growth:
        for name in given.strategies:
            print(f"\n{name} on the office\n")
            print_head("robots, side [cells], range [m]")
            cases = [(robots, 500, 7.0) for robots in (2, 8, 32, 64)]
            cases += [(8, side, 7.0) for side in (250, 1000)]
            cases += [(8, 500, range_m) for range_m in (3.5, 14.0)]
            for robots, side, range_m in cases:
                first = f"{robots}, {side}, {range_m:g}"
                row(
                    first,
                    built_in("office", side),
                    name,
                    robots=robots,
                    range_m=range_m,
                    **planning,
                )
    if given.all or given.big:
        strategy = given.strategies[0] if len(given.strategies) == 1 else "pocket-assignment"
        robots = 64 if given.robots == 8 else given.robots
        side = 1000 if given.side == 500 else given.side
        big(robots, side, given.builtin or ("office", "cave"), cell_m, strategy)


if __name__ == "__main__":
    main()
