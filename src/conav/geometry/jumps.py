"""What lies along straight runs and diagonals from a cell, for `jump_graph`.

From a cell a search goes straight on in four directions, and along four diagonals, from each cell
of which it goes straight on in the two directions of its parts. It need not turn before it comes to
a cell that has other successors.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2

MORE_NODES = -1
"""There are more nodes than there is room for."""
MORE_EDGES = -2
MORE_HITS = -3


@kernel
def node_at(
    cell: int, node_of: NDArray[np.int32], nodes: NDArray[np.int32], used: NDArray[np.int64]
) -> int:
    """The node of a cell, a new one where there was none, -1 where there is no room for it."""
    node = node_of[cell]
    if node < 0:
        node = used[0]
        if node == nodes.shape[0]:
            return -1
        used[0] += 1
        node_of[cell] = node
        nodes[node, 0] = cell
        nodes[node, 1] = -1  # nobody looked around there yet
    return node


@kernel
def look_around(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    node: int,
    line_first: NDArray[np.int64],
    on_line: NDArray[np.int32],
    node_of: NDArray[np.int32],
    nodes: NDArray[np.int32],
    edges: NDArray[np.int32],
    hits: NDArray[np.int32],
    used: NDArray[np.int64],
    best: NDArray[np.int32],
    least: NDArray[np.float64],
    seen: NDArray[np.int32],
) -> int:
    """0 when what lies along runs from a node is written, or what there is too little room for.

    Edges lead to other nodes; a hit is the nearest place of a group, the first of equals.
    """
    rows, cols = moves.shape
    flat = moves.reshape(-1)
    start = nodes[node, 0]
    n_edges = used[1]
    count = 0  # of groups seen
    lack = 0
    for k in range(8):
        r = start // cols
        c = start % cols
        cell = start
        more = 0
        while lack == 0:
            turn = False
            if k >= 4:
                if flat[cell] & (1 << k) == 0:
                    break
                r += DROW[k]
                c += DCOL[k]
                cell += DROW[k] * cols + DCOL[k]
                more += 1
                turn = only[cell] & (1 << k) == 0
            # Straight on, or the two straight parts of the diagonal, along the row first. Where a
            # diagonal comes to a node, nothing but the cell itself.
            for part in range(1 if k < 4 or turn else 2):
                q = k
                if k >= 4:
                    q = 1 - DCOL[k] if part == 0 else 2 - DROW[k]
                step = DROW[q] * cols + DCOL[q]
                run = 0
                if not turn and flat[cell] & (1 << q):
                    run = int(runs[q, cell + step])
                far = abs(run)
                along_row = q % 2 == 0
                line = r if along_row else rows + c
                origin = c if along_row else r
                low = origin if q < 2 else origin - far
                high = origin + far if q < 2 else origin
                i = line_first[line]
                end = line_first[line + 1]
                stop = end
                while stop - i > 4:  # many lie before
                    middle = (i + stop) // 2
                    if on_line[middle, 0] < low:
                        i = middle
                    else:
                        stop = middle
                while i < end:
                    at = on_line[i, 0]
                    if at > high:
                        break
                    if at >= low:
                        j = on_line[i, 1]
                        straight = abs(at - origin)
                        reached = straight + more * SQRT2
                        if least[j] == np.inf:
                            seen[count] = j
                            count += 1
                        if reached < least[j] or (
                            reached == least[j] and on_line[i, 2] < best[j, 2]
                        ):
                            least[j] = reached
                            best[j, 0] = straight
                            best[j, 1] = more
                            best[j, 2] = on_line[i, 2]
                    i += 1
                if turn or run > 0:
                    other = node_at(cell + far * step, node_of, nodes, used)
                    if other < 0:
                        lack = MORE_NODES
                        break
                    if n_edges == edges.shape[0]:
                        lack = MORE_EDGES
                        break
                    edges[n_edges, 0] = other
                    edges[n_edges, 1] = far
                    edges[n_edges, 2] = more
                    n_edges += 1
            if k < 4 or turn:
                break
    n_hits = used[2]
    if lack == 0 and n_hits + count > hits.shape[0]:
        lack = MORE_HITS
    for i in range(count):
        j = seen[i]
        least[j] = np.inf
        if lack == 0:
            hits[n_hits + i, 0] = j
            hits[n_hits + i, 1] = best[j, 0]
            hits[n_hits + i, 2] = best[j, 1]
            hits[n_hits + i, 3] = best[j, 2]
    if lack == 0:
        nodes[node, 1] = used[1]
        nodes[node, 2] = n_edges
        nodes[node, 3] = n_hits
        nodes[node, 4] = n_hits + count
        used[1] = n_edges
        used[2] = n_hits + count
    return lack
