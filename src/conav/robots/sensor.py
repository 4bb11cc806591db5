"""What a robot sees from where it stands."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Sensor:
    """A sensor that looks all around, up to `range_m` metres, cell-exact.

    With `occlusion` walls block sight (a 360 degree range sensor): a free cell is seen when the
    segment between the two cell centres is clear, a wall when part of its boundary is. Without, all
    cells whose centre lies in the disc are seen, as in papers/000.
    """

    name: str
    occlusion: bool
    range_m: float  # [m] between cell centres


SENSORS = {"range": True, "disc": False}
"""Sensor name -> whether walls block its sight."""


def sensor(name: str, range_m: float) -> Sensor:
    """The sensor of that name with that range [m]."""
    return Sensor(name, SENSORS[name], range_m)
