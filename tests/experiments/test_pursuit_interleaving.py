"""The study of interleaving: its ratios by hand, and one floor played."""

from math import isnan

from conav.experiments.pursuit.interleaving import (
    FLOORS,
    Bound,
    Cleared,
    against_exploring_first,
    compare_bounds,
    table,
)
from conav.maps.load_floor_plan import load_floor_plan


def row(floor: str, edb: Bound, metres: float, team: int = 1, verdict: str = "captured") -> Cleared:
    return Cleared(floor, edb, verdict, team, metres, metres, 0, 0, 0)


def test_ratios_are_of_the_same_team_on_captured_floors() -> None:
    rows = [
        *(row("a", 1, 5.0), row("a", "unlimited", 10.0)),
        *(row("b", 1, 12.0), row("b", "unlimited", 10.0)),
        *(row("c", 1, 7.0), row("c", "unlimited", 10.0)),
        *(row("team", 1, 9.0, team=2), row("team", "unlimited", 10.0)),
        *(row("lost", 1, 9.0), row("lost", "unlimited", 10.0, verdict="")),
        *(row("still", 1, 0.0), row("still", "unlimited", 0.0)),
    ]
    (one,) = against_exploring_first(rows)
    assert one.edb == 1
    assert one.ratios == {"a": 0.5, "b": 1.2, "c": 0.7}
    assert one.median == 0.7
    assert one.above_one == {"b": 1.2}
    assert one.other_teams == ("team",)
    assert table([one])[-1] == "| 1 | 3 | 0.70 | 2 | `b` 1.20 | 1 |"
    (nothing,) = against_exploring_first([row("a", 1, 5.0)])
    assert isnan(nothing.median)


def test_a_floor_is_played_with_each_bound() -> None:
    told: list[Cleared] = []
    rows = compare_bounds(["rooms:2"], (2, "unlimited"), on_cleared=told.append)
    assert rows == told
    assert [one.edb for one in rows] == [2, "unlimited"]
    assert {one.verdict for one in rows} == {"captured"}
    assert all(one.distance_m == one.time_s > 0.0 for one in rows)  # one at a time, at 1 m/s
    (one,) = against_exploring_first(rows)
    assert list(one.ratios) == ["rooms:2"]


def test_the_study_has_floors_with_and_without_holes() -> None:
    holes = [len(load_floor_plan(name).holes) for name in FLOORS]
    assert min(holes) == 0 < max(holes)
    assert len(set(FLOORS)) == len(FLOORS) > 20
