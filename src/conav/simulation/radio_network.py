"""Who tells whom what: scans spread through the team by radio.

Each step every robot sends a report to every robot in reach: its position and how many scans of
each teammate it holds. What a receiver then lacks it gets from the neighbour that holds most, the
lower number first. A robot that learned something this way and has a neighbour that, as far as it
can tell, lacks it, reports again; so within one step news reaches everybody connected through
others. Where all hear all in every step, one report with the sender's own new scan is enough; no
scans are kept. Strategies that may switch a radio off (`Action.quiet`) do without that shortcut.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import Belief
from conav.geometry.obstruction import obstructed
from conav.messages.message import report_bytes, scan_bytes
from conav.simulation.slow_network import post
from conav.simulation.told import Exchange, Told
from conav.simulation.world_state import DEAD, Scan, WorldState

MAX_ROUNDS = 32


def links(state: WorldState) -> NDArray[np.bool_]:
    """Which robots hear each other now, shape (n, n), symmetric, False on the diagonal.

    A robot whose radio is off in this step neither hears nor is heard.
    """
    n = state.n_robots
    lattice = state.problem.plan.lattice
    row, col = np.divmod(state.cells.astype(np.int64), lattice.cols)
    square = (row[:, None] - row[None, :]) ** 2 + (col[:, None] - col[None, :]) ** 2
    heard = np.ones((n, n), dtype=bool)
    for i, robot in enumerate(state.problem.robots):
        if robot.radio.range_m is not None:
            limit = robot.radio.range_m / lattice.cell_m
            heard[i] &= (square[i] <= limit * limit) & (limit > 0)
    heard &= heard.T
    silent = state.quiet
    if state.problem.breakable:
        silent = silent | (state.condition >= DEAD)
    heard[silent] = False
    heard[:, silent] = False
    _weaken(state, heard)
    np.fill_diagonal(heard, False)
    return heard


def _weaken(state: WorldState, heard: NDArray[np.bool_]) -> None:
    """Take out the links that distance and walls take too much of."""
    models = [robot.radio.path_loss for robot in state.problem.robots]
    if all(model is None for model in models):
        return
    plan = state.problem.plan
    lattice = plan.lattice
    row, col = np.divmod(state.cells, lattice.cols)
    fine_row, fine_col = lattice.fine_row[row].tolist(), lattice.fine_col[col].tolist()
    for i, j in np.argwhere(np.triu(heard, 1)).tolist():
        ends = (fine_row[i], fine_col[i], fine_row[j], fine_col[j])
        inside, whole = obstructed(plan.walls, *ends)
        square = (ends[2] - ends[0]) ** 2 + (ends[3] - ends[1]) ** 2
        length_m = sqrt(square) * lattice.resolution
        wall_m = length_m * (inside / whole)
        free_m = length_m * ((whole - inside) / whole)
        for model in (models[i], models[j]):
            if model is not None and not model.reaches(free_m, wall_m):
                heard[i, j] = heard[j, i] = False


def exchange(state: WorldState, fresh: list[Scan | None], scratch: NDArray[np.int32]) -> Exchange:
    """What was exchanged in this step.

    Brings held scans, beliefs and last heard positions up to date; `fresh` is each robot's new
    scan, if it made one.
    """
    if state.all_to_all:
        return _all_to_all(state, fresh, scratch)
    before = state.held.copy()
    for robot, scan in enumerate(fresh):
        if scan is not None:
            state.scans[robot].append(scan)
            state.held[robot, robot] += 1
    if state.problem.lossy:
        outcome = post(state, links(state))
    else:
        outcome = _gossip(state, links(state))
    _regroup(state, before, scratch)
    return outcome


def _all_to_all(
    state: WorldState, fresh: list[Scan | None], scratch: NDArray[np.int32]
) -> Exchange:
    n = state.n_robots
    plan = state.problem.plan
    belief = state.beliefs[0]
    size = report_bytes(n) * n
    for robot, scan in enumerate(fresh):
        if scan is not None:
            belief.hear(plan, scan.cell, scan.seen, scratch)
            state.held[:, robot] += 1
            size += scan_bytes(len(scan.seen))
    state.heard_cell[:] = state.cells
    state.heard_step[:] = state.step
    return Exchange([], n * (n - 1), size * (n - 1))


def _gossip(state: WorldState, heard: NDArray[np.bool_]) -> Exchange:
    n = state.n_robots
    held = state.held
    np.fill_diagonal(state.heard_step, state.step)
    np.fill_diagonal(state.heard_cell, state.cells)
    state.heard_step[heard] = state.step
    np.copyto(state.in_touch, heard)
    np.fill_diagonal(state.in_touch, True)
    state.heard_cell[heard] = np.broadcast_to(state.cells, (n, n))[heard]
    messages = int(heard.sum())
    size = messages * report_bytes(n)
    told: list[Told] = []
    neighbours = [np.flatnonzero(heard[i]) for i in range(n)]
    # What each robot thinks each other holds, from reports and from what it sent there itself.
    first = held.copy()
    thought: dict[tuple[int, int], NDArray[np.int32]] = {}  # (who thinks so, of whom)
    for _ in range(MAX_ROUNDS):
        start = held.copy()
        learned = np.zeros(n, dtype=bool)
        for receiver in range(n):
            around = neighbours[receiver]
            if len(around) == 0:
                continue
            most = start[around].max(axis=0)
            lacking = np.flatnonzero(most > start[receiver])
            sizes: dict[int, int] = {}
            for origin in lacking:
                upto = int(most[origin])
                sender = int(around[np.argmax(start[around, origin] == upto)])
                told.append(Told(receiver, sender, int(origin), upto))
                for scan in state.scans[origin][int(start[receiver, origin]) : upto]:
                    sizes[sender] = sizes.get(sender, 0) + scan_bytes(len(scan.seen))
                sizes.setdefault(sender, 0)
                held[receiver, origin] = upto
                if (sender, receiver) not in thought:
                    thought[sender, receiver] = first[receiver].copy()
                thought[sender, receiver][origin] = upto
                learned[receiver] = True
            messages += len(sizes)
            size += sum(report_bytes(n) + cells for cells in sizes.values())
        if not learned.any():
            break
        for sender in np.flatnonzero(learned).tolist():
            now = held[sender]
            for receiver in neighbours[sender].tolist():
                if (now > thought.get((sender, receiver), first[receiver])).any():
                    messages += 1
                    size += report_bytes(n)
                thought[receiver, sender] = now.copy()
    return Exchange(told, messages, size)


def _regroup(state: WorldState, before: NDArray[np.int32], scratch: NDArray[np.int32]) -> None:
    """Give every robot the belief its held scans make, one object for each set of equal rows."""
    held = state.held
    groups: dict[bytes, list[int]] = {}
    for robot in range(state.n_robots):
        groups.setdefault(held[robot].tobytes(), []).append(robot)
    # Each group goes on from the fullest belief among its members; the first that claims one keeps
    # the object, later ones take a copy before anything is added to it.
    claimed: set[int] = set()
    work: list[tuple[Belief, int, list[int]]] = []
    for members in groups.values():
        leader = max(members, key=lambda robot: (int(before[robot].sum()), -robot))
        belief = state.beliefs[leader]
        if id(belief) in claimed:
            belief = belief.copy()
        else:
            claimed.add(id(belief))
        work.append((belief, leader, members))
    plan = state.problem.plan
    for belief, leader, members in work:
        for origin in np.flatnonzero(held[leader] > before[leader]):
            start, end = int(before[leader, origin]), int(held[leader, origin])
            for scan in state.scans[origin][start:end]:
                belief.hear(plan, scan.cell, scan.seen, scratch)
        for robot in members:
            state.beliefs[robot] = belief
