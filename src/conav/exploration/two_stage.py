"""Two-stage coordinated strategy: rectangles shaped by social entropy, then sections by auction.

The strategy of [Dai2018]. What it says of obstacle-free worlds is followed; what it leaves open is
a setting, and what becomes of obstacles, which it leaves for later, is this module's own.

Rules of this file and of those it is made of (`two_stage_*.py`): every change of phase goes through
`FLOW`, which is Figure 2 as a table, and all that a phase reads and writes is in its `Turn`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from conav.exploration.section_auction import Announce, Award, Bid, IllegalMessage, Join
from conav.exploration.section_board import News
from conav.exploration.social_entropy import Measure, Sense
from conav.exploration.two_stage_auction import answer, hear_award, run_auction, wait_for_award
from conav.exploration.two_stage_flow import Phase
from conav.exploration.two_stage_rectangles import approach, drive_first, scan_section
from conav.exploration.two_stage_rest import finish_frontiers
from conav.exploration.two_stage_turn import STAY, Turn, TwoStageMemory
from conav.exploration.two_stage_vote import Vote, count_vote, elect, vote
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message

Tie = Literal["near", "order", "random"]
Closing = Literal["useful", "always"]

PHASES: dict[Phase, Callable[[Turn], Action | None]] = {
    Phase.VOTE: vote,
    Phase.FIRST: drive_first,
    Phase.AUCTION: wait_for_award,
    Phase.APPROACH: approach,
    Phase.SCAN: scan_section,
    Phase.REST: finish_frontiers,
}
"""What a robot does in a phase: its action, or None when it has passed to another phase."""


@dataclass(frozen=True)
class TwoStage:
    """Stage 1: a rectangle along a direction the team votes on. Stage 2: sections by auction.

    Each robot starts with a rectangle whose directions are chosen by social entropy. Then it bids
    for the sections that are left, scans the one it gets with rectangles, and bids again. When no
    section is left, what obstacles hid is finished as `nearest` does.
    """

    sense: Sense = "minimise"
    """Whether directions minimise the team's social entropy, as in the paper, or maximise it."""
    measure: Measure = "hierarchic"
    """Hierarchic or simple social entropy."""
    cluster_m: float | None = None
    """Robots at most this far apart are one cluster of the simple measure [m]; None is 2 r."""
    probe_m: float | None = None
    """How far a robot imagines it has moved when it compares directions [m]; None is 2 r."""
    tie: Tie = "near"
    """Among directions with equal entropy: the nearest border, up-down-left-right, or at random."""
    task_width_m: float | None = None
    """d_0, the width of section a robot can scan in a task [m]; None is 2 r."""
    closing: Closing = "useful"
    """Drive rectangles to the end always, or only while that shows anything unknown."""
    auction_wait_s: float = 5.0
    """How long robots stand still in an auction period [s]."""
    silence_s: float = 120.0
    """A section awarded to a robot not heard, or not seen to move, for longer is free again [s]."""

    def __post_init__(self) -> None:
        for name in ("cluster_m", "probe_m", "task_width_m"):
            length: float | None = getattr(self, name)
            if length is not None and not 0.0 < length < float("inf"):
                raise ValueError(f"{name} is {length:g}; give a positive length in metres")
        for name in ("auction_wait_s", "silence_s"):
            time: float = getattr(self, name)
            if not 0.0 <= time < float("inf"):
                raise ValueError(f"{name} is {time:g}; give 0 or more seconds")

    def start(self, view: TeamView, rng: np.random.Generator) -> TwoStageMemory:
        return TwoStageMemory()

    def step(
        self,
        memory: TwoStageMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TwoStageMemory, Action, Sequence[Message]]:
        turn = Turn(self, memory, view, rng)
        _take(turn, inbox)
        return memory, memory.action, turn.said


def _take(turn: Turn, inbox: Sequence[Message]) -> None:
    """Read the messages, then decide; once a step, and again when something was decided."""
    memory = turn.memory
    begins = memory.began < turn.view.step
    memory.began = turn.view.step
    if begins:
        turn.watch()
        turn.greet()
        if memory.phase is Phase.VOTE and memory.candidate >= 0:
            elect(turn)  # with the votes that arrived
    before = memory.phase
    for message in inbox:
        try:
            _read(turn, message)
        except IllegalMessage:
            memory.refused += 1
    run_auction(turn)
    if begins or memory.phase is not before:
        memory.action = _decide(turn)
        run_auction(turn)  # it may have joined its own
        if memory.phase is Phase.APPROACH and memory.action == STAY:
            memory.action = _decide(turn)


def _read(turn: Turn, message: Message) -> None:
    memory, body, sender = turn.memory, message.body, message.sender
    if isinstance(body, Vote):
        if memory.phase is Phase.VOTE:
            count_vote(turn, sender, body)
    elif isinstance(body, News):
        turn.hear_news(body, sender)
    elif isinstance(body, Join):
        memory.auctioneer.join(sender, turn.view.time_s)
    elif isinstance(body, Bid):
        memory.auctioneer.bid(sender, body)
    elif isinstance(body, Announce):
        answer(turn, sender, body)
    elif isinstance(body, Award):
        hear_award(turn, sender, body)


def _decide(turn: Turn) -> Action:
    """The action of the phase the robot is in, or of those it passes through now."""
    while True:
        before = turn.memory.phase
        action = PHASES[before](turn)
        if action is not None and (turn.memory.phase is before or before is Phase.AUCTION):
            return action
