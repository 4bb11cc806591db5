"""All sums of cost vectors that no plan on the robots' graphs dominates: a search for small teams.

The search goes through the product of the graphs. Whoever's present edge ends first goes on: along
an edge out of there, or, its task done, by resting (or vanishing). Each new edge is tested against
the others' present ones. Those are all it can collide with later: what the others did before ended
by then, and what they do next is tested when its turn comes. So a complete plan is made in exactly
one way, and found if no label of the same edges and states of all robots is at least as good.

Labels are looked at in the lexicographic order of their sum and the rest of each robot's way alone,
in each component; so with one cost this is A*, and the first plan found is the optimum
[Stewart1991]. The number of labels grows exponentially with the robots.

A rule may say more of robots together than that they keep apart. It is told of every pair of steps
that overlap in time, each once, and remembers what it needs; labels it remembers different things
of are kept side by side.
"""

import heapq
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from operator import add
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.planning.best_response import LEAST_GAIN, Roads, state_after
from conav.planning.graph_arrays import ONE_CHANGE
from conav.planning.joint_rule import JointRule, Present
from conav.planning.steering import pieces_of
from conav.planning.team import Team
from conav.planning.traffic import pieces_apart
from conav.planning.types import PIECE

_REST = -1  # in place of an edge's head: at rest, or gone


@dataclass(frozen=True, eq=False)
class JointPlan:
    """Paths by ranks, one for each robot asked about, and the sum of their cost vectors."""

    paths: tuple[NDArray[np.int64], ...]
    total: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class JointResult:
    """Plans of which none dominates another, by increasing sums.

    With `proved` every plan that is below what was known has a sum that is at least as great as one
    of theirs everywhere. `bound` is what the first component of every plan's sum is at least, or
    what was known if that is less; infinite when it is proved that there is no plan.
    """

    plans: tuple[JointPlan, ...]
    proved: bool
    labels: int
    bound: float


_Step = tuple[int, int]  # an edge by the ranks of its ends, or a rank and `_REST`


class _Move(NamedTuple):
    step: _Step
    state: int  # of the task after it
    cost: tuple[float, ...]
    rest: tuple[float, ...]  # what remains after it, alone


@dataclass(eq=False)
class _Side:
    """One robot's graph for this search."""

    roads: tuple[Roads, ...]
    limits: NDArray[np.float64]
    stays: bool
    horizon: float
    body: float
    out: list[list[tuple[int, int]]]  # of each rank: edges out of it and where they lead
    times: list[float]
    remaining: NDArray[np.float64]  # (ranks, states, components)
    costs: NDArray[np.float64]  # (edges, components)
    _pieces: dict[_Step, NDArray[np.float64]] = field(default_factory=dict)
    _presents: dict[_Step, Present] = field(default_factory=dict)
    _moves: dict[_Step, list[_Move]] = field(default_factory=dict)

    def moves(self, here: int, state: int) -> list[_Move]:
        """What the robot can do at a rank in a state of its task."""
        if (here, state) not in self._moves:
            zero = (0.0,) * self.costs.shape[1]
            found: list[_Move] = []
            if self.roads[0].automaton.accepting[state]:
                found.append(_Move((here, _REST), state, zero, zero))
            for edge, head in self.out[here]:
                after = self.state_after(state, here, edge, head)
                rest = tuple(self.remaining[head, after].tolist())
                if max(rest) < float("inf"):
                    more = tuple(self.costs[edge].tolist())
                    found.append(_Move((here, head), after, more, rest))
            self._moves[here, state] = found
        return self._moves[here, state]

    def pieces(self, step: _Step) -> NDArray[np.float64]:
        """The pieces of an edge from a rank to another, or of the rest at a rank."""
        if step not in self._pieces:
            states = self.roads[0].arranged.states
            tail, head = step
            if head == _REST:
                x, y, t = states[tail, :3].tolist()
                row = np.zeros((1, PIECE))
                row[0, :4] = t, self.horizon if self.stays else t, x, y
                self._pieces[step] = row
            else:
                self._pieces[step] = pieces_of(self.limits, states[[tail, head]])
        return self._pieces[step]

    def present(self, step: _Step) -> Present:
        """The robot at a step, for rules."""
        if step not in self._presents:
            tail, head = step
            if tail < 0:
                found = Present(step, np.empty((0, PIECE)), -1.0)
            else:
                until = float("inf") if head == _REST else self.times[head]
                found = Present(step, self.pieces(step), until)
            self._presents[step] = found
        return self._presents[step]

    def state_after(self, state: int, tail: int, edge: int, head: int) -> int:
        """The state of the task after an edge."""
        arranged, automaton = self.roads[0].arranged, self.roads[0].automaton
        word = int(arranged.words[edge])
        if word == ONE_CHANGE and arranged.letters[tail] == arranged.letters[head]:
            return state
        return int(
            state_after(
                state,
                arranged.letters[tail],
                arranged.letters[head],
                word,
                arranged.letters_of_words,
                automaton.transition,
            )
        )


_At = tuple[tuple[_Step, int], ...]  # of each robot its present edge and its state after it
_Key = tuple[_At, Hashable]


@dataclass(frozen=True, eq=False)
class _Label:
    at: _At
    cost: tuple[float, ...]
    rests: tuple[tuple[float, ...], ...]  # what remains of each robot's way, alone
    before: "_Label | None"
    memory: Hashable  # of the rule


def joint_search(
    team: Team,
    robots: Sequence[int],
    max_labels: int,
    known: float = float("inf"),
    out_of_time: Callable[[], bool] = lambda: False,
    rule: JointRule | None = None,
    weight: float = 1.0,
) -> JointResult:
    """The plans with sums that nothing dominates, one for each such sum.

    Of one component, only if its sum is below `known`, by more than rounding. Where `rule` is given
    they keep it. With a `weight` above 1, for one component, what remains counts so many times in
    the order of labels: a plan is found sooner, costs at most so many times the least, and nothing
    is proved.
    """
    nothing = float("inf")
    sides = [_side(team, robot) for robot in robots]
    start: _At = tuple(((-1, 0), side.roads[0].start_state) for side in sides)
    zero = (0.0,) * len(team.problem.costs)
    alone = tuple(
        tuple(side.remaining[0, s].tolist()) for side, (_, s) in zip(sides, start, strict=True)
    )
    # Starts are tested as if each were an edge of no length.
    for i, side in enumerate(sides):
        for other in sides[:i]:
            a, b = side.pieces((0, _REST))[:, :].copy(), other.pieces((0, _REST)).copy()
            a[0, 1] = b[0, 1] = 0.0
            if not pieces_apart(a, 0, b, 0, side.body + other.body):
                return JointResult((), True, 0, nothing)
    seen: dict[_Key, list[tuple[float, ...]]] = {}
    apart: dict[tuple[int, _Step, int, _Step], bool] = {}
    plans: list[JointPlan] = []
    bound = _sum(zero, alone)
    if max(bound) == nothing:
        return JointResult((), True, 0, nothing)
    easy = bound[0]  # with nobody about
    heap: list[tuple[tuple[float, ...], int, _Label]] = [
        (bound, 0, _Label(start, zero, alone, None, None if rule is None else rule.begin()))
    ]
    made = 1
    labels = 0
    while heap:
        order, _, label = heapq.heappop(heap)
        bound = order if weight == 1.0 else _sum(label.cost, label.rests)
        if bound[0] >= known - LEAST_GAIN and len(bound) == 1:
            if weight != 1.0:  # others may have less yet to come
                continue
            return JointResult(tuple(plans), True, labels, min(bound[0], known))
        if any(_covers(plan.total, bound) for plan in plans):
            continue
        kept = seen.setdefault((label.at, label.memory), [])
        if any(_covers(cost, label.cost) for cost in kept):
            continue
        if labels >= max_labels or out_of_time():
            least = min([bound[0] if weight == 1.0 else easy, *(p.total[0] for p in plans)])
            return JointResult(tuple(plans), False, labels, least)
        labels += 1
        kept.append(label.cost)
        moving = [i for i, ((_, head), _) in enumerate(label.at) if head != _REST]
        if not moving:
            if rule is not None and not rule.holds(label.memory):
                continue
            # Bounds are sums in another order, so by a rounding one may come before another that it
            # turns out to be dominated by.
            if not any(_covers(plan.total, label.cost) for plan in plans):
                plans = [plan for plan in plans if not _covers(label.cost, plan.total)]
                plans.append(JointPlan(_paths(label), label.cost))
            if len(bound) == 1:
                break
            continue
        robot = min(moving, key=lambda i: (sides[i].times[label.at[i][0][1]], i))
        side = sides[robot]
        (_, here), state = label.at[robot]
        for step, after, more, rest in side.moves(here, state):
            cost = tuple(map(add, label.cost, more))
            rests = (*label.rests[:robot], rest, *label.rests[robot + 1 :])
            below = _sum(cost, rests)
            if any(_covers(plan.total, below) for plan in plans):
                continue
            if len(below) == 1 and below[0] >= known - LEAST_GAIN:
                continue
            at = (*label.at[:robot], (step, after), *label.at[robot + 1 :])
            memory = label.memory
            if rule is None and any(_covers(other, cost) for other in seen.get((at, None), ())):
                continue
            fine = True
            for other, (theirs, _) in enumerate(label.at):
                if other == robot or theirs[0] < 0:
                    continue
                key = robot, step, other, theirs
                if key not in apart:
                    apart[key] = _apart(side, step, sides[other], theirs)
                if not apart[key]:
                    fine = False
                    break
            if not fine:
                continue
            if rule is not None:
                others = [one.present(own) for one, (own, _) in zip(sides, label.at, strict=True)]
                memory = rule.after(memory, robot, side.present(step), others)
                if memory is None:
                    continue
                if any(_covers(other, cost) for other in seen.get((at, memory), ())):
                    continue
            priority = below if weight == 1.0 else _weighted(cost, rests, weight)
            heapq.heappush(heap, (priority, made, _Label(at, cost, rests, label, memory)))
            made += 1
    least = min([known, *(plan.total[0] for plan in plans)])
    if weight != 1.0 and plans:
        return JointResult(tuple(plans), False, labels, easy)
    return JointResult(tuple(plans), True, labels, least)


def _side(team: Team, robot: int) -> _Side:
    roads = team.roads_of(robot)
    arranged = roads[0].arranged
    size = len(arranged.letters)
    out: list[list[tuple[int, int]]] = [[] for _ in range(size)]
    for head in range(size):
        for edge in range(int(arranged.starts[head]), int(arranged.starts[head + 1])):
            out[arranged.sources[edge]].append((edge, head))
    return _Side(
        roads,
        team.graphs[robot].surroundings.limits,
        team.traffic.stays[robot],
        team.traffic.horizon_s,
        float(team.traffic.bodies[robot]),
        out,
        arranged.states[:, 2].tolist(),
        np.stack([each.remaining for each in roads], axis=2),
        np.stack([each.costs for each in roads], axis=1),
    )


def _sum(cost: tuple[float, ...], rests: Sequence[tuple[float, ...]]) -> tuple[float, ...]:
    """What every plan from here on costs at least."""
    return tuple(map(sum, zip(cost, *rests, strict=True)))


def _weighted(
    cost: tuple[float, ...], rests: Sequence[tuple[float, ...]], weight: float
) -> tuple[float, ...]:
    """As `_sum`, with what remains so many times."""
    return tuple(own + weight * sum(rest) for own, *rest in zip(cost, *rests, strict=True))


def _apart(a: _Side, step: _Step, b: _Side, other: _Step) -> bool:
    mine, theirs = a.pieces(step), b.pieces(other)
    return all(
        pieces_apart(mine, i, theirs, j, a.body + b.body)
        for i in range(len(mine))
        for j in range(len(theirs))
    )


def _covers(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    """Whether a is at least as good as b everywhere, but for rounding."""
    return all(x <= y + LEAST_GAIN for x, y in zip(a, b, strict=True))


def _paths(label: _Label) -> tuple[NDArray[np.int64], ...]:
    """Each robot's ranks, from the last label back."""
    rows: list[list[int]] = [[] for _ in label.at]
    at: _Label | None = label
    while at is not None:
        for row, ((_, head), _) in zip(rows, at.at, strict=True):
            if head != _REST and (not row or row[-1] != head):
                row.append(head)
        at = at.before
    return tuple(np.array(row[::-1], np.int64) for row in rows)
