"""A schedule made round by round: all who drive in a round begin together and arrive together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from conav.pursuit.shadow_moves import Point
from conav.pursuit.types import Pursuer, Schedule


@dataclass
class Rounds:
    """Where everybody is after each round. Who is not sent yet stands at its start, unseeing.

    Rounds are barriers: what the team knows after one is of one moment.
    """

    pursuers: list[Pursuer]
    present: list[bool]
    times: list[float] = field(default_factory=lambda: [0.0])
    rows: list[list[Point]] = field(default_factory=list[list[Point]])
    active: list[list[bool]] = field(default_factory=list[list[bool]])

    @classmethod
    def of(cls, pursuers: Sequence[Pursuer]) -> "Rounds":
        """A team at its starts, before anything happened."""
        starts = [(float(one.start[0]), float(one.start[1])) for one in pursuers]
        return cls(list(pursuers), [True] * len(pursuers), rows=[starts])

    @property
    def now(self) -> float:
        """The time after the last round [s]."""
        return self.times[-1]

    @property
    def places(self) -> list[Point]:
        """Where everybody is."""
        return self.rows[-1]

    def enter(self, pursuer: Pursuer) -> int:
        """The number of a pursuer that joins at its start, now."""
        start = (float(pursuer.start[0]), float(pursuer.start[1]))
        self.pursuers.append(pursuer)
        self.present.append(True)
        for row in self.rows:
            row.append(start)
        for flags in self.active:
            flags.append(False)
        return len(self.pursuers) - 1

    def lasts(self, moves: Mapping[int, Point]) -> float:
        """How long a round with these drives takes [s]."""
        return max(
            (_length(self.places[i], end) / self.pursuers[i].speed_mps for i, end in moves.items()),
            default=0.0,
        )

    def drive(self, moves: Mapping[int, Point], lasts: float | None = None) -> None:
        """A round in which pursuers drive straight to these points; the slowest gives the pace."""
        duration = self.lasts(moves) if lasts is None else lasts
        self.rows.append([moves.get(i, place) for i, place in enumerate(self.places)])
        self.times.append(self.now + duration)
        self.active.append(list(self.present))

    def lose(self, pursuer: int) -> None:
        """From now on this pursuer sees nothing."""
        if not any(flags[pursuer] for flags in self.active):
            self.drive({})  # it was there
        self.present[pursuer] = False

    def schedule(self) -> Schedule:
        """All rounds; who did nothing yet looks round for no time."""
        seeing = [any(flags) for flags in zip(*self.active, strict=True)] or [False]
        if not all(seeing):
            self.drive({})
        return Schedule(np.array(self.times), np.array(self.rows), np.array(self.active))


def _length(a: Point, b: Point) -> float:
    return ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
