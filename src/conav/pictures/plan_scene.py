"""A planning scene on a canvas: floor, obstacles, regions, starts, paths and robots."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor, hypot

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.pictures.canvas import Canvas, clipped
from conav.pictures.footer import text_size
from conav.pictures.marks import (
    Mask,
    disc,
    line,
    line_height,
    line_of_text,
    polygon,
    ring_around,
    words_width,
)
from conav.pictures.palette import (
    FRONTIER,
    PAGE,
    SOFT_TEXT,
    TEXT,
    UNKNOWN_GROUND,
    WALL,
    Colours,
)
from conav.planning.trajectory import positions
from conav.planning.types import PlanningProblem, Region, Trajectory
from conav.tasks.formula import Formula, Operator
from conav.tasks.parse import parse_formula

MARGIN = 0.02  # of the longer side of the floor, around it
Box = tuple[slice, slice]  # rows and columns of a page
WHOLE: Box = (slice(None), slice(None))
MANY = 24
"""Teams with more robots have no labels at the places of each robot, which nobody could read."""

_TICKS = 8  # dots on a path, about
_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1))
_HATCH = 9.0  # [pixels] between the lines across a region to keep out of, at 1000 pixels


@dataclass(frozen=True)
class PlanView:
    """Where metres lie on a page: the floor above, a footer below."""

    left_m: float
    top_m: float
    pixels_per_m: float
    width: int  # [pixels]
    height: int  # [pixels] of the floor's part
    page_width: int
    footer_height: int

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a point [m] lies on the page, y down."""
        left = (self.page_width - self.width) // 2
        return left + (x - self.left_m) * self.pixels_per_m, (self.top_m - y) * self.pixels_per_m

    def pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points, shape (n, 2) [m], lie on the page."""
        x, y = self.pixel(0.0, 0.0)
        return np.array([x, y]) + points * np.array([self.pixels_per_m, -self.pixels_per_m])


@dataclass(frozen=True)
class _Place:
    """A region as it is drawn: once, however many robots share it."""

    region: Region
    owner: int | None  # the one robot that knows it; None where several do
    label: str
    kept_out: bool  # somebody's task is to keep out of it
    wanted: bool  # somebody's is not


class PlanScene:
    """A problem in one view, ready to be painted on any canvas of its size."""

    def __init__(self, view: PlanView, problem: PlanningProblem, colours: Colours) -> None:
        self.view = view
        self.problem = problem
        self.colours = colours
        longer = max(view.width, view.height)
        self.line = 1.5 + (longer >= 500) * 0.75 + (longer >= 1300) * 0.75
        if len(problem.robots) > MANY:
            self.line *= 0.7
        self._thin = max(self.line * 0.45, 0.8)
        self._text = max(text_size(view.page_width) - 4, 10)
        self._places = _places(problem)
        self._labels = [
            (place, self._label(place))
            for place in self._places
            if place.owner is None or len(problem.robots) <= MANY
        ]
        self._cover = np.zeros((view.height, view.page_width), dtype=np.uint8)
        self._owner = np.zeros((view.height, view.page_width), dtype=np.uint8)

    def paint_ground(self, canvas: Canvas) -> None:
        """Paint what does not move: floor, walls, obstacles and regions."""
        view = self.view
        canvas.put(np.full((view.height, view.page_width), UNKNOWN_GROUND, dtype=np.uint8), 0, 0)
        rings = [view.pixels(ring) for ring in self.problem.floor.rings]
        canvas.paint(polygon(rings), PAGE)
        for place in sorted(self._places, key=lambda place: place.owner is not None):
            self._paint_region(canvas, place)
        for x, y, radius in self.problem.discs.tolist():
            at = view.pixel(x, y)
            canvas.paint(disc(*at, radius * view.pixels_per_m), UNKNOWN_GROUND)
            canvas.paint(ring_around(*at, radius * view.pixels_per_m, self._thin), WALL)
        for ring in rings:
            canvas.paint(line(np.vstack([ring, ring[:1]]), self._thin), WALL)

    def drive(self, robot: int, points: NDArray[np.float64]) -> Box:
        """Add a stretch of a robot's way through points, shape (n, 2) [m]; where it was added."""
        mask = line(self.view.pixels(points), self.line / 2)
        new, left, top = clipped(mask, self.view.page_width, self.view.height)
        box = np.s_[top : top + new.shape[0], left : left + new.shape[1]]
        old = self._cover[box]
        self._owner[box][(new >= old) & (new > 0)] = self.colours.line(robot)
        np.maximum(old, new, out=old)
        return box

    def paint_ways(self, canvas: Canvas, box: Box = WHOLE) -> None:
        """Paint the ways driven so far, or their part in a box."""
        rows, cols = box
        canvas.paint_layer(self._cover[box], self._owner[box], cols.start or 0, rows.start or 0)

    def paint_starts(self, canvas: Canvas) -> None:
        """Paint a ring where each robot starts, with its number."""
        for index, robot in enumerate(self.problem.robots):
            px, py = self.view.pixel(robot.start[0], robot.start[1])
            radius = self._radius(index)
            canvas.paint(ring_around(px, py, radius, self.line * 0.5), self.colours.line(index))
            self._paint_number(canvas, index, px, py, radius, halo=True)

    def paint_labels(self, canvas: Canvas, parked: Collection[int] = ()) -> None:
        """Paint the names of the regions, but those that repeat a parked robot's number."""
        for place, (mask, colour) in self._labels:
            if place.owner in parked and place.label == str(place.owner):
                continue
            _paint_edged(canvas, mask, colour)

    def paint_ticks(
        self, canvas: Canvas, robot: int, trajectory: Trajectory, every_s: float
    ) -> None:
        """Paint a dot wherever a robot is at a multiple of a time."""
        times = np.arange(1, int(trajectory.arrival_s / every_s + 1e-9) + 1) * every_s
        for x, y in positions(trajectory, times).tolist() if len(times) else ():
            at = self.view.pixel(x, y)
            canvas.paint(disc(*at, self.line * 1.15), self.colours.line(robot))
            canvas.paint(disc(*at, self.line * 0.6), PAGE)

    def paint_robot(self, canvas: Canvas, robot: int, x: float, y: float) -> None:
        """Paint a robot's disc with its number."""
        px, py = self.view.pixel(x, y)
        radius = self._radius(robot)
        canvas.paint(disc(px, py, radius + 1.0), PAGE)
        canvas.paint(disc(px, py, radius), self.colours.line(robot))
        self._paint_number(canvas, robot, px, py, radius, halo=False)

    def paint_vanished(self, canvas: Canvas, robot: int, x: float, y: float) -> None:
        """Paint the place where a robot arrived and went away: its outline, and a dot."""
        px, py = self.view.pixel(x, y)
        canvas.paint(ring_around(px, py, self._radius(robot), self._thin), self.colours.line(robot))
        canvas.paint(disc(px, py, self.line * 1.4), self.colours.line(robot))

    def _radius(self, robot: int) -> float:
        """Of a robot [pixels]."""
        return max(self.problem.robots[robot].radius_m * self.view.pixels_per_m, 2.5)

    def _paint_region(self, canvas: Canvas, place: _Place) -> None:
        tint = FRONTIER if place.owner is None else self.colours.tint(place.owner)
        edge = SOFT_TEXT if place.owner is None else self.colours.line(place.owner)
        region, view = place.region, self.view
        if region.disc is not None:
            x, y, radius = region.disc
            at, radius = view.pixel(x, y), radius * view.pixels_per_m
            shape: shapely.Polygon = shapely.Point(at).buffer(radius, quad_segs=16)
            masks = disc(*at, radius), ring_around(*at, radius, self._thin)
        else:
            assert region.polygon is not None
            corners = view.pixels(region.polygon)
            shape = shapely.Polygon(corners)
            masks = polygon([corners]), None
        if place.wanted:
            canvas.paint(masks[0], tint)
        for a, b in _hatching(shape, _HATCH * view.width / 1000) if place.kept_out else ():
            canvas.paint(line(np.array([a, b]), self._thin * 0.6), edge)
        if masks[1] is not None:
            canvas.paint(masks[1], edge)
        else:
            corners = np.asarray(shape.exterior.coords)
            canvas.paint(line(corners, self._thin * 0.75), edge)

    def _label(self, place: _Place) -> tuple[Mask, int]:
        x, y, half_x, half_y = (value * self.view.pixels_per_m for value in _extent(place.region))
        px, py = self.view.pixel(x / self.view.pixels_per_m, y / self.view.pixels_per_m)
        wide, high = words_width(place.label, self._text), line_height(self._text)
        body = 0.0 if place.owner is None else self._radius(place.owner)
        left, top = floor(px - wide / 2), floor(py - max(half_y, body) - high - 1)
        # A robot that stops in the middle of its region must not hide the label.
        if place.kept_out and not place.wanted and wide < 2 * half_x and high < 2 * half_y:
            top = floor(py - high / 2)
        elif wide + 6 < 2 * half_x and high + body < half_y:
            top = floor(py - half_y + 2)
        left = min(max(left, 2), self.view.page_width - wide - 2)
        top = min(max(top, 1), self.view.height - high - 1)
        colour = TEXT if place.owner is None else self.colours.line(place.owner)
        return line_of_text(place.label, left, top, self._text), colour

    def _paint_number(
        self, canvas: Canvas, robot: int, x: float, y: float, radius: float, *, halo: bool
    ) -> None:
        """A robot's number in the middle of its disc, white, or in its colour with a white edge."""
        size = min(self._text, round(radius * 1.25))
        text = str(robot)
        if size < 8 or words_width(text, size) > 1.7 * radius:
            return
        mask = line_of_text(text, 0, 0, size)
        # By the ink itself, for digits have no parts below the line.
        rows, cols = (np.flatnonzero(mask.cover.max(axis=axis)) for axis in (1, 0))
        middle = (rows[0] + rows[-1] + 1) / 2, (cols[0] + cols[-1] + 1) / 2
        mask = Mask(mask.cover, round(x - middle[1]), round(y - middle[0]))
        if halo:
            _paint_edged(canvas, mask, self.colours.line(robot))
        else:
            canvas.paint(mask, PAGE)


def _paint_edged(canvas: Canvas, mask: Mask, colour: int) -> None:
    """Words with a white edge around them."""
    for dx, dy in _AROUND:
        canvas.paint(Mask(mask.cover, mask.left + dx, mask.top + dy), PAGE)
    canvas.paint(mask, colour)


def plan_view(
    problem: PlanningProblem, max_pixels: int, min_width: int, footer_height: int
) -> PlanView:
    """The largest view of a problem whose picture fits into a square."""
    x0, y0, x1, y1 = problem.floor.bounds
    margin = MARGIN * max(x1 - x0, y1 - y0)
    across, up = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
    scale = min(max_pixels / across, (max_pixels - footer_height) / up)
    width, height = max(round(across * scale), 1), max(round(up * scale), 1)
    page = max(width, min(min_width, max_pixels))
    return PlanView(x0 - margin, y1 + margin, scale, width, height, page, footer_height)


def tick_s(trajectories: Sequence[Trajectory | None]) -> float:
    """The time between dots: 1, 2 or 5 times a power of ten, some `_TICKS` on the longest path."""
    longest = max((item.arrival_s for item in trajectories if item is not None), default=0.0)
    power = 1e-3
    while True:
        for step in (1.0, 2.0, 5.0):
            if longest / (step * power) <= _TICKS:
                return step * power
        power *= 10


def _places(problem: PlanningProblem) -> list[_Place]:
    """The regions of all robots and couplings, equal ones once, large ones first."""
    found: list[tuple[Region, list[int], list[bool]]] = []
    keys: dict[tuple[object, ...], int] = {}

    def add(region: Region, owner: int, kept_out: bool) -> None:
        shape = region.disc if region.polygon is None else region.polygon.tobytes()
        key = (region.name, shape)
        if key not in keys:
            keys[key] = len(found)
            found.append((region, [], []))
        _, owners, out = found[keys[key]]
        if owner not in owners:
            owners.append(owner)
            out.append(kept_out)

    for index, robot in enumerate(problem.robots):
        forbidden = _kept_out(robot.task)
        for region in robot.regions.values():
            add(region, index, region.name in forbidden)
    numbers = {robot.name: index for index, robot in enumerate(problem.robots)}
    for coupling in problem.couplings:
        for region in (coupling.region, coupling.other_region):
            if region is not None:
                for name in coupling.robots:
                    add(region, numbers[name], False)
    names: dict[str, int] = {}
    for region, _, _ in found:
        names[region.name] = names.get(region.name, 0) + 1
    places = [
        _Place(
            region,
            owners[0] if len(owners) == 1 else None,
            # A name that many regions have says whose it is.
            region.name if names[region.name] == 1 else _own_label(problem, region, owners[0]),
            any(out),
            not all(out),
        )
        for region, owners, out in found
    ]
    return sorted(places, key=lambda place: -np.prod(_extent(place.region)[2:]))


def _own_label(problem: PlanningProblem, region: Region, owner: int) -> str:
    alone = len(problem.robots[owner].regions) == 1
    return str(owner) if alone else f"{owner}{region.name}"


def _kept_out(task: str) -> set[str]:
    """The regions a task forbids for ever: those under G !."""
    found: set[str] = set()
    pending: list[Formula] = [parse_formula(task, allow_next=True)]
    while pending:
        formula = pending.pop()
        if formula.operator is Operator.ALWAYS:
            (inner,) = formula.operands
            parts = inner.operands if inner.operator is Operator.AND else (inner,)
            for part in parts:
                if part.operator is Operator.NOT and part.operands[0].operator is Operator.NAME:
                    found |= part.operands[0].names
        elif formula.operator is Operator.AND:
            pending += formula.operands
    return found


def _extent(region: Region) -> tuple[float, float, float, float]:
    """The middle of a region and half its width and height [m]."""
    if region.disc is not None:
        x, y, radius = region.disc
        return x, y, radius, radius
    assert region.polygon is not None
    low, high = region.polygon.min(axis=0), region.polygon.max(axis=0)
    (x, y), (dx, dy) = ((low + high) / 2).tolist(), ((high - low) / 2).tolist()
    return x, y, dx, dy


def _hatching(
    shape: shapely.Polygon, apart: float
) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    """Diagonal lines across a shape."""
    x0, y0, x1, y1 = shape.bounds
    high, step = y1 - y0, apart * 2**0.5
    for k in range(floor((x1 - x0 + high) / step) + 1):
        x = x0 - high + (k + 0.5) * step
        line = shapely.LineString([(x, y1), (x + high, y0)])
        for part in shapely.get_parts(shapely.intersection(shape, line)).tolist():
            ends = list(part.coords)
            for a, b in pairwise(ends):
                if hypot(a[0] - b[0], a[1] - b[1]) > 1.0:
                    yield (a[0], a[1]), (b[0], b[1])
