"""Tasks of two robots together, for the verifier: judged from the ways alone.

Everything is forgiven the tolerance: regions are a little larger or smaller, distances a little
longer, whichever keeps the coupling.
"""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_clearance import extended
from conav.planning.verify_curves import least_apart
from conav.planning.verify_deviation import most_apart
from conav.planning.verify_regions import stays_in
from conav.planning.verify_scene import TOLERANCE, Area, Check, Scene, Violation, is_number
from conav.runs.types import PlanRun

Track = NDArray[np.float64]


def check_couplings(run: PlanRun, scene: Scene, check: Check) -> None:
    """Every coupling of the problem is kept by the two robots' ways."""
    couplings = run.header["problem"].get("couplings", [])
    numbers = {body.name: number for number, body in enumerate(scene.bodies)}
    for entry in couplings if isinstance(couplings, list) else [couplings]:
        try:
            kind, (first, second), region, other, within = _read(entry)
            a, b = (numbers[name] for name in (first, second))
        except (KeyError, TypeError, ValueError) as error:
            check.fault(Violation(f"a coupling cannot be read ({error!r})"))
            continue
        ways = [scene.tracks[number] for number in (a, b)]
        if ways[0] is None or ways[1] is None:
            continue  # told by the status
        check.looked += 1
        mine, theirs = (
            extended(way, scene.bodies[number].stays, scene.horizon)
            for way, number in zip(cast("list[Track]", ways), (a, b), strict=True)
        )
        problem = {"meet": _unmet, "near": _far, "not-before": _early}[kind](
            mine, theirs, region, other, within
        )
        if problem:
            check.fault(Violation(problem, (first, second)))


_Regions = Area | None


def _unmet(a: Track, b: Track, region: _Regions, other: _Regions, within: float) -> str:
    """What is wrong with a meeting; "" where there is one."""
    assert region is not None
    least = np.inf
    for t0, t1 in stays_in(a, region, TOLERANCE):
        for u0, u1 in stays_in(b, region, TOLERANCE):
            begin, end = max(t0, u0), min(t1, u1)
            if begin > end + TOLERANCE:
                continue
            low, _ = _distances(a, b, begin, max(begin, end), least=True)
            least = min(least, low)
    if least <= within + TOLERANCE:
        return ""
    if not np.isfinite(least):
        return "do not meet: they are never in the region at the same time"
    return f"do not meet: in the region they are {least:.6g} m apart at least, not {within:g}"


def _far(a: Track, b: Track, region: _Regions, other: _Regions, within: float) -> str:
    """What is wrong with robots that have to be near each other; "" for nothing."""
    end = min(float(a[-1, 1]), float(b[-1, 1]))
    _, most = _distances(a, b, 0.0, end, least=False)
    return "" if most <= within + TOLERANCE else f"are {most:.6g} m apart, and may be {within:g}"


def _early(a: Track, b: Track, region: _Regions, other: _Regions, within: float) -> str:
    """What is wrong with the order in which regions are reached; "" for nothing."""
    assert region is not None
    sure = stays_in(a, region, -TOLERANCE)
    if not sure:
        return ""
    reached = stays_in(b, other or region, TOLERANCE)
    when = reached[0][0] if reached else np.inf
    if when <= sure[0][0] + TOLERANCE:
        return ""
    then = f"at {when:.6g} s" if np.isfinite(when) else "never"
    return f"the first is there at {sure[0][0]:.6g} s, the second where it has to be {then}"


def _distances(a: Track, b: Track, begin: float, end: float, *, least: bool) -> tuple[float, float]:
    """An upper bound on the least distance, or a lower one on the greatest, between two times.

    The other number is 0.
    """
    low, high = np.inf, 0.0
    for mine in a:
        for theirs in b:
            t0 = max(begin, float(mine[0]), float(theirs[0]))
            t1 = min(end, float(mine[1]), float(theirs[1]))
            if t0 > t1:
                continue
            if least:
                low = min(low, float(least_apart(mine, theirs, t0, t1, np.inf)[1]))
            else:
                high = max(high, float(most_apart(mine, theirs, t0, t1, high)[0]))
    return (low, 0.0) if least else (0.0, high)


def _read(entry: Any) -> tuple[str, tuple[str, str], _Regions, _Regions, float]:
    """Kind, robots, regions and distance. Raises `KeyError`, `TypeError` or `ValueError`."""
    kind = entry["kind"]
    first, second = entry["robots"]
    if kind not in ("meet", "near", "not-before") or first == second:
        raise ValueError(kind)
    region = None if kind == "near" else _area(entry["region"])
    other = _area(entry["other_region"]) if "other_region" in entry else None
    within = 0.0 if kind == "not-before" else entry["within_m"]
    if not is_number(within) or within < 0.0:
        raise ValueError(within)
    return kind, (first, second), region, other, float(within)


def _area(record: Any) -> Area:
    if "disc" in record:
        x, y, radius = map(float, record["disc"])
        return Area((x, y, radius), None)
    corners = np.array(record["polygon"], dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1] != 2 or not np.isfinite(corners).all():
        raise ValueError("a polygon that is none")
    return Area(None, corners)
