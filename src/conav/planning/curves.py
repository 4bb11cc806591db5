"""What ways of pieces that are not straight meet: walls and discs, and borders of regions.

For walls and discs a piece is cut into times in which it is at most `SAG` from its chord, and each
chord keeps that much more distance: nothing that overlaps is accepted, and of what is free nothing
but what is a millimetre near. Borders of regions are found by halving times until a chord with its
sag is clear of all borders, or so short that the border is met there.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.clearance import point_segment_square
from conav.planning.labels import MAX_EVENTS, SAME, UNCLEAR, point_label
from conav.planning.obstacles import segment_keeps, segments_square
from conav.planning.piece import bend, state_on_piece

SAG = 1e-3
"""[m] between a piece and its chords, at most."""

_DEEPEST = MAX_EVENTS - 1  # halvings of one piece


@kernel
def pieces_free(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    pieces: NDArray[np.float64],
    count: int,
) -> bool:
    """Whether a robot that drives these pieces overlaps no obstacle.

    The obstacles' lists must have been made with `SAG` to spare.
    """
    for row in range(count):
        piece = pieces[row]
        duration = piece[1] - piece[0]
        bound = bend(piece)
        steps = int(duration * sqrt(bound / (8.0 * SAG))) + 1
        step = duration / steps
        x, y, vx, vy = state_on_piece(piece, piece[0])
        for i in range(1, steps + 1):
            to_x, to_y, to_vx, to_vy = state_on_piece(piece, piece[0] + i * step)
            dx = to_x - x
            dy = to_y - y
            bent = bound
            if piece[8] == 0.0 and vx * dx + vy * dy >= 0.0 and to_vx * dx + to_vy * dy >= 0.0:
                # Along the chord it goes from end to end; what matters is how it leaves the chord.
                away = sqrt(dx * dx + dy * dy)
                bent = abs(piece[6] * dy - piece[7] * dx) / away if away > 0.0 else bound
            sag = 0.125 * bent * step * step
            if not segment_keeps(grid, starts, items, shapes, x, y, to_x, to_y, sag):
                return False
            x = to_x
            y = to_y
            vx = to_vx
            vy = to_vy
    return True


@kernel
def pieces_meet_regions(
    discs: NDArray[np.float64], rings: NDArray[np.float64], pieces: NDArray[np.float64], count: int
) -> bool:
    """Whether the boxes around pieces and around a region meet: else they have no word to find."""
    for row in range(count):
        left, low, right, high = box_of(pieces[row])
        for i in range(len(discs)):
            x = discs[i, 0]
            y = discs[i, 1]
            r = discs[i, 2] + SAME
            if left <= x + r and right >= x - r and low <= y + r and high >= y - r:
                return True
        for i in range(len(rings)):
            if (
                left <= rings[i, 4] + SAME
                and right >= rings[i, 2] - SAME
                and low <= rings[i, 5] + SAME
                and high >= rings[i, 3] - SAME
            ):
                return True
    return False


@kernel
def box_of(piece: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """A box that a piece stays in: left, low, right, high [m]."""
    duration = piece[1] - piece[0]
    sag = 0.125 * bend(piece) * duration * duration
    x, y, _, _ = state_on_piece(piece, piece[1])
    return (
        min(piece[2], x) - sag,
        min(piece[3], y) - sag,
        max(piece[2], x) + sag,
        max(piece[3], y) + sag,
    )


@kernel
def pieces_word(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    pieces: NDArray[np.float64],
    count: int,
    first: int,
    last: int,
    until: NDArray[np.float64],
    word: NDArray[np.int64],
) -> int:
    """How many times the label changes along pieces, or `UNCLEAR`; `word` gets the new labels.

    `first` and `last` are the labels at the ends; `until` is memory for `MAX_EVENTS` numbers.
    Borders met within `SAME` [m] count as met together, and there regions are entered before others
    are left, as along straight lines. A border that is touched and not crossed is unclear.
    """
    mask = first
    changes = 0
    for row in range(count):
        piece = pieces[row]
        bound = bend(piece)
        _, _, ux, uy = state_on_piece(piece, piece[0])
        _, _, vx, vy = state_on_piece(piece, piece[1])
        fastest = sqrt(max(ux * ux + uy * uy, vx * vx + vy * vy))
        if fastest == 0.0:
            continue
        shortest = SAME / fastest
        begin = piece[0]
        x = piece[2]
        y = piece[3]
        until[0] = piece[1]
        depth = 1
        while depth > 0:
            end = until[depth - 1]
            to_x, to_y, _, _ = state_on_piece(piece, end)
            sag = 0.125 * bound * (end - begin) * (end - begin)
            if not _meets_border(discs, rings, sides, x, y, to_x, to_y, sag):
                depth -= 1
            elif end - begin > shortest and depth < _DEEPEST:
                until[depth] = 0.5 * (begin + end)
                depth += 1
                continue
            else:
                label = point_label(discs, rings, sides, to_x, to_y)
                if label == mask or changes + 2 > MAX_EVENTS:
                    return UNCLEAR
                if label & ~mask:
                    word[changes] = mask | label
                    changes += 1
                if mask & ~label:
                    word[changes] = label
                    changes += 1
                mask = label
                depth -= 1
            begin = end
            x = to_x
            y = to_y
    return changes if mask == last else UNCLEAR


@kernel
def _meets_border(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    sag: float,
) -> bool:
    """Whether a border comes as near to a chord as its sag."""
    for i in range(len(discs)):
        x = discs[i, 0]
        y = discs[i, 1]
        r = discs[i, 2]
        if r - sag > 0.0:
            inside = (r - sag) * (r - sag)
            if (ax - x) * (ax - x) + (ay - y) * (ay - y) < inside and (bx - x) * (bx - x) + (
                by - y
            ) * (by - y) < inside:
                continue
        if point_segment_square(x, y, ax, ay, bx, by) <= (r + sag) * (r + sag):
            return True
    left = min(ax, bx) - sag
    right = max(ax, bx) + sag
    low = min(ay, by) - sag
    high = max(ay, by) + sag
    for i in range(len(rings)):
        if left > rings[i, 4] or right < rings[i, 2] or low > rings[i, 5] or high < rings[i, 3]:
            continue
        for side in range(int(rings[i, 0]), int(rings[i, 1])):
            x0, y0, x1, y1 = sides[side]
            if segments_square(ax, ay, bx, by, x0, y0, x1, y1) <= sag * sag:
                return True
    return False
