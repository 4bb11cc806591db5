"""The nouns of exploration: the problem, what a mind sees, what it answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import Belief
from conav.geometry.directions import STAY
from conav.maps.planning_grid import Lattice, PlanningGrid
from conav.messages.message import Message
from conav.robots.fault import Fault, check_faults
from conav.robots.robot import Robot

TRAFFIC = ("pibt", "none")
"""What happens where robots meet: one shared rule that keeps them apart, or, as in papers without
such a rule, nothing at all: they pass through each other."""


@dataclass(frozen=True, eq=False)
class ExplorationProblem:
    """Everything a run depends on besides the strategy.

    Raises `ValueError` when robots, starts and planning grid do not belong together: the grid's
    moves were tested for one radius, with or without diagonals.
    """

    plan: PlanningGrid
    robots: tuple[Robot, ...]
    starts: tuple[int, ...]  # planning cell of each robot, flat index
    seed: int
    max_time_s: float  # [s] simulated
    traffic: str = "pibt"  # the rule where robots meet, of `TRAFFIC`
    faults: tuple[Fault, ...] = ()

    def __post_init__(self) -> None:
        if self.traffic not in TRAFFIC:
            raise ValueError(f"traffic {self.traffic!r} is none of {', '.join(TRAFFIC)}")
        if not self.robots or len(self.starts) != len(self.robots):
            raise ValueError(f"{len(self.robots)} robots need as many starts, one at least")
        check_faults(self.faults, len(self.robots))
        networks = {(robot.radio.loss, robot.radio.delay_s) for robot in self.robots}
        if len(networks) > 1:
            raise ValueError("all radios of a team need the same loss and the same delay")
        for robot, cell in zip(self.robots, self.starts, strict=True):
            if robot.radius_m > self.plan.radius_m:
                raise ValueError(
                    f"{robot.name} has radius {robot.radius_m:g} m; the planning grid was made for "
                    f"{self.plan.radius_m:g} m"
                )
            if robot.motion.diagonal != self.plan.diagonal:
                raise ValueError(
                    f"{robot.name} is {robot.motion.name}; make the planning grid with "
                    f"diagonal={robot.motion.diagonal}"
                )
            if not self.plan.standable.reshape(-1)[cell]:
                raise ValueError(f"{robot.name} cannot stand at planning cell {cell}")

    @cached_property
    def step_s(self) -> float:
        """The length of a step [s]: the fastest robot's time for one straight move."""
        return self.plan.lattice.cell_m / max(robot.speed_mps for robot in self.robots)

    @cached_property
    def perfect_radio(self) -> bool:
        """Whether everybody hears everything everybody says at once, as far as they are alive."""
        return not self.lossy and all(
            robot.radio.range_m is None and robot.radio.path_loss is None for robot in self.robots
        )

    @cached_property
    def lossy(self) -> bool:
        """Whether messages may be lost or come later than they are sent."""
        return self.loss > 0.0 or self.delay_steps > 0

    @cached_property
    def loss(self) -> float:
        """The probability that a message is lost."""
        return self.robots[0].radio.loss

    @cached_property
    def delay_steps(self) -> int:
        """How many steps after it was sent a message arrives."""
        return steps_until(self.robots[0].radio.delay_s, self.step_s)

    @cached_property
    def patience_steps(self) -> int:
        """How many steps running a robot may be silent by loss alone; one in a thousand is more."""
        steps, chance = 0, self.loss
        while chance > 1e-3:
            steps, chance = steps + 1, chance * self.loss
        return steps

    @cached_property
    def breakable(self) -> bool:
        """Whether a robot may be anything but in order."""
        return bool(self.faults) or any(robot.energy_j is not None for robot in self.robots)

    @cached_property
    def rates(self) -> NDArray[np.float64]:
        """Cells of travel each robot earns in a step, 1 for the fastest, shape (n_robots,)."""
        top = max(robot.speed_mps for robot in self.robots)
        return np.array([robot.speed_mps / top for robot in self.robots])


def steps_until(time_s: float, step_s: float) -> int:
    """The first step at or after a time."""
    return ceil(time_s / step_s - 1e-9)


class TeamView(NamedTuple):
    """What one robot knows at one moment; its arrays are locked and change with the next step."""

    step: int
    time_s: float  # [s] simulated
    robot: int  # its own number
    body: Robot
    cell: int  # planning cell it stands on, flat index
    heading: int  # direction 0 to 3 it faces
    belief: Belief
    lattice: Lattice
    heard_cell: NDArray[np.int32]  # (n_robots,) where each robot was when last heard, -1 never
    heard_step: NDArray[np.int32]  # (n_robots,) the step it was there, -1 never
    in_touch: NDArray[np.bool_]  # (n_robots,) whether messages go to and fro, itself included
    """Heard in this step; where radios are slow or lose messages, heard of as lately as they let
    one expect: `ExplorationProblem.delay_steps` and `patience_steps` ago."""
    delay_steps: int = 0  # a message sent in this step arrives so many steps later

    @property
    def prompt(self) -> bool:
        """Whether all that is said arrives in the step it is said in."""
        return self.delay_steps == 0 and self.body.radio.loss == 0.0


class Action(NamedTuple):
    """What a mind wants its robot to do in this step."""

    direction: int = STAY  # 0 to 7 of `conav.geometry.directions`, or STAY
    goal: int = -1  # planning cell it is heading for, -1 none; for people and for the verifier
    finished: bool = False  # nothing left to explore as far as it knows
    quiet: bool = False  # its radio is off during the next step; needs `may_be_quiet`


class Strategy(Protocol):
    """An exploration strategy: frozen settings and two pure functions.

    `step` does no input or output and does not change what it is given other than `memory`, which
    is its own; all randomness comes from `rng`. Memory must pickle.

    A strategy that switches radios off (`Action.quiet`) has an attribute `may_be_quiet` that is
    true. Its robots pass scans on one by one even where everybody hears everybody.
    """

    def start(self, view: TeamView, rng: np.random.Generator) -> Any:
        """A robot's memory before its first decision."""
        ...

    def step(
        self, memory: Any, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[Any, Action, Sequence[Message]]:
        """The new memory, the action, and messages to send now.

        Called again in the same step for as long as messages arrive; the last action counts.
        """
        ...
