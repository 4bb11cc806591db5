"""The map part of a picture: ground, paths, starts, goals and robots, for stills and animations."""

from math import floor, isfinite

import numpy as np
from numpy.typing import NDArray

from conav.geometry.directions import DCOL, DROW
from conav.pictures.canvas import Canvas, clipped
from conav.pictures.marks import Mask, disc, stretches, stroke
from conav.pictures.palette import PAGE, Colours
from conav.pictures.replay import Replay, Team
from conav.pictures.view import Tiles, View

DEAD, ABSENT = 2, 3  # conditions of robots in `StepRecord`
MIN_RADIUS = 3.0  # [pixels] of a robot
FEW = 8  # robots whose paths are drawn a pixel wider
_APART = 0.15  # share of a planning cell that paths are moved at most, down or up


class Scene:
    """What has happened so far in one view, ready to be painted at any moment."""

    def __init__(self, view: View, team: Team, truth: NDArray[np.uint8], colours: Colours) -> None:
        self.view = view
        self.team = team
        self.colours = colours
        self.tiles = Tiles(view, truth, colours)
        longer = max(view.width, view.height)
        # Whole pixels, so that lines along the axes are sharp.
        self._line = max(1 + (longer >= 500) + (longer >= 1300) - (team.size > FEW), 1)
        self._half_mark = max(longer / 320, self._line * 1.5, 2.5)
        self._radius = [
            max(radius * view.pixels_per_m, MIN_RADIUS, self._line + 2.0)
            for radius in team.radius_m
        ]
        self._shift = _shifts(team.size, self._line, team.cell_m * view.pixels_per_m)
        self._cover = np.zeros((view.height, view.width), dtype=np.uint8)
        self._owner = np.zeros((view.height, view.width), dtype=np.uint8)

    def see(self, cells: NDArray[np.int64], replay: Replay) -> None:
        """Add to the ground what the team now knows of these flat fine cells."""
        self.tiles.reveal(cells, replay)

    def drive(self, robot: int, points: NDArray[np.float64]) -> None:
        """Add a stretch of a robot's path through these points [m], shape (m, 2)."""
        if len(points) < 2:
            return
        shift = self._shift[robot]
        pixels = [self._sharp(*self.view.pixel(float(x), float(y))) for x, y in _corners(points)]
        pixels = [(x + 2 * shift, y + shift) for x, y in pixels]
        colour = self.colours.line(robot)
        for x0, y0, x1, y1 in stretches(pixels):
            mask = stroke(x0, y0, x1, y1, self._line / 2)
            new, left, top = clipped(mask, self.view.width, self.view.height)
            box = np.s_[top : top + new.shape[0], left : left + new.shape[1]]
            old = self._cover[box]
            self._owner[box][(new >= old) & (new > 0)] = colour
            np.maximum(old, new, out=old)

    def paint(
        self,
        canvas: Canvas,
        places: NDArray[np.float64],
        step: int,
        *,
        frontier: bool,
        goals: bool,
    ) -> None:
        """Paint all of it with the robots at these places [m], shape (n, 2)."""
        left = self.view.left
        canvas.put(self.tiles.ground(frontier=frontier), left, 0)
        canvas.paint_layer(self._cover, self._owner, left, 0)
        team = self.team
        for robot in range(team.size):
            x, y = self.view.pixel(*team.track[0, robot])
            self._paint_start(canvas, robot, left + x, y)
        if goals:
            for robot in range(team.size):
                goal_x, goal_y = (float(value) for value in team.goals[step, robot])
                if isfinite(goal_x) and (goal_x, goal_y) != tuple(places[robot]):
                    x, y = self.view.pixel(goal_x, goal_y)
                    self._paint_cross(canvas, robot, left + x, y)
        for robot in range(team.size):
            if team.condition[step, robot] == ABSENT:
                continue
            x, y = self.view.pixel(float(places[robot, 0]), float(places[robot, 1]))
            if team.condition[step, robot] == DEAD:
                self._paint_wreck(canvas, robot, left + x, y)
                continue
            heading = int(team.headings[step, robot]) if team.has_heading[robot] else None
            self._paint_robot(canvas, robot, left + x, y, heading)

    def _sharp(self, x: float, y: float) -> tuple[float, float]:
        """The nearest place where a line along an axis covers whole pixels."""
        if self._line % 2:
            return floor(x) + 0.5, floor(y) + 0.5
        return floor(x + 0.5), floor(y + 0.5)

    def _paint_start(self, canvas: Canvas, robot: int, x: float, y: float) -> None:
        canvas.paint(disc(x, y, self._half_mark), self.colours.line(robot))
        canvas.paint(disc(x, y, self._half_mark - max(self._line * 0.7, 1.0)), PAGE)

    def _paint_cross(self, canvas: Canvas, robot: int, x: float, y: float) -> None:
        # Through the middle of a pixel a small cross is as sharp as it can be.
        x, y = floor(x) + 0.5, floor(y) + 0.5
        arm = self._half_mark * 1.2
        for extra, colour in ((1.0, PAGE), (0.0, self.colours.line(robot))):
            half = self._line / 2 + 0.1 + extra
            canvas.paint(stroke(x - arm, y - arm, x + arm, y + arm, half), colour)
            canvas.paint(stroke(x - arm, y + arm, x + arm, y - arm, half), colour)

    def _paint_wreck(self, canvas: Canvas, robot: int, x: float, y: float) -> None:
        """A ring: larger than that of a start."""
        radius = self._radius[robot]
        canvas.paint(disc(x, y, radius + 1.2), PAGE)
        canvas.paint(disc(x, y, radius), self.colours.line(robot))
        canvas.paint(disc(x, y, radius * 0.55), PAGE)

    def _paint_robot(
        self, canvas: Canvas, robot: int, x: float, y: float, heading: int | None
    ) -> None:
        radius, half = self._radius[robot], self._line / 2 + 0.3
        body: list[tuple[Mask, Mask]] = [(disc(x, y, radius + 1.2), disc(x, y, radius))]
        if heading is not None:
            reach = radius + max(radius * 0.7, 2.5)
            tip_x, tip_y = x + DCOL[heading] * reach, y - DROW[heading] * reach
            body.append((stroke(x, y, tip_x, tip_y, half + 1.2), stroke(x, y, tip_x, tip_y, half)))
        for halo, _ in body:
            canvas.paint(halo, PAGE)
        for _, shape in body:
            canvas.paint(shape, self.colours.line(robot))


def _shifts(robots: int, line: int, cell: float) -> list[int]:
    """How far down each robot's path is moved [pixels], so that shared ways do not hide others.

    Moved twice as far to the right as down, paths in all eight directions come apart. Large teams
    have no room for it.
    """
    middle = (robots - 1) / 2
    apart = min(line * 0.75, _APART * cell / max(middle, 1.0))
    if apart < 0.5:
        return [0] * robots
    return [round(robot * apart) - round(middle * apart) for robot in range(robots)]


def _corners(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points without those that lie on the way between their neighbours."""
    moved = np.concatenate([[True], (np.diff(points, axis=0) != 0.0).any(axis=1)])
    points = points[moved]
    if len(points) < 3:
        return points if len(points) > 1 else points.repeat(2, axis=0)
    step = np.diff(points, axis=0)
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    ahead = (step[:-1] * step[1:]).sum(axis=1) > 0.0
    straight = (np.abs(cross) < 1e-9) & ahead
    return points[np.concatenate([[True], ~straight, [True]])]
