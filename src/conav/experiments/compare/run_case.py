"""Plays the cases of a comparison; maps and planning cells are kept from case to case."""

import traceback
from collections import OrderedDict
from dataclasses import replace
from pathlib import Path

from conav.errors import InputError
from conav.experiments.compare.arguments import map_content
from conav.experiments.compare.cases import Case, Ground, Study
from conav.experiments.compare.outcome import CaseBounds, Failure, Outcome, outcome_of
from conav.exploration.types import ExplorationProblem
from conav.maps.planning_grid import PlanningGrid, default_start_area, planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import sensor as make_sensor
from conav.simulation.explore import load_map, make_faults, make_link
from conav.simulation.finish_bounds import finish_bounds
from conav.simulation.run_exploration import run_exploration
from conav.simulation.starts import start_together
from conav.simulation.world_state import generator_for

KEPT_CELLS = 16_000_000
"""Fine cells of the maps a process keeps; some ten bytes each."""


class Runner:
    """Plays the cases of one study, in one process."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self._plans: OrderedDict[tuple[str, int], PlanningGrid] = OrderedDict()

    def problem(self, case: Case) -> tuple[ExplorationProblem, tuple[str, ...]]:
        """The problem `conav explore` would make of the case, and what was odd about it.

        Raises `InputError` for a map that cannot be used and a team that does not fit on it.
        """
        world = self.study.world
        plan = self._plan(case.map, case.seed)
        link = make_link(self.study.radio(case), world.loss, world.delay_s)
        team = tuple(
            Robot(
                name=f"robot_{number}",
                radius_m=world.radius_m,
                speed_mps=world.speed_mps,
                motion=MOTIONS[world.motion],
                sensor=make_sensor(world.sensor, case.range_m),
                radio=link,
                energy_j=world.energy_j,
            )
            for number in range(case.robots)
        )
        warnings = list(plan.grid.warnings)
        if case.range_m < plan.lattice.cell_m:
            warnings.append(
                f"a sensor range of {case.range_m:g} m is less than a planning cell of "
                f"{plan.lattice.cell_m:g} m: robots may not see where they could go"
            )
        area = default_start_area(plan, outside=world.outside)
        warnings.extend(area.warnings)
        starts = start_together(plan, area, team, generator_for(case.seed, "starts"))
        limit = float(world.max_time_s)
        faults = make_faults(world.faults, team)
        made = ExplorationProblem(plan, team, starts, case.seed, limit, world.traffic, faults)
        return made, tuple(warnings)

    def fits(self, case: Case) -> InputError | None:
        """What is wrong with the map or with the team on it, if anything."""
        try:
            self.problem(case)
        except InputError as error:
            return _on_map(case, error)
        return None

    def begins(self, case: Case) -> InputError | None:
        """What is wrong with the map, the team, or the strategy's first step, if anything."""
        try:
            problem, _ = self.problem(case)
            at_once = replace(problem, max_time_s=0.0)  # a run that ends after the first decision
            run_exploration(at_once, self.study.team(case.strategy).mind, name=case.strategy)
        except InputError as error:
            return _on_map(case, error)
        except Exception:
            return None  # a fault of the strategy's, which is told of where the case is run
        return None

    def run(self, case: Case) -> Outcome | Failure:
        """What came of the case. An interrupt from the keyboard goes through."""
        try:
            problem, warnings = self.problem(case)
            mind = self.study.team(case.strategy).mind
            result = run_exploration(problem, mind, name=case.strategy)
        except Exception as error:
            return Failure(_in_a_line(error))
        if result.interrupted:
            raise KeyboardInterrupt
        return outcome_of(problem, warnings, result)

    def bounds(self, ground: Ground) -> CaseBounds | Failure:
        """Bounds on the best possible time. An interrupt from the keyboard goes through."""
        study = self.study
        case = Case(
            ground.map,
            ground.robots,
            ground.range_m,
            study.radios[0],
            study.teams[0].name,
            ground.seed,
        )
        try:
            problem, _ = self.problem(case)
            found = finish_bounds(problem, (100,), effort=study.effort)[100]
        except Exception as error:
            return Failure(_in_a_line(error))
        return CaseBounds(found.lower_s, found.by, found.upper_s)

    def _plan(self, name: str, seed: int) -> PlanningGrid:
        place, world = self.study.map(name), self.study.world
        key = (name, seed if place.seeded else 0)
        if key not in self._plans:
            grid = load_map(
                place.source,
                resolution=world.resolution,
                seed=seed,
                outside_folder=world.outside_folder,
            )
            if not place.seeded and map_content(grid) != place.content:
                raise InputError(name, "has changed since the comparison began", "start it again")
            diagonal = MOTIONS[world.motion].diagonal
            self._plans[key] = planning_grid(
                grid, cell_m=world.cell_m, radius_m=world.radius_m, diagonal=diagonal
            )
            while len(self._plans) > 1 and self._cells() > KEPT_CELLS:
                self._plans.popitem(last=False)
        self._plans.move_to_end(key)
        return self._plans[key]

    def _cells(self) -> int:
        return sum(plan.walls.size for plan in self._plans.values())


def _on_map(case: Case, error: InputError) -> InputError:
    """The error with the map and the seed named."""
    place = f"map {case.map}, seed {case.seed}"
    if error.place != case.map:
        place += f": {error.place}"
    return InputError(place, error.problem, error.remedy)


def _in_a_line(error: Exception) -> str:
    """The error and where it was raised."""
    if isinstance(error, InputError):
        return str(error)
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return " ".join(f"{type(error).__name__}: {error}{where}".split())
