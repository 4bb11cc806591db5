"""What a team believed to be clear, against what the verifier finds, after each leg."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.pursuit.types import Schedule
from conav.pursuit.verify_decide import MAX_PIECES, settle
from conav.pursuit.verify_lattice import PARTS
from conav.pursuit.verify_polygons import face_polygons, region_polygon
from conav.pursuit.verify_problem import Check
from conav.pursuit.verify_step import Step, Stepper
from conav.pursuit.verify_timeline import Piece
from conav.runs.types import RegionRecord

Flags = NDArray[np.bool_]

PART = 0.01  # of a contaminated region that a belief may leave out: outlines are drawn by eye
LEAST_M = 0.001  # [m] and a square of this size
UNSEEN = 0.001  # of the floor that may seem unseen for rounding
NEAR = 2  # [grid steps] what is nearer to a contaminated region counts as covered: all was rounded


def check_beliefs(
    beliefs: dict[int, tuple[RegionRecord, ...]],
    schedule: Schedule,
    pieces: Sequence[Piece],
    stepper: Stepper,
    known: bool,
    check: Check,
) -> int:
    """How many beliefs could not be settled; a breach for each that is proved wrong.

    A belief is wrong when an evader may be, for sure, in a region that is not among those it calls
    contaminated. On an unknown floor what nobody has seen yet need not be among them.
    """
    claims: dict[int, Flags] = {}
    seen: shapely.Geometry | None = None if known else shapely.Polygon()
    for k, piece in enumerate(pieces):
        step = piece.step(stepper)
        if seen is not None:
            seen = shapely.union_all([seen, *_seen(step)])
        last = k + 1 == len(pieces) or pieces[k + 1].leg > piece.leg
        if last and piece.leg in beliefs and _settled_view(schedule, piece.leg):
            claims[piece.leg] = _left_out(step, beliefs[piece.leg], stepper, seen)
    check.looked += len(claims)

    def asked(pieces: list[Piece]) -> dict[int, Flags]:
        return {
            k + 1: claims[piece.leg]
            for k, piece in enumerate(pieces)
            if piece.leg in claims and (k + 1 == len(pieces) or pieces[k + 1].leg > piece.leg)
        }

    found = settle(list(pieces), stepper, asked, 2 * MAX_PIECES)
    open_ones = 0
    for k, flags in asked(found.pieces).items():
        leg = found.pieces[k - 1].leg
        if (flags & found.sure[k]).any():
            check.fault(f"after leg {leg} the team takes a region for clear that is not")
        elif (flags & found.labels[k]).any():
            open_ones += 1
    return open_ones


def check_explored(
    result: dict[str, Any], pieces: Sequence[Piece], stepper: Stepper, check: Check
) -> None:
    """On a floor not known before, what is said to be explored was seen; all of it when done.

    What somebody sees at an end of a motion counts, or of half a motion where it was halved.
    """
    whole = shapely.Polygon(stepper.lattice.rings[0], stepper.lattice.rings[1:])
    seen = shapely.union_all([one for piece in pieces for one in _seen(piece.step(stepper))])
    share = float(shapely.area(seen)) / float(shapely.area(whole))
    said = result.get("explored")
    near = said is None or (isinstance(said, int | float) and 0.0 <= said <= share + UNSEEN)
    check.look(near, f"explored is {said!r}, and {share:.4g} of the floor was seen")
    if result.get("status") == "done":
        text = f"the run says that nobody is hidden, and {share:.4g} of the floor was seen"
        check.look(share >= 1.0 - UNSEEN, text)


def _settled_view(schedule: Schedule, leg: int) -> bool:
    """Whether who sees at the end of a leg is plain: it lasts, or nothing changes after it."""
    if schedule.times[leg + 1] > schedule.times[leg]:
        return True
    after = schedule.active[leg + 1 :]
    return len(after) == 0 or bool((after[0] == schedule.active[leg]).all())


def _seen(step: Step) -> list[shapely.Polygon]:
    """What is seen before or after a motion, in lattice units."""
    seen = step.regions.inside & ((step.regions.old < 0) | (step.regions.new < 0))
    return face_polygons(step, np.flatnonzero(seen))


def _left_out(
    step: Step,
    regions: tuple[RegionRecord, ...],
    stepper: Stepper,
    seen: shapely.Geometry | None,
) -> Flags:
    """Which shadows after a motion a belief does not call contaminated, or not all of it."""
    contaminated = shapely.union_all([_polygon(one, stepper) for one in regions if not one.clear])
    contaminated = shapely.buffer(contaminated, NEAR * PARTS, quad_segs=2)
    least = (LEAST_M / stepper.lattice.grid_m * PARTS) ** 2
    flags = np.zeros(step.regions.n_new, dtype=np.bool_)
    for number in range(step.regions.n_new):
        shadow = region_polygon(step, np.flatnonzero(step.regions.new == number))
        if seen is not None:
            shadow = shapely.intersection(shadow, seen)
        rest = float(shapely.area(shapely.difference(shadow, contaminated)))
        flags[number] = rest > PART * float(shapely.area(shadow)) + least
    return flags


def _polygon(region: RegionRecord, stepper: Stepper) -> shapely.Geometry:
    rings = [stepper.lattice.from_metres(ring) for ring in region.rings if len(ring) > 2]
    if not rings:
        return shapely.Polygon()
    return shapely.make_valid(shapely.Polygon(rings[0], rings[1:]))
