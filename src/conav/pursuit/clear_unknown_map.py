"""Clearing a floor nobody gave the team: exploration and pursuit in turn [Pellier2005].

Algorithm 1 goes to unexplored vertices by shortest ways. Algorithm 2 clears the known part and goes
on exploring. What is known of a floor may need more pursuers than the whole, so the team grows only
when all is explored, where the paper adds one at once. Then the search of `clear_known_map` goes on
from where pursuers stand and with what they know to be clear; newcomers enter where the first did.
"""

from dataclasses import dataclass
from typing import Literal

from conav.errors import InputError
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.drives import moves_of
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.known_map import KnownMapSearch, Move
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.sensor import Point, Sensor
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.team import may_grow, team_of
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.unknown_floor_team import UnknownFloorTeam
from conav.status import Status


@dataclass(frozen=True)
class ClearUnknownMap:
    """Exploration and pursuit in turn, until nothing is unexplored and nothing contaminated."""

    edb: int | Literal["unlimited"] = 5
    """How many vertices are explored between two pursuits, the exploration depth bound; unlimited
    explores everything first."""
    care: float = 1.0
    """Metres that the square root of a known contaminated square metre counts for when the team
    chooses what to explore next and by which way; 0 takes the nearest vertex by the shortest way,
    as Algorithm 1 does, and so does edb unlimited."""
    places: Literal["auto", "vertices", "all"] = "auto"
    """As for known floors, once all is explored; before that, critical vertices."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for."""
    budget: int = 100_000
    """For each team size and roadmap when all is explored: windows of the views laid over each
    other."""
    partial_budget: int = 5000
    """The same, for each search before that, for a pursuit or for the next vertex."""

    def __post_init__(self) -> None:
        if self.edb != "unlimited" and self.edb < 1:
            raise ValueError(f"edb is {self.edb}; give 1 or more, or unlimited")
        for name in ("care", "weight"):
            if not 0.0 <= getattr(self, name) < float("inf"):
                raise ValueError(f"{name} is {getattr(self, name):g}; give 0 or more")
        if self.budget < 1 or self.partial_budget < 1:
            raise ValueError("a budget is below 1; give 1 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """What the team did, and what came of it.

        Raises `InputError` for limited range or reach and for a start off the floor.
        """
        run = _Run(self, problem, on_progress)
        while not run.sweep.survey.complete:
            run.explore()
            if not run.sweep.survey.complete:
                run.pursue()
        return run.finish()


class _Run:
    def __init__(
        self, method: ClearUnknownMap, problem: PursuitProblem, on_progress: OnProgress | None
    ) -> None:
        if problem.faults:
            raise InputError(
                "pursuit", "loses pursuers, which this method does not plan for", "use delegation"
            )
        for one in problem.pursuers:
            if one.range_m is not None or one.reach_m is not None:
                raise InputError(
                    f"pursuer {one.name!r}",
                    "has a limited range or reach, which this method does not plan for",
                    "leave both out",
                )
        self.method, self.problem, self.told = method, problem, on_progress
        sensor = Sensor(problem.floor)
        for one in problem.pursuers:
            if len(sensor.look((float(one.start[0]), float(one.start[1]))).corners) == 0:
                x, y = one.start
                raise InputError(
                    f"pursuer {one.name!r}", f"starts at ({x:g}, {y:g}), off the floor", "move it"
                )
        self.sensor = sensor
        self.sweep = UnknownFloorTeam(sensor, problem.pursuers)
        self.explored = 0
        self.pursuits = 0
        self.stopped = False
        self.expanded = 0

    def explore(self) -> None:
        """Go to the nearest unexplored vertex, by who is nearest, up to `edb` times."""
        edb = self.method.edb
        count = 0
        while not self.sweep.survey.complete and (edb == "unlimited" or count < edb):
            count += 1
            self.explored += 1
            targets = self.sweep.survey.unexplored()
            if edb == "unlimited" or self.method.care == 0.0 or not self._with_care(targets):
                self._to_nearest(targets)

    def _with_care(self, targets: tuple[Point, ...]) -> bool:
        """Go to one of these so that little is contaminated afterwards; False if no way is found.

        Ways are taken by metres driven plus `care` times the square root of the known
        contaminated area.
        """
        sweep = self.sweep
        ends = {sweep.search.roadmap.points.index(target) for target in targets}
        found = sweep.search.clear(
            sweep.numbers(),
            weight=self.method.care,
            budget=self.method.partial_budget,
            dirty=sweep.dirty,
            goal=lambda places, _: not ends.isdisjoint(places),
        )
        self.expanded += found.expanded
        if found.moves:
            self._make(sweep.search, found.moves)
        return bool(found.moves)

    def _to_nearest(self, targets: tuple[Point, ...]) -> None:
        graph = self.sweep.graph
        ends = [graph.points.index(target) for target in targets]
        ways = [
            (float(graph.distances[start, end]), i, start, end)
            for i, start in enumerate(self.sweep.numbers())
            for end in ends
        ]
        _, i, start, end = min(ways)
        for place in graph.way(start, end)[1:]:
            self.sweep.drive(i, graph.points[place])

    def pursue(self) -> None:
        """Clear the known part of the floor where a way to do it is found."""
        sweep = self.sweep
        found = sweep.search.clear(
            sweep.numbers(),
            weight=self.method.weight,
            budget=self.method.partial_budget,
            dirty=sweep.dirty,
        )
        self.expanded += found.expanded
        if found.moves:
            self.pursuits += 1
            self._make(sweep.search, found.moves)

    def _make(self, search: KnownMapSearch, moves: tuple[Move, ...] | list[Move]) -> None:
        for start, end in [(search.roadmap.points[a], search.roadmap.points[b]) for a, b in moves]:
            self.sweep.drive(self.sweep.team.index(start), end)

    def finish(self) -> PursuitResult:
        """Clear the floor, of which everything is known, with as few newcomers as are found."""
        sweep, method, problem = self.sweep, self.method, self.problem
        if sweep.done:
            if sweep.legs == 0:
                sweep.stand()
            return self._result(Status.DONE, "")
        first = len(sweep.pursuers)
        gate = (float(problem.pursuers[0].start[0]), float(problem.pursuers[0].start[1]))
        floor, mesh = sweep.survey.known, sweep.survey.mesh
        shadows = ShadowMoves(mesh)
        searches: list[KnownMapSearch] = []
        for middles in (False, True):
            if method.places in ("auto", "all" if middles else "vertices"):
                roadmap = make_roadmap(floor, mesh, (gate, *sweep.team), middles=middles)
                searches.append(KnownMapSearch(shadows, roadmap))
        posts: tuple[int, ...] | None = None
        size = first
        while True:
            pursuers = team_of(problem, size)
            newcomers = pursuers[first:]
            if posts is not None and size >= len(posts):
                begin = [
                    *sweep.numbers(),
                    *[searches[0].roadmap.points.index(gate)] * len(newcomers),
                ]
                drives = [(who, [post]) for who, post in enumerate(posts)]
                moves = moves_of(searches[0].roadmap, begin, drives)
                if moves is not None:
                    return self._carry_out(searches[0], newcomers, moves)
            for search in searches:
                sweep.use(search)
                found = search.clear(
                    [*sweep.numbers(), *[search.roadmap.points.index(gate)] * len(newcomers)],
                    weight=method.weight,
                    budget=method.budget,
                    dirty=sweep.dirty_with(*[gate] * len(newcomers)),
                    on_progress=lambda count, size=size: self._goes_on(size, count),
                )
                self.expanded += found.expanded
                if found.moves is not None:
                    return self._carry_out(search, newcomers, found.moves)
                if self.stopped:
                    return self._result(Status.OUT_OF_BUDGET, "it was stopped")
            if not may_grow(problem, size):
                break
            if size == first:
                found_posts = guard_posts(mesh, searches[0].roadmap.points)
                posts = None if found_posts is None else found_posts.places
            size += 1
        word = "pursuer" if size == 1 else "pursuers"
        tried = f"no plan for {size} {word} was found; more or a larger budget may find one"
        return self._result(Status.OUT_OF_BUDGET, tried)

    def _goes_on(self, size: int, expanded: int) -> bool:
        if self.told is not None and not self.told(size, expanded):
            self.stopped = True
        return not self.stopped

    def _carry_out(
        self,
        search: KnownMapSearch,
        newcomers: tuple[Pursuer, ...],
        moves: tuple[Move, ...] | list[Move],
    ) -> PursuitResult:
        self.sweep.use(search)
        for one in newcomers:
            self.sweep.enter(one)
        self._make(search, moves)
        if not moves:
            self.sweep.stand()
        if not self.sweep.done:
            return self._result(Status.OUT_OF_BUDGET, "the last plan did not clear the floor")
        return self._result(Status.DONE, "")

    def _result(self, status: Status, reason: str) -> PursuitResult:
        sweep, size = self.sweep, len(self.sweep.pursuers)
        least = min(least_pursuers(sweep.survey.known), size)
        return PursuitResult(
            status,
            reason,
            sweep.schedule(),
            tuple(sweep.pursuers),
            lower_bound=least,
            minimal_proved=status is Status.DONE and size == least,
            counters={
                "moves": sweep.drives,
                "explored_vertices": self.explored,
                "pursuits": self.pursuits,
                "expanded": self.expanded,
                "looks": self.sensor.looks,
                "critical_vertices": len(sweep.survey.critical),
            },
            explored=sweep.survey.known.area / self.problem.floor.area,
            recontaminations=sweep.recontaminations,
            beliefs=sweep.beliefs,
            history=tuple(sweep.history),
        )
