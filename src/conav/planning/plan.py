"""From a problem to a plan, in one call."""

from collections.abc import Mapping
from typing import Any

from conav.planning.budget import OnProgress
from conav.planning.catalogue import DEFAULT_SOLVER, make_solver
from conav.planning.types import PlanningProblem, PlanningResult


def plan(
    problem: PlanningProblem,
    solver: str = DEFAULT_SOLVER,
    seed: int = 0,
    *,
    settings: Mapping[str, object] | None = None,
    on_progress: OnProgress | None = None,
    **more_settings: Any,
) -> PlanningResult:
    """The result of a solver, by default of iNash; the same for the same seed.

    Settings of the solver are given by name or as a mapping: `samples=5000`, `time_s=2.0`. After
    each iteration `on_progress` is called, and stops the solver by returning False.

    Raises `InputError` for an unknown solver or setting, and for a problem that makes no sense.

        >>> from conav.maps.polygon_map import PolygonMap
        >>> from conav.planning.types import PlanningRobot, Region
        >>> goal = Region("goal", disc=(8.0, 1.0, 0.5))
        >>> robot = PlanningRobot("a", (2.0, 1.0), "F goal", {"goal": goal})
        >>> floor = PolygonMap([(0, 0), (10, 0), (10, 2), (0, 2)])
        >>> found = plan(PlanningProblem(floor, (robot,), horizon_s=20.0), samples=200)
        >>> str(found.status), round(float(found.costs[0, 0]), 3)
        ('done', 5.5)
    """
    return make_solver(solver, {**(settings or {}), **more_settings}).solve(
        problem, seed, on_progress
    )
