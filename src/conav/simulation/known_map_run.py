"""Runs of a team that knows the map: what they take, nobody need take longer.

The routes of `conav.exploration.bounds.known_map_plan` are driven by the simulation itself,
meetings included, so that an upper bound on the optimum is the time of a real run.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.exploration.bounds.bounds import cells_needed
from conav.exploration.bounds.known_map_plan import known_map_plan
from conav.exploration.types import Action, ExplorationProblem, TeamView
from conav.geometry.directions import DCOL, DROW, STAY, STRAIGHT
from conav.geometry.grid_search import path_to, search, search_space
from conav.messages.message import Message
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import ExplorationResult, run_exploration
from conav.simulation.world_state import generator_for

KNOWN_MAP = "known-map"


@dataclass
class FollowerMemory:
    """How far a robot has come."""

    at: int = 0  # entry of the route it was at last


@dataclass(frozen=True, eq=False)
class KnownMapFollower:
    """Robots drive along given routes and come back to them where others push them off.

    Not a strategy of the catalogue: it holds the true map.
    """

    routes: tuple[tuple[int, ...], ...]  # per robot the planning cells to pass, the start first
    moves: NDArray[np.uint8]  # (rows, cols) the true moves

    def start(self, view: TeamView, rng: np.random.Generator) -> FollowerMemory:
        return FollowerMemory()

    def step(
        self,
        memory: FollowerMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[FollowerMemory, Action, Sequence[Message]]:
        route = self.routes[view.robot]
        if memory.at + 1 < len(route) and view.cell == route[memory.at + 1]:
            memory.at += 1
        if memory.at + 1 == len(route):
            return memory, Action(finished=True), ()
        following = route[memory.at + 1]
        # A robot may only go where it has seen that it can. A sensor that does not reach to the
        # end of a diagonal shows its two straight moves one after the other.
        for moves in (view.belief.moves, self.moves & np.uint8(STRAIGHT), self.moves):
            direction = _towards(moves, view.cell, following)
            if direction != STAY and view.belief.moves.item(view.cell) & (1 << direction):
                return memory, Action(direction, following), ()
        return memory, Action(STAY, following), ()


def _towards(moves: NDArray[np.uint8], cell: int, goal: int) -> int:
    """The first direction of a shortest way from a cell to another, `STAY` where there is none."""
    cols = moves.shape[1]
    for k in range(8):
        if moves.item(cell) & (1 << k) and cell + DROW[k] * cols + DCOL[k] == goal:
            return k
    goals = np.zeros(moves.shape, dtype=np.uint8)
    goals.reshape(-1)[goal] = 1
    space = search_space(moves.size)
    if search(moves, cell, goals, 1, space) < 0:
        return STAY
    path, length = path_to(space, cols, goal)
    return int(path[length - 1])


def known_map_run(
    problem: ExplorationProblem, share: float = 1.0, *, rounds: int = 150
) -> ExplorationResult | None:
    """A run of a team that knows the map and wants to see a share of it; None without a plan.

    `rounds` is how often the plan is changed in search of a better one. The plan's randomness comes
    from the problem's seed.
    """
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    needed = cells_needed(share, int(np.count_nonzero(observable)))
    rng = generator_for(problem.seed, "known map")
    plan = known_map_plan(problem, observable, needed, rng, rounds=rounds)
    if plan is None:
        return None
    follower = KnownMapFollower(plan.routes, problem.plan.moves)
    return run_exploration(problem, follower, name=KNOWN_MAP)
