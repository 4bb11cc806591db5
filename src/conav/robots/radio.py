"""Who hears whom, how much of it is lost, and how late it comes."""

from dataclasses import dataclass
from math import inf, log10

RADIOS = ("perfect", "off", "path-loss")
"""The radios that go by a name alone; others have a range."""

_DECIMALS = 12


@dataclass(frozen=True)
class PathLoss:
    """A log-distance link budget with separate exponents for free space and for walls.

    The form of the signal model of IR2 (Tan et al., IROS 2024), with its constants as defaults:

        PL = PL0 + [10 g_w log10(d_w) + K  if d_w > 0] + [10 g log10(d_f / d0) + X  if d_f >= d0]

    where d_w and d_f are the lengths of the line of sight inside cells that are not free and inside
    free ones, in units of `unit_m`; there is a link when P_T - PL is above the threshold. The
    original counts pixels, so that its d_w is 1 or more; the wall's term is 0 here where a thinner
    one would make it negative, for a wall never helps.
    """

    transmit_dbm: float = -20.0  # P_T
    threshold_dbm: float = -70.0
    reference_db: float = 31.0  # PL0
    free_exponent: float = 2.0  # g
    wall_exponent: float = 4.0  # g_w
    reference_distance: float = 35.0  # d0 [units]
    wall_shadow_db: float = 0.0  # K
    free_shadow_db: float = 0.0  # X
    unit_m: float = 0.1  # [m]

    def loss_db(self, free_m: float, wall_m: float) -> float:
        """The path loss PL over these lengths [m], rounded so that it is equal on every machine."""
        loss = self.reference_db
        wall, free = wall_m / self.unit_m, free_m / self.unit_m
        if wall > 0.0:
            loss += max(10.0 * self.wall_exponent * _log10(wall), 0.0) + self.wall_shadow_db
        if free >= self.reference_distance:
            ratio = free / self.reference_distance
            loss += 10.0 * self.free_exponent * _log10(ratio) + self.free_shadow_db
        return round(loss, _DECIMALS)

    def reaches(self, free_m: float, wall_m: float) -> bool:
        """Whether a message gets across."""
        return self.transmit_dbm - self.loss_db(free_m, wall_m) > self.threshold_dbm


def _log10(value: float) -> float:
    # Logarithms differ in the last digit between machines.
    return round(log10(value), _DECIMALS)


@dataclass(frozen=True)
class Radio:
    """A radio: two robots hear each other when both their radios reach the other.

    It reaches as far as `range_m`, and with `path_loss` where that leaves enough of the signal.
    `range_m` None and no path loss is the radio that reaches everybody; 0 is one that is off, with
    which robots hear nobody even where they pass through each other. Links are symmetric. Each
    message over a link is lost independently with probability `loss`; what arrives does so
    `delay_s` later, rounded up to steps.
    """

    name: str
    range_m: float | None  # [m] or None for no limit
    path_loss: PathLoss | None = None
    loss: float = 0.0  # 0 to less than 1
    delay_s: float = 0.0  # [s]

    def __post_init__(self) -> None:
        if not 0.0 <= self.loss < 1.0:
            raise ValueError(f"a radio that loses {self.loss:g} of its messages; give 0 to below 1")
        if not 0.0 <= self.delay_s < inf:
            raise ValueError(f"a radio with a delay of {self.delay_s:g} s; give 0 or more")


def radio(
    name: str, range_m: float | None = None, *, loss: float = 0.0, delay_s: float = 0.0
) -> Radio:
    """The radio of that name: "perfect", "off", "path-loss", or "limited" with a range [m]."""
    if name == "perfect":
        return Radio("perfect", None, None, loss, delay_s)
    if name == "path-loss":
        return Radio("path-loss", None, PathLoss(), loss, delay_s)
    if name == "off" or (name == "limited" and range_m == 0):
        return Radio("off", 0.0, None, loss, delay_s)
    if name == "limited" and range_m is not None:
        return Radio("limited", range_m, None, loss, delay_s)
    raise ValueError(f"no radio {name!r} with range {range_m}")
