"""A robot."""

from dataclasses import dataclass
from math import inf

from conav.robots.motion import MOTIONS, Motion
from conav.robots.radio import Radio
from conav.robots.sensor import Sensor

_RANGE_SENSOR = Sensor("range", occlusion=True, range_m=7.0)
_PERFECT_RADIO = Radio("perfect", range_m=None)


@dataclass(frozen=True)
class Robot:
    """One robot: name, body and equipment.

    With `energy_j` it has a battery: it spends `on_w` for as long as it is switched on and
    `drive_j_per_m` for what it drives, and is dead in the first step that finds nothing left. The
    defaults are of the order of a small indoor robot with a laser scanner and a computer.
    """

    name: str
    radius_m: float = 0.1  # [m]
    speed_mps: float = 0.5  # [m/s] top speed
    motion: Motion = MOTIONS["8-connected"]
    sensor: Sensor = _RANGE_SENSOR
    radio: Radio = _PERFECT_RADIO
    energy_j: float | None = None  # [J] or None for no limit
    drive_j_per_m: float = 20.0  # [J/m]
    on_w: float = 10.0  # [W]

    def __post_init__(self) -> None:
        if self.energy_j is not None and not 0.0 < self.energy_j < inf:
            raise ValueError(f"{self.name} has {self.energy_j:g} J; give more than 0, or None")
        if not (0.0 <= self.drive_j_per_m < inf and 0.0 <= self.on_w < inf):
            raise ValueError(f"{self.name} spends a negative amount of energy, or all at once")

    def spent_j(self, driven_m: float, on_s: float) -> float:
        """What it has spent after driving so far and being on for so long [J]."""
        return round(self.drive_j_per_m * driven_m + self.on_w * on_s, 9)
