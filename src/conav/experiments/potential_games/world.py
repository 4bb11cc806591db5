"""The world of [Philip2014] as far as the paper tells it, and games in it.

Told: three robots, three obstacles, a square grid of points, four headings, a sensor without
occlusion. Not told: the size of the grid, where the obstacles are and where robots start. Here: 40
x 40 points, 20 and more layouts of three rectangles, starts side by side in a corner.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import Belief, new_scratch
from conav.exploration.catalogue import make_strategy
from conav.exploration.marginal_contribution import (
    BOUND,
    GameMemory,
    first_sequence,
    joint_points,
    regrets,
)
from conav.exploration.types import ExplorationProblem, TeamView
from conav.simulation.bulk_potential import BulkStrategy, play_games
from conav.simulation.bulk_replay import replay
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world

STARTS = ((1.5, 1.5), (2.5, 1.5), (1.5, 2.5))  # [m] points (1, 1), (2, 1) and (1, 2)
SIDE = 40  # points
ROBOTS = len(STARTS)
SEEDS = 100_000  # apart: so many games of a layout have seeds of their own
STEPS = 8000
"""The cap of a game. What is not finished by then counts as taking this long, and is reported."""


@dataclass(frozen=True)
class Team:
    """A strategy with its settings, and what it is called in tables."""

    label: str
    strategy: str
    settings: tuple[tuple[str, Any], ...] = ()
    s_range: int = 2
    traffic: str = "none"
    radio_m: float | None = None  # [m], None as the strategy is made for

    def make(self) -> BulkStrategy:
        """The strategy."""
        return cast("BulkStrategy", make_strategy(self.strategy, dict(self.settings)))


def team(label: str, strategy: str, s_range: int = 2, **settings: Any) -> Team:
    """A team with these settings of its strategy."""
    return Team(label, strategy, tuple(sorted(settings.items())), s_range)


class Played(NamedTuple):
    """The games of one team in one layout."""

    observable: int
    coverage: NDArray[np.float64]  # (steps + 1,) mean share seen
    times: NDArray[np.float64]  # (games, 4) steps to 90, 95, 99 and 100 percent, inf for never
    decisions: float  # per robot-step
    turns: float  # turn sequences per robot-step in which a robot is free to choose
    left_out: float  # share of the points in nobody's set at the end
    overlap: NDArray[np.float64]  # (steps + 1,) mean share of what is in range that several have
    sensed: NDArray[np.float64]  # (steps + 1,) mean of what each saw, added up, over what all saw
    equilibria: float  # share of the steps until all is seen in which nobody had regret


SHARES = (0.90, 0.95, 0.99, 1.0)


@lru_cache(maxsize=64)
def world(layout: int, s_range: int, traffic: str, radio: str | float) -> ExplorationProblem:
    """A layout for a sensor range; the same for every seed of robots."""
    problem, _ = exploration_problem(
        "three-obstacles",
        robots=ROBOTS,
        range_m=float(s_range),
        cell_m=1.0,
        speed_mps=1.0,
        motion="forward-turn",
        sensor="disc",
        radio=radio,
        traffic=traffic,
        starts=STARTS,
        seed=layout,
        max_time_s=float(STEPS),
    )
    return problem


def problem_of(players: Team, layout: int) -> ExplorationProblem:
    """The layout as this team meets it."""
    radio = getattr(players.make(), "radio", "perfect")
    if players.radio_m is not None:
        radio = players.radio_m
    return world(layout, players.s_range, players.traffic, radio)


def seeds_of(layout: int, games: int) -> Sequence[int]:
    """The seeds of the games of a layout, none of them another layout's."""
    return range(layout * SEEDS, layout * SEEDS + games)


def play(players: Team, layout: int, games: int, steps: int, traced: bool) -> Played:
    """So many games in bulk; `traced` measures overlap and equilibria, and needs more memory."""
    problem = problem_of(players, layout)
    done = play_games(problem, players.make(), seeds_of(layout, games), steps, trace=traced)
    times = np.stack([done.time_to(share) for share in SHARES], axis=1)
    overlap = sensed = np.zeros(0)
    equilibria = float("nan")
    if traced:
        again = replay(problem, done)
        overlap = again.overlap.mean(axis=0, dtype=np.float64)
        sensed = (again.sensed / np.maximum(done.covered, 1) - 1.0).mean(axis=0)
        open_steps = np.arange(steps + 1) < np.minimum(times[:, 3:], steps)
        equilibria = float((again.regret == 0)[open_steps].mean())
    robot_steps = games * steps * ROBOTS
    return Played(
        done.observable,
        done.covered.mean(axis=0) / done.observable,
        times,
        float(done.decisions.sum()) / robot_steps,
        float(done.turns.sum()) / max(float(done.free_steps.sum()), 1.0),
        float(done.left_out.mean()) / done.observable,
        overlap,
        sensed,
        equilibria,
    )


class Simulated(NamedTuple):
    """One game by the ordinary simulator."""

    times: NDArray[np.float64]  # (4,) as in `Played`
    messages: float  # per robot-step
    bytes: float  # per robot-step
    points: float  # looked at for decisions, per robot-step
    regret: float  # mean over robot-steps of what a robot could have gained, by what all saw
    regretful: float  # share of the robot-steps with such a regret


def simulate(players: Team, layout: int, game: int, steps: int) -> Simulated:
    """One game by the ordinary simulator, to its end or so many steps.

    Regret is measured for the strategy of marginal contributions, against everything the robots
    have seen together.
    """
    problem = replace(problem_of(players, layout), seed=seeds_of(layout, game + 1)[game])
    strategy = players.make()
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, observable)
    engine = engine_for(state)
    known = Belief(problem.plan)
    scratch = new_scratch(problem.plan)
    covered: list[int] = []
    regret = 0
    regretful = 0
    playing = players.strategy == "marginal-contribution"
    while True:
        events = engine.sense_and_decide(state, [])
        covered.append(int(state.covered[0]))
        if playing:
            for scan in events.scans:
                if scan is not None:
                    known.hear(problem.plan, scan.cell, scan.seen, scratch)
            found = _team_regrets(state, known)
            regret += int(found.sum())
            regretful += int((found > 0).sum())
        if covered[-1] == state.n_observable or state.step >= steps:
            break
        engine.move(state, events.actions)
    counts = np.array(covered)
    times = [
        float(np.argmax(counts >= share * state.n_observable))
        if counts[-1] >= share * state.n_observable
        else np.inf
        for share in SHARES
    ]
    robot_steps = len(covered) * ROBOTS
    points = sum(int(getattr(memory, "points_checked", 0)) for memory in state.memories)
    return Simulated(
        np.array(times),
        state.messages / robot_steps,
        state.bytes / robot_steps,
        points / robot_steps,
        regret / robot_steps,
        regretful / robot_steps,
    )


def _team_regrets(state: WorldState, known: Belief) -> NDArray[np.int64]:
    """What each robot could gain by another sequence, by all that was seen."""
    problem = state.problem
    lattice = problem.plan.lattice
    players: list[tuple[int, int, int]] = []
    for robot, memory in enumerate(cast("list[GameMemory]", state.memories)):
        players.append((int(state.cells[robot]), int(state.headings[robot]), memory.sequence))
    never = np.full(len(players), -1, dtype=np.int32)
    nobody = np.zeros(len(players), dtype=np.bool_)
    view = TeamView(
        state.step, state.time_s, 0, problem.robots[0], 0, 0, known, lattice, never, never, nobody
    )
    profile = np.array([first_sequence(sequence) for _, _, sequence in players])
    found = regrets(*joint_points(view, players), profile)
    # A robot in mid-turn has no choice.
    found[[sequence == BOUND for _, _, sequence in players]] = 0
    return found


def settings_text(settings: Mapping[str, Any] | tuple[tuple[str, Any], ...]) -> str:
    """The settings as one text for tables."""
    return " ".join(f"{name}={value}" for name, value in dict(settings).items())
