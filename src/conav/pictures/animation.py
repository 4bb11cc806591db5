"""A whole exploration as an animation."""

import os
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.occupancy_grid import UNKNOWN
from conav.pictures.canvas import TRANSPARENT, Canvas, PaletteCanvas
from conav.pictures.footer import (
    MIN_WIDTH,
    Footer,
    coverage_of,
    is_done,
    state_of,
    text_size,
    title_of,
)
from conav.pictures.gif import GifWriter
from conav.pictures.marks import Mask, words_width
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import CURVE, PAGE, STRIP, Colours
from conav.pictures.replay import Replay, Team, free_seen, team_of
from conav.pictures.scene import Scene
from conav.pictures.view import fitted, window_around
from conav.runs.types import ExplorationRun

FIRST_S = 0.5  # [s] the first frame is shown before anything moves
LAST_S = 2.0  # [s] the last frame is held
FRAMES_PER_STEP = 8  # at most; a run of few steps is over sooner


def save_animation(
    run: ExplorationRun,
    path: str | os.PathLike[str],
    *,
    max_pixels: int = 800,
    seconds: float = 12.0,
    fps: float = 20.0,
) -> None:
    """Draw a run to a looping GIF, at most `max_pixels` on a side.

    It moves for `seconds`, before and after which the first and the last frame are held. Frames lie
    evenly in simulated time; one between two steps shows robots on their way. Raises `InputError`
    for a run that is no exploration, a path that cannot be written, and times no GIF can have.
    """
    target = checked_path(path, ".gif", "an animation")
    max_pixels = checked_pixels(max_pixels)
    check_times(seconds, fps)
    film = _Film(run, max_pixels, max(round(seconds * fps), 1))
    canvas = film.canvas
    with whole_file(target) as stream:
        gif = GifWriter(stream, canvas.width, canvas.height, canvas.palette, TRANSPARENT)
        for ticks in frame_ticks(film.times.count, fps):
            film.paint_next()
            gif.add(canvas.pixels, ticks)
        gif.close()


@dataclass(frozen=True)
class _Times:
    """Which moment of a run each frame shows."""

    moves: int  # steps after the first
    count: int  # frames

    def at(self, frame: int) -> tuple[int, float]:
        """The step a frame shows, and the part of the way to the next one."""
        if self.count == 1:
            return self.moves, 0.0
        step, rest = divmod(frame * self.moves, self.count - 1)
        return step, rest / (self.count - 1)


class _Film:
    """The frames of a run, painted one after another on one canvas."""

    def __init__(self, run: ExplorationRun, max_pixels: int, intervals: int) -> None:
        self.run = run
        self.team = team_of(run)
        end = Replay(run)
        free = free_seen(run, end)
        moves = max(len(run.steps) - 1, 0)
        self.times = _Times(moves, min(intervals, FRAMES_PER_STEP * moves) + 1)
        self._states = _states(run, self.team, free, self.times)
        size = text_size(max_pixels)
        widest = max(self._states, key=lambda state: words_width(state, size))
        self._footer = Footer(title_of(self.team), widest)
        self._view = view = fitted(
            window_around(end.team_map != UNKNOWN),
            run.resolution,
            max_pixels,
            MIN_WIDTH,
            lambda width: self._footer.height(width) + _strip_height(width),
        )
        colours = Colours(self.team.size)
        self.canvas = PaletteCanvas(view.page_width, view.height + view.footer_height, colours)
        self._blank = np.full((view.footer_height, view.page_width), PAGE, dtype=np.uint8)
        self._scene = Scene(view, self.team, run.cells, colours)
        self._strip = _Strip(view.page_width, free, coverage_of(run))
        self._replay = Replay(run)
        self._frame = -1
        self._step = -1  # the last one seen and driven to
        self._places = self.team.track[0]

    def paint_next(self) -> None:
        """Paint the next frame."""
        self._frame += 1
        step, part = self.times.at(self._frame)
        track = self.team.track
        last = self._frame == self.times.count - 1
        fresh = [self._replay.apply(record) for record in self.run.steps[self._step + 1 : step + 1]]
        if fresh:
            self._scene.see(np.concatenate(fresh), self._replay)
        places = track[step]
        if part > 0.0:
            places = places + (track[step + 1] - places) * part
        way = np.concatenate([self._places[None], track[self._step + 1 : step + 1], places[None]])
        for robot in np.flatnonzero((way != way[0]).any(axis=(0, 2))):
            self._scene.drive(int(robot), way[:, robot])
        self._step, self._places = step, places
        live = not (last and is_done(self.run))
        self._scene.paint(self.canvas, places, step, frontier=live, goals=live)
        top = self._view.height
        self.canvas.put(self._blank, 0, top)
        self._strip.paint(self.canvas, top, (self._frame + 1) / self.times.count)
        self._footer.paint(
            self.canvas,
            top + _strip_height(self.canvas.width),
            self._states[self._frame],
            self._view.pixels_per_m,
        )


class _Strip:
    """Coverage over time, drawn as far as the animation has got."""

    def __init__(self, width: int, free: NDArray[np.int64], coverage: float) -> None:
        height = _strip_height(width)
        share = np.zeros(1) if len(free) == 0 else free / max(int(free[-1]), 1) * coverage
        at = (np.arange(width) * len(share) // width).astype(np.int64)
        # Two pixels stay free above full coverage.
        fill = share[at] * (height - 2) - np.arange(height)[::-1, None]
        self._cover = (np.clip(fill, 0.0, 1.0) * 255.0).astype(np.uint8)
        self._ground = np.full(self._cover.shape, STRIP, dtype=np.uint8)

    def paint(self, canvas: Canvas, top: int, part: float) -> None:
        canvas.put(self._ground, 0, top)
        shown = self._cover[:, : round(part * self._cover.shape[1])]
        canvas.paint(Mask(shown, 0, top), CURVE)


def _strip_height(width: int) -> int:
    return 2 * text_size(width)


def _states(run: ExplorationRun, team: Team, free: NDArray[np.int64], times: _Times) -> list[str]:
    """The footer's words for each frame."""
    first = run.steps[0].step if run.steps else 0
    seen = free if len(free) else np.zeros(1, dtype=np.int64)
    result: list[str] = []
    for frame in range(times.count):
        step, part = times.at(frame)
        time_s = (first + step + part) * team.step_s
        end = frame == times.count - 1
        result.append(state_of(run, time_s, int(seen[step]), int(seen[-1]), end=end))
    return result


def check_times(seconds: float, fps: float) -> None:
    """Raises `InputError` for a length and a rate of frames that no GIF can have."""
    if not 0.1 <= seconds <= 600:
        raise InputError(f"seconds {seconds:g}", "is no length of an animation", "give 0.1 to 600")
    if not 1 <= fps <= 50:
        raise InputError(f"fps {fps:g}", "is more or less than a GIF can show", "give 1 to 50")


def frame_ticks(frames: int, fps: float) -> list[int]:
    """How long each frame is shown [hundredths of a second], rounded so that no error adds up."""
    if frames == 1:
        return [round(LAST_S * 100)]
    edges = [round(100 * frame / fps) for frame in range(frames)]
    ticks = [later - edge for edge, later in pairwise(edges)]
    ticks[0] = max(ticks[0], round(FIRST_S * 100))
    return [*ticks, round(LAST_S * 100)]
