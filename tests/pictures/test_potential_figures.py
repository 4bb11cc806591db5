"""The figures of [Philip2014]: their data against numbers found by hand, and their files."""

from collections.abc import Callable
from math import hypot
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.exploration.belief import Belief, new_scratch
from conav.exploration.turn_sequences import (
    TurnMemory,
    best_of,
    points_in_square,
    sequence_gains,
)
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.pictures.potential_figures import (
    EAST,
    FIGURE_2,
    FIGURES,
    NORTH,
    GridGame,
    Player,
    discovered,
    figure_1_positions,
    figure_4_squares,
    new_points,
    points_in_range,
    points_to_scan,
    save_figure_4,
    save_figure_5,
)
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import sensor

# Figure 2 by hand. Within 2 of (4, 1), rows from below: 3 points, 4 with (2, 1), 3, and (4, 3).
PLAYER_1 = {
    (3, 0), (4, 0), (5, 0),
    (2, 1), (3, 1), (4, 1), (5, 1),
    (3, 2), (4, 2), (5, 2),
    (4, 3),
}  # fmt: skip
# Within 2 of (1, 3); only (-1, 3) is off the grid.
PLAYER_2 = {
    (1, 1),
    (0, 2), (1, 2), (2, 2),
    (0, 3), (1, 3), (2, 3), (3, 3),
    (0, 4), (1, 4), (2, 4),
    (1, 5),
}  # fmt: skip
NEW = (
    # To (5, 1): all in its range but (5, 3) were in range from (4, 1). The second position is off
    # the grid.
    {(5, 3)},
    # To (4, 2), in range beside known ones: (4, 4), (5, 3), and player 2's (2, 2) and (3, 3).
    {(4, 4), (5, 3)},
    # To (3, 1): (2, 0), and player 2's (1, 1), (2, 2) and (3, 3).
    {(2, 0)},
    # To (4, 0): (2, 0); everything else was in range from (4, 1).
    {(2, 0)},
)


def test_figure_1_positions() -> None:
    assert figure_1_positions() == {1: (0, 2), 2: (0, 1), 3: (-1, 0), 4: (0, -1), 5: (1, 0)}


def test_figure_2_is_the_game_of_the_text() -> None:
    first, second = FIGURE_2.players
    assert FIGURE_2.size == 6
    assert (first.x, first.y, first.pose) == (4, 1, (1, 0))
    assert FIGURE_2.on_grid((second.x, second.y))
    assert second.pose == (0, 1)


def test_figure_2_discovered_points() -> None:
    assert discovered(FIGURE_2) == (PLAYER_1, PLAYER_2)
    assert (len(PLAYER_1), len(PLAYER_2)) == (11, 12)


def test_figure_2_new_points() -> None:
    assert new_points(FIGURE_2, 0) == NEW


def test_figure_2_alone_going_back_would_be_as_good_as_left() -> None:
    """Without player 2, four points wait on either side; with it, only the left has two."""
    alone = GridGame(6, 2, FIGURE_2.players[:1])
    assert [len(points) for points in new_points(alone, 0)] == [1, 4, 4, 1]


def test_a_range_of_1() -> None:
    """From (4, 1) with range 1: forward finds two corners, left (4, 3), (3, 2) and (5, 2)."""
    game = GridGame(6, 1, (Player(4, 1, EAST),))
    assert [len(points) for points in new_points(game, 0)] == [2, 3, 3, 2]


def in_disc(x: int, y: int, s_range: int, size: int) -> list[int]:
    """Flat indices of the cells within a range, by their definition."""
    every = [(row, col) for row in range(size) for col in range(size)]
    return [row * size + col for row, col in every if hypot(row - y, col - x) <= s_range]


def belief_of(game: GridGame) -> TeamView:
    """What player 1 knows when all have scanned: a cell of a map for each point of the game."""
    grid = OccupancyGrid(np.zeros((game.size, game.size), dtype=np.uint8), 1.0)
    plan = planning_grid(grid, cell_m=1.0, radius_m=0.1, diagonal=False)
    belief = Belief(plan)
    scratch = new_scratch(plan)
    for player in game.players:
        seen = in_disc(player.x, player.y, game.s_range, game.size)
        cell = player.y * game.size + player.x
        belief.hear(plan, cell, np.array(seen, dtype=np.int32), scratch)
    first = game.players[0]
    body = Robot("r", motion=MOTIONS["forward-turn"], sensor=sensor("disc", float(game.s_range)))
    nobody = np.full(len(game.players), -1, dtype=np.int32)
    cell = first.y * game.size + first.x
    return TeamView(
        1, 1.0, 0, body, cell, first.heading, belief, plan.lattice, nobody, nobody, nobody == 0
    )


@pytest.mark.parametrize("heading", range(4))
@pytest.mark.parametrize("s_range", [1, 2, 3])
def test_the_strategies_count_the_same(s_range: int, heading: int) -> None:
    others = FIGURE_2.players[1:]
    for x, y in ((4, 1), (2, 2), (3, 3)):
        game = GridGame(6, s_range, (Player(x, y, heading), *others))
        gains = sequence_gains(TurnMemory(), belief_of(game))
        assert gains.tolist() == [len(points) for points in new_points(game, 0)]


def test_figure_2_gains_of_the_strategies() -> None:
    memory = TurnMemory()
    gains = sequence_gains(memory, belief_of(FIGURE_2))
    # The utilities (7) are 11 more each: 12, 13, 12 and 12. Turning left is best.
    assert gains.tolist() == [1, 2, 1, 1] == [len(points) for points in NEW]
    assert best_of(gains, "baseline", np.random.default_rng(0)) == 1


def test_figure_4_squares() -> None:
    squares = figure_4_squares()
    centres = {square.number: square.centre for square in squares}
    assert centres == {1: (0, 2), 2: (0, 1), 3: (1, 0), 4: (-1, 0), 5: (0, -1)}
    # Sequences in the order of (2): forward, left, back, right.
    assert [square.sequence for square in squares] == [0, 0, 3, 1, 2]
    for square in squares[2:]:
        k = (NORTH + square.sequence) % 4
        assert square.centre == (DCOL[k], DROW[k])


@pytest.mark.parametrize(("s_range", "total"), [(1, 40), (2, 120), (3, 240), (4, 400)])
def test_figure_4_total(s_range: int, total: int) -> None:
    scanned = [len(points_to_scan(square.centre, s_range)) for square in figure_4_squares()]
    assert sum(scanned) == total == 20 * (s_range**2 + s_range)
    assert set(scanned) == {points_in_square(s_range)}


@pytest.mark.parametrize(("s_range", "scanned", "seen"), [(1, 8, 5), (2, 24, 13), (3, 48, 29)])
def test_figure_5_points(s_range: int, scanned: int, seen: int) -> None:
    square, disc = points_to_scan((0, 0), s_range), points_in_range((0, 0), s_range)
    assert (len(square), len(disc)) == (scanned, seen)
    assert disc - square == {(0, 0)}


def test_figure_5_points_for_2() -> None:
    corners_and_beside = {
        (x, y) for x in (-2, -1, 1, 2) for y in (-2, -1, 1, 2) if abs(x) == 2 or abs(y) == 2
    }
    assert points_to_scan((0, 0), 2) - points_in_range((0, 0), 2) == corners_and_beside
    assert points_in_range((7, 3), 2) == {(x + 7, y + 3) for x, y in points_in_range((0, 0), 2)}


@pytest.mark.parametrize("number", FIGURES)
def test_figures_are_pictures_and_repeat(number: int, tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        FIGURES[number](tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as picture:
        picture.load()
        assert picture.width == 1280
        # Something is drawn, and in colour.
        assert picture.convert("HSV").getchannel("S").getextrema()[1] > 200


@pytest.mark.parametrize("save", [save_figure_4, save_figure_5])
def test_figures_with_another_range(save: Callable[..., None], tmp_path: Path) -> None:
    save(tmp_path / "a.svg", s_range=3)
    assert (tmp_path / "a.svg").read_bytes().startswith(b"<?xml")


def test_there_is_a_function_for_each_figure_drawn_by_hand() -> None:
    assert list(FIGURES) == [1, 2, 4, 5]
