"""Whether one pursuer can clear a floor without holes.

Within a critical cell the pursuer's windows hang on the same vertices, and on a floor without holes
each window hides one shadow. So a state is a cell and a bit for each of its windows [Guibas1999].
What crossing from cell to cell does to them depends on the event alone:

- Two reflex vertices w and v touched by the line, w going out of sight behind v: the windows of
  both become that of v, contaminated if one of them was; on the way back both take over its bit.
- A wall from w to v going out of sight behind v. If w is reflex too, the window of w becomes that
  of v. Else a window appears, clear; on the way back it disappears.

Where lines meet in a point a pursuer may stand on that point and see more than from any cell beside
it; so it may on a line that touches three vertices. Such places are searched too. There the search
keeps only windows that are there for sure, and takes bits along only where one event tells how; so
the pursuer can do more than it truly can. A floor that cannot be cleared thus cannot be cleared;
ways that rest on such places have to be tried.
"""

import heapq
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.geometry.critical_cells import CriticalCells, critical_cells
from conav.geometry.triangulation import triangulate
from conav.maps.polygon_map import PolygonMap, without_collinear_points
from conav.pursuit.shadow_moves import Point

MOST_EVENTS = 2000  # there are more cells by far
_SURELY = 1e-9  # of the floor's size: the width of cells that a rounded point lies in for sure

Gaps = tuple[int, ...]


@dataclass(frozen=True)
class Decision:
    """Whether one pursuer may be able to clear a floor, and how.

    `suffices` is False where it is proved that none can, None where nothing was found out in time.
    Else `way` leads through the cells that the search went through; unless `exact`, the search let
    the pursuer do more than it can, so it may not clear the floor.
    """

    suffices: bool | None
    way: tuple[Point, ...]
    exact: bool
    states: int


@dataclass(frozen=True)
class _Step:
    """A way from one place to the next, through a point; which old windows each new one takes."""

    to: int
    through: Point
    sources: tuple[int, ...]  # per window of the next place, bits of windows of this one

    def apply(self, bits: int) -> int:
        after = 0
        for number, source in enumerate(self.sources):
            if source & bits:
                after |= 1 << number
        return after


def decide_one_pursuer(floor: PolygonMap, most_states: int = 50_000) -> Decision:
    """Whether one pursuer can clear the floor; not found out for floors with holes.

    `most_states` ends the search.
    """
    if floor.holes:
        return Decision(None, (), True, 0)
    plain = without_collinear_points(floor)
    mesh = triangulate(plain.vertices, plain.ring_starts)
    cells = critical_cells(mesh, MOST_EVENTS)
    if cells is None:
        # No line beyond a reflex vertex: there is none, and everything is seen from everywhere.
        convex = not (plain.turns < 0).any()
        return Decision(True if convex else None, (), True, 0)
    size = float(np.ptp(plain.vertices, axis=0).max())
    if (cells.widths <= _SURELY * size).any():
        return Decision(None, (), True, 0)
    places = _Places(cells, plain.turns)
    return places.search(most_states)


class _Places:
    """Cells, and the lines and points on which a pursuer may see more than beside them."""

    def __init__(self, cells: CriticalCells, turns: NDArray[np.int8]) -> None:
        self.cells = cells
        starts, gaps = cells.starts.tolist(), cells.gaps.tolist()
        self.gaps: list[Gaps] = [tuple(gaps[begin:end]) for begin, end in pairwise(starts)]
        self.points: list[Point] = [(x, y) for x, y in cells.points.tolist()]
        self.steps: list[list[_Step]] = [[] for _ in self.gaps]
        self.exact = True
        events = cells.events.tolist()
        self.events: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for (w, v), chord in zip(events, cells.chord_of.tolist(), strict=True):
            self.events[chord].append((w, v))
        self.walls = {(w, v) for w, v in events if abs(w - v) in (1, len(turns) - 1)}
        self.reflex = (turns < 0).tolist()
        self._join_cells()
        self._add_points()

    def _join_cells(self) -> None:
        cells = self.cells
        ends = cells.node_points[cells.nodes[: 2 * len(cells.left)]]
        middles = ((ends[::2] + ends[1::2]) / 2.0).tolist()
        rows = zip(cells.left.tolist(), cells.right.tolist(), cells.chords.tolist(), strict=True)
        for (one, other, chord), (x, y) in zip(rows, middles, strict=True):
            sources = self._sources(chord, self.gaps[one], self.gaps[other])
            if sources is not None:
                self.steps[one].append(_Step(other, (x, y), sources[0]))
                self.steps[other].append(_Step(one, (x, y), sources[1]))
            if sources is None or not any(self._sees_all(side, [chord]) for side in (one, other)):
                self._add_place((x, y), [one, other], [chord])

    def _sources(
        self, chord: int, one: Gaps, other: Gaps
    ) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Which windows take the bits of which when the pursuer crosses a chord, there and back.

        None where windows come and go that the chord's events do not account for.
        """
        tails = {w for w, _ in self.events[chord]}
        head = self.events[chord][0][1]
        walls = {w for w, v in self.events[chord] if (w, v) in self.walls}
        if any(v != head for _, v in self.events[chord]) or (
            walls and head in one and head in other
        ):
            # A chord between two vertices, with events behind both; or a window hangs on the end of
            # a wall on both sides of its line, on different walls.
            return None
        if set(other) - set(one) - {head} or (head in one and head not in other):
            back = self._crossed(tails, head, other, one)
            return None if back is None else (back[1], back[0])
        return self._crossed(tails, head, one, other)

    @staticmethod
    def _crossed(
        tails: set[int], head: int, one: Gaps, other: Gaps
    ) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """As `_sources`, from the side where the tails are in sight."""
        hidden, shown = set(one) - set(other), set(other) - set(one)
        if not (hidden <= tails | {head} and shown <= {head}):
            return None
        forth = {gap: [gap] for gap in other if gap in one}
        back = {gap: [gap] for gap in one if gap in other}
        if head in other:
            forth.setdefault(head, []).extend(sorted(hidden & tails))
            back.update({tail: [head] for tail in hidden & tails})
        elif hidden & tails:
            return None
        return _bits(forth, one, other), _bits(back, other, one)

    def _sees_all(self, cell: int, chords: Iterable[int]) -> bool:
        """Whether a cell is on the side of all events of these chords where nothing is hidden."""
        gaps = self.gaps[cell]
        return all(
            (w in gaps or not self.reflex[w]) and ((w, v) not in self.walls or v not in gaps)
            for chord in chords
            for w, v in self.events[chord]
        )

    def _add_points(self) -> None:
        """Points where chords meet of which no cell beside sees all that can be seen there."""
        cells = self.cells
        around: dict[int, set[int]] = defaultdict(set)
        meeting: dict[int, set[int]] = defaultdict(set)
        for node, cell in zip(cells.nodes.tolist(), cells.cells.tolist(), strict=True):
            around[node].add(cell)
        for h, node in enumerate(cells.nodes[: 2 * len(cells.left)].tolist()):
            meeting[node].add(int(cells.chords[h // 2]))
        for node, chords in meeting.items():
            if len(chords) > 1 and not any(self._sees_all(one, chords) for one in around[node]):
                x, y = cells.node_points[node].tolist()
                self._add_place((x, y), sorted(around[node]), sorted(chords))

    def _add_place(self, point: Point, beside: list[int], chords: list[int]) -> None:
        """A place on lines, from which the pursuer goes to cells beside it and back."""
        self.exact = False
        everywhere = set(self.gaps[beside[0]]).intersection(*(self.gaps[c] for c in beside[1:]))
        somewhere = {gap for cell in beside for gap in self.gaps[cell]}
        behind: dict[int, set[int]] = defaultdict(set)  # the heads of each tail
        for chord in chords:
            for w, v in self.events[chord]:
                behind[w].add(v)
        on_walls = {v for w, heads in behind.items() for v in heads if (w, v) in self.walls}
        kept = (everywhere | (somewhere & behind.keys())) - on_walls
        here, gaps = len(self.gaps), tuple(sorted(kept))
        self.gaps.append(gaps)
        self.points.append(point)
        self.steps.append([])
        for cell in dict.fromkeys(beside):
            there = self.gaps[cell]
            back = {gap: [gap] for gap in gaps if gap in there}
            forth = {gap: [gap] for gap in there if gap in kept}
            for w in kept - set(there):
                if len(behind[w]) == 1:
                    (v,) = behind[w]
                    if v in there:
                        forth.setdefault(v, []).append(w)
                        back[w] = [v]
            self.steps[here].append(_Step(cell, point, _bits(forth, gaps, there)))
            self.steps[cell].append(_Step(here, point, _bits(back, there, gaps)))

    def search(self, most_states: int) -> Decision:
        """From the first cell, all windows contaminated; states with few contaminated first."""
        full = (1 << len(self.gaps[0])) - 1
        waiting: list[tuple[int, int, int, int]] = [(full.bit_count(), 0, 0, full)]
        parents: list[tuple[int, int, Point]] = [(-1, 0, self.points[0])]
        reached: list[list[int]] = [[] for _ in self.gaps]
        states = 0
        while waiting:
            _, state, place, bits = heapq.heappop(waiting)
            if bits == 0:
                return Decision(True, self._way(parents, state), self.exact, states)
            if any(known & bits == known for known in reached[place]):
                continue
            reached[place] = [known for known in reached[place] if known & bits != bits]
            reached[place].append(bits)
            states += 1
            if states > most_states:
                return Decision(None, (), self.exact, states)
            for step in self.steps[place]:
                after = step.apply(bits)
                if not any(known & after == known for known in reached[step.to]):
                    parents.append((state, step.to, step.through))
                    heapq.heappush(waiting, (after.bit_count(), len(parents) - 1, step.to, after))
        return Decision(False, (), True, states)

    def _way(self, parents: list[tuple[int, int, Point]], state: int) -> tuple[Point, ...]:
        way: list[Point] = []
        while state >= 0:
            state, place, through = parents[state]
            for point in (self.points[place], through):
                if not way or way[-1] != point:
                    way.append(point)
        return tuple(way[::-1])


def _bits(sources: dict[int, list[int]], old: Gaps, new: Gaps) -> tuple[int, ...]:
    """Per new window the old ones it takes its bit from, as bits."""
    number = {gap: 1 << i for i, gap in enumerate(old)}
    return tuple(sum(number[gap] for gap in sources.get(new_gap, ())) for new_gap in new)
