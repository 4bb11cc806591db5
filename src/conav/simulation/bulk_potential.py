"""Thousands of games of the potential-game family at once, for Monte-Carlo studies.

Plays exactly the games that `run_exploration` plays, step for step and draw for draw, in the world
of [Philip2014]: grid points, forward-turn motion, a disc sensor, robots that pass through each
other, and a radio that carries everything or nothing.

For every place the number of undiscovered points within range of it is kept up to date: a point
that is discovered lowers the numbers of the places around it, O(sRange^2) once per point. The gain
of a turn is then one number, that of the baseline one number and the 2 sRange + 1 points that the
second step adds, so a decision costs O(sRange) whatever the map, where (17) costs O(sRange^2).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.better_response import BetterResponse
from conav.exploration.potential import Potential
from conav.exploration.potential_1 import Potential1
from conav.exploration.potential_improved import PotentialImproved
from conav.exploration.types import ExplorationProblem
from conav.exploration.uncoordinated import Uncoordinated
from conav.exploration.uncoordinated_alone import UncoordinatedAlone
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import OCCUPIED
from conav.simulation.bulk_choice import best_of_four, better_of_four
from conav.simulation.bulk_improved import OFF_MAP, play_improved
from conav.simulation.bulk_random import (
    name_words,
    next_double,
    next_quarter,
    seed_generator,
)
from conav.simulation.observable import observable_cells

BulkStrategy = Potential1 | Potential | BetterResponse | PotentialImproved | Uncoordinated


@dataclass(frozen=True)
class BulkGames:
    """The outcome of games; the first index of every array is the game."""

    covered: NDArray[np.uint32]  # (games, steps + 1) observable cells seen by the team
    observable: int
    decisions: NDArray[np.int64]  # (games,) decisions of all robots
    turns: NDArray[np.int64]  # (games,) turn sequences played
    free_steps: NDArray[np.int64]  # (games,) robot-steps not bound to the second step of a sequence
    discovered: NDArray[np.int64]  # (games, robots) size of each robot's own set, discPts_i
    left_out: NDArray[np.int64]  # (games,) cells seen and in nobody's set at the end (section 4)
    cells: NDArray[np.int32]  # (games, steps + 1, robots) planning cells, or (games, 0, robots)
    headings: NDArray[np.int8]  # the same of headings

    def time_to(self, share: float) -> NDArray[np.float64]:
        """The first step at which that share of the cells was seen, inf where never, (games,)."""
        # Shares such as 0.55 are no floats: without slack 55 of 100 cells would not be enough.
        enough = self.covered >= share * self.observable - 1e-6
        first = enough.argmax(axis=1).astype(np.float64)
        first[~enough.any(axis=1)] = np.inf
        return first


def play_games(
    problem: ExplorationProblem,
    strategy: BulkStrategy,
    seeds: Sequence[int],
    steps: int,
    *,
    trace: bool = False,
) -> BulkGames:
    """The games of these seeds, each of so many steps, from the problem's starts.

    The problem's own seed and time limit are not used, and a game goes on when all is seen. With
    `trace` every robot's cell and heading at every step is kept. Raises `ValueError` for a problem
    of another kind than the module describes.
    """
    _check(problem, strategy)
    if any(seed != int(seed) or not 0 <= seed < 2**64 for seed in seeds):
        raise ValueError("seeds are whole numbers from 0 to 2**64 - 1")
    plan = problem.plan
    rows, cols = plan.moves.shape
    sensor = problem.robots[0].sensor
    limits = lateral_limits(min(sensor.range_m / plan.lattice.resolution, rows + cols))
    free = observable_cells(plan, problem.starts, sensor)
    n = len(problem.robots)
    kept = steps + 1 if trace else 0
    games = BulkGames(
        covered=np.zeros((len(seeds), steps + 1), dtype=np.uint32),
        observable=int(np.count_nonzero(free)),
        decisions=np.zeros(len(seeds), dtype=np.int64),
        turns=np.zeros(len(seeds), dtype=np.int64),
        free_steps=np.zeros(len(seeds), dtype=np.int64),
        discovered=np.zeros((len(seeds), n), dtype=np.int64),
        left_out=np.zeros(len(seeds), dtype=np.int64),
        cells=np.zeros((len(seeds), kept, n), dtype=np.int32),
        headings=np.zeros((len(seeds), kept, n), dtype=np.int8),
    )
    shape = disc_shape(limits, cols)
    game = (
        np.array(seeds, dtype=np.uint64),
        name_words([robot.name for robot in problem.robots]),
        np.array(problem.starts, dtype=np.int64),
        padded(plan.walls == OCCUPIED, shape.pad, OFF_MAP),
        padded(free, shape.pad, 0),
    )
    tallies = (
        games.covered,
        games.decisions,
        games.turns,
        games.free_steps,
        games.discovered,
    )
    traces = (games.cells, games.headings)
    rule = _rule(strategy)
    if isinstance(strategy, PotentialImproved):
        signed = (shape.disc.view(np.int64), shape.crescent.view(np.int64))
        play_improved(
            *game,
            limits,
            shape.pad,
            shape.width,
            *signed,
            cols,
            steps,
            rule.epsilon,
            rule.baseline_wins,
            rule.per_sequence,
            *tallies,
            games.left_out,
            *traces,
        )
    else:
        shared = problem.robots[0].radio.range_m is None
        _play(*game, *shape, cols, steps, *rule, shared, *tallies, *traces)
    return games


def _check(problem: ExplorationProblem, strategy: object) -> None:
    """Raise `ValueError` unless this problem and strategy can be played here."""
    robots = problem.robots
    lattice = problem.plan.lattice
    # A subclass may do something else.
    if type(strategy) not in (*get_args(BulkStrategy), UncoordinatedAlone):
        raise ValueError(f"{type(strategy).__name__} is no strategy of potential games for bulk")
    if lattice.ratio != 1.0 or problem.plan.radius_fine >= 0.5:
        raise ValueError("games in bulk need planning cells as large as the map's, and a robot")
    if problem.traffic != "none" or robots[0].sensor.occlusion:
        raise ValueError("games in bulk need traffic none and the disc sensor")
    if not robots[0].motion.turn_costs_step or robots[0].sensor.range_m < lattice.resolution:
        raise ValueError("games in bulk need motion forward-turn and a range of a cell or more")
    if any(replace(robot, name=robots[0].name) != robots[0] for robot in robots):
        raise ValueError("games in bulk need robots that differ in nothing but their names")
    if robots[0].radio.range_m not in (None, 0.0):
        raise ValueError("games in bulk need a radio that is perfect or off")
    if isinstance(strategy, PotentialImproved) and robots[0].radio.range_m is not None:
        raise ValueError("the improved algorithm in bulk needs the perfect radio")


class _Rule(NamedTuple):
    epsilon: float
    baseline_wins: bool  # ties
    per_sequence: bool  # epsilon is drawn
    turns_at_obstacles: bool
    better: bool  # one random sequence if it is better, instead of the best


def _rule(strategy: BulkStrategy) -> _Rule:
    """What tells the strategies apart."""
    if isinstance(strategy, Uncoordinated):
        strategy = Potential(epsilon=1.0, tie=strategy.tie)
    better = isinstance(strategy, BetterResponse)
    return _Rule(
        strategy.epsilon,
        not better and strategy.tie == "baseline",
        strategy.draw == "sequence",
        not isinstance(strategy, Potential1),
        better,
    )


class DiscShape(NamedTuple):
    """A disc of points as steps through the flat map with `pad` more points on each side.

    Steps are unsigned and wrap around where they go back: compiled code tests a signed index for
    being negative at every use.
    """

    pad: int
    width: int  # of the padded map
    disc: NDArray[np.uint64]  # (points in a disc,) from its centre, which comes first
    crescent: NDArray[np.uint64]  # (4, 2 reach + 1) those one step in a direction has added


def disc_shape(limits: NDArray[np.int32], cols: int) -> DiscShape:
    """The disc of a sensor with these lateral limits on a map of so many columns."""
    reach = len(limits) - 1
    pad = reach + 2
    width = cols + 2 * pad
    points = [
        (r, c)
        for r in range(-reach, reach + 1)
        for c in range(-int(limits[abs(r)]), int(limits[abs(r)]) + 1)
    ]
    points.sort(key=lambda point: point != (0, 0))
    inside = set(points)
    crescent = [
        [r * width + c for r, c in points if (r + DROW[k], c + DCOL[k]) not in inside]
        for k in range(4)
    ]
    return DiscShape(
        pad,
        width,
        np.array([r * width + c for r, c in points], dtype=np.int64).view(np.uint64),
        np.array(crescent, dtype=np.int64).view(np.uint64),
    )


def padded(cells: NDArray[Any], pad: int, value: int) -> NDArray[np.uint8]:
    """A map with so many more rows and columns of a value around it, made flat."""
    return np.pad(cells.astype(np.uint8), pad, constant_values=value).reshape(-1)


@kernel
def _play(
    seeds: NDArray[np.uint64],
    names: NDArray[np.uint64],
    starts: NDArray[np.int64],
    walls: NDArray[np.uint8],
    free: NDArray[np.uint8],
    pad: int,
    width: int,
    disc: NDArray[np.uint64],
    crescent: NDArray[np.uint64],
    cols: int,
    steps: int,
    epsilon: float,
    baseline_wins: bool,
    per_sequence: bool,
    turns_at_obstacles: bool,
    better: bool,
    shared: bool,
    covered: NDArray[np.uint32],
    decisions: NDArray[np.int64],
    turns: NDArray[np.int64],
    free_steps: NDArray[np.int64],
    discovered: NDArray[np.int64],
    trace: NDArray[np.int32],
    faced: NDArray[np.int8],
) -> None:
    n = names.shape[0]
    size = walls.shape[0]
    sets = 1 if shared else n
    thin = crescent.shape[1]
    ahead_of = np.array([1, width, -1, -width]).astype(np.uint64)
    mine = np.array([i * size for i in range(n)]).astype(np.uint64)
    begin = np.array([0 if shared else i * size for i in range(n)]).astype(np.uint64)
    # What is unknown at the beginning of a game: all points of the map, per set of knowledge.
    fresh = np.zeros(sets * size, dtype=np.uint8)
    around = np.zeros(sets * size, dtype=np.int32)
    for q in range(size):
        if walls[q] != OFF_MAP:
            for k in range(sets):
                fresh[k * size + q] = 1
                for j in range(disc.shape[0]):
                    around[np.uint64(k * size + q) + disc[j]] += 1
    unknown = np.zeros(sets * size, dtype=np.uint8)
    left = np.zeros(sets * size, dtype=np.int32)  # unknown points within range of each place
    seen = np.zeros(size, dtype=np.uint8)  # by the team
    own = np.zeros(n * size, dtype=np.uint8)  # discPts_i
    states = np.zeros((n, 4), dtype=np.uint64)
    at = np.zeros(n, dtype=np.uint64)
    heading = np.zeros(n, dtype=np.int64)
    bound = np.zeros(n, dtype=np.uint8)
    moved = np.zeros(n, dtype=np.uint8)
    for game in range(seeds.shape[0]):
        unknown[:] = fresh
        left[:] = around
        seen[:] = 0
        own[:] = 0
        total = 0
        made = 0
        turned = 0
        unbound = 0
        for i in range(n):
            seed_generator(seeds[game], names[i], states, i)
            heading[i] = next_quarter(states, i)
            at[i] = (starts[i] // cols + pad) * width + starts[i] % cols + pad
            bound[i] = 0
            moved[i] = 1
        for step in range(steps + 1):
            # Sense: own sets against what all had discovered before, then the common one. After
            # the first look only what the last move has added can be new.
            anything = False
            for i in range(n):
                if moved[i] == 1:
                    here = at[i]
                    of = begin[i]
                    if left[of + here] == 0:
                        moved[i] = 0
                        continue
                    anything = True
                    for j in range(disc.shape[0] if step == 0 else thin):
                        p = here + (disc[j] if step == 0 else crescent[heading[i], j])
                        own[mine[i] + p] |= unknown[of + p]
            if anything:
                for i in range(n):
                    if moved[i] == 0:
                        continue
                    of = begin[i]
                    for j in range(disc.shape[0] if step == 0 else thin):
                        p = at[i] + (disc[j] if step == 0 else crescent[heading[i], j])
                        if unknown[of + p] == 1:
                            unknown[of + p] = 0
                            for m in range(disc.shape[0]):
                                left[of + p + disc[m]] -= 1
                            if seen[p] == 0:
                                seen[p] = 1
                                total += free[p]
            covered[game, step] = total
            if trace.shape[1] > 0:
                for i in range(n):
                    place = int(at[i])
                    trace[game, step, i] = (place // width - pad) * cols + place % width - pad
                    faced[game, step, i] = heading[i]
            if step == steps:
                break
            # Decide and move: nobody's decision depends on another's move of this step.
            for i in range(n):
                moved[i] = 0
                forward = ahead_of[heading[i]]
                ahead = walls[at[i] + forward] == 0
                held = bound[i] == 1 and ahead
                bound[i] = 0
                if held:
                    at[i] += forward
                    moved[i] = 1
                    continue
                unbound += 1
                forced = turns_at_obstacles and not ahead
                turn = 0
                if forced or (step > 0 and next_double(states, i) < epsilon):
                    made += 1
                    of = begin[i]
                    here = at[i]
                    leftward = ahead_of[(heading[i] + 1) & 3]
                    gain0 = -1
                    if ahead and not forced:
                        gain0 = int(left[of + here + forward])
                        second = here + forward + forward
                        # The second move counts unless an obstacle is known to be there.
                        if left[of + second] > 0 and (
                            walls[second] == 0 or (walls[second] == 1 and unknown[of + second] == 1)
                        ):
                            for j in range(thin):
                                gain0 += int(unknown[of + second + crescent[heading[i], j]])
                    p = here + leftward
                    gain1 = int(left[of + p]) if walls[p] == 0 else -1
                    p = here - forward
                    gain2 = int(left[of + p]) if walls[p] == 0 else -1
                    p = here - leftward
                    gain3 = int(left[of + p]) if walls[p] == 0 else -1
                    if better and not forced:
                        turn = better_of_four(gain0, gain1, gain2, gain3, states, i)
                    else:
                        turn = best_of_four(gain0, gain1, gain2, gain3, baseline_wins, states, i)
                goes = turn == 0 and ahead
                at[i] += forward if goes else np.uint64(0)
                moved[i] = 1 if goes else 0
                turned += 1 if turn > 0 else 0
                heading[i] = (heading[i] + max(turn, 0)) & 3
                bound[i] = 1 if turn > 0 or (turn == 0 and per_sequence) else 0
        for i in range(n):
            discovered[game, i] = own[i * size : (i + 1) * size].sum()
        decisions[game] = made
        turns[game] = turned
        free_steps[game] = unbound
