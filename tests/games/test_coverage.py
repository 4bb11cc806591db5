"""The coverage game: potential, and the half that equilibria and greedy choices promise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conav.games.coverage import Coverage, coverage_game, covered, greedy, point_sets
from conav.games.game import profiles
from conav.games.optimum import efficiency, optimum
from conav.games.potential import is_potential
from conav.games.responses import is_equilibrium
from conav.games.weakly_acyclic import weak_acyclicity
from conav.games.wonderful_life import ABSENT

choices = st.lists(st.integers(0, 2**8 - 1), min_size=1, max_size=4).map(tuple)
teams = st.lists(choices, min_size=1, max_size=4).map(tuple)
coverages = st.builds(Coverage, teams, st.integers(0, 2**8 - 1))


def half(points: int) -> Coverage:
    """Player 0 may cover P or Q, which has a point less; player 1 may cover P or one point R."""
    p = (1 << points) - 1
    q = (1 << points - 1) - 1 << points
    return Coverage(((p, q), (p, 1 << 2 * points)))


def test_by_hand() -> None:
    # Points 0 to 3; 3 is known.
    coverage = Coverage(((0b0011, 0b1100), (0b0110,)), known=0b1000)
    assert covered(coverage, (0, 0)) == 3
    assert covered(coverage, (1, 0)) == 2
    assert covered(coverage, (ABSENT, 0)) == 2
    assert covered(coverage, (ABSENT, ABSENT)) == 0
    game = coverage_game(coverage)
    assert game.actions == (2, 1)
    assert game.utility(0, (0, 0)) == 1
    assert game.utility(0, (1, 0)) == 0
    assert game.utility(1, (0, 0)) == 1
    assert greedy(coverage) == (0, 0)


def test_rows_of_booleans_become_sets() -> None:
    rows = np.zeros((2, 70), dtype=bool)
    rows[0, [0, 8, 69]] = True
    assert point_sets(rows) == ((1 << 0) + (1 << 8) + (1 << 69), 0)
    with pytest.raises(ValueError, match="two dimensions"):
        point_sets([True, False])


@given(coverages)
def test_counts_against_sets_of_points(coverage: Coverage) -> None:
    def points(mask: int) -> set[int]:
        return {p for p in range(8) if mask >> p & 1}

    for profile in profiles(coverage_game(coverage)):
        union = set().union(
            *(points(own[a]) for own, a in zip(coverage.sets, profile, strict=True))
        )
        assert covered(coverage, profile) == len(union - points(coverage.known))


@given(coverages)
def test_new_points_are_the_exact_potential(coverage: Coverage) -> None:
    game = coverage_game(coverage)
    assert is_potential(game, lambda profile: covered(coverage, profile))
    assert weak_acyclicity(game).holds


@given(coverages)
def test_what_only_one_covers_sums_to_no_more_than_the_union(coverage: Coverage) -> None:
    game = coverage_game(coverage)
    for profile in profiles(game):
        total = sum(game.utility(i, profile) for i in range(game.n_players))
        assert total <= covered(coverage, profile)


@given(coverages)
def test_at_least_half_of_the_optimum(coverage: Coverage) -> None:
    best = optimum(coverage.actions, lambda profile: covered(coverage, profile)).welfare
    assert 2 * covered(coverage, greedy(coverage)) >= best
    if best > 0.0:
        found = efficiency(coverage_game(coverage), lambda profile: covered(coverage, profile))
        assert found.price_of_anarchy >= 0.5
        # The optimum is the top of a potential, so it is an equilibrium itself.
        assert found.price_of_stability == 1.0


def test_no_more_than_half_is_promised() -> None:
    coverage = half(100)
    game = coverage_game(coverage)
    found = efficiency(game, lambda profile: covered(coverage, profile))
    assert found.optimum == ((1, 0), 199.0)
    assert is_equilibrium(game, (0, 1))
    assert found.worst == ((0, 1), 101.0)
    assert greedy(coverage) == (0, 1)
    assert found.price_of_anarchy < 0.51


def test_greedy_takes_the_lower_of_equals_and_counts_known_points() -> None:
    assert greedy(Coverage(((0b01, 0b10), (0b01, 0b10)))) == (0, 1)
    assert greedy(Coverage(((0b0011, 0b0100),), known=0b0011)) == (1,)


@pytest.mark.parametrize(
    ("sets", "known", "message"),
    [
        ((), 0, "needs a player"),
        (((1,), ()), 0, "player 1 has 0 actions"),
        (((1, -1),), 0, "integers of 0 or more"),
        (((1,),), -2, "integers of 0 or more"),
    ],
)
def test_bad_sets_are_refused(sets: tuple[tuple[int, ...], ...], known: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Coverage(sets, known)
