"""Parts cleared one after the other, or at once, and with a guard lost on the way."""

from collections.abc import Sequence
from typing import NamedTuple

from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.delegation import Delegation
from conav.pursuit.splitting import Order
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_schedule
from conav.robots.fault import Fault

ORDERS: tuple[Order, ...] = ("sequence", "parallel")


class Cleared(NamedTuple):
    """How one floor was cleared by delegation."""

    floor: str
    order: Order
    lost_s: float | None  # when a guard was lost, None for none
    recontaminated_m2: float  # by that
    pursuers: int  # sent
    time_s: float
    distance_m: float
    messages: int
    captured: bool  # as the verifier finds


def orders_and_losses(names: Sequence[str], share: float = 0.5) -> list[Cleared]:
    """For each floor both orders, without a loss and with one.

    Lost is the first guard that was posted, that part of the undisturbed time after it came which
    `share` says; where nobody stands guard it is the first pursuer, after that part of all.
    """
    rows: list[Cleared] = []
    for name in names:
        floor = load_floor_plan(name)
        for order in ORDERS:
            whole = _cleared(floor, order, ())
            rows.append(_row(name, order, floor, whole, None))
            end = float(whole.schedule.times[-1])
            held = [entry for entry in whole.history if entry["what"] == "holds"]
            numbers = {one.name: i for i, one in enumerate(whole.pursuers)}
            who = numbers[held[0]["pursuer"]] if held else 0
            begin = float(held[0]["time_s"]) if held else 0.0
            at = begin + share * (end - begin)
            disturbed = _cleared(floor, order, (Fault(who, "dies", at),))
            rows.append(_row(name, order, floor, disturbed, at))
    return rows


def _cleared(floor: PolygonMap, order: Order, faults: tuple[Fault, ...]) -> PursuitResult:
    team = (Pursuer("pursuer_1", default_start(floor)),)
    return Delegation(order=order).solve(PursuitProblem(floor, team, faults=faults))


def _row(
    name: str, order: Order, floor: PolygonMap, result: PursuitResult, lost_s: float | None
) -> Cleared:
    found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
    again = sum(float(entry.get("recontaminated_m2", 0.0)) for entry in result.history)
    return Cleared(
        name,
        order,
        lost_s,
        again,
        len(result.pursuers),
        float(result.schedule.times[-1]),
        result.schedule.distance_m,
        result.counters["messages"],
        found.verdict == "captured",
    )
