"""A plan as an animation."""

import os
from collections.abc import Sequence

import numpy as np

from conav.errors import InputError
from conav.pictures.animation import check_times, frame_ticks
from conav.pictures.canvas import TRANSPARENT, PaletteCanvas
from conav.pictures.gif import GifWriter
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import PAGE, Colours
from conav.pictures.plan_picture import checked_trajectories, framed
from conav.pictures.plan_scene import PlanScene
from conav.planning.trajectory import polyline, positions
from conav.planning.types import PlanningProblem, Trajectory

SLOWEST = 1.0
"""A plan is not shown slower than it is driven."""


def save_plan_animation(
    problem: PlanningProblem,
    path: str | os.PathLike[str],
    trajectories: Sequence[Trajectory | None],
    *,
    words: str = "",
    max_pixels: int = 800,
    seconds: float = 12.0,
    fps: float = 20.0,
) -> None:
    """Draw a plan to a looping GIF, at most `max_pixels` on a side.

    It moves for `seconds`, or as long as the plan takes where that is less; frames lie evenly in
    the plan's time. Robots leave their way behind them; those that vanish leave an outline. Raises
    `InputError` when no robot has a trajectory, for a path that cannot be written, and for times no
    GIF can have.
    """
    target = checked_path(path, ".gif", "an animation")
    max_pixels = checked_pixels(max_pixels)
    check_times(seconds, fps)
    given = checked_trajectories(problem, trajectories)
    end_s = max((item.arrival_s for item in given if item is not None), default=0.0)
    if all(item is None for item in given):
        raise InputError(target, "no robot has a trajectory to show", "draw a picture instead")
    count = max(round(min(seconds, end_s / SLOWEST) * fps), 1) + 1
    times = [end_s * frame / (count - 1) for frame in range(count)]
    states = [_state(words, time_s, end_s) for time_s in times]
    view, footer = framed(problem, states[-1], max_pixels)
    colours = Colours(len(problem.robots))
    scene = PlanScene(view, problem, colours)
    ground = PaletteCanvas(view.page_width, view.height + view.footer_height, colours)
    scene.paint_ground(ground)
    clean = ground.pixels.copy()
    canvas = PaletteCanvas(ground.width, ground.height, colours)
    blank = np.full((view.footer_height, view.page_width), PAGE, dtype=np.uint8)
    lines = [None if item is None else polyline(item, 0.3 / view.pixels_per_m) for item in given]
    before = 0.0
    with whole_file(target) as stream:
        gif = GifWriter(stream, canvas.width, canvas.height, canvas.palette, TRANSPARENT)
        for time_s, state, ticks in zip(times, states, frame_ticks(count, fps), strict=True):
            for robot, (item, line) in enumerate(zip(given, lines, strict=True)):
                if item is not None and line is not None and before < item.arrival_s:
                    corners = line[(line[:, 2] > before) & (line[:, 2] < time_s), :2]
                    ends = positions(item, [before, time_s])
                    box = scene.drive(robot, np.vstack([ends[:1], corners, ends[1:]]))
                    # Ways have soft edges, which must not be laid over themselves.
                    ground.pixels[box] = clean[box]
                    scene.paint_ways(ground, box)
            before = time_s
            canvas.pixels[:] = ground.pixels
            scene.paint_starts(canvas)
            for robot, item in enumerate(given):
                x, y = problem.robots[robot].start[:2]
                if item is not None:
                    x, y = positions(item, time_s)[0].tolist()
                    vanishes = problem.robots[robot].after_arrival == "vanish"
                    if vanishes and time_s >= item.arrival_s:
                        scene.paint_vanished(canvas, robot, x, y)
                        continue
                scene.paint_robot(canvas, robot, x, y)
            scene.paint_labels(canvas)
            canvas.put(blank, 0, view.height)
            footer.paint(canvas, view.height, state, view.pixels_per_m)
            gif.add(canvas.pixels, ticks)
        gif.close()


def _state(words: str, time_s: float, end_s: float) -> str:
    time = f"{time_s:.1f} of {end_s:.1f} s"
    return f"{words} · {time}" if words else time
