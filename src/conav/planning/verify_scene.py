"""What a plan's run file says, in the verifier's own terms, and the notes it takes."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple, TypeGuard, cast

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.runs.types import PlanRun

TOLERANCE = 1e-6
"""How much every comparison forgives [m, m/s, m/s^2, s, rad]: rounding is a thousand times less."""

SHOWN = 5  # violations told in full per check
MAX_ROBOTS = 4096
LARGEST = 1e9  # of any number: beyond, rounding is no longer below the tolerance
SMALLEST_RADIUS_M = 1e-4  # far above the tolerance, or walls would stop nobody

MOTIONS = ("single-integrator", "double-integrator", "dubins-car")


class Violation(NamedTuple):
    """A rule that was broken: by whom, when, where."""

    text: str
    robots: tuple[str, ...] = ()
    time_s: float | None = None
    place: tuple[float, float] | None = None  # x, y [m]

    def __str__(self) -> str:
        who = f"{' and '.join(self.robots)}: " if self.robots else ""
        when = f" at {self.time_s:.6g} s" if self.time_s is not None else ""
        where = f" at ({self.place[0]:.6g}, {self.place[1]:.6g})" if self.place is not None else ""
        return f"{who}{self.text}{when}{where}"


@dataclass
class Check:
    """One rule: how often it was looked at, where it was broken, what could not be looked at."""

    name: str
    looked: int = 0
    broken: int = 0
    violations: list[Violation] = field(default_factory=list[Violation])
    unchecked: list[str] = field(default_factory=list[str])
    notes: list[str] = field(default_factory=list[str])

    def fault(self, violation: Violation) -> None:
        """Note a breach."""
        self.broken += 1
        if len(self.violations) < SHOWN:
            self.violations.append(violation)

    def skip(self, why: str) -> None:
        """Note that something was not checked."""
        if why not in self.unchecked:
            self.unchecked.append(why)


class Area(NamedTuple):
    """A region: a disc, or a polygon's corners."""

    disc: tuple[float, float, float] | None
    corners: NDArray[np.float64] | None  # (n, 2) [m]


class Body(NamedTuple):
    """A robot of the problem."""

    name: str
    motion: str
    start: tuple[float, ...]
    task: str
    areas: dict[str, Area]
    radius: float  # [m]
    speed: float  # [m/s]
    acceleration: float  # [m/s^2]
    turning_radius: float  # [m]
    stays: bool


class Scene(NamedTuple):
    """The problem, and the trajectories in the end."""

    walls: NDArray[np.float64]  # (n, 4) x0, y0, x1, y1 [m]
    discs: NDArray[np.float64]  # (m, 3) x, y, radius [m]
    area_m2: float
    horizon: float  # [s]
    margin: float  # [m]
    costs: tuple[str, ...]
    bodies: tuple[Body, ...]
    tracks: tuple[NDArray[np.float64] | None, ...]  # each (n, 9), or none

    def ways(self) -> list[tuple[int, Body, NDArray[np.float64]]]:
        """Robots that have a trajectory, by number."""
        return [
            (number, body, track)
            for number, (body, track) in enumerate(zip(self.bodies, self.tracks, strict=True))
            if track is not None
        ]


def read_scene(run: PlanRun) -> Scene:
    """The problem of a planner's run and its plan.

    Raises `InputError` when the run is of another job or its header is not one of a plan.
    """
    if run.header.get("job") != "plan":
        raise InputError(run.path, f"is a run of job {run.header.get('job')!r}", "give a plan")
    try:
        return _scene(run, run.header["problem"])
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise InputError(
            run.path, f"has a header that cannot be used ({error!r})", "the file is damaged"
        ) from None


def _scene(run: PlanRun, problem: dict[str, Any]) -> Scene:
    robots = cast("list[dict[str, Any]]", problem["robots"])
    if not 1 <= len(robots) <= MAX_ROBOTS:
        raise ValueError(f"{len(robots)} robots")
    floor = problem["floor"]
    rings = [_points(ring) for ring in [floor["outer"], *floor["holes"]]]
    walls = np.concatenate([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings])
    x0, y0, x1, y1 = walls.T
    discs = np.array(problem["discs"], dtype=np.float64).reshape(-1, 3)
    if not (np.abs(discs) <= LARGEST).all() or (discs[:, 2:] < 0).any():
        raise ValueError("discs that are none")
    costs = tuple(problem["costs"])
    if not costs or not set(costs) <= {"length", "duration"}:
        raise ValueError(f"costs {costs!r}")
    bodies = tuple(_body(robot) for robot in robots)
    if len({body.name for body in bodies}) < len(bodies):
        raise ValueError("two robots of one name")
    return Scene(
        walls=np.ascontiguousarray(walls),
        discs=discs,
        area_m2=float((x0 * y1 - x1 * y0).sum() / 2.0),
        horizon=_number(problem["horizon_s"], least=0.0),
        margin=_number(problem["margin_m"], least=0.0),
        costs=costs,
        bodies=bodies,
        tracks=tuple(run.pieces(number) for number in range(len(bodies))),
    )


def _body(robot: dict[str, Any]) -> Body:
    motion, after = robot["motion"], robot["after_arrival"]
    if motion not in MOTIONS or after not in ("stay", "vanish"):
        raise ValueError(f"motion {motion!r} and {after!r} after arrival")
    start = tuple(_number(number) for number in robot["start"])
    if len(start) != {"single-integrator": 2, "double-integrator": 4, "dubins-car": 3}[motion]:
        raise ValueError(f"a {motion} that starts at {start!r}")
    return Body(
        name=str(robot["name"]),
        motion=motion,
        start=start,
        task=str(robot["task"]),
        areas={str(name): _area(region) for name, region in dict(robot["regions"]).items()},
        radius=_number(robot["radius_m"], least=SMALLEST_RADIUS_M),
        speed=_number(robot["speed_mps"], least=0.0),
        acceleration=_number(robot["acceleration_mps2"], least=0.0),
        turning_radius=_number(robot["turning_radius_m"], least=0.0),
        stays=after == "stay",
    )


def _area(region: dict[str, Any]) -> Area:
    if "disc" in region:
        x, y, radius = (_number(number) for number in region["disc"])
        return Area((x, y, _number(radius, least=0.0)), None)
    return Area(None, _points(region["polygon"]))


def _points(rows: Any) -> NDArray[np.float64]:
    points = np.array(rows, dtype=np.float64)
    whole = points.ndim == 2 and points.shape[1] == 2 and len(points) >= 3
    if not whole or not (np.abs(points) <= LARGEST).all():
        raise ValueError("a ring that is none")
    return points


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value from JSON is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _number(value: object, *, least: float | None = None) -> float:
    """A number that is not too large, and at least so large."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r} is no number")
    number = float(value)
    if not abs(number) <= LARGEST or (least is not None and number < least):
        raise ValueError(f"{value!r} is out of range")
    return number
