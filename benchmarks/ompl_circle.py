"""How near to the shortest way one robot among 70 discs is, beside the planners of OMPL.

The scene and the exact lengths are those of `planning.py`: a square of 66 m, 70 discs, a robot of
0.4 m. OMPL's planners get a test of whole motions that is exact and compiled, as ours is, in place
of one that looks at places along them. Budgets are seconds of processor time from a warm start, in
one process, one planner after the other for each query; a planner goes on from one budget to the
next. Prints the median and the range of how much longer than exact the ways are. Needs the package
`ompl`, which is in the group `oracle` of development dependencies.
"""

import argparse
from collections.abc import Callable
from math import inf
from statistics import median
from time import process_time

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric, util

from conav.compiled import kernel
from conav.maps.polygon_map import PolygonMap
from conav.planning.plan import plan
from conav.planning.types import PlanningProblem, PlanningRobot, Region
from planning import free_places, scattered, shortest_among_discs

SIDE, RADIUS = 66.0, 0.4
GOAL = 0.01  # [m] around the goal, where our robot may stop
BUDGETS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
PLANNERS = (
    "RRTstar", "InformedRRTstar", "PRMstar", "BITstar", "ABITstar", "AITstar", "EITstar", "AORRTC",
)  # fmt: skip

Place = tuple[float, float]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--queries", type=int, default=100)
    parser.add_argument("--budgets", type=float, nargs="+", default=BUDGETS)
    options = parser.parse_args()
    util.setLogLevel(util.LogLevel.LOG_NONE)
    discs = scattered(70, 7, SIDE, 1.0, 3.0, 1.0)
    places = free_places(2 * options.queries, 8, discs, SIDE, 1.0)
    names = [name for name in PLANNERS if hasattr(geometric, name)]
    print("not in this build of OMPL:", ", ".join(name for name in PLANNERS if name not in names))
    longer: dict[str, list[list[float]]] = {name: [] for name in ("inash", *names)}
    by_inash(discs, places[0], places[1], 0, [0.2])  # kernels are compiled
    for query in range(options.queries):
        start, goal = places[2 * query], places[2 * query + 1]
        exact = shortest_among_discs(start, goal, discs + np.array([0, 0, RADIUS]))
        for name, found in longer.items():
            if name == "inash":
                lengths = by_inash(discs, start, goal, query, options.budgets)
                found.append([100.0 * (length / (exact - GOAL) - 1.0) for length in lengths])
            else:
                lengths = by_ompl(name, discs, start, goal, query, options.budgets)
                found.append([100.0 * (length / exact - 1.0) for length in lengths])
        print(f"query {query + 1} of {options.queries}", flush=True)
    print("| planner |" + "".join(f" {budget:g} s |" for budget in options.budgets))
    print("|---|" + "---|" * len(options.budgets))
    for name, rows in longer.items():
        print(f"| {name} | " + " | ".join(map(shown, zip(*rows, strict=True))) + " |")


def shown(percents: tuple[float, ...]) -> str:
    """The median and the range."""
    return f"{median(percents):.3f} ({min(percents):.3f} to {max(percents):.3f})"


def by_inash(
    discs: NDArray[np.float64], start: Place, goal: Place, seed: int, budgets: list[float]
) -> list[float]:
    """The length at each budget."""
    floor = PolygonMap([(0, 0), (SIDE, 0), (SIDE, SIDE), (0, SIDE)])
    robot = PlanningRobot(
        "a", start, "F goal", {"goal": Region("goal", disc=(*goal, GOAL))}, RADIUS
    )
    problem = PlanningProblem(floor, (robot,), 200.0, discs)
    lengths: list[float] = []
    length = inf
    begun = process_time()

    def look(progress) -> bool:
        nonlocal length
        now = process_time() - begun
        while len(lengths) < len(budgets) and now > budgets[len(lengths)]:
            lengths.append(length)  # what was there before this iteration ended
        length = float(progress.costs[0, 0])
        return len(lengths) < len(budgets)

    plan(problem, seed=seed, samples=None, iterations=10**9, on_progress=look)
    return lengths


@kernel
def clear_between(discs: NDArray[np.float64], ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether a straight motion of the robot's centre meets no disc and stays on the floor."""
    low, high = RADIUS, SIDE - RADIUS
    if min(ax, ay, bx, by) < low or max(ax, ay, bx, by) > high:
        return False
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    for i in range(len(discs)):
        x = discs[i, 0] - ax
        y = discs[i, 1] - ay
        s = 0.0
        if square > 0.0:
            s = min(max((x * dx + y * dy) / square, 0.0), 1.0)
        x -= s * dx
        y -= s * dy
        away = discs[i, 2] + RADIUS
        if x * x + y * y < away * away:
            return False
    return True


def by_ompl(
    name: str,
    discs: NDArray[np.float64],
    start: Place,
    goal: Place,
    seed: int,
    budgets: list[float],
) -> list[float]:
    """The length at each budget, infinite without a way."""
    clear: Callable[..., bool] = clear_between.compile()
    util.RNG.setSeed(seed + 1)

    class Motions(base.MotionValidator):
        def checkMotion(self, a, b, *_) -> bool:
            return clear(discs, a[0], a[1], b[0], b[1])

    begun = process_time()
    space = base.RealVectorStateSpace(2)
    bounds = base.RealVectorBounds(2)
    bounds.setLow(0.0)
    bounds.setHigh(SIDE)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda at: clear(discs, at[0], at[1], at[0], at[1]))
    motions = Motions(information)
    information.setMotionValidator(motions)
    ends = []
    for x, y in (start, goal):
        state = space.allocState()
        state[0], state[1] = x, y
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.setPlanner(getattr(geometric, name)(information))
    setup.setup()
    lengths: list[float] = []
    for budget in budgets:
        # Its own clock tells the time of day, which is never less; a Python one hangs PRM's thread.
        while (rest := budget - (process_time() - begun)) > 0.0:
            setup.solve(base.timedPlannerTerminationCondition(max(rest, 0.001)))
        exact = setup.haveExactSolutionPath()
        lengths.append(setup.getSolutionPath().length() if exact else inf)
    return lengths


if __name__ == "__main__":
    main()
