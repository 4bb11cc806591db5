"""Who hears whom."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Radio:
    """A radio: two robots hear each other when their distance is at most `range_m`.

    `range_m` None is the perfect radio: everybody hears everybody at once; 0 is a radio that is
    off, with which robots hear nobody even where they pass through each other. Links are symmetric,
    lossless and without delay; other link models are further fields here and a further case in
    `conav.simulation.radio_network`.
    """

    name: str
    range_m: float | None  # [m] or None for no limit


def radio(name: str, range_m: float | None = None) -> Radio:
    """The radio of that name: "perfect", "off", or "limited" with a range [m]."""
    if name == "perfect":
        return Radio("perfect", None)
    if name == "off" or (name == "limited" and range_m == 0):
        return Radio("off", 0.0)
    if name == "limited" and range_m is not None:
        return Radio("limited", range_m)
    raise ValueError(f"no radio {name!r} with range {range_m}")
