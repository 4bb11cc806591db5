"""The improved algorithm of [Philip2014], section 4: robots predict each other.

Letters of the paper: discPts_i is the set of points robot i has discovered, discPts_-i that of all
others; loc(t) a location, a hat marks a prediction.

A robot that may change its action predicts that all others go forward for two steps, and counts
only points that none of them will have in range: C1 and C2 of (18). For the next two steps it also
adds to its own set only such points: (19). A point may so be seen and counted by nobody; robots
then come back for it. It is called left out here, and coverage is still what robots truly saw.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.turn_sequences import (
    LEFT_OUT,
    Draw,
    Tie,
    TurnMemory,
    best_of,
    check_settings,
    clear_ahead,
    explores,
    forward,
    near_any,
    play,
    second_step,
    sequence_gains,
    turn_from_obstacle,
)
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import sight_space
from conav.maps.occupancy_grid import OCCUPIED, UNKNOWN
from conav.messages.message import Message

DISCOVERED = 1
"""State of a point that belongs to somebody's set; `LEFT_OUT` if it was only seen, else 0."""

_NOBODY = np.empty((0, 2), dtype=np.int32)


@dataclass(frozen=True)
class Tidings:
    """What a robot tells its teammates beside the scan they get from it anyway.

    With a perfect radio encoded as its heading, what of its scan it leaves out, and what it now
    takes that had been left out before; which points it added follows from these and the scan. With
    a limited one a receiver may know points from others, so all that were added are sent.
    """

    heading: int
    added: NDArray[np.int32]  # flat fine indices now in the sender's set
    left_out: NDArray[np.int32]  # flat fine indices it saw for the first time and leaves out
    sent: int  # how many of `added` have to be sent

    @property
    def size_bytes(self) -> int:
        """Heading 1, two counts of 4, and 4 per point [bytes]."""
        return 9 + 4 * (len(self.left_out) + self.sent)


_STAY = Action()


@dataclass
class ImprovedMemory(TurnMemory):
    """The sequence under way, what is known of the sets, and the last prediction."""

    state: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.uint8))
    others: NDArray[np.int32] = field(default_factory=lambda: _NOBODY)  # predicted, (k, 2) fine
    predicted_at: int = -3  # the step of that
    told_at: int = -1  # the last step it told the others
    headings: dict[int, int] = field(default_factory=dict[int, int])  # as last heard, slow radios
    action: Action = _STAY  # of this step


@dataclass(frozen=True)
class PotentialImproved:
    """Algorithm 2 by robots that predict where the others will be (section 4).

    Readings, where the text is short or does not hold together: C2 of (18) is printed with the
    negation of its first clause, which would count what is out of range; (19) compares locations of
    two different times, here both are those of the step in which a point is seen, and the others'
    are the predicted ones of both steps, as in (18) and as the text around it asks for. A predicted
    robot stops at an obstacle that is known. A robot that turns at an obstacle predicts as well.

    Where radios are slow or lose messages it goes by what it last heard of those in touch, and
    points whose message was lost stay undiscovered in its sets.
    """

    epsilon: float = 0.1
    """Probability with which a robot may change its action in a step: the exploration rate."""
    tie: Tie = "random"
    """Who wins a tie: "random" or, to the letter of section 2.4, the "baseline"."""
    draw: Draw = "step"
    """Draw epsilon every "step" but in mid-turn, or once per two-step "sequence"."""

    def __post_init__(self) -> None:
        check_settings(self.epsilon, self.tie, self.draw)

    def start(self, view: TeamView, rng: np.random.Generator) -> ImprovedMemory:
        return ImprovedMemory(state=np.zeros(view.belief.cells.shape, dtype=np.uint8))

    def step(
        self,
        memory: ImprovedMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[ImprovedMemory, Action, Sequence[Message]]:
        begins = memory.told_at < view.step
        said: list[Message] = []
        if begins:
            memory.told_at = view.step
            tidings = _update_own_set(memory, view)
            near = np.flatnonzero(view.in_touch).tolist()
            near.remove(view.robot)
            said = [Message(view.robot, other, view.time_s, tidings) for other in near]
            if near and view.prompt:
                # Each of them tells in this step too, so the decision waits for that.
                return memory, _STAY, said
        headings = _update_other_sets(memory.state, inbox)
        if not view.prompt:
            memory.headings.update(headings)
            if not begins:
                return memory, memory.action, ()
            headings = {
                other: heading
                for other, heading in sorted(memory.headings.items())
                if view.in_touch[other]
            }
        memory.action = self._decide(memory, view, headings, rng)
        return memory, memory.action, said

    def _decide(
        self,
        memory: ImprovedMemory,
        view: TeamView,
        headings: dict[int, int],
        rng: np.random.Generator,
    ) -> Action:
        if second_step(memory, view):
            return forward(view)
        turn = 0
        ahead = clear_ahead(view)
        if not ahead or explores(view, self.epsilon, rng):
            memory.others = predict_others(view, headings)
            memory.predicted_at = view.step
            gains = sequence_gains(memory, view, memory.state, memory.others)
            turn = best_of(gains, self.tie, rng) if ahead else turn_from_obstacle(gains, rng)
        return play(memory, view, turn, self.draw)


def predict_others(view: TeamView, headings: dict[int, int]) -> NDArray[np.int32]:
    """Fine positions (k, 2) of the teammates after one and after two steps forward."""
    lattice = view.lattice
    places: list[tuple[int, int]] = []
    for other, heading in headings.items():
        row, col = divmod(int(view.heard_cell[other]), lattice.cols)
        for _ in range(2):
            r, c = row + DROW[heading], col + DCOL[heading]
            if (
                0 <= r < lattice.rows
                and 0 <= c < lattice.cols
                and view.belief.cells[lattice.fine_row[r], lattice.fine_col[c]] != OCCUPIED
            ):
                row, col = r, c
            places.append((int(lattice.fine_row[row]), int(lattice.fine_col[col])))
    return np.array(places, dtype=np.int32).reshape(-1, 2)


def _update_other_sets(state: NDArray[np.uint8], inbox: Sequence[Message]) -> dict[int, int]:
    """The heading of each sender; brings the sets up to date, in whatever order they wrote."""
    headings: dict[int, int] = {}
    flat = state.reshape(-1)
    for message in inbox:
        tidings = message.body
        if not isinstance(tidings, Tidings):
            continue
        headings[message.sender] = tidings.heading
        mine = tidings.left_out
        flat[mine[flat[mine] == 0]] = LEFT_OUT
        flat[tidings.added] = DISCOVERED
    return headings


def _update_own_set(memory: ImprovedMemory, view: TeamView) -> Tidings:
    """What this robot's set gains from where it stands, and what it leaves out."""
    lattice = view.lattice
    sensor = view.body.sensor
    space = sight_space(
        sensor.range_m, lattice.resolution, sensor.occlusion, view.belief.cells.shape
    )
    row, col = divmod(view.cell, lattice.cols)
    bound = view.step - memory.predicted_at <= 2
    lists = np.empty((2, len(space.out)), dtype=np.int32)
    added, left_out, taken = _own_set(
        view.belief.cells,
        memory.state,
        memory.others if bound else _NOBODY,
        int(lattice.fine_row[row]),
        int(lattice.fine_col[col]),
        *space,
        lists,
    )
    sent = taken if view.body.radio.range_m is None else added
    return Tidings(view.heading, lists[0, :added].copy(), lists[1, :left_out].copy(), sent)


@kernel
def _own_set(
    cells: NDArray[np.uint8],
    state: NDArray[np.uint8],
    others: NDArray[np.int32],
    row: int,
    col: int,
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    lists: NDArray[np.int32],
) -> tuple[int, int, int]:
    """How many points were added, left out for the first time, and taken after being left out.

    Writes the first two to the rows of `lists` and brings `state` up to date.
    """
    cols = cells.shape[1]
    count = cells_in_sight(cells, row, col, occlusion, limits, lows, highs, out)
    added = 0
    left_out = 0
    taken = 0
    for i in range(count):
        cell = out[i]
        r = cell // cols
        c = cell - r * cols
        if cells[r, c] == UNKNOWN or state[r, c] == DISCOVERED:
            continue
        if near_any(others, limits, r, c):
            if state[r, c] == 0:
                state[r, c] = LEFT_OUT
                lists[1, left_out] = cell
                left_out += 1
            continue
        if state[r, c] == LEFT_OUT:
            taken += 1
        state[r, c] = DISCOVERED
        lists[0, added] = cell
        added += 1
    return added, left_out, taken
