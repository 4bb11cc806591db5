"""A robot's graph: states in space and time, and the ways between them.

The vertices, in the order they came, say everything: vertex 0 is the start at time 0, and the
edges follow by a rule. With k the greater of the two vertices' numbers, plus 1, there is an edge
from u to w exactly when

1. t_u < t_w (in mode "paper" also u < w: from older to newer vertices alone, as in Algorithm 2
   Extend of [Zhu2014]),
2. |dx|^2 + |dy|^2 <= (v dt)^2: the robot can be in time,
3. |dx|^2 + |dy|^2 + (v dt)^2 <= r(k)^2 with the radius of `conav.planning.radius`,
4. the straight way is free of walls and discs (`conav.planning.obstacles`),
5. it has a word (`conav.planning.labels`): no region's border is met so closely that rounding
   decides; in mode "paper" the label changes once at most ("trace inclusive").

So it is for a robot that goes straight at constant speed. Where the motion is another, the way
from u to w is the motion's (`conav.planning.steering`) and exists when that finds one, (4) is asked
of its pieces and (5) of the borders they meet (`conav.planning.curves`).

Old graphs are part of newer ones and time makes every one acyclic, in both modes, which is what
the convergence of iNash needs. Mode "forward" has about twice the edges for the same vertices.
How vertices are found is no part of the rule (`conav.planning.extend`).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.planning.graph_arrays import (
    COUNTS,
    EDGES,
    ETA,
    FULL,
    GAMMA,
    ROOT,
    VERTICES,
    WORDS,
    Graph,
    Memory,
    Surroundings,
    cell_of,
    letter_of,
    scratch,
)
from conav.planning.insert import insert
from conav.planning.insert_curved import insert_curved
from conav.planning.labels import point_label
from conav.planning.radius import connection_radius
from conav.planning.steering import MOTION, SPEED, STRAIGHT

MAX_CELLS = 1 << 20
_CELLS = 2  # of a graph in the greatest radius


@dataclass(eq=False)
class RobotGraph:
    """A growing graph of one robot. `arrays` is replaced when it gets too short."""

    surroundings: Surroundings
    arrays: Graph
    memory: Memory = field(init=False)

    def __post_init__(self) -> None:
        self.memory = scratch(len(self.arrays.states))

    @property
    def straight(self) -> bool:
        """Whether the robot's ways are straight and at constant speed."""
        return self.surroundings.limits[MOTION] == STRAIGHT

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Shape (n, numbers of a state), in order of insertion: a view."""
        return self.arrays.states[: self.size]

    @property
    def size(self) -> int:
        return int(self.arrays.counts[VERTICES])

    @property
    def edges(self) -> int:
        return int(self.arrays.counts[EDGES])

    def radius_at(self, count: int) -> float:
        """The connection radius [m] for the vertex that makes them `count`."""
        rule = self.surroundings.rule
        return connection_radius(count, float(rule[GAMMA]), float(rule[ETA]), int(rule[ROOT]))

    def enlarge(self) -> None:
        """Twice the room for whatever is more than half full, and for all where nothing is."""
        graph = self.arrays
        used = {
            "states": graph.counts[VERTICES],
            "links": graph.counts[VERTICES],
            "edges": graph.counts[EDGES],
            "lengths": graph.counts[EDGES],
            "words": graph.counts[WORDS],
        }
        full = [name for name in used if 2 * used[name] >= len(getattr(graph, name))]
        longer: dict[str, NDArray[np.generic]] = {}
        for name in full or used:
            old = getattr(graph, name)
            new = np.empty((2 * len(old), *old.shape[1:]), old.dtype)
            new[: len(old)] = old
            longer[name] = new
        self.arrays = graph._replace(**longer)
        self.memory = scratch(len(self.arrays.states))

    def insert(self, states: NDArray[np.float64]) -> int:
        """How many of these states, (m, numbers), came in as vertices, each with all its edges."""
        add = insert if self.straight else insert_curved
        added = 0
        done = 0
        while done < len(states):
            outcome = add(*self.surroundings.arrays, *self.arrays, states[done], *self.memory)
            if outcome == FULL:
                self.enlarge()
            else:
                added += outcome
                done += 1
        return added


def build_graph(
    surroundings: Surroundings,
    bounds: tuple[float, float, float, float],
    horizon_s: float,
    start: NDArray[np.float64],
) -> RobotGraph:
    """The graph of the start alone, (numbers of a state,), its letter being one of the task's."""
    x0, y0, x1, y1 = bounds
    extent = surroundings.limits[SPEED] * horizon_s
    cell = float(surroundings.rule[ETA]) / _CELLS
    while ((x1 - x0) / cell + 1) * ((y1 - y0) / cell + 1) * (extent / cell + 1) > MAX_CELLS:
        cell *= 2
    columns, rows, layers = (int(size / cell) + 1 for size in (x1 - x0, y1 - y0, extent))
    room, edges = 256, 1024
    graph = Graph(
        np.empty((room, len(start))),
        np.empty((room, 2), np.int32),
        np.full(columns * rows * layers, -1, np.int32),
        np.empty((edges, 3), np.int32),
        np.empty(edges),
        np.empty(256, np.int32),
        np.zeros(COUNTS, np.int64),
        np.array([x0, y0, cell, columns, rows, layers]),
    )
    x, y, t = start[:3].tolist()
    graph.states[0] = start
    label = point_label(*surroundings.regions, x, y)
    graph.links[0] = letter_of(surroundings.masks, label), -1
    graph.heads[cell_of(graph.box, float(surroundings.limits[SPEED]), x, y, t)] = 0
    graph.counts[VERTICES] = 1
    return RobotGraph(surroundings, graph)
