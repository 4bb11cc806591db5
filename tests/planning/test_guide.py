"""Guides: first paths by a search over cells."""

import heapq
import math

import numpy as np
import pytest

from conav.planning.guide import STEPS, build_cells, delayed, guide_path
from conav.planning.lay_guides import lay_guides
from conav.planning.obstacles import segment_free
from conav.planning.team import GraphSettings, build_team


def test_moves_are_the_free_ones(scenes) -> None:
    problem = scenes.errand()
    team = build_team(problem, GraphSettings(), 0)
    obstacles = team.graphs[0].surroundings.obstacles
    cells = build_cells(obstacles, problem.floor.bounds, 1.0)
    rows, columns = cells.moves.shape
    for row in range(rows):
        for column in range(columns):
            x, y = (column + 0.5) * cells.cell, (row + 0.5) * cells.cell
            for step, (du, dv) in enumerate(STEPS.tolist()):
                inside = 0 <= row + dv < rows and 0 <= column + du < columns
                free = inside and segment_free(
                    *obstacles, x, y, x + du * cells.cell, y + dv * cells.cell
                )
                assert bool(cells.moves[row, column] >> step & 1) == free


@pytest.mark.parametrize("cell", [0.4, 0.7])
def test_a_guide_is_a_shortest_way_over_cells(scenes, cell: float) -> None:
    problem = scenes.antipodal(1)
    team = build_team(problem, GraphSettings(), 0)
    graph = team.graphs[0]
    cells = build_cells(graph.surroundings.obstacles, problem.floor.bounds, cell)
    path = guide_path(graph, cells, team.tasks[0].automaton, 60.0)
    assert path is not None
    assert (path[0] == graph.vertices[0]).all()
    assert math.dist(path[-1, :2], (2.0, 10.0)) <= 0.5
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert (steps <= np.diff(path[:, 2]) * 1.0).all()  # no faster than 1 m/s
    assert math.isclose(steps.sum(), plain_dijkstra(graph, cells), rel_tol=1e-9)
    assert guide_path(graph, cells, team.tasks[0].automaton, 10.0) is None  # too late


def plain_dijkstra(graph, cells) -> float:
    x, y, _ = graph.vertices[0].tolist()
    rows, columns = cells.moves.shape
    heap, best = [], {}
    for v in range(int(y / cells.cell) - 2, int(y / cells.cell) + 3):
        for u in range(int(x / cells.cell) - 2, int(x / cells.cell) + 3):
            if 0 <= v < rows and 0 <= u < columns:
                there = (u + 0.5) * cells.cell, (v + 0.5) * cells.cell
                if segment_free(*graph.surroundings.obstacles, x, y, *there):
                    heap.append((math.dist((x, y), there), u, v))
    heapq.heapify(heap)
    while heap:
        length, u, v = heapq.heappop(heap)
        if (u, v) in best:
            continue
        best[u, v] = length
        if math.dist(((u + 0.5) * cells.cell, (v + 0.5) * cells.cell), (2.0, 10.0)) <= 0.5:
            return length
        for step, (du, dv) in enumerate(STEPS.tolist()):
            if cells.moves[v, u] >> step & 1:
                heapq.heappush(heap, (length + cells.cell * math.hypot(du, dv), u + du, v + dv))
    return math.inf


def test_guides_become_part_of_graphs(scenes) -> None:
    problem = scenes.errand()
    team = build_team(problem, GraphSettings(), 0)
    assert not team.active(0)
    lay_guides(team)
    assert team.active(0)
    assert team.guides[0][-1, 2] <= problem.horizon_s
    without = build_team(problem, GraphSettings(guide=False), 0)
    lay_guides(without)
    assert without.graphs[0].size == 1


def test_delayed_copies() -> None:
    rows = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 2.0]])
    assert delayed(rows, 2.0, 2, 5.5).tolist() == [[0, 0, 3], [1, 0, 4], [0, 0, 5]]
