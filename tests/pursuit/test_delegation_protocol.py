"""The delegation protocol: tables, single members under any events, teams under any order."""

from collections import Counter
from itertools import product
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
from conav.pursuit.delegation_protocol import (
    Came,
    Event,
    Heard,
    Joined,
    Late,
    Member,
    Needs,
    PartEnded,
    Quoted,
    Released,
    Sent,
    Stuck,
    TakesPart,
    step,
)
from conav.pursuit.delegation_tables import (
    ASKING,
    HELPING,
    ROLES,
    Asking,
    Helping,
    IllegalEvent,
    follow,
    protocol_table,
)

REQUEST = Request((1.0, 2.0), (((0.0, 0.0), (1.0, 0.0)),), 60.0)


def play(me: Member, *events: Event) -> tuple[Member, Sent]:
    sent: Sent = ()
    for event in events:
        me, sent = step(me, event)
    return me, sent


def heard(sender: int, body: Body) -> Heard:
    return Heard(sender, body)


# --- the tables -----------------------------------------------------------------------------------


def test_every_state_and_event_is_defined_or_rejected() -> None:
    for table, states in ((ASKING, Asking), (HELPING, Helping), (ROLES, Role)):
        events = {event for _, event in table}
        for state, event in product(states, events):
            if (state, event) in table:
                assert follow(table, state, event) in set(states)  # type: ignore[arg-type]
            else:
                with pytest.raises(IllegalEvent):
                    follow(table, state, event)  # type: ignore[arg-type]
        assert {state for state, _ in table} == set(states)  # nobody stays anywhere for ever
        assert {*table.values()} == set(states)  # and every state is come to
    assert protocol_table().count("\n") == 1 + len(ASKING) + len(HELPING) + len(ROLES)


def test_numbers_are_the_papers() -> None:
    assert [str(state)[0] for state in Asking] == list("012345678")


# --- by hand --------------------------------------------------------------------------------------

EXPLORER = Member(0, frozenset({1, 2, 3}), role=Role.EXPLORER)


def asked_for(*roles: Role) -> tuple[Member, Sent]:
    """Member 0 is stuck, and 1, 2 and 3 have told these roles."""
    answers = [heard(i, TellRole(0, 1, role)) for i, role in enumerate(roles, 1)]
    return play(EXPLORER, Stuck(REQUEST), *answers)


def test_who_is_stuck_asks_for_roles() -> None:
    me, sent = play(EXPLORER, Stuck(REQUEST))
    assert (me.role, me.asking) == (Role.STUCK, Asking.ROLES)
    assert sent == tuple((i, AskRole(0, 1)) for i in (1, 2, 3))


@pytest.mark.parametrize(
    ("roles", "state", "whom"),
    [
        ((Role.GUARD, Role.IDLE, Role.STUCK), Asking.IDLES, [2]),
        ((Role.GUARD, Role.EXPLORER, Role.GUARD), Asking.GUARDS, [1, 3]),
        ((Role.STUCK, Role.EXPLORER, Role.STUCK), Asking.WAITING, []),
        ((Role.STUCK, Role.STUCK, Role.STUCK), Asking.STUCKS, [1, 2, 3]),
    ],
)
def test_the_least_committed_are_asked(
    roles: tuple[Role, ...], state: Asking, whom: list[int]
) -> None:
    me, sent = asked_for(*roles)
    assert me.asking is state
    assert sent == tuple((i, AskHelp(0, 1, REQUEST)) for i in whom)


def test_the_best_offer_is_taken() -> None:
    me, _ = asked_for(Role.IDLE, Role.IDLE, Role.IDLE)
    me, sent = play(
        me,
        heard(1, Bid(0, 1, 3.0, 2.0)),
        heard(3, Bid(0, 1, 9.0, 0.0)),
        heard(2, Bid(0, 1, 8.0, 0.0)),
    )
    assert (me.asking, me.helper) == (Asking.HELPED, 2)
    assert sent == ((2, Award(0, 1)), (1, Nack(0, 1)), (3, Nack(0, 1)))
    me, _ = play(me, heard(2, EndOfTask(0, 1)))
    assert (me.asking, me.role) == (Asking.WORKING, Role.EXPLORER)


def test_refusals_go_on_to_the_next() -> None:
    """Idle refuse, guards refuse, nobody explores, the stuck one refuses: one more is needed."""
    me, _ = asked_for(Role.IDLE, Role.GUARD, Role.STUCK)
    states = [me.asking]
    for i in (1, 2, 3):
        me, _ = play(me, heard(i, Refuse(0, 1)))
        states.append(me.asking)
    assert states == [Asking.IDLES, Asking.GUARDS, Asking.STUCKS, Asking.MORE]
    me, sent = play(me, Joined(4))
    assert me.asking is Asking.ROLES
    assert sent == tuple((i, AskRole(0, 2)) for i in (1, 2, 3, 4))


def test_waiting_ends_with_the_task_of_an_explorer() -> None:
    me, _ = asked_for(Role.STUCK, Role.EXPLORER, Role.GUARD)
    me, _ = play(me, heard(3, Refuse(0, 1)))
    assert me.asking is Asking.WAITING
    again, sent = play(me, heard(2, TaskEnded(0, 1)))
    assert (again.asking, again.round, len(sent)) == (Asking.ROLES, 2, 3)
    # So it does when the explorer is lost.
    again, sent = play(me, heard(1, Lost(1, 0, 2)))
    assert (again.asking, len(sent)) == (Asking.ROLES, 2)


def test_a_task_that_ends_meanwhile_is_not_missed() -> None:
    me, _ = asked_for(Role.STUCK, Role.EXPLORER, Role.GUARD)
    me, sent = play(me, heard(2, TaskEnded(0, 1)), heard(3, Refuse(0, 1)))
    assert me.asking is Asking.ROLES
    assert len(sent) == 3


def test_an_explorer_tells_whoever_counts_on_it() -> None:
    me, sent = play(EXPLORER, heard(2, AskRole(2, 5)))
    assert sent == ((2, TellRole(2, 5, Role.EXPLORER)),)
    for event in (PartEnded(), Stuck(REQUEST)):
        _, sent = play(me, event)
        assert sent[0] == (2, TaskEnded(2, 5))


def test_alone_one_more_is_needed_at_once() -> None:
    me, sent = play(Member(0, frozenset(), role=Role.EXPLORER), Stuck(REQUEST))
    assert (me.asking, sent) == (Asking.MORE, ())


def test_silence_is_refusal() -> None:
    me, _ = play(EXPLORER, Stuck(REQUEST), heard(2, TellRole(0, 1, Role.IDLE)), Late())
    assert me.asking is Asking.IDLES
    me, _ = play(me, Late())
    assert me.asking is Asking.MORE
    with pytest.raises(IllegalEvent):
        step(me, Late())


def test_the_helper() -> None:
    me = Member(2, frozenset({0, 1}))
    me, sent = play(me, heard(0, AskHelp(0, 1, REQUEST)))
    assert (me.helping, sent) == (Helping.ASKED, ())
    # Who is asked already refuses others.
    _, sent = play(me, heard(1, AskHelp(1, 4, REQUEST)))
    assert sent == ((1, Refuse(1, 4)),)
    refused, sent = play(me, Quoted(None))
    assert (refused.helping, sent) == (Helping.FREE, ((0, Refuse(0, 1)),))
    me, sent = play(me, Quoted((5.0, 0.0)))
    assert sent == ((0, Bid(0, 1, 5.0, 0.0)),)
    assert play(me, heard(0, Nack(0, 1)))[0].helping is Helping.FREE
    me, _ = play(me, heard(0, Award(0, 1)))
    assert (me.helping, me.role) == (Helping.COMING, Role.IDLE)
    me, sent = play(me, Came())
    assert (me.helping, me.role) == (Helping.FREE, Role.GUARD)
    assert sent == ((0, EndOfTask(0, 1)),)
    assert play(me, Released())[0].role is Role.IDLE


def test_a_stuck_helper_gives_up_its_own_request() -> None:
    me, _ = play(
        Member(2, frozenset({0, 1}), role=Role.EXPLORER),
        Stuck(REQUEST),
        heard(0, TellRole(2, 1, Role.STUCK)),
        heard(1, TellRole(2, 1, Role.STUCK)),
        heard(1, Bid(2, 1, 3.0, 0.0)),
        heard(0, AskHelp(0, 7, REQUEST)),
        Quoted((1.0, 0.0)),
    )
    assert me.asking is Asking.STUCKS
    me, sent = play(me, heard(0, Award(0, 7)))
    assert (me.asking, me.role, me.helping) == (Asking.WORKING, Role.IDLE, Helping.COMING)
    assert sent == ((1, Nack(2, 1)),)
    # An offer that comes now is declined.
    assert play(me, heard(0, Bid(2, 1, 1.0, 0.0)))[1] == ((0, Nack(2, 1)),)


def test_of_two_who_ask_the_lower_number_is_helped() -> None:
    asking, _ = play(EXPLORER, Stuck(REQUEST))
    _, sent = play(asking, heard(1, AskHelp(1, 1, REQUEST)))
    assert sent == ((1, Refuse(1, 1)),)
    other, _ = play(Member(3, frozenset({0, 1, 2}), role=Role.EXPLORER), Stuck(REQUEST))
    assert play(other, heard(1, AskHelp(1, 1, REQUEST)))[0].helping is Helping.ASKED


def test_needs_change() -> None:
    me, _ = asked_for(Role.STUCK, Role.EXPLORER, Role.EXPLORER)
    later = Request((3.0, 2.0), (), 90.0)
    me, sent = play(me, Needs(later))
    assert (me.asking, sent) == (Asking.WAITING, ())
    me, _ = play(me, heard(2, TaskEnded(0, 1)))
    _, sent = play(me, *(heard(i, TellRole(0, 2, Role.IDLE)) for i in (1, 2, 3)))
    assert sent[0] == (1, AskHelp(0, 2, later))
    me, _ = play(me, Needs(None))
    assert (me.asking, me.role) == (Asking.WORKING, Role.IDLE)
    for need in (None, later):
        with pytest.raises(IllegalEvent):
            step(me, Needs(need))


def test_losses() -> None:
    helped, _ = asked_for(Role.IDLE, Role.GUARD, Role.STUCK)
    helped, _ = play(helped, heard(1, Bid(0, 1, 1.0, 0.0)))
    again, sent = play(helped, heard(2, Lost(2, 0, 1)))
    assert (again.asking, again.team) == (Asking.ROLES, frozenset({2, 3}))
    assert len(sent) == 2
    client, _ = play(Member(1, frozenset({0, 2})), heard(0, AskHelp(0, 1, REQUEST)))
    for me in (client, play(client, Quoted((1.0, 0.0)))[0]):
        alone, _ = play(me, heard(2, Lost(2, 0, 0)))
        assert alone.helping is Helping.FREE
        # What it had said before comes too late.
        assert play(alone, heard(0, AskHelp(0, 1, REQUEST))) == (alone, ())


def test_sizes() -> None:
    assert AskHelp(0, 1, REQUEST).size_bytes == 64
    assert AskRole(0, 1).size_bytes == 8
    assert TellRole(0, 1, Role.IDLE).size_bytes == 9
    assert Bid(0, 1, 1.0, 2.0).size_bytes == 24
    assert Lost(0, 0, 1).size_bytes == 12


# --- any events -----------------------------------------------------------------------------------


def any_event(random: Random, round_: int) -> Event:
    owner, number = random.randrange(4), random.choice([round_, round_, 1, 0])
    bodies: list[Body] = [
        AskRole(owner, number),
        TellRole(owner, number, random.choice(list(Role))),
        AskHelp(owner, number, REQUEST),
        Bid(owner, number, random.random(), random.random()),
        Refuse(owner, number),
        Award(owner, number),
        Nack(owner, number),
        EndOfTask(owner, number),
        TaskEnded(owner, number),
        Lost(owner, 0, random.randrange(4)),
    ]
    events: list[Event] = [
        TakesPart(),
        PartEnded(),
        Stuck(REQUEST),
        Needs(random.choice([None, REQUEST])),
        Quoted(random.choice([None, (1.0, 0.0)])),
        Came(),
        Released(),
        Joined(random.randrange(1, 5)),
        Late(),
        *(Heard(random.randrange(1, 4), random.choice(bodies)) for _ in range(12)),
    ]
    return random.choice(events)


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_any_event_is_followed_or_rejected(seed: int) -> None:
    random = Random(seed)
    me = Member(0, frozenset({1, 2, 3}))
    for _ in range(60):
        try:
            me, sent = step(me, any_event(random, me.round))
        except IllegalEvent:
            continue
        assert (me.role is Role.STUCK) == (me.asking is not Asking.WORKING)
        assert (me.helping is Helping.FREE) == (me.client is None)
        assert me.asking is not Asking.CHOICE  # it is left at once
        assert (me.helper is not None) == (me.asking is Asking.HELPED)
        assert me.awaited <= me.team
        assert len({receiver for receiver, _ in sent}) == len(sent) or len(sent) <= 2 * 4


# --- any order ------------------------------------------------------------------------------------


class Play:
    """A team whose messages come in any order, and to which anything happens at any time."""

    def __init__(self, random: Random, size: int, stucks: int, joins: int, losses: int) -> None:
        self.random = random
        self.members = {
            i: Member(i, frozenset(range(size)) - {i}, role=random.choice(list(Role)[:3]))
            for i in range(size)
        }
        self.mail: list[tuple[int, int, Body]] = []
        self.stucks, self.joins, self.losses = stucks, joins, losses
        self.per_round: Counter[tuple[int, int]] = Counter()
        self.ended = 0
        self.size = size

    def tell(self, i: int, event: Event) -> None:
        self.members[i], sent = step(self.members[i], event)
        for receiver, body in sent:
            self.mail.append((i, receiver, body))
            self.per_round[body.owner, body.round] += 1

    def choices(self) -> list[tuple[str, int]]:
        found = [("deliver", k) for k in range(len(self.mail))]
        for i, me in self.members.items():
            if me.helping is Helping.ASKED:
                found.append(("quote", i))
            if me.helping is Helping.COMING and me.role in (Role.IDLE, Role.GUARD):
                found.append(("come", i))
            if me.role is Role.EXPLORER:
                found.append(("end", i))
                if self.stucks > 0:
                    found.append(("stuck", i))
            if self.losses > 0 and len(self.members) > 1:
                found.append(("lose", i))
        if (
            not found
            and self.joins > 0
            and any(me.asking is Asking.MORE for me in self.members.values())
        ):
            found.append(("join", 0))
        return found

    def do(self, what: str, i: int) -> None:
        if what == "deliver":
            sender, receiver, body = self.mail.pop(i)
            if receiver in self.members:
                self.tell(receiver, Heard(sender, body))
        elif what == "quote":
            cost = (self.random.random(), 0.0) if self.random.random() < 0.5 else None
            self.tell(i, Quoted(cost))
        elif what == "come":
            self.tell(i, Came())
        elif what == "end":
            self.ended += 1
            self.tell(i, PartEnded())
        elif what == "stuck":
            self.stucks -= 1
            self.ended += 1
            self.tell(i, Stuck(REQUEST))
        elif what == "lose":
            self.losses -= 1
            self.ended += 1
            del self.members[i]
            for other in list(self.members):
                self.mail.append((other, other, Lost(other, 0, i)))
        elif what == "join":
            self.joins -= 1
            number, self.size = self.size, self.size + 1
            for other in list(self.members):
                self.tell(other, Joined(number))
            self.members[number] = Member(number, frozenset(self.members) - {number})


@settings(max_examples=150, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    size=st.integers(1, 6),
    stucks=st.integers(0, 6),
    joins=st.integers(0, 2),
    losses=st.integers(0, 2),
)
def test_teams_come_to_an_end(seed: int, size: int, stucks: int, joins: int, losses: int) -> None:
    """No loop, no deadlock, and O(n^2) messages a deliberation, whatever comes first."""
    random = Random(seed)
    play_ = Play(random, size, stucks, joins, losses)
    steps = 0
    while choices := play_.choices():
        play_.do(*random.choice(choices))
        steps += 1
        assert steps < 5000
    for me in play_.members.values():
        # Whoever still needs help has asked everybody, and nobody more may be sent.
        assert me.asking in (Asking.WORKING, Asking.MORE)
        assert me.asking is Asking.WORKING or play_.joins == 0
        assert me.helping is Helping.FREE
    n = play_.size
    rounds = Counter(owner for owner, number in play_.per_round if number > 0)
    for (_, number), count in play_.per_round.items():
        # Roles asked and told, help asked and answered, awarded or not, tasks' ends, one arrival.
        assert number == 0 or count <= 7 * (n - 1) + 1
    # A round of a deliberation follows a task's end, a loss, a joining, or a helper helped itself.
    assert sum(rounds.values()) <= stucks * (1 + play_.ended + n)
