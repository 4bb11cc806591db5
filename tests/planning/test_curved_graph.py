"""Graphs of curved motions against their rule; distances and words are the verifier's."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.curves import SAG, pieces_word
from conav.planning.graph_arrays import EDGES, HEAD, LETTER, TAIL, WORD
from conav.planning.labels import UNCLEAR, build_regions, point_label
from conav.planning.lay_guides import lay_guides
from conav.planning.motion_states import come_to_rest, soonest, state_on_way
from conav.planning.piece import state_on_piece
from conav.planning.radius import connection_radius, fifth_root
from conav.planning.steering import MAX_PIECES, build_limits, connection
from conav.planning.team import GraphSettings, Team, build_team
from conav.planning.trajectory import length
from conav.planning.types import DOUBLE_INTEGRATOR, DUBINS_CAR, PIECE, Region, Trajectory
from conav.planning.verify_curves import least_from_segment
from conav.planning.verify_regions import words
from conav.planning.verify_scene import Area

from .test_trajectory import any_piece

STARTS = {DOUBLE_INTEGRATOR: (2.0, 2.0, 0.0, 0.3), DUBINS_CAR: (2.0, 2.0, 0.5)}


def grown(scenes, motion: str, mode: str, samples: int) -> Team:
    problem = scenes.errand()
    robot = replace(
        problem.robots[0], motion=motion, start=STARTS[motion], radius_m=0.6, speed_mps=1.5
    )
    pillars = np.array([(x, y, 0.5) for x in range(4, 19, 4) for y in range(4, 19, 4)], float)
    problem = replace(problem, robots=(robot,), discs=pillars)
    team = build_team(problem, GraphSettings(mode=mode, gamma_m=60.0), 3)
    lay_guides(team)
    team.grow(0, samples)
    return team


@pytest.mark.parametrize("motion", STARTS)
@pytest.mark.parametrize("mode", ["forward", "paper"])
def test_edges_are_those_of_the_rule(scenes, motion: str, mode: str) -> None:
    team = grown(scenes, motion, mode, 200 if mode == "forward" else 1000)
    graph, robot = team.graphs[0].arrays, team.problem.robots[0]
    surroundings = team.graphs[0].surroundings
    eta, gamma, root, _ = surroundings.rule.tolist()
    assert root == len(STARTS[motion]) + 1
    states = team.graphs[0].vertices
    found = {
        (int(graph.edges[e, TAIL]), int(graph.edges[e, HEAD])): e
        for e in range(int(graph.counts[EDGES]))
    }
    assert len(found) == graph.counts[EDGES] > 150
    walls = np.hstack([surroundings.obstacles.shapes])
    areas = {
        str(bit): Area(region.disc, region.polygon)
        for bit, region in enumerate(team.tasks[0].regions)
    }
    masks = surroundings.masks
    pieces = np.empty((MAX_PIECES, PIECE))
    left_out = 0
    for u, w in np.ndindex(len(states), len(states)):
        dx, dy, dt = (states[w] - states[u])[:3].tolist()
        radius = connection_radius(max(u, w) + 1, gamma, eta, int(root))
        plane, cone = dx * dx + dy * dy, (robot.speed_mps * dt) ** 2
        if dt <= 0 or plane > cone or plane + cone > radius**2 or (mode == "paper" and u > w):
            assert (u, w) not in found
            continue
        count = connection(surroundings.limits, states, u, w, pieces)
        if count == 0:
            assert (u, w) not in found
            continue
        way = pieces[:count].copy()
        spare = min(
            least_from_segment(piece, wall[:4], math.inf)[1] - wall[4]
            for piece in way
            for wall in walls
        )
        readings = words(way, areas)
        letters = [sum(1 << int(name) for name in letter) for letter in readings[0]]
        if (u, w) not in found:
            left_out += 1
            unclear = len(readings) > 1
            assert spare < SAG + 1e-6 or unclear or (mode == "paper" and len(letters) > 2)
            continue
        assert spare >= -1e-9
        edge = found[u, w]
        assert math.isclose(graph.lengths[edge], length(Trajectory(way)), rel_tol=1e-12)
        place = int(graph.edges[edge, WORD])
        first, last = (int(masks[graph.links[each, LETTER]]) for each in (u, w))
        if place >= 0:
            new = [int(masks[i]) for i in graph.words[place + 1 : place + 1 + graph.words[place]]]
        else:
            new = [] if first == last else [last]
        assert [first, *new] in [
            [sum(1 << int(name) for name in letter) for letter in reading] for reading in readings
        ]
    assert left_out > 2 or mode == "paper"


@settings(max_examples=150, deadline=None)
@given(any_piece(), st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 2))
def test_words_of_pieces_are_the_verifiers(
    piece: np.ndarray, x: float, y: float, size: float
) -> None:
    corners = np.array([(x, y), (x + size, y - 0.1), (x + 0.3, y + 2 * size)])
    regions = (Region("a", disc=(x, y, size)), Region("b", polygon=corners))
    arrays = build_regions(regions)
    ends = [state_on_piece(piece, t)[:2] for t in piece[:2]]
    first, last = (point_label(*arrays, *end) for end in ends)
    word = np.empty(192, np.int64)
    changes = pieces_word(*arrays, piece[None], 1, first, last, np.empty(64), word)
    readings = words(piece[None], {r.name: Area(r.disc, r.polygon) for r in regions})
    if len(readings) > 1:
        return  # touched, or so nearly that either is right
    expected = [("a" in letter) + 2 * ("b" in letter) for letter in readings[0]]
    assert changes != UNCLEAR
    assert [first, *word[:changes].tolist()] == expected


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([DOUBLE_INTEGRATOR, DUBINS_CAR]),
    st.tuples(*[st.floats(-3, 3)] * 4),
    st.floats(0.05, 0.95),
)
def test_parts_of_a_soonest_way_are_ways(scenes, motion: str, numbers: tuple, share: float) -> None:
    """Chains of vertices along a way rest on this; a double integrator's from rest to rest."""
    robot = replace(scenes.antipodal(2).robots[0], motion=motion, start=STARTS[motion])
    limits = build_limits(robot)
    x, y, heading, last_heading = numbers
    rest = [[0.0, 0.0]] * 2 if motion == DOUBLE_INTEGRATOR else [[heading], [last_heading]]
    pair = np.array([[0.0, 0.0, 1.0, *rest[0]], [x, y, 0.0, *rest[1]]])
    pieces = np.empty((MAX_PIECES, PIECE))
    count = soonest(limits, pair, pieces)
    if math.hypot(x, y) < 0.01:
        return
    assert count > 0
    middle = np.empty(pair.shape[1])
    state_on_way(limits, pair[0], pieces, count, 1.0 + share * (pair[1, 2] - 1.0), middle)
    rows = np.array([pair[0], middle, pair[1]])
    assert connection(limits, rows, 0, 1, pieces) > 0
    end = state_on_piece(pieces[connection(limits, rows, 0, 1, pieces) - 1], middle[2])
    assert math.dist(end[:2], middle[:2]) < 1e-9
    assert connection(limits, rows, 1, 2, pieces) > 0


def test_coming_to_rest(scenes) -> None:
    robot = replace(scenes.antipodal(2).robots[0], motion=DOUBLE_INTEGRATOR, start=(0, 0, 0, 0),
                    acceleration_mps2=0.5)  # fmt: skip
    states = np.array([[1.0, 2.0, 3.0, 0.6, -0.8]])
    state = np.empty(5)
    come_to_rest(build_limits(robot), states, 0, state)
    assert np.allclose(state, [1.6, 1.2, 5.0, 0.0, 0.0], atol=1e-8)  # v / a, v^2 / 2a


def test_fifth_root() -> None:
    for x in (0.0, 1e-9, 0.003, 0.03125, 0.7, 1.0):
        assert math.isclose(fifth_root(x), x**0.2, rel_tol=2e-15, abs_tol=0.0)
