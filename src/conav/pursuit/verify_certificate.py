"""The certificate of a capture: what somebody else needs to check it, as one JSON object.

What its fields mean: docs/pursuit-verifier.md, section 6. `verify_certificate_check` checks it.
"""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.pursuit.types import Schedule
from conav.pursuit.verify_decide import Decision, Verdict
from conav.pursuit.verify_lattice import PARTS
from conav.pursuit.verify_polygons import face_polygons
from conav.pursuit.verify_range import inscribed_polygon
from conav.pursuit.verify_step import Mover, Stepper
from conav.pursuit.verify_timeline import Piece

FORMAT = 1


def certificate(
    decision: Decision, stepper: Stepper, schedule: Schedule, run_digest: str = ""
) -> dict[str, Any]:
    """The certificate of a capture, ready for `json.dump`."""
    if decision.verdict is not Verdict.CAPTURED:
        raise ValueError("only a capture has a certificate")
    lattice = stepper.lattice
    pieces = decision.pieces
    layers = [_layer(pieces[0], decision.labels[0], stepper, end=False)]
    layers += [
        _layer(piece, label, stepper, end=True)
        for piece, label in zip(pieces, decision.labels[1:], strict=True)
    ]
    return {
        "kind": "conav capture certificate",
        "format": FORMAT,
        "run": run_digest,
        "grid_m": lattice.grid_m,
        "parts": PARTS,
        "centre": list(lattice.centre),
        "rings": [ring.tolist() for ring in lattice.rings],
        "pieces": [_piece(piece, stepper, schedule) for piece in pieces],
        "layers": layers,
    }


def _piece(piece: Piece, stepper: Stepper, schedule: Schedule) -> dict[str, Any]:
    step = piece.step(stepper)
    begin = float(schedule.times[piece.leg])
    lasts = 0.0 if piece.instant else float(schedule.times[piece.leg + 1]) - begin
    return {
        "leg": piece.leg,
        "part": [str(end) for end in piece.part],
        "time_s": [begin + lasts * float(end) for end in piece.part],
        "instant": piece.instant,
        "pursuers": [
            _mover(name, mover, stepper)
            for name, mover in zip(piece.names, piece.movers, strict=True)
        ],
        "links": step.regions.links.astype(int).tolist(),
    }


def _mover(name: int, mover: Mover, stepper: Stepper) -> dict[str, Any]:
    result: dict[str, Any] = {
        "pursuer": name,
        "before": list(mover.before),
        "after": list(mover.after),
        "old": mover.old,
        "new": mover.new,
    }
    if mover.range is not None:
        corners = stepper.lattice.points
        result |= {
            "range": mover.range,
            "reach": [
                [list(point) for point in inscribed_polygon(at, mover.range, corners)]
                for at in (mover.before, mover.after)
            ],
            "throughout": stepper.sees_throughout(mover),
        }
    return result


def _layer(
    piece: Piece, label: NDArray[np.bool_], stepper: Stepper, *, end: bool
) -> list[dict[str, Any]]:
    """The shadows before a piece or after it, in the order of its matrix."""
    step = piece.step(stepper)
    of_face = step.regions.new if end else step.regions.old
    result: list[dict[str, Any]] = []
    for number, contaminated in enumerate(label.tolist()):
        polygons = face_polygons(step, np.flatnonzero(of_face == number))
        largest = max(polygons, key=lambda polygon: polygon.area)
        inside = largest.representative_point()
        result.append(
            {
                "point": [str(Fraction(inside.x)), str(Fraction(inside.y))],
                "contaminated": contaminated,
                "outlines": [stepper.lattice.metres(ring).tolist() for ring in _rings(polygons)],
            }
        )
    return result


def _rings(polygons: list[shapely.Polygon]) -> Iterator[NDArray[np.float64]]:
    union = shapely.union_all(polygons)
    for polygon in getattr(union, "geoms", [union]):
        for ring in (polygon.exterior, *polygon.interiors):
            yield np.asarray(ring.coords)[:-1]
