"""Exploration by repeated auctions: Nanjanath and Gini (RAS 2010).

Rules of this file:
- Whatever changes a robot's state in the protocol is a row of `BIDDER` or `AUCTIONEER` in
  `auction_protocol`. A message that has no row, or does not belong to the auction at hand, changes
  nothing.
- An auction is over within a step: task ended -> call -> bids -> awards, four message rounds at
  most. A step that begins finds every robot at the head of its table. Where messages take time each
  round takes that; a robot goes back to the head when what it waits for is overdue.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from conav.exploration.auction_protocol import (
    AUCTIONEER,
    BIDDER,
    NO_CALL,
    Auctioneer,
    Award,
    Bidder,
    Bids,
    Call,
    Ended,
)
from conav.exploration.frontier_targets import find_pieces, paths_to, paths_to_targets
from conav.exploration.nearest import NearestMemory, by_field, choose_nearest, keeps_goal
from conav.exploration.sequential_auction import TaskPaths, sequential_auctions
from conav.exploration.standstill import Standstill
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import STAY
from conav.geometry.distance_field import shortest_path
from conav.messages.message import Message


def task_cells(
    cells: NDArray[np.int64],
    piece: NDArray[np.int64],
    n_pieces: int,
    nearest: NDArray[np.float64],
) -> NDArray[np.int64]:
    """The tasks: of every piece of frontier the cell nearest to any robot, in the pieces' order.

    `cells`, `piece` and `n_pieces` are those of `find_pieces`; `nearest` (n_cells,) is the path
    length from the nearest robot. Ties go to the lower cell; a piece nobody can reach is no task.
    """
    order = np.lexsort((cells, nearest, piece))
    order = order[np.searchsorted(piece[order], np.arange(n_pieces))]
    return cells[order[np.isfinite(nearest[order])]]


@dataclass
class AuctionMemory:
    """What a robot has to do, and where it stands in the protocol."""

    drive: NearestMemory = field(default_factory=NearestMemory)
    tasks: tuple[int, ...] = ()  # won and not completed; it drives to the first
    idle: bool = False  # others won all it could do; waits for the next auction
    company: tuple[int, ...] = ()  # whom it heard when it became idle
    until_s: float = 0.0  # [s] stands still until then
    asked: tuple[int, int] = (-1, STAY)  # planning cell and direction of the last move it wanted
    under_way: tuple[int, int] = (-1, STAY)  # the same of one that it began and has not finished
    stands: Standstill = field(default_factory=Standstill)
    stuck: bool = False  # cannot drive; bids for nothing
    began: int = -1  # the last step it began
    bidder: Bidder = Bidder.AT_WORK
    answered: Call = NO_CALL  # the call it bid on last, or its own
    costs: tuple[float, ...] = ()  # its own to the tasks of that
    auctioneer: Auctioneer = Auctioneer.READY
    call: Call = NO_CALL  # the call it made last
    auctions: int = 0  # how many it held


@dataclass(frozen=True)
class RepeatedAuction:
    """Frontier targets are auctioned to the robots, and again whenever a task has ended.

    A task is a cell of a piece of frontier. Tasks are sold one by one in first-price reverse
    auctions; a bid is the path cost from the end of what a robot has won already. A robot carries
    out the first task it won. When any task is completed, delayed (the robot was pushed off its
    path) or failed (it has not got on for long), all tasks not yet completed are put up for bids
    again.
    """

    auction_wait_s: float = 0.0
    """How long the robots of an auction stand still for it [s]; 0 or more. Who is on its way from
    one cell to the next gets there first."""
    give_up_s: float = 60.0
    """A task has failed when its robot has not got on for this long [s]; until it moves again it
    wins nothing."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.auction_wait_s < inf:
            raise ValueError(f"auction_wait_s is {self.auction_wait_s:g}; give 0 or more")
        if not 0.0 < self.give_up_s < inf:
            raise ValueError(f"give_up_s is {self.give_up_s:g}; give more than 0")

    def start(self, view: TeamView, rng: np.random.Generator) -> AuctionMemory:
        return AuctionMemory()

    def step(
        self,
        memory: AuctionMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[AuctionMemory, Action, Sequence[Message]]:
        said: list[Message] = []
        if memory.began < view.step:
            memory.began = view.step
            memory.under_way = memory.asked
            _reset(memory, view)
            failed = self._fails(memory, view)
            if not _waits(memory, view) and (failed or _task_ended(memory, view)):
                said += _ask(memory, view)
        for message in inbox:
            body = message.body
            if isinstance(body, Ended):
                said += _open(memory, view)
            elif isinstance(body, Call):
                said += _bid(memory, view, message.sender, body)
            elif isinstance(body, Award) and _takes(memory, view, message.sender, body):
                self._begin(memory, view, body.tasks)
        said += self._close(memory, view, inbox)
        return memory, _action(memory, view), said

    def _fails(self, memory: AuctionMemory, view: TeamView) -> bool:
        """Whether the robot finds now that it cannot get on with its task."""
        drives = not memory.idle and memory.drive.goal >= 0 and not _waits(memory, view)
        was_stuck = memory.stuck
        memory.stuck = memory.stands.time_s(view, drives) >= self.give_up_s
        return memory.stuck and not was_stuck

    def _close(
        self, memory: AuctionMemory, view: TeamView, inbox: Sequence[Message]
    ) -> list[Message]:
        """The awards, if bids came in; begins with its own."""
        offers = {
            message.sender: message.body.costs
            for message in inbox
            if isinstance(message.body, Bids) and _fits(message.body, memory.call)
        }
        following = AUCTIONEER.get((memory.auctioneer, Bids))
        if following is None or not offers:
            return []
        memory.auctioneer = following
        mine = _lowest_heard(view) == view.robot
        if mine:
            if view.delay_steps:
                _set_costs(memory, view, memory.call)  # it has moved since
            offers[view.robot] = memory.costs
        bidders = sorted(offers)
        lists = _sell(memory.call.tasks, [offers[robot] for robot in bidders], view)
        memory.auctions += 1
        if mine:
            self._begin(memory, view, lists[bidders.index(view.robot)])
        return [
            Message(view.robot, robot, view.time_s, Award(memory.call.auction, tasks))
            for robot, tasks in zip(bidders, lists, strict=True)
            if robot != view.robot
        ]

    def _begin(self, memory: AuctionMemory, view: TeamView, tasks: tuple[int, ...]) -> None:
        """Begin with what was won in an auction with others."""
        memory.until_s = view.time_s + self.auction_wait_s
        _begin(memory, view, tasks)


def _reset(memory: AuctionMemory, view: TeamView) -> None:
    """Back to the head of the tables, unless an answer may still come."""
    delay = view.delay_steps
    awaits_award = (
        memory.bidder is Bidder.BIDDING and view.step <= memory.answered.auction + 3 * delay
    )
    if not (delay and awaits_award):
        memory.bidder = Bidder.AT_WORK
    awaits_bids = (
        memory.auctioneer is Auctioneer.OPEN and view.step <= memory.call.auction + 2 * delay
    )
    if not (delay and awaits_bids):
        memory.auctioneer = Auctioneer.READY


def _task_ended(memory: AuctionMemory, view: TeamView) -> bool:
    """Whether a robot has nothing to go on with as far as it can see."""
    if memory.idle:
        # Those who have the tasks will call, unless they are lost or the tasks are gone.
        return memory.company != _heard(view) or not _any_target(view)
    return not keeps_goal(memory.drive, view)


def _ask(memory: AuctionMemory, view: TeamView) -> list[Message]:
    """What a robot says whose task has ended."""
    memory.tasks = ()
    memory.idle = False
    # Until it is told it goes where it would go alone; without targets that is all there is to do.
    choose_nearest(memory.drive, view, by_field)
    if not _any_target(view):
        return []
    auctioneer = _lowest_heard(view)
    if auctioneer == view.robot:
        return _open(memory, view)
    following = BIDDER.get((memory.bidder, Ended))
    if following is None:  # an award is under way
        return []
    memory.bidder = following
    return [Message(view.robot, auctioneer, view.time_s, Ended())]


def _open(memory: AuctionMemory, view: TeamView) -> list[Message]:
    """The call for bids to all it hears, if it may open an auction; alone, it takes all tasks."""
    following = AUCTIONEER.get((memory.auctioneer, Ended))
    if following is None or not _any_target(view):
        return []
    memory.auctioneer = following
    heard = _heard(view)
    cells, piece, n_pieces = find_pieces(view)
    nearest = paths_to_targets(view.belief).costs(view.heard_cell[list(heard)]).min(axis=0)
    tasks = tuple(task_cells(cells, piece, n_pieces, nearest).tolist())
    memory.call = Call(view.step, tasks)
    if _lowest_heard(view) == view.robot:
        _set_costs(memory, view, memory.call)
    others = [robot for robot in heard if robot != view.robot]
    if not others:
        memory.auctioneer = AUCTIONEER[memory.auctioneer, Bids]
        memory.auctions += 1
        _begin(memory, view, _sell(tasks, [memory.costs], view)[0])
    return [Message(view.robot, other, view.time_s, memory.call) for other in others]


def _bid(memory: AuctionMemory, view: TeamView, sender: int, call: Call) -> list[Message]:
    """The answer to a call by its auctioneer for an auction that began when it was sent."""
    following = BIDDER.get((memory.bidder, Call))
    size = view.lattice.rows * view.lattice.cols
    legal = (
        sender == _lowest_heard(view) != view.robot and call.auction == view.step - view.delay_steps
    )
    if following is None or not legal or not all(0 <= task < size for task in call.tasks):
        return []
    memory.bidder = following
    _set_costs(memory, view, call)
    return [Message(view.robot, sender, view.time_s, Bids(call.auction, memory.costs))]


def _set_costs(memory: AuctionMemory, view: TeamView, call: Call) -> None:
    memory.answered = call
    if memory.stuck:
        memory.costs = (inf,) * len(call.tasks)
        return
    paths, which = paths_to(view.belief, call.tasks)
    memory.costs = tuple(paths.costs_from(view.cell)[which].tolist())


def _takes(memory: AuctionMemory, view: TeamView, sender: int, award: Award) -> bool:
    """Whether an award answers this robot's bids; takes note of it."""
    following = BIDDER.get((memory.bidder, Award))
    legal = sender == _lowest_heard(view) and award.auction == memory.answered.auction
    if following is None or not legal or not set(award.tasks) <= set(memory.answered.tasks):
        return False
    memory.bidder = following
    return True


def _fits(bids: Bids, call: Call) -> bool:
    """Whether these are costs for the tasks of a call."""
    return (
        bids.auction == call.auction
        and len(bids.costs) == len(call.tasks)
        and all(cost >= 0 for cost in bids.costs)
    )


def _sell(
    tasks: tuple[int, ...], offers: Sequence[tuple[float, ...]], view: TeamView
) -> list[tuple[int, ...]]:
    """What each bidder wins, in the order of the awards.

    Costs between tasks are worked out by the auctioneer, in the map it shares with the bidders.
    """
    paths = TaskPaths(view.belief, tasks)
    won: list[list[int]] = [[] for _ in offers]
    for task, bidder in sequential_auctions(np.array(offers), paths.between, paths.least):
        won[bidder].append(tasks[task])
    return [tuple(own) for own in won]


def _begin(memory: AuctionMemory, view: TeamView, tasks: tuple[int, ...]) -> None:
    """Drive to the first task; without one wait, or look for the last pockets as `nearest` does."""
    drive = memory.drive
    memory.tasks = tasks
    memory.idle = not tasks and any(isfinite(cost) for cost in memory.costs)
    if memory.idle:
        memory.company = _heard(view)
        drive.goal = -1
    elif not tasks:
        if not keeps_goal(drive, view):
            choose_nearest(drive, view)
    elif tasks[0] != drive.goal or not keeps_goal(drive, view):
        path, left = shortest_path(view.belief.ground, view.cell, tasks[0])
        if left > 0:
            drive.goal, drive.looks_for, drive.beside = tasks[0], -1, False
            drive.here = view.cell
            drive.path, drive.left = path, left
        else:  # a task it did not bid for in earnest
            choose_nearest(drive, view)


def _action(memory: AuctionMemory, view: TeamView) -> Action:
    drive = memory.drive
    memory.asked = (-1, STAY)
    if memory.idle:
        return Action(STAY, drive.goal)
    waits = _waits(memory, view)
    if drive.goal < 0:
        return Action(STAY) if waits else Action(finished=True)
    move = (view.cell, int(drive.path[drive.left - 1]))
    # A diagonal takes longer than a step. Halted on the way it would have to begin anew after each
    # auction, and where others end tasks all the time would never get there.
    if waits and move != memory.under_way:
        return Action(STAY, drive.goal)
    memory.asked = move
    return Action(move[1], drive.goal)


def _waits(memory: AuctionMemory, view: TeamView) -> bool:
    return view.time_s < memory.until_s - 1e-9


def _any_target(view: TeamView) -> bool:
    return len(paths_to_targets(view.belief).cells) > 0


def _heard(view: TeamView) -> tuple[int, ...]:
    """The robots it hears now, itself included, ascending."""
    return tuple(view.in_touch.nonzero()[0].tolist())


def _lowest_heard(view: TeamView) -> int:
    """The number of its auctioneer."""
    return int(view.in_touch.argmax())
