"""Longitudes and latitudes of a building, laid flat.

x points east and y north, in metres from the middle of the bounding box, on the plane that touches
the WGS 84 ellipsoid there: degrees times the ellipsoid's two radii of curvature. Over a site of a
kilometre lengths are off by less than a tenth of a millimetre a metre.
"""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from conav.errors import InputError
from conav.geometry.turned import cosine_and_sine
from conav.maps.rings import Ring

Coordinates = Literal["auto", "degrees", "metres"]

SMALL = 0.05  # what spans less, both ways, is no plan in metres: 5 cm, but up to 5 km in degrees

_AXIS_M = 6378137.0
_ECCENTRICITY_SQUARED = 0.0066943799901413165


def in_metres(
    place: object, parts: Sequence[Sequence[Ring]], coordinates: Coordinates, declared: bool | None
) -> tuple[list[list[Ring]], list[str]]:
    """The rings in metres, and what was done about degrees, for people.

    With `auto`, rings are in degrees where the file says so (`declared`), and where it says nothing
    if they lie within 180 and 90 and span less than `SMALL` both ways. Raises `InputError` for
    degrees out of range.
    """
    whole = [[np.asarray(ring, dtype=np.float64) for ring in part] for part in parts]
    points = np.concatenate([ring for part in whole for ring in part])
    low, high = points.min(axis=0), points.max(axis=0)
    inside = bool(np.abs(points[:, 0]).max() <= 180 and np.abs(points[:, 1]).max() <= 90)
    if coordinates == "auto":
        small = inside and bool((high - low).max() < SMALL)
        degrees = small if declared is None else declared
    else:
        degrees = coordinates == "degrees"
    if not degrees:
        return whole, []
    if not inside:
        raise InputError(
            place,
            "longitudes or latitudes are out of range",
            "give --coordinates metres if they are metres",
        )
    lon, lat = ((low + high) / 2).tolist()
    cosine, sine = cosine_and_sine(math.radians(lat))
    bulge = 1.0 - _ECCENTRICITY_SQUARED * sine * sine
    east = _AXIS_M / math.sqrt(bulge) * cosine
    north = _AXIS_M * (1.0 - _ECCENTRICITY_SQUARED) / (bulge * math.sqrt(bulge))
    scale = np.array([east, north]) * (math.pi / 180.0)
    flat = [[(ring - np.array([lon, lat])) * scale for ring in part] for part in whole]
    said = "as the file says" if declared else "as their range suggests"
    why = said if coordinates == "auto" else "as asked"
    return flat, [
        f"coordinates were read as degrees, {why}, and laid flat in metres from longitude"
        f" {lon:.7f}, latitude {lat:.7f}"
    ]
