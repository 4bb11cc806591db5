"""Splitting a floor by guards until each part can be swept by one pursuer.

[Pellier2005], SplitEnvironment and Algorithm 2 on a known floor: one pursuer tries a part alone;
where it cannot, a guard is posted, and the parts beyond it are tried in turn. What a part is, how
it is tried and where guards stand is a `Parts` object.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from conav.pursuit.known_map import Move
from conav.pursuit.navigation_graph import NavigationGraph

P = TypeVar("P")


@dataclass(frozen=True)
class Sweep:
    """One pursuer goes to `entry` and makes these drives; the part is clear then."""

    entry: int
    moves: tuple[Move, ...]
    standing: tuple[int, ...]  # where guards stand meanwhile


@dataclass(frozen=True)
class Guarded:
    """A guard stands at `post` until all parts beyond it are clear."""

    post: int
    parts: tuple["Plan", ...]


Plan = Sweep | Guarded


class Parts(Protocol[P]):
    """What parts of a floor are; places are numbers of a navigation graph."""

    def places(self, part: P) -> Sequence[int]: ...

    def standing(self, part: P) -> tuple[int, ...]: ...

    def swept(self, part: P, entry: int) -> tuple[Move, ...] | None: ...

    def post(self, part: P, entry: int) -> int: ...

    def beyond(self, part: P, post: int) -> list[P]: ...


def split(graph: NavigationGraph, parts: Parts[P], part: P, near: int) -> Plan:
    """A plan for a part; it is entered at its place nearest to `near`.

    It ends when each guard makes what is left of a part smaller.
    """
    places = parts.places(part)
    entry = near
    if near not in places and len(places) > 0:
        entry = min(places, key=lambda place: (graph.distances[near, place], place))
    moves = parts.swept(part, entry)
    if moves is not None:
        return Sweep(entry, moves, parts.standing(part))
    post = parts.post(part, entry)
    return Guarded(post, tuple(split(graph, parts, one, post) for one in parts.beyond(part, post)))


def in_sequence(plan: Plan) -> int:
    """How many pursuers a plan takes when parts are cleared one after the other."""
    if isinstance(plan, Sweep):
        return 1
    return 1 + max((in_sequence(part) for part in plan.parts), default=0)


def in_parallel(plan: Plan) -> int:
    """How many pursuers a plan takes when all parts are cleared at the same time."""
    if isinstance(plan, Sweep):
        return 1
    return 1 + sum(in_parallel(part) for part in plan.parts)


def sweeps(plan: Plan) -> Iterator[Sweep]:
    """All sweeps of a plan, in order."""
    if isinstance(plan, Sweep):
        yield plan
    else:
        for part in plan.parts:
            yield from sweeps(part)


def posts(plan: Plan) -> Iterator[int]:
    """Where guards stand, in the order in which they are posted."""
    if isinstance(plan, Guarded):
        yield plan.post
        for part in plan.parts:
            yield from posts(part)
