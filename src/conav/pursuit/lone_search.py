"""One searcher clears a part of a floor while guards stand.

Guards part the floor: an evader never leaves its component of what they do not see. So each
component can be cleared by itself, the others being as they were. A state is where the searcher
stands and which of its and the guards' shadows inside the component may hold somebody. The searcher
may be put down at any place from which it sees some of the component: all of it is contaminated
in the beginning, so what happens on its way there does not matter.
"""

import heapq
from dataclasses import dataclass

from conav.pursuit.roadmap import Roadmap
from conav.pursuit.shadow_moves import ShadowMoves, Team

NOBODY = -1


@dataclass(frozen=True)
class Component:
    """What guards do not see: one of their shadows, by number."""

    guards: Team  # by number of their viewpoints
    shadow: int
    area: float  # [m^2]


def components(moves: ShadowMoves, guards: Team) -> list[Component]:
    """The shadows of guards."""
    areas = moves.numbered_shadows(guards).areas.tolist()
    return [Component(guards, shadow, area) for shadow, area in enumerate(areas)]


def left_of(moves: ShadowMoves, part: Component, number: int) -> tuple[int, float]:
    """The shadows left of a contaminated component with somebody at a viewpoint; their area [m^2].

    As bits, of guards and viewpoint together.
    """
    guards = part.guards
    areas = moves.numbered_shadows(tuple(sorted({*guards, number}))).areas
    if guards:
        bits = moves.links(guards, guards[0], number).apply(1 << part.shadow)[0]
    else:
        bits = (1 << len(areas)) - 1
    return bits, area_of(bits, areas.tolist())


def area_of(bits: int, areas: list[float]) -> float:
    """Of these shadows together [m^2]."""
    return sum(area for shadow, area in enumerate(areas) if bits >> shadow & 1)


@dataclass(frozen=True)
class Alone:
    """What a search found: places by number, None where it ended or there are none."""

    way: list[int] | None
    exhausted: bool  # whether every state was looked at
    expanded: int


def search_alone(
    moves: ShadowMoves,
    roadmap: Roadmap,
    numbers: list[int],
    part: Component,
    *,
    weight: float,
    most: int,
    windows: int,
) -> Alone:
    """Places through which a searcher that begins at the first of them clears a component.

    `numbers` are the viewpoints of places; `most` states are expanded,
    `windows` of views laid over each other (`ShadowMoves.windows`). States are taken by metres
    driven plus `weight` times the square root of the contaminated area [m].
    """
    waiting: list[tuple[float, int, float, int, int]] = []
    parents: list[tuple[int, int]] = []
    useful: dict[int, bool] = {}
    best: dict[int, list[int]] = {}

    def push(parent: int, place: int, cost: float, dirty: int) -> None:
        if any(bits & dirty == bits for bits in best.setdefault(place, [])):
            return
        team = tuple(sorted({*part.guards, numbers[place]}))
        area = area_of(dirty, moves.numbered_shadows(team).areas.tolist())
        parents.append((parent, place))
        rank = cost + weight * max(area, 0.0) ** 0.5
        heapq.heappush(waiting, (rank, len(parents) - 1, cost, place, dirty))

    for place, number in enumerate(numbers):
        bits, area = left_of(moves, part, number)
        useful[place] = area < part.area * (1.0 - 1e-9)
        if useful[place] or bits == 0:
            push(NOBODY, place, 0.0, bits)
    expanded = 0
    last = moves.windows + windows
    while waiting:
        _, state, cost, place, dirty = heapq.heappop(waiting)
        known = best[place]
        if any(bits & dirty == bits for bits in known):
            continue
        known[:] = [bits for bits in known if bits & dirty != dirty]
        known.append(dirty)
        if dirty == 0:
            way: list[int] = []
            while state != NOBODY:
                state, place = parents[state]
                way.append(place)
            return Alone(way[::-1], False, expanded)
        if expanded >= most or moves.windows >= last:
            return Alone(None, False, expanded)
        expanded += 1
        for end in roadmap.joined[place].tolist():
            if useful[end]:
                after = moves.numbered_after(part.guards, numbers[place], numbers[end], dirty)
                push(state, end, cost + float(roadmap.lengths[place, end]), after)
    return Alone(None, True, expanded)
