"""Routes over pieces of lanes against plain Python, and against all routes where these are few."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.compiled import Kernel
from conav.exploration import sweep_routes
from conav.exploration.sweep_routes import TOTAL, Routes, improve, no_routes, route_length, travel

SEEDS = st.integers(0, 2**32 - 1)
DIAGONALS = (2.0**0.5, 2.0)


def distance(a: NDArray[np.float64], b: NDArray[np.float64], diagonal: float) -> float:
    """Of a king who pays `diagonal` for a diagonal move."""
    straight, both = sorted(abs(a - b))[::-1]
    return float(straight - both + diagonal * both)


def length_of(
    route: list[tuple[int, int]],
    ends: NDArray[np.float64],
    start: NDArray[np.float64],
    diagonal: float,
) -> float:
    here, total = start, 0.0
    for piece, turned in route:
        first, second = ends[piece, turned], ends[piece, 1 - turned]
        total += distance(here, first, diagonal) + distance(first, second, diagonal)
        here = second
    return total


def routes_of(routes: Routes) -> list[list[tuple[int, int]]]:
    return [
        list(zip(pieces[:count].tolist(), turned[:count].tolist(), strict=True))
        for pieces, turned, count in zip(
            routes.pieces, routes.turned, routes.count.tolist(), strict=True
        )
    ]


def cost_of(lengths: list[float]) -> float:
    return max(lengths) + TOTAL * sum(lengths) / len(lengths)


def instance(
    rng: np.random.Generator, n_pieces: int, n_robots: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pieces of lanes, some of them places, and robots, on a field of 40 x 40."""
    ends = rng.integers(0, 40, (n_pieces, 2, 2)).astype(np.float64)
    ends[:, 1, 1] = ends[:, 0, 1]
    places = rng.random(n_pieces) < 0.2
    ends[places, 1] = ends[places, 0]
    return ends, rng.integers(0, 40, (n_robots, 2)).astype(np.float64)


def some_routes(rng: np.random.Generator, n_pieces: int, n_robots: int) -> Routes:
    """Some of the pieces, in any order; lengths that are wrong."""
    routes = no_routes(n_robots, n_pieces)
    for piece in rng.permutation(n_pieces)[: int(rng.integers(0, n_pieces + 1))]:
        robot = int(rng.integers(n_robots))
        routes.pieces[robot, routes.count[robot]] = piece
        routes.turned[robot, routes.count[robot]] = rng.integers(2)
        routes.count[robot] += 1
    routes.length[:] = rng.random(n_robots) * 1000
    return routes


def check(
    routes: Routes, ends: NDArray[np.float64], starts: NDArray[np.float64], diagonal: float
) -> None:
    """Every piece once, and lengths that are those of the routes."""
    found = routes_of(routes)
    assert sorted(piece for route in found for piece, _ in route) == list(range(len(ends)))
    assert {turned for route in found for _, turned in route} <= {0, 1}
    lengths = [
        length_of(route, ends, start, diagonal) for route, start in zip(found, starts, strict=True)
    ]
    assert routes.length == pytest.approx(lengths)
    assert routes.cost() == pytest.approx(cost_of(lengths))


@settings(deadline=None)
@given(st.integers(-50, 50), st.integers(-50, 50), st.sampled_from(DIAGONALS))
def test_travel_is_the_length_of_a_way(down: int, right: int, diagonal: float) -> None:
    expected = distance(np.array([3.0, 4.0]), np.array([3.0 + down, 4.0 + right]), diagonal)
    assert travel(3.0, 4.0, 3.0 + down, 4.0 + right, diagonal) == pytest.approx(expected)


def test_travel_by_hand() -> None:
    assert travel(0.0, 0.0, 3.0, -5.0, 2.0) == 8.0
    assert travel(0.0, 0.0, 3.0, -5.0, 2.0**0.5) == pytest.approx(2 + 3 * 2.0**0.5)


def test_a_route_by_hand() -> None:
    ends = np.array([[[0.0, 0.0], [10.0, 0.0]], [[0.0, 5.0], [10.0, 5.0]]])
    # Up the first lane, over to the second, and down.
    length = route_length(
        np.array([0, 1]), np.array([0, 1]), 2, ends, np.array([-2.0, 0.0]), 2.0**0.5
    )
    assert length == 2 + 10 + 5 + 10
    best = improve(
        no_routes(1, 2), ends, np.array([[-2.0, 0.0]]), 2.0**0.5, 50, np.random.default_rng(0)
    )
    assert routes_of(best) == [[(0, 0), (1, 1)]]
    # Two robots take one each, from where they are nearer.
    starts = np.array([[-2.0, 0.0], [12.0, 5.0]])
    best = improve(no_routes(2, 2), ends, starts, 2.0**0.5, 50, np.random.default_rng(0))
    assert routes_of(best) == [[(0, 0)], [(1, 1)]]
    assert best.length.tolist() == [12.0, 12.0]
    assert best.cost() == pytest.approx(12.0 * (1 + TOTAL))


@settings(deadline=None)
@given(
    SEEDS,
    st.integers(1, 25),
    st.integers(1, 5),
    st.integers(0, 120),
    st.sampled_from(DIAGONALS),
)
def test_every_piece_once_no_worse_and_repeatable(
    seed: int, n_pieces: int, n_robots: int, rounds: int, diagonal: float
) -> None:
    rng = np.random.default_rng(seed)
    ends, starts = instance(rng, n_pieces, n_robots)
    given_routes = some_routes(rng, n_pieces, n_robots)
    before = given_routes.copy()
    made = [
        improve(given_routes, ends, starts, diagonal, k, np.random.default_rng(seed))
        for k in (0, rounds, rounds)
    ]
    for routes in made:
        check(routes, ends, starts, diagonal)
    completed, best, again = made
    assert best.cost() <= completed.cost() + 1e-9
    for name in ("pieces", "turned", "count", "length"):
        assert np.array_equal(getattr(given_routes, name), getattr(before, name))
        assert np.array_equal(getattr(best, name), getattr(again, name))
    # What was given stays in its order when the missing pieces are put in.
    for given_route, route in zip(routes_of(before), routes_of(completed), strict=True):
        assert [stop for stop in route if stop in given_route] == given_route


def best_cost(ends: NDArray[np.float64], starts: NDArray[np.float64], diagonal: float) -> float:
    """The least cost of all routes there are."""
    n_pieces, n_robots = len(ends), len(starts)
    # The least length of each robot over each set of pieces.
    least: dict[tuple[int, frozenset[int]], float] = {}
    for size in range(n_pieces + 1):
        for order in permutations(range(n_pieces), size):
            for ways in product((0, 1), repeat=size):
                route = list(zip(order, ways, strict=True))
                for robot, start in enumerate(starts):
                    key = (robot, frozenset(order))
                    length = length_of(route, ends, start, diagonal)
                    least[key] = min(length, least.get(key, np.inf))
    return min(
        cost_of(
            [
                least[robot, frozenset(i for i in range(n_pieces) if owner[i] == robot)]
                for robot in range(n_robots)
            ]
        )
        for owner in product(range(n_robots), repeat=n_pieces)
    )


def test_the_best_of_all_routes_where_they_are_few() -> None:
    optimal = 0
    cases = 40
    for seed in range(cases):
        rng = np.random.default_rng(seed)
        n_pieces, n_robots = 1 + seed % 4, 1 + seed // 4 % 2
        ends, starts = instance(rng, n_pieces, n_robots)
        diagonal = DIAGONALS[seed % 2]
        found = improve(
            no_routes(n_robots, n_pieces), ends, starts, diagonal, 300, np.random.default_rng(seed)
        ).cost()
        best = best_cost(ends, starts, diagonal)
        assert found >= best - 1e-9
        assert found <= 1.1 * best
        optimal += found <= best + 1e-9
    assert optimal >= 0.9 * cases


def test_a_back_and_forth_is_found() -> None:
    """Twelve lanes of 60 side by side and one robot at a corner: the snake is the best there is."""
    ends = np.array([[[0.0, 9.0 * lane], [60.0, 9.0 * lane]] for lane in range(12)])
    rng = np.random.default_rng(1)
    routes = improve(no_routes(1, 12), ends, np.array([[0.0, 0.0]]), 2.0**0.5, 1000, rng)
    assert routes.length[0] == 12 * 60 + 11 * 9


def test_routes_are_balanced() -> None:
    """Two robots in one corner share twelve lanes almost evenly."""
    ends = np.array([[[0.0, 9.0 * lane], [60.0, 9.0 * lane]] for lane in range(12)])
    starts = np.zeros((2, 2))
    routes = improve(no_routes(2, 12), ends, starts, 2.0**0.5, 2000, np.random.default_rng(1))
    # Six lanes each and somebody drives to the far side: no plan is shorter than that.
    assert routes.length.max() <= 1.1 * (6 * 60 + 11 * 9)
    assert routes.length.min() >= 6 * 60


def test_no_pieces() -> None:
    starts = np.zeros((3, 2))
    routes = improve(
        no_routes(3, 0), np.empty((0, 2, 2)), starts, 2.0, 10, np.random.default_rng(0)
    )
    assert routes.count.tolist() == [0, 0, 0]
    assert routes.length.tolist() == [0.0, 0.0, 0.0]
    assert routes.cost() == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_kernels_do_what_their_source_says(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled against interpreted, callees included."""
    rng = np.random.default_rng(seed)
    n_pieces, n_robots = int(rng.integers(1, 9)), int(rng.integers(1, 4))
    ends, starts = instance(rng, n_pieces, n_robots)
    routes = some_routes(rng, n_pieces, n_robots)
    compiled = improve(routes, ends, starts, 2.0**0.5, 25, np.random.default_rng(seed))
    for name, value in vars(sweep_routes).copy().items():
        if isinstance(value, Kernel):
            monkeypatch.setattr(sweep_routes, name, value.python)
    with np.errstate(over="ignore"):  # of the generator, which is meant to
        plain = improve(routes, ends, starts, 2.0**0.5, 25, np.random.default_rng(seed))
    for name in ("pieces", "turned", "count"):
        assert np.array_equal(getattr(compiled, name), getattr(plain, name))
    assert compiled.length == pytest.approx(plain.length)
