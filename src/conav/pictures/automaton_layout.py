"""Where the states, arrows and labels of an automaton go, so that none covers another.

States stand in columns, the initial one to the left and each arrow that does not lead back going
to the right. Every arrow then has some ways to bend and some places for its label. What each way
costs by itself and each two together is tabulated, and ways are chosen so that no two arrows can
do better. Where something still covers something the drawing is made wider. All lengths are in
inches.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RADIUS = 0.24
"""Of a state."""
ENTRY = 0.5
"""Length of the arrow into the initial state."""

Points = NDArray[np.float64]  # (..., 2)

_GAP = 0.08  # between things that must not touch
_NEAR = 0.1  # between arrows that would look like one
_SAMPLES = 66  # points on an arrow
_COARSE = 5  # of which every so many are looked at where arrows are compared
_HEIGHTS = (0.0, 0.3, -0.3, 0.6, -0.6, 1.0, -1.0, 1.5, -1.5, 2.1, -2.1)
_SHARES = (0.5, 0.41, 0.59, 0.32, 0.68)
_LOOP_ANGLES = (90, 270, 60, 120, 240, 300, 0, 180)  # degrees
_LOOP_LENGTH = 0.36
_SWEEPS = 8
_LITTLE = 1e-9  # which no change is made for
_TRIES = 6
_GROWTH = 1.2

_FOOT = 0.13  # between the ends of two arrows at a state
_COVERED, _CROSSED, _ALONG, _TOGETHER, _BENT, _ASIDE = 50.0, 4.0, 14.0, 5.0, 1.2, 0.8  # how bad


@dataclass(frozen=True)
class Edge:
    """An arrow to be placed: from a state to another or itself, and how large its label is."""

    source: int
    target: int
    width: float
    height: float


@dataclass(frozen=True)
class Arrow:
    """An arrow that has its place."""

    points: Points
    """From the border of one state to that of the other."""
    label: tuple[float, float]
    """The middle of the label."""


@dataclass(frozen=True)
class Layout:
    """Places of states, (n_states, 2), and the arrows in the order of the edges."""

    states: Points
    arrows: tuple[Arrow, ...]
    clashes: int
    """Pairs of a label and a state, arrow or label, or an arrow and a state, that overlap."""


def lay_out(n_states: int, edges: Sequence[Edge]) -> Layout:
    """The layout with fewest clashes of those tried; state 0 is the initial one."""
    columns = _columns(n_states, edges)
    widest = max((edge.width for edge in edges if edge.source != edge.target), default=0.0)
    across = max(widest + 2 * RADIUS + 0.45, 1.4)
    tallest = max((edge.height for edge in edges), default=0.0)
    apart = RADIUS * 2 + _LOOP_LENGTH + tallest + 0.35
    best: Layout | None = None
    for _ in range(_TRIES):
        found = _placed(_states(columns, n_states, across, apart), edges)
        if best is None or found.clashes < best.clashes:
            best = found
        if best.clashes == 0:
            break
        across *= _GROWTH
        apart *= _GROWTH
    assert best is not None
    return best


def _columns(n_states: int, edges: Sequence[Edge]) -> list[list[int]]:
    """The states of each column from bottom to top."""
    reach = np.eye(n_states, dtype=np.bool_)
    for edge in edges:
        reach[edge.source, edge.target] = True
    for middle in range(n_states):
        reach |= reach[:, middle : middle + 1] & reach[middle]
    # A state reaches more than those it leads to, unless they lead back.
    order = sorted(range(n_states), key=lambda state: (-int(reach[state].sum()), state))
    rank = {state: i for i, state in enumerate(order)}
    column = [0] * n_states
    for state in order:
        for edge in edges:
            if edge.source == state and rank[edge.target] > rank[state]:
                column[edge.target] = max(column[edge.target], column[state] + 1)
    columns: list[list[int]] = [[] for _ in range(max(column, default=0) + 1)]
    for state in reversed(range(n_states)):  # the first on top
        columns[column[state]].append(state)
    links = [(edge.source, edge.target) for edge in edges if edge.source != edge.target]
    for _ in range(4):  # each next to the middle of its neighbours
        height = {s: i - (len(some) - 1) / 2 for some in columns for i, s in enumerate(some)}
        for some in columns:
            wanted: dict[int, float] = {}
            for state in some:
                beside = [height[q] for p, q in links if p == state and q not in some]
                beside += [height[p] for p, q in links if q == state and p not in some]
                wanted[state] = sum(beside) / len(beside) if beside else height[state]
            some.sort(key=lambda state: wanted[state])
            height |= {s: i - (len(some) - 1) / 2 for i, s in enumerate(some)}
    return columns


def _states(columns: list[list[int]], n_states: int, across: float, apart: float) -> Points:
    places = np.zeros((n_states, 2))
    for x, some in enumerate(columns):
        for i, state in enumerate(some):
            places[state] = (x * across, (i - (len(some) - 1) / 2) * apart)
    return places


class _Ways(NamedTuple):
    """The ways to draw an edge: curves, and for each where its label may be."""

    curves: Points  # (n_curves, _SAMPLES, 2)
    labels: Points  # (n_curves, n_labels, 2)
    badness: NDArray[np.float64]  # (n_curves, n_labels)
    half: Points  # (2,) of the label's width and height


def _placed(states: Points, edges: Sequence[Edge]) -> Layout:
    ways = [
        _loops(states, edge) if edge.source == edge.target else _bends(states, edge)
        for edge in edges
    ]
    entry = np.linspace(states[0] - (RADIUS + ENTRY, 0.0), states[0] - (RADIUS, 0.0), _SAMPLES)
    alone = [
        (way.badness + _COVERED * _in_the_way(states, entry, edge, way)).ravel()
        for edge, way in zip(edges, ways, strict=True)
    ]
    together: dict[tuple[int, int], NDArray[np.float64]] = {}
    for i in range(len(edges)):
        for j in range(i):
            together[i, j] = _pair(edges[i], ways[i], edges[j], ways[j])
            together[j, i] = together[i, j].T
    chosen = _choose(alone, together)
    arrows: list[Arrow] = []
    for way, which in zip(ways, chosen, strict=True):
        curve, label = divmod(which, way.labels.shape[1])
        x, y = way.labels[curve, label].tolist()
        arrows.append(Arrow(way.curves[curve], (x, y)))
    return Layout(states, tuple(arrows), clashes(states, edges, arrows))


def _choose(
    alone: list[NDArray[np.float64]], together: dict[tuple[int, int], NDArray[np.float64]]
) -> list[int]:
    """A way for each edge, such that no edge and no two edges can choose better by themselves.

    `alone[i][a]` is what way a of edge i costs, and `together[i, j][a, b]` what it costs besides
    where edge j takes way b.
    """
    n = len(alone)
    chosen = [int(costs.argmin()) for costs in alone]

    def costs_of(i: int, without: int) -> NDArray[np.float64]:
        costs = alone[i].copy()
        for j in range(n):
            if j not in (i, without):
                costs += together[i, j][:, chosen[j]]
        return costs

    for _ in range(_SWEEPS):
        before = list(chosen)
        for i in range(n):
            costs = costs_of(i, i)
            best = int(costs.argmin())
            if costs[best] < costs[chosen[i]] - _LITTLE:
                chosen[i] = best
        for i in range(n):
            for j in range(i):
                costs = costs_of(i, j)[:, None] + costs_of(j, i) + together[i, j]
                a, b = divmod(int(costs.argmin()), costs.shape[1])
                if costs[a, b] < costs[chosen[i], chosen[j]] - _LITTLE:
                    chosen[i], chosen[j] = a, b
        if chosen == before:
            break
    return chosen


def _bends(states: Points, edge: Edge) -> _Ways:
    """Straight, and bent more and more to either side."""
    start, end = states[edge.source], states[edge.target]
    along = (end - start) / np.hypot(*(end - start))
    side = np.array([-along[1], along[0]])
    t = np.linspace(0.0, 1.0, 1601)[:, None]
    curves: list[Points] = []
    labels: list[Points] = []
    for height in _HEIGHTS:
        control = (start + end) / 2 + 2 * height * side
        whole = (1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end
        free = (np.hypot(*(whole - start).T) >= RADIUS) & (np.hypot(*(whole - end).T) >= RADIUS)
        seen = whole[free]
        curves.append(seen[np.linspace(0, len(seen) - 1, _SAMPLES).astype(np.intp)])
        labels.append(seen[(np.array(_SHARES) * (len(seen) - 1)).astype(np.intp)])
    badness = _BENT * np.abs(_HEIGHTS)[:, None] + _ASIDE * np.abs(np.array(_SHARES) - 0.5)
    return _Ways(np.array(curves), np.array(labels), badness, _half(edge))


def _loops(states: Points, edge: Edge) -> _Ways:
    """On one side of the state or another, with the label beyond."""
    centre, half = states[edge.source], _half(edge)
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    spread = np.radians(28.0)
    curves: list[Points] = []
    labels: list[Points] = []
    for angle in np.radians(_LOOP_ANGLES):
        out = np.array([np.cos(angle), np.sin(angle)])
        side = np.array([-out[1], out[0]])
        feet = [centre + RADIUS * (np.cos(spread) * out + sign * np.sin(spread) * side)
                for sign in (1.0, -1.0)]  # fmt: skip
        a, d = feet
        b = a + 1.3 * _LOOP_LENGTH * out + 0.16 * side
        c = d + 1.3 * _LOOP_LENGTH * out - 0.16 * side
        curve = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
        far = float(((curve - centre) @ out).max())
        curves.append(curve)
        labels.append((centre + (far + float(np.abs(out) @ half) + 0.04) * out)[None])
    badness = 0.4 * np.arange(len(_LOOP_ANGLES), dtype=np.float64)[:, None]
    return _Ways(np.array(curves), np.array(labels), badness, half)


def _half(edge: Edge) -> Points:
    return np.array([edge.width, edge.height]) / 2


def _in_the_way(states: Points, entry: Points, edge: Edge, way: _Ways) -> NDArray[np.float64]:
    """How many states and whether the first arrow are covered, (n_curves, n_labels)."""
    others = np.delete(states, (edge.source, edge.target), axis=0)
    curves = _apart(way.curves[:, :, None], others).min(axis=1) < RADIUS + _GAP
    labels = _on_states(states, way.labels, way.half)
    first = _under(entry, way.labels, way.half)
    across = _apart(way.curves[:, :, None], entry).min(axis=(1, 2)) < _NEAR
    return (curves.sum(axis=1) + across)[:, None] + labels.sum(axis=-1) + first


def _pair(edge: Edge, way: _Ways, other: Edge, its: _Ways) -> NDArray[np.float64]:
    """How much two edges are in each other's way, for each way of the one and of the other."""
    own, others = way.curves[:, ::_COARSE], its.curves[:, ::_COARSE]
    gaps = own[:, None, :, None] - others[:, None]
    near = (gaps[..., 0] ** 2 + gaps[..., 1] ** 2).min(axis=-1) < _NEAR**2
    # Arrows of one state meet at it, which is no fault as long as their ends are apart.
    shared = len({edge.source, edge.target} & {other.source, other.target})
    along = np.maximum(near.sum(axis=-1) - 2 * shared, 0)
    feet = _apart(own[:, (0, -1)][:, None, :, None], others[:, (0, -1)][:, None]) < _FOOT
    curves = (
        _ALONG * along / own.shape[1]
        + _CROSSED * _crossings(own, others)
        + _TOGETHER * feet.sum(axis=(-1, -2))
    )  # (own curves, other curves)
    on = _under(its.curves[:, ::2], way.labels[:, :, None], way.half)
    under = _under(way.curves[:, ::2], its.labels[:, :, None], its.half)
    gaps = np.abs(way.labels[:, :, None, None] - its.labels)
    meet = (gaps < way.half + its.half + _GAP / 2).all(axis=-1)
    costs = (
        curves[:, None, :, None]
        + _COVERED * on[:, :, :, None]
        + _COVERED * under.transpose(2, 0, 1)[:, None]
        + 2 * _COVERED * meet
    )
    return costs.reshape(way.badness.size, its.badness.size)


def _crossings(own: Points, others: Points) -> NDArray[np.bool_]:
    """Which of the curves, (n, m, 2), cross which of the others, (k, m, 2): shape (n, k)."""
    left = _left(own[:, None], others)  # (n, k, m - 1, m)
    right = _left(others, own[:, None])
    parted = left[..., 1:] != left[..., :-1]  # others' segments by the lines of own ones
    return (parted & (right[..., 1:] != right[..., :-1]).swapaxes(-1, -2)).any(axis=(-1, -2))


def _left(curve: Points, points: Points) -> NDArray[np.bool_]:
    """Whether each point, (..., k, 2), is left of the line of each segment, (..., m - 1, k)."""
    x, y = curve[..., :-1, None, 0], curve[..., :-1, None, 1]
    along_x, along_y = np.diff(curve[..., 0])[..., None], np.diff(curve[..., 1])[..., None]
    beyond_x, beyond_y = points[..., None, :, 0] - x, points[..., None, :, 1] - y
    return along_x * beyond_y > along_y * beyond_x


def clashes(states: Points, edges: Sequence[Edge], arrows: Sequence[Arrow]) -> int:
    """Pairs of a label and a state, arrow or label, or an arrow and a state, that overlap."""
    count = 0
    for i, (edge, arrow) in enumerate(zip(edges, arrows, strict=True)):
        others = np.delete(states, (edge.source, edge.target), axis=0)
        label, half = np.array(arrow.label), _half(edge)
        count += int((_apart(arrow.points[:, None], others) < RADIUS).any(axis=0).sum())
        count += int(_on_states(states, label, half).sum())
        for j, (other, placed) in enumerate(zip(edges, arrows, strict=True)):
            if i != j:
                count += bool(_under(placed.points, label, half))
            if i < j:
                gaps = np.abs(label - np.array(placed.label))
                count += bool((gaps < half + _half(other)).all())
    return count


def _apart(a: Points, b: Points) -> NDArray[np.float64]:
    """Distances, of arrays that numpy can pair up."""
    gaps = a - b
    return np.hypot(gaps[..., 0], gaps[..., 1])


def _on_states(states: Points, labels: Points, half: Points) -> NDArray[np.bool_]:
    """Which states are covered by which labels, (..., 2): shape (..., n_states)."""
    beyond = np.maximum(np.abs(states - labels[..., None, :]) - half, 0.0)
    return np.hypot(beyond[..., 0], beyond[..., 1]) < RADIUS + _GAP / 4


def _under(points: Points, labels: Points, half: Points) -> NDArray[np.bool_]:
    """Whether any of the points, (..., m, 2), is covered by the labels, (..., 2): shape (...)."""
    wide, high = half + _GAP / 4
    x = np.abs(points[..., 0] - labels[..., None, 0]) < wide
    return (x & (np.abs(points[..., 1] - labels[..., None, 1]) < high)).any(axis=-1)
