"""Where everybody is at every time, and whether a piece of a motion stays clear of it.

Each robot has its pieces, in the order of time until it vanishes or the horizon. Time is cut into
slots; for each the first piece that reaches into it and a box around where the robot then is are
kept, so that most robots are passed over by comparing boxes.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.clearance import pieces_apart as curves_apart
from conav.planning.piece import bend, state_on_piece
from conav.planning.types import PIECE, PlanningProblem

MAX_SLOTS = 512


@dataclass(eq=False)
class Traffic:
    """The trajectories of a team; a robot without one is nowhere.

    `arrays` are for kernels, in the order in which these take them.
    """

    horizon_s: float
    stays: tuple[bool, ...]  # after arrival
    tracks: NDArray[np.float64]  # (robots, room, PIECE)
    sizes: NDArray[np.int64]  # (robots,) pieces in use
    firsts: NDArray[np.int64]  # (robots, slots) the first piece that ends in a slot or later
    boxes: NDArray[np.float64]  # (robots, slots, 4) least x, y, greatest x, y [m]
    bodies: NDArray[np.float64]  # (robots,) radius and half the margin [m]
    span: float = field(init=False)  # [s] of a slot

    def __post_init__(self) -> None:
        self.span = self.horizon_s / self.firsts.shape[1]

    @property
    def arrays(
        self,
    ) -> tuple[
        NDArray[np.float64],
        NDArray[np.int64],
        NDArray[np.int64],
        NDArray[np.float64],
        NDArray[np.float64],
        float,
    ]:
        return (self.tracks, self.sizes, self.firsts, self.boxes, self.bodies, self.span)

    def put(self, robot: int, pieces: NDArray[np.float64]) -> None:
        """The robot drives these pieces, (n, PIECE), and then stays or vanishes."""
        end = pieces[-1]
        rows = pieces
        if self.stays[robot] and end[1] < self.horizon_s:
            x, y, _, _ = state_on_piece(end, float(end[1]))
            rest = np.zeros(PIECE)
            rest[:4] = end[1], self.horizon_s, x, y
            rows = np.vstack([pieces, rest])
        if len(rows) > self.tracks.shape[1]:
            longer = np.zeros((len(self.tracks), 2 * len(rows), PIECE))
            longer[:, : self.tracks.shape[1]] = self.tracks
            self.tracks = longer
        self.tracks[robot, : len(rows)] = rows
        self.sizes[robot] = len(rows)
        _index(self.tracks[robot], len(rows), self.span, self.firsts[robot], self.boxes[robot])

    def remove(self, robot: int) -> None:
        """The robot is nowhere."""
        self.sizes[robot] = 0

    def conflicts(self, robot: int) -> NDArray[np.bool_]:
        """Whether the robot and each other come too close, (robots,)."""
        found = np.zeros(len(self.sizes), np.bool_)
        _conflicts(*self.arrays, robot, found)
        return found


def build_traffic(problem: PlanningProblem) -> Traffic:
    """A floor on which nobody is."""
    robots = problem.robots
    slots = min(MAX_SLOTS, int(problem.horizon_s) + 1)
    return Traffic(
        problem.horizon_s,
        tuple(robot.after_arrival == "stay" for robot in robots),
        np.zeros((len(robots), 32, PIECE)),
        np.zeros(len(robots), np.int64),
        np.zeros((len(robots), slots), np.int64),
        np.zeros((len(robots), slots, 4)),
        np.array([robot.radius_m + 0.5 * problem.margin_m for robot in robots]),
    )


@kernel
def _index(
    pieces: NDArray[np.float64],
    size: int,
    span: float,
    firsts: NDArray[np.int64],
    boxes: NDArray[np.float64],
) -> None:
    """Fills a robot's slots."""
    slots = len(firsts)
    for slot in range(slots):
        firsts[slot] = size
        boxes[slot, 0] = np.inf
        boxes[slot, 1] = np.inf
        boxes[slot, 2] = -np.inf
        boxes[slot, 3] = -np.inf
    for piece in range(size):
        begin = pieces[piece, 0]
        end = pieces[piece, 1]
        first = min(int(begin / span), slots - 1)
        last = min(int(end / span), slots - 1)
        longest = min(end - begin, 1.1 * span)  # of what is looked at in one slot
        sag = 0.125 * bend(pieces[piece]) * longest * longest
        for slot in range(max(first - 1, 0), min(last + 2, slots)):
            # One slot more on each side: a time on the edge of two may count to either.
            firsts[slot] = min(firsts[slot], piece)
            for side in range(2):
                at = max(begin, (slot - 1e-6) * span)
                if side == 1:
                    at = min(end, (slot + 1 + 1e-6) * span)
                at = min(max(at, begin), end)
                x, y, _, _ = state_on_piece(pieces[piece], at)
                boxes[slot, 0] = min(boxes[slot, 0], x - sag)
                boxes[slot, 1] = min(boxes[slot, 1], y - sag)
                boxes[slot, 2] = max(boxes[slot, 2], x + sag)
                boxes[slot, 3] = max(boxes[slot, 3], y + sag)


@kernel
def is_straight(pieces: NDArray[np.float64], row: int) -> bool:
    """Whether a piece goes straight at constant speed."""
    return pieces[row, 6] == 0.0 and pieces[row, 7] == 0.0 and pieces[row, 8] == 0.0


@kernel
def pieces_apart(
    mine: NDArray[np.float64], a: int, theirs: NDArray[np.float64], b: int, distance: float
) -> bool:
    """Whether two pieces are at least `distance` [m] apart at every time both last.

    The relative motion of two straight ones is linear, so its least distance is that of a segment
    to the origin; others are looked at by `conav.planning.clearance`.
    """
    if not (is_straight(mine, a) and is_straight(theirs, b)):
        return curves_apart(mine, a, theirs, b, distance)
    begin = max(mine[a, 0], theirs[b, 0])
    end = min(mine[a, 1], theirs[b, 1])
    if begin > end:
        return True
    from_a = begin - mine[a, 0]
    from_b = begin - theirs[b, 0]
    x = mine[a, 2] + mine[a, 4] * from_a - theirs[b, 2] - theirs[b, 4] * from_b
    y = mine[a, 3] + mine[a, 5] * from_a - theirs[b, 3] - theirs[b, 5] * from_b
    vx = mine[a, 4] - theirs[b, 4]
    vy = mine[a, 5] - theirs[b, 5]
    least = distance * distance
    if x * x + y * y < least:
        return False
    approach = x * vx + y * vy
    if approach >= 0.0:
        return True
    after = min(-approach / (vx * vx + vy * vy), end - begin)
    x += vx * after
    y += vy * after
    return x * x + y * y >= least


@kernel
def _hull(
    pieces: NDArray[np.float64], count: int, span: float, slots: int
) -> tuple[float, float, float, float, int, int]:
    """A box around pieces that follow each other, least and greatest x and y, and their slots.

    A piece with constant acceleration is a curve with three control points, and lies between them;
    one that turns is somewhere within its length.
    """
    left = np.inf
    right = -np.inf
    low = np.inf
    high = -np.inf
    for piece in range(count):
        dt = pieces[piece, 1] - pieces[piece, 0]
        x = pieces[piece, 2]
        y = pieces[piece, 3]
        left = min(left, x)
        right = max(right, x)
        low = min(low, y)
        high = max(high, y)
        vx = pieces[piece, 4] * dt
        vy = pieces[piece, 5] * dt
        if pieces[piece, 8] != 0.0:
            length = abs(vx) + abs(vy)
            left = min(left, x - length)
            right = max(right, x + length)
            low = min(low, y - length)
            high = max(high, y + length)
            continue
        across = x + vx + 0.5 * pieces[piece, 6] * dt * dt
        up = y + vy + 0.5 * pieces[piece, 7] * dt * dt
        left = min(left, min(x + 0.5 * vx, across))
        right = max(right, max(x + 0.5 * vx, across))
        low = min(low, min(y + 0.5 * vy, up))
        high = max(high, max(y + 0.5 * vy, up))
    first = min(int(pieces[0, 0] / span), slots - 1)
    last = min(int(pieces[count - 1, 1] / span), slots - 1)
    return left, right, low, high, first, last


@kernel
def hits(
    tracks: NDArray[np.float64],
    sizes: NDArray[np.int64],
    firsts: NDArray[np.int64],
    boxes: NDArray[np.float64],
    bodies: NDArray[np.float64],
    span: float,
    robot: int,
    heed: NDArray[np.bool_],
    pieces: NDArray[np.float64],
    count: int,
    enough: int,
) -> int:
    """How many of the heeded robots some piece comes too close to; stops counting at `enough`."""
    found = 0
    slots = firsts.shape[1]
    if count == 0:
        return 0
    most_left, most_right, lowest, highest, earliest, latest = _hull(pieces, count, span, slots)
    for other in range(len(sizes)):
        if other == robot or sizes[other] == 0 or not heed[other]:
            continue
        distance = bodies[robot] + bodies[other]
        # Of most others a box around all the pieces is enough.
        about = False
        for slot in range(earliest, latest + 1):
            if (
                boxes[other, slot, 0] <= most_right + distance
                and boxes[other, slot, 2] >= most_left - distance
                and boxes[other, slot, 1] <= highest + distance
                and boxes[other, slot, 3] >= lowest - distance
            ):
                about = True
                break
        if not about:
            continue
        apart = True
        for piece in range(count):
            begin = pieces[piece, 0]
            end = pieces[piece, 1]
            x0 = pieces[piece, 2]
            y0 = pieces[piece, 3]
            x1 = x0 + pieces[piece, 4] * (end - begin)
            y1 = y0 + pieces[piece, 5] * (end - begin)
            away = distance
            if not is_straight(pieces, piece):
                x1, y1, _, _ = state_on_piece(pieces[piece], end)
                away += 0.125 * bend(pieces[piece]) * (end - begin) * (end - begin)
            left = min(x0, x1) - away
            right = max(x0, x1) + away
            low = min(y0, y1) - away
            high = max(y0, y1) + away
            first = min(int(begin / span), slots - 1)
            near = False
            for slot in range(first, min(int(end / span), slots - 1) + 1):
                if (
                    boxes[other, slot, 0] <= right
                    and boxes[other, slot, 2] >= left
                    and boxes[other, slot, 1] <= high
                    and boxes[other, slot, 3] >= low
                ):
                    near = True
                    break
            if not near:
                continue
            for theirs in range(firsts[other, first], sizes[other]):
                if tracks[other, theirs, 0] > end:
                    break
                if not pieces_apart(pieces, piece, tracks[other], theirs, distance):
                    apart = False
                    break
            if not apart:
                break
        if not apart:
            found += 1
            if found >= enough:
                break
    return found


@kernel
def _conflicts(
    tracks: NDArray[np.float64],
    sizes: NDArray[np.int64],
    firsts: NDArray[np.int64],
    boxes: NDArray[np.float64],
    bodies: NDArray[np.float64],
    span: float,
    robot: int,
    found: NDArray[np.bool_],
) -> None:
    heed = np.zeros(len(sizes), np.bool_)
    for other in range(len(sizes)):
        heed[other] = True
        found[other] = (
            hits(
                tracks, sizes, firsts, boxes, bodies, span, robot, heed, tracks[robot],
                sizes[robot], 1,
            )
            > 0
        )  # fmt: skip
        heed[other] = False
