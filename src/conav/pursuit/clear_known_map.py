"""Clearing a known floor with as few pursuers as are found to suffice.

Teams grow one by one from those the problem begins with. Each size is searched on the critical
vertices, and where these do not suffice with middles of triangles beside them. A size no plan is
found for is not proved to be too small: the budget may have ended, or other places might do. Posts
that see the whole floor end the growth, where 60 of them are enough.
"""

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from conav.errors import InputError
from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import Triangulation, triangulate
from conav.pursuit.beliefs import beliefs_of
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.drives import moves_of
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.known_map import KnownMapSearch, Move
from conav.pursuit.one_pursuer import decide_one_pursuer
from conav.pursuit.roadmap import Roadmap, make_roadmap
from conav.pursuit.schedule import schedule_of
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.split_search import Drive, SplitSearch
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.status import Status

OnProgress = Callable[[int, int], bool]
"""Told how many pursuers are tried and how many states were expanded for them; False ends it."""


LARGEST = 60  # pursuers: a drive needs two views more, and there are bits for 62
QUICK = 100  # states for a part by itself where any plan is looked for
QUICK_SHARE = 30  # times the budget, so that large floors come to a plan
THOROUGH = 2000  # and where a plan for fewer is


@dataclass(frozen=True)
class ClearKnownMap:
    """Search over places and contaminated shadows, one team size after the other."""

    places: Literal["auto", "vertices", "all"] = "auto"
    """Critical vertices, or middles of triangles beside them; auto tries the first first."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for; 0 looks for the
    shortest plan on the roadmap, which takes much longer."""
    budget: int = 100_000
    """For each team size, roadmap and way of searching: windows of the views laid over each other.
    A million takes five seconds or so."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.weight < float("inf"):
            raise ValueError(f"weight is {self.weight:g}; give 0 or more")
        if self.budget < 1:
            raise ValueError(f"budget is {self.budget}; give 1 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """A plan, and what it rests on.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        mesh = _checked(problem)
        plans = _Plans(problem, mesh, self, on_progress)
        first = len(problem.pursuers)
        size, quick = first, plans.quick(first)
        while quick is None and not plans.stopped and _may_grow(problem, size):
            size += 1
            quick = plans.quick(size)
        if plans.stopped:
            return _nothing(problem, size, plans, "it was stopped")
        last = size + (quick is None or self.weight == 0.0)
        for smaller in range(first, last):
            thorough = plans.alone() if smaller == 1 else None
            if smaller < plans.least:
                continue
            if thorough is None:
                thorough = plans.thorough(smaller)
            if plans.stopped:
                return _nothing(problem, smaller, plans, "it was stopped")
            if thorough is not None:
                return _result(problem, smaller, thorough, plans)
        if quick is None:
            return _nothing(problem, size, plans)
        return _result(problem, size, quick, plans)


class _Plan(NamedTuple):
    roadmap: Roadmap
    moves: tuple[Move, ...]


class _Plans:
    """Plans for one problem, by different searches; what they learn of the floor is shared."""

    def __init__(
        self,
        problem: PursuitProblem,
        mesh: Triangulation,
        settings: ClearKnownMap,
        on_progress: OnProgress | None,
    ) -> None:
        self.problem, self.mesh, self.settings = problem, mesh, settings
        self.on_progress = on_progress
        self.expanded = 0
        self.stopped = False
        self.least = least_pursuers(problem.floor)
        self.shadows = ShadowMoves(mesh)
        self._starts = [(float(one.start[0]), float(one.start[1])) for one in problem.pursuers]
        self._splits: dict[bool, SplitSearch] = {}
        self._posts: tuple[int, ...] | None = None  # none there are: ()

    def quick(self, size: int) -> _Plan | None:
        """By the post that looks best in each part; after the budget by posts that see all."""
        middles = self.settings.places == "all"
        plan = self._split(size, middles, breadth=1, each=QUICK, share=QUICK_SHARE)
        if plan is None and not self.stopped and (self._splits[middles].ended or size == LARGEST):
            search = self._splits[middles]
            if self._posts is None:
                self._posts = guard_posts(search.roadmap, self.shadows) or ()
            if 0 < len(self._posts) <= size:
                drives = [(who, [post]) for who, post in enumerate(self._posts)]
                plan = self._plan(search, drives, size)
        return plan

    def thorough(self, size: int) -> _Plan | None:
        """By several posts in each part, and by moving in turn, as far as the budget goes.

        The shortest plan may have all move in turn, so it is looked for among these alone.
        """
        for middles in (False, True):
            if self.settings.places in ("auto", "all" if middles else "vertices"):
                plan = None
                if self.settings.weight > 0.0:
                    plan = self._split(size, middles, breadth=8, each=THOROUGH)
                if plan is None and not self.stopped:
                    plan = self._in_turn(size, middles)
                if plan is not None or self.stopped:
                    return plan
        return None

    def alone(self) -> _Plan | None:
        """By the cells that tell whether one pursuer can clear the floor; proves it where not."""
        decision = decide_one_pursuer(self.problem.floor)
        self.expanded += decision.states
        if decision.suffices is False:
            self.least = max(self.least, 2)
        if not decision.suffices or self.settings.weight == 0.0:
            return None
        return self._along(decision.way)

    def _along(self, way: Sequence[Point]) -> _Plan | None:
        """One pursuer goes to the way's beginning and along it; None where that leaves somebody."""
        roadmap = self._search(False).roadmap
        points = list(dict.fromkeys((*roadmap.points, *way)))
        number = {point: i for i, point in enumerate(points)}
        lengths = np.full((len(points), len(points)), np.inf)
        n = len(roadmap.points)
        lengths[:n, :n] = roadmap.lengths
        seen = [i for i in range(n) if sees(self.mesh, points[i], way[0])]
        pairs = [(i, number[way[0]]) for i in seen]
        pairs += [(number[a], number[b]) for a, b in pairwise(way)]
        for i, j in pairs:
            (ax, ay), (bx, by) = points[i], points[j]
            lengths[i, j] = lengths[j, i] = ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5
        joined = tuple(np.flatnonzero(np.isfinite(row)) for row in lengths)
        extended = Roadmap(tuple(points), joined, lengths)
        begin = self._begin(extended, 1)
        moves = moves_of(extended, begin, [(0, [number[point] for point in way])])
        if moves is None:
            return None
        dirty = (1 << self.shadows.shadows([points[begin[0]]]).count) - 1
        for count, move in enumerate(moves):
            if dirty == 0:
                return _Plan(extended, moves[:count])
            dirty = self.shadows.after((), points[move.start], points[move.end], dirty)
        return _Plan(extended, moves) if dirty == 0 else None

    def _split(
        self, size: int, middles: bool, *, breadth: int, each: int, share: int = 1
    ) -> _Plan | None:
        search = self._search(middles)
        drives = search.clear(
            size,
            breadth=breadth,
            each=each,
            budget=share * self.settings.budget,
            on_progress=lambda count: self._told(size, count),
        )
        self.expanded += search.spent
        search.spent = 0
        return None if drives is None else self._plan(search, drives, size)

    def _in_turn(self, size: int, middles: bool) -> _Plan | None:
        search = self._search(middles)
        found = KnownMapSearch(self.shadows, search.roadmap).clear(
            self._begin(search.roadmap, size),
            weight=self.settings.weight,
            budget=self.settings.budget,
            on_progress=lambda count: self._told(size, count),
        )
        self.expanded += found.expanded
        return None if found.moves is None else _Plan(search.roadmap, found.moves)

    def _search(self, middles: bool) -> SplitSearch:
        if middles not in self._splits:
            roadmap = make_roadmap(self.problem.floor, self.mesh, self._starts, middles=middles)
            self._splits[middles] = SplitSearch(self.shadows, roadmap, self.settings.weight)
        return self._splits[middles]

    def _plan(self, search: SplitSearch, drives: list[Drive], size: int) -> _Plan | None:
        moves = moves_of(search.roadmap, self._begin(search.roadmap, size), drives)
        return None if moves is None else _Plan(search.roadmap, moves)

    def _begin(self, roadmap: Roadmap, size: int) -> list[int]:
        starts = [one.start for one in _team(self.problem, size)]
        return [roadmap.points.index((float(x), float(y))) for x, y in starts]

    def _told(self, size: int, count: int) -> bool:
        if self.on_progress is not None and not self.on_progress(size, count):
            self.stopped = True
        return not self.stopped


def _may_grow(problem: PursuitProblem, size: int) -> bool:
    return size < LARGEST and (problem.most is None or size < problem.most)


def _checked(problem: PursuitProblem) -> Triangulation:
    if not problem.known:
        raise InputError("pursuit", "the floor is not known", "give a method for unknown floors")
    for one in problem.pursuers:
        if one.range_m is not None or one.reach_m is not None:
            raise InputError(
                f"pursuer {one.name!r}",
                "has a limited range or reach, which this method does not plan for",
                "leave both out",
            )
    mesh = triangulate(problem.floor.vertices, problem.floor.ring_starts)
    for one in problem.pursuers:
        x, y = one.start
        if not sees(mesh, (x, y), (x, y)):
            raise InputError(
                f"pursuer {one.name!r}", f"starts at ({x:g}, {y:g}), off the floor", "move it"
            )
    return mesh


def _team(problem: PursuitProblem, size: int) -> tuple[Pursuer, ...]:
    """The problem's pursuers, and more like the first."""
    team = list(problem.pursuers[:size])
    taken = {one.name for one in team}
    number = len(team)
    while len(team) < size:
        number += 1
        name = f"pursuer_{number}"
        if name not in taken:
            team.append(replace(problem.pursuers[0], name=name))
    return tuple(team)


def _result(problem: PursuitProblem, size: int, plan: _Plan, plans: _Plans) -> PursuitResult:
    pursuers = _team(problem, size)
    schedule = schedule_of(pursuers, plan.roadmap.points, plan.moves)
    return PursuitResult(
        Status.DONE,
        "",
        schedule,
        pursuers,
        lower_bound=min(plans.least, size),
        minimal_proved=size <= plans.least,
        counters={
            "moves": len(plan.moves),
            "expanded": plans.expanded,
            "arrangements": plans.shadows.arrangements,
            "places": len(plan.roadmap.points),
        },
        beliefs=beliefs_of(plans.shadows, schedule),
    )


def _nothing(problem: PursuitProblem, size: int, plans: _Plans, reason: str = "") -> PursuitResult:
    pursuers = _team(problem, size)
    starts = np.array([one.start for one in pursuers], dtype=np.float64)
    stand = Schedule(np.zeros(1), starts[None], np.empty((0, size), np.bool_))
    word = "pursuer" if size == 1 else "pursuers"
    tried = f"no plan for {size} {word} was found; more pursuers or a larger budget may find one"
    return PursuitResult(
        Status.OUT_OF_BUDGET,
        reason or tried,
        stand,
        pursuers,
        lower_bound=min(plans.least, size),
        minimal_proved=False,
        counters={"expanded": plans.expanded},
    )


def make_clearing(settings: Mapping[str, object]) -> ClearKnownMap:
    """The method with these settings; text is read as the setting's type.

    Raises `InputError` for a misspelt setting or a value that is not allowed.
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    names = [item.name for item in fields(ClearKnownMap)]
    for key in settings:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1)
            hint = f"did you mean {near[0]}?" if near else "the settings: " + ", ".join(names)
            raise InputError(f"setting {key!r}", "is not known", hint)
    cls: Any = ClearKnownMap
    cls.__pydantic_config__ = ConfigDict(extra="forbid")
    try:
        return cast("ClearKnownMap", TypeAdapter(cls).validate_python(dict(settings)))
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(
            f"setting {key!r}" if key else "settings",
            f"got {first['input']!r}: {first['msg'].removeprefix('Value error, ')}",
            "see docs/pursuit.md",
        ) from None


def settings_of(method: ClearKnownMap) -> dict[str, object]:
    """All settings, defaults included, by name."""
    return {item.name: getattr(method, item.name) for item in fields(method)}
