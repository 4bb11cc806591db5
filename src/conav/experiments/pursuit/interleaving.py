"""Whether exploration and pursuit in turn drive less than exploring first and clearing afterwards.

[Pellier2005] interleaves them up to an exploration depth bound and claims that this is efficient,
without figures. Here floors are cleared with several bounds, and distances compared with those of
the same team that explores everything first (edb unlimited). Everything is counted, nothing timed
but the drives, so the study is the same on every machine.
"""

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from typing import Literal, NamedTuple

from conav.maps.load_floor_plan import load_floor_plan
from conav.pursuit.clear_unknown_map import ClearUnknownMap
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem
from conav.pursuit.verify import verify_schedule

Bound = int | Literal["unlimited"]

BOUNDS: tuple[Bound, ...] = (1, 2, 3, 5, "unlimited")
FLOORS = (
    *(f"comb:{teeth}" for teeth in (3, 6, 9)),
    *(f"rooms:{rooms}" for rooms in (2, 3, 4, 5)),
    *(f"spider:{bends}" for bends in ("0,1,2", "1,1,2", "1,2,2", "1,3,3", "2,2,2", "2,3,3")),
    "ring",
    "streets:2",
    *(f"corridor-tree:segments=12,seed={seed}" for seed in range(4)),
    *(f"corridor-tree:segments=16,seed={seed}" for seed in range(4)),
)


class Cleared(NamedTuple):
    """What a team did on one floor with one bound."""

    floor: str
    edb: Bound
    verdict: str  # of the verifier; "" where the team gave up
    pursuers: int
    distance_m: float
    time_s: float
    recontaminations: int
    explored_vertices: int
    pursuits: int


class Comparison(NamedTuple):
    """Distances with one bound, as shares of those of the same team that explores first."""

    edb: Bound
    ratios: dict[str, float]  # floor -> its ratio; floors with another team size are left out
    other_teams: tuple[str, ...]  # floors on which the teams had different sizes

    @property
    def median(self) -> float:
        """Of the ratios; nan without any."""
        return median(self.ratios.values()) if self.ratios else float("nan")

    @property
    def above_one(self) -> dict[str, float]:
        """Floors on which exploring first drives less."""
        return {floor: ratio for floor, ratio in self.ratios.items() if ratio > 1.0 + 1e-9}


def clear_floor(name: str, method: ClearUnknownMap) -> Cleared:
    """Clears a floor that nobody knows, with one pursuer and as many more as are called."""
    floor = load_floor_plan(name)
    team = (Pursuer("pursuer_1", default_start(floor)),)
    result = method.solve(PursuitProblem(floor, team, known=False, name=name))
    verdict = ""
    if result.status == "done":
        found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
        verdict = str(found.verdict)
    return Cleared(
        name,
        method.edb,
        verdict,
        len(result.pursuers),
        result.schedule.distance_m,
        float(result.schedule.times[-1]),
        result.recontaminations or 0,
        result.counters["explored_vertices"],
        result.counters["pursuits"],
    )


def compare_bounds(
    floors: Iterable[str] = FLOORS,
    bounds: Sequence[Bound] = BOUNDS,
    *,
    care: float = ClearUnknownMap.care,
    on_cleared: Callable[[Cleared], None] | None = None,
) -> list[Cleared]:
    """One entry a floor and bound, in this order."""
    every: list[Cleared] = []
    for floor in floors:
        for edb in bounds:
            every.append(clear_floor(floor, ClearUnknownMap(edb=edb, care=care)))
            if on_cleared is not None:
                on_cleared(every[-1])
    return every


def against_exploring_first(cleared: Sequence[Cleared]) -> list[Comparison]:
    """A comparison for each finite bound, in the order of their first entries.

    Floors that were not captured with either are left out.
    """
    captured = {(one.floor, one.edb): one for one in cleared if one.verdict == "captured"}
    comparisons: list[Comparison] = []
    for edb in dict.fromkeys(one.edb for one in cleared if one.edb != "unlimited"):
        ratios: dict[str, float] = {}
        others: list[str] = []
        for floor in dict.fromkeys(one.floor for one in cleared):
            one, first = captured.get((floor, edb)), captured.get((floor, "unlimited"))
            if one is None or first is None:
                continue
            if one.pursuers != first.pursuers:
                others.append(floor)
            elif first.distance_m > 0.0:
                ratios[floor] = one.distance_m / first.distance_m
        comparisons.append(Comparison(edb, ratios, tuple(others)))
    return comparisons


def table(comparisons: Sequence[Comparison]) -> list[str]:
    """The comparisons as lines of a Markdown table."""
    lines = [
        "| edb | floors | median ratio | shorter on | longer on | another team on |",
        "|---|---|---|---|---|---|",
    ]
    for one in comparisons:
        shorter = sum(ratio < 1.0 - 1e-9 for ratio in one.ratios.values())
        longer = ", ".join(f"`{floor}` {ratio:.2f}" for floor, ratio in one.above_one.items())
        lines.append(
            f"| {one.edb} | {len(one.ratios)} | {one.median:.2f} | {shorter} | "
            f"{longer or 'none'} | {len(one.other_teams)} |"
        )
    return lines
