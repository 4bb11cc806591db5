"""Clearing a known floor with as few pursuers as are found to suffice.

Teams grow one by one from those the problem begins with. Each size is searched on the critical
vertices, and where these do not suffice with middles of triangles beside them. A size no plan is
found for is not proved to be too small: the budget may have ended, or other places might do. Posts
that see the whole floor end the growth, where 60 of them are enough.
"""

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from conav.errors import InputError
from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import Triangulation, triangulate
from conav.pursuit.beliefs import beliefs_of
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.known_map import KnownMapSearch, Move
from conav.pursuit.roadmap import Roadmap, make_roadmap
from conav.pursuit.schedule import schedule_of
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.status import Status

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")

OnProgress = Callable[[int, int], bool]
"""Told how many pursuers are tried and how many states were expanded for them; False ends it."""


LARGEST = 60  # pursuers: a drive needs two views more, and there are bits for 62


@dataclass(frozen=True)
class ClearKnownMap:
    """Search over places and contaminated shadows, one team size after the other."""

    places: Literal["auto", "vertices", "all"] = "auto"
    """Critical vertices, or middles of triangles beside them; auto tries the first first."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for; 0 looks for the
    shortest plan on the roadmap, which takes much longer."""
    budget: int = 2000
    """States expanded for each team size and roadmap."""

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
        starts = [(float(one.start[0]), float(one.start[1])) for one in problem.pursuers]
        first = len(starts)
        searches: list[KnownMapSearch] = []
        for middles in (False, True):
            if self.places in ("auto", "all" if middles else "vertices"):
                roadmap = make_roadmap(problem.floor, mesh, starts, middles=middles)
                searches.append(KnownMapSearch(mesh, roadmap))
        posts: tuple[int, ...] | None = None
        expanded, size = 0, first
        while True:
            pursuers = grown_team(problem, size)
            if posts is not None and size >= len(posts):
                moves = ways_to_posts(searches[0].roadmap, _begin(searches[0], pursuers), posts)
                if moves is not None:
                    return _result(problem, pursuers, searches[0], moves, expanded, searches)
            for search in searches:

                def told(count: int, size: int = size) -> bool:
                    return on_progress is None or on_progress(size, count)

                found = search.clear(
                    _begin(search, pursuers),
                    weight=self.weight,
                    budget=self.budget,
                    on_progress=told,
                )
                expanded += found.expanded
                if found.moves is not None:
                    return _result(problem, pursuers, search, found.moves, expanded, searches)
                if not found.exhausted and found.expanded < self.budget:
                    return _nothing(problem, pursuers, expanded, "it was stopped")
            if size >= LARGEST or (problem.most is not None and size >= problem.most):
                return _nothing(problem, pursuers, expanded)
            if size == first:
                posts = guard_posts(searches[0].roadmap, searches[0].shadows)
            size += 1


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


def grown_team(problem: PursuitProblem, size: int) -> tuple[Pursuer, ...]:
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


def _begin(search: KnownMapSearch, pursuers: tuple[Pursuer, ...]) -> list[int]:
    points = search.roadmap.points
    return [points.index((float(one.start[0]), float(one.start[1]))) for one in pursuers]


def ways_to_posts(roadmap: Roadmap, begin: list[int], posts: tuple[int, ...]) -> list[Move] | None:
    """Moves that take one pursuer to each post, by shortest ways; None where there is no way."""
    lengths = np.where(np.isfinite(roadmap.lengths), roadmap.lengths, 0.0)
    _, before = dijkstra(csr_matrix(lengths), directed=False, return_predecessors=True)
    moves: list[Move] = []
    for start, post in zip(begin, posts, strict=False):
        way = [post]
        while way[-1] != start:
            previous = int(before[start, way[-1]])
            if previous < 0:
                return None
            way.append(previous)
        way.reverse()
        moves += [Move(a, b) for a, b in pairwise(way)]
    return moves


def _result(
    problem: PursuitProblem,
    pursuers: tuple[Pursuer, ...],
    search: KnownMapSearch,
    moves: list[Move] | tuple[Move, ...],
    expanded: int,
    searches: list[KnownMapSearch],
) -> PursuitResult:
    schedule = schedule_of(pursuers, search.roadmap.points, moves)
    return PursuitResult(
        Status.DONE,
        "",
        schedule,
        pursuers,
        lower_bound=1,
        minimal_proved=len(pursuers) == 1,
        counters={
            "moves": len(moves),
            "expanded": expanded,
            "arrangements": sum(one.shadows.arrangements for one in searches),
            "places": len(search.roadmap.points),
        },
        beliefs=beliefs_of(search.shadows, schedule),
    )


def _nothing(
    problem: PursuitProblem, pursuers: tuple[Pursuer, ...], expanded: int, reason: str = ""
) -> PursuitResult:
    starts = np.array([one.start for one in pursuers], dtype=np.float64)
    stand = Schedule(np.zeros(1), starts[None], np.empty((0, len(pursuers)), np.bool_))
    count = len(pursuers)
    word = "pursuer" if count == 1 else "pursuers"
    tried = f"no plan for {count} {word} was found; more pursuers or a larger budget may find one"
    return PursuitResult(
        Status.OUT_OF_BUDGET,
        reason or tried,
        stand,
        pursuers,
        lower_bound=1,
        minimal_proved=False,
        counters={"expanded": expanded},
    )


def make_clearing(settings: Mapping[str, object], method: type[T]) -> T:
    """A method with these settings; text is read as the setting's type.

    Raises `InputError` for a misspelt setting or a value that is not allowed.
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    names = [item.name for item in fields(method)]
    for key in settings:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1)
            hint = f"did you mean {near[0]}?" if near else "the settings: " + ", ".join(names)
            raise InputError(f"setting {key!r}", "is not known", hint)
    cls: Any = method
    cls.__pydantic_config__ = ConfigDict(extra="forbid")
    try:
        return cast("T", TypeAdapter(cls).validate_python(dict(settings)))
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0]) if first["loc"] else ""
        raise InputError(
            f"setting {key!r}" if key else "settings",
            f"got {first['input']!r}: {first['msg'].removeprefix('Value error, ')}",
            "see docs/pursuit.md",
        ) from None


def settings_of(method: "DataclassInstance") -> dict[str, object]:
    """All settings, defaults included, by name."""
    return {item.name: getattr(method, item.name) for item in fields(method)}
