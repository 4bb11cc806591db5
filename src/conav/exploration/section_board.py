"""The blackboard of sections: what nobody has scanned yet, and who has which part of it.

The area is cut into strips one planning cell wide, numbered across the lanes. A section is an
interval of strips <l_j, u_j> that nobody has scanned; its width d_j is their number. The board
holds the strips that were scanned and, per robot, the section it was given. All else follows from
these two, so boards of robots that met merge without a conflict: scanned strips add up, and of two
entries about one robot the newer holds.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum


class Status(StrEnum):
    """The status q_j of a section."""

    UNSCANNED = "unscanned"
    TO_BE_SCANNED = "to_be_scanned"
    BEING_SCANNED = "being_scanned"


_ORDER = (Status.UNSCANNED, Status.TO_BE_SCANNED, Status.BEING_SCANNED)


def section_capacities(widths: Sequence[float], robots: int, task_width: float) -> list[int]:
    """The capacities n_cj of sections of these widths d_j, Algorithm 1 of [Dai2018].

    `robots` is n_a, those that take part in the assignment; `task_width` is d_0, what one robot can
    scan in a task. Ties of the largest go to the first. Sections of no width keep capacity 0; the
    algorithm's own steps would give one to the first of them when there is nothing else.
    """
    capacities = [1 if width > 0 else 0 for width in widths]  # step 1
    left = [float(width) for width in widths]  # step 2
    while sum(capacities) < robots and any(width > 0 for width in left):  # steps 3 and 5
        p = left.index(max(left))  # step 4
        capacities[p] += 1
        left[p] -= task_width
    return capacities


def divide(lower: int, upper: int, parts: int, lane: int) -> list[tuple[int, int]]:
    """A section's division into at most `parts` sub-sections of whole lanes, from below.

    A lane is `lane` strips wide; what is left over goes to the last sub-section's last lane.
    """
    lanes = -(-(upper - lower + 1) // lane)
    parts = min(parts, lanes)
    pieces: list[tuple[int, int]] = []
    begin = lower
    for part in range(parts):
        share = lanes // parts + (1 if part < lanes % parts else 0)
        end = upper if part == parts - 1 else begin + share * lane - 1
        pieces.append((begin, end))
        begin = end + 1
    return pieces


@dataclass(frozen=True)
class Claim:
    """An entry of the board: the section one robot was given; empty when upper < lower."""

    robot: int
    lower: int
    upper: int
    status: Status
    version: int  # counts the entries about this robot
    step: int  # when it was entered
    advance: int = 0  # +1 or -1: the way it scans across the section; 0 in stage 1
    heading: int = 0  # +1 or -1: the way it drives its first lane in stage 1; 0 in stage 2
    begun: int = 0  # lanes of the rectangle under way it has begun

    @property
    def rank(self) -> tuple[int, ...]:
        """Of two entries about one robot the one of higher rank holds."""
        return (
            self.version,
            self.step,
            _ORDER.index(self.status),
            self.lower,
            self.upper,
            self.advance,
            self.heading,
            self.begun,
        )


CLAIM_BYTES = 4 + 4 + 4 + 1 + 4 + 4 + 1 + 1 + 1


@dataclass(frozen=True)
class News:
    """What one robot tells another of its board."""

    axis: int
    voted_by: int
    scanned: tuple[tuple[int, int], ...]  # intervals of strips
    claims: tuple[Claim, ...]

    @property
    def size_bytes(self) -> int:
        """Axis 1, voter 4, two counts 4 each, 8 per interval, 24 per claim."""
        return 13 + 8 * len(self.scanned) + CLAIM_BYTES * len(self.claims)


@dataclass(frozen=True)
class Section:
    """A section of the blackboard <d_j, b_j, n_cj, q_j>, and whose it is; lengths in strips."""

    lower: int  # l_j of the border b_j
    upper: int  # u_j
    width: int  # d_j
    capacity: int  # n_cj: how many robots it can contain
    status: Status  # q_j
    robot: int = -1  # who has it so far, -1 nobody


@dataclass
class Board:
    """One robot's copy of the blackboard."""

    axis: int  # 0: lanes run north and south, strips are columns; 1: east and west, rows
    voted_by: int  # the lowest robot in the vote for the axis
    size: int  # strips of the area
    scanned: int = 0  # bit i: strip i was scanned
    claims: dict[int, Claim] = field(default_factory=dict[int, Claim])
    changes: int = 0

    def width(self, lower: int, upper: int) -> int:
        """How many strips of an interval nobody has scanned."""
        return _count(~self.scanned & _bits(lower, upper)) if upper >= lower else 0

    def total_width(self) -> int:
        """The sum of all widths d_j; stage 2 ends when it is 0."""
        return self.width(0, self.size - 1)

    def unscanned(self, lower: int, upper: int) -> list[tuple[int, int]]:
        """The maximal intervals of strips in [lower, upper] nobody has scanned, ascending."""
        return _intervals(~self.scanned & _bits(lower, upper)) if upper >= lower else []

    def scan(self, lower: int, upper: int) -> tuple[int, int]:
        """The interval, cut to the area, that now counts as scanned."""
        lower, upper = max(lower, 0), min(upper, self.size - 1)
        before = self.scanned
        if upper >= lower:
            self.scanned |= _bits(lower, upper)
        self.changes += self.scanned != before
        return lower, upper

    def enter(
        self,
        robot: int,
        section: tuple[int, int],
        status: Status,
        step: int,
        *,
        advance: int = 0,
        heading: int = 0,
        begun: int = 0,
    ) -> Claim:
        """The new entry about a robot."""
        before = self.claims.get(robot)
        version = before.version + 1 if before is not None else 1
        claim = Claim(robot, *section, status, version, step, advance, heading, begun)
        self.claims[robot] = claim
        self.changes += 1
        return claim

    def release(self, robot: int, step: int) -> Claim:
        """The entry that says a robot has no section any more."""
        return self.enter(robot, (0, -1), Status.UNSCANNED, step)

    def news(self) -> News:
        """All of the board."""
        claims = tuple(self.claims[robot] for robot in sorted(self.claims))
        return News(self.axis, self.voted_by, tuple(_intervals(self.scanned)), claims)

    def merge(self, news: News) -> bool:
        """Whether the board changed by what another robot told.

        Robots that voted apart may have lanes across each other. Then the vote with the lowest
        voter holds, and what was entered under the other is void.
        """
        before = self.changes
        if news.axis != self.axis:
            if news.voted_by >= self.voted_by:
                return False
            self.axis, self.scanned, self.claims = news.axis, 0, {}
            self.changes += 1
        self.voted_by = min(self.voted_by, news.voted_by)
        for lower, upper in news.scanned:
            self.scan(lower, upper)
        for claim in news.claims:
            mine = self.claims.get(claim.robot)
            if mine is None or claim.rank > mine.rank:
                self.claims[claim.robot] = claim
                self.changes += 1
        return self.changes != before

    def silent(self, stirred: Sequence[int], step: int, limit: float, robot: int) -> list[int]:
        """Robots with a section that `robot` has no sign of for more than `limit` steps.

        `stirred` is the step each was last heard to have moved; an entry about it is a sign too.
        """
        return [
            other
            for other, claim in self.claims.items()
            if other != robot and step - max(stirred[other], claim.step) > limit
        ]

    def held(self, silent: Iterable[int] = ()) -> list[Claim]:
        """The claims that hold, by robot: not empty, and not of robots that fell silent."""
        gone = set(silent)
        return [
            claim
            for robot, claim in sorted(self.claims.items())
            if robot not in gone and self.width(claim.lower, claim.upper) > 0
        ]

    def lanes_beside(self, lane: int, half: int, taken: Sequence[Claim]) -> dict[int, int]:
        """The lanes beside a lane, by side -1 and +1, where there is a strip to scan for it.

        They lie a footprint away, or less where less is left to scan.
        """
        found: dict[int, int] = {}
        for side in (-1, 1):
            strips = [lane + side * (half + i) for i in range(1, 2 * half + 2)]
            wanted = [
                strip
                for strip in strips
                if 0 <= strip < self.size
                and self.width(strip, strip)
                and not any(claim.lower <= strip <= claim.upper for claim in taken)
            ]
            if wanted:
                found[side] = wanted[-1] - side * half
        return found

    def free(self, held: Iterable[Claim]) -> list[tuple[int, int]]:
        """The sections with status unscanned: neither scanned nor anybody's, ascending."""
        taken = self.scanned
        for claim in held:
            taken |= _bits(claim.lower, claim.upper)
        return _intervals(~taken & _bits(0, self.size - 1))

    def sections(self, held: Sequence[Claim], robots: int, task_width: float) -> list[Section]:
        """All sections when `robots` robots are free, ascending by status, then by border.

        Capacities are those of Algorithm 1: of unscanned sections for the free robots, of those
        that are somebody's for the robots that have them as well. Rectangles of stage 1 are not
        among them: nobody else is let into one.
        """
        free = self.free(held)
        widths = [upper - lower + 1 for lower, upper in free]
        capacities = section_capacities(widths, robots, task_width)
        found = [
            Section(lower, upper, width, capacity, Status.UNSCANNED)
            for (lower, upper), width, capacity in zip(free, widths, capacities, strict=True)
        ]
        for status in (Status.TO_BE_SCANNED, Status.BEING_SCANNED):
            some = [claim for claim in held if claim.status is status and claim.heading == 0]
            widths = [self.width(claim.lower, claim.upper) for claim in some]
            capacities = section_capacities(widths, len(some) + robots, task_width)
            found += [
                Section(claim.lower, claim.upper, width, capacity, status, claim.robot)
                for claim, width, capacity in zip(some, widths, capacities, strict=True)
            ]
        return found

    def offer(
        self, held: Sequence[Claim], robots: int, task_width: float, lane: int
    ) -> list[Section]:
        """The sections to bid for: unscanned ones, else to be scanned, else being scanned.

        Each has room for one robot. Unscanned sections are divided into as many sub-sections as
        they have capacity for. Of sections that are somebody's the far half is offered where they
        have capacity for another, in whole lanes; a robot keeps one lane, and those it has begun.
        """
        sections = self.sections(held, robots, task_width)
        for status in _ORDER:
            items = [
                Section(*part, self.width(*part), 1, status, section.robot)
                for section in sections
                if section.status is status
                for part in self._parts(section, lane)
            ]
            if items:
                return items
        return []

    def _parts(self, section: Section, lane: int) -> list[tuple[int, int]]:
        """What of a section may be bid for."""
        if section.robot < 0:
            return divide(section.lower, section.upper, section.capacity, lane)
        part = self._far_half(self.claims[section.robot], lane) if section.capacity > 1 else None
        return [] if part is None else [part]

    def _far_half(self, claim: Claim, lane: int) -> tuple[int, int] | None:
        pieces = self.unscanned(claim.lower, claim.upper)
        lower, upper = pieces[0][0], pieces[-1][1]
        lanes = -(-(upper - lower + 1) // lane)
        keeps = max(lanes - lanes // 2, claim.begun)
        if keeps >= lanes:
            return None
        if claim.advance < 0:
            return lower, upper - keeps * lane
        return lower + keeps * lane, upper


def _bits(lower: int, upper: int) -> int:
    return ((1 << (upper + 1)) - 1) & ~((1 << lower) - 1) if upper >= lower else 0


def _count(bits: int) -> int:
    return bits.bit_count()


def _intervals(bits: int) -> list[tuple[int, int]]:
    """The runs of ones, ascending."""
    found: list[tuple[int, int]] = []
    begin = 0
    while bits:
        zeros = (bits & -bits).bit_length() - 1
        bits >>= zeros
        ones = (~bits & (bits + 1)).bit_length() - 1
        found.append((begin + zeros, begin + zeros + ones - 1))
        bits >>= ones
        begin += zeros + ones
    return found
