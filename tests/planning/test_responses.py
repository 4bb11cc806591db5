"""Responses against all paths of small random graphs, one by one."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.arranged import Arranged
from conav.planning.best_response import LEAST_GAIN, best_response, make_roads
from conav.planning.first_response import first_response
from conav.planning.pareto_response import _can_better, pareto_response
from conav.planning.traffic import Traffic, build_traffic, hits
from conav.planning.types import PIECE, PlanningProblem
from conav.tasks.automaton import INITIAL, Automaton
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, disjoint_letters

SPEED = 2.0
HORIZON = 12.0
FORMULAS = ("F a", "F a & F b", "F a & G !b", "(!b U a) & F b")


class Small:
    """A random graph, automaton and traffic, and every path of it."""

    def __init__(self, scenes, seed: int, parts: int = 1) -> None:
        random = np.random.default_rng(seed)
        size = int(random.integers(4, 13))
        times = np.sort(np.concatenate([[0.0], random.uniform(0.5, HORIZON - 1, size - 1)]))
        if random.uniform() < 0.3:
            times[-1] = times[-2]  # at the same time
        states = np.column_stack([random.uniform(0, 6, (size, 2)), times])
        formula = FORMULAS[int(random.integers(len(FORMULAS)))]
        letters = disjoint_letters(["a", "b"])
        self.automaton: Automaton = automaton_of(parse_formula(formula), letters)
        self.letters = random.choice(3, size, p=(0.5, 0.3, 0.2)).astype(np.int32)
        self.ends = np.random.default_rng(seed + 100_000).uniform(size=size) < 0.8
        self.words: dict[tuple[int, int], tuple[int, ...]] = {}
        self.costs: dict[tuple[int, int], np.ndarray] = {}
        pool: list[int] = []
        places: list[int] = []
        starts, sources = [0], []
        for head in range(size):
            for tail in range(head):
                if times[tail] == times[head] or random.uniform() < 0.25:
                    continue
                ends = (int(self.letters[tail]), int(self.letters[head]))
                places.append(-1)
                self.words[tail, head] = () if ends[0] == ends[1] else (ends[1],)
                if random.uniform() < 0.2:  # through another region on the way
                    between = int(random.choice([x for x in range(3) if x not in ends]))
                    places[-1] = len(pool)
                    self.words[tail, head] = (between, ends[1])
                    pool += [2, between, ends[1]]
                sources.append(tail)
                # Few values, so that ties and dominance happen.
                self.costs[tail, head] = random.integers(0, 4, parts).astype(float)
            starts.append(len(sources))
        self.arranged = Arranged(
            np.arange(size),
            states,
            self.letters,
            self.ends,
            np.array(starts, np.int64),
            np.array(sources, np.int32),
            np.zeros(len(sources)),
            np.array(places, np.int32),
            np.array(pool, np.int32),
        )
        self.traffic = self.traffic_of(scenes, random)
        self.limits = np.array([1000.0, 0.0, 0.0])
        self.size = size
        columns = np.array([self.costs[key] for key in self.words]).reshape(-1, parts)
        self.roads = tuple(
            make_roads(self.arranged, self.automaton, np.ascontiguousarray(columns[:, i]))
            for i in range(parts)
        )
        self.heed = np.array([True, True, random.uniform() < 0.8])

    def traffic_of(self, scenes, random: np.random.Generator) -> Traffic:
        robots = scenes.antipodal(3, 0.4).robots
        after = ["stay" if random.uniform() < 0.5 else "vanish" for _ in robots]
        robots = tuple(
            replace(robot, after_arrival=end) for robot, end in zip(robots, after, strict=True)
        )
        traffic = build_traffic(PlanningProblem(scenes.square, robots, HORIZON))
        for other in (1, 2):
            at, to = random.uniform(0, 6, (2, 2))
            end = random.uniform(3, HORIZON)
            pieces = np.zeros((1, PIECE))
            pieces[0, :6] = 0.0, end, *at, *((to - at) / end)
            traffic.put(other, pieces)
        return traffic

    def edge_hits(self, tail: int, head: int) -> int:
        a, b = self.arranged.states[tail], self.arranged.states[head]
        piece = np.zeros((1, PIECE))
        dt = b[2] - a[2]
        piece[0, :6] = a[2], b[2], a[0], a[1], (b[0] - a[0]) / dt, (b[1] - a[1]) / dt
        return hits(*self.traffic.arrays, 0, self.heed, piece, 1, 99)

    def rest_hits(self, vertex: int) -> int:
        x, y, t = self.arranged.states[vertex]
        if not self.traffic.stays[0] or t >= HORIZON:
            return 0
        piece = np.zeros((1, PIECE))
        piece[0, :4] = t, HORIZON, x, y
        return hits(*self.traffic.arrays, 0, self.heed, piece, 1, 99)

    def paths(self):
        """(cost vector, hits, path) of every path that does the task."""
        start = int(self.automaton.transition[INITIAL, self.letters[0]])
        stack = [((0,), start, np.zeros(len(self.roads)), 0)]
        while stack:
            path, state, cost, run_into = stack.pop()
            if self.automaton.accepting[state] and self.ends[path[-1]]:
                yield cost, run_into + self.rest_hits(path[-1]), path
            for (tail, head), word in self.words.items():
                if tail == path[-1]:
                    after = state
                    for letter in word:
                        after = int(self.automaton.transition[after, letter])
                    more = self.edge_hits(tail, head)
                    stack.append(
                        ((*path, head), after, cost + self.costs[tail, head], run_into + more)
                    )


def check_scalar(scenes, seed: int) -> int:
    small = Small(scenes, seed)
    every = list(small.paths())
    free = [cost[0] for cost, run_into, _ in every if run_into == 0]
    counters = np.zeros(2, np.int64)
    arguments = (small.roads[0], small.traffic, 0, small.limits, small.heed)
    found = best_response(*arguments, np.inf, counters)
    assert (found is None) == (not free)
    alone = min((cost[0] for cost, _, _ in every), default=np.inf)
    assert small.roads[0].alone == alone
    by_path = {path: (cost[0], run_into) for cost, run_into, path in every}
    if found is not None:
        assert found.cost == min(free)
        assert by_path[tuple(found.path.tolist())] == (found.cost, 0)
        assert best_response(*arguments, found.cost, counters) is None
    for bound in (0.0, 2.0, 5.0, np.inf):
        better = [cost for cost in free if cost < bound]
        first = first_response(*arguments, bound, counters)
        assert (first is None) == (not better)
        if first is not None:
            assert by_path[tuple(first.path.tolist())] == (first.cost, 0)
            assert first.cost in better
    for tolerated in (1, 2, 1000):
        least = min(((run, cost[0]) for cost, run, _ in every if run <= tolerated), default=None)
        found = best_response(*arguments, np.inf, counters, tolerated)
        assert (found is None) == (least is None)
        if found is not None:
            assert (found.conflicts, found.cost) == least
            assert by_path[tuple(found.path.tolist())] == (found.cost, found.conflicts)
    return len(every)


def check_vector(scenes, seed: int, parts: int) -> int:
    small = Small(scenes, seed, parts)
    every = list(small.paths())
    free = [tuple(cost.tolist()) for cost, run_into, _ in every if run_into == 0]
    counters = np.zeros(2, np.int64)
    random = np.random.default_rng(seed)
    bounds = [np.full(parts, np.inf), *random.integers(1, 9, (4, parts)).astype(float)]
    for present in bounds:
        better = [
            cost
            for cost in free
            if all(c <= p for c, p in zip(cost, present, strict=True))
            and any(c < p - LEAST_GAIN for c, p in zip(cost, present, strict=True))
        ]
        found = pareto_response(
            small.roads, small.traffic, 0, small.limits, small.heed, present, counters
        )
        assert (found is None) == (not better)
        if found is not None:
            total = np.zeros(parts)
            path = found.path.tolist()
            for tail, head in pairwise(path):
                total += small.costs[tail, head]
                assert small.edge_hits(tail, head) == 0
            assert tuple(total.tolist()) == min(better, key=lambda cost: (sum(cost), cost))
            assert found.cost == total[0]
    return len(every)


def test_scalar_responses_in_many_graphs(scenes) -> None:
    paths = [check_scalar(scenes, seed) for seed in range(200)]
    assert sum(count > 10 for count in paths) > 30


@pytest.mark.parametrize("parts", [1, 2, 3])
def test_vector_responses_in_many_graphs(scenes, parts: int) -> None:
    paths = [check_vector(scenes, 1000 + seed, parts) for seed in range(120)]
    assert sum(count > 10 for count in paths) > 20


def test_an_edge_that_is_the_best_for_two_states(scenes) -> None:
    """Somebody stands in the way from 2 to 4, to which robots come with and without `a` seen."""
    places = [(0, 0), (0, 1), (1, 0), (3, 3), (3, 0), (4, 0), (5, 0)]
    times = [0.0, 1.0, 2.0, 2.5, 4.0, 5.0, 6.0]
    costs = {(0, 1): 1.0, (0, 2): 1.0, (1, 2): 1.0, (1, 3): 2.0, (2, 4): 1.0, (3, 4): 5.0,
             (4, 5): 1.0, (4, 6): 1.0, (5, 6): 1.0}  # fmt: skip
    edges = sorted(costs, key=lambda edge: (edge[1], edge[0]))
    arranged = Arranged(
        np.arange(7),
        np.column_stack([places, times]),
        np.array([0, 1, 0, 0, 0, 1, 2], np.int32),
        np.ones(7, np.bool_),
        np.searchsorted([head for _, head in edges], np.arange(8)).astype(np.int64),
        np.array([tail for tail, _ in edges], np.int32),
        np.zeros(len(edges)),
        np.full(len(edges), -1, np.int32),
        np.empty(0, np.int32),
    )
    automaton = automaton_of(parse_formula("F a & F b"), disjoint_letters(["a", "b"]))
    roads = make_roads(arranged, automaton, np.array([costs[edge] for edge in edges]))
    traffic = build_traffic(PlanningProblem(scenes.square, scenes.antipodal(2, 0.4).robots, 12.0))
    arguments = (roads, traffic, 0, np.array([1000.0, 0.0, 0.0]), np.ones(2, np.bool_), np.inf)
    counters = np.zeros(2, np.int64)
    alone = best_response(*arguments, counters)
    assert alone is not None
    assert alone.path.tolist() == [0, 1, 2, 4, 6]
    traffic.put(1, np.array([[0.0, 1.0, 2.0, 0.0, 0, 0, 0, 0, 0]]))
    found = best_response(*arguments, counters)
    assert found is not None
    assert (found.path.tolist(), found.cost, found.conflicts) == ([0, 1, 3, 4, 6], 9.0, 0)


@given(st.integers(10**6, 10**9))
@settings(max_examples=40, deadline=None)
def test_scalar_and_vector_responses(scenes, seed: int) -> None:
    check_scalar(scenes, seed)
    check_vector(scenes, seed, 2)


def test_rounding_of_one_cost_hides_no_gain_in_another() -> None:
    none_left = np.zeros(2)
    present = np.array([5.0, 20.0])
    assert _can_better(np.array([5.0 + 1e-10, 5.0]), none_left, present)
    assert not _can_better(np.array([5.0 + 1e-6, 5.0]), none_left, present)
    assert not _can_better(np.array([5.0, 20.0 - 1e-10]), none_left, present)
