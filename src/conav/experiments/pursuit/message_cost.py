"""Messages of the delegation protocol against the size of the team [Pellier2005], section 4."""

from collections.abc import Sequence
from typing import NamedTuple

from conav.maps.load_floor_plan import load_floor_plan
from conav.pursuit.delegation import Delegation
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem
from conav.pursuit.verify import verify_schedule


class MessageCost(NamedTuple):
    """What clearing one floor took a team of one size."""

    floor: str
    pursuers: int  # at the end
    deliberations: int
    rounds: int  # of all deliberations
    messages: int
    longest_round: int  # messages of the round with most
    size_bytes: int
    captured: bool  # as the verifier finds


def round_bound(pursuers: int) -> int:
    """The most messages a round of a deliberation can take in a team of this size."""
    return 7 * (pursuers - 1) + 1


def messages_by_team_size(
    name: str, sizes: Sequence[int], method: Delegation | None = None
) -> list[MessageCost]:
    """What teams that begin with so many pursuers say to each other on a floor."""
    floor = load_floor_plan(name)
    start = default_start(floor)
    rows: list[MessageCost] = []
    for size in sizes:
        team = tuple(Pursuer(f"pursuer_{i}", start) for i in range(1, size + 1))
        result = (method or Delegation()).solve(PursuitProblem(floor, team))
        counters = result.counters
        found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
        rows.append(
            MessageCost(
                name,
                len(result.pursuers),
                counters["deliberations"],
                counters["talks"],
                counters["messages"],
                counters["longest_talk"],
                counters["bytes"],
                found.verdict == "captured",
            )
        )
    return rows
