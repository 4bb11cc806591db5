"""Labels of critical vertices, clear or contaminated, as [Pellier2005] defines them.

They do not prove a capture. A region without a critical vertex has no label, and parts of the
inside can be hidden while all walls are seen. `conav.pursuit.shadow_labels` has labels that do.
"""

from dataclasses import dataclass, field
from typing import Literal

from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.shadow_moves import Point
from conav.pursuit.vertex_sight import VertexSight

Paths = Literal["all", "hidden", "partly-hidden"]
"""Through which vertices an evader gets from a contaminated one to a clear one; see `VertexLabels`.
"""


@dataclass
class VertexLabels:
    """Labels of the critical vertices of a navigation graph, or of some of them.

    A vertex is clear if it is seen and both its walls are seen entirely (section 3.2). While
    somebody drives, a clear vertex stays so unless a path in the graph leads to it from a
    contaminated one and it is not seen all the way. The paper does not say through which vertices
    paths lead: `all` of the graph; `hidden` ones, those not seen all the way; or `partly-hidden`
    ones, those that are not seen together with both walls at both ends of the drive. With several
    pursuers seen is what one of them sees, so the two walls may be seen by two.
    """

    graph: NavigationGraph
    sight: VertexSight
    nodes: tuple[int, ...]  # of the graph: vertex i of `sight` is node `nodes[i]`
    paths: Paths = "all"
    _near: list[int] = field(default_factory=list[int], repr=False)
    _clear: dict[Point, tuple[int, int, int]] = field(
        default_factory=dict[Point, tuple[int, int, int]], repr=False
    )

    def __post_init__(self) -> None:
        number = {node: i for i, node in enumerate(self.nodes)}
        for node in self.nodes:
            joined = self.graph.joined[node].tolist()
            self._near.append(sum(1 << number[other] for other in joined if other in number))

    def begin(self, team: tuple[Point, ...]) -> int:
        """The vertices that are contaminated at the beginning, as bits."""
        return self.sight.everything & ~self.clear_on_sight(team)

    def clear_on_sight(self, team: tuple[Point, ...]) -> int:
        """The vertices that a standing team sees together with both their walls, as bits."""
        seen = came = gone = 0
        for place in team:
            if place not in self._clear:
                self._clear[place] = (self.sight.seen(place), *self.sight.walls(place))
            one = self._clear[place]
            seen, came, gone = seen | one[0], came | one[1], gone | one[2]
        return seen & came & gone

    def after(self, others: tuple[Point, ...], a: Point, b: Point, contaminated: int) -> int:
        """The vertices that are contaminated after somebody drove from a to b, as bits.

        The others stand.
        """
        everything = self.sight.everything
        watched = self.sight.throughout(a, b)
        for place in others:
            watched |= self.sight.seen(place)
        open_to = everything
        if self.paths == "hidden":
            open_to = everything & ~watched
        elif self.paths == "partly-hidden":
            open_to &= ~(self.clear_on_sight((*others, a)) & self.clear_on_sight((*others, b)))
        lost = self._spread(contaminated & open_to, open_to) & ~watched
        return (contaminated | lost) & ~self.clear_on_sight((*others, b))

    def _spread(self, reached: int, open_to: int) -> int:
        """The vertices to which paths lead, those where they begin included."""
        waiting = reached
        while waiting:
            bit = waiting & -waiting
            new = self._near[bit.bit_length() - 1] & open_to & ~reached
            reached |= new
            waiting = (waiting ^ bit) | new
        return reached


def label_all(graph: NavigationGraph, sight: VertexSight, paths: Paths = "all") -> VertexLabels:
    """Labels of all critical vertices; `sight` is of these vertices, in the graph's order."""
    nodes = tuple(node for node, critical in enumerate(graph.critical.tolist()) if critical)
    return VertexLabels(graph, sight, nodes, paths)
