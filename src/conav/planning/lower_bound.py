"""How far a robot must drive at least, whatever the walls and the others."""

import heapq

import numpy as np
from numpy.typing import NDArray

from conav.planning.letters import Task, point_distance, region_distance
from conav.planning.types import PlanningProblem, PlanningRobot
from conav.tasks.automaton import INITIAL

_Node = tuple[int, int, int]
"""State, letter, and where from: a letter with regions, or -1 for the start."""


def shortest_length(robot: PlanningRobot, task: Task, start_letter: int) -> float:
    """A length [m] that every path which does the task has at least; infinite if none can.

    A shortest way through the automaton, where a label that is entered costs the distance to its
    farthest region from the label before that had one, or from the start.
    """
    between = _distances(task)
    from_start = [point_distance(robot.start[0], robot.start[1], region) for region in task.regions]
    automaton = task.automaton
    masks: list[int] = task.masks.tolist()
    first: _Node = (int(automaton.transition[INITIAL, start_letter]), start_letter, -1)
    best: dict[_Node, float] = {first: 0.0}
    heap: list[tuple[float, _Node]] = [(0.0, first)]
    while heap:
        length, node = heapq.heappop(heap)
        if length > best[node]:
            continue
        state, letter, origin = node
        if automaton.accepting[state]:
            return length
        for to in range(len(masks)):
            after = int(automaton.transition[state, to])
            if to == letter or automaton.sink[after]:
                continue
            entered = _bits(masks[to])
            if not entered:
                step, place = 0.0, origin
            elif origin < 0:
                step, place = max(from_start[bit] for bit in entered), to
            else:
                left = _bits(masks[origin])
                step, place = max(between[a, b] for a in left for b in entered), to
            found = length + step
            there = (after, to, place)
            if found < best.get(there, np.inf):
                best[there] = found
                heapq.heappush(heap, (found, there))
    return np.inf


def sum_bound(problem: PlanningProblem, lengths: list[float]) -> float:
    """What the first components of all costs sum up to at least, from each one's least length."""
    if problem.costs[0] == "length":
        return sum(lengths)
    return sum(
        length / robot.speed_mps for length, robot in zip(lengths, problem.robots, strict=True)
    )


def _distances(task: Task) -> NDArray[np.float64]:
    count = len(task.regions)
    distances = [region_distance(a, b) for a in task.regions for b in task.regions]
    return np.array(distances).reshape(count, count)


def _bits(mask: int) -> list[int]:
    return [bit for bit in range(mask.bit_length()) if mask >> bit & 1]
