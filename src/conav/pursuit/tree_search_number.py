"""The search number of a tree: how few searchers clear it when evaders hide on edges and vertices.

Searchers are put on vertices, taken away, and moved along edges, which clears these; an evader of
unbounded speed gets everywhere that no searcher blocks [Parsons1976].
"""

from collections.abc import Sequence

Label = tuple[tuple[int, bool], ...]
"""Of a rooted tree: its vertex separation, and whether a vertex of it is critical, that is, has two
children of that separation; if so, the label of what is left without that vertex's subtree."""


def tree_search_number(edges: Sequence[tuple[int, int]]) -> int:
    """The search number of the tree with these edges; 1 without edges, for a vertex alone.

    It is the vertex separation of the tree with two vertices put on each edge, which is found with
    labels from the leaves to a root [Ellis1994]. A merge takes as long as labels are, and they fall
    strictly, so all takes O(n log n). Raises `ValueError` where edges make no tree.

    >>> tree_search_number([(0, 1), (1, 2)]), tree_search_number([(0, 1), (0, 2), (0, 3)])
    (1, 2)
    """
    around: dict[int, list[int]] = {}
    for a, b in edges:
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    if not edges:
        return 1
    root = edges[0][0]
    parent = {root: root}
    order = [root]
    for vertex in order:
        for other in around[vertex]:
            if other not in parent:
                parent[other] = vertex
                order.append(other)
    if len(order) != len(around) or len(edges) != len(around) - 1:
        raise ValueError("these edges make no tree")
    below: dict[int, list[Label]] = {vertex: [] for vertex in order}
    for vertex in reversed(order):
        label = _merged(below.pop(vertex))
        if vertex == root:
            return label[0][0]
        # Two vertices on the edge to the parent.
        below[parent[vertex]].append(_merged([_merged([label])]))
    raise AssertionError("the root comes last")


def _merged(children: Sequence[Label]) -> Label:
    """The label of a root with these subtrees."""
    children = [label for label in children if label]
    if not children:
        return ((0, False),)
    most = max(label[0][0] for label in children)
    if most == 0:
        return ((1, False),)
    top = [label for label in children if label[0][0] == most]
    critical = any(label[0][1] for label in top)
    if len(top) > 2 or (len(top) == 2 and critical):
        return ((most + 1, False),)
    if len(top) == 2:
        return ((most, True),)  # the root is critical, and nothing is left without it
    if not critical:
        return ((most, False),)
    rest = _merged([*(label for label in children if label is not top[0]), top[0][1:]])
    return ((most + 1, False),) if rest[0][0] >= most else ((most, True), *rest)
