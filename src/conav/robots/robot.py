"""A robot."""

from dataclasses import dataclass

from conav.robots.motion import MOTIONS, Motion
from conav.robots.radio import Radio
from conav.robots.sensor import Sensor

_RANGE_SENSOR = Sensor("range", occlusion=True, range_m=7.0)
_PERFECT_RADIO = Radio("perfect", range_m=None)


@dataclass(frozen=True)
class Robot:
    """One robot: name, body and equipment."""

    name: str
    radius_m: float = 0.1  # [m]
    speed_mps: float = 0.5  # [m/s] top speed
    motion: Motion = MOTIONS["8-connected"]
    sensor: Sensor = _RANGE_SENSOR
    radio: Radio = _PERFECT_RADIO
    energy_j: float | None = None  # [J] or None for no limit
