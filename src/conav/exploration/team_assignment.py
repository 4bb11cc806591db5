"""How a team is sent to frontiers by one of its robots: who asks, who computes, who drives.

A robot whose goal is resolved or reached asks the robot of the lowest number it hears, itself
included, for a new one. That robot assigns targets to all it hears, as every method here
reconsiders the whole team whenever somebody needs a target, and tells them. It hears nobody lower,
or it tells only those who asked: with a limited radio the others belong to somebody else's team. A
robot that gets no target goes to the nearest one, and where there is none to the nearest place from
which an unknown cell might be seen, as `nearest` does; so the team finishes whenever one robot
alone would.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_targets import Targets, find_targets
from conav.exploration.nearest import (
    NearestMemory,
    by_field,
    choose_nearest,
    drive_on,
    drive_to,
    keeps_goal,
)
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


class Assign(Protocol):
    """A rule that gives robots targets."""

    def __call__(
        self, targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
    ) -> NDArray[np.int64]:
        """A planning cell per robot, -1 for none; `targets.costs` has a row for each of them."""
        ...


@dataclass(frozen=True)
class Request:
    """A robot asks for a target."""

    @property
    def size_bytes(self) -> int:
        """Nothing but the header."""
        return 0


@dataclass(frozen=True)
class Order:
    """A robot is given a target."""

    goal: int  # planning cell, -1 for none
    looks_for: int = -1  # unknown fine cell that may be seen from there, -1 where it is frontier

    @property
    def size_bytes(self) -> int:
        """A planning cell, 4 bytes, and 4 more where it says what to look for."""
        return 4 if self.looks_for < 0 else 8


class Plan(Protocol):
    """What a leader does: orders for all it hears."""

    def __call__(
        self, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
    ) -> list[Order]:
        """An order per robot."""
        ...


@dataclass
class TeamMemory:
    """The drive under way, and what was said in this step."""

    drive: NearestMemory = field(default_factory=NearestMemory)
    began: int = -1  # the last step it began
    assigned: int = -1  # the last step it computed an assignment
    asked: int = -1  # the last step it asked for a target
    assignments: int = 0  # how many it computed


def team_step(
    memory: TeamMemory, view: TeamView, inbox: Sequence[Message], assign: Assign
) -> tuple[TeamMemory, Action, Sequence[Message]]:
    """A step of a strategy that is nothing but a rule of assignment."""

    return planned_step(memory, view, inbox, partial(_plan_targets, assign))


def _plan_targets(
    assign: Assign, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
) -> list[Order]:
    targets = find_targets(view, positions)
    if len(targets.cells) == 0:
        return [Order(-1)] * len(robots)
    return [Order(int(goal)) for goal in assign(targets, view, robots, positions)]


def planned_step(
    memory: TeamMemory, view: TeamView, inbox: Sequence[Message], plan: Plan
) -> tuple[TeamMemory, Action, Sequence[Message]]:
    """A step of a strategy whose leaders plan for all they hear."""
    said: list[Message] = []
    asking = [message.sender for message in inbox if isinstance(message.body, Request)]
    orders = [message.body for message in inbox if isinstance(message.body, Order)]
    if memory.began < view.step:
        memory.began = view.step
        if not keeps_goal(memory.drive, view):
            near = np.flatnonzero(view.in_touch)
            leader = int(near.min())
            if leader == view.robot:
                said += _lead(memory, view, asking, plan)
            else:
                memory.asked = view.step
                # Until it is told it goes where it would go alone.
                choose_nearest(memory.drive, view, by_field)
                said.append(Message(view.robot, leader, view.time_s, Request()))
    if asking and memory.assigned < view.step:
        said += _lead(memory, view, asking, plan)
    for order in orders:
        _follow(memory, view, order)
    return memory, drive_on(memory.drive), said


def _lead(memory: TeamMemory, view: TeamView, asking: Sequence[int], plan: Plan) -> list[Message]:
    """The orders to the others; takes its own."""
    memory.assigned = view.step
    memory.assignments += 1
    near = np.flatnonzero(view.in_touch)
    orders = plan(view, near.tolist(), view.heard_cell[near])
    lowest = int(near.min()) == view.robot
    said: list[Message] = []
    for robot, order in zip(near.tolist(), orders, strict=True):
        if robot == view.robot:
            if lowest:
                _follow(memory, view, order)
        elif lowest or robot in asking:
            said.append(Message(view.robot, robot, view.time_s, order))
    return said


def _follow(memory: TeamMemory, view: TeamView, order: Order) -> None:
    """Drive to a goal; without one, or where it cannot be reached, to the nearest."""
    drive = memory.drive
    if order.goal == drive.goal and keeps_goal(drive, view):
        return
    if not drive_to(drive, view, order.goal, order.looks_for):
        choose_nearest(drive, view)
