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
    off_path,
)
from conav.exploration.types import Action, TeamView
from conav.messages.message import Body, Message


class Assign(Protocol):
    """A rule that gives robots targets."""

    def __call__(
        self, targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
    ) -> NDArray[np.int64]:
        """A planning cell per robot, -1 for none; `targets.costs` has a row for each of them."""
        ...


@dataclass(frozen=True)
class Request:
    """A robot asks for a target, and may say what it has done with."""

    report: Body | None = None

    @property
    def size_bytes(self) -> int:
        """Nothing but the header, and the report if there is one."""
        return 0 if self.report is None else self.report.size_bytes


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
    ) -> Sequence[Body]:
        """An order per robot."""
        ...


class Driver(Protocol):
    """How a robot carries out orders; what it remembers of them is in its memory."""

    def busy(self, view: TeamView) -> bool:
        """Whether the drive under way goes on; called once a step."""
        ...

    def ask(self, view: TeamView) -> Request:
        """What it asks with; until it is told something it goes where it would go alone."""
        ...

    def follow(self, view: TeamView, order: Body) -> None:
        """Take an order."""
        ...


@dataclass
class Conversation:
    """What was said in this step."""

    began: int = -1  # the last step it began
    assigned: int = -1  # the last step it computed an assignment
    asked: int = -1  # the last step it asked for a target
    assignments: int = 0  # how many it computed


@dataclass
class TeamMemory(Conversation):
    """The drive under way, and what was said."""

    drive: NearestMemory = field(default_factory=NearestMemory)


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
    said = converse(memory, FrontierDriver(memory.drive), view, inbox, plan)
    return memory, drive_on(memory.drive), said


def converse(
    memory: Conversation,
    driver: Driver,
    view: TeamView,
    inbox: Sequence[Message],
    plan: Plan,
) -> list[Message]:
    """What is said in this step; the driver is told what to do."""
    said: list[Message] = []
    asking: list[int] = []
    orders: list[Body] = []
    for message in inbox:
        if isinstance(message.body, Request):
            asking.append(message.sender)
        else:
            orders.append(message.body)
    if memory.began < view.step:
        memory.began = view.step
        if not driver.busy(view):
            leader = int(view.in_touch.argmax())  # the lowest
            if leader == view.robot:
                said += _lead(memory, driver, view, asking, plan)
            else:
                memory.asked = view.step
                said.append(Message(view.robot, leader, view.time_s, driver.ask(view)))
    if asking and memory.assigned < view.step:
        said += _lead(memory, driver, view, asking, plan)
    for order in orders:
        driver.follow(view, order)
    return said


def _lead(
    memory: Conversation, driver: Driver, view: TeamView, asking: Sequence[int], plan: Plan
) -> list[Message]:
    """The orders to the others; takes its own."""
    memory.assigned = view.step
    memory.assignments += 1
    near = np.flatnonzero(view.in_touch)
    robots = near.tolist()
    orders = plan(view, robots, view.heard_cell[near])
    lowest = robots[0] == view.robot
    said: list[Message] = []
    for robot, order in zip(robots, orders, strict=True):
        if robot == view.robot:
            if lowest:
                driver.follow(view, order)
        elif lowest or robot in asking:
            said.append(Message(view.robot, robot, view.time_s, order))
    return said


@dataclass(frozen=True)
class FrontierDriver:
    """Drives to frontiers and to places from which an unknown cell may be seen."""

    drive: NearestMemory

    def busy(self, view: TeamView) -> bool:
        """Whether the goal still promises something new; pushed off its path it takes another.

        To ask would have all sent anew, and two robots in a door across each other for ever.
        """
        drive = self.drive
        if keeps_goal(drive, view):
            return True
        return off_path(drive, view) and drive_to(drive, view, drive.goal, drive.looks_for)

    def ask(self, view: TeamView) -> Request:
        """A request; it goes to the nearest frontier until it is told."""
        choose_nearest(self.drive, view, by_field)
        return Request()

    def follow(self, view: TeamView, order: Body) -> None:
        """Drive to a goal; without one, or where it cannot be reached, to the nearest."""
        assert isinstance(order, Order)
        drive = self.drive
        if order.goal == drive.goal and keeps_goal(drive, view):
            return
        if not drive_to(drive, view, order.goal, order.looks_for):
            choose_nearest(drive, view)
