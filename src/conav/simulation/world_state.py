"""Everything a run needs to go on: step it, pickle it, resume it."""

from dataclasses import dataclass, field
from typing import Any

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
    in_flight: list[Message]
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


def new_world(
    problem: ExplorationProblem, strategy: Strategy, observable: NDArray[np.uint8]
) -> WorldState:
    """The state before the first look."""
    n = len(problem.robots)
    plan = problem.plan
    belief = Belief(plan)
    fine = plan.walls.size
    generators = [generator_for(problem.seed, robot.name) for robot in problem.robots]
    return WorldState(
        problem=problem,
        strategy=strategy,
        step=0,
        cells=np.array(problem.starts, dtype=np.int32),
        headings=np.array([int(rng.integers(4)) for rng in generators], dtype=np.int8),
        beliefs=[belief] * n,
        all_to_all=problem.perfect_radio and not getattr(strategy, "may_be_quiet", False),
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
    )
