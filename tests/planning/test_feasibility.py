"""Paths for all at once."""

import numpy as np

from conav.planning.budget import Budget
from conav.planning.draws import Draws
from conav.planning.feasibility import Feasibility, renew_pairs
from conav.planning.lay_guides import lay_guides
from conav.planning.team import GraphSettings, Team, build_team


def hit_pairs(team: Team) -> np.ndarray:
    hit = np.zeros((team.size, team.size), np.bool_)
    renew_pairs(team, list(range(team.size)), hit)
    return hit


def stage(orders: int, repairs: int) -> Feasibility:
    return Feasibility(Draws(np.uint64(5)), orders, repairs, 200)


def test_orders_alone_and_repair_alone_find_paths_for_all(scenes) -> None:
    for orders, repairs in ((20, 0), (0, 200)):
        team = build_team(scenes.antipodal(6, 0.5), GraphSettings(), 1)
        lay_guides(team)
        for robot in range(team.size):
            team.grow(robot, 400)
        budget = Budget(1, None, None)
        assert stage(orders, repairs).find(team, list(range(6)), budget)
        assert all(path is not None for path in team.paths)
        assert not hit_pairs(team).any()


def test_everything_is_as_before_where_nothing_is_found(scenes) -> None:
    team = build_team(scenes.bay(), GraphSettings(), 0)
    lay_guides(team)
    found = team.best_path(0, team.everybody())
    assert found is not None
    team.adopt(0, found)
    before = team.pieces(0)
    assert not stage(1, 0).find(team, [0, 1], Budget(1, None, None))
    assert np.array_equal(team.pieces(0), before)
    assert team.paths[1] is None
    assert np.isinf(team.costs[1, 0])
    assert not team.traffic.conflicts(0).any()


def test_random_choices_are_even_and_repeat() -> None:
    draws, again = Draws(np.uint64(3)), Draws(np.uint64(3))
    numbers = [draws.below(5) for _ in range(2000)]
    assert numbers == [again.below(5) for _ in range(2000)]
    assert np.bincount(numbers).min() > 300
    assert sorted(draws.shuffled([4, 7, 9, 1])) == [1, 4, 7, 9]
