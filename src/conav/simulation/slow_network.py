"""Who tells whom what where messages are late or get lost: one message a step over each link.

Each step every robot sends every robot in reach a report: its position, how many scans of each
teammate it holds, its own new scan, and whose scans it asks the receiver for. It asks the one that,
as far as it has heard, holds most of what it lacks, the lower number first, and again when the
answer is overdue. Who is asked answers with the scans. A scan that does not follow on those the
receiver holds is dropped. So news goes one robot far in a step, and what was lost is sent again.

Links must be up when a message is sent and the receiver's radio on when it arrives. Which messages
are lost is a function of the problem's seed, the step, the round, the two robots and the kind of
message, so that it depends on nothing else that is random.
"""

import numpy as np
from numpy.typing import NDArray

from conav.messages.message import report_bytes, scan_bytes
from conav.simulation.told import Exchange, Told
from conav.simulation.world_state import DEAD, Mail, Parcel, WorldState

REPORT = 0
ANSWER = 1
SPEECH = 2  # of minds; further messages of a round between the same two count up from here

_MASK = 2**64 - 1
_GAMMA = 0x9E3779B97F4A7C15


def is_lost(
    seed: int, chance: float, step: int, round_: int, sender: int, receiver: int, kind: int
) -> bool:
    """Whether this message is lost: true with that chance, and independent of all others."""
    bits = 0
    for part in (seed, step, round_, sender, receiver, kind):
        bits = _mixed(((bits ^ part) + _GAMMA) & _MASK)
    return (bits >> 11) * 2.0**-53 < chance


def _mixed(bits: int) -> int:
    """The finaliser of splitmix64 [Steele2014]."""
    bits = ((bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    bits = ((bits ^ (bits >> 27)) * 0x94D049BB133111EB) & _MASK
    return bits ^ (bits >> 31)


def post(state: WorldState, heard: NDArray[np.bool_]) -> Exchange:
    """What arrives and what is sent in this step; brings held scans and positions up to date."""
    problem, mail, step = state.problem, state.mail, state.step
    n = state.n_robots
    silent = state.quiet | (state.condition >= DEAD)
    np.fill_diagonal(state.heard_step, step)
    np.fill_diagonal(state.heard_cell, state.cells)
    told: list[Told] = []
    arrived = [parcel for parcel in mail.parcels if parcel.due <= step]
    mail.parcels = [parcel for parcel in mail.parcels if parcel.due > step]
    asked = _receive(state, [p for p in arrived if not silent[p.receiver]], told)
    reports = _reports(state, heard)
    answers: list[Parcel] = []
    if problem.delay_steps == 0:
        asked += _receive(state, _kept(state, reports, REPORT), told)
        answers = _answers(state, heard, asked)
        _receive(state, _kept(state, answers, ANSWER), told)
    else:
        answers = _answers(state, heard, asked)
        mail.parcels += _kept(state, reports, REPORT) + _kept(state, answers, ANSWER)
    age = step - state.heard_step
    limit = problem.delay_steps + problem.patience_steps
    np.copyto(state.in_touch, (state.heard_step >= 0) & (age <= limit))
    messages = len(reports) + len(answers)
    size = messages * report_bytes(n) + sum(_size(state, parcel) for parcel in reports + answers)
    return Exchange(told, messages, size)


def _receive(state: WorldState, parcels: list[Parcel], told: list[Told]) -> list[Parcel]:
    """Take in what arrived; returns what asks for an answer, and adds to `told`."""
    held = state.held
    asking: list[Parcel] = []
    for parcel in parcels:
        sender, receiver = parcel.sender, parcel.receiver
        if parcel.sent >= state.heard_step[receiver, sender]:
            state.heard_step[receiver, sender] = parcel.sent
            state.heard_cell[receiver, sender] = parcel.cell
            state.mail.news[receiver][sender] = parcel.held
        for origin, since, upto in parcel.scans:
            if since <= held[receiver, origin] < upto:
                held[receiver, origin] = upto
                told.append(Told(receiver, sender, origin, upto))
        if parcel.wants:
            asking.append(parcel)
    return asking


def _reports(state: WorldState, heard: NDArray[np.bool_]) -> list[Parcel]:
    """The reports of this step, by sender and receiver."""
    held = state.held.copy()
    due = state.step + state.problem.delay_steps
    reports: list[Parcel] = []
    for sender in range(state.n_robots):
        around = np.flatnonzero(heard[sender]).tolist()
        if not around:
            continue
        wants = _wants(state, state.mail, sender, around)
        own = int(held[sender, sender])
        # The mark is still set: nobody has moved since the look.
        scans = ((sender, own - 1, own),) if state.must_look[sender] else ()
        cell = int(state.cells[sender])
        for receiver in around:
            asks = tuple(wants.get(receiver, ()))
            reports.append(
                Parcel(due, state.step, sender, receiver, cell, held[sender], scans, asks)
            )
    return reports


def _wants(state: WorldState, mail: Mail, robot: int, around: list[int]) -> dict[int, list[int]]:
    """Whose scans it asks for now, by whom it asks; takes note of that."""
    news = [(other, mail.news[robot][other]) for other in around if other in mail.news[robot]]
    if not news:
        return {}
    offers = np.stack([held for _, held in news])
    most = offers.max(axis=0)
    waiting = state.step - mail.asked[robot] <= 2 * state.problem.delay_steps
    wants: dict[int, list[int]] = {}
    for origin in np.flatnonzero((most > state.held[robot]) & ~waiting).tolist():
        mail.asked[robot, origin] = state.step
        wants.setdefault(news[int(np.argmax(offers[:, origin]))][0], []).append(origin)
    return wants


def _answers(state: WorldState, heard: NDArray[np.bool_], asked: list[Parcel]) -> list[Parcel]:
    """The scans that were asked for, to those in reach, as far as they are here."""
    due = state.step + state.problem.delay_steps
    answers: list[Parcel] = []
    for parcel in asked:
        robot, other = parcel.receiver, parcel.sender
        held = state.held[robot].copy()
        scans = tuple(
            (origin, int(parcel.held[origin]), int(held[origin]))
            for origin in parcel.wants
            if held[origin] > parcel.held[origin]
        )
        if scans and heard[robot, other]:
            cell = int(state.cells[robot])
            answers.append(Parcel(due, state.step, robot, other, cell, held, scans))
    return answers


def _kept(state: WorldState, parcels: list[Parcel], kind: int) -> list[Parcel]:
    """The parcels that are not lost."""
    problem = state.problem
    if problem.loss == 0.0:
        return parcels
    return [
        parcel
        for parcel in parcels
        if not is_lost(
            problem.seed, problem.loss, state.step, 0, parcel.sender, parcel.receiver, kind
        )
    ]


def _size(state: WorldState, parcel: Parcel) -> int:
    """The bytes of a parcel beyond those of a report: scans, and 4 for each origin it asks for."""
    size = 4 * len(parcel.wants)
    for origin, since, upto in parcel.scans:
        size += sum(scan_bytes(len(scan.seen)) for scan in state.scans[origin][since:upto])
    return size
