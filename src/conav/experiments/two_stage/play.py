"""One run, watched: what is measured of it that a run does not report itself."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import Any

import numpy as np

from conav.experiments.two_stage.drift import Drift, replay
from conav.experiments.two_stage.paths import Path, changes, lengths, spread, stretches, turns_of
from conav.experiments.two_stage.world import RANGE_M, Case, World, problem_of, strategy_of
from conav.exploration.auction_protocol import Bids
from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.repeated_auction import AuctionMemory
from conav.exploration.section_auction import Bid
from conav.exploration.team_assignment import TeamMemory
from conav.exploration.two_stage_flow import STAGE, Phase
from conav.exploration.two_stage_turn import TwoStageMemory
from conav.exploration.types import Action, ExplorationProblem, Strategy, TeamView
from conav.messages.message import Message
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import ExplorationResult, run_exploration
from conav.simulation.world_state import WorldState, generator_for

DRIFT = Drift()


@dataclass(frozen=True)
class Played:
    """What is kept of a run; team totals where nothing else is said, times simulated."""

    status: str
    time_s: float
    bound_s: float  # certified: no team from these starts is done before
    path_m: float
    balance: float  # spread of the robots' shares of the path
    balance_first: float | None  # the same of what each drove in stage 1; None without stages
    second_s: float | None  # when the last robot changed to stage 2
    still: float  # share of the robots' time they stood still
    targets: int  # that were set out for
    tasks: int  # the same, a rectangle counted as one
    stretches: int  # local maps no larger than the sensor's range
    turns: int
    turned: float  # [rad]
    rounds: int  # of task assignment
    bids: int  # values sent by bidders
    messages: int  # sent by minds
    bytes: int
    closures_own: int
    closures_shared: int
    error_none_m: float  # root mean square over robots of the final error of position
    error_own_m: float
    error_shared_m: float
    mean_none_m: float  # the same over all steps
    mean_own_m: float
    mean_shared_m: float

    @staticmethod
    def read(content: dict[str, Any]) -> "Played":
        """What was kept. Raises `TypeError` for what is none."""
        if set(content) != {item.name for item in fields(Played)}:
            raise TypeError("no run of this reproduction")
        return Played(**content)


@dataclass
class Watched:
    """A strategy, and a count of what its robots say."""

    strategy: Strategy
    bids: int = 0
    messages: int = 0
    bytes: int = 0

    def start(self, view: TeamView, rng: np.random.Generator) -> Any:
        return self.strategy.start(view, rng)

    def step(
        self, memory: Any, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[Any, Action, Sequence[Message]]:
        memory, action, said = self.strategy.step(memory, view, inbox, rng)
        for message in said:
            self.messages += 1
            self.bytes += message.size_bytes
            if isinstance(message.body, Bid):
                self.bids += 1
            elif isinstance(message.body, Bids):
                self.bids += len(message.body.costs)
        return memory, action, said


def target_of(memory: Any) -> Hashable:
    """What a robot drives to now: a frontier, or the end of an edge of its rectangle; or None."""
    if not isinstance(memory, TwoStageMemory):
        return _frontier_of(memory)
    rectangle = memory.rectangle
    if memory.phase in (Phase.FIRST, Phase.SCAN) and rectangle is not None:
        return "edge", memory.rectangles, rectangle.leg
    if memory.phase is Phase.APPROACH and memory.goal_lane is not None:
        return "lane", memory.rectangles, memory.goal_lane[0]
    return _cell(memory.rest.goal) if memory.phase is Phase.REST else None


def task_of(memory: Any) -> Hashable:
    """What a robot is at now: a frontier, or a whole rectangle with the way to it; or None."""
    if not isinstance(memory, TwoStageMemory):
        return _frontier_of(memory)
    if memory.phase in (Phase.FIRST, Phase.APPROACH, Phase.SCAN):
        return "rectangle", memory.rectangles
    return _cell(memory.rest.goal) if memory.phase is Phase.REST else None


def _frontier_of(memory: AuctionMemory | TeamMemory) -> Hashable:
    return _cell(memory.drive.goal)


def _cell(goal: int) -> Hashable:
    return ("cell", goal) if goal >= 0 else None


def rounds_of(memory: Any) -> int:
    """How many assignments a robot has made: sections sold, auctions held, or teams assigned."""
    return memory.assignments if isinstance(memory, TeamMemory) else memory.auctions


@dataclass
class Track:
    """What is seen of a run step by step."""

    cells: list[list[int]] = field(default_factory=list[list[int]])
    targets: list[list[Hashable]] = field(default_factory=list[list[Hashable]])
    tasks: list[list[Hashable]] = field(default_factory=list[list[Hashable]])
    second: dict[int, int] = field(default_factory=dict[int, int])  # robot -> step of stage 2
    board: tuple[int, int, tuple[tuple[int, int], ...]] | None = None
    """When all are in stage 2: the step, the axis, and the sections nobody has scanned."""
    rounds: int = 0

    def see(self, state: WorldState) -> None:
        """Note what there is to see after the decisions of a step."""
        memories = state.memories
        self.cells.append(state.cells.tolist())
        self.targets.append([target_of(memory) for memory in memories])
        self.tasks.append([task_of(memory) for memory in memories])
        self.rounds = sum(rounds_of(memory) for memory in memories)
        for robot, memory in enumerate(memories):
            if isinstance(memory, TwoStageMemory) and STAGE[memory.phase] == 2:
                self.second.setdefault(robot, state.step)
        if self.board is None and len(self.second) == len(memories):
            board = memories[0].board
            left = tuple(board.unscanned(0, board.size - 1))
            self.board = state.step, board.axis, left

    def paths(self, problem: ExplorationProblem) -> list[Path]:
        """Where each robot was at each step [m]."""
        lattice = problem.plan.lattice
        row, col = np.divmod(np.array(self.cells), lattice.cols)
        places = np.stack([col + 0.5, row + 0.5], axis=2) * lattice.cell_m
        return [places[:, robot] for robot in range(places.shape[1])]


def watch(case: Case, world: World) -> tuple[ExplorationProblem, ExplorationResult, Track, Watched]:
    """A case played to its end, and what was seen. An interrupt from the keyboard goes through."""
    problem = problem_of(case.robots, case.seed, world)
    track, mind = Track(), Watched(strategy_of(case))
    result = run_exploration(problem, mind, name=case.method, progress=track.see)
    if result.interrupted:
        raise KeyboardInterrupt
    return problem, result, track, mind


def play(case: Case, world: World) -> Played:
    """What is kept of a case."""
    problem, result, track, mind = watch(case, world)
    paths = track.paths(problem)
    turns = [turns_of(path) for path in paths]
    driven = [lengths(path) for path in paths]
    steps = len(track.cells) - 1
    first = [float(driven[robot][track.second.get(robot, steps)]) for robot in range(case.robots)]
    staged = case.method == "TSCA"
    moves = sum(int(np.count_nonzero(np.diff(path, axis=0).any(axis=1))) for path in paths)
    drifted = {
        closing: replay(
            paths,
            problem.step_s,
            DRIFT,
            [generator_for(case.seed, f"drift of {robot.name}") for robot in problem.robots],
            closing=closing,
        )
        for closing in ("none", "own", "shared")
    }
    return Played(
        status=str(result.status),
        time_s=result.metrics.time_s,
        bound_s=bound_of(case.robots, case.seed, world),
        path_m=round(sum(turn.length_m for turn in turns), 9),
        balance=spread([turn.length_m for turn in turns]),
        balance_first=spread(first) if staged else None,
        second_s=max(track.second.values()) * problem.step_s
        if staged and len(track.second) == case.robots
        else None,
        still=1.0 - moves / max(steps * case.robots, 1),
        targets=sum(changes(keys) for keys in zip(*track.targets, strict=True)),
        tasks=sum(changes(keys) for keys in zip(*track.tasks, strict=True)),
        stretches=sum(stretches(path, RANGE_M) for path in paths),
        turns=sum(turn.count for turn in turns),
        turned=sum(turn.angle for turn in turns),
        rounds=track.rounds,
        bids=mind.bids,
        messages=mind.messages,
        bytes=mind.bytes,
        closures_own=drifted["own"].closures,
        closures_shared=drifted["shared"].closures,
        error_none_m=drifted["none"].final_m,
        error_own_m=drifted["own"].final_m,
        error_shared_m=drifted["shared"].final_m,
        mean_none_m=drifted["none"].mean_m,
        mean_own_m=drifted["own"].mean_m,
        mean_shared_m=drifted["shared"].mean_m,
    )


@lru_cache(maxsize=64)
def bound_of(robots: int, seed: int, world: World) -> float:
    """The certified lower bound on the time of any team from these starts [s]."""
    problem = problem_of(robots, seed, world)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return lower_bounds(problem, observable, witnesses=0).lower_s
