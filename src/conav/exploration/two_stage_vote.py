"""The beginning of stage 1: candidates by social entropy, and the vote for a common direction."""

from collections.abc import Sequence
from dataclasses import dataclass

from conav.exploration.rectangle_drive import Rectangle, coordinates, extent
from conav.exploration.section_board import Board, Status
from conav.exploration.social_entropy import entropy_directions
from conav.exploration.two_stage_turn import STAY, Turn
from conav.exploration.types import Action

_UP_DOWN_LEFT_RIGHT = (1, 3, 2, 0)


@dataclass(frozen=True)
class Vote:
    """A robot's candidate for the auxiliary exploring direction."""

    direction: int  # 0 to 3

    @property
    def size_bytes(self) -> int:
        """A direction, 1 byte."""
        return 1


def candidate_among(turn: Turn, directions: Sequence[int]) -> int:
    """The direction among these after which the team's entropy is best."""
    settings = turn.settings
    best = entropy_directions(
        turn.view,
        directions,
        sense=settings.sense,
        measure=settings.measure,
        level=settings.cluster_m or turn.footprint_m,
        probe=settings.probe_m or turn.footprint_m,
    )
    return _untie(turn, best)


def _untie(turn: Turn, directions: Sequence[int]) -> int:
    if turn.settings.tie == "random" and len(directions) > 1:
        return directions[int(turn.rng.random() * len(directions))]
    if turn.settings.tie == "near":
        return min(directions, key=lambda k: _to_border(turn, k))  # the first of equal ones
    return directions[0]


def _to_border(turn: Turn, k: int) -> int:
    """Planning cells to the border of the area in that direction."""
    lattice = turn.view.lattice
    row, col = divmod(turn.view.cell, lattice.cols)
    return (lattice.cols - 1 - col, lattice.rows - 1 - row, col, row)[k]


def vote(turn: Turn) -> Action:
    """Stand still and vote, once."""
    memory = turn.memory
    if memory.candidate < 0:
        memory.candidate = candidate_among(turn, _UP_DOWN_LEFT_RIGHT)
        memory.votes[turn.view.robot] = memory.candidate
        turn.send(turn.others, Vote(memory.candidate))
        if set(memory.votes) >= set(turn.near):
            elect(turn)
    return STAY


def count_vote(turn: Turn, sender: int, body: Vote) -> None:
    """Note another robot's vote; choose as soon as everybody in reach has voted."""
    turn.memory.votes[sender] = body.direction
    if turn.memory.candidate >= 0 and set(turn.memory.votes) >= set(turn.near):
        elect(turn)


def elect(turn: Turn) -> None:
    """Count the votes and choose the auxiliary direction."""
    memory, view = turn.memory, turn.view
    upright = sum(direction in (1, 3) for direction in memory.votes.values())
    axis = 0 if upright > len(memory.votes) - upright else 1
    common = (1, 3) if axis == 0 else (2, 0)
    chosen = memory.candidate
    if chosen not in common:
        chosen = candidate_among(turn, common)
    _, size = extent(axis, view.lattice)
    board = memory.board = Board(axis, min(memory.votes), size)
    along, across = coordinates(axis, view.cell, view.lattice.cols)
    heading = 1 if chosen in (0, 1) else -1
    memory.rectangle = Rectangle(axis, heading, across, None, along)
    claim = board.enter(view.robot, turn.swath(), Status.BEING_SCANNED, view.step, heading=heading)
    turn.go("auxiliary direction chosen")
    turn.tell(claims=[claim])
    for news in memory.early:
        turn.hear_news(news, -1)
    memory.early = []
