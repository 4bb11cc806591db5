"""The end of the two-stage strategy: what obstacles hid, and robots that no section is left for."""

from collections.abc import Sequence

import numpy as np

from conav.exploration.belief import TARGET
from conav.exploration.nearest import NearestMemory, choose_nearest, keeps_goal
from conav.exploration.section_board import Claim
from conav.exploration.two_stage_turn import LOOK_EVERY, STAY, Turn
from conav.exploration.types import Action
from conav.geometry.grid_search import path_to, search, search_space


def finish_frontiers(turn: Turn) -> Action | None:
    """The next move to the nearest frontier outside others' sections, None when one is on offer."""
    memory, board, view = turn.memory, turn.board, turn.view
    if board.changes != memory.tried:
        memory.tried = board.changes
        if turn.offer(1):
            turn.go("section on offer")
            return None
    rest = memory.rest
    taken = [claim for claim in turn.held() if claim.robot != view.robot]
    if bool(taken) != memory.rest_masked:
        memory.rest_masked = bool(taken)
        memory.rest = rest = NearestMemory()
    if not taken:
        if not keeps_goal(rest, view):
            choose_nearest(rest, view)
    elif rest.goal < 0 or not keeps_goal(rest, view):
        if rest.goal < 0 and view.step - memory.rest_at < LOOK_EVERY:
            return STAY
        memory.rest_at = view.step
        _choose_outside(turn, rest, taken)
        if rest.goal < 0:
            return STAY
    if rest.goal < 0:
        return Action(finished=True)
    return Action(int(rest.path[rest.left - 1]), rest.goal)


def _choose_outside(turn: Turn, rest: NearestMemory, taken: Sequence[Claim]) -> None:
    """Set the nearest frontier that is in nobody's section, or none."""
    view = turn.view
    wanted = np.asarray(view.belief.marks & TARGET, dtype=np.uint8)
    strips = wanted if turn.board.axis == 1 else wanted.T
    for claim in taken:
        strips[claim.lower : claim.upper + 1] = 0
    space = search_space(wanted.size)
    rest.goal = search(view.belief.moves, view.cell, wanted, TARGET, space)
    rest.looks_for, rest.beside = -1, False
    if rest.goal >= 0:
        rest.here = view.cell
        rest.path, rest.left = path_to(space, view.lattice.cols, rest.goal)
