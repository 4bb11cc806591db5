"""How robots of the two-stage strategy talk in an auction of sections."""

from collections.abc import Sequence

from conav.exploration.nearest import NearestMemory
from conav.exploration.rectangle_drive import coordinates
from conav.exploration.section_auction import (
    Announce,
    Award,
    Bid,
    Bidding,
    IllegalMessage,
    Interval,
    Selling,
    best_bid,
)
from conav.exploration.section_board import Claim, Status
from conav.exploration.two_stage_flow import Phase
from conav.exploration.two_stage_turn import STAY, Turn, side
from conav.exploration.types import Action

# --- as a bidder ----------------------------------------------------------------------------------


def wait_for_award(turn: Turn) -> Action:
    """Join the auction and stand still until it is over."""
    memory, view = turn.memory, turn.view
    bidder = memory.bidder
    if bidder.state is not Bidding.IDLE:
        waited_s = (view.step - bidder.since_step) * view.time_s / max(view.step, 1)
        if view.step - bidder.since_step > 3 and waited_s > 2 * turn.settings.auction_wait_s:
            bidder.leave()
    if bidder.state is Bidding.IDLE:
        leader = min(turn.near)
        join = bidder.join(leader, view.step)
        if leader == view.robot:
            try:
                memory.auctioneer.join(leader, view.time_s)
            except IllegalMessage:
                memory.refused += 1
        else:
            turn.send([leader], join)
    return STAY


def answer(turn: Turn, sender: int, body: Announce) -> None:
    """Bid for one of the sections on offer."""
    bid = _bid(turn, body.sections)  # before anything changes: none may be on offer
    turn.memory.bidder.announced(sender, turn.view.step)
    turn.send([sender], bid)


def hear_award(turn: Turn, sender: int, body: Award) -> None:
    """Take what the auctioneer awards."""
    turn.memory.bidder.awarded(sender, turn.view.step)
    _awarded(turn, body.section)


def _bid(turn: Turn, sections: Sequence[Interval]) -> Bid:
    _, across = coordinates(turn.board.axis, turn.view.cell, turn.view.lattice.cols)
    widths = [turn.board.width(*section) for section in sections]
    bid = best_bid(sections, widths, across)
    if bid is None:
        raise IllegalMessage("nothing is on offer")
    return bid


def _awarded(turn: Turn, section: Interval | None) -> None:
    memory = turn.memory
    if memory.phase is not Phase.AUCTION:
        return
    claim = turn.board.claims.get(turn.view.robot)
    if section is None or claim is None or (claim.lower, claim.upper) != section:
        memory.tried = turn.board.changes
        memory.rest, memory.rest_at = NearestMemory(), -1
        turn.go("no section left")
    else:
        memory.goal_lane = None
        turn.go("section awarded")


# --- as an auctioneer -----------------------------------------------------------------------------


def run_auction(turn: Turn) -> None:
    """Sell when the period is over and when the bids are there."""
    memory, view = turn.memory, turn.view
    auctioneer = memory.auctioneer
    if memory.board is None:
        return
    if (
        auctioneer.state is Selling.OPEN
        and view.time_s >= auctioneer.opened_s + turn.settings.auction_wait_s - 1e-9
    ):
        _announce(turn)
    late = auctioneer.state is Selling.SELLING and memory.announced_step < view.step
    while auctioneer.complete() or (late and auctioneer.state is Selling.SELLING):
        late = False
        if auctioneer.bids:
            _award(turn)
            _announce(turn)
        else:
            auctioneer.close(view.time_s)


def _announce(turn: Turn) -> None:
    memory, view = turn.memory, turn.view
    auctioneer = memory.auctioneer
    sections = turn.offer(len(auctioneer.bidders)) if auctioneer.bidders else []
    memory.offered = {(item.lower, item.upper): item.robot for item in sections}
    announce = auctioneer.announce(list(memory.offered))
    memory.announced_step = view.step
    if not announce.sections:
        for robot in auctioneer.close(view.time_s):
            _give(turn, robot, None)
        return
    turn.send([robot for robot in auctioneer.bidders if robot != view.robot], announce)
    if view.robot in auctioneer.bidders:
        memory.bidder.announced(view.robot, view.step)
        auctioneer.bid(view.robot, _bid(turn, announce.sections))


def _award(turn: Turn) -> None:
    memory, board, view = turn.memory, turn.board, turn.view
    winner, section = memory.auctioneer.sell()
    memory.auctions += 1
    _, across = coordinates(board.axis, int(view.heard_cell[winner]), view.lattice.cols)
    claims = [
        board.enter(
            winner, section, Status.TO_BE_SCANNED, view.step, advance=side(across, *section)
        )
    ]
    holder = memory.offered[section]
    if holder >= 0:
        claims.append(_keep_rest(turn, board.claims[holder], section))
    turn.tell(claims=claims)
    _give(turn, winner, section)


def _keep_rest(turn: Turn, old: Claim, sold: Interval) -> Claim:
    """The entry of the one who had a section: it keeps the half that was not sold."""
    keeps = (
        (old.lower, sold[0] - 1)
        if old.upper == sold[1] or old.lower < sold[0]
        else (sold[1] + 1, old.upper)
    )
    return turn.board.enter(
        old.robot, keeps, old.status, turn.view.step, advance=old.advance, begun=old.begun
    )


def _give(turn: Turn, robot: int, section: Interval | None) -> None:
    if robot != turn.view.robot:
        turn.send([robot], Award(section))
    elif turn.memory.bidder.state is not Bidding.IDLE:
        turn.memory.bidder.awarded(robot, turn.view.step)
        _awarded(turn, section)
