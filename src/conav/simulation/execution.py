"""Robots drive a plan, not quite: they start late, and are never quite where they should be.

Each robot hears the plan, or has its clock, up to `delay_s` late: at time t it wants to be where
the plan has it at t - lag, with one lag for the whole run; until then it waits at its start. It is
off by an error that is never longer than `tracking_error_m`: at every half second a vector drawn
from the disc of that radius, between them straight, from none at time 0. Bounded errors of both
kinds are what a margin is for (the paper plans strongly feasible paths, which keep a distance delta
[Zhu2014]).

A margin of `safe_margin` makes touching impossible. Robots i and j are p_i(t - a) + e and
p_j(t - b) + f, say a >= b. At the plan's time t - a both are there, r_i + r_j + margin apart. Since
then j has gone (a - b) v_j at most, and the errors take two more bounds away. The same holds before
the starts and after arrivals, as clamping a time to a robot's stay moves it no farther.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import isfinite, sqrt

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.piece import state_on_piece
from conav.planning.plan_summary import TOLERANCE_M, Nearest, pair_clearances
from conav.planning.trajectory import polyline, straight
from conav.planning.types import PIECE, PlanningProblem, PlanningRobot, Trajectory
from conav.simulation.world_state import generator_for

KNOT_S = 0.5  # [s] between two draws of an error
CHORD = 0.05  # of the error's bound: what a curve may be off when it is driven in straight pieces
ROUNDING_M = 1e-9  # [m] of overlap that is none


@dataclass(frozen=True, eq=False)
class Disturbance:
    """What a robot's run has against it: a lag, and an error at times 0, KNOT_S, 2 KNOT_S, ..."""

    lag_s: float
    errors: NDArray[np.float64]  # (n, 2) [m]; the last holds on


@dataclass(frozen=True)
class WallTouch:
    """A robot that overlaps a wall or an obstacle, by so much [m]."""

    robot: int
    depth_m: float


@dataclass(frozen=True, eq=False)
class Execution:
    """What was driven. `problem` has the robots as they are: smaller than planned by the slack."""

    problem: PlanningProblem
    planned: tuple[Trajectory | None, ...]
    driven: tuple[Trajectory | None, ...]
    tracking_error_m: float
    delay_s: float
    slack_m: float
    seed: int
    lags_s: tuple[float | None, ...]  # of each robot that has a trajectory
    deviations_m: tuple[float | None, ...]  # the farthest it was from its late plan
    touches: tuple[Nearest, ...]  # pairs of robots that overlapped, when they did most
    wall_touches: tuple[WallTouch, ...]
    clearance_m: float | None  # the least between two robots, negative where they overlapped
    wall_clearance_m: float | None  # the least of a robot from walls and obstacles
    margin_m: float  # kept in the plan between the robots as they are
    safe_margin_m: float  # with which no two can touch

    @property
    def touched(self) -> bool:
        """Whether any robot overlapped another, a wall or an obstacle."""
        return bool(self.touches or self.wall_touches)

    @property
    def tolerance_m(self) -> float:
        """How much less than the truth clearances may be [m]: curves are looked at in chords."""
        curved = any(way is not None and bool(way.pieces[:, 6:].any()) for way in self.driven)
        return 4.0 * TOLERANCE_M if curved else 0.0

    @property
    def deviation_m(self) -> float:
        """The farthest any robot was from its late plan."""
        return max((each for each in self.deviations_m if each is not None), default=0.0)


def safe_margin(problem: PlanningProblem, tracking_error_m: float, delay_s: float) -> float:
    """The margin [m] with which robots that are so far off and so late cannot touch each other."""
    fastest = max(robot.speed_mps for robot in problem.robots)
    return 2.0 * tracking_error_m + fastest * delay_s


def execute(
    problem: PlanningProblem,
    trajectories: Sequence[Trajectory | None],
    *,
    tracking_error_m: float = 0.0,
    delay_s: float = 0.0,
    slack_m: float = 0.0,
    seed: int = 0,
) -> Execution:
    """What becomes of a plan when robots drive it with errors and late; the same for a seed.

    `slack_m` is how much smaller robots are than they were planned for, which is what keeps them
    from walls. Robots without a trajectory are not there. Raises `InputError` for numbers that make
    no sense.
    """
    for name, value in (
        ("tracking error", tracking_error_m), ("delay", delay_s), ("slack", slack_m),
    ):  # fmt: skip
        if not (isfinite(value) and value >= 0.0):
            raise InputError(name, f"is {value}", "give a number that is not negative")
    for robot in problem.robots:
        if slack_m >= robot.radius_m:
            raise InputError(
                "slack", f"{slack_m:g} m leaves nothing of {robot.name}, whose radius is "
                f"{robot.radius_m:g} m", "give less",
            )  # fmt: skip
    given = [
        None if way is None else _drawn(robot, way, tracking_error_m, delay_s, seed)
        for robot, way in zip(problem.robots, trajectories, strict=True)
    ]
    return executed(
        problem,
        trajectories,
        given,
        tracking_error_m=tracking_error_m,
        delay_s=delay_s,
        slack_m=slack_m,
        seed=seed,
    )


def executed(
    problem: PlanningProblem,
    trajectories: Sequence[Trajectory | None],
    disturbances: Sequence[Disturbance | None],
    *,
    tracking_error_m: float,
    delay_s: float,
    slack_m: float = 0.0,
    seed: int = 0,
) -> Execution:
    """As `execute`, with what each robot has against it given; None without a trajectory."""
    driven = tuple(
        None if way is None or each is None else drive(way, each, CHORD * tracking_error_m)
        for way, each in zip(trajectories, disturbances, strict=True)
    )
    real = replace(
        problem,
        robots=tuple(replace(robot, radius_m=robot.radius_m - slack_m) for robot in problem.robots),
        horizon_s=problem.horizon_s + delay_s,
        margin_m=0.0,
    )
    pairs = pair_clearances(real, driven)
    walls = _wall_clearances(real, driven)
    return Execution(
        problem=real,
        planned=tuple(trajectories),
        driven=driven,
        tracking_error_m=tracking_error_m,
        delay_s=delay_s,
        slack_m=slack_m,
        seed=seed,
        lags_s=tuple(None if each is None else each.lag_s for each in disturbances),
        deviations_m=tuple(
            None if way is None or real_way is None or each is None
            else _deviation(way, real_way, each.lag_s)
            for way, real_way, each in zip(trajectories, driven, disturbances, strict=True)
        ),
        touches=tuple(pair for pair in pairs if pair.clearance_m < -ROUNDING_M),
        wall_touches=tuple(
            WallTouch(robot, -clear) for robot, clear in walls if clear < -ROUNDING_M
        ),
        clearance_m=min((pair.clearance_m for pair in pairs), default=None),
        wall_clearance_m=min((clear for _, clear in walls), default=None),
        margin_m=problem.margin_m + 2.0 * slack_m,
        safe_margin_m=safe_margin(problem, tracking_error_m, delay_s),
    )  # fmt: skip


def drive(planned: Trajectory, disturbance: Disturbance, tolerance_m: float = 1e-3) -> Trajectory:
    """What a robot drives; curves that have errors in straight pieces, off by the tolerance [m].

    Without errors the pieces are those of the plan, later.
    """
    lag, errors = disturbance.lag_s, disturbance.errors
    if not errors.any():
        pieces = planned.pieces.copy()
        pieces[:, :2] += lag
        if lag > 0.0:
            wait = np.zeros(PIECE)
            wait[1:4] = pieces[0, 0], pieces[0, 2], pieces[0, 3]
            pieces = np.vstack([wait, pieces])
        return Trajectory(pieces)
    end = planned.arrival_s + lag
    corners = polyline(planned, max(tolerance_m, ROUNDING_M))[:, 2] + lag
    knots = np.arange(len(errors)) * KNOT_S
    times = _apart(np.concatenate([[0.0], corners, knots[knots < end], [end]]), end)
    places = np.array([_place(planned, t - lag) for t in times.tolist()])
    offsets = np.stack([np.interp(times, knots, errors[:, k]) for k in (0, 1)], axis=1)
    if len(times) == 1:
        return Trajectory(planned.pieces)  # done where and when it starts
    return straight(places + offsets, times)


def _drawn(
    robot: PlanningRobot, way: Trajectory, tracking_error_m: float, delay_s: float, seed: int
) -> Disturbance:
    rng = generator_for(seed, f"{robot.name}/execution")
    lag = float(rng.random()) * delay_s
    count = int((way.arrival_s + lag) / KNOT_S) + 2
    curved = bool(way.pieces[:, 6:].any())
    bound = tracking_error_m * (1.0 - CHORD) if curved else tracking_error_m
    errors = np.zeros((count, 2))
    if bound > 0.0:
        errors[1:] = [_in_disc(rng, bound) for _ in range(count - 1)]
    return Disturbance(lag, errors)


def _in_disc(rng: np.random.Generator, radius: float) -> tuple[float, float]:
    while True:
        x, y = (2.0 * rng.random(2) - 1.0).tolist()
        if x * x + y * y <= 1.0:
            return radius * x, radius * y


def _apart(times: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Different times in order, the last being `end`; of those nearly equal the first."""
    ordered = np.unique(np.clip(times, 0.0, end))
    kept = [0.0, *(t for a, t in pairwise(ordered) if t - a > 1e-9)]
    kept[-1] = end
    return np.array(kept)


def _place(way: Trajectory, t: float) -> tuple[float, float]:
    """Where a robot is on its way, at its start before and at its end after it."""
    pieces = way.pieces
    t = min(max(t, float(pieces[0, 0])), way.arrival_s)
    row = pieces[max(int(np.searchsorted(pieces[:, 0], t, side="right")) - 1, 0)]
    x, y, _, _ = state_on_piece(row, min(t, float(row[1])))
    return float(x), float(y)


def _deviation(planned: Trajectory, driven: Trajectory, lag: float) -> float:
    """The farthest from the late plan, looked at where pieces end and in their middles."""
    ends = np.concatenate([driven.pieces[:, 0], driven.pieces[:, :2].mean(axis=1)])
    most = 0.0
    for t in [*ends.tolist(), driven.arrival_s]:
        (x, y), (u, v) = _place(driven, t), _place(planned, t - lag)
        most = max(most, sqrt((x - u) ** 2 + (y - v) ** 2))
    return most


def _wall_clearances(
    problem: PlanningProblem, driven: Sequence[Trajectory | None]
) -> list[tuple[int, float]]:
    """How far each robot that drives stays from walls and obstacles [m]."""
    walls = shapely.boundary(problem.floor.polygon)
    found: list[tuple[int, float]] = []
    for number, (robot, way) in enumerate(zip(problem.robots, driven, strict=True)):
        if way is None:
            continue
        line = shapely.LineString(polyline(way, TOLERANCE_M)[:, :2])
        discs = [line.distance(shapely.Point(x, y)) - r for x, y, r in problem.discs.tolist()]
        curved = TOLERANCE_M if way.pieces[:, 6:].any() else 0.0
        found.append((number, min([line.distance(walls), *discs]) - robot.radius_m - curved))
    return found
