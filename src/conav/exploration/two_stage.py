"""Two-stage coordinated strategy: rectangles shaped by social entropy, then sections by auction.

The strategy of [Dai2018]. What it says of obstacle-free worlds is followed; what it leaves open is
a setting, and what becomes of obstacles, which it leaves for later, is this module's own.

Rules of this file: every change of phase goes through `FLOW`, which is Figure 2 as a table.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

import numpy as np

from conav.exploration.belief import TARGET
from conav.exploration.nearest import NearestMemory, choose_nearest, keeps_goal
from conav.exploration.rectangle_drive import (
    CHOOSE,
    CLOSED,
    Path,
    Rectangle,
    coordinates,
    direction,
    extent,
    half_footprint,
    lanes,
    next_move,
    path_towards,
    rest_is_worth,
    unknown_within_known,
)
from conav.exploration.section_auction import (
    Announce,
    Auctioneer,
    Award,
    Bid,
    Bidder,
    Bidding,
    IllegalMessage,
    Interval,
    Join,
    Selling,
    best_bid,
)
from conav.exploration.section_board import Board, Claim, News, Section, Status
from conav.exploration.social_entropy import Measure, Sense, entropy_directions
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW
from conav.geometry.grid_search import path_to, search, search_space
from conav.messages.message import Body, Message

Tie = Literal["near", "order", "random"]
Closing = Literal["useful", "always"]

_UP_DOWN_LEFT_RIGHT = (1, 3, 2, 0)
_STAY = Action()
_LOOK_EVERY = 8  # steps between two looks at whether a drive or a wait is still worth it


class Phase(StrEnum):
    """Where a robot is in the flowchart."""

    VOTE = "vote"
    FIRST = "rectangle of stage 1"
    AUCTION = "auction"
    APPROACH = "way to a lane"
    SCAN = "rectangle in a section"
    REST = "nearest frontier"


FLOW: dict[tuple[Phase, str], Phase] = {
    (Phase.VOTE, "auxiliary direction chosen"): Phase.FIRST,
    (Phase.FIRST, "trajectory closed"): Phase.AUCTION,
    (Phase.FIRST, "no unknown area to explore"): Phase.AUCTION,
    (Phase.FIRST, "other common direction heard of"): Phase.AUCTION,
    (Phase.AUCTION, "section awarded"): Phase.APPROACH,
    (Phase.AUCTION, "no section left"): Phase.REST,
    (Phase.APPROACH, "arrived"): Phase.SCAN,
    (Phase.APPROACH, "width of the section is 0"): Phase.AUCTION,
    (Phase.APPROACH, "other common direction heard of"): Phase.AUCTION,
    (Phase.SCAN, "trajectory closed"): Phase.APPROACH,
    (Phase.SCAN, "other common direction heard of"): Phase.AUCTION,
    (Phase.REST, "section on offer"): Phase.AUCTION,
}
"""(phase, event) -> phase: Figure 2, with what we added for limited radios and for obstacles."""


def _side(across: int, lower: int, upper: int) -> int:
    """The way a robot coming from there scans across a section: +1 upwards, -1 downwards."""
    return 1 if abs(across - lower) <= abs(across - upper) else -1


def flow_table() -> str:
    """The strategy's transitions as a Markdown table, made from `FLOW`."""
    rows = ["| phase | event | next phase |", "|---|---|---|"]
    rows += [f"| {phase} | {event} | {then} |" for (phase, event), then in FLOW.items()]
    return "\n".join(rows)


@dataclass(frozen=True)
class Vote:
    """A robot's candidate for the auxiliary exploring direction."""

    direction: int  # 0 to 3

    @property
    def size_bytes(self) -> int:
        """A direction, 1 byte."""
        return 1


@dataclass
class TwoStageMemory:
    """Where the robot is in the flowchart, its copy of the board, and its parts in auctions."""

    phase: Phase = Phase.VOTE
    began: int = -1  # the last step it began
    action: Action = _STAY
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


@dataclass(frozen=True)
class TwoStage:
    """Stage 1: a rectangle along a direction the team votes on. Stage 2: sections by auction.

    Each robot starts with a rectangle whose directions are chosen by social entropy. Then it bids
    for the sections that are left, scans the one it gets with rectangles, and bids again. When no
    section is left, what obstacles hid is finished as `nearest` does.
    """

    sense: Sense = "minimise"
    """Whether directions minimise the team's social entropy, as in the paper, or maximise it."""
    measure: Measure = "hierarchic"
    """Hierarchic or simple social entropy."""
    cluster_m: float | None = None
    """Robots at most this far apart are one cluster of the simple measure [m]; None is 2 r."""
    probe_m: float | None = None
    """How far a robot imagines it has moved when it compares directions [m]; None is 2 r."""
    tie: Tie = "near"
    """Among directions with equal entropy: the nearest border, up-down-left-right, or at random."""
    task_width_m: float | None = None
    """d_0, the width of section a robot can scan in a task [m]; None is 2 r."""
    closing: Closing = "useful"
    """Drive rectangles to the end always, or only while that shows anything unknown."""
    auction_wait_s: float = 5.0
    """How long robots stand still in an auction period [s]."""
    silence_s: float = 120.0
    """A section awarded to a robot not heard, or not seen to move, for longer is free again [s]."""

    def __post_init__(self) -> None:
        for name in ("cluster_m", "probe_m", "task_width_m"):
            length: float | None = getattr(self, name)
            if length is not None and not 0.0 < length < float("inf"):
                raise ValueError(f"{name} is {length:g}; give a positive length in metres")
        for name in ("auction_wait_s", "silence_s"):
            time: float = getattr(self, name)
            if not 0.0 <= time < float("inf"):
                raise ValueError(f"{name} is {time:g}; give 0 or more seconds")

    def start(self, view: TeamView, rng: np.random.Generator) -> TwoStageMemory:
        return TwoStageMemory()

    def step(
        self,
        memory: TwoStageMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TwoStageMemory, Action, Sequence[Message]]:
        turn = _Turn(self, memory, view, rng)
        turn.take(inbox)
        return memory, memory.action, turn.said


@dataclass
class _Turn:
    """One call of `TwoStage.step`: the settings, the memory, the view, and what is said."""

    settings: TwoStage
    memory: TwoStageMemory
    view: TeamView
    rng: np.random.Generator
    said: list[Message] = field(default_factory=list[Message])

    def __post_init__(self) -> None:
        view = self.view
        self.near = np.flatnonzero(view.in_touch).tolist()
        self.others = [robot for robot in self.near if robot != view.robot]
        self.half = half_footprint(view.body.sensor.range_m, view.lattice)
        self.footprint_m = 2.0 * view.body.sensor.range_m

    def take(self, inbox: Sequence[Message]) -> None:
        """Read the messages, then decide; once a step, and again when something was decided."""
        memory = self.memory
        begins = memory.began < self.view.step
        memory.began = self.view.step
        if begins:
            self._watch()
            self._greet()
            if memory.phase is Phase.VOTE and memory.candidate >= 0:
                self._elect()  # with the votes that arrived
        before = memory.phase
        for message in inbox:
            try:
                self._read(message)
            except IllegalMessage:
                memory.refused += 1
        self._run_auction()
        if begins or memory.phase is not before:
            memory.action = self._decide()
            self._run_auction()  # it may have joined its own
            if memory.phase is Phase.APPROACH and memory.action == _STAY:
                memory.action = self._decide()

    def _watch(self) -> None:
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

    # --- what is said -----------------------------------------------------------------------------

    def _send(self, robots: Sequence[int], body: Body) -> None:
        view = self.view
        self.said += [Message(view.robot, robot, view.time_s, body) for robot in robots]

    def _greet(self) -> None:
        """Tell those not heard in the last step all of the board."""
        memory = self.memory
        new = [robot for robot in self.others if robot not in memory.contacts]
        memory.contacts = frozenset(self.others)
        if memory.board is not None and new:
            self._send(new, memory.board.news())

    def _tell(self, scanned: Sequence[Interval] = (), claims: Sequence[Claim] = ()) -> None:
        """Tell everybody what changed on the board."""
        board = self.board
        self._send(self.others, News(board.axis, board.voted_by, tuple(scanned), tuple(claims)))

    @property
    def board(self) -> Board:
        board = self.memory.board
        assert board is not None
        return board

    def _read(self, message: Message) -> None:
        memory, body, sender = self.memory, message.body, message.sender
        if isinstance(body, Vote):
            if memory.phase is Phase.VOTE:
                memory.votes[sender] = body.direction
                if memory.candidate >= 0 and set(memory.votes) >= set(self.near):
                    self._elect()
        elif isinstance(body, News):
            self._hear_news(body, sender)
        elif isinstance(body, Join):
            memory.auctioneer.join(sender, self.view.time_s)
        elif isinstance(body, Bid):
            memory.auctioneer.bid(sender, body)
        elif isinstance(body, Announce):
            bid = self._bid(body.sections)  # before anything changes: none may be on offer
            memory.bidder.announced(sender, self.view.step)
            self._send([sender], bid)
        elif isinstance(body, Award):
            memory.bidder.awarded(sender, self.view.step)
            self._awarded(body.section)

    def _hear_news(self, news: News, sender: int) -> None:
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
                self._go("other common direction heard of")
        if self.view.body.radio.range_m is not None:
            # Others may not hear the sender.
            self._send([robot for robot in self.others if robot != sender], news)

    def _go(self, event: str) -> None:
        self.memory.phase = FLOW[self.memory.phase, event]

    # --- stage 1 ----------------------------------------------------------------------------------

    def _candidate(self, directions: Sequence[int]) -> int:
        """The direction among these after which the team's entropy is best."""
        settings = self.settings
        best = entropy_directions(
            self.view,
            directions,
            sense=settings.sense,
            measure=settings.measure,
            level=settings.cluster_m or self.footprint_m,
            probe=settings.probe_m or self.footprint_m,
        )
        return self._untie(best)

    def _untie(self, directions: Sequence[int]) -> int:
        if self.settings.tie == "random" and len(directions) > 1:
            return directions[int(self.rng.random() * len(directions))]
        if self.settings.tie == "near":
            return min(directions, key=self._to_border)  # the first of equal ones
        return directions[0]

    def _to_border(self, k: int) -> int:
        """Planning cells to the border of the area in that direction."""
        lattice = self.view.lattice
        row, col = divmod(self.view.cell, lattice.cols)
        return (lattice.cols - 1 - col, lattice.rows - 1 - row, col, row)[k]

    def _vote(self) -> Action:
        memory = self.memory
        if memory.candidate < 0:
            memory.candidate = self._candidate(_UP_DOWN_LEFT_RIGHT)
            memory.votes[self.view.robot] = memory.candidate
            self._send(self.others, Vote(memory.candidate))
            if set(memory.votes) >= set(self.near):
                self._elect()
        return _STAY

    def _elect(self) -> None:
        """Count the votes and choose the auxiliary direction."""
        memory, view = self.memory, self.view
        upright = sum(vote in (1, 3) for vote in memory.votes.values())
        axis = 0 if upright > len(memory.votes) - upright else 1
        common = (1, 3) if axis == 0 else (2, 0)
        chosen = memory.candidate
        if chosen not in common:
            chosen = self._candidate(common)
        _, size = extent(axis, view.lattice)
        board = memory.board = Board(axis, min(memory.votes), size)
        along, across = coordinates(axis, view.cell, view.lattice.cols)
        heading = 1 if chosen in (0, 1) else -1
        memory.rectangle = Rectangle(axis, heading, across, None, along)
        claim = board.enter(
            view.robot, self._swath(), Status.BEING_SCANNED, view.step, heading=heading
        )
        self._go("auxiliary direction chosen")
        self._tell(claims=[claim])
        for news in memory.early:
            self._hear_news(news, -1)
        memory.early = []

    def _swath(self) -> Interval:
        """The strips the rectangle under way covers."""
        rectangle = self.memory.rectangle
        assert rectangle is not None
        second = rectangle.first if rectangle.second is None else rectangle.second
        lower = min(rectangle.first, second) - self.half
        upper = max(rectangle.first, second) + self.half
        return max(lower, 0), min(upper, self.board.size - 1)

    def _explores_for(self) -> bool:
        """Whether the first lane is not a lower robot's as well."""
        me = self.board.claims[self.view.robot]
        return not any(
            claim.robot < me.robot
            and claim.heading == me.heading
            and abs(claim.lower + claim.upper - me.lower - me.upper) <= 2 * self.half
            for claim in self._held()
        )

    def _choose_second(self, rectangle: Rectangle) -> None:
        """At the border: the temporary direction by entropy, among sides with unknown area."""
        board, view = self.board, self.view
        taken = [claim for claim in self._held() if claim.robot != view.robot]
        sides = {
            direction(rectangle.axis, 0, side): lane
            for side, lane in board.lanes_beside(rectangle.first, self.half, taken).items()
        }
        possible = [k for k in sides if view.belief.moves.item(view.cell) >> k & 1]
        if not possible:
            rectangle.second = rectangle.first
            return
        rectangle.second = sides[self._candidate(possible)]
        me = board.claims[view.robot]
        claim = board.enter(
            view.robot, self._swath(), Status.BEING_SCANNED, view.step, heading=me.heading
        )
        self._tell(claims=[claim])

    def _first(self) -> Action | None:
        memory, board, view = self.memory, self.board, self.view
        rectangle = memory.rectangle
        assert rectangle is not None
        if rectangle.leg == 0 and not self._explores_for():
            memory.rectangle = None
            self._tell(claims=[board.release(view.robot, view.step)])
            self._go("no unknown area to explore")
            return None
        action = self._drive(rectangle)
        if action is None:
            scanned = board.scan(*self._swath())
            memory.rectangle = None
            self._tell([scanned], [board.release(view.robot, view.step)])
            self._go("trajectory closed")
        return action

    def _drive(self, rectangle: Rectangle) -> Action | None:
        """The next move of the rectangle, None when it is closed."""
        memory, view = self.memory, self.view
        wanted = next_move(rectangle, view)
        if wanted == CHOOSE:
            self._choose_second(rectangle)
            wanted = next_move(rectangle, view)
        look = rectangle.leg != memory.looked_leg or view.step % _LOOK_EVERY == 0
        memory.looked_leg = rectangle.leg
        if wanted == CLOSED or (
            look and self.settings.closing == "useful" and not rest_is_worth(rectangle, view)
        ):
            memory.rectangles += 1
            return None
        return Action(wanted, self._next_cell(wanted))

    def _next_cell(self, k: int) -> int:
        return self.view.cell + DROW[k] * self.view.lattice.cols + DCOL[k]

    # --- stage 2: the auction ---------------------------------------------------------------------

    def _held(self) -> list[Claim]:
        """The sections that are somebody's who is heard of."""
        view = self.view
        limit = self.settings.silence_s * view.step / view.time_s if view.step else 0.0
        return self.board.held(self.board.silent(self.memory.stirred, view.step, limit, view.robot))

    def _offer(self, robots: int) -> list[Section]:
        width = (self.settings.task_width_m or self.footprint_m) / self.view.lattice.cell_m
        return self.board.offer(self._held(), robots, width, 2 * self.half + 1)

    def _bid(self, sections: Sequence[Interval]) -> Bid:
        _, across = coordinates(self.board.axis, self.view.cell, self.view.lattice.cols)
        widths = [self.board.width(*section) for section in sections]
        bid = best_bid(sections, widths, across)
        if bid is None:
            raise IllegalMessage("nothing is on offer")
        return bid

    def _auction(self) -> Action:
        """Stand still until the auction is over."""
        memory, view = self.memory, self.view
        bidder = memory.bidder
        if bidder.state is not Bidding.IDLE:
            waited_s = (view.step - bidder.since_step) * view.time_s / max(view.step, 1)
            if view.step - bidder.since_step > 3 and waited_s > 2 * self.settings.auction_wait_s:
                bidder.leave()
        if bidder.state is Bidding.IDLE:
            leader = min(self.near)
            join = bidder.join(leader, view.step)
            if leader == view.robot:
                try:
                    memory.auctioneer.join(leader, view.time_s)
                except IllegalMessage:
                    memory.refused += 1
            else:
                self._send([leader], join)
        return _STAY

    def _run_auction(self) -> None:
        """As an auctioneer: sell when the period is over and when the bids are there."""
        memory, view = self.memory, self.view
        auctioneer = memory.auctioneer
        if memory.board is None:
            return
        if (
            auctioneer.state is Selling.OPEN
            and view.time_s >= auctioneer.opened_s + self.settings.auction_wait_s - 1e-9
        ):
            self._announce()
        late = auctioneer.state is Selling.SELLING and memory.announced_step < view.step
        while auctioneer.complete() or (late and auctioneer.state is Selling.SELLING):
            late = False
            if auctioneer.bids:
                self._award()
                self._announce()
            else:
                auctioneer.close(view.time_s)

    def _announce(self) -> None:
        memory, view = self.memory, self.view
        auctioneer = memory.auctioneer
        sections = self._offer(len(auctioneer.bidders)) if auctioneer.bidders else []
        memory.offered = {(item.lower, item.upper): item.robot for item in sections}
        announce = auctioneer.announce(list(memory.offered))
        memory.announced_step = view.step
        if not announce.sections:
            for robot in auctioneer.close(view.time_s):
                self._give(robot, None)
            return
        self._send([robot for robot in auctioneer.bidders if robot != view.robot], announce)
        if view.robot in auctioneer.bidders:
            memory.bidder.announced(view.robot, view.step)
            auctioneer.bid(view.robot, self._bid(announce.sections))

    def _award(self) -> None:
        memory, board, view = self.memory, self.board, self.view
        winner, section = memory.auctioneer.sell()
        memory.auctions += 1
        _, across = coordinates(board.axis, int(view.heard_cell[winner]), view.lattice.cols)
        claims = [
            board.enter(
                winner, section, Status.TO_BE_SCANNED, view.step, advance=_side(across, *section)
            )
        ]
        holder = memory.offered[section]
        if holder >= 0:
            # The one who had it keeps the other half.
            old = board.claims[holder]
            keeps = (
                (old.lower, section[0] - 1)
                if old.upper == section[1] or old.lower < section[0]
                else (section[1] + 1, old.upper)
            )
            claims.append(
                board.enter(
                    holder, keeps, old.status, view.step,
                    advance=old.advance, begun=old.begun,
                )
            )  # fmt: skip
        self._tell(claims=claims)
        self._give(winner, section)

    def _give(self, robot: int, section: Interval | None) -> None:
        if robot != self.view.robot:
            self._send([robot], Award(section))
        elif self.memory.bidder.state is not Bidding.IDLE:
            self.memory.bidder.awarded(robot, self.view.step)
            self._awarded(section)

    def _awarded(self, section: Interval | None) -> None:
        memory = self.memory
        if memory.phase is not Phase.AUCTION:
            return
        claim = self.board.claims.get(self.view.robot)
        if section is None or claim is None or (claim.lower, claim.upper) != section:
            memory.tried = self.board.changes
            memory.rest, memory.rest_at = NearestMemory(), -1
            self._go("no section left")
        else:
            memory.goal_lane = None
            self._go("section awarded")

    # --- stage 2: in a section --------------------------------------------------------------------

    def _approach(self) -> Action | None:
        memory, board, view = self.memory, self.board, self.view
        axis = board.axis
        _, across = coordinates(axis, view.cell, view.lattice.cols)
        claim = board.claims[view.robot]
        if (claim.lower, claim.upper) != memory.section:
            memory.goal_lane = None  # a part of it is somebody else's now
            memory.section = (claim.lower, claim.upper)
        while memory.goal_lane is None:
            pieces = board.unscanned(claim.lower, claim.upper)
            if not pieces:
                self._tell(claims=[board.release(view.robot, view.step)])
                self._go("width of the section is 0")
                return None
            lower, upper = min(
                pieces, key=lambda piece: min(abs(across - piece[0]), abs(across - piece[1]))
            )
            advance = _side(across, lower, upper)
            first, second = (
                min(max(lane, 0), board.size - 1)
                for lane in lanes(lower, upper, advance, self.half)
            )
            swath = min(first, second) - self.half, max(first, second) + self.half
            covers = max(swath[0], lower), min(swath[1], upper)
            if unknown_within_known(axis, *covers, view) == 0:
                self._tell([board.scan(*covers)])
                continue
            memory.goal_lane, memory.piece, memory.path = (first, second, advance), covers, Path()
        first, second, advance = memory.goal_lane
        wanted = memory.path.next(view)
        if wanted < 0 and across != first:
            path = path_towards(axis, first, view)
            if path is not None:
                memory.path = path
                wanted = path.next(view)
            elif memory.piece[0] <= across <= memory.piece[1]:
                # An obstacle keeps it from the lane, not from the section.
                second = second if (second - across) * advance > 0 else across
                first = across
            else:
                # No rectangle can be driven here: left to the end.
                self._tell([board.scan(*memory.piece)])
                memory.goal_lane = None
                return None
        if wanted >= 0 and across != first:
            return Action(wanted, self._next_cell(wanted))
        self._arrive(first, second, advance)
        return None

    def _arrive(self, first: int, second: int, advance: int) -> None:
        memory, board, view = self.memory, self.board, self.view
        axis = board.axis
        along, _ = coordinates(axis, view.cell, view.lattice.cols)
        size, _ = extent(axis, view.lattice)
        # A lane driven to and fro is shorter by way of the nearer border.
        heading = 1 if size - 1 - along < along else -1
        memory.rectangle = Rectangle(axis, heading, first, second, along)
        memory.goal_lane = None
        claim = board.claims[view.robot]
        self._tell(
            claims=[
                board.enter(
                    view.robot, (claim.lower, claim.upper), Status.BEING_SCANNED, view.step,
                    advance=advance, begun=1,
                )
            ]
        )  # fmt: skip
        self._go("arrived")

    def _scan(self) -> Action | None:
        memory, board, view = self.memory, self.board, self.view
        rectangle = memory.rectangle
        assert rectangle is not None
        claim = board.claims[view.robot]
        if claim.begun < 2 and not claim.lower <= (rectangle.second or 0) <= claim.upper:
            rectangle.second = rectangle.first  # somebody else was given the second lane
        action = self._drive(rectangle)
        if action is None:
            scanned = board.scan(*self._swath())
            memory.rectangle = None
            self._tell([scanned])
            self._go("trajectory closed")
        elif rectangle.leg > 0 and claim.begun < 2:
            section = claim.lower, claim.upper
            claim = board.enter(
                view.robot, section, claim.status, view.step, advance=claim.advance, begun=2
            )
            self._tell(claims=[claim])
        return action

    # --- what is left -----------------------------------------------------------------------------

    def _rest(self) -> Action | None:
        memory, board, view = self.memory, self.board, self.view
        if board.changes != memory.tried:
            memory.tried = board.changes
            if self._offer(1):
                self._go("section on offer")
                return None
        rest = memory.rest
        taken = [claim for claim in self._held() if claim.robot != view.robot]
        if bool(taken) != memory.rest_masked:
            memory.rest_masked = bool(taken)
            memory.rest = rest = NearestMemory()
        if not taken:
            if not keeps_goal(rest, view):
                choose_nearest(rest, view)
        elif rest.goal < 0 or not keeps_goal(rest, view):
            if rest.goal < 0 and view.step - memory.rest_at < _LOOK_EVERY:
                return _STAY
            memory.rest_at = view.step
            self._choose_outside(rest, taken)
            if rest.goal < 0:
                return _STAY
        if rest.goal < 0:
            return Action(finished=True)
        return Action(int(rest.path[rest.left - 1]), rest.goal)

    def _choose_outside(self, rest: NearestMemory, taken: Sequence[Claim]) -> None:
        """Set the nearest frontier that is in nobody's section, or none."""
        view = self.view
        wanted = np.asarray(view.belief.marks & TARGET, dtype=np.uint8)
        strips = wanted if self.board.axis == 1 else wanted.T
        for claim in taken:
            strips[claim.lower : claim.upper + 1] = 0
        space = search_space(wanted.size)
        rest.goal = search(view.belief.moves, view.cell, wanted, TARGET, space)
        rest.looks_for, rest.beside = -1, False
        if rest.goal >= 0:
            rest.here = view.cell
            rest.path, rest.left = path_to(space, view.lattice.cols, rest.goal)

    def _decide(self) -> Action:
        """The action of the phase the robot is in, or of those it passes through now."""
        phases = {
            Phase.VOTE: self._vote,
            Phase.FIRST: self._first,
            Phase.AUCTION: self._auction,
            Phase.APPROACH: self._approach,
            Phase.SCAN: self._scan,
            Phase.REST: self._rest,
        }
        while True:
            before = self.memory.phase
            action = phases[before]()
            if action is not None and (self.memory.phase is before or before is Phase.AUCTION):
                return action
