"""Clearing a known floor with as few pursuers as are found to suffice.

A plan is looked for quickly first: guards part the floor, and one searcher clears the parts. Then,
on floors without holes, it is decided whether one pursuer suffices. Else it is tried with one less,
and one less again, more thoroughly: by guards at several places, and by a search in which all move
in turn. A size no plan is found for is not proved to be too small, but where a bound says so. Posts
that see the whole floor end the growth, where 60 of them are enough.
"""

from dataclasses import dataclass, replace
from typing import Literal

from conav.pursuit.beliefs import beliefs_of
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.known_map_plans import Limits, Plan, Plans
from conav.pursuit.schedule import schedule_of
from conav.pursuit.team import known_floor, may_grow, out_of_budget, team_of
from conav.pursuit.together import move_together
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.status import Status


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
    together: bool = False
    """Whether drives overlap in time where the floor is cleared all the same."""

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
        mesh = known_floor(problem)
        plans = Plans(problem, mesh, Limits(self.places, self.weight, self.budget), on_progress)
        first = len(problem.pursuers)
        size, quick = first, plans.quick(first)
        while quick is None and not plans.stopped and may_grow(problem, size):
            size += 1
            quick = plans.quick(size)
        if plans.stopped:
            return _nothing(problem, size, plans, "it was stopped")
        best = None if quick is None else (size, quick)
        if first == 1 and (quick is None or size > 1):
            alone = plans.alone()
            if alone is not None:
                return self._result(problem, 1, alone, plans)
        smaller = size - (quick is not None and self.weight > 0.0)
        while smaller >= max(first, plans.least):
            found = plans.thorough(smaller)
            if plans.stopped:
                return _nothing(problem, smaller, plans, "it was stopped")
            if found is None:
                break
            best = smaller, found
            smaller -= 1
        return (
            _nothing(problem, size, plans) if best is None else self._result(problem, *best, plans)
        )

    def _result(
        self, problem: PursuitProblem, size: int, plan: Plan, plans: Plans
    ) -> PursuitResult:
        pursuers = team_of(problem, size)
        schedule = schedule_of(pursuers, plan.roadmap.points, plan.moves)
        if self.together:
            schedule = move_together(schedule, pursuers, plans.shadows)
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


def _nothing(problem: PursuitProblem, size: int, plans: Plans, reason: str = "") -> PursuitResult:
    word = "pursuer" if size == 1 else "pursuers"
    tried = f"no plan for {size} {word} was found; more pursuers or a larger budget may find one"
    if size < plans.least:
        tried = f"{size} {word} cannot clear this floor, that is proved; {plans.least} may"
    found = out_of_budget(team_of(problem, size), reason or tried, {"expanded": plans.expanded})
    status = Status.INFEASIBLE if size < plans.least and not reason else found.status
    return replace(found, status=status, lower_bound=plans.least)
