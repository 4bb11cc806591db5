"""What the guards of a team hold.

The labels of the team are those of the shadows of its guards alone. A part that somebody clears
stays contaminated as a whole until it is done, so whatever becomes of who clears it, nothing else
has to be known of it.
"""

from collections import deque
from dataclasses import dataclass, field

from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.shadow_moves import Point
from conav.pursuit.shadow_parts import ShadowPart
from conav.pursuit.standing_guards import StandingGuards

_SLACK = 1e-9  # of the floor's area


@dataclass(eq=False)
class Task:
    """A part that somebody clears, or is stuck in."""

    shadows: int  # of the guards, as bits
    way: deque[int]


@dataclass(kw_only=True)
class Holdings:
    """Where guards stand, what is contaminated beyond them, and who clears which part of it."""

    graph: NavigationGraph
    guards: StandingGuards
    labels: ShadowLabels
    standing: dict[int, int] = field(default_factory=dict[int, int])  # guard -> place
    dirty: int = 1  # shadows of the guards, as bits
    tasks: dict[int, Task] = field(default_factory=dict[int, Task])

    def posts(self) -> tuple[Point, ...]:
        """Where guards stand."""
        return tuple(self.graph.points[place] for place in self.standing.values())

    def part(self, shadows: int) -> ShadowPart:
        """Shadows of the guards as a part."""
        return ShadowPart(tuple(sorted(set(self.standing.values()))), shadows)

    def slack_m2(self) -> float:
        """The area that counts as none [m^2]."""
        return _SLACK * self.guards.area((), 1)

    def taken(self) -> int:
        """The shadows somebody clears or is stuck in, as bits."""
        bits = 0
        for task in self.tasks.values():
            bits |= task.shadows
        return bits

    def stand(self, standing: dict[int, int]) -> None:
        """Others stand guard from now on; nobody moves meanwhile."""
        before = self.posts()
        self.standing = standing
        after = self.posts()
        self.dirty = self.guards.carried(before, after, self.dirty)
        for task in self.tasks.values():
            task.shadows = self.guards.carried(before, after, task.shadows)

    def can_leave(self, i: int) -> dict[int, int] | None:
        """The posts that are left when a guard goes; None where that contaminates anything."""
        rest = {j: place for j, place in self.standing.items() if j != i}
        posts = tuple(self.graph.points[place] for place in rest.values())
        after = self.guards.area(posts, self.guards.carried(self.posts(), posts, self.dirty))
        grows = after > self.guards.area(self.posts(), self.dirty) + self.slack_m2()
        return None if grows else rest

    def change_post(self, i: int, place: int) -> None:
        """A guard drove to another post; nobody clears anything meanwhile."""
        others = tuple(self.graph.points[other] for j, other in self.standing.items() if j != i)
        a, b = self.graph.points[self.standing[i]], self.graph.points[place]
        self.dirty = self.labels.after(others, a, b, self.dirty)
        for task in self.tasks.values():
            task.shadows = self.labels.after(others, a, b, task.shadows)
        self.standing[i] = place

    def second_post(self, i: int) -> tuple[float, float, int] | None:
        """The nearest place a guard sees that serves both tasks, and what going there costs.

        From there contaminated shadows are smaller, and nothing clear is contaminated.
        """
        post = self.standing[i]
        rest = [place for j, place in self.standing.items() if j != i]
        others = tuple(self.graph.points[place] for place in rest)
        before = self.guards.areas(self.posts(), self.dirty)
        for place in sorted(
            self.graph.joined[post].tolist(), key=lambda q: (self.graph.lengths[post, q], q)
        ):
            a, b = self.graph.points[post], self.graph.points[place]
            after = (*others, b)
            areas = self.guards.areas(after, self.labels.after(others, a, b, self.dirty))
            again = max(0.0, sum(areas) - sum(before))
            smaller = max(areas, default=0.0) < max(before, default=0.0) - self.slack_m2()
            if again <= self.slack_m2() and smaller:
                return float(self.graph.lengths[post, place]), again, place
        return None
