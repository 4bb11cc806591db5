"""The navigation graph of what is known of a floor [Pellier2005, section 3.1], and ways in it.

Its vertices are the critical vertices seen up to now, and the places where pursuers entered. Two
are joined as soon as it is certain that they see each other: when the segment between them lies in
the known region. The paper joins a vertex to those seen from it when somebody stands there; here
vertices that nobody visited are joined too. Weights are metres driven.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from conav.pursuit.roadmap import Roadmap, join_places
from conav.pursuit.sensor import Point
from conav.pursuit.survey import Survey


def navigation_graph(survey: Survey, places: Sequence[Point]) -> Roadmap:
    """The graph of a survey: these places first, then critical vertices."""
    return join_places(survey.mesh, list(dict.fromkeys((*places, *survey.critical))))


def walking_distances(graph: Roadmap, start: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Metres from a vertex to each other, and the vertex before each on a shortest way.

    inf, and a negative number, where there is no way.
    """
    lengths = np.where(np.isfinite(graph.lengths), graph.lengths, 0.0)
    metres, before = dijkstra(
        csr_matrix(lengths), directed=False, indices=[start], return_predecessors=True
    )
    return metres[0], before[0].astype(np.int64)


def way_to(before: NDArray[np.int64], start: int, end: int) -> list[int]:
    """The vertices on the way, both ends included; `before` as `walking_distances` gives it."""
    way = [end]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return way[::-1]
