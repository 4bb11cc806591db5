"""The strip below a map: what it is, how far the team got, and how long a metre is."""

import unicodedata
from dataclasses import dataclass
from math import floor

from conav.pictures.canvas import Canvas
from conav.pictures.marks import Mask, line_height, line_of_text, shortened, stroke, words_width
from conav.pictures.palette import SOFT_TEXT, TEXT
from conav.pictures.replay import Team
from conav.runs.types import ExplorationRun

MIN_WIDTH = 320  # [pixels] of a page, so that a footer has a chance
_NAME_LENGTH = 60


@dataclass(frozen=True)
class Footer:
    """A title, a state that changes with time, and a scale bar, flowing into as few rows as fit."""

    title: str
    widest_state: str  # room is left for this one

    def height(self, width: int) -> int:
        """The height on a page that wide [pixels]."""
        rows = self._rows(width)
        return len(rows) * self._row_height(width) + 2 * _pad(width) - self._gap(width)

    def paint(self, canvas: Canvas, top: int, state: str, pixels_per_m: float) -> None:
        """Paint it across the page from `top` on."""
        width = canvas.width
        size, pad = text_size(width), _pad(width)
        contents = {"title": (self.title, TEXT), "state": (state, SOFT_TEXT)}
        y = top + pad
        for row in self._rows(width):
            x = pad
            for item, room in row:
                if item in contents:
                    text, colour = contents[item]
                    text = shortened(text, size, width - 2 * pad)
                    canvas.paint(line_of_text(text, x, y, size), colour)
                else:
                    _paint_scale(canvas, width - pad, y, room, size, pixels_per_m)
                x += room + 2 * size
            y += self._row_height(width)

    def _rows(self, width: int) -> list[list[tuple[str, int]]]:
        """The items of each row with the room each takes [pixels]."""
        size = text_size(width)
        full = width - 2 * _pad(width)
        items = [
            ("title", min(words_width(self.title, size), full)),
            ("state", min(words_width(self.widest_state, size), full)),
            ("scale", min(16 * size, full)),
        ]
        rows: list[list[tuple[str, int]]] = [[]]
        used = 0
        for item, room in items:
            if used + room > full:
                rows.append([])
                used = 0
            rows[-1].append((item, room))
            used += room + 2 * size
        return rows

    def _gap(self, width: int) -> int:
        return text_size(width) // 4

    def _row_height(self, width: int) -> int:
        return line_height(text_size(width)) + self._gap(width)


def text_size(width: int) -> int:
    """The size of text on a page that wide [pixels]."""
    return min(max(round(width / 58), 12), 24)


def title_of(team: Team) -> str:
    """What the run is: map, strategy, size of the team."""
    robots = f"{team.size} robots" if team.size > 1 else "1 robot"
    return f"{plain_name(team.map_name)} \u00b7 {plain_name(team.strategy)} \u00b7 {robots}"


def state_of(
    run: ExplorationRun, time_s: float, free_cells: int, last_free_cells: int, *, end: bool
) -> str:
    """How far the team had got at a time: coverage, time, and at the end how it ended.

    What counts as covered is known exactly at the end only; before, it is taken to grow as the
    known free area does. A run cut short has no such measure and shows the area itself.
    """
    if run.result is None:
        area = free_cells * run.resolution * run.resolution
        how_far = f"{area:.3g} sq m seen" if area < 100 else f"{area:.0f} sq m seen"
        ended = "cut short"
    else:
        share = coverage_of(run) * (free_cells / last_free_cells if last_free_cells else 1.0)
        # Rounded down, so that only a complete run shows 100.
        percent = floor(share * 1000 + 1e-9) / 10 if end else floor(share * 100 + 1e-9)
        how_far = f"{percent:g} %"
        status = str(run.result.get("status", "")).replace("_", " ")
        ended = "interrupted" if run.result.get("interrupted") else status
    words = [how_far, clock(time_s)] + ([ended] if end and not is_done(run) else [])
    return " \u00b7 ".join(words)


def is_done(run: ExplorationRun) -> bool:
    """Whether the run ended with nothing left to see."""
    return run.result is not None and run.result.get("status") == "done"


def coverage_of(run: ExplorationRun) -> float:
    """The share of the observable area the team had seen at the end, 1 where none is told."""
    metrics = (run.result or {}).get("metrics", {})
    return float(metrics.get("coverage", 1.0))


def clock(time_s: float) -> str:
    """A time in the units people use for it."""
    seconds = floor(time_s + 1e-9)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60:02d} s"
    return f"{seconds // 3600} h {seconds // 60 % 60:02d} min"


def _pad(width: int) -> int:
    return text_size(width) * 3 // 4


def plain_name(name: str) -> str:
    """A name from a file as one short line in letters that Pillow's font has."""
    apart = unicodedata.normalize("NFKD", name)
    text = "".join(
        letter if " " <= letter <= "~" else "?"
        for letter in apart
        if not unicodedata.combining(letter)
    )
    return text if len(text) <= _NAME_LENGTH else text[: _NAME_LENGTH - 3] + "..."


def _paint_scale(
    canvas: Canvas, right: int, top: int, room: int, size: int, pixels_per_m: float
) -> None:
    longest = room - 5 * size
    if longest < 8:
        return
    metres = _round_length(longest / pixels_per_m)
    length = metres * pixels_per_m
    text = f"{metres:g} m"
    x0 = right - words_width(text, size) - size // 2 - length
    middle = top + round(line_height(size) * 0.52) + 0.5
    tick = size * 0.25
    half = max(size / 22, 0.5)
    x0 = floor(x0) + 0.5
    strokes: list[Mask] = [
        stroke(x0, middle, x0 + length, middle, half),
        stroke(x0, middle - tick, x0, middle + tick, half),
        stroke(x0 + length, middle - tick, x0 + length, middle + tick, half),
    ]
    for mask in strokes:
        canvas.paint(mask, SOFT_TEXT)
    canvas.paint(line_of_text(text, right - words_width(text, size), top, size), SOFT_TEXT)


def _round_length(limit: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above the limit."""
    power = 1.0
    while power > limit:
        power /= 10
    while power * 10 <= limit:
        power *= 10
    return max(step * power for step in (1, 2, 5) if step * power <= limit)
