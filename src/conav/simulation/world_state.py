"""Everything a run needs to go on: step it, pickle it, resume it."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import Belief
from conav.exploration.types import ExplorationProblem, Strategy
from conav.messages.message import Message


@dataclass(eq=False)
class Scan:
    """One look of one robot: where from, and the fine cells that were new to it."""

    cell: int  # planning cell, flat
    seen: NDArray[np.int32]  # flat fine indices


ACTIVE = 0
"""Condition of a robot that is in order."""
STALLED = 1
"""Of one that cannot move."""
DEAD = 2
"""Of one that is gone."""
ABSENT = 3
"""Of one that is not there yet."""


class Parcel(NamedTuple):
    """What one robot sends another in one message, where messages take time or may be lost."""

    due: int  # the step it arrives in
    sent: int
    sender: int
    receiver: int
    cell: int  # where the sender was
    held: NDArray[np.int32]  # (n,) scans it held then
    scans: tuple[tuple[int, int, int], ...]  # origin, scans before those sent, and after them
    wants: tuple[int, ...] = ()  # origins whose further scans it asks for


@dataclass(eq=False)
class Mail:
    """What robots know of each other and await, where messages take time or may be lost."""

    parcels: list[Parcel]  # under way, in the order they were sent
    news: list[dict[int, NDArray[np.int32]]]  # per robot, sender -> what it last said it held
    asked: NDArray[np.int32]  # (n, n) the step robot row last asked for robot column's scans


@dataclass(eq=False)
class WorldState:
    """The state of an exploration between two steps. The engine changes it in place.

    Knowledge is kept as scans. Robot r numbers its scans from 1; `held[i, r]` is how many of r's
    scans robot i holds, always the first ones, so two robots with equal rows hold equal beliefs and
    share one `Belief` object.
    """

    problem: ExplorationProblem
    strategy: Strategy
    step: int
    cells: NDArray[np.int32]  # (n,) planning cell of each robot
    headings: NDArray[np.int8]  # (n,) direction 0 to 3
    beliefs: list[Belief]  # (n,) shared where equal
    all_to_all: bool  # everybody tells everybody everything, always: see `radio_network`
    scans: list[list[Scan]]  # per robot, in order; none are kept where all tell all
    held: NDArray[np.int32]  # (n, n) scans of robot column held by robot row
    heard_cell: NDArray[np.int32]  # (n, n) where robot column was when robot row last heard it
    heard_step: NDArray[np.int32]  # (n, n) the step of that, -1 never
    must_look: NDArray[np.bool_]  # (n,) moved since its last scan
    memories: list[Any]
    started: list[bool]  # whether a mind has made its memory
    generators: list[np.random.Generator]
    in_flight: list[tuple[int, Message]]  # of minds, with the step they arrive in
    sensed_by: NDArray[np.uint8]  # (words, fine cells) a bit per robot: has seen that cell
    observable: NDArray[np.uint8]  # (fine rows, fine cols) what the team can observe
    n_observable: int
    sensed: NDArray[np.int64]  # (n,) observable cells each robot has seen itself
    discovered: NDArray[np.int64]  # (n,) observable cells each robot reported as new
    covered: NDArray[np.int64]  # (1,) observable cells the team has seen
    travelled: NDArray[np.float64]  # (n,) [cells]
    credit: NDArray[np.float64]  # (n,) [cells] of travel earned and not used
    finished: NDArray[np.bool_]  # (n,) its mind has nothing left to do
    quiet: NDArray[np.bool_]  # (n,) its radio is off in this step
    condition: NDArray[np.uint8]  # (n,) in order, stalled, dead or absent: see `conditions`
    on_since: NDArray[np.int32]  # (n,) the step it was switched on
    died_at: NDArray[np.int32]  # (n,) the step it died, -1 while it lives
    in_touch: NDArray[np.bool_]  # (n, n) whether robot row takes robot column to hear it
    mail: Mail  # under way between robots, where that takes time or may fail
    messages: int = 0
    bytes: int = 0
    decisions: list[Any] = field(default_factory=list)

    @property
    def n_robots(self) -> int:
        return len(self.problem.robots)

    @property
    def time_s(self) -> float:
        """Simulated time [s]."""
        return self.step * self.problem.step_s


def generator_for(seed: int, name: str) -> np.random.Generator:
    """The random generator of the one who bears this name in a run with this seed."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *name.encode()])))


def tells_all(problem: ExplorationProblem, strategy: Strategy) -> bool:
    """Whether everybody tells everybody everything in every step, so that no scans are kept."""
    return (
        problem.perfect_radio
        and not getattr(strategy, "may_be_quiet", False)
        and all(fault.kind == "stalls" for fault in problem.faults)
        and all(robot.energy_j is None for robot in problem.robots)
    )


def new_world(
    problem: ExplorationProblem, strategy: Strategy, observable: NDArray[np.uint8]
) -> WorldState:
    """The state before the first look."""
    n = len(problem.robots)
    plan = problem.plan
    belief = Belief(plan)
    fine = plan.walls.size
    late = [fault.robot for fault in problem.faults if fault.kind == "joins"]
    generators = [generator_for(problem.seed, robot.name) for robot in problem.robots]
    return WorldState(
        problem=problem,
        strategy=strategy,
        step=0,
        cells=np.array(problem.starts, dtype=np.int32),
        headings=np.array([int(rng.integers(4)) for rng in generators], dtype=np.int8),
        beliefs=[belief] * n,
        all_to_all=tells_all(problem, strategy),
        scans=[[] for _ in range(n)],
        held=np.zeros((n, n), dtype=np.int32),
        heard_cell=np.full((n, n), -1, dtype=np.int32),
        heard_step=np.full((n, n), -1, dtype=np.int32),
        must_look=np.ones(n, dtype=np.bool_),
        memories=[None] * n,
        started=[False] * n,
        generators=generators,
        in_flight=[],
        sensed_by=np.zeros(((n + 7) // 8, fine), dtype=np.uint8),
        observable=observable,
        n_observable=int(np.count_nonzero(observable)),
        sensed=np.zeros(n, dtype=np.int64),
        discovered=np.zeros(n, dtype=np.int64),
        covered=np.zeros(1, dtype=np.int64),
        travelled=np.zeros(n, dtype=np.float64),
        credit=np.zeros(n, dtype=np.float64),
        finished=np.zeros(n, dtype=np.bool_),
        quiet=np.zeros(n, dtype=np.bool_),
        condition=np.isin(np.arange(n), late).astype(np.uint8) * np.uint8(ABSENT),
        on_since=np.zeros(n, dtype=np.int32),
        died_at=np.full(n, -1, dtype=np.int32),
        in_touch=np.ones((n, n), dtype=np.bool_),
        mail=Mail(
            parcels=[],
            news=[{} for _ in range(n)],
            asked=np.full((n, n), -(2**30), dtype=np.int32),
        ),
    )
