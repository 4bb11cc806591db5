"""The end of an exploration as one picture."""

import os

import numpy as np

from conav.maps.occupancy_grid import UNKNOWN
from conav.pictures.canvas import ColourCanvas
from conav.pictures.footer import MIN_WIDTH, Footer, is_done, state_of, title_of
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import Colours
from conav.pictures.replay import Replay, free_seen, team_of
from conav.pictures.scene import Scene
from conav.pictures.view import fitted, window_around
from conav.runs.types import ExplorationRun


def save_still(
    run: ExplorationRun, path: str | os.PathLike[str], *, max_pixels: int = 1600
) -> None:
    """Draw the end of a run, or as far as it got, to a PNG at most `max_pixels` on a side.

    Ground is tinted by the robot that saw it first; walls nobody has seen are faint. Raises
    `InputError` for a run that is no exploration and for a path that cannot be written.
    """
    from PIL import Image

    target = checked_path(path, ".png", "a still picture")
    max_pixels = checked_pixels(max_pixels)
    team = team_of(run)
    replay = Replay(run)
    free = free_seen(run, replay)
    last = len(team.track) - 1
    cells = int(free[-1]) if len(free) else 0
    time_s = run.steps[-1].step * team.step_s if run.steps else 0.0
    state = state_of(run, time_s, cells, cells, end=True)
    footer = Footer(title_of(team), state)
    known = replay.team_map != UNKNOWN
    view = fitted(window_around(known), run.resolution, max_pixels, MIN_WIDTH, footer.height)
    colours = Colours(team.size)
    scene = Scene(view, team, run.cells, colours)
    scene.see(np.flatnonzero(known), replay)
    for robot in range(team.size):
        scene.drive(robot, team.track[:, robot])
    canvas = ColourCanvas(view.page_width, view.height + view.footer_height, colours)
    live = not is_done(run)
    scene.paint(canvas, team.track[last], last, frontier=live, goals=live)
    footer.paint(canvas, view.height, state, view.pixels_per_m)
    with whole_file(target) as stream:
        Image.fromarray(canvas.pixels).save(stream, format="PNG")
