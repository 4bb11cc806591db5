"""Whether a certificate of a capture holds: stand-alone, in Python's own exact arithmetic.

It trusts nothing in the certificate but the floor and the motions, works out anew which shadows
there are and who may get from which to which unseen, and compares. It shares no code with what
makes certificates. What is left to the reader: that the floor and the motions are those meant.
"""

from fractions import Fraction
from typing import Any

from conav.pursuit.verify_slabs import Place, Point, View, cells, cross, in_floor, walls_of

Rings = list[list[Point]]


def certificate_faults(certificate: dict[str, Any]) -> list[str]:
    """Why a certificate does not prove a capture, in words; empty when it does."""
    try:
        return _faults(certificate)
    except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError) as error:
        return [f"it is no certificate: {error!r}"]


def _faults(certificate: dict[str, Any]) -> list[str]:
    if certificate["kind"] != "conav capture certificate" or certificate["format"] != 1:
        return ["it is of another kind or format"]
    rings: Rings = [[_point(corner) for corner in ring] for ring in certificate["rings"]]
    pieces, layers = certificate["pieces"], certificate["layers"]
    if not pieces or len(layers) != len(pieces) + 1:
        return ["its pieces and layers do not belong together"]
    faults = _order_faults(pieces)
    if len(layers[0]) != 1 or not layers[0][0]["contaminated"]:
        faults.append("it does not begin with an evader who may be anywhere")
    for k, piece in enumerate(pieces):
        faults += [f"piece {k}: {text}" for text in _piece_faults(rings, piece, *layers[k : k + 2])]
    if any(shadow["contaminated"] for shadow in layers[-1]):
        faults.append("an evader may be hidden at its end")
    return faults


def _order_faults(pieces: list[dict[str, Any]]) -> list[str]:
    """Whether each piece takes up where the one before left off."""
    faults: list[str] = []
    active: dict[int, Point] = {}  # who sees and where, between pieces
    for k, piece in enumerate(pieces):
        movers = {int(one["pursuer"]): one for one in piece["pursuers"]}
        if len(movers) != len(piece["pursuers"]):
            faults.append(f"piece {k}: a pursuer twice")
        if piece["instant"]:
            old = {i for i, one in movers.items() if one["old"]}
            if any(one["before"] != one["after"] for one in movers.values()):
                faults.append(f"piece {k}: somebody moves in no time")
        else:
            old = set(movers)
            if not all(one["old"] and one["new"] for one in movers.values()):
                faults.append(f"piece {k}: somebody comes or goes during a motion")
        if old != set(active):
            faults.append(f"piece {k}: it begins with others than the one before ended with")
        elif any(_point(movers[i]["before"]) != active[i] for i in old):
            faults.append(f"piece {k}: somebody is not where the piece before ended")
        active = {i: _point(one["after"]) for i, one in movers.items() if one["new"]}
    return faults


def _piece_faults(
    rings: Rings,
    piece: dict[str, Any],
    before: list[dict[str, Any]],
    after: list[dict[str, Any]],
) -> list[str]:
    views: list[View] = []
    for one in piece["pursuers"]:
        a, b = _point(one["before"]), _point(one["after"])
        if not in_floor(walls_of(rings), a, b):
            return [f"pursuer {one['pursuer']} leaves the floor"]
        reach: list[list[Point]] = [[], []]
        if "range" in one:
            reach = [[_point(corner) for corner in polygon] for polygon in one["reach"]]
            for at, polygon in zip((a, b), reach, strict=True):
                if not _within_reach(rings, at, int(one["range"]), polygon):
                    return [f"pursuer {one['pursuer']} sees beyond its range"]
        throughout = one.get("throughout", True)
        views.append(
            View(a, b, reach[0], reach[1], "range" in one, one["old"], one["new"], throughout)
        )
    old_points = [_place(shadow["point"]) for shadow in before]
    new_points = [_place(shadow["point"]) for shadow in after]
    found = cells(rings, views, piece["instant"], old_points, new_points)
    if sorted(found.old_at) != list(range(found.n_old)):
        return ["the shadows before it are not those of the certificate"]
    if sorted(found.new_at) != list(range(found.n_new)):
        return ["the shadows after it are not those of the certificate"]
    faults: list[str] = []
    for i, old in enumerate(found.old_at):
        for j, new in enumerate(found.new_at):
            if not found.links[old][new]:
                continue
            if not piece["links"][i][j]:
                faults.append(f"an evader may get from shadow {i} to shadow {j}")
            if before[i]["contaminated"] and not after[j]["contaminated"]:
                faults.append(f"shadow {j} is not clear: shadow {i} was not")
    return faults


def _within_reach(rings: Rings, at: Point, radius: int, polygon: list[Point]) -> bool:
    """Whether a polygon is convex and lies in the circle; one without corners stands for all of
    the floor.
    """
    held = polygon or [corner for ring in rings for corner in ring]
    if any((x - at[0]) ** 2 + (y - at[1]) ** 2 > radius**2 for x, y in held):
        return False
    return all(cross(a, b, c) >= 0 for a, b in walls_of([polygon]) for c in polygon)


def _point(pair: Any) -> Point:
    x, y = pair
    if type(x) is not int or type(y) is not int:
        raise TypeError(f"{pair!r} is no lattice point")
    return x, y


def _place(pair: Any) -> Place:
    x, y = pair
    return Fraction(x), Fraction(y)
