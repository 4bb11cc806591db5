"""Lanes where it is open, pieces of frontier and pockets where it is not.

Where robots meet few walls the team sweeps lanes along routes that are balanced among them; where
there are rooms and corridors it is sent to pieces of frontier and pockets, as by
`pocket_assignment`. What is known of the walls decides, anew at every plan.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from conav.exploration.lane_plan import LanePlan, plan_lanes
from conav.exploration.nearest import NearestMemory, by_field, choose_nearest, drive_on
from conav.exploration.pocket_assignment import check_advantage, plan_pockets
from conav.exploration.sweep_drive import Sweep, SweepDrive, next_move, place_of, swept
from conav.exploration.team_assignment import (
    Conversation,
    FrontierDriver,
    Order,
    Request,
    converse,
)
from conav.exploration.types import Action, TeamView
from conav.exploration.walls_met import walls_met
from conav.messages.message import Body, Message


@dataclass
class LanesMemory(Conversation):
    """The drive under way, to a frontier or along a lane, and what the robot knows as a leader."""

    drive: NearestMemory = field(default_factory=NearestMemory)
    sweep: SweepDrive | None = None
    move: int = -1  # of the sweep in this step
    done: Sweep | None = None  # swept and not told yet
    plan: LanePlan = field(default_factory=LanePlan)
    open: bool = False  # whether the team is in the open


@dataclass(frozen=True)
class LanesAndPockets:
    """Lanes in the open, assignment of frontier pieces and pockets indoors."""

    advantage: float = 0.5
    """Weight of a task's mean distance from the others against a robot's way to it."""
    open_below: float = 1.0
    """Walls met per cell driven below which the team begins to sweep lanes; 0 is never."""
    closed_above: float = 1.5
    """Walls met per cell driven above which the team stops to sweep lanes."""

    def __post_init__(self) -> None:
        check_advantage(self.advantage)
        if not 0.0 <= self.open_below <= self.closed_above < float("inf"):
            raise ValueError(
                f"open_below is {self.open_below:g} and closed_above {self.closed_above:g}; give "
                "0 or more, the second no less than the first"
            )

    def start(self, view: TeamView, rng: np.random.Generator) -> LanesMemory:
        return LanesMemory()

    def step(
        self,
        memory: LanesMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[LanesMemory, Action, Sequence[Message]]:
        for message in inbox:
            if isinstance(message.body, Request) and isinstance(message.body.report, Sweep):
                memory.plan.give_up(message.body.report, view)
                memory.assigned = -1  # orders given before it was told may be for the same
        plan = partial(self._plan, memory, rng)
        said = converse(memory, _LaneDriver(memory), view, inbox, plan)
        if memory.sweep is None:
            # It has given a sweep up in this step, and asks in the next.
            waits = memory.done is not None
            return memory, Action() if waits else drive_on(memory.drive), said
        if memory.move < 0:  # it has just been ordered
            memory.move = next_move(memory.sweep, view)
        if memory.move < 0:  # there is no way to it: it asks again in the next step
            memory.done = swept(memory.sweep, view)
            memory.sweep = None
            memory.drive = NearestMemory()
            return memory, Action(), said
        return memory, Action(memory.move, place_of(memory.sweep, view)), said

    def _plan(
        self,
        memory: LanesMemory,
        rng: np.random.Generator,
        view: TeamView,
        robots: Sequence[int],
        positions: NDArray[np.int32],
    ) -> list[Sweep | Order]:
        if memory.done is not None:
            memory.plan.give_up(memory.done, view)
            memory.done = None
        range_fine = view.body.sensor.range_m / view.lattice.resolution
        limit = self.closed_above if memory.open else self.open_below
        memory.open = walls_met(view.belief, range_fine) < limit
        orders: list[Sweep | Order | None] = [None] * len(robots)
        if memory.open:
            orders = plan_lanes(memory.plan, view, robots, positions, rng)
        rest = [index for index, order in enumerate(orders) if order is None]
        pockets = plan_pockets(self.advantage, view, positions[rest]) if rest else []
        following = iter(pockets)
        return [next(following) if order is None else order for order in orders]


@dataclass(frozen=True)
class _LaneDriver:
    """Drives along lanes and to frontiers."""

    memory: LanesMemory

    def busy(self, view: TeamView) -> bool:
        """Whether the sweep, or else the drive to a frontier, goes on."""
        memory = self.memory
        memory.move = -1
        if memory.sweep is not None:
            memory.move = next_move(memory.sweep, view)
            if memory.move >= 0:
                return True
            memory.done = swept(memory.sweep, view)
            memory.sweep = None
            memory.drive = NearestMemory()
            return False
        return memory.done is None and FrontierDriver(memory.drive).busy(view)

    def ask(self, view: TeamView) -> Request:
        """A request that says what was swept; it goes to the nearest frontier until it is told."""
        memory = self.memory
        choose_nearest(memory.drive, view, by_field)
        done, memory.done = memory.done, None
        return Request(done)

    def follow(self, view: TeamView, order: Body) -> None:
        """Begin a sweep, or drive to a place, if that is not what it does already."""
        memory = self.memory
        if isinstance(order, Sweep):
            if memory.sweep is None or not memory.sweep.goes_on_as(order):
                memory.sweep = SweepDrive(order)
                memory.move = -1
            return
        if memory.sweep is not None:
            memory.sweep = None
            memory.drive = NearestMemory()
        FrontierDriver(memory.drive).follow(view, order)
