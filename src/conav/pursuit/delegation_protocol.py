"""One pursuer's side of the delegation protocol: a pure function of its state and an event.

It does no input or output and knows no geometry: what help costs is told by the event `Quoted`.
Who is stuck asks for roles, and then asks, in this order, idle pursuers, guards, and, when nobody
explores any more, stuck ones; then for one more pursuer. Whoever is asked answers at once, so
nobody waits in a circle. Of two that deliberate at the same time the one with the lower number may
be helped by the other.
"""

from dataclasses import dataclass, replace

from conav.pursuit.delegation_messages import (
    AskHelp,
    AskRole,
    Award,
    Bid,
    Body,
    EndOfTask,
    Lost,
    Nack,
    Refuse,
    Request,
    Role,
    TaskEnded,
    TellRole,
)
from conav.pursuit.delegation_tables import (
    ASKING,
    HELPING,
    ROLES,
    Asking,
    Helping,
    IllegalEvent,
    follow,
)

Sent = tuple[tuple[int, Body], ...]  # receiver and what it is told

_BUSY = (Asking.ROLES, Asking.IDLES, Asking.GUARDS, Asking.STUCKS)


@dataclass(frozen=True)
class Member:
    """All that a pursuer keeps of the protocol."""

    number: int
    team: frozenset[int]  # the others, as far as it knows
    role: Role = Role.IDLE
    asking: Asking = Asking.WORKING
    helping: Helping = Helping.FREE
    request: Request | None = None  # its own
    round: int = 0  # of its own deliberations
    awaited: frozenset[int] = frozenset()  # who owes it an answer
    roles: tuple[tuple[int, Role], ...] = ()  # told in this round
    tried: frozenset[Role] = frozenset()  # asked for help in this round
    bids: tuple[tuple[int, Bid], ...] = ()
    helper: int | None = None
    news: bool = False  # whether a task ended since roles were collected
    client: tuple[int, int] | None = None  # whom it helps, and in which round
    asked: Request | None = None  # what it is asked for
    callers: tuple[tuple[int, int], ...] = ()  # who counts on its task's end, and their round


@dataclass(frozen=True)
class TakesPart:
    """It begins to clear a part."""


@dataclass(frozen=True)
class PartEnded:
    """The part it took is clear, or was taken from it."""


@dataclass(frozen=True)
class Stuck:
    """It cannot clear its part alone, and needs this."""

    request: Request


@dataclass(frozen=True)
class Needs:
    """What it needs has changed since it was stuck, or is needed later; None for nothing more."""

    request: Request | None


@dataclass(frozen=True)
class Heard:
    """A message came."""

    sender: int
    body: Body


@dataclass(frozen=True)
class Quoted:
    """What the help it is asked for would cost; None where it cannot help."""

    cost: tuple[float, float] | None  # [m] to drive, [m^2] contaminated again


@dataclass(frozen=True)
class Came:
    """It is where it was called to."""


@dataclass(frozen=True)
class Released:
    """Nobody needs it as a guard any more."""


@dataclass(frozen=True)
class Joined:
    """One more pursuer is in the team."""

    pursuer: int


@dataclass(frozen=True)
class Late:
    """Whoever has not answered will not."""


Event = TakesPart | PartEnded | Stuck | Needs | Heard | Quoted | Came | Released | Joined | Late


def step(me: Member, event: Event) -> tuple[Member, Sent]:
    """The pursuer after an event, and what it says.

    Raises `IllegalEvent` for an event that its state has no transition for. Answers to what it no
    longer asks are no error: offers are declined, the rest is dropped.
    """
    match event:
        case TakesPart():
            return replace(me, role=follow(ROLES, me.role, "takes a part")), ()
        case PartEnded():
            role = follow(ROLES, me.role, "part ended")
            return replace(me, role=role, callers=()), _told_callers(me)
        case Stuck():
            role = follow(ROLES, me.role, "stuck")
            asking = follow(ASKING, me.asking, "stuck")
            told = _told_callers(me)
            me = replace(me, role=role, asking=asking, request=event.request, callers=())
            me, sent = _ask_roles(me)
            return me, told + sent
        case Needs():
            if event.request is None:
                return _give_up(me)
            if me.role is not Role.STUCK:
                raise IllegalEvent(f"who is {me.role!s} needs nothing")
            return replace(me, request=event.request), ()
        case Heard():
            return _hear(me, event.sender, event.body)
        case Quoted():
            return _quote(me, event.cost)
        case Came():
            helping = follow(HELPING, me.helping, "came")
            role = follow(ROLES, me.role, "came")
            assert me.client is not None
            sent = ((me.client[0], EndOfTask(*me.client)),)
            return replace(me, helping=helping, role=role, client=None, asked=None), sent
        case Released():
            return replace(me, role=follow(ROLES, me.role, "released")), ()
        case Joined():
            me = replace(me, team=me.team | {event.pursuer})
            if me.asking is not Asking.MORE:
                return me, ()
            return _ask_roles(replace(me, asking=follow(ASKING, me.asking, "a pursuer joined")))
        case Late():
            if me.asking not in _BUSY:
                raise IllegalEvent(f"{me.asking!s} waits for no answers")
            return _answered(replace(me, awaited=frozenset()))


def _hear(me: Member, sender: int, body: Body) -> tuple[Member, Sent]:
    if sender not in me.team and not isinstance(body, Lost):
        return me, ()  # it was lost after it spoke
    mine = body.owner == me.number and body.round == me.round
    match body:
        case AskRole():
            if me.role is Role.EXPLORER:
                me = replace(me, callers=(*me.callers, (sender, body.round)))
            return me, ((sender, TellRole(body.owner, body.round, me.role)),)
        case TellRole():
            if not mine or me.asking is not Asking.ROLES or sender not in me.awaited:
                return me, ()
            roles = (*me.roles, (sender, body.role))
            return _answered(replace(me, roles=roles, awaited=me.awaited - {sender}))
        case AskHelp():
            return _asked(me, sender, body)
        case Bid() | Refuse():
            return _offer(me, sender, body, mine)
        case Award():
            return _awarded(me, sender, body)
        case Nack():
            if me.helping is not Helping.OFFERED or me.client != (body.owner, body.round):
                return me, ()
            helping = follow(HELPING, me.helping, "offer not taken")
            return replace(me, helping=helping, client=None, asked=None), ()
        case EndOfTask():
            if not mine or me.asking is not Asking.HELPED or sender != me.helper:
                return me, ()
            role = follow(ROLES, me.role, "helper came")
            asking = follow(ASKING, me.asking, "helper came")
            return replace(me, role=role, asking=asking, request=None, helper=None), ()
        case TaskEnded():
            if me.asking is Asking.WAITING:
                return _new_round(me, "a task ended")
            return replace(me, news=me.news or mine), ()
        case Lost():
            return _gone(me, body.pursuer)
        case _:
            raise IllegalEvent(f"nobody says {type(body).__name__}")


# --- the assisted pursuer, Figure 6 ---------------------------------------------------------------


def _ask_roles(me: Member) -> tuple[Member, Sent]:
    """State 1 is entered."""
    me = replace(
        me,
        round=me.round + 1,
        awaited=me.team,
        roles=(),
        tried=frozenset(),
        bids=(),
        helper=None,
        news=False,
    )
    if not me.team:
        return _answered(me)
    return me, tuple((other, AskRole(me.number, me.round)) for other in sorted(me.team))


def _new_round(me: Member, event: str) -> tuple[Member, Sent]:
    return _ask_roles(replace(me, asking=follow(ASKING, me.asking, event)))


def _answered(me: Member) -> tuple[Member, Sent]:
    """Goes on where nobody owes an answer any more."""
    if me.awaited:
        return me, ()
    if me.asking is Asking.ROLES:
        return _choose(replace(me, asking=follow(ASKING, me.asking, "all roles told")))
    if not me.bids:
        return _choose(replace(me, asking=follow(ASKING, me.asking, "all refused")))
    # What is contaminated again must be cleared again, so it counts before the way.
    best = min(me.bids, key=lambda one: (one[1].recontaminated_m2, one[1].distance_m, one[0]))[0]
    sent: list[tuple[int, Body]] = [(best, Award(me.number, me.round))]
    sent += [(who, Nack(me.number, me.round)) for who, _ in me.bids if who != best]
    asking = follow(ASKING, me.asking, "best offer taken")
    return replace(me, asking=asking, bids=(), helper=best), tuple(sent)


def _choose(me: Member) -> tuple[Member, Sent]:
    """State 2: the least committed that were not asked yet in this round."""
    having = {role: [who for who, one in me.roles if one is role] for role in Role}
    if having[Role.IDLE] and Role.IDLE not in me.tried:
        return _ask_help(me, "some are idle", Role.IDLE, having[Role.IDLE])
    if having[Role.GUARD] and Role.GUARD not in me.tried:
        return _ask_help(me, "some are guards", Role.GUARD, having[Role.GUARD])
    if me.news:
        return _new_round(me, "a task ended")
    if having[Role.EXPLORER]:
        return replace(me, asking=follow(ASKING, me.asking, "some explore")), ()
    if having[Role.STUCK] and Role.STUCK not in me.tried:
        return _ask_help(me, "others are stuck", Role.STUCK, having[Role.STUCK])
    return replace(me, asking=follow(ASKING, me.asking, "nobody is left to ask")), ()


def _ask_help(me: Member, event: str, role: Role, whom: list[int]) -> tuple[Member, Sent]:
    asking = follow(ASKING, me.asking, event)
    me = replace(me, asking=asking, tried=me.tried | {role}, awaited=frozenset(whom), bids=())
    assert me.request is not None
    body = AskHelp(me.number, me.round, me.request)
    return me, tuple((who, body) for who in sorted(whom))


def _offer(me: Member, sender: int, body: Bid | Refuse, mine: bool) -> tuple[Member, Sent]:
    if mine and me.asking is Asking.HELPED and sender == me.helper and isinstance(body, Refuse):
        return _new_round(me, "helper is gone")
    expected = me.asking in _BUSY and me.asking is not Asking.ROLES
    if not (mine and expected and sender in me.awaited):
        declined = ((sender, Nack(body.owner, body.round)),) if isinstance(body, Bid) else ()
        return me, declined
    bids = (*me.bids, (sender, body)) if isinstance(body, Bid) else me.bids
    return _answered(replace(me, bids=bids, awaited=me.awaited - {sender}))


def _give_up(me: Member) -> tuple[Member, Sent]:
    """Ends its own deliberation and declines what it was offered."""
    sent = tuple((who, Nack(me.number, me.round)) for who, _ in me.bids)
    asking = follow(ASKING, me.asking, "gives up")
    role = follow(ROLES, me.role, "gives up")
    me = replace(me, asking=asking, role=role, request=None, awaited=frozenset(), bids=(), roles=())
    return me, sent


# --- the assistant pursuer, Figure 7 --------------------------------------------------------------


def _asked(me: Member, sender: int, body: AskHelp) -> tuple[Member, Sent]:
    busy = (
        me.helping is not Helping.FREE
        or me.role is Role.EXPLORER
        or me.asking is Asking.HELPED
        or (me.asking in _BUSY and me.number < sender)
    )
    if busy:
        return me, ((sender, Refuse(body.owner, body.round)),)
    helping = follow(HELPING, me.helping, "asked for help")
    return replace(me, helping=helping, client=(sender, body.round), asked=body.request), ()


def _quote(me: Member, cost: tuple[float, float] | None) -> tuple[Member, Sent]:
    if cost is None:
        helping = follow(HELPING, me.helping, "cannot help")
        assert me.client is not None
        sent = ((me.client[0], Refuse(*me.client)),)
        return replace(me, helping=helping, client=None, asked=None), sent
    helping = follow(HELPING, me.helping, "can help")
    assert me.client is not None
    return replace(me, helping=helping), ((me.client[0], Bid(*me.client, *cost)),)


def _awarded(me: Member, sender: int, body: Award) -> tuple[Member, Sent]:
    if me.helping is not Helping.OFFERED or me.client != (body.owner, body.round):
        return me, ((sender, Refuse(body.owner, body.round)),)
    if me.asking is Asking.HELPED or me.role is Role.EXPLORER:
        # It was helped itself in the meantime.
        helping = follow(HELPING, me.helping, "offer not taken")
        me = replace(me, helping=helping, client=None, asked=None)
        return me, ((sender, Refuse(body.owner, body.round)),)
    sent: Sent = ()
    if me.role is Role.STUCK:
        me, sent = _give_up(me)
    return replace(me, helping=follow(HELPING, me.helping, "offer taken")), sent


# --- both -----------------------------------------------------------------------------------------


def _told_callers(me: Member) -> Sent:
    known = [one for one in dict.fromkeys(me.callers) if one[0] in me.team]
    return tuple((who, TaskEnded(who, number)) for who, number in known)


def _gone(me: Member, pursuer: int) -> tuple[Member, Sent]:
    """A teammate was lost: it answers nothing, helps nobody and needs nothing."""
    if pursuer not in me.team:
        return me, ()
    news = me.news or (pursuer, Role.EXPLORER) in me.roles
    me = replace(
        me,
        team=me.team - {pursuer},
        roles=tuple(one for one in me.roles if one[0] != pursuer),
        bids=tuple(one for one in me.bids if one[0] != pursuer),
        callers=tuple(one for one in me.callers if one[0] != pursuer),
        news=news,
    )
    if me.client is not None and me.client[0] == pursuer:
        helping = follow(HELPING, me.helping, "asker is gone")
        me = replace(me, helping=helping, client=None, asked=None)
    if me.asking is Asking.HELPED and me.helper == pursuer:
        return _new_round(me, "helper is gone")
    if me.asking is Asking.WAITING and news:
        return _new_round(me, "a task ended")
    if me.asking in _BUSY and pursuer in me.awaited:
        return _answered(replace(me, awaited=me.awaited - {pursuer}))
    return me, ()
