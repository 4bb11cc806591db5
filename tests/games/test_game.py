"""Games, profiles and tables."""

import pickle

import numpy as np
import pytest

from conav.games import game as room
from conav.games.game import (
    Game,
    check_profile,
    deviate,
    first_where,
    game_from_tables,
    profile_table,
    profiles,
    tabulate,
)


def weighted(player: int, profile: tuple[int, ...]) -> float:
    return 100.0 * player + sum(10.0**-k * action for k, action in enumerate(profile))


def test_profiles_come_in_order() -> None:
    assert list(profiles(Game((2, 1, 3), weighted))) == [
        (a, 0, c) for a in range(2) for c in range(3)
    ]


def test_a_table_holds_every_utility() -> None:
    game = Game((2, 3, 2), weighted)
    table = tabulate(game)
    assert table.shape == (3, 2, 3, 2)
    for player in range(3):
        for profile in profiles(game):
            assert table[(player, *profile)] == weighted(player, profile)
    with pytest.raises(ValueError, match="read-only"):
        table[0, 0, 0, 0] = 1.0


def test_tables_give_the_game_back() -> None:
    source = np.arange(12.0).reshape(2, 2, 3)
    game = game_from_tables(source)
    source[:] = 0.0  # copied before
    assert game.actions == (2, 3)
    assert game.utility(1, (0, 2)) == 8.0
    assert tabulate(game).tolist() == np.arange(12.0).reshape(2, 2, 3).tolist()
    assert tabulate(pickle.loads(pickle.dumps(game))).tolist() == tabulate(game).tolist()


def test_profile_tables_come_from_functions_and_tables() -> None:
    table = profile_table((2, 3), lambda profile: profile[0] * 10.0 + profile[1])
    assert table.tolist() == [[0, 1, 2], [10, 11, 12]]
    assert profile_table((2, 3), table).tolist() == table.tolist()
    with pytest.raises(ValueError, match=r"shape \(2, 3\), the game's actions are \(3, 2\)"):
        profile_table((3, 2), table)


def test_deviate_changes_one_action() -> None:
    assert [deviate((4, 5, 6), player, 9) for player in range(3)] == [
        (9, 5, 6),
        (4, 9, 6),
        (4, 5, 9),
    ]


def test_first_where_is_the_first_in_order() -> None:
    mask = np.zeros((2, 2, 2), dtype=bool)
    assert first_where(mask) is None
    mask[1, 0, 0] = mask[0, 1, 1] = True
    assert first_where(mask) == (0, 1, 1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Game((), weighted), "needs a player"),
        (lambda: Game((2, 0), weighted), "player 1 has 0 actions"),
        (lambda: game_from_tables([1.0, 2.0]), "shape"),
        (lambda: game_from_tables(np.zeros((3, 2, 2))), "n players need shape"),
        (lambda: game_from_tables(np.zeros((2, 2, 0))), "player 1 has 0 actions"),
        (lambda: game_from_tables([[0.0, np.nan]]), r"utility at \(0, 1\) is nan"),
        (lambda: tabulate(Game((2,), lambda *_: np.inf)), r"utility at \(0, 0\) is inf"),
        (lambda: profile_table((2,), lambda _: np.nan), r"value at \(0,\) is nan"),
        (lambda: check_profile(Game((2, 2), weighted), (1,)), "1 actions for 2 players"),
        (lambda: check_profile(Game((2, 2), weighted), (1, 2)), "player 1 has actions 0 to 1"),
        (lambda: check_profile(Game((2, 2), weighted), (-1, 0)), "profile has -1"),
    ],
)
def test_bad_input_is_named(make, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


def test_tables_that_are_too_large_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "LARGEST_TABLE", 8)
    assert tabulate(Game((2, 2), weighted)).size == 8
    with pytest.raises(ValueError, match="12 numbers are too many"):
        tabulate(Game((2, 3), weighted))
