"""The nouns of pursuit: the problem, a schedule, the result."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.maps.polygon_map import PolygonMap
from conav.robots.fault import Fault
from conav.status import Status


@dataclass(frozen=True)
class Pursuer:
    """A point that moves at bounded speed and sees all round, as far as walls let it.

    With `range_m` it sees no farther than that; with `reach_m` it drives no farther than that in
    all, and refuses what it could not finish.
    """

    name: str
    start: tuple[float, float]  # [m]
    speed_mps: float = 1.0
    range_m: float | None = None  # None: no limit
    reach_m: float | None = None  # None: no limit


@dataclass(frozen=True, eq=False)
class PursuitProblem:
    """A floor on which evaders of unbounded speed may be, and who is sent to clear it.

    The evader is a point and moves through the closed floor, borders included. It is caught when a
    pursuer sees it: when the straight segment between them lies in the closed floor and is no
    longer than the pursuer's range. With `known` false a pursuer knows of the floor what it has
    seen or been told. `pursuers` are those to begin with; `most` says how many may be sent, and
    `faults` which of those sent are lost, and when.
    """

    floor: PolygonMap
    pursuers: tuple[Pursuer, ...]
    known: bool = True
    most: int | None = None  # None: no limit
    name: str = "floor"
    faults: tuple[Fault, ...] = ()  # who is lost when; robots are numbered as pursuers are sent

    def __post_init__(self) -> None:
        if not self.pursuers:
            raise ValueError("a pursuit needs one pursuer at least")
        for fault in self.faults:
            if fault.kind != "dies":
                raise ValueError(f"a pursuer that {fault.kind}; all it can do is die")
        if len({fault.robot for fault in self.faults}) < len(self.faults):
            raise ValueError("a pursuer dies twice")


@dataclass(frozen=True, eq=False)
class Schedule:
    """Who is where at which time.

    Between `times[m]` and `times[m + 1]` pursuer i drives from `positions[m, i]` to
    `positions[m + 1, i]` on a straight line at constant speed, and sees when `active[m, i]`: it is
    not before it enters the floor, nor after it was lost. Times never fall; two equal times mark a
    moment at which pursuers enter or are lost. Arrays are copied and locked.
    """

    times: NDArray[np.float64]  # (n + 1,) [s]
    positions: NDArray[np.float64]  # (n + 1, pursuers, 2) [m]
    active: NDArray[np.bool_]  # (n, pursuers)

    def __post_init__(self) -> None:
        times, positions, active = (
            _locked(self.times, np.float64),
            _locked(self.positions, np.float64),
            _locked(self.active, np.bool_),
        )
        moments, pursuers = positions.shape[:2]
        fits = times.shape == (moments,) and active.shape == (moments - 1, pursuers)
        if positions.ndim != 3 or positions.shape[2] != 2 or not fits:
            raise ValueError("a schedule's times, positions and activity do not belong together")
        if not (np.isfinite(times).all() and np.isfinite(positions).all()):
            raise ValueError("a schedule's times and positions are finite")
        if (np.diff(times) < 0).any():
            raise ValueError("a schedule's times never fall")
        for name, array in (("times", times), ("positions", positions), ("active", active)):
            object.__setattr__(self, name, array)

    @property
    def distance_m(self) -> float:
        """What all pursuers drive together while they are active."""
        legs = np.hypot(*np.moveaxis(np.diff(self.positions, axis=0), 2, 0))
        return float(legs[self.active].sum())


@dataclass(frozen=True, eq=False)
class HiddenRegion:
    """A part of the floor that nobody sees, as a team knows it. Arrays are copied and locked."""

    outer: NDArray[np.float64]  # (n, 2) [m]
    holes: tuple[NDArray[np.float64], ...] = ()  # each (m, 2) [m]
    clear: bool = False  # whether nobody can be in it, as far as the team can tell

    def __post_init__(self) -> None:
        object.__setattr__(self, "outer", _locked(self.outer, np.float64))
        object.__setattr__(self, "holes", tuple(_locked(one, np.float64) for one in self.holes))


@dataclass(frozen=True, eq=False)
class PursuitResult:
    """What a method found.

    `status` is done when, as far as the team can tell, nobody can be hidden any longer; infeasible
    when it is proved that so many pursuers cannot do it. Whether an evader could have escaped is
    for the verifier to say, from the run file.
    """

    status: Status
    reason: str  # in words a person acts on; "" when done
    schedule: Schedule
    pursuers: tuple[Pursuer, ...]  # all that were sent, in the order of the schedule
    lower_bound: int  # certified: fewer than so many cannot clear the floor
    minimal_proved: bool  # whether the team's size equals that bound
    counters: Mapping[str, int] = field(default_factory=dict)
    explored: float | None = None
    """The share of the floor's area that was seen, on a floor not known before."""
    recontaminations: int | None = None
    """After how many drives something known and clear was contaminated again, where counted."""
    beliefs: Mapping[int, tuple[HiddenRegion, ...]] = field(
        default_factory=dict[int, tuple[HiddenRegion, ...]]
    )
    """All that is hidden after a leg of the schedule, by the leg's number, where the team says."""
    history: tuple[Mapping[str, Any], ...] = ()  # what was decided when, for pictures and people


def _locked(array: ArrayLike, kind: Any) -> NDArray[Any]:
    copy = np.array(array, dtype=kind)
    copy.flags.writeable = False
    return copy
