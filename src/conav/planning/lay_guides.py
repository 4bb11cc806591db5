"""Putting a first path of each robot into its graph, from a search over cells."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from conav.planning.curves import SAG
from conav.planning.graph import RobotGraph
from conav.planning.guide import Cells, build_cells, delayed, guide_path
from conav.planning.guide_curved import curved_guide
from conav.planning.obstacles import Obstacles, build_obstacles
from conav.planning.shortcut import between
from conav.planning.shortcut_curved import between_curved
from conav.planning.steering import BOUND, CAR, MOTION, STATE, STRAIGHT
from conav.planning.team import Team

GUIDE_CELLS = (1.0, 0.5)
"""Sizes of the cells that are tried for a guide, in radii of the robot."""

GUIDE_TRIES = 1000
"""At straightening a guide."""

ROOM_TO_TURN = (0.5, 0.25, 0.0)
"""That a car's guide keeps from walls, in radii of its tightest turn, tried one after the other."""

_Guide = tuple[NDArray[np.float64], int]
"""States, and how many vertices may come in while they do."""


@dataclass
class _Places:
    """What guides of robots of one radius share."""

    obstacles: dict[tuple[float, float], Obstacles] = field(default_factory=dict)
    """By radius and what is kept more."""
    cells: dict[tuple[float, float, float], Cells] = field(default_factory=dict)
    """By those and the size of cells."""


def lay_guides(team: Team) -> None:
    """A guide for every robot for which one is found, and its copies some times later."""
    if not team.settings.guide or team.settings.mode == "paper":
        return
    places = _Places()
    for robot, at in enumerate(team.problem.robots):
        graph = team.graphs[robot]
        found = (_straight if graph.straight else _curved)(team, robot, places)
        if found is None:
            continue
        team.guides[robot], room = found
        rows = (between if graph.straight else between_curved)(graph, team.guides[robot], room)
        graph.insert(rows[1:])
        # A little less than half: two of them are then clearly within the radius.
        radius = graph.radius_at(graph.size + len(rows) * team.settings.delays)
        wait = 0.49 * radius / at.speed_mps
        graph.insert(delayed(rows, wait, team.settings.delays, team.problem.horizon_s))
        team.roads[robot] = ()
        team.count("guides")


def _straight(team: Team, robot: int, places: _Places) -> _Guide | None:
    path = next(_paths(team, robot, team.graphs[robot], 0.0, places), None)
    if path is None:
        return None
    return team.straightened(robot, path, team.only([]), GUIDE_TRIES), len(path)


def _curved(team: Team, robot: int, places: _Places) -> _Guide | None:
    """The first straight guide that can be made one of curves, and is then straightened again."""
    problem, graph = team.problem, team.graphs[robot]
    at, limits = problem.robots[robot], graph.surroundings.limits
    for share in ROOM_TO_TURN if limits[MOTION] == CAR else (0.0,):
        more = share * float(limits[BOUND])
        key = at.radius_m, more
        if key not in places.obstacles:
            places.obstacles[key] = build_obstacles(
                problem.floor, problem.discs, at.radius_m + more, spare_m=SAG
            )
        slow = limits.copy()
        slow[MOTION] = STRAIGHT
        line_graph = replace(
            graph,
            surroundings=graph.surroundings._replace(obstacles=places.obstacles[key], limits=slow),
        )
        for path in _paths(team, robot, line_graph, more, places):
            line = path[:, :STATE]
            line = team.straightened(robot, line, team.only([]), GUIDE_TRIES, line_graph)
            guide = curved_guide(graph, line[:, :2], problem.horizon_s)
            if guide is None:
                # Samples are drawn around the line all the same.
                team.guides[robot] = np.zeros((len(line), len(graph.vertices[0])))
                team.guides[robot][:, :STATE] = line
                continue
            guide = team.straightened(robot, guide, team.only([]), GUIDE_TRIES)
            return guide, len(guide)
    return None


def _paths(
    team: Team, robot: int, graph: RobotGraph, more: float, places: _Places
) -> Iterator[NDArray[np.float64]]:
    """Guides as straight lines, from coarse cells and from fine ones."""
    problem = team.problem
    radius = problem.robots[robot].radius_m
    for cell in GUIDE_CELLS:
        key = radius, more, cell
        if key not in places.cells:
            obstacles = graph.surroundings.obstacles
            places.cells[key] = build_cells(obstacles, problem.floor.bounds, radius * cell)
        path = guide_path(graph, places.cells[key], team.tasks[robot].automaton, problem.horizon_s)
        if path is not None:
            yield path
