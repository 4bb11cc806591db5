"""What a pursuit's run says, in the verifier's own terms, and the notes it takes."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple, cast

import numpy as np

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Pursuer, Schedule
from conav.runs.types import PursuitRun

SHOWN = 3  # faults told in full per check
MAX_PURSUERS = 1000


@dataclass
class Check:
    """One rule: how often it was looked at and where it was broken."""

    name: str
    looked: int = 0
    broken: int = 0
    faults: list[str] = field(default_factory=list[str])

    def fault(self, text: str) -> None:
        """Note a breach."""
        self.broken += 1
        if len(self.faults) < SHOWN:
            self.faults.append(text)

    def look(self, holds: bool, text: str) -> None:
        """Look at one more thing, and note a breach unless it holds."""
        self.looked += 1
        if not holds:
            self.fault(text)


class Problem(NamedTuple):
    """The problem of a run, and who was sent."""

    plan: PolygonMap
    pursuers: tuple[Pursuer, ...]
    known: bool
    most: int | None
    begin_with: int
    deaths: tuple[tuple[int, float], ...]  # who is lost, by number, and when [s]

    @property
    def ranges(self) -> tuple[float | None, ...]:
        """How far each pursuer sees [m]; None: no limit."""
        return tuple(one.range_m for one in self.pursuers)


def read_problem(run: PursuitRun) -> Problem:
    """The problem of a pursuit's run; raises `InputError` when its header is not one of that."""
    try:
        return _problem(run.header)
    except InputError as error:
        raise InputError(run.path, f"holds a floor that is none ({error})") from None
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InputError(
            run.path, f"has a header that cannot be used ({error!r})", "the file is damaged"
        ) from None


def read_schedule(run: PursuitRun, problem: Problem, check: Check) -> Schedule | None:
    """The schedule of the run; None, with the breach noted, where its legs do not make one.

    Legs follow each other in time and place, have a row per pursuer and finite numbers.
    """
    n = len(problem.pursuers)
    for k, leg in enumerate(run.legs):
        numbers = np.concatenate(([leg.begin_s, leg.end_s], leg.before.ravel(), leg.after.ravel()))
        check.looked += 1
        if len(leg.active) != n:
            check.fault(f"leg {k} is of {len(leg.active)} pursuers, not of {n}")
        elif not np.isfinite(numbers).all() or leg.begin_s > leg.end_s:
            check.fault(f"leg {k} has numbers that are none, or ends before it begins")
        elif k > 0 and leg.begin_s != run.legs[k - 1].end_s:
            check.fault(f"leg {k} does not begin when the one before ends")
        elif k > 0 and not np.array_equal(leg.before, run.legs[k - 1].after):
            check.fault(f"in leg {k} somebody does not begin where the leg before ended")
    if not run.legs:
        check.fault("there are no legs, so nobody ever looks")
    if check.broken:
        return None
    legs = run.legs
    return Schedule(
        np.array([legs[0].begin_s, *(leg.end_s for leg in legs)]),
        np.array([legs[0].before, *(leg.after for leg in legs)]),
        np.array([leg.active for leg in legs]),
    )


def _problem(header: dict[str, Any]) -> Problem:
    floor = header["floor"]
    plan = PolygonMap(floor["outer"], floor["holes"], str(floor["name"]))
    sent = cast("list[dict[str, Any]]", header["pursuers"])
    if not 1 <= len(sent) <= MAX_PURSUERS:
        raise ValueError(f"{len(sent)} pursuers")
    if not isinstance(header["known"], bool):
        raise TypeError(f"known is {header['known']!r}")
    return Problem(
        plan=plan,
        pursuers=tuple(_pursuer(one) for one in sent),
        known=header["known"],
        most=None if header["most"] is None else _count(header["most"]),
        begin_with=_count(header["begin_with"]),
        deaths=tuple(_death(one) for one in header["faults"]),
    )


def _death(one: dict[str, Any]) -> tuple[int, float]:
    if one["kind"] != "dies" or not isinstance(one["robot"], int):
        raise ValueError(f"a fault {one!r}")
    return one["robot"], _number(one["at_s"])


def _pursuer(one: dict[str, Any]) -> Pursuer:
    x, y = one["start"]
    return Pursuer(
        name=str(one["name"]),
        start=(_number(x), _number(y)),
        speed_mps=_positive(one["speed_mps"]),
        range_m=None if one["range_m"] is None else _positive(one["range_m"]),
        reach_m=None if one["reach_m"] is None else _positive(one["reach_m"]),
    )


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise TypeError(f"{value!r} is no number")
    return float(value)


def _positive(value: object) -> float:
    number = _number(value)
    if number <= 0.0:
        raise ValueError(f"{value!r} is not above 0")
    return number


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{value!r} is no number of pursuers")
    return value
