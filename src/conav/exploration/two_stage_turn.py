"""A robot's turn in the two-stage strategy: its memory, its view, and what it says meanwhile."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from conav.exploration.nearest import NearestMemory
from conav.exploration.rectangle_drive import Path, Rectangle, half_footprint
from conav.exploration.section_auction import Auctioneer, Bidder, Interval
from conav.exploration.section_board import Board, Claim, News, Section
from conav.exploration.two_stage_flow import FLOW, Phase
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW
from conav.messages.message import Body, Message

if TYPE_CHECKING:
    from conav.exploration.two_stage import TwoStage

STAY = Action()

LOOK_EVERY = 8
"""Steps between two looks at whether a drive or a wait is still worth it."""


@dataclass
class TwoStageMemory:
    """Where the robot is in the flowchart, its copy of the board, and its parts in auctions."""

    phase: Phase = Phase.VOTE
    began: int = -1  # the last step it began
    action: Action = STAY
    candidate: int = -1
    votes: dict[int, int] = field(default_factory=dict[int, int])
    board: Board | None = None
    early: list[News] = field(default_factory=list[News])  # news from before it had a board
    contacts: frozenset[int] = frozenset()  # whom it heard in the last step
    places: tuple[int, ...] = ()  # where it last heard each robot
    stirred: list[int] = field(default_factory=list[int])  # the step each was first heard there
    rectangle: Rectangle | None = None
    looked_leg: int = -1
    path: Path = field(default_factory=Path)
    goal_lane: tuple[int, int, int] | None = None  # first lane, second, advance, of the approach
    piece: Interval = (0, -1)  # the part of the section the approach is to
    section: Interval = (0, -1)  # the section then
    bidder: Bidder = field(default_factory=Bidder)
    auctioneer: Auctioneer = field(default_factory=Auctioneer)
    announced_step: int = -1  # of its own last announcement
    offered: dict[Interval, int] = field(default_factory=dict[Interval, int])  # -> who has it
    rest: NearestMemory = field(default_factory=NearestMemory)
    rest_masked: bool = False  # the goal was chosen outside others' sections
    rest_at: int = -1  # the step it last looked for one
    tried: int = -1  # changes of the board when there was no section for it
    refused: int = 0  # illegal messages
    auctions: int = 0  # items it sold as an auctioneer
    rectangles: int = 0  # trajectories it closed


@dataclass
class Turn:
    """One call of the strategy: the settings, the memory, the view, and what is said."""

    settings: "TwoStage"
    memory: TwoStageMemory
    view: TeamView
    rng: np.random.Generator
    said: list[Message] = field(default_factory=list[Message])

    def __post_init__(self) -> None:
        view = self.view
        self.near: list[int] = np.flatnonzero(view.in_touch).tolist()
        self.others = [robot for robot in self.near if robot != view.robot]
        self.half = half_footprint(view.body.sensor.range_m, view.lattice)
        self.footprint_m = 2.0 * view.body.sensor.range_m

    @property
    def board(self) -> Board:
        """The robot's copy of the board; it has one from the vote on."""
        board = self.memory.board
        assert board is not None
        return board

    def go(self, event: str) -> None:
        """Change to the phase that follows the event."""
        self.memory.phase = FLOW[self.memory.phase, event]

    def watch(self) -> None:
        """Note who moved. The dead are not heard; one that stalled is, and gets nowhere."""
        memory, view = self.memory, self.view
        places = tuple(view.heard_cell.tolist())
        if places == memory.places:
            return
        if not memory.places:
            memory.stirred = [-1] * len(places)
        else:
            for robot, (before, now) in enumerate(zip(memory.places, places, strict=True)):
                if before != now:
                    memory.stirred[robot] = int(view.heard_step[robot])
        memory.places = places

    def move(self, k: int) -> Action:
        """The action of a move in a direction."""
        return Action(k, self.view.cell + DROW[k] * self.view.lattice.cols + DCOL[k])

    # --- what is said -----------------------------------------------------------------------------

    def send(self, robots: Sequence[int], body: Body) -> None:
        """Say something to some robots."""
        view = self.view
        self.said += [Message(view.robot, robot, view.time_s, body) for robot in robots]

    def greet(self) -> None:
        """Tell those not heard in the last step all of the board."""
        memory = self.memory
        new = [robot for robot in self.others if robot not in memory.contacts]
        memory.contacts = frozenset(self.others)
        if memory.board is not None and new:
            self.send(new, memory.board.news())

    def tell(self, scanned: Sequence[Interval] = (), claims: Sequence[Claim] = ()) -> None:
        """Tell everybody what changed on the board."""
        board = self.board
        self.send(self.others, News(board.axis, board.voted_by, tuple(scanned), tuple(claims)))

    def hear_news(self, news: News, sender: int) -> None:
        """Enter what another robot told of its board."""
        memory = self.memory
        if memory.board is None:
            memory.early.append(news)
            return
        axis = memory.board.axis
        if not memory.board.merge(news):
            return
        if memory.board.axis != axis:
            memory.rectangle, memory.goal_lane = None, None
            if memory.phase in (Phase.FIRST, Phase.APPROACH, Phase.SCAN):
                self.go("other common direction heard of")
        if self.view.body.radio.range_m is not None:
            # Others may not hear the sender.
            self.send([robot for robot in self.others if robot != sender], news)

    # --- what is on the board ---------------------------------------------------------------------

    def held(self) -> list[Claim]:
        """The sections that are somebody's who is heard of."""
        view = self.view
        limit = self.settings.silence_s * view.step / view.time_s if view.step else 0.0
        return self.board.held(self.board.silent(self.memory.stirred, view.step, limit, view.robot))

    def offer(self, robots: int) -> list[Section]:
        """The sections so many free robots may bid for."""
        width = (self.settings.task_width_m or self.footprint_m) / self.view.lattice.cell_m
        return self.board.offer(self.held(), robots, width, 2 * self.half + 1)

    def swath(self) -> Interval:
        """The strips the rectangle under way covers."""
        rectangle = self.memory.rectangle
        assert rectangle is not None
        second = rectangle.first if rectangle.second is None else rectangle.second
        lower = min(rectangle.first, second) - self.half
        upper = max(rectangle.first, second) + self.half
        return max(lower, 0), min(upper, self.board.size - 1)


def side(across: int, lower: int, upper: int) -> int:
    """The way a robot coming from there scans across a section: +1 upwards, -1 downwards."""
    return 1 if abs(across - lower) <= abs(across - upper) else -1
