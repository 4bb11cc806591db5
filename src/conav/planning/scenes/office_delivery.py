"""Deliveries in an office, each robot with errands of its own."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.ndimage import label

from conav.errors import InputError
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.planning_grid import PlanningGrid, default_start_area, planning_grid
from conav.planning.floor import floor_of_grid
from conav.planning.scenes.catalogue import MAX_ROBOTS
from conav.planning.scenes.placing import Point, distance
from conav.planning.types import PlanningProblem, PlanningRobot, Region

OFFICE = "office"
AREA_PER_ROBOT_M2 = 20.0  # below this the office grows
CELL_M = 0.2
CLEARANCE_M = 0.1
TRIES = 4000
TASKS = ("F a & F b & G !c", "(!b U a) & F b & G !c", "F a & G !c")
"""Two errands in any order, one before the other, and a single one; all keep out of c."""


@dataclass(frozen=True)
class OfficeDelivery:
    """Robots run errands on an office floor: to a, to b or to both, and never through c.

    Every robot has places a, b and c of its own and one of the tasks in `TASKS`. Starts and places
    are drawn so that robots can take turns: any robot can go from its start to its places while all
    others stand at their starts or anywhere in their places, and never needs to enter its c. So the
    scene has a plan, if the horizon is long enough for one after the other; all at once is for the
    planner to find. `office` is the seed of the floor; where it is not given, it is drawn too.
    """

    robots: Annotated[int, Field(ge=1, le=MAX_ROBOTS)] = 8
    office: Annotated[int, Field(ge=0)] | None = None
    radius_m: Annotated[float, Field(gt=0)] = 0.2
    speed_mps: Annotated[float, Field(gt=0)] = 1.0
    place_m: Annotated[float, Field(gt=0)] = 0.25  # radius of a and b
    avoid_m: Annotated[float, Field(gt=0)] = 0.6  # radius of c
    horizon_s: Annotated[float, Field(gt=0)] = 120.0

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        seed = int(rng.integers(1000)) if self.office is None else self.office
        usual = BUILTIN[OFFICE]
        grow = sqrt(max(1.0, self.robots * AREA_PER_ROBOT_M2 / (usual.width_m * usual.height_m)))
        grid = builtin_map(
            OFFICE, width_m=usual.width_m * grow, height_m=usual.height_m * grow, seed=seed
        )
        plan = planning_grid(grid, cell_m=CELL_M, radius_m=self.radius_m + CLEARANCE_M)
        places = _Places(plan, 2 * self.radius_m + CLEARANCE_M)
        robots: list[PlanningRobot] = []
        for index in range(self.robots):
            task = TASKS[int(rng.integers(len(TASKS)))]
            start = places.add(rng, 0.0, index)
            stops = [places.add(rng, self.place_m, index)]
            if "b" in task:
                stops.append(places.add(rng, self.place_m, index))
            regions = {
                key: Region(key, disc=(*at, self.place_m))
                for key, at in zip("ab", stops, strict=False)
            }
            robots.append(
                PlanningRobot(
                    name=f"robot_{index}",
                    start=start,
                    task=task,
                    regions=regions,
                    radius_m=self.radius_m,
                    speed_mps=self.speed_mps,
                )
            )
        # Only now, for what they leave open depends on where everybody may stand.
        robots = [self._with_c(rng, places, robot) for robot in robots]
        floor = floor_of_grid(grid, robots)
        return PlanningProblem(
            floor=floor,
            robots=tuple(robots),
            horizon_s=self.horizon_s * grow,
            name="office-delivery",
        )

    def _with_c(
        self, rng: np.random.Generator, places: "_Places", robot: PlanningRobot
    ) -> PlanningRobot:
        stops = [
            (region.disc[0], region.disc[1]) for region in robot.regions.values() if region.disc
        ]
        x, y = places.avoidable(rng, self.avoid_m, [(robot.start[0], robot.start[1]), *stops])
        regions = {**robot.regions, "c": Region("c", disc=(x, y, self.avoid_m))}
        return PlanningRobot(
            name=robot.name,
            start=robot.start,
            task=robot.task,
            regions=regions,
            radius_m=robot.radius_m,
            speed_mps=robot.speed_mps,
        )


class _Places:
    """Places on a planning grid that leave each other reachable.

    A place blocks the cells within `keep` of anywhere in it. From every place there must be a way,
    over cells that no other place blocks, to one connected part of what none blocks at all.
    """

    def __init__(self, plan: PlanningGrid, keep: float) -> None:
        self._lattice = plan.lattice
        self._keep = keep
        area = default_start_area(plan)
        inside = np.zeros(plan.standable.size, dtype=np.bool_)
        inside[area.cells] = True
        self._open = inside.reshape(plan.standable.shape)
        cols, rows = np.arange(plan.lattice.cols), np.arange(plan.lattice.rows)
        self._x = (cols + 0.5) * plan.lattice.cell_m
        self._y = (rows[:, None] + 0.5) * plan.lattice.cell_m
        self._taken: list[tuple[Point, float]] = []
        self._blocks = np.zeros(self._open.shape, dtype=np.int16)  # by how many places

    def add(self, rng: np.random.Generator, radius: float, robot: int) -> Point:
        """A new place of that radius, the middle of a cell."""
        cells = np.flatnonzero(self._open & (self._blocks == 0))
        for _ in range(TRIES if len(cells) else 0):
            point = self._lattice.position(int(cells[int(rng.integers(len(cells)))]))
            if any(distance(point, at) < self._keep + radius + r for at, r in self._taken):
                continue
            blocks = self._blocks + self._disc(point, self._keep + radius)
            taken = [*self._taken, (point, radius)]
            if self._joined(self._open, blocks, taken):
                self._taken, self._blocks = taken, blocks
                return point
        raise InputError(
            f"office-delivery: robot_{robot}", "finds no place that leaves the others a way",
            "ask for fewer or smaller robots",
        )  # fmt: skip

    def avoidable(self, rng: np.random.Generator, radius: float, own: list[Point]) -> Point:
        """A place to keep out of: none of the robot's own is near it, and none gets cut off."""
        cells = np.flatnonzero(self._open)
        places = [(at, r) for at, r in self._taken if at in own]
        for _ in range(TRIES):
            point = self._lattice.position(int(cells[int(rng.integers(len(cells)))]))
            if any(distance(point, at) < radius + r + CLEARANCE_M for at, r in places):
                continue
            rest = self._open & ~self._disc(point, radius + CLEARANCE_M)
            if self._joined(rest, self._blocks, places):
                return point
        raise InputError("office-delivery", "finds no place for a c", "ask for a smaller avoid_m")

    def _disc(self, at: Point, radius: float) -> NDArray[np.bool_]:
        dx, dy = self._x - at[0], self._y - at[1]
        return dx * dx + dy * dy < radius * radius

    def _joined(
        self,
        ground: NDArray[np.bool_],
        blocks: NDArray[np.int16],
        places: list[tuple[Point, float]],
    ) -> bool:
        """Whether every place has its way to the largest part of the ground nobody blocks."""
        parts, count = label(ground & (blocks == 0))
        if count == 0:
            return False
        largest = parts == int(np.argmax(np.bincount(parts.ravel())[1:])) + 1
        for at, radius in places:
            col, row = int(at[0] / self._lattice.cell_m), int(at[1] / self._lattice.cell_m)
            half = int((self._keep + radius) / self._lattice.cell_m) + 2
            rows, cols = (slice(max(middle - half, 0), middle + half + 1) for middle in (row, col))
            own = self._disc(at, self._keep + radius)[rows, cols] & (blocks[rows, cols] == 1)
            way, _ = label(ground[rows, cols] & (own | largest[rows, cols]))
            part = way[row - rows.start, col - cols.start]
            if part == 0 or not (largest[rows, cols] & (way == part)).any():
                return False
        return True
