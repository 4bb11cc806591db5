"""The nouns of planning: the problem, a trajectory, the result."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.maps.polygon_map import PolygonMap
from conav.status import Status

SINGLE_INTEGRATOR = "single-integrator"
DOUBLE_INTEGRATOR = "double-integrator"
DUBINS_CAR = "dubins-car"
PLANNING_MOTIONS = (SINGLE_INTEGRATOR, DOUBLE_INTEGRATOR, DUBINS_CAR)

COSTS = ("length", "duration")
"""What a robot may want little of: metres driven, and seconds until it arrives."""

PIECE = 9
"""Numbers of a piece of a trajectory: t0, t1, x, y, vx, vy, ax, ay, turn rate."""

Pieces = NDArray[np.float64]  # (n, PIECE)


@dataclass(frozen=True, eq=False)
class Region:
    """A closed part of the floor: a disc, or a simple polygon.

    `disc` is (x, y, radius) [m]; `polygon` has shape (n, 2) [m], counter-clockwise. A robot is in a
    region when its centre is.
    """

    name: str
    disc: tuple[float, float, float] | None = None
    polygon: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        if (self.disc is None) == (self.polygon is None):
            raise ValueError(f"region {self.name} needs a disc or a polygon, and not both")
        if self.polygon is not None:
            object.__setattr__(self, "polygon", _locked(self.polygon))


@dataclass(frozen=True, eq=False)
class PlanningRobot:
    """A disc with a start, a motion, regions it calls by name, and a task about them.

    `task` is a formula of finite linear temporal logic over the names of `regions`; its word is the
    sequence of sets of regions the robot's centre is in, a letter at each change.

    `start` is (x, y) for a single integrator, (x, y, vx, vy) for a double integrator, and (x, y,
    heading [rad]) for a Dubins car. After arrival a robot stays where it is and is in everybody's
    way, or vanishes.
    """

    name: str
    start: tuple[float, ...]
    task: str
    regions: Mapping[str, Region]
    radius_m: float = 0.25
    speed_mps: float = 1.0  # top speed
    acceleration_mps2: float = 1.0  # of a double integrator: bound on the acceleration's norm
    turning_radius_m: float = 0.5  # of a Dubins car: the tightest turn
    motion: str = SINGLE_INTEGRATOR
    after_arrival: Literal["stay", "vanish"] = "stay"


COUPLINGS = ("meet", "not-before", "near")
"""What two robots can have to do with each other beside keeping apart."""


@dataclass(frozen=True, eq=False)
class Coupling:
    """A task of two robots together; `robots` are their names.

    `meet`: at some time both centres are in `region`, within `within_m` of each other.
    `not-before`: the first is not in `region` before the second has been in `other_region`, or in
    the same one where that is None. `near`: the centres are within `within_m` of each other while
    both are there.
    """

    kind: Literal["meet", "not-before", "near"]
    robots: tuple[str, str]
    region: Region | None = None
    other_region: Region | None = None
    within_m: float | None = None

    def __post_init__(self) -> None:
        needed = {"meet": (True, False, True), "near": (False, False, True)}
        given = (self.region is not None, self.other_region is not None, self.within_m is not None)
        if self.kind == "not-before":
            if not given[0] or given[2]:
                raise ValueError("not-before needs a region, and no within_m")
        elif given != needed[self.kind]:
            need = "region and within_m" if self.kind == "meet" else "within_m"
            raise ValueError(f"{self.kind} needs {need}, and nothing else")
        if self.robots[0] == self.robots[1]:
            raise ValueError("a coupling is of two different robots")


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """Robots with tasks of their own on one floor.

    `floor` has the walls, `discs` further obstacles, shape (m, 3): x, y, radius [m]. A robot of
    radius r keeps its centre r from both, and r_i + r_j + `margin_m` from every other robot, at
    every time from 0 until it vanishes; a robot that has stopped is there until `horizon_s`.
    `costs` names the components of each robot's cost; `couplings` are tasks of two robots together,
    which few solvers know.
    """

    floor: PolygonMap
    robots: tuple[PlanningRobot, ...]
    horizon_s: float
    discs: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    costs: tuple[str, ...] = ("length",)
    margin_m: float = 0.0
    name: str = "scene"
    couplings: tuple[Coupling, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "discs", _locked(np.reshape(self.discs, (-1, 3))))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where a robot's centre is at every time.

    Each row of `pieces`, shape (n, PIECE), starts at (x, y) at t0 with velocity (vx, vy) and lasts
    until t1. With turn rate 0 the acceleration (ax, ay) is constant; with another [rad/s] the speed
    is constant and the velocity turns, counter-clockwise where positive, and (ax, ay) are 0. Pieces
    follow each other without a gap or a jump; the first begins at time 0. The robot arrives at the
    end of the last.
    """

    pieces: Pieces

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _locked(np.reshape(self.pieces, (-1, PIECE))))

    @property
    def arrival_s(self) -> float:
        """When the robot is done."""
        return float(self.pieces[-1, 1])


@dataclass(frozen=True, eq=False)
class PlanningResult:
    """What a solver found.

    `status` is done only when every robot has a trajectory and the solver's own claim holds: for
    inash, that no robot can do better alone on its final graph. A robot without a trajectory has
    None, and infinite costs.
    """

    status: Status
    reason: str  # in words a person acts on; "" when done
    trajectories: tuple[Trajectory | None, ...]
    costs: NDArray[np.float64]  # (robots, components)
    epsilon: NDArray[np.float64] | None  # (robots,) what each could still gain alone; None: unknown
    solo: NDArray[np.float64] | None  # (robots, components) best found alone in the scene
    lower_bound: float | None  # certified, on the sum of the first component; None: unknown
    counters: Mapping[str, int]  # vertices, iterations, messages, checks, ...
    graphs: tuple[NDArray[np.float64], ...] = ()  # per robot its vertices in insertion order
    history: tuple[Mapping[str, Any], ...] = ()  # improvements as they came
    graph_bound: float | None = None  # as lower_bound, but of plans on the final graphs alone


def _locked(array: ArrayLike) -> NDArray[np.float64]:
    copy = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy
