"""Figures 1, 2, 4 and 5 of [Philip2014], drawn from the definitions. Needs the extra `[plot]`.

The paper's points are (x, y) with y to the north. Each figure has a function with its data and one
that draws it. What the text of the paper leaves open is chosen here, and the picture says so.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from conav.exploration.turn_sequences import points_in_square, predicted_positions
from conav.geometry.directions import DCOL, DROW
from conav.pictures.palette import CURVE, PAGE, TEXT, UNKNOWN_GROUND
from conav.pictures.plots import (
    Colour,
    figure_file,
    page_colour,
    series_colours,
    write_note,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Point = tuple[int, int]

EAST, NORTH = 0, 1

_SEQUENCES = ("forward, forward", "turn +90°, forward", "turn 180°, forward", "turn -90°, forward")


@dataclass(frozen=True)
class Player:
    """A robot of a grid game."""

    x: int
    y: int
    heading: int  # 0 to 3 for E, N, W, S

    @property
    def pose(self) -> Point:
        """The unit vector it faces along."""
        return DCOL[self.heading], DROW[self.heading]


@dataclass(frozen=True)
class GridGame:
    """Robots on the grid points 0 to `size` - 1 both ways, each with a sensor of `s_range`."""

    size: int
    s_range: int
    players: tuple[Player, ...]

    def on_grid(self, point: Point) -> bool:
        return 0 <= point[0] < self.size and 0 <= point[1] < self.size


@dataclass(frozen=True)
class Square:
    """A numbered square of Figure 4, around a position where the robot would be."""

    number: int
    centre: Point
    sequence: int  # place in (2), 0 for the baseline


FIGURE_2 = GridGame(6, 2, (Player(4, 1, EAST), Player(1, 3, NORTH)))
"""Player 1 and the grid are the paper's; it says nothing of player 2's place, nor of sRange."""


def figure_1_positions() -> dict[int, Point]:
    """Number -> point: where a robot at (0, 0) facing north expects to be, as section 2.1.3 counts.

    2 and 1 are those of the baseline at the ends of time t and t + 1, 3 to 5 those of the turns by
    +90, 180 and -90 degrees at the end of t + 1.
    """
    baseline, left, back, right = _sequence_positions(Player(0, 0, NORTH))
    return {1: baseline[1], 2: baseline[0], 3: left[0], 4: back[0], 5: right[0]}


def discovered(game: GridGame) -> tuple[frozenset[Point], ...]:
    """The points each player has discovered from where it stands, (5)."""
    return tuple(
        frozenset(filter(game.on_grid, points_in_range((player.x, player.y), game.s_range)))
        for player in game.players
    )


def new_points(game: GridGame, player: int) -> tuple[frozenset[Point], ...]:
    """The points each of a player's four sequences would discover that nobody has; from (17).

    A position off the grid cannot be taken and discovers nothing.
    """
    known = frozenset[Point]().union(*discovered(game))
    found: list[frozenset[Point]] = []
    for positions in _sequence_positions(game.players[player]):
        seen = [points_in_range(p, game.s_range) for p in positions if game.on_grid(p)]
        points = filter(game.on_grid, frozenset[Point]().union(*seen) - known)
        found.append(frozenset(points))
    return tuple(found)


def figure_4_squares() -> tuple[Square, ...]:
    """The squares to be scanned around a robot at (0, 0) facing north, as section 3.1 counts them.

    1 and 2 are the baseline's; 3, 4 and 5 belong to turning right, left and back, another order
    than in Figure 1. Which one of the first two is which the text does not say; as there, 2 is
    taken for the nearer.
    """
    baseline, left, back, right = _sequence_positions(Player(0, 0, NORTH))
    return (
        Square(1, baseline[1], 0),
        Square(2, baseline[0], 0),
        Square(3, right[0], 3),
        Square(4, left[0], 1),
        Square(5, back[0], 2),
    )


def points_to_scan(centre: Point, s_range: int) -> frozenset[Point]:
    """The points of the square around a position but for the position itself, (15)."""
    x0, y0 = centre
    steps = range(-s_range, s_range + 1)
    return frozenset((x0 + dx, y0 + dy) for dx in steps for dy in steps) - {centre}


def points_in_range(centre: Point, s_range: int) -> frozenset[Point]:
    """The points no farther than `s_range` from a position, the position among them."""
    x0, y0 = centre
    within = {
        (x, y)
        for x, y in points_to_scan(centre, s_range)
        if (x - x0) ** 2 + (y - y0) ** 2 <= s_range**2
    }
    return frozenset(within | {centre})


def save_figure_1(path: str | os.PathLike[str]) -> None:
    """Draw Figure 1, a robot's predicted positions for each two-step sequence, to a PNG or SVG."""
    with figure_file(path, height=1180) as figure:
        axes = _grid_axes(figure, "Figure 1. Predicted positions for each two-step sequence")
        _lines(axes, -2, 2, -2, 3)
        colours = series_colours(4)
        sequence_of = {1: 0, 2: 0, 3: 1, 4: 2, 5: 3}
        for number, (x, y) in figure_1_positions().items():
            sequence = sequence_of[number]
            _numbered(axes, (x, y), number, colours[sequence])
            words = _SEQUENCES[sequence].replace(", ", ",\n")
            if sequence == 0:
                words = f"{_SEQUENCES[0]}:\nafter time t" + (" + 1" if number == 1 else "")
            axes.annotate(
                words, (x, y), xytext=(18, 0) if sequence == 0 else (0, -17),
                textcoords="offset points", bbox=_PATCH,
                ha="left" if sequence == 0 else "center", va="center" if sequence == 0 else "top",
            )  # fmt: skip
        _robot(axes, Player(0, 0, NORTH), page_colour(TEXT))
        write_note(
            figure,
            "A turn takes the first step, in which the robot stays where it is; so turn sequences "
            "have one new position, where it is after time t + 1.",
        )


def save_figure_2(path: str | os.PathLike[str]) -> None:
    """Draw Figure 2, a 6 x 6 grid game with two robots and what they have discovered."""
    from matplotlib.patches import Circle

    game = FIGURE_2
    seen = discovered(game)
    gains = [len(points) for points in new_points(game, 0)]
    colours = series_colours(len(game.players))
    with figure_file(path, height=1380) as figure:
        axes = _grid_axes(figure, "Figure 2. A 6 x 6 grid game with two robots")
        last = game.size - 1
        _lines(axes, 0, last, 0, last)
        for player, colour in zip(game.players, colours, strict=True):
            place = (player.x, player.y)
            axes.add_patch(Circle(place, game.s_range, color=colour, alpha=0.10, linewidth=0))
            axes.add_patch(Circle(place, game.s_range, fill=False, color=colour, linewidth=1.2))
        every = [(x, y) for x in range(game.size) for y in range(game.size)]
        for point in every:
            owner = next((i for i, points in enumerate(seen) if point in points), None)
            _dot(axes, point, None if owner is None else colours[owner])
        for i, (player, colour) in enumerate(zip(game.players, colours, strict=True)):
            _robot(axes, player, colour)
            words = f"Player {i + 1} at ({player.x}, {player.y})\nfacing {player.pose}"
            axes.annotate(words, (player.x, player.y), xytext=(0, -16), va="top", ha="center",
                          textcoords="offset points", bbox=_PATCH)  # fmt: skip
        axes.set_xticks(range(game.size))
        axes.set_yticks(range(game.size))
        axes.set_xlim(-1.2, last + 1.2)
        axes.set_ylim(-1.2, last + 0.6)
        write_note(
            figure,
            f"sRange {game.s_range}. Filled points are discovered: {len(seen[0])} by player 1, "
            f"{len(seen[1])} by player 2. New points for player 1: {gains[0]} by going forward, "
            f"{gains[1]} by turning +90°, {gains[2]} by 180°, {gains[3]} by -90°.\n"
            "Player 2 and sRange are chosen here: the paper's text gives neither.",
        )


def save_figure_4(path: str | os.PathLike[str], *, s_range: int = 2) -> None:
    """Draw Figure 4, a player that considers each two-step sequence, to a PNG or SVG."""
    from matplotlib.patches import Circle, Rectangle

    colours = series_colours(4)
    reach = s_range + 3
    with figure_file(path, height=1340) as figure:
        axes = _grid_axes(figure, "Figure 4. A player considers each two-step sequence")
        _lines(axes, -reach, reach, 1 - reach, reach)
        squares = figure_4_squares()
        for square in squares:
            x, y = square.centre
            colour = colours[square.sequence]
            axes.add_patch(Circle(square.centre, s_range, fill=False, color=colour, alpha=0.6))
            axes.add_patch(
                Rectangle((x - s_range, y - s_range), 2 * s_range, 2 * s_range, fill=False,
                          color=colour, linewidth=2.0,
                          linestyle="-" if square.sequence == 0 else (0, (2.0, 1.5)))
            )  # fmt: skip
        for square in squares:
            x, y = square.centre
            colour = colours[square.sequence]
            _numbered(axes, (x, y), square.number, colour)
            # On the edge that looks away from the robot, beside the middle of it.
            away = (x and x // abs(x), y and y // abs(y))
            edge = (
                x + s_range * away[0] + 0.5 * s_range * abs(away[1]),
                y + s_range * away[1] + 0.5 * s_range * abs(away[0]),
            )
            axes.annotate(str(square.number), edge, ha="center", va="center", color=colour,
                          fontsize=13.0, fontweight="bold", bbox=_PATCH)  # fmt: skip
            if square.number != 2:
                words = _SEQUENCES[square.sequence]
                axes.annotate(
                    words if x == 0 else words.replace(", ", ",\n"),
                    (x + s_range * away[0], y + s_range * away[1]),
                    xytext=(10 * away[0], 10 * away[1]), textcoords="offset points",
                    ha=("right", "center", "left")[away[0] + 1],
                    va=("top", "center", "bottom")[away[1] + 1],
                )  # fmt: skip
        _robot(axes, Player(0, 0, NORTH), page_colour(TEXT))
        each = points_in_square(s_range)
        write_note(
            figure,
            f"sRange {s_range}. Circles are what the sensor would cover, squares what is scanned: "
            f"solid for the baseline, dotted for turns. 5 squares of {each} points make "
            f"{len(squares) * each} = 20 (sRange² + sRange).\nTurns are numbered as in the "
            "text, unlike in Figure 1; that 2 is nearer than 1 is taken from there.",
        )


def save_figure_5(path: str | os.PathLike[str], *, s_range: int = 2) -> None:
    """Draw Figure 5, the square that encloses a sensor's circle, to a PNG or SVG."""
    from matplotlib.patches import Circle, Rectangle

    (colour,) = series_colours(1)
    with figure_file(path, height=1240) as figure:
        axes = _grid_axes(figure, "Figure 5. A square encloses the sensor's circle")
        _lines(axes, -s_range - 1, s_range + 1, -s_range - 1, s_range + 1)
        centre = (0, 0)
        corner = (-s_range, -s_range)
        axes.add_patch(Circle(centre, s_range, facecolor=(*colour, 0.10), edgecolor=colour))
        axes.add_patch(
            Rectangle(corner, 2 * s_range, 2 * s_range, fill=False, linewidth=2.6,
                      edgecolor=page_colour(TEXT))
        )  # fmt: skip
        scanned = points_to_scan(centre, s_range)
        in_range = points_in_range(centre, s_range)
        for point in sorted(scanned):
            _dot(axes, point, None, colour if point in in_range else page_colour(CURVE))
        _dot(axes, centre, page_colour(TEXT))
        # Between the lines of the grid and its diagonals.
        end = (0.8 * s_range, -0.6 * s_range)
        axes.annotate(
            "", end, centre, arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkB": 0.0}
        )
        axes.annotate("sRange", (0.5 * end[0], 0.5 * end[1]), ha="center", va="center",
                      color=colour, bbox=_PATCH)  # fmt: skip
        axes.annotate("robot", centre, xytext=(0, 9), textcoords="offset points", ha="center",
                      va="bottom", bbox=_PATCH)  # fmt: skip
        write_note(
            figure,
            f"sRange {s_range}. The {len(scanned)} hollow points are scanned, (2 sRange + 1)² - 1; "
            f"{len(in_range)} points are in range, the robot's own one among them.",
        )


FIGURES: dict[int, Callable[[str | os.PathLike[str]], None]] = {
    1: save_figure_1,
    2: save_figure_2,
    4: save_figure_4,
    5: save_figure_5,
}
"""Number -> the function that draws the figure to a file."""

# Behind words, so that lines do not run through them.
_PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}


def _sequence_positions(player: Player) -> list[list[Point]]:
    """The new positions of a player's four sequences."""
    predicted = predicted_positions(player.y, player.x, player.heading)
    return [[(col, row) for row, col in positions] for positions in predicted]


def _grid_axes(figure: "Figure", title: str) -> "Axes":
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.spines[:].set_visible(False)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.tick_params(length=0.0)
    figure.suptitle(title, x=0.015, ha="left", fontsize=13.0, fontweight="bold")
    return axes


def _lines(axes: "Axes", x0: int, x1: int, y0: int, y1: int) -> None:
    """The lines whose crossings are the grid points, and room around them."""
    grey = page_colour(UNKNOWN_GROUND)
    axes.vlines(range(x0, x1 + 1), y0, y1, color=grey, linewidth=0.8, zorder=0.5)
    axes.hlines(range(y0, y1 + 1), x0, x1, color=grey, linewidth=0.8, zorder=0.5)
    axes.set_xlim(x0 - 0.1, x1 + 0.1)
    axes.set_ylim(y0 - 0.1, y1 + 0.1)


def _dot(axes: "Axes", point: Point, face: Colour | None, edge: Colour | None = None) -> None:
    """A grid point; without a colour hollow and grey."""
    edge = edge or face or page_colour(CURVE)
    axes.plot([point[0]], [point[1]], marker="o", markersize=8.0, markeredgewidth=1.6,
              markerfacecolor=face or page_colour(PAGE), markeredgecolor=edge)  # fmt: skip


def _numbered(axes: "Axes", point: Point, number: int, colour: Colour) -> None:
    """A position of the robot with its number in it."""
    axes.plot([point[0]], [point[1]], marker="o", markersize=17.0, color=colour, zorder=3.0)
    axes.annotate(str(number), point, ha="center", va="center_baseline", color="white",
                  fontweight="bold", zorder=3.1)  # fmt: skip


def _robot(axes: "Axes", player: Player, colour: Colour) -> None:
    """A square where the robot is and an arrow to where it looks."""
    dx, dy = player.pose
    axes.annotate(
        "", (player.x + 0.55 * dx, player.y + 0.55 * dy), (player.x, player.y), zorder=3.0,
        arrowprops={"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "color": colour,
                    "linewidth": 2.4, "shrinkA": 0.0, "shrinkB": 0.0},
    )  # fmt: skip
    axes.plot([player.x], [player.y], marker="s", markersize=15.0, color=colour, zorder=3.0)
