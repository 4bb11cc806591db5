"""A true potential game of exploration: every robot is paid what the team would miss without it.

The potential phi(a) of a joint action is the number of points the team would newly discover with
it, each counted once. A robot's utility is phi(a) - phi(a_-i), its marginal contribution, which is
the wonderful life utility (3) of [Philip2014], and unlike the utility (7) of that paper it depends
on what the others do. So a change of one robot's action changes its utility by exactly as much as
phi; better responses end in an equilibrium, and as phi is monotone and submodular every equilibrium
discovers at least half as many points as the best joint action (Vetta 2002).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.turn_sequences import (
    TurnMemory,
    check_settings,
    clear_ahead,
    explores,
    forward,
    play,
    second_step,
    ways,
)
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW, STRAIGHT
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import sight_space
from conav.maps.occupancy_grid import OCCUPIED, UNKNOWN
from conav.messages.message import Message

BOUND = -2
"""Sequence of a robot that is in mid-turn: it goes forward once."""
NONE = -1
"""Sequence of a robot that is shut in: it stays."""


@dataclass(frozen=True)
class Standing:
    """What a robot tells the others before the game: how it stands and how it begins."""

    heading: int
    sequence: int  # 0 to 3, `BOUND` or `NONE`

    @property
    def size_bytes(self) -> int:
        """Heading and sequence, 1 byte each."""
        return 2


_STAY = Action()


@dataclass
class GameMemory(TurnMemory):
    """The sequence under way and the outcome of the last game."""

    asked_at: int = -1  # the last step it told how it stands
    sequence: int = NONE  # how it began that step, then what it plays
    regret: int = 0  # the largest regret among the players it computed, 0 at an equilibrium
    responses: int = 0  # better responses made in all its games
    standings: dict[int, Standing] = field(default_factory=dict[int, Standing])  # as last heard
    action: Action = _STAY  # of this step


@dataclass(frozen=True)
class MarginalContribution:
    """In every step the robots play the game to an equilibrium and make its moves.

    Players are the robots that hear each other; those in mid-turn are bound to go forward. A game
    begins with everybody going forward or, with probability epsilon and at obstacles, with a random
    sequence; then the robots, in the order of their numbers, change to the best response where that
    is better, until nobody can gain. What each needs for that it hears in one message from each;
    all compute the same path of better responses, and each takes its own part. Only robots whose
    views could overlap, directly or through others, enter each other's games: the others' do not
    count. All are taken to have this robot's sensor. With a limited radio a robot leaves out those
    it cannot hear, and may have regret; so it may where radios are slow or lose messages, for there
    it plays at once with what it last heard of those in touch.
    """

    epsilon: float = 0.1
    """Probability with which a robot begins a game with a random sequence."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon)

    def start(self, view: TeamView, rng: np.random.Generator) -> GameMemory:
        return GameMemory()

    def step(
        self,
        memory: GameMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[GameMemory, Action, Sequence[Message]]:
        begins = memory.asked_at < view.step
        said: list[Message] = []
        if begins:
            memory.asked_at = view.step
            memory.sequence = self._first(memory, view, rng)
            near = np.flatnonzero(view.in_touch).tolist()
            near.remove(view.robot)
            standing = Standing(view.heading, memory.sequence)
            said = [Message(view.robot, other, view.time_s, standing) for other in near]
            if near and view.prompt:
                # Each of them tells in this step too, so the game waits for that.
                return memory, _STAY, said
        standings = {
            message.sender: message.body for message in inbox if isinstance(message.body, Standing)
        }
        if not view.prompt:
            memory.standings.update(standings)
            if not begins:
                return memory, memory.action, ()
            standings = {
                other: standing
                for other, standing in sorted(memory.standings.items())
                if view.in_touch[other]
            }
        memory.action = self._answer(memory, view, standings)
        return memory, memory.action, said

    def _answer(self, memory: GameMemory, view: TeamView, others: dict[int, Standing]) -> Action:
        if memory.sequence == BOUND:
            return forward(view)
        memory.sequence = _play_game(memory, view, others)
        return play(memory, view, memory.sequence, "step")

    def _first(self, memory: GameMemory, view: TeamView, rng: np.random.Generator) -> int:
        if second_step(memory, view):
            return BOUND
        if clear_ahead(view) and not explores(view, self.epsilon, rng):
            return 0
        possible = [turn for turn in range(4) if ways(view) >> (view.heading + turn) % 4 & 1]
        return possible[int(rng.random() * len(possible))] if possible else NONE


class JointPoints(NamedTuple):
    """What each sequence of each player would newly discover: the game in numbers."""

    points: NDArray[np.int32]  # flat fine indices, the sets one after the other
    first: NDArray[np.int64]  # (n_players, 4) where a set begins, -1 where it cannot be played
    end: NDArray[np.int64]  # (n_players, 4) where it ends
    cover: NDArray[np.int32]  # (fine cells,) working space, all 0


def joint_points(view: TeamView, players: Sequence[tuple[int, int, int]]) -> JointPoints:
    """The sets of points of players given as (planning cell, heading, sequence they begin with).

    A player that is `BOUND` has one set, in the place of the baseline; one that is shut in none.
    Reads of the view only the belief, the lattice and the sensor.
    """
    lattice = view.lattice
    sensor = view.body.sensor
    belief = view.belief
    space = sight_space(sensor.range_m, lattice.resolution, sensor.occlusion, belief.cells.shape)
    found = np.empty((4, 2 * len(space.out)), dtype=np.int32)
    sizes = np.empty(4, dtype=np.int64)
    parts: list[NDArray[np.int32]] = []
    first = np.full((len(players), 4), -1, dtype=np.int64)
    end = np.full((len(players), 4), -1, dtype=np.int64)
    total = 0
    for player, (cell, heading, sequence) in enumerate(players):
        row, col = divmod(cell, lattice.cols)
        _collect(
            belief.cells,
            row,
            col,
            heading,
            int(belief.moves.item(cell)) & STRAIGHT,
            sequence == BOUND,
            lattice.fine_row,
            lattice.fine_col,
            *space,
            found,
            sizes,
        )
        for turn in range(4):
            size = int(sizes[turn])
            if size >= 0:
                parts.append(found[turn, :size].copy())
                first[player, turn] = total
                total += size
                end[player, turn] = total
    points = np.concatenate(parts) if parts else np.empty(0, dtype=np.int32)
    return JointPoints(points, first, end, _cover_space(belief.cells.size))


def _play_game(memory: GameMemory, view: TeamView, others: dict[int, Standing]) -> int:
    """This robot's sequence in the equilibrium."""
    standings = {view.robot: (view.cell, view.heading, memory.sequence)}
    for other, standing in others.items():
        standings[other] = (int(view.heard_cell[other]), standing.heading, standing.sequence)
    players = _players(view, standings)
    game = joint_points(view, [standings[player] for player in players])
    profile = np.array([first_sequence(standings[player][2]) for player in players])
    responses = better_responses(*game, profile)
    memory.decisions += 1
    memory.points_checked += len(game.points)
    memory.responses += responses
    memory.regret = int(regrets(*game, profile).max())
    return int(profile[players.index(view.robot)])


def first_sequence(sequence: int) -> int:
    """The column of `JointPoints` a player begins with, -1 when it is shut in."""
    return 0 if sequence == BOUND else sequence


def _players(view: TeamView, standings: dict[int, tuple[int, int, int]]) -> list[int]:
    """This robot and those whose views could overlap with its own, directly or through others."""
    lattice = view.lattice
    # Both may go two planning cells towards each other and look as far as their sensors reach.
    reach = 2 * view.body.sensor.range_m / lattice.cell_m + 4 + 2 / lattice.ratio
    at = {player: divmod(standing[0], lattice.cols) for player, standing in standings.items()}
    inside = [view.robot]
    left = set(standings) - {view.robot}
    for one in inside:  # grows while it is read
        row, col = at[one]
        near = [
            other
            for other in left
            if (at[other][0] - row) ** 2 + (at[other][1] - col) ** 2 <= reach * reach
        ]
        inside.extend(near)
        left.difference_update(near)
    return sorted(inside)


@lru_cache(maxsize=4)
def _cover_space(size: int) -> NDArray[np.int32]:
    return np.zeros(size, dtype=np.int32)


@kernel
def _collect(
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    heading: int,
    bits: int,
    bound: bool,
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    found: NDArray[np.int32],
    sizes: NDArray[np.int64],
) -> None:
    """Fill `found` (4, size) and `sizes` (4,) with the unknown points of each sequence, -1 none."""
    last = stamps.shape[0] - 1
    for turn in range(4):
        sizes[turn] = -1
        k = (heading + turn) & 3
        if bits & (1 << k) == 0 or (bound and turn > 0):
            continue
        stamp = stamps[last] + 1
        stamps[last] = stamp
        size = 0
        for steps in range(1, 2 if turn > 0 or bound else 3):
            r = row + steps * DROW[k]
            c = col + steps * DCOL[k]
            if r < 0 or r >= fine_row.shape[0] or c < 0 or c >= fine_col.shape[0]:
                continue
            if cells[fine_row[r], fine_col[c]] == OCCUPIED:
                continue
            count = cells_in_sight(
                cells, fine_row[r], fine_col[c], occlusion, limits, lows, highs, out
            )
            for i in range(count):
                cell = out[i]
                if (
                    stamps[cell] != stamp
                    and cells[cell // cells.shape[1], cell % cells.shape[1]] == UNKNOWN
                ):
                    stamps[cell] = stamp
                    found[turn, size] = cell
                    size += 1
        sizes[turn] = size


@kernel
def _gain(points: NDArray[np.int32], first: int, end: int, cover: NDArray[np.int32]) -> int:
    """How many points of a set nobody covers."""
    gain = 0
    for i in range(first, end):
        if cover[points[i]] == 0:
            gain += 1
    return gain


@kernel
def _add(
    points: NDArray[np.int32], first: int, end: int, cover: NDArray[np.int32], sign: int
) -> None:
    for i in range(first, end):
        cover[points[i]] += sign


@kernel
def better_responses(
    points: NDArray[np.int32],
    first: NDArray[np.int64],
    end: NDArray[np.int64],
    cover: NDArray[np.int32],
    profile: NDArray[np.int64],
) -> int:
    """The number of better responses made; changes `profile` (n_players,) to an equilibrium.

    In every round each player, in order, takes its best response if it is better than what it
    plays; the first of equally good ones. Ends as phi grows with every change and is bounded.
    """
    n = profile.shape[0]
    for player in range(n):
        if profile[player] >= 0:
            k = profile[player]
            _add(points, first[player, k], end[player, k], cover, 1)
    changes = 0
    quiet = 0
    player = 0
    while quiet < n:
        now = profile[player]
        quiet += 1
        if now >= 0:
            _add(points, first[player, now], end[player, now], cover, -1)
            most = _gain(points, first[player, now], end[player, now], cover)
            best = now
            for k in range(4):
                if k != now and first[player, k] >= 0:
                    gain = _gain(points, first[player, k], end[player, k], cover)
                    if gain > most:
                        most = gain
                        best = k
            if best != now:
                profile[player] = best
                changes += 1
                quiet = 0
            _add(points, first[player, best], end[player, best], cover, 1)
        player = (player + 1) % n
    for player in range(n):
        if profile[player] >= 0:
            k = profile[player]
            _add(points, first[player, k], end[player, k], cover, -1)
    return changes


@kernel
def regrets(
    points: NDArray[np.int32],
    first: NDArray[np.int64],
    end: NDArray[np.int64],
    cover: NDArray[np.int32],
    profile: NDArray[np.int64],
) -> NDArray[np.int64]:
    """What each player could gain by changing alone, shape (n_players,)."""
    n = profile.shape[0]
    regret = np.zeros(n, dtype=np.int64)
    for player in range(n):
        if profile[player] >= 0:
            k = profile[player]
            _add(points, first[player, k], end[player, k], cover, 1)
    for player in range(n):
        now = profile[player]
        if now < 0:
            continue
        _add(points, first[player, now], end[player, now], cover, -1)
        mine = _gain(points, first[player, now], end[player, now], cover)
        for k in range(4):
            if first[player, k] >= 0:
                gain = _gain(points, first[player, k], end[player, k], cover)
                regret[player] = max(regret[player], gain - mine)
        _add(points, first[player, now], end[player, now], cover, 1)
    for player in range(n):
        if profile[player] >= 0:
            k = profile[player]
            _add(points, first[player, k], end[player, k], cover, -1)
    return regret
