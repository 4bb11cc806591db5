"""A team that is being planned for: each robot's task, graph and present path, and the traffic.

Solvers are rules about who answers whom, and when; what they do is all here.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.planning.arranged import arrange
from conav.planning.best_response import (
    LEAST_GAIN,
    Response,
    Roads,
    best_response,
    edge_costs,
    make_roads,
    random_costs,
)
from conav.planning.budget import Budget
from conav.planning.coupling_rule import refuse_couplings
from conav.planning.curves import SAG
from conav.planning.first_response import first_response
from conav.planning.graph import RobotGraph, build_graph
from conav.planning.graph_arrays import (
    EDGE_TESTS,
    SAMPLES,
    Exponent,
    Mode,
    Surroundings,
    make_rule,
)
from conav.planning.growing import grow
from conav.planning.labels import build_regions
from conav.planning.letters import Task, task_of
from conav.planning.lower_bound import sum_bound
from conav.planning.obstacles import Obstacles, build_obstacles
from conav.planning.pareto_response import pareto_response
from conav.planning.radius import default_gamma
from conav.planning.sampler import Sampler
from conav.planning.shortcut import between, shortcut
from conav.planning.shortcut_curved import between_curved, shortcut_curved
from conav.planning.steering import (
    MOTION,
    STATE,
    STRAIGHT,
    build_limits,
    path_costs,
    pieces_of,
    start_state,
)
from conav.planning.traffic import Traffic, build_traffic
from conav.planning.types import PlanningProblem, PlanningResult, Trajectory
from conav.status import Status


@dataclass(frozen=True)
class GraphSettings:
    """How graphs grow, for every solver."""

    mode: Mode = "forward"
    eta_m: float = 3.0  # greatest connection radius, and of a step towards a sample
    gamma_m: float | None = None  # of the radius; None: from the floor's area and the horizon
    exponent: Exponent = "d"  # of the radius
    goal_share: float = 0.1  # of samples, in a region of the task
    straight_share: float = 0.02  # straight ways to a region
    wait_share: float = 0.05  # waits
    local_share: float = 0.3  # around the present path
    shortcut_tries: int = 200  # at straightening a path that got better; 0: never
    guide: bool = True  # begin with a path from a search over cells
    delays: int = 8  # copies of it, each later by the time of about half a radius


@dataclass(eq=False)
class Team:
    """Everything a solver changes. Robots are numbers, in the order of the problem."""

    problem: PlanningProblem
    settings: GraphSettings
    tasks: tuple[Task, ...]
    graphs: tuple[RobotGraph, ...]
    samplers: tuple[Sampler, ...]
    traffic: Traffic
    guides: list[NDArray[np.float64]]  # per robot the states of its guide, may be none
    roads: list[tuple[Roads, ...]]  # one for each component; none: the graph has grown
    paths: list[NDArray[np.int64] | None]
    costs: NDArray[np.float64]  # (robots, components), infinite without a path
    least_lengths: NDArray[np.float64]  # (robots,) [m] certified; 0: nothing is known
    tested: NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, np.int64))
    counters: dict[str, int] = field(default_factory=dict)
    history: list[dict[str, object]] = field(default_factory=list)

    @property
    def size(self) -> int:
        return len(self.graphs)

    def count(self, name: str, more: int = 1) -> None:
        """Adds to a counter."""
        self.counters[name] = self.counters.get(name, 0) + more

    def everybody(self) -> NDArray[np.bool_]:
        """All robots, as those to heed; one never heeds itself."""
        return np.ones(self.size, np.bool_)

    def only(self, robots: Iterable[int]) -> NDArray[np.bool_]:
        """These robots, as those to heed."""
        heed = np.zeros(self.size, np.bool_)
        heed[list(robots)] = True
        return heed

    def grow(self, robot: int, samples: int) -> None:
        """The robot's graph grows by what so many samples give."""
        graph = self.graphs[robot]
        path = self.paths[robot]
        states = graph.vertices[path] if path is not None else self.guides[robot]
        grow(graph, self.samplers[robot], states, samples)
        self.roads[robot] = ()

    def roads_of(self, robot: int) -> tuple[Roads, ...]:
        """The robot's graph, ready for responses; made anew when it has grown."""
        if not self.roads[robot]:
            arranged = arrange(self.graphs[robot].arrays, self.graphs[robot].surroundings.limits)
            automaton = self.tasks[robot].automaton
            self.roads[robot] = tuple(
                make_roads(arranged, automaton, edge_costs(arranged, component))
                for component in self.problem.costs
            )
        return self.roads[robot]

    def active(self, robot: int) -> bool:
        """Whether the robot's graph has a path that does its task, with nobody about."""
        return self.roads_of(robot)[0].alone < np.inf

    def solo(self) -> NDArray[np.float64]:
        """The least of each component on each robot's graph with nobody about."""
        return np.array(
            [[roads.alone for roads in self.roads_of(robot)] for robot in range(self.size)]
        )

    def best_path(
        self,
        robot: int,
        heed: NDArray[np.bool_],
        tolerated: int = 0,
        whim: np.uint64 | None = None,
    ) -> Response | None:
        """The robot's best path given the heeded robots, in the first component of its cost.

        With `tolerated` it may run into them that many times (`conav.planning.best_response`); a
        `whim` is the seed of random costs, by which it then chooses.
        """
        self.count("responses")
        roads = self.roads_of(robot)[0]
        if whim is not None:
            costs = random_costs(roads.arranged.lengths, whim)
            roads = make_roads(roads.arranged, roads.automaton, costs)
        return best_response(
            roads,
            self.traffic,
            robot,
            self.graphs[robot].surroundings.limits,
            heed,
            np.inf,
            self.tested,
            tolerated,
        )

    def better_path(
        self, robot: int, heed: NDArray[np.bool_], first: bool = False
    ) -> Response | None:
        """A path better than the robot's present one given the heeded robots, in all components.

        The best, or with `first` the first that is found; of several components always the best.
        """
        self.count("responses")
        roads = self.roads_of(robot)
        limits = self.graphs[robot].surroundings.limits
        present = self.costs[robot]
        if len(self.problem.costs) > 1:
            return pareto_response(roads, self.traffic, robot, limits, heed, present, self.tested)
        bound = float(present[0]) - LEAST_GAIN
        respond = first_response if first else best_response
        return respond(roads[0], self.traffic, robot, limits, heed, bound, self.tested)

    def adopt(self, robot: int, response: Response) -> None:
        """The response is the robot's path from now on."""
        graph = self.graphs[robot]
        length, duration = path_costs(graph.surroundings.limits, graph.vertices, response.path)
        by_name = {"length": length, "duration": duration}
        costs = np.array([by_name[component] for component in self.problem.costs])
        self.put(robot, response.path, costs)

    def put(self, robot: int, path: NDArray[np.int64], costs: NDArray[np.float64]) -> None:
        """Gives the robot a path of its graph."""
        self.paths[robot] = path
        self.costs[robot] = costs
        self.traffic.put(robot, self.pieces(robot))

    def drop(self, robot: int) -> None:
        """The robot is without a path."""
        self.paths[robot] = None
        self.costs[robot] = np.inf
        self.traffic.remove(robot)

    def pieces(self, robot: int) -> NDArray[np.float64]:
        """The pieces of the robot's path, which it must have."""
        path = self.paths[robot]
        assert path is not None
        graph = self.graphs[robot]
        return pieces_of(graph.surroundings.limits, graph.vertices[path])

    def straighten(self, robot: int, heed: NDArray[np.bool_]) -> bool:
        """Whether new vertices came in that make the robot's path straighter."""
        path = self.paths[robot]
        if path is None or self.settings.shortcut_tries == 0:
            return False
        graph = self.graphs[robot]
        before = graph.vertices[path]
        after = self.straightened(robot, before, heed, self.settings.shortcut_tries)
        if len(after) == len(before) and np.array_equal(after, before):
            return False
        rows = (between if graph.straight else between_curved)(graph, after, len(after) * 4)
        graph.insert(rows[1:])
        self.roads[robot] = ()
        return True

    def straightened(
        self,
        robot: int,
        path: NDArray[np.float64],
        heed: NDArray[np.bool_],
        tries: int,
        graph: RobotGraph | None = None,
    ) -> NDArray[np.float64]:
        """The states of a path of the robot made straighter, by its own or another graph's rule."""
        self.count("shortcuts")
        graph = graph or self.graphs[robot]
        return (shortcut if graph.straight else shortcut_curved)(
            graph,
            path,
            self.tasks[robot].automaton,
            self.traffic,
            robot,
            heed,
            np.uint64(int(self.samplers[robot].seed) ^ (self.counters["shortcuts"] << 20)),
            tries,
            "duration" in self.problem.costs,
        )

    def trajectory(self, robot: int) -> Trajectory | None:
        """Where the robot goes, None without a path."""
        return None if self.paths[robot] is None else Trajectory(self.pieces(robot))

    def gains(self) -> NDArray[np.float64] | None:
        """What each robot could still gain alone on its graph, (robots,), in one cost.

        0 for a robot with no path and none to be had, infinite for one that could have a path. None
        where costs have several components, of which no single number tells.
        """
        if len(self.problem.costs) > 1:
            return None
        gains = np.zeros(self.size)
        for robot in range(self.size):
            found = self.better_path(robot, self.everybody())
            if found is not None:
                gains[robot] = self.costs[robot, 0] - found.cost
        return gains

    def note(self, budget: Budget, stage: str) -> None:
        """Adds a line to the history if somebody's cost changed."""
        costs = self.costs.tolist()
        if self.history and self.history[-1]["costs"] == costs:
            return
        self.history.append(
            {
                "stage": stage,
                "iteration": budget.iteration,
                "samples": budget.drawn,
                "costs": costs,
            }
        )

    def tell(self, budget: Budget, stage: str) -> None:
        """Tells who listens how far the solver is."""
        budget.tell(stage, self.costs, self.history, self.trajectories)

    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """Everybody's present trajectory."""
        return tuple(self.trajectory(robot) for robot in range(self.size))

    def what_is_missing(self, missing: Sequence[int]) -> str:
        """Why a plan is not complete, in words; `missing` are the robots without a path."""
        if not missing:
            return "the budget ended before nobody could improve any more; raise it"
        names = ", ".join(self.problem.robots[robot].name for robot in missing)
        alone = [robot for robot in missing if not self.active(robot)]
        if alone:
            names_alone = ", ".join(self.problem.robots[robot].name for robot in alone)
            return (
                f"no path yet for {names}, and for {names_alone} not even alone; raise the budget"
            )
        return f"no path past the others yet for {names}; raise the budget"

    def result(
        self,
        status: Status,
        reason: str,
        epsilon: NDArray[np.float64] | None = None,
        iterations: int = 0,
    ) -> PlanningResult:
        """What was found so far, as a result."""
        planned = status != Status.INFEASIBLE
        lengths = self.least_lengths.tolist()
        counters = {
            "vertices": sum(graph.size for graph in self.graphs),
            "edges": sum(graph.edges for graph in self.graphs),
            "samples": sum(int(graph.arrays.counts[SAMPLES]) for graph in self.graphs),
            "edge_tests": sum(int(graph.arrays.counts[EDGE_TESTS]) for graph in self.graphs),
            "collision_checks": int(self.tested[0]),
            "labels": int(self.tested[1]),
            "iterations": iterations,
            **self.counters,
        }
        return PlanningResult(
            status=status,
            reason=reason,
            trajectories=self.trajectories(),
            costs=self.costs.copy(),
            epsilon=epsilon,
            solo=self.solo() if planned else None,
            lower_bound=sum_bound(self.problem, lengths) if planned else None,
            counters=counters,
            graphs=tuple(graph.vertices.copy() for graph in self.graphs),
            history=tuple(self.history),
        )


def build_team(problem: PlanningProblem, settings: GraphSettings, seed: int) -> Team:
    """The team before anything was sampled: graphs of the starts alone.

    Raises `InputError` for a problem with couplings, which no graph of one robot knows.
    """
    refuse_couplings(problem)
    x0, y0, x1, y1 = problem.floor.bounds
    tasks = tuple(task_of(robot) for robot in problem.robots)
    by_radius: dict[tuple[float, bool], Obstacles] = {}
    graphs: list[RobotGraph] = []
    samplers: list[Sampler] = []
    for robot, task in zip(problem.robots, tasks, strict=True):
        limits, start = build_limits(robot), start_state(robot)
        kind = robot.radius_m, limits[MOTION] == STRAIGHT
        if kind not in by_radius:
            spare = 0.0 if kind[1] else SAG
            by_radius[kind] = build_obstacles(
                problem.floor, problem.discs, robot.radius_m, spare_m=spare
            )
        gamma = settings.gamma_m
        if gamma is None:
            gamma = default_gamma(problem.floor.area, robot.speed_mps * problem.horizon_s)
        surroundings = Surroundings(
            by_radius[kind],
            build_regions(task.regions),
            task.masks,
            limits,
            make_rule(settings.eta_m, gamma, len(start), settings.exponent, settings.mode),
        )
        graphs.append(build_graph(surroundings, (x0, y0, x1, y1), problem.horizon_s, start))
        samplers.append(
            Sampler(
                robot_seed(seed, robot.name),
                (x0, y0, x1, y1),
                problem.horizon_s,
                settings.goal_share,
                settings.straight_share,
                settings.wait_share,
                settings.local_share,
            )
        )
    size = len(graphs)
    return Team(
        problem,
        settings,
        tasks,
        tuple(graphs),
        tuple(samplers),
        build_traffic(problem),
        [np.empty((0, STATE))] * size,
        [()] * size,
        [None] * size,
        np.full((size, len(problem.costs)), np.inf),
        np.zeros(size),
    )


def robot_seed(seed: int, name: str) -> np.uint64:
    """The seed of one robot, from the problem's and its name."""
    entropy = [seed, *name.encode()]
    return np.uint64(np.random.SeedSequence(entropy).generate_state(1, np.uint64)[0])
