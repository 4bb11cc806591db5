"""What the reproduction plays: studies, their floors, and what a case's outcome follows from."""

import json
from collections.abc import Sequence
from typing import NamedTuple

from conav import __version__
from conav.experiments.compare.source import source_hash
from conav.experiments.pursuit.interleaving import BOUNDS

INTERLEAVING, GRAPHS, ORDERS, MESSAGES, TEAMS, WALLS = (
    "interleaving", "graphs", "orders", "messages", "teams", "walls",
)  # fmt: skip

FAMILIES: dict[str, tuple[str, ...]] = {
    "comb": ("comb:3", "comb:6", "comb:9"),
    "rooms": ("rooms:2", "rooms:3", "rooms:4"),
    "spider": ("spider:1,1,2", "spider:2,2,2", "spider:2,3,3"),
    "triples": ("triples:1", "triples:2", "triples:3"),
    "streets": ("streets:2", "streets:3", "streets:4"),
}
"""Made floors, each family in order of size."""
SIZES = max(len(floors) for floors in FAMILIES.values())

NINE = "nine-corners"
NINE_CORNERS = (
    (2.9804, 6.3622), (-0.6928, 0.0), (-5.0, 0.0), (-5.0, -0.6), (2.3464, -0.6),
    (4.5, -4.3301), (5.0196, -4.0301), (1.3464, 2.3321), (3.5, 6.0622),
)  # fmt: skip
"""Three crossing corridors [m]. From their ends all walls are seen, and not a triangle between."""
NINE_STARTS = ((-5.0, 0.0), (4.5, -4.3301), (3.5, 6.0622))

TEAM_SIZES = (3, 6, 12, 24)
LABELS = ("shadows", "paper")
METHODS = ("known-map", "guards", "delegation", "paper labels", "paper labels, split")
PAPER_LIMIT = 3000
"""States of a pursuit graph with the paper's labels; more count as no plan."""
PAPER_MOST = 4
"""Pursuers that may be sent with the paper's labels on the whole floor."""

_TREE = "corridor-tree:"


class Case(NamedTuple):
    """One run that is kept: a study, a floor, and what is varied."""

    study: str
    floor: str
    setting: str


def is_random(floor: str) -> bool:
    """Whether a floor is one of a number of independent ones; intervals are over these alone."""
    return floor.startswith(_TREE)


def all_cases(runs: int, seed: int, sizes: int) -> list[Case]:
    """All cases: `runs` random floors with the seeds from `seed` on, `sizes` of each family."""
    small, large = (
        [f"{_TREE}segments={segments},seed={one}" for one in range(seed, seed + runs)]
        for segments in (12, 20)
    )
    made = {name: floors[:sizes] for name, floors in FAMILIES.items()}
    every = [floor for floors in made.values() for floor in floors]
    few = [*made["comb"], *made["rooms"], *made["spider"], *made["streets"][:1], "ring"]
    parted = [*made["spider"], *made["triples"]]
    return [
        *_cases(INTERLEAVING, [*few, *small], [str(bound) for bound in BOUNDS]),
        *_cases(GRAPHS, [*every, *large], LABELS),
        *_cases(ORDERS, [*parted, *large], [""]),
        *_cases(MESSAGES, [*parted, *large], [str(size) for size in TEAM_SIZES]),
        *_cases(TEAMS, [*every, "ring", *large], METHODS),
        Case(WALLS, NINE, "paper labels"),
    ]


def _cases(study: str, floors: Sequence[str], settings: Sequence[str]) -> list[Case]:
    return [Case(study, floor, setting) for floor in floors for setting in settings]


_PLAYS = (
    "conav.experiments.pursuit.play",
    "conav.pursuit.clear_known_map",
    "conav.pursuit.clear_by_guards",
    "conav.pursuit.clear_by_vertex_labels",
    "conav.maps.floor_plans.catalogue",
)
"""What outcomes follow from."""


def code_of_cases() -> str:
    """A hash of all code that outcomes follow from."""
    return source_hash(*_PLAYS)


def case_key(case: Case, code: str) -> str:
    """All that a case's outcome follows from, as JSON."""
    limits = [PAPER_LIMIT, PAPER_MOST] if case.study in (TEAMS, WALLS) else []
    known = {"conav": __version__, "code": code, "limits": limits}
    return json.dumps({**known, **case._asdict()}, sort_keys=True)
