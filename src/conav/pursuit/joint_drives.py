"""Between which shadows an evader can get while several pursuers drive at once.

All begin together and arrive together. What is seen all the time contains what those who stand see,
and what each driver sees throughout, as in `shadow_links`; each is found by itself and their union
is taken. An evader stays in one component of the rest.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from conav.geometry.view_cells import MOST_VIEWS, join_cells
from conav.geometry.view_cells import shadows as shadows_of
from conav.pursuit.shadow_moves import Links, ShadowMoves, Team

Drives = tuple[tuple[int, int], ...]
"""Viewpoints by number: where each drive begins and ends."""


@dataclass
class JointDrives:
    """What drives at the same time do to shadows on one floor, kept as it is found."""

    shadows: ShadowMoves
    _links: dict[tuple[Team, Drives], Links] = field(
        default_factory=dict[tuple[Team, Drives], Links]
    )

    def after(
        self, standing: Team, drives: Drives, contaminated: int, halvings: int | None = None
    ) -> int:
        """The new shadows, as bits, that may hold somebody after these drives, given the old ones.

        Viewpoints by number. The drives are halved where that may tell more, up to `halvings`
        times, by default as often as a drive by itself.
        """
        drives = tuple(sorted(set(drives)))
        left = self.shadows.halvings if halvings is None else halvings
        if len(drives) == 1:
            return self.shadows.numbered_after(standing, *drives[0], contaminated, left)
        bits, doubt = self.links(standing, drives).apply(contaminated)
        if not doubt or left == 0:
            return bits
        middles = [self.shadows.middle(a, b) for a, b in drives]
        if min(middles) < 0:
            return bits
        first = tuple((a, m) for (a, _), m in zip(drives, middles, strict=True))
        second = tuple((m, b) for (_, b), m in zip(drives, middles, strict=True))
        half_way = self.after(standing, first, contaminated, left - 1)
        return bits & self.after(standing, second, half_way, left - 1)

    def fits(self, standing: Team, drives: Drives) -> bool:
        """Whether so many viewpoints can be laid over each other."""
        return len({*standing, *(end for drive in drives for end in drive)}) <= MOST_VIEWS

    def links(self, standing: Team, drives: Drives) -> Links:
        """The rule for whole drives, as `ShadowMoves.links` has it for one."""
        if (standing, drives) not in self._links:
            self._links[standing, drives] = self._find(standing, drives)
        return self._links[standing, drives]

    def _find(self, standing: Team, drives: Drives) -> Links:
        who = np.array(sorted({*standing, *(end for pair in drives for end in pair)}), np.int64)
        cells = self.shadows.cells(who)
        bit = {number: 1 << i for i, number in enumerate(who.tolist())}
        stand = sum(bit[number] for number in standing)
        at_begin = stand | _union(bit[a] for a, _ in drives)
        at_end = stand | _union(bit[b] for _, b in drives)
        seen = cells.seen_by & stand != 0
        for a, b in drives:
            ends = bit[a] | bit[b]
            both = cells.seen_by & ends == ends
            self.shadows.leave_out_holes(cells, a, b, both)
            seen |= both
        component = join_cells(cells, ~seen)
        count = int(component.max(initial=-1)) + 1
        sides: list[list[int]] = []
        for viewers in (at_begin, at_end):
            bits = [0] * count
            numbers = shadows_of(cells, viewers)
            for cell in np.flatnonzero(numbers >= 0).tolist():
                bits[int(component[cell])] |= 1 << int(numbers[cell])
            sides.append(bits)
        joined = [pair for pair in zip(*sides, strict=True) if pair != (0, 0)]
        return Links(tuple(old for old, _ in joined), tuple(new for _, new in joined))


def _union(bits: Iterable[int]) -> int:
    result = 0
    for one in bits:
        result |= one
    return result
