"""Rectangles of the two-stage strategy: that of stage 1, and those in a section of stage 2."""

from conav.exploration.rectangle_drive import (
    CHOOSE,
    CLOSED,
    Path,
    Rectangle,
    coordinates,
    direction,
    extent,
    lanes,
    next_move,
    path_towards,
    rest_is_worth,
    unknown_within_known,
)
from conav.exploration.section_board import Status
from conav.exploration.two_stage_turn import LOOK_EVERY, Turn, side
from conav.exploration.two_stage_vote import candidate_among
from conav.exploration.types import Action


def drive(turn: Turn, rectangle: Rectangle) -> Action | None:
    """The next move of the rectangle, None when it is closed."""
    memory, view = turn.memory, turn.view
    wanted = next_move(rectangle, view)
    if wanted == CHOOSE:
        _choose_second(turn, rectangle)
        wanted = next_move(rectangle, view)
    look = rectangle.leg != memory.looked_leg or view.step % LOOK_EVERY == 0
    memory.looked_leg = rectangle.leg
    if wanted == CLOSED or (
        look and turn.settings.closing == "useful" and not rest_is_worth(rectangle, view)
    ):
        memory.rectangles += 1
        return None
    return turn.move(wanted)


# --- stage 1 --------------------------------------------------------------------------------------


def drive_first(turn: Turn) -> Action | None:
    """The next move of the rectangle of stage 1, None when the robot changes to stage 2."""
    memory, board, view = turn.memory, turn.board, turn.view
    rectangle = memory.rectangle
    assert rectangle is not None
    if rectangle.leg == 0 and not _explores_for(turn):
        memory.rectangle = None
        turn.tell(claims=[board.release(view.robot, view.step)])
        turn.go("no unknown area to explore")
        return None
    action = drive(turn, rectangle)
    if action is None:
        scanned = board.scan(*turn.swath())
        memory.rectangle = None
        turn.tell([scanned], [board.release(view.robot, view.step)])
        turn.go("trajectory closed")
    return action


def _explores_for(turn: Turn) -> bool:
    """Whether the first lane is not a lower robot's as well."""
    me = turn.board.claims[turn.view.robot]
    return not any(
        claim.robot < me.robot
        and claim.heading == me.heading
        and abs(claim.lower + claim.upper - me.lower - me.upper) <= 2 * turn.half
        for claim in turn.held()
    )


def _choose_second(turn: Turn, rectangle: Rectangle) -> None:
    """At the border: the temporary direction by entropy, among sides with unknown area."""
    board, view = turn.board, turn.view
    taken = [claim for claim in turn.held() if claim.robot != view.robot]
    sides = {
        direction(rectangle.axis, 0, way): lane
        for way, lane in board.lanes_beside(rectangle.first, turn.half, taken).items()
    }
    possible = [k for k in sides if view.belief.moves.item(view.cell) >> k & 1]
    if not possible:
        rectangle.second = rectangle.first
        return
    rectangle.second = sides[candidate_among(turn, possible)]
    me = board.claims[view.robot]
    claim = board.enter(
        view.robot, turn.swath(), Status.BEING_SCANNED, view.step, heading=me.heading
    )
    turn.tell(claims=[claim])


# --- stage 2, in a section ------------------------------------------------------------------------


def approach(turn: Turn) -> Action | None:
    """The next move to the first lane of the next rectangle, None when the phase has changed."""
    memory, board, view = turn.memory, turn.board, turn.view
    axis = board.axis
    _, across = coordinates(axis, view.cell, view.lattice.cols)
    claim = board.claims[view.robot]
    if (claim.lower, claim.upper) != memory.section:
        memory.goal_lane = None  # a part of it is somebody else's now
        memory.section = (claim.lower, claim.upper)
    while memory.goal_lane is None:
        pieces = board.unscanned(claim.lower, claim.upper)
        if not pieces:
            turn.tell(claims=[board.release(view.robot, view.step)])
            turn.go("width of the section is 0")
            return None
        lower, upper = min(
            pieces, key=lambda piece: min(abs(across - piece[0]), abs(across - piece[1]))
        )
        advance = side(across, lower, upper)
        first, second = (
            min(max(lane, 0), board.size - 1) for lane in lanes(lower, upper, advance, turn.half)
        )
        swath = min(first, second) - turn.half, max(first, second) + turn.half
        covers = max(swath[0], lower), min(swath[1], upper)
        if unknown_within_known(axis, *covers, view) == 0:
            turn.tell([board.scan(*covers)])
            continue
        memory.goal_lane, memory.piece, memory.path = (first, second, advance), covers, Path()
    first, second, advance = memory.goal_lane
    wanted = memory.path.next(view)
    if wanted < 0 and across != first:
        path = path_towards(axis, first, view)
        if path is not None:
            memory.path = path
            wanted = path.next(view)
        elif memory.piece[0] <= across <= memory.piece[1]:
            # An obstacle keeps it from the lane, not from the section.
            second = second if (second - across) * advance > 0 else across
            first = across
        else:
            # No rectangle can be driven here: left to the end.
            turn.tell([board.scan(*memory.piece)])
            memory.goal_lane = None
            return None
    if wanted >= 0 and across != first:
        return turn.move(wanted)
    _arrive(turn, first, second, advance)
    return None


def _arrive(turn: Turn, first: int, second: int, advance: int) -> None:
    memory, board, view = turn.memory, turn.board, turn.view
    axis = board.axis
    along, _ = coordinates(axis, view.cell, view.lattice.cols)
    size, _ = extent(axis, view.lattice)
    # A lane driven to and fro is shorter by way of the nearer border.
    heading = 1 if size - 1 - along < along else -1
    memory.rectangle = Rectangle(axis, heading, first, second, along)
    memory.goal_lane = None
    claim = board.claims[view.robot]
    turn.tell(
        claims=[
            board.enter(
                view.robot, (claim.lower, claim.upper), Status.BEING_SCANNED, view.step,
                advance=advance, begun=1,
            )
        ]
    )  # fmt: skip
    turn.go("arrived")


def scan_section(turn: Turn) -> Action | None:
    """The next move of a rectangle in a section, None when it is closed."""
    memory, board, view = turn.memory, turn.board, turn.view
    rectangle = memory.rectangle
    assert rectangle is not None
    claim = board.claims[view.robot]
    if claim.begun < 2 and not claim.lower <= (rectangle.second or 0) <= claim.upper:
        rectangle.second = rectangle.first  # somebody else was given the second lane
    action = drive(turn, rectangle)
    if action is None:
        scanned = board.scan(*turn.swath())
        memory.rectangle = None
        turn.tell([scanned])
        turn.go("trajectory closed")
    elif rectangle.leg > 0 and claim.begun < 2:
        section = claim.lower, claim.upper
        claim = board.enter(
            view.robot, section, claim.status, view.step, advance=claim.advance, begun=2
        )
        turn.tell(claims=[claim])
    return action
