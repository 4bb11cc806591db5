"""What a leader knows of lanes: who sweeps what next, planned anew whenever somebody asks.

Routes go on from one plan to the next: a robot keeps the pieces it had, as far as they are still
unknown, unless a better plan is found. What was left unseen beside the lanes is visited where the
routes pass, once no sweep will see it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_tasks import find_tasks
from conav.exploration.lane_pieces import (
    Lanes,
    Piece,
    find_pieces,
    lay_lanes,
    looks_like_wall,
    wanted_cells,
)
from conav.exploration.rectangle_drive import coordinates
from conav.exploration.sweep_drive import Sweep
from conav.exploration.sweep_routes import Routes, improve, no_routes
from conav.exploration.team_assignment import Order
from conav.exploration.types import TeamView
from conav.geometry.directions import SQRT2

PARTS = 4  # pieces a robot has at least, so that routes can be balanced
EFFORT = 120_000  # rounds of improvement times pieces and robots
FIRST_EFFORT = 3  # times as much for the first plan
MOST_ROUNDS = 3000
LEAST_ROUNDS = 50


class Leg(NamedTuple):
    """A piece in somebody's route."""

    lane: int
    low: int
    high: int
    turned: int


@dataclass
class LanePlan:
    """The lanes, and who sweeps what in which order."""

    lanes: Lanes | None = None  # once laid they stay
    given_up: NDArray[np.uint8] | None = None  # (fine rows, fine cols) 1: swept and not seen
    routes: dict[int, list[Leg]] = field(default_factory=dict[int, list[Leg]])  # by robot

    def give_up(self, swept: Sweep, view: TeamView) -> None:
        """What a robot has swept and not seen is not swept again."""
        lanes = self.lanes
        if lanes is None or lanes.axis != swept.axis:
            return  # of another leader's lanes
        given_up = self.mask(view)
        oriented = given_up if lanes.axis == 0 else given_up.T
        along_of = view.lattice.row_of if lanes.axis == 0 else view.lattice.col_of
        lane = int(np.argmin(np.abs(lanes.middle - swept.across)))
        low = int(np.searchsorted(along_of, swept.low))
        high = int(np.searchsorted(along_of, swept.high, side="right"))
        oriented[low:high, lanes.edges[lane] : lanes.edges[lane + 1]] = 1

    def mask(self, view: TeamView) -> NDArray[np.uint8]:
        """What is given up, 1 per map cell."""
        if self.given_up is None:
            self.given_up = np.zeros(view.belief.cells.shape, dtype=np.uint8)
        return self.given_up


class _Proposal(NamedTuple):
    """Routes over the pieces of some lanes, and over places to look from."""

    lanes: Lanes
    pieces: list[Piece]
    spots: list[tuple[tuple[int, int], Order]]
    routes: Routes


def plan_lanes(
    plan: LanePlan,
    view: TeamView,
    robots: Sequence[int],
    positions: NDArray[np.int32],
    rng: np.random.Generator,
) -> list[Sweep | Order | None]:
    """An order for each robot: to sweep a piece, to look at what was left, or None.

    The first plan chooses between lanes in both directions.
    """
    lattice = view.lattice
    row, col = np.divmod(positions, lattice.cols)
    here = lattice.fine_row[row].astype(np.int64) * lattice.fine_cols + lattice.fine_col[col]
    wanted = wanted_cells(view.belief.cells, here.tolist(), plan.mask(view))
    options = [plan.lanes] if plan.lanes is not None else _both(view)
    best: _Proposal | None = None
    for lanes in options:
        made = _propose(plan, lanes, view, robots, positions, wanted, rng)
        if made is not None and (best is None or made.routes.cost() < best.routes.cost()):
            best = made
    if best is None:
        plan.routes = {}
        return [None] * len(robots)
    plan.lanes = best.lanes
    plan.routes = {}
    return [_order(plan, best, index, robot) for index, robot in enumerate(robots)]


def _both(view: TeamView) -> list[Lanes]:
    return [lay_lanes(axis, view.body.sensor.range_m, view.lattice) for axis in (0, 1)]


def _propose(
    plan: LanePlan,
    lanes: Lanes,
    view: TeamView,
    robots: Sequence[int],
    positions: NDArray[np.int32],
    wanted: NDArray[np.uint8],
    rng: np.random.Generator,
) -> _Proposal | None:
    """Routes over the pieces of these lanes, or None where there are none."""
    lattice = view.lattice
    first = plan.lanes is None
    wanted = wanted.copy()
    at = [coordinates(lanes.axis, int(cell), lattice.cols) for cell in positions]
    uncut: list[list[int]] = [[] for _ in lanes.middle]
    runs = find_pieces(lanes, wanted, lattice, uncut, max(lattice.rows, lattice.cols))
    if not runs:
        return None
    total = sum(run.end - run.begin + 1 for run in runs)
    cuts = _kept_cuts(plan, len(lanes.middle))
    for along, across in at:
        for lane in lanes.beside(across):
            cuts[lane].append(along)  # a robot may go either way
    most = max(total // (PARTS * len(robots)), 1)
    pieces = find_pieces(lanes, wanted, lattice, cuts, most)
    spots = [] if first else _left_behind(lanes, view, positions, wanted)
    ends = [
        [[piece.begin, lanes.middle[piece.lane]], [piece.end, lanes.middle[piece.lane]]]
        for piece in pieces
    ]
    ends += [[place, place] for place, _ in spots]
    routes = no_routes(len(robots), len(ends))
    if not first:
        _carry_on(plan, robots, pieces, routes)
    effort = EFFORT // (len(ends) + len(robots))
    rounds = min(max(effort, LEAST_ROUNDS), MOST_ROUNDS) * (FIRST_EFFORT if first else 1)
    routes = improve(
        routes,
        np.array(ends, dtype=np.float64),
        np.array(at, dtype=np.float64),
        SQRT2 if view.body.motion.diagonal else 2.0,
        rounds,
        rng,
    )
    return _Proposal(lanes, pieces, spots, routes)


def _order(plan: LanePlan, made: _Proposal, index: int, robot: int) -> Sweep | Order | None:
    """What a robot does first; its route is noted."""
    routes = made.routes
    numbers = routes.pieces[index, : routes.count[index]].tolist()
    turned = routes.turned[index, : routes.count[index]].tolist()
    plan.routes[robot] = [
        Leg(made.pieces[number].lane, made.pieces[number].low, made.pieces[number].high, way)
        for number, way in zip(numbers, turned, strict=True)
        if number < len(made.pieces)
    ]
    if not numbers:
        return None
    if numbers[0] >= len(made.pieces):
        return made.spots[numbers[0] - len(made.pieces)][1]
    piece = made.pieces[numbers[0]]
    begin, end = (piece.end, piece.begin) if turned[0] else (piece.begin, piece.end)
    middle = int(made.lanes.middle[piece.lane])
    return Sweep(made.lanes.axis, middle, begin, end, piece.low, piece.high)


def _left_behind(
    lanes: Lanes, view: TeamView, positions: NDArray[np.int32], wanted: NDArray[np.uint8]
) -> list[tuple[tuple[int, int], Order]]:
    """Places to look from at what no sweep will see: (along, across) and the order.

    Ends of long walls are left to the very end: they hide nothing most of the time, and robots are
    far when it shows that no sweep will pass.
    """
    lattice = view.lattice
    reach = int(view.body.sensor.range_m / lattice.resolution)
    tasks = find_tasks(view, positions)
    spots: list[tuple[tuple[int, int], Order]] = []
    for task, cell in enumerate(tasks.looks_for.tolist()):
        place = int(tasks.nearest[np.argmin(tasks.costs[:, task]), task])
        row, col = divmod(place, lattice.cols)
        if cell >= 0:
            r, c = divmod(cell, lattice.fine_cols)
        else:
            r, c = int(lattice.fine_row[row]), int(lattice.fine_col[col])
        if wanted[max(r - reach, 0) : r + reach + 1, max(c - reach, 0) : c + reach + 1].any():
            continue  # a sweep may still see it
        if looks_like_wall(view.belief.cells, r, c, int(lattice.ratio) + 2, reach):
            continue
        spots.append((coordinates(lanes.axis, place, lattice.cols), Order(place, cell)))
    return spots


def _kept_cuts(plan: LanePlan, n_lanes: int) -> list[list[int]]:
    """Where pieces meet that are not driven one after the other: these stay two pieces."""
    cuts: list[list[int]] = [[] for _ in range(n_lanes)]
    parts = sorted(
        (leg.lane, leg.low, robot, place)
        for robot, route in plan.routes.items()
        for place, leg in enumerate(route)
    )
    for one, two in pairwise(parts):
        together = one[2] == two[2] and abs(one[3] - two[3]) == 1
        if one[0] == two[0] and not together:
            cuts[one[0]].append(two[1])
    return cuts


def _carry_on(
    plan: LanePlan, robots: Sequence[int], pieces: Sequence[Piece], routes: Routes
) -> None:
    """Fill routes with the pieces there are now, each where the one it was part of was."""
    number_of = {robot: index for index, robot in enumerate(robots)}
    by_lane: dict[int, list[tuple[Leg, int, int]]] = {}
    for robot, route in plan.routes.items():
        if robot in number_of:
            for place, leg in enumerate(route):
                by_lane.setdefault(leg.lane, []).append((leg, number_of[robot], place))
    found: list[list[tuple[int, int, int, int]]] = [[] for _ in robots]
    for number, piece in enumerate(pieces):
        most = 0
        where: tuple[Leg, int, int] | None = None
        for entry in by_lane.get(piece.lane, ()):
            leg = entry[0]
            shared = min(leg.high, piece.high) - max(leg.low, piece.low) + 1
            if shared > most:
                most, where = shared, entry
        if where is not None:
            leg, robot, place = where
            along = -piece.low if leg.turned else piece.low
            found[robot].append((place, along, number, leg.turned))
    for robot, route in enumerate(found):
        for k, (_, _, number, turned) in enumerate(sorted(route)):
            routes.pieces[robot, k] = number
            routes.turned[robot, k] = turned
        routes.count[robot] = len(route)
