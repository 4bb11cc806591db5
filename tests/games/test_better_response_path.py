"""Better-response paths: checked, and walked at random."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.games.better_response_path import better_response_path, is_better_response_path
from conav.games.game import Game, game_from_tables
from conav.games.responses import is_equilibrium
from conav.status import Status

DILEMMA = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])
PENNIES = game_from_tables([[[1, -1], [-1, 1]], [[-1, 1], [1, -1]]])


@pytest.mark.parametrize(
    ("path", "is_one"),
    [
        ([(0, 0)], True),
        ([(0, 0), (1, 0)], True),
        ([(0, 0), (1, 0), (1, 1)], True),
        ([(0, 0), (1, 1)], False),  # two players change
        ([(0, 0), (0, 0)], False),  # nobody changes
        ([(1, 0), (0, 0)], False),  # for the worse
        ([(0, 0), (1, 0), (1, 1), (0, 1)], False),
    ],
)
def test_paths_of_the_dilemma(path: list[tuple[int, int]], is_one: bool) -> None:
    assert is_better_response_path(DILEMMA, path) == is_one


def test_a_change_that_gains_nothing_is_no_step() -> None:
    assert not is_better_response_path(game_from_tables([[1, 1]]), [(0,), (1,)])
    game = game_from_tables([[0.0, 0.5]])
    assert is_better_response_path(game, [(0,), (1,)], tolerance=0.4)
    assert not is_better_response_path(game, [(0,), (1,)], tolerance=0.5)


def test_bad_paths_are_refused() -> None:
    with pytest.raises(ValueError, match="at least one"):
        is_better_response_path(DILEMMA, [])
    with pytest.raises(ValueError, match="player 1 has actions 0 to 1"):
        is_better_response_path(DILEMMA, [(0, 0), (0, 2)])


def test_a_walk_that_cannot_end_runs_out_of_budget() -> None:
    walk = better_response_path(PENNIES, (0, 0), np.random.default_rng(1), max_steps=7)
    assert walk.status is Status.OUT_OF_BUDGET
    # Only one player gains in each profile of this game, so the walk goes round.
    ring = [(0, 0), (0, 1), (1, 1), (1, 0)]
    assert list(walk.profiles) == (ring * 2)[:8]


def test_a_walk_may_end_at_the_last_step_of_its_budget() -> None:
    rng = np.random.default_rng(1)
    assert better_response_path(DILEMMA, (0, 0), rng, max_steps=2).status is Status.DONE
    assert better_response_path(DILEMMA, (0, 0), rng, max_steps=1).status is Status.OUT_OF_BUDGET
    assert better_response_path(DILEMMA, (1, 1), rng, max_steps=0).status is Status.DONE


def test_walks_repeat_with_the_seed_and_differ_without() -> None:
    def walk(seed: int) -> tuple[tuple[int, ...], ...]:
        game = Game((4, 4, 4), lambda player, profile: sum(profile))
        return better_response_path(game, (0, 0, 0), np.random.default_rng(seed)).profiles

    assert walk(3) == walk(3)
    assert len({walk(seed) for seed in range(10)}) > 1


shapes = st.lists(st.integers(1, 4), min_size=1, max_size=3).map(tuple)


@given(shapes.flatmap(lambda s: arrays(np.int8, s, elements=st.integers(-9, 9))), st.data())
def test_walks_in_potential_games_end_at_equilibria(phi: np.ndarray, data: st.DataObject) -> None:
    game = game_from_tables([phi] * phi.ndim)  # all get the potential itself
    start = tuple(data.draw(st.integers(0, count - 1)) for count in phi.shape)
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    walk = better_response_path(game, start, rng, max_steps=phi.size)
    assert walk.status is Status.DONE
    assert walk.profiles[0] == start
    assert is_equilibrium(game, walk.profiles[-1])
    assert is_better_response_path(game, walk.profiles)
    values = [phi[profile] for profile in walk.profiles]
    assert values == sorted(set(values))
