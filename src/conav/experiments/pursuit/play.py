"""One case of the reproduction: what is kept of it."""

from dataclasses import dataclass
from typing import Any

from conav.experiments.pursuit.graph_size import graph_sizes
from conav.experiments.pursuit.interleaving import clear_floor
from conav.experiments.pursuit.message_cost import messages_by_team_size
from conav.experiments.pursuit.orders import orders_and_losses
from conav.experiments.pursuit.world import (
    GRAPHS,
    INTERLEAVING,
    MESSAGES,
    NINE,
    NINE_CORNERS,
    NINE_STARTS,
    ORDERS,
    PAPER_LIMIT,
    PAPER_MOST,
    Case,
)
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import Method
from conav.pursuit.clear_by_guards import ClearByGuards
from conav.pursuit.clear_by_vertex_labels import ClearByVertexLabels
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.clear_unknown_map import ClearUnknownMap
from conav.pursuit.delegation import Delegation
from conav.pursuit.splitting import SplittingByVertexLabels
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem
from conav.pursuit.verify import verify_schedule


@dataclass(frozen=True)
class Played:
    """What is kept of a case: a row of numbers and words, or several."""

    rows: tuple[dict[str, Any], ...]

    @staticmethod
    def read(content: dict[str, Any]) -> "Played":
        """What was kept. Raises `TypeError` for what is none."""
        rows: Any = content.get("rows")
        if set(content) != {"rows"} or not isinstance(rows, list):
            raise TypeError("no outcome")
        kept: list[Any] = rows
        if not all(isinstance(row, dict) for row in kept):
            raise TypeError("no outcome")
        return Played(tuple(kept))


def play(case: Case) -> Played:
    """What is kept of a case. Raises what the studies raise."""
    if case.study == INTERLEAVING:
        edb = "unlimited" if case.setting == "unlimited" else int(case.setting)
        return Played((clear_floor(case.floor, ClearUnknownMap(edb=edb))._asdict(),))
    if case.study == GRAPHS:
        labels = "paper" if case.setting == "paper" else "shadows"
        return Played(tuple(one._asdict() for one in graph_sizes([case.floor], labels)))
    if case.study == ORDERS:
        return Played(tuple(one._asdict() for one in orders_and_losses([case.floor])))
    if case.study == MESSAGES:
        found = messages_by_team_size(case.floor, [int(case.setting)])
        return Played(tuple(one._asdict() for one in found))
    return Played((_team(case.floor, case.setting),))


def _team(name: str, which: str) -> dict[str, Any]:
    """The team a method sends, and whether the verifier agrees that the floor is clear."""
    methods: dict[str, Method] = {
        "known-map": ClearKnownMap(),
        "guards": ClearByGuards(cover="fewest"),
        "delegation": Delegation(),
        "paper labels": ClearByVertexLabels(limit=PAPER_LIMIT),
        "paper labels, split": SplittingByVertexLabels(limit=PAPER_LIMIT),
    }
    floor = PolygonMap(NINE_CORNERS) if name == NINE else load_floor_plan(name)
    starts = NINE_STARTS if name == NINE else [default_start(floor)]
    team = tuple(Pursuer(f"pursuer_{i}", start) for i, start in enumerate(starts, 1))
    most = PAPER_MOST if which == "paper labels" else None
    result = methods[which].solve(PursuitProblem(floor, team, most=most, name=name))
    verdict = ""
    if result.status == "done":
        found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
        verdict = str(found.verdict)
    return {
        "floor": name,
        "method": which,
        "corners": len(floor.vertices),
        "holes": len(floor.holes),
        "verdict": verdict,  # "" where the method gave up
        "pursuers": len(result.pursuers),
        "lower_bound": result.lower_bound,
        "distance_m": result.schedule.distance_m,
        "time_s": float(result.schedule.times[-1]),
    }
