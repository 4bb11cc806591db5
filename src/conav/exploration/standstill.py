"""How long a robot has wanted to drive and stood still: how it finds that it is stuck."""

from dataclasses import dataclass

from conav.exploration.types import TeamView


@dataclass
class Standstill:
    """Where a robot stands, and since when."""

    cell: int = -1
    heading: int = -1
    since_s: float = 0.0  # [s]

    def time_s(self, view: TeamView, drives: bool) -> float:
        """How long it has stood there facing that way, 0 while it does not want to `drive` [s]."""
        if not drives or (view.cell, view.heading) != (self.cell, self.heading):
            self.cell, self.heading, self.since_s = view.cell, view.heading, view.time_s
        return view.time_s - self.since_s
