"""The graph against its rule, built again by the definition."""

import math

import numpy as np
import pytest

from conav.planning.graph_arrays import EDGES, HEAD, LETTER, TAIL, WORD
from conav.planning.labels import MAX_EVENTS, UNCLEAR, segment_word
from conav.planning.lay_guides import lay_guides
from conav.planning.near import nearest
from conav.planning.obstacles import segment_free
from conav.planning.radius import connection_radius
from conav.planning.team import GraphSettings, Team, build_team


def grown(scenes, mode: str, samples: int, seed: int = 0, batch: int | None = None, **more) -> Team:
    team = build_team(scenes.errand(), GraphSettings(mode=mode, **more), seed)
    lay_guides(team)
    batch = batch or samples
    for _ in range(samples // batch):
        team.grow(0, batch)
    return team


def edges_of(team: Team) -> dict[tuple[int, int], tuple[float, tuple[int, ...] | None]]:
    graph = team.graphs[0].arrays
    found = {}
    for edge in range(int(graph.counts[EDGES])):
        place = int(graph.edges[edge, WORD])
        word = None
        if place >= 0:
            word = tuple(graph.words[place + 1 : place + 1 + graph.words[place]].tolist())
        key = (int(graph.edges[edge, TAIL]), int(graph.edges[edge, HEAD]))
        assert key not in found
        found[key] = (float(graph.lengths[edge]), word)
    return found


def edges_by_the_rule(team: Team, mode: str) -> dict:
    """All pairs of vertices, one by one."""
    surroundings = team.graphs[0].surroundings
    eta, gamma, root, _ = surroundings.rule.tolist()
    speed = float(surroundings.limits[0])
    vertices = team.graphs[0].vertices.tolist()
    letters = team.graphs[0].arrays.links[:, LETTER]
    masks = surroundings.masks
    index = {int(mask): letter for letter, mask in enumerate(masks)}
    found = {}
    for u, (ax, ay, at) in enumerate(vertices):
        for w, (bx, by, bt) in enumerate(vertices):
            if not at < bt or (mode == "paper" and u > w):
                continue
            square = (bx - ax) ** 2 + (by - ay) ** 2
            reach = (speed * (bt - at)) ** 2
            radius = connection_radius(max(u, w) + 1, gamma, eta, int(root))
            if square > reach or square + reach > radius**2:
                continue
            if not segment_free(*surroundings.obstacles, ax, ay, bx, by):
                continue
            word = np.empty(3 * MAX_EVENTS, np.int64)
            first, last = int(masks[letters[u]]), int(masks[letters[w]])
            changes = segment_word(
                *surroundings.regions, ax, ay, bx, by, first, last, np.empty(MAX_EVENTS), word
            )
            if changes == UNCLEAR or (changes > 1 and mode == "paper"):
                continue
            letters_on_it = tuple(index[int(mask)] for mask in word[:changes])
            found[u, w] = (math.sqrt(square), letters_on_it if changes > 1 else None)
    return found


@pytest.mark.parametrize(
    ("mode", "exponent", "gamma"),
    [("forward", "d", None), ("forward", "d+1", 4.0), ("paper", "d", 12.0), ("paper", "d+1", 9.0)],
)
def test_edges_are_those_of_the_rule(scenes, mode: str, exponent: str, gamma: float | None) -> None:
    team = grown(scenes, mode, 500, exponent=exponent, gamma_m=gamma)
    found, expected = edges_of(team), edges_by_the_rule(team, mode)
    assert found.keys() == expected.keys()
    assert len(found) > 200
    for key, (length, word) in expected.items():
        assert math.isclose(found[key][0], length, rel_tol=1e-12, abs_tol=1e-15)
        assert found[key][1] == word
    if mode == "forward" and gamma is None:
        assert any(word for _, word in found.values())


def test_older_graphs_are_part_of_newer_ones(scenes) -> None:
    for mode in ("forward", "paper"):
        before, after = grown(scenes, mode, 200), grown(scenes, mode, 400)
        size = before.graphs[0].size
        assert np.array_equal(after.graphs[0].vertices[:size], before.graphs[0].vertices)
        old = edges_of(before)
        assert old.items() <= edges_of(after).items()


def test_batches_and_room_change_nothing(scenes) -> None:
    whole, parts = grown(scenes, "forward", 600), grown(scenes, "forward", 600, batch=20)
    assert np.array_equal(whole.graphs[0].vertices, parts.graphs[0].vertices)
    assert edges_of(whole) == edges_of(parts)
    other = grown(scenes, "forward", 600, seed=1)
    assert not np.array_equal(whole.graphs[0].vertices[-50:], other.graphs[0].vertices[-50:])


def test_two_robots_of_other_names_sample_other_places(scenes) -> None:
    team = build_team(scenes.antipodal(2), GraphSettings(guide=False), 0)
    for robot in range(2):
        team.grow(robot, 50)
    assert team.samplers[0].seed != team.samplers[1].seed


def test_nearest_is_the_nearest_that_can_reach(scenes) -> None:
    team = grown(scenes, "forward", 1500)
    graph = team.graphs[0]
    states = graph.vertices
    random = np.random.default_rng(5)
    reached = 0
    for _ in range(300):
        x, y = random.uniform(0, 20, 2)
        t = random.uniform(0, 90)
        found = nearest(*graph.arrays[:3], graph.arrays.box, graph.size, 1.0, x, y, t)
        square = (states[:, 0] - x) ** 2 + (states[:, 1] - y) ** 2
        reach = t - states[:, 2]
        able = (square <= reach**2) & (reach > 0)
        if not able.any():
            assert found == -1
            continue
        away = np.where(able, square + reach**2, np.inf)
        assert found == int(np.argmin(away))
        reached += 1
    assert reached > 100


def test_every_vertex_but_the_start_has_a_way_in(scenes) -> None:
    for mode in ("forward", "paper"):
        team = grown(scenes, mode, 300)
        heads = {head for _, head in edges_of(team)}
        assert heads >= set(range(1, team.graphs[0].size))
