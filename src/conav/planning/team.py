"""A team that is being planned for: each robot's task, graph and present path, and the traffic.

Solvers are rules about who answers whom, and when; what they do is all here.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.planning.arranged import arrange
from conav.planning.best_response import (
    LEAST_GAIN,
    Response,
    Roads,
    best_response,
    make_roads,
)
from conav.planning.extend import Sampler, grow
from conav.planning.graph import (
    EDGE_TESTS,
    SAMPLES,
    Exponent,
    Mode,
    RobotGraph,
    Surroundings,
    build_graph,
    make_rule,
)
from conav.planning.labels import build_regions
from conav.planning.letters import Task, task_of
from conav.planning.obstacles import Obstacles, build_obstacles
from conav.planning.radius import cube_root
from conav.planning.shortcut import between, shortcut
from conav.planning.steering import build_limits, pieces_of, start_state
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


@dataclass(eq=False)
class Team:
    """Everything a solver changes. Robots are numbers, in the order of the problem."""

    problem: PlanningProblem
    settings: GraphSettings
    tasks: tuple[Task, ...]
    graphs: tuple[RobotGraph, ...]
    samplers: tuple[Sampler, ...]
    traffic: Traffic
    roads: list[Roads | None]
    paths: list[NDArray[np.int64] | None]
    costs: NDArray[np.float64]  # (robots, components), infinite without a path
    tested: NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, np.int64))
    counters: dict[str, int] = field(default_factory=dict)

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
        states = graph.vertices[path] if path is not None else graph.vertices[:0]
        grow(graph, self.samplers[robot], states, samples)
        self.roads[robot] = None

    def roads_of(self, robot: int) -> Roads:
        """The robot's graph, ready for responses; made anew when it has grown."""
        roads = self.roads[robot]
        if roads is None:
            arranged = arrange(self.graphs[robot].arrays)
            automaton = self.tasks[robot].automaton
            roads = self.roads[robot] = make_roads(arranged, automaton, self.problem.costs[0])
        return roads

    def active(self, robot: int) -> bool:
        """Whether the robot's graph has a path that does its task, with nobody about."""
        return self.roads_of(robot).alone < np.inf

    def response(
        self, robot: int, heed: NDArray[np.bool_], bound: float | None = None, tolerated: int = 0
    ) -> Response | None:
        """What the robot does best given the heeded robots, if it costs less than the bound.

        Without one the bound is what its present path costs, and what a better one must gain.
        """
        self.count("responses")
        limit = float(self.costs[robot, 0]) - LEAST_GAIN if bound is None else bound
        return best_response(
            self.roads_of(robot),
            self.traffic,
            robot,
            self.graphs[robot].surroundings.limits,
            heed,
            limit,
            self.tested,
            tolerated,
        )

    def adopt(self, robot: int, response: Response) -> None:
        """The response is the robot's path from now on."""
        self.put(robot, response.path, np.array([response.cost]))

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
        sampler = self.samplers[robot]
        after = shortcut(
            graph,
            before,
            self.tasks[robot].automaton,
            self.traffic,
            robot,
            heed,
            np.uint64(int(sampler.seed) ^ (self.counters.get("shortcuts", 0) << 20)),
            self.settings.shortcut_tries,
            "duration" in self.problem.costs,
        )
        self.count("shortcuts")
        if len(after) == len(before) and np.array_equal(after, before):
            return False
        rows = between(graph, after, len(after) * 4)
        graph.insert(rows[1:])
        self.roads[robot] = None
        return True

    def trajectory(self, robot: int) -> Trajectory | None:
        """Where the robot goes, None without a path."""
        return None if self.paths[robot] is None else Trajectory(self.pieces(robot))

    def result(self, status: Status, reason: str, **more: object) -> PlanningResult:
        """What was found so far, as a result."""
        counters = {
            "vertices": sum(graph.size for graph in self.graphs),
            "edges": sum(graph.edges for graph in self.graphs),
            "samples": sum(int(graph.arrays.counts[SAMPLES]) for graph in self.graphs),
            "edge_tests": sum(int(graph.arrays.counts[EDGE_TESTS]) for graph in self.graphs),
            "collision_checks": int(self.tested[0]),
            "labels": int(self.tested[1]),
            **self.counters,
        }
        return PlanningResult(
            status=status,
            reason=reason,
            trajectories=tuple(self.trajectory(robot) for robot in range(self.size)),
            costs=self.costs.copy(),
            counters=counters,
            graphs=tuple(graph.vertices.copy() for graph in self.graphs),
            **more,  # pyright: ignore[reportArgumentType]
        )


def build_team(problem: PlanningProblem, settings: GraphSettings, seed: int) -> Team:
    """The team before anything was sampled: graphs of the starts alone."""
    x0, y0, x1, y1 = problem.floor.bounds
    tasks = tuple(task_of(robot) for robot in problem.robots)
    by_radius: dict[float, Obstacles] = {}
    graphs: list[RobotGraph] = []
    samplers: list[Sampler] = []
    for robot, task in zip(problem.robots, tasks, strict=True):
        if robot.radius_m not in by_radius:
            obstacles = build_obstacles(problem.floor, problem.discs, robot.radius_m)
            by_radius[robot.radius_m] = obstacles
        gamma = settings.gamma_m
        if gamma is None:
            gamma = default_gamma(problem.floor.area, robot.speed_mps * problem.horizon_s)
        surroundings = Surroundings(
            by_radius[robot.radius_m],
            build_regions(task.regions),
            task.masks,
            build_limits(robot),
            make_rule(settings.eta_m, gamma, settings.exponent, settings.mode),
        )
        graphs.append(
            build_graph(surroundings, (x0, y0, x1, y1), problem.horizon_s, start_state(robot))
        )
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
        [None] * size,
        [None] * size,
        np.full((size, len(problem.costs)), np.inf),
    )


def robot_seed(seed: int, name: str) -> np.uint64:
    """The seed of one robot, from the problem's and its name."""
    entropy = [seed, *name.encode()]
    return np.uint64(np.random.SeedSequence(entropy).generate_state(1, np.uint64)[0])


def default_gamma(area_m2: float, extent_m: float) -> float:
    """The least gamma of RRG in the plane and time [Karaman2011], times what the cone takes away.

    gamma = 2 (1 + 1/3)^(1/3) (mu / zeta)^(1/3) with mu the measure of places and times, v t in
    metres, and zeta the unit ball's. Of a ball only the cones of what can be reached count, a share
    of (1 - 1/sqrt 2) / 2 on each side: gamma is larger by the cube root of its inverse, 1.9.
    """
    ball = 4.18879020478639
    cone = 0.14644660940672624
    return 2.0 * cube_root(4.0 / 3.0 * area_m2 * extent_m / ball / cone)
