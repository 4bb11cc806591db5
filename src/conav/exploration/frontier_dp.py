"""Frontier-based dynamic programming: Burgard, Moors, Fox, Simmons, Thrun (ICRA 2000)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.decision_theoretic import check_beta
from conav.exploration.frontier_targets import Targets
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.exploration.utility_reduction import Seen, assign_by_utility
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import sight_space
from conav.geometry.value_iteration import raster_order, value_iteration
from conav.maps.occupancy_grid import UNKNOWN
from conav.messages.message import Message

RINGS = 32
"""Into so many equal parts distances up to the sensor's range are divided."""


@dataclass
class ViewMemory(TeamMemory):
    """The drive under way, and how far robots have been able to see so far."""

    seen: NDArray[np.int64] = field(default_factory=lambda: np.zeros(RINGS, dtype=np.int64))
    there: NDArray[np.int64] = field(default_factory=lambda: np.zeros(RINGS, dtype=np.int64))


@dataclass(frozen=True)
class FrontierDP:
    """Robots go where utility less cost is highest; a target given away makes others less useful by
    the probability of seeing them from it.

    The cost of a cell comes from value iteration over the explored cells, where every move costs
    its length times the probability that it ends in an obstacle. Free cells have a floor for that,
    as with 0 all costs would be 0. That robots see as far as d has the probability that they did so
    up to now: the share of measured ranges of d or more in the paper; here, where sight is exact,
    the share of the cells at distance d that were seen from where robots were.
    """

    beta: float = 1.0
    """Weight of the cost of reaching a target against its utility."""
    free: float = 0.1
    """Probability that a cell seen as free is occupied after all."""
    literal: bool = False
    """Compute costs by sweeps of value iteration as the paper does, not by an equal, faster
    search."""

    def __post_init__(self) -> None:
        check_beta(self.beta)
        if not 0.0 < self.free <= 1.0:
            raise ValueError(f"free is {self.free:g}; a probability above 0 is needed")

    def start(self, view: TeamView, rng: np.random.Generator) -> ViewMemory:
        return ViewMemory()

    def step(
        self,
        memory: ViewMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        return team_step(memory, view, inbox, partial(self._assign, memory))

    def _assign(
        self,
        memory: ViewMemory,
        targets: Targets,
        view: TeamView,
        robots: Sequence[int],
        positions: NDArray[np.int32],
    ) -> NDArray[np.int64]:
        # No farther than the map is large, as `look_around` counts.
        lattice = view.lattice
        reach = view.body.sensor.range_m / lattice.resolution
        reach = max(min(reach, sum(view.belief.cells.shape)), 1.0) / lattice.ratio
        look_around(memory, view, positions)
        share = np.where(memory.there > 0, memory.seen / np.maximum(memory.there, 1), 1.0)
        lengths = targets.costs
        if self.literal:
            lengths = iterated_costs(view, positions, targets.cells)
        return assign_by_utility(
            targets,
            lengths * self.free,
            self.beta,
            lattice.cols,
            Seen(reach, share),
            np.empty(0, dtype=np.int64),
        )


def iterated_costs(
    view: TeamView, positions: NDArray[np.int32], cells: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Path lengths [planning cells] as `targets.costs`, by value iteration."""
    moves = view.belief.moves
    lengths = np.full((len(positions), len(cells)), np.inf)
    field_ = np.empty(moves.size)
    for robot, position in enumerate(positions.tolist()):
        order = raster_order(moves, position)
        field_.fill(np.inf)
        value_iteration(moves, position, field_, order)
        lengths[robot] = field_[cells]
    return lengths


def look_around(memory: ViewMemory, view: TeamView, positions: NDArray[np.int32]) -> None:
    """Count, by distance, the cells that can be seen from robots' places, and those there are."""
    lattice = view.lattice
    sensor = view.body.sensor
    cells = view.belief.cells
    space = sight_space(sensor.range_m, lattice.resolution, sensor.occlusion, cells.shape)
    row, col = np.divmod(positions, lattice.cols)
    _count_rings(
        cells,
        lattice.fine_row[row],
        lattice.fine_col[col],
        *space,
        *_rings(len(space.limits) - 1),
        memory.seen,
        memory.there,
    )


@lru_cache(maxsize=8)
def _rings(reach: int) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
    """The ring of each cell of a quarter disc, by rows and columns from its centre [fine cells],
    and how many cells of each of its rows lie within each ring, (reach + 1, RINGS + 1)."""
    away = np.arange(reach + 1)
    distance = np.sqrt(away[:, np.newaxis] ** 2 + away**2) / max(reach, 1) * RINGS
    ring = np.minimum(distance.astype(np.int64), RINGS - 1)
    within = np.array([np.searchsorted(row, np.arange(RINGS + 1)) for row in ring])
    return ring.astype(np.uint8), within.astype(np.int32)


@kernel
def _count_rings(
    cells: NDArray[np.uint8],
    rows: NDArray[np.int32],
    cols: NDArray[np.int32],
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    ring_of: NDArray[np.uint8],
    within: NDArray[np.int32],
    seen: NDArray[np.int64],
    there: NDArray[np.int64],
) -> None:
    """Add, by rings, the cells seen from some map cells to `seen`, those of the map to `there`."""
    width = cells.shape[1]
    flat = cells.reshape(-1)
    upwards = 1.0 / width
    for k in range(rows.shape[0]):
        row = rows[k]
        col = cols[k]
        _count_disc(cells.shape[0], width, row, col, limits, within, there)
        count = cells_in_sight(cells, row, col, occlusion, limits, lows, highs, out)
        stamp = stamps[stamps.shape[0] - 1] + 1
        stamps[stamps.shape[0] - 1] = stamp
        for i in range(count):
            cell = out[i]
            if stamps[cell] != stamp and flat[cell] != UNKNOWN:
                stamps[cell] = stamp
                r = int((cell + 0.5) * upwards)  # a division takes several times as long
                seen[ring_of[abs(r - row), abs(cell - r * width - col)]] += 1


@kernel
def _count_disc(
    height: int,
    width: int,
    row: int,
    col: int,
    limits: NDArray[np.int32],
    within: NDArray[np.int32],
    there: NDArray[np.int64],
) -> None:
    """Add, by rings, the cells of a disc that lie on a map of that size."""
    reach = limits.shape[0] - 1
    for r in range(max(row - reach, 0), min(row + reach, height - 1) + 1):
        off = abs(r - row)
        # So many cells to each side, the middle one with those to the right.
        left = min(limits[off], col) + 1
        right = min(limits[off], width - 1 - col) + 1
        for ring in range(RINGS):
            low = within[off, ring]
            high = within[off, ring + 1]
            there[ring] += min(high, left) - min(low, left) + min(high, right) - min(low, right)
            if low == 0 and high > 0:
                there[ring] -= 1
