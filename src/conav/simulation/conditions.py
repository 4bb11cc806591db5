"""Which robots are in order, stalled, dead or not there yet: faults and empty batteries."""

import numpy as np
from numpy.typing import NDArray

from conav.exploration.types import steps_until
from conav.maps.occupancy_grid import UNKNOWN
from conav.simulation.pibt import MIN_GAP
from conav.simulation.world_state import ABSENT, ACTIVE, DEAD, STALLED, WorldState


def update_conditions(state: WorldState, gap: NDArray[np.float64]) -> None:
    """Bring `state.condition` up to the step that begins.

    A robot that joins, or can drive again, does so when its place is free of all that can: others
    drive through one that cannot. Deaths come first, then robots in the order of their numbers.
    """
    problem = state.problem
    step = state.step
    condition = state.condition
    for robot, body in enumerate(problem.robots):
        if condition[robot] >= DEAD or body.energy_j is None:
            continue
        on_s = (step - int(state.on_since[robot])) * problem.step_s
        driven_m = float(state.travelled[robot]) * problem.plan.lattice.cell_m
        if body.spent_j(driven_m, on_s) >= body.energy_j:
            _die(state, robot)
    for fault in problem.faults:
        if fault.kind == "dies" and step >= steps_until(fault.at_s, problem.step_s):
            _die(state, fault.robot)
    for robot in range(len(problem.robots)):
        if condition[robot] == DEAD or _waits_to_join(state, robot):
            continue
        if _has_stalled(state, robot):
            now = STALLED
            state.credit[robot] = 0.0
        else:
            drives = condition[robot] == ACTIVE or _is_free(state, robot, gap)
            now = ACTIVE if drives else condition[robot]
        if condition[robot] == ABSENT and now != ABSENT:
            state.on_since[robot] = step
        condition[robot] = now


def _die(state: WorldState, robot: int) -> None:
    if state.condition[robot] != DEAD:
        state.condition[robot] = DEAD
        state.died_at[robot] = state.step


def _waits_to_join(state: WorldState, robot: int) -> bool:
    problem = state.problem
    return any(
        fault.robot == robot
        and fault.kind == "joins"
        and state.step < steps_until(fault.at_s, problem.step_s)
        for fault in problem.faults
    )


def _has_stalled(state: WorldState, robot: int) -> bool:
    problem, step = state.problem, state.step
    return any(
        fault.robot == robot
        and fault.kind == "stalls"
        and step >= steps_until(fault.at_s, problem.step_s)
        and (fault.until_s is None or step < steps_until(fault.until_s, problem.step_s))
        for fault in problem.faults
    )


def _is_free(state: WorldState, robot: int, gap: NDArray[np.float64]) -> bool:
    """Whether a robot may stand where it is beside those that can drive."""
    if state.problem.traffic == "none":
        return True
    cols = state.problem.plan.lattice.cols
    row, col = divmod(int(state.cells[robot]), cols)
    for other in np.flatnonzero(state.condition == ACTIVE).tolist():
        r, c = divmod(int(state.cells[other]), cols)
        least = max(float(gap[robot] + gap[other]), MIN_GAP)
        if other != robot and (r - row) ** 2 + (c - col) ** 2 < least * least - 1e-9:
            return False
    return True


def to_come(state: WorldState) -> bool:
    """Whether somebody will join, or drive again, at a time that lies ahead."""
    problem = state.problem
    for fault in problem.faults:
        if state.condition[fault.robot] == DEAD:
            continue
        when = fault.at_s if fault.kind == "joins" else fault.until_s
        if when is not None and state.step < steps_until(when, problem.step_s):
            return True
    return False


def recount(state: WorldState) -> None:
    """Count as seen what robots that are not dead hold, and nothing else."""
    known = np.zeros(state.problem.plan.walls.size, dtype=np.bool_)
    counted: set[int] = set()
    for robot in np.flatnonzero(state.condition != DEAD).tolist():
        belief = state.beliefs[robot]
        if id(belief) in counted:
            continue
        counted.add(id(belief))
        known |= belief.cells.reshape(-1) != UNKNOWN
    dead = np.flatnonzero(state.condition == DEAD)
    state.sensed_by[:, ~known] = 0
    # What only the dead have seen and others hold still counts as seen by somebody.
    told = known & ~(state.sensed_by != 0).any(axis=0)
    word, bit = divmod(int(dead[0]), 8)
    state.sensed_by[word, told] |= np.uint8(1 << bit)
    state.covered[0] = np.count_nonzero(known & (state.observable.reshape(-1) == 1))
