"""Colours: of the page, of what a team knows, and one per robot that no two people confuse."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

PAGE, TEXT, SOFT_TEXT, STRIP, CURVE, UNKNOWN_GROUND, HIDDEN_WALL, WALL, FRONTIER = range(9)
"""Colour numbers that every picture has; those of the robots follow."""

_PAGE_COLOURS = (
    (255, 255, 255),
    (38, 44, 54),
    (104, 113, 126),
    (240, 242, 245),
    (158, 172, 190),
    (203, 207, 213),
    (186, 191, 199),
    (48, 54, 64),
    (255, 250, 214),
)

# Okabe and Ito (2008), "Color Universal Design", without their black: walls have it.
_OKABE_ITO = (
    (0, 114, 178),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
    (240, 228, 66),
)

MAX_DISTINCT = 64
"""Teams with more robots share colours in turn."""

_TINT = 0.20  # share of the robot's colour in the ground it saw first
_MAX_LUMINANCE = 0.36  # of a line, so that it stands out from its own tint

_TO_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
# What eyes without the long or the middle cones see: Machado, Oliveira and Fernandes (2009).
_PROTANOPE = np.array(
    [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ]
)
_DEUTERANOPE = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)


class Colours:
    """The colours of one picture by number: the page's, a tint and a line colour per robot."""

    def __init__(self, robots: int) -> None:
        self.distinct = max(min(robots, MAX_DISTINCT), 1)
        pure = robot_colours(self.distinct).astype(np.float64)
        lines = np.array([_dark_enough(colour) for colour in pure])
        tints = 255.0 + (lines - 255.0) * _TINT
        table = np.concatenate([np.array(_PAGE_COLOURS, dtype=np.float64), tints, lines])
        self.rgb = np.rint(table).astype(np.uint8)  # (colours, 3)

    def tint(self, robot: int) -> int:
        """The number of the soft colour of ground the robot saw first."""
        return len(_PAGE_COLOURS) + robot % self.distinct

    def line(self, robot: int) -> int:
        """The number of the robot's own colour, for its path and body."""
        return len(_PAGE_COLOURS) + self.distinct + robot % self.distinct


@lru_cache(maxsize=8)
def robot_colours(robots: int) -> NDArray[np.uint8]:
    """Colours that differ from each other for every eye, shape (robots, 3).

    The first seven are those of Okabe and Ito. Each further one is the candidate farthest from all
    before it and from the page's own, measured in Oklab for full colour vision and for the two
    common kinds of colour blindness, the smallest of the three distances counting.
    """
    chosen = np.array(_OKABE_ITO, dtype=np.uint8)
    if robots > len(chosen):
        candidates = _candidates()
        seen = _as_seen(candidates)
        taken = np.concatenate([chosen, np.array(_PAGE_COLOURS, dtype=np.uint8)])
        nearest = np.min([_distance(seen, _as_seen(one[None])) for one in taken], axis=0)
        added: list[NDArray[np.uint8]] = []
        while len(chosen) + len(added) < robots:
            best = int(np.argmax(nearest))
            added.append(candidates[best])
            nearest = np.minimum(nearest, _distance(seen, seen[:, best : best + 1]))
        chosen = np.concatenate([chosen, np.array(added)])
    chosen = chosen[:robots]
    chosen.flags.writeable = False
    return chosen


def _candidates() -> NDArray[np.uint8]:
    """Colours with some colour in them, neither near white nor near black, shape (m, 3)."""
    steps = np.arange(0, 256, 15)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    lab = _oklab(_linear(cube))
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    keep = (lab[:, 0] > 0.38) & (lab[:, 0] < 0.82) & (chroma > 0.06)
    return cube[keep].astype(np.uint8)


def _dark_enough(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    luminance = float(_linear(colour) @ np.array([0.2126, 0.7152, 0.0722]))
    if luminance <= _MAX_LUMINANCE:
        return colour
    # Dividing light by a factor divides the coded value by about its 2.2th root.
    return colour * (_MAX_LUMINANCE / luminance) ** (1 / 2.2)


def _linear(rgb: NDArray[np.generic]) -> NDArray[np.float64]:
    share = rgb.astype(np.float64) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def _oklab(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lightness and two opponent colours (Ottosson 2020), where distance is what eyes tell."""
    return np.cbrt(np.clip(light, 0.0, None) @ _TO_LMS.T) @ _TO_LAB.T


def _as_seen(rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Oklab of each colour for three kinds of eyes, shape (3, m, 3)."""
    light = _linear(rgb)
    eyes = (light, light @ _PROTANOPE.T, light @ _DEUTERANOPE.T)
    return np.stack([_oklab(seen) for seen in eyes])


def _distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The smallest distance over the kinds of eyes, colour by colour, shape (m,)."""
    far = np.sqrt(((a - b) ** 2).sum(axis=2))
    # With two kinds of cones nobody tells dozens of colours apart; counted in full, those eyes
    # would leave no room for what the others can.
    return np.minimum(far[0], np.minimum(far[1], far[2]) * 2.0)
