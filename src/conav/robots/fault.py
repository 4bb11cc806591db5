"""What may go wrong with a robot, as data of a problem."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Literal, cast, get_args

from conav.errors import InputError

Kind = Literal["dies", "stalls", "joins"]
KINDS: tuple[str, ...] = get_args(Kind)


@dataclass(frozen=True)
class Fault:
    """Something that happens to one robot at one time.

    A robot that "dies" is gone for good: it neither moves, senses, thinks nor talks. One that
    "stalls" cannot move until `until_s`, or ever again; it still senses, thinks and talks. One that
    "joins" is not there before. Times count from the first step at or after them.
    """

    robot: int  # number
    kind: Kind
    at_s: float  # [s] simulated
    until_s: float | None = None  # [s] when a stall ends, None never

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"a robot that {self.kind!r}; give one of {', '.join(KINDS)}")
        if not 0.0 <= self.at_s < inf:
            raise ValueError(f"a fault at {self.at_s} s; give 0 or more seconds")
        if self.until_s is not None and self.kind != "stalls":
            raise ValueError(f"a robot that {self.kind} does so at one time; leave the second out")
        if self.until_s is not None and not self.at_s < self.until_s < inf:
            raise ValueError(f"a stall from {self.at_s:g} s to {self.until_s:g} s")


def check_faults(faults: tuple[Fault, ...], robots: int) -> None:
    """Raise `ValueError` unless these can happen to a team of so many robots."""
    for fault in faults:
        if not 0 <= fault.robot < robots:
            raise ValueError(f"a fault of robot {fault.robot}; there are {robots} robots")
    for kind in ("dies", "joins"):
        numbers = [fault.robot for fault in faults if fault.kind == kind]
        for robot in numbers:
            if numbers.count(robot) > 1:
                raise ValueError(f"robot {robot} {kind} twice")


def parse_fault(text: str, names: Sequence[str]) -> Fault:
    """The fault that "ROBOT:dies:S", "ROBOT:joins:S", "ROBOT:stalls:S" or "ROBOT:stalls:S:S" says.

    Raises `InputError` for any other text, and for a robot that is not among the names.

    >>> parse_fault("robot_1:stalls:50:200", ["robot_0", "robot_1"])
    Fault(robot=1, kind='stalls', at_s=50.0, until_s=200.0)
    """
    place = f"fault {text!r}"
    remedy = "write robot_1:dies:100, robot_2:stalls:50:200, robot_0:stalls:50 or robot_3:joins:300"
    name, _, rest = text.partition(":")
    kind, *times = rest.split(":")
    if kind not in KINDS or not 1 <= len(times) <= 2:
        raise InputError(place, "is not ROBOT:KIND:SECONDS", remedy)
    if name not in names:
        raise InputError(
            place, f"is of {name!r}, who is not in the team", f"robots: {names[0]} to {names[-1]}"
        )
    try:
        at_s, *until_s = (float(time) for time in times)
    except ValueError:
        raise InputError(place, "has times that are no numbers", remedy) from None
    try:
        return Fault(names.index(name), cast("Kind", kind), at_s, *until_s)
    except ValueError as error:
        raise InputError(place, f"cannot be: {error}", remedy) from None
