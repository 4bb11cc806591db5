"""The rendezvous game of [Lindsay2011]: robots that drive a step at a time want to meet.

Robots are at points (x, y) of a bounded grid and face a heading 0 to 3: E, N, W, S, the order of
`conav.geometry.directions`. They never wait. Under the simple forward turn a robot goes forward, or
it turns where it is in one step and goes forward in the next; so an action is one of four two-step
sequences: forward twice, or turn by +90, 180 or -90 degrees and then forward ([Philip2014],
equation (2)). Robots do not hinder each other.

The text of [Lindsay2011] is not at hand; what is said of it in [Philip2014], section 2.1, leaves
the border open. Here a robot one step from the border it faces goes forward once and counts as
staying there; a sequence whose first move forward would leave the grid is no action.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

from conav.compiled import kernel
from conav.games.game import Game, Profile
from conav.geometry.directions import DCOL, DROW

TIE = 1e-9
"""Utilities [cells] that differ by no more are equal: sums of equal roots may round differently."""


class TwoStep(NamedTuple):
    """A two-step sequence and where it ends."""

    turn: int  # quarter turns to the left: 0 forward twice, 1 is +90, 2 is 180, 3 is -90 degrees
    x: int
    y: int


@kernel
def reach(x: int, y: int, heading: int, turn: int, width: int, height: int) -> tuple[int, int]:
    """Where a two-step sequence ends: (x, y) itself when the border forbids its move forward."""
    towards = (heading + turn) % 4
    length = 2 if turn == 0 else 1
    return (
        min(max(x + length * DCOL[towards], 0), width - 1),
        min(max(y + length * DROW[towards], 0), height - 1),
    )


def sequences(x: int, y: int, heading: int, width: int, height: int) -> tuple[TwoStep, ...]:
    """The sequences a robot has at this point: forward first if possible, then by turn."""
    ends = ((turn, *reach.python(x, y, heading, turn, width, height)) for turn in range(4))
    return tuple(TwoStep(*end) for end in ends if end[1:] != (x, y))


def rendezvous_game(
    positions: Sequence[tuple[int, int]], headings: Sequence[int], width: int, height: int
) -> Game:
    """The game of one decision: action a of robot i is its `sequences(...)[a]`.

    A robot's utility is minus the sum of its distances [cells] to the others after the two steps,
    whatever they choose. It is an exact potential game with `rendezvous_potential`; compare its
    utilities with tolerance `TIE`. Raises `ValueError` when a robot is off the grid or the grid has
    a single point.
    """
    ends = _ends(positions, headings, width, height)

    def utility(player: int, profile: Profile) -> float:
        x, y = ends[player][profile[player]][1:]
        total = 0.0
        for other, action in enumerate(profile):
            at = ends[other][action]
            total += sqrt((x - at.x) ** 2 + (y - at.y) ** 2)
        return -total

    return Game(tuple(len(own) for own in ends), utility)


def rendezvous_potential(
    positions: Sequence[tuple[int, int]],
    headings: Sequence[int],
    width: int,
    height: int,
    profile: Profile,
) -> float:
    """Minus the sum over all pairs of robots of their distance [cells] after the two steps."""
    ends = _ends(positions, headings, width, height)
    at = [own[action] for own, action in zip(ends, profile, strict=True)]
    total = 0.0
    for i, one in enumerate(at):
        for other in at[:i]:
            total += sqrt((one.x - other.x) ** 2 + (one.y - other.y) ** 2)
    return -total


def _ends(
    positions: Sequence[tuple[int, int]], headings: Sequence[int], width: int, height: int
) -> list[tuple[TwoStep, ...]]:
    check_grid(width, height)
    if len(positions) != len(headings):
        raise ValueError(f"{len(positions)} positions and {len(headings)} headings")
    for (x, y), heading in zip(positions, headings, strict=True):
        if not (0 <= x < width and 0 <= y < height):
            raise ValueError(f"({x}, {y}) is not on the grid of {width} x {height} points")
        if not 0 <= heading < 4:
            raise ValueError(f"heading {heading} is none of 0 to 3")
    return [
        sequences(x, y, heading, width, height)
        for (x, y), heading in zip(positions, headings, strict=True)
    ]


def check_grid(width: int, height: int) -> None:
    """Nothing; raises `ValueError` when the grid has fewer than two points."""
    if width < 1 or height < 1 or width * height < 2:
        raise ValueError(f"a grid of {width} x {height} points leaves no room to move")
