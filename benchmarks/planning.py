"""How fast planning is, on one core: graphs, responses, first plans, and how near to exact.

Prints the median and the spread over repetitions of
- extends a second up to 3,000 and 10,000 vertices (20 x 20 m, 60 s, 10 discs, eta 3 m, labels),
- a round of best responses of 8 robots with 3,000 vertices each and a task with an automaton,
- the time to the first plan of all of 8 discs across a circle,
- one robot among 70 discs: its length over the exact one, after 0.5 and 2 seconds.
Times are processor seconds where nothing else is said. The first line is what a fixed piece of work
took, by which tables of different days and machines can be compared.
"""

import argparse
import heapq
import math
from statistics import median
from time import perf_counter, process_time

import numpy as np

from conav.maps.polygon_map import PolygonMap
from conav.planning.plan import plan
from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.types import PlanningProblem, PlanningRobot, Region
from decisions import calibration

SIDE = 20.0
SQUARE = PolygonMap([(0, 0), (SIDE, 0), (SIDE, SIDE), (0, SIDE)])
ERRAND = "F goal & F dock & G !pit"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("--queries", type=int, default=20)
    options = parser.parse_args()
    print(calibration())
    extends(options.repeat)
    rounds(options.repeat)
    first_plans(options.repeat)
    against_exact(options.queries)


def shown(values: list[float], unit: str, scale: float = 1.0, digits: int = 1) -> str:
    low, middle, high = min(values) * scale, median(values) * scale, max(values) * scale
    return f"{middle:,.{digits}f} {unit} ({low:,.{digits}f} to {high:,.{digits}f})"


def scattered(count: int, seed: int, side: float, small: float, large: float, gap: float):
    """Discs that leave a gap between each other and to the border."""
    random = np.random.default_rng(seed)
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        r = random.uniform(small, large)
        x, y = random.uniform(r + gap, side - r - gap, 2)
        if all(math.hypot(x - u, y - v) > r + s + gap for u, v, s in found):
            found.append((x, y, r))
    return np.array(found)


def free_places(count: int, seed: int, discs: np.ndarray, side: float, margin: float):
    random = np.random.default_rng(seed)
    found: list[tuple[float, float]] = []
    while len(found) < count:
        x, y = random.uniform(margin, side - margin, 2)
        clear = all(math.hypot(x - u, y - v) > r + margin for u, v, r in discs)
        if clear and all(math.hypot(x - u, y - v) > 2 * margin for u, v in found):
            found.append((x, y))
    return found


def errands(count: int) -> PlanningProblem:
    discs = scattered(10, 1, SIDE, 0.4, 1.0, 1.2)
    places = free_places(3 * count, 2, discs, SIDE, 0.55)
    robots = tuple(
        PlanningRobot(
            f"r{i}",
            places[3 * i],
            ERRAND,
            {
                "goal": Region("goal", disc=(*places[3 * i + 1], 0.5)),
                "dock": Region("dock", disc=(*places[3 * i + 2], 0.5)),
                "pit": Region("pit", disc=(10.0, 10.0, 0.5)),
            },
            0.3,
        )
        for i in range(count)
    )
    return PlanningProblem(SQUARE, robots, 60.0, discs)


def extends(repeat: int) -> None:
    problem = errands(1)
    for vertices in (3000, 10_000):
        rates: list[float] = []
        for seed in range(repeat + 1):
            team = build_team(problem, GraphSettings(), seed)
            start = process_time()
            samples = 0
            while team.graphs[0].size < vertices:
                team.grow(0, 500)
                samples += 500
            rates.append(samples / (process_time() - start))
        print(f"extends up to {vertices:6,} vertices:", shown(rates[1:], "a second", digits=0))


def rounds(repeat: int) -> None:
    team: Team = build_team(errands(8), GraphSettings(), 0)
    for robot in range(team.size):
        while team.graphs[robot].size < 3000:
            team.grow(robot, 100)
    everybody = team.everybody()
    times: dict[str, list[float]] = {"first paths": [], "nobody improves": []}
    for _ in range(repeat + 1):
        for robot in range(team.size):
            team.drop(robot)
            team.roads_of(robot)
        for name in times:
            start = process_time()
            for robot in range(team.size):
                found = team.better_path(robot, everybody)
                if found is not None:
                    team.adopt(robot, found)
            times[name].append(process_time() - start)
            while any(respond(team, robot) for robot in range(team.size)):
                pass
    for name, taken in times.items():
        text = shown(taken[1:], "ms", 1000.0)
        print(f"a round of 8 robots x 3,000 vertices, {name}:", text)


def respond(team: Team, robot: int) -> bool:
    found = team.better_path(robot, team.everybody())
    if found is not None:
        team.adopt(robot, found)
    return found is not None


def first_plans(repeat: int) -> None:
    robots = []
    for i in range(8):
        dx, dy = 8 * math.cos(math.pi * i / 4), 8 * math.sin(math.pi * i / 4)
        goal = {"goal": Region("goal", disc=(10 - dx, 10 - dy, 0.5))}
        robots.append(PlanningRobot(f"r{i}", (10 + dx, 10 + dy), "F goal", goal, 0.5))
    problem = PlanningProblem(SQUARE, tuple(robots), 60.0)
    times: list[float] = []
    for seed in range(repeat + 1):
        start = process_time()
        found = plan(
            problem,
            seed=seed,
            samples=20_000,
            on_progress=lambda progress: not np.isfinite(progress.costs).all(),
        )
        assert all(found.trajectories)
        times.append(process_time() - start)
    print("first plan of 8 discs across a circle:", shown(times[1:], "s", digits=3))


def against_exact(queries: int) -> None:
    side, radius = 66.0, 0.4
    discs = scattered(70, 7, side, 1.0, 3.0, 1.0)
    floor = PolygonMap([(0, 0), (side, 0), (side, side), (0, side)])
    places = free_places(2 * queries, 8, discs, side, 1.0)
    ratios: dict[float, list[float]] = {0.5: [], 2.0: []}
    for i in range(queries):
        start, goal = places[2 * i], places[2 * i + 1]
        region = Region("goal", disc=(*goal, 0.01))
        robot = PlanningRobot("a", start, "F goal", {"goal": region}, radius)
        problem = PlanningProblem(floor, (robot,), 200.0, discs)
        exact = shortest_among_discs(start, goal, discs + np.array([0, 0, radius])) - 0.01
        for seconds, found in ratios.items():
            wall = perf_counter()
            result = plan(problem, seed=i, samples=None, time_s=seconds)
            assert perf_counter() - wall < 1.5 * seconds + 1 or i == 0
            found.append(float(result.costs[0, 0]) / exact)
    for seconds, found in ratios.items():
        text = shown([100 * (ratio - 1) for ratio in found], "%", digits=3)
        print(f"70 discs, {seconds} s of wall time, longer than exact by:", text)


def shortest_among_discs(start, goal, discs: np.ndarray) -> float:
    """The exact length of a shortest way from point to point around discs that do not meet.

    Dijkstra's algorithm on the tangent graph: straight ways that touch discs at their ends, and
    arcs of the discs between the places where they are touched.
    """
    circles = [(*start, 0.0), (*goal, 0.0), *map(tuple, discs.tolist())]
    touched: list[list[tuple[float, int]]] = [[] for _ in circles]  # (angle, node)
    nodes: list[tuple[float, float]] = []
    edges: dict[int, list[tuple[int, float]]] = {}

    def node(circle: int, x: float, y: float) -> int:
        nodes.append((x, y))
        cx, cy, _ = circles[circle]
        touched[circle].append((math.atan2(y - cy, x - cx), len(nodes) - 1))
        return len(nodes) - 1

    def join(a: int, b: int, length: float) -> None:
        edges.setdefault(a, []).append((b, length))
        edges.setdefault(b, []).append((a, length))

    for i, (ax, ay, ar) in enumerate(circles):
        for j in range(i + 1, len(circles)):
            bx, by, br = circles[j]
            away, angle = math.hypot(bx - ax, by - ay), math.atan2(by - ay, bx - ax)
            tangents = {(s * ar, t * br) for s in (1, -1) for t in (1, -1)}
            for p, q in sorted(tangents):
                if abs(p - q) > away:
                    continue
                # The line's normal n has n . (b - a) = p - q with signed radii p and q.
                normal = angle + math.acos((p - q) / away)
                nx, ny = math.cos(normal), math.sin(normal)
                ux, uy, vx, vy = ax + p * nx, ay + p * ny, bx + q * nx, by + q * ny
                if free_line(ux, uy, vx, vy, circles, (i, j)):
                    length = math.hypot(vx - ux, vy - uy)
                    join(node(i, ux, uy), node(j, vx, vy), length)
    for (_, _, r), places in zip(circles, touched, strict=True):
        places.sort()
        for (one, a), (two, b) in zip(places, places[1:] + places[:1], strict=True):
            if a != b:
                join(a, b, r * ((two - one) % (2 * math.pi)))
    ends = {place for _, place in touched[1]}
    best = {place: 0.0 for _, place in touched[0]}
    heap = [(0.0, place) for place in best]
    heapq.heapify(heap)
    while heap:
        length, at = heapq.heappop(heap)
        if at in ends:
            return length
        if length > best[at]:
            continue
        for to, step in edges.get(at, ()):
            if length + step < best.get(to, math.inf):
                best[to] = length + step
                heapq.heappush(heap, (length + step, to))
    return math.inf


def free_line(ax, ay, bx, by, circles, but: tuple[int, int]) -> bool:
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    for i, (cx, cy, r) in enumerate(circles):
        if i in but or r == 0.0:
            continue
        along = min(max(((cx - ax) * dx + (cy - ay) * dy) / square, 0.0), 1.0) if square else 0.0
        if math.hypot(ax + along * dx - cx, ay + along * dy - cy) < r - 1e-12:
            return False
    return True


if __name__ == "__main__":
    main()
