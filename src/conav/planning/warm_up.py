"""Getting kernels ready before the clock of a budget in seconds starts."""

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.catalogue import make_solver
from conav.planning.types import (
    DOUBLE_INTEGRATOR,
    DUBINS_CAR,
    PlanningProblem,
    PlanningRobot,
    Region,
)

SIDE_M = 8.0
SAMPLES = 20

_REST = {DOUBLE_INTEGRATOR: (0.0, 0.0), DUBINS_CAR: (0.0,)}  # what a start has beside its place


def warm_up(solver: str, problem: PlanningProblem) -> None:
    """Compile or load the kernels that a solver needs, by a small plan with the same motions.

    Compiling takes up to a minute, loading a second or two; a budget of seconds is for planning.
    """
    motions = sorted({robot.motion for robot in problem.robots})
    goal = Region("goal", disc=(0.8 * SIDE_M, 0.5 * SIDE_M, 0.5))
    robots = tuple(
        PlanningRobot(
            f"r{number}",
            (1.0, 1.5 * (number + 1), *_REST.get(motion, ())),
            "F goal",
            {"goal": goal},
            radius_m=0.2,
            motion=motion,
            after_arrival="vanish",
        )
        for number, motion in enumerate([*motions, motions[0]])
    )
    floor = PolygonMap([(0, 0), (SIDE_M, 0), (SIDE_M, SIDE_M), (0, SIDE_M)])
    small = PlanningProblem(floor, robots, 40.0, costs=problem.costs)
    try:
        make_solver(solver, {"samples": SAMPLES}).solve(small)
    except InputError:
        return  # what a solver does not know it says of the problem itself
