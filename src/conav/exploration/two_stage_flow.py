"""The flowchart of the two-stage strategy, Figure 2 of [Dai2018], as a table."""

from enum import StrEnum


class Phase(StrEnum):
    """Where a robot is in the flowchart."""

    VOTE = "vote"
    FIRST = "rectangle of stage 1"
    AUCTION = "auction"
    APPROACH = "way to a lane"
    SCAN = "rectangle in a section"
    REST = "nearest frontier"


STAGE = {
    Phase.VOTE: 1,
    Phase.FIRST: 1,
    Phase.AUCTION: 2,
    Phase.APPROACH: 2,
    Phase.SCAN: 2,
    Phase.REST: 2,
}
"""The stage of the paper that a phase belongs to."""

FLOW: dict[tuple[Phase, str], Phase] = {
    (Phase.VOTE, "auxiliary direction chosen"): Phase.FIRST,
    (Phase.FIRST, "trajectory closed"): Phase.AUCTION,
    (Phase.FIRST, "no unknown area to explore"): Phase.AUCTION,
    (Phase.FIRST, "other common direction heard of"): Phase.AUCTION,
    (Phase.AUCTION, "section awarded"): Phase.APPROACH,
    (Phase.AUCTION, "no section left"): Phase.REST,
    (Phase.APPROACH, "arrived"): Phase.SCAN,
    (Phase.APPROACH, "width of the section is 0"): Phase.AUCTION,
    (Phase.APPROACH, "other common direction heard of"): Phase.AUCTION,
    (Phase.SCAN, "trajectory closed"): Phase.APPROACH,
    (Phase.SCAN, "other common direction heard of"): Phase.AUCTION,
    (Phase.REST, "section on offer"): Phase.AUCTION,
}
"""(phase, event) -> phase: Figure 2, with what we added for limited radios and for obstacles."""

ADDED = frozenset(
    {
        "other common direction heard of",
        "no section left",
        "section on offer",
    }
)
"""Events that are not of the paper: radios that do not reach everybody, and obstacles."""


def flow_table() -> str:
    """The strategy's transitions as a Markdown table, made from `FLOW`."""
    rows = ["| phase | event | next phase |", "|---|---|---|"]
    rows += [f"| {phase} | {event} | {then} |" for (phase, event), then in FLOW.items()]
    return "\n".join(rows)
