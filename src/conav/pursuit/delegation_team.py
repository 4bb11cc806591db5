"""A team that clears a known floor by delegation: each member its own mind, one world for all.

Members talk at barriers, when nobody drives, so what they merge is of one moment.
"""

from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from conav.messages.message import Message
from conav.pursuit.beliefs import hidden_now
from conav.pursuit.delegation_holdings import Holdings, Task
from conav.pursuit.delegation_messages import Body, Lost, Request, Role
from conav.pursuit.delegation_protocol import (
    Came,
    Event,
    Heard,
    Joined,
    Member,
    Needs,
    PartEnded,
    Quoted,
    Released,
    Stuck,
    TakesPart,
    step,
)
from conav.pursuit.delegation_tables import Asking, Helping
from conav.pursuit.rounds import Rounds
from conav.pursuit.shadow_moves import Point
from conav.pursuit.shadow_parts import ShadowParts
from conav.pursuit.types import HiddenRegion

_SLACK = 1e-9  # [m] and [s]


@dataclass(kw_only=True)
class Team(Holdings):
    """Members, where they are, and what their guards hold."""

    parts: ShadowParts
    rounds: Rounds
    deaths: Mapping[int, float]  # [s] of who is lost when
    patience_s: float  # how long after its request help must have come
    members: list[Member] = field(default_factory=list[Member])
    at: list[int] = field(default_factory=list[int])  # places of the graph
    driven: list[float] = field(default_factory=list[float])  # [m]
    calls: dict[int, deque[int]] = field(default_factory=dict[int, deque[int]])  # ways of helpers
    offers: dict[int, int] = field(default_factory=dict[int, int])  # where who offered would stand
    mail: deque[tuple[int, int, Body]] = field(default_factory=deque[tuple[int, int, Body]])
    said: Counter[str] = field(default_factory=Counter[str])
    in_round: Counter[tuple[int, int]] = field(default_factory=Counter[tuple[int, int]])
    beliefs: dict[int, tuple[HiddenRegion, ...]] = field(
        default_factory=dict[int, tuple[HiddenRegion, ...]]
    )
    history: list[dict[str, object]] = field(default_factory=list[dict[str, object]])

    # --- who there is -----------------------------------------------------------------------------

    def add_member(self) -> None:
        """The last pursuer of the rounds becomes a member; the others are told."""
        number = len(self.members)
        others = frozenset(self.living())
        self.members.append(Member(number, others))
        self.at.append(self.graph.points.index(self.rounds.places[number]))
        self.driven.append(0.0)
        for other in sorted(others):
            self.tell(other, Joined(number))

    def living(self) -> list[int]:
        """Who is not lost."""
        return [i for i in range(len(self.members)) if self.rounds.present[i]]

    def free(self) -> list[int]:
        """Who could take a part."""
        return [
            i
            for i in self.living()
            if self.members[i].role is Role.IDLE and self.members[i].helping is Helping.FREE
        ]

    def left_m(self, i: int) -> float:
        """How far a pursuer can still drive [m]."""
        reach = self.rounds.pursuers[i].reach_m
        return float("inf") if reach is None else reach - self.driven[i]

    # --- what is said -----------------------------------------------------------------------------

    def tell(self, i: int, event: Event) -> None:
        """Lets an event happen to a member, and sends what it says."""
        self.members[i], sent = step(self.members[i], event)
        for receiver, body in sent:
            self.send(i, receiver, body)
        if self.members[i].role is Role.IDLE:
            self.tasks.pop(i, None)
        if self.members[i].helping is not Helping.COMING:
            self.calls.pop(i, None)  # whoever called may be lost

    def send(self, sender: int, receiver: int, body: Body) -> None:
        self.mail.append((sender, receiver, body))
        self.said["messages"] += 1
        self.said["bytes"] += Message(sender, receiver, self.rounds.now, body).size_bytes
        self.in_round[body.owner, body.round] += 1

    def talk(self) -> None:
        """Until nobody has anything to say or to answer, and nobody called is there already."""
        while True:
            while self.mail:
                sender, i, body = self.mail.popleft()
                if not self.rounds.present[i]:
                    continue
                before = self.members[i]
                self.tell(i, Heard(sender, body))
                me = self.members[i]
                if me.helping is Helping.ASKED and before.helping is not Helping.ASKED:
                    self.tell(i, Quoted(self.quote(i)))
                if me.helping is Helping.COMING and before.helping is not Helping.COMING:
                    self._call(i)
                if before.asking is Asking.HELPED and me.asking is Asking.WORKING:
                    self._note("helped", i)
                    self.tell(i, PartEnded())  # what is left of its part is there to be taken
            if not self._settle():
                return

    def _call(self, i: int) -> None:
        place = self.offers.pop(i)
        self.calls[i] = deque(self.graph.way(self.at[i], place)[1:])
        self._note("comes", i)

    def _note(self, what: str, i: int, **more: object) -> None:
        name = self.rounds.pursuers[i].name
        self.said[what] += 1
        self.history.append({"time_s": self.rounds.now, "what": what, "pursuer": name, **more})

    # --- who holds what ---------------------------------------------------------------------------

    def release(self) -> None:
        """Guards go whose leaving contaminates nothing."""
        for i in sorted(self.standing):
            if self.members[i].helping is not Helping.FREE:
                continue
            rest = self.can_leave(i)
            if rest is not None:
                self.stand(rest)
                self.tell(i, Released())
                self._note("released", i)

    # --- what help costs --------------------------------------------------------------------------

    def request(self, shadows: int, entry: int) -> Request:
        """The help who is stuck in these shadows asks for."""
        part = self.part(shadows)
        post = self.parts.post(part, entry)
        windows = self.guards.windows(self.posts(), shadows, self.graph.points[post])
        deadline = self.rounds.now + self.patience_s
        return Request(self.graph.points[post], windows, deadline)

    def quote(self, i: int) -> tuple[float, float] | None:
        """What help would cost a pursuer: metres, and square metres contaminated again.

        None where it would come late or empty, and for a guard where something clear would be
        contaminated.
        """
        request = self.members[i].asked
        assert request is not None
        if i in self.standing:
            # While others are under way guards stay, as these count on them; one goes at a time.
            if any(task.way for task in self.tasks.values()) or self.guard_goes(i):
                return None
            found = self.second_post(i)
        else:
            place = self.graph.points.index(request.post)
            found = (float(self.graph.distances[self.at[i], place]), 0.0, place)
        if found is None:
            return None
        distance, area, place = found
        arrives = self.rounds.now + distance / self.rounds.pursuers[i].speed_mps
        if distance >= self.left_m(i) - _SLACK or arrives > request.deadline_s + _SLACK:
            return None
        self.offers[i] = place
        return distance, area

    def guard_goes(self, but: int | None = None) -> bool:
        """Whether a guard, another than this, has offered to leave its post, or is leaving it."""
        return any(i != but and self.members[i].helping is not Helping.FREE for i in self.standing)

    # --- a round ----------------------------------------------------------------------------------

    def movers(self) -> dict[int, int]:
        """Who drives next, and to which place."""
        ways: list[tuple[int, deque[int]]] = [(i, task.way) for i, task in self.tasks.items()]
        return {i: way[0] for i, way in sorted([*ways, *self.calls.items()]) if way}

    def drive(self) -> None:
        """A round; who is to be lost during it is lost on the way."""
        moves = self.movers()
        ends = {i: self.graph.points[place] for i, place in moves.items()}
        lost: list[int] = []
        while True:
            lasts = self.rounds.lasts(ends)
            due = [(t, i) for i, t in self.deaths.items() if i < len(self.members)]
            due = [
                (t, i) for t, i in due if self.rounds.present[i] and t <= self.rounds.now + lasts
            ]
            if not due:
                break
            t, i = min(due)
            share = min(max(t - self.rounds.now, 0.0) / lasts, 1.0) if lasts > 0.0 else 1.0
            now = {
                j: _between(self.rounds.places[j], end, share) if share < 1.0 else end
                for j, end in ends.items()
            }
            self.rounds.drive(now, max(t - self.rounds.now, 0.0))
            self.rounds.lose(i)
            lost.append(i)
            ends = {j: end for j, end in ends.items() if j != i}
        if ends and self.rounds.lasts(ends) > 0.0:
            self.rounds.drive(ends)
        for i in lost:
            self._bury(i)  # before what others did counts: it did not see to the end
        for i in sorted(set(moves) - set(lost)):
            self._arrive(i, moves[i])
        self._settle()
        for i in self.living():
            if self.left_m(i) <= _SLACK:
                self.rounds.lose(i)
                self._bury(i)
        self._believe()
        self._renew()

    def _renew(self) -> None:
        """Who is stuck asks, from now on, for what it needs now."""
        for i, task in sorted(self.tasks.items()):
            me = self.members[i]
            if me.role is not Role.STUCK:
                continue
            if task.shadows:
                places = self.parts.places(self.part(task.shadows))
                entry = min(places, key=lambda q: (self.graph.distances[self.at[i], q], q))
                self.tell(i, Needs(self.request(task.shadows, entry)))
            elif me.asking is not Asking.HELPED:
                self.tell(i, Needs(None))  # others see all of it

    def _arrive(self, i: int, place: int) -> None:
        """A member is at the next place of its way."""
        self.driven[i] += float(self.graph.lengths[self.at[i], place])
        for way in (self.calls.get(i), self.tasks[i].way if i in self.tasks else None):
            if way and way[0] == place:
                way.popleft()
        if i in self.standing:
            self.change_post(i, place)
            self._note("serves both", i)
        self.at[i] = place

    def _settle(self) -> bool:
        """Helpers that came stand, parts whose way is done are clear; whether anything was so."""
        done = False
        for i in [i for i, way in self.calls.items() if not way]:
            del self.calls[i]
            if self.members[i].helping is Helping.COMING:
                self.stand({**self.standing, i: self.at[i]})
                self.tell(i, Came())
                self._note("holds", i)
                done = True
        for i in sorted(self.tasks):
            task = self.tasks[i]
            if not task.way and self.members[i].role is Role.EXPLORER:
                self.dirty &= ~task.shadows
                self.tell(i, PartEnded())
                self._note("cleared", i)
                done = True
        self.release()
        return done

    def _bury(self, i: int) -> None:
        """Who was lost holds nothing any more; the lowest that lives tells the others."""
        self._note("lost", i)
        area = self.guards.area(self.posts(), self.dirty)
        sizes = {j: self.guards.area(self.posts(), task.shadows) for j, task in self.tasks.items()}
        self.tasks.pop(i, None)
        self.calls.pop(i, None)
        if i in self.standing:
            self.stand({j: place for j, place in self.standing.items() if j != i})
        self.history[-1]["recontaminated_m2"] = self.guards.area(self.posts(), self.dirty) - area
        living = self.living()
        if living:
            body = Lost(living[0], 0, i)
            for other in living[1:]:
                self.send(living[0], other, body)
            self.tell(living[0], Heard(living[0], body))
        for j, task in list(self.tasks.items()):
            # Whose part grew counted on who was lost; its own part is to be taken again.
            grown = self.guards.area(self.posts(), task.shadows) > sizes[j] + self.slack_m2()
            if grown and self.members[j].role is Role.EXPLORER:
                self.tell(j, PartEnded())

    def _believe(self) -> None:
        leg = len(self.rounds.active) - 1
        if leg >= 0:
            self.beliefs[leg] = hidden_now(self.guards.shadows, self.posts(), self.dirty)

    # --- who takes what ---------------------------------------------------------------------------

    def take(self, i: int, shadow: int) -> bool:
        """A member begins to clear a shadow, and is stuck where it cannot; whether it began.

        It does not where it could with more energy than it has left.
        """
        places = self.parts.places(self.part(1 << shadow))
        entry = min(places, key=lambda place: (self.graph.distances[self.at[i], place], place))
        moves = self.parts.swept(self.part(1 << shadow), entry)
        way = self.graph.way(self.at[i], entry)[1:]
        reach = self.rounds.pursuers[i].reach_m
        if moves is not None:
            way += [move.end for move in moves]
            length = sum(
                float(self.graph.lengths[a, b])
                for a, b in zip([self.at[i], *way], way, strict=False)
            )
            if length > self.left_m(i) + _SLACK:
                if reach is not None and length <= reach and self.driven[i] > 0.0:
                    return False  # one that drove less could
                moves = None
        self.tell(i, TakesPart())
        self.tasks[i] = Task(1 << shadow, deque(way if moves is not None else ()))
        if moves is None:
            self._note("stuck", i)
            self.tell(i, Stuck(self.request(1 << shadow, entry)))
        else:
            self._note("explores", i)
        return True

    def offered(self, shadows: Sequence[int]) -> list[tuple[float, int, int]]:
        """Free members and shadows they could take: metres to drive there, member, shadow."""
        found: list[tuple[float, int, int]] = []
        for i in self.free():
            for shadow in shadows:
                places = self.parts.places(self.part(1 << shadow))
                nearest = min(float(self.graph.distances[self.at[i], place]) for place in places)
                found.append((nearest, i, shadow))
        return sorted(found)


def _between(a: Point, b: Point, share: float) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
