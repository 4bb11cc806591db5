"""Which faces of an arrangement are hidden at both ends of a motion, and throughout it.

The rules and their proofs: docs/pursuit-verifier.md, section 3. A view is flooded from the viewer
without crossing its windows, and what is seen all along a motion from the motion's path without
crossing the windows of either end.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.pursuit.verify_arrangement import root, unite

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Columns of a mover: rows of its positions before and after, the segment it drives on (-1: it
# stands), and whether it counts for the old view, for the new one and for what is seen throughout.
BEFORE, AFTER, PATH, OLD, NEW, THROUGHOUT = range(6)


class Regions(NamedTuple):
    """Hidden regions as sets of faces; -1 where a face belongs to none."""

    inside: Flags  # (faces,) whether a face is of the floor
    old: Ints  # (faces,) the shadow before the motion, numbered canonically
    new: Ints  # (faces,) the shadow after it
    unseen: Ints  # (faces,) the component of what is not seen throughout
    n_old: int
    n_new: int
    links: Flags  # (n_old, n_new) whether somebody may get from one shadow to the other unseen


@kernel
def _flood(
    face: Ints, same: Ints, blocked: Flags, starts: Flags, faces: int, reached: Flags
) -> None:
    """Mark in `reached` the faces that the start faces lead to over edges that do not block."""
    parent = np.arange(faces)
    for e in range(blocked.shape[0]):
        if not blocked[e] and same[2 * e] == 2 * e:
            unite(parent, face[2 * e], face[2 * e + 1])
    held = np.zeros(faces, dtype=np.bool_)
    for f in range(faces):
        if starts[f]:
            held[root(parent, f)] = True
    for f in range(faces):
        if held[root(parent, f)]:
            reached[f] = True


@kernel
def _block(
    segment: Ints, same: Ints, owner: Ints, n_walls: int, one: int, two: int, blocked: Flags
) -> None:
    """Mark the edges that are walls or on windows of positions `one` and `two`."""
    blocked[:] = False
    for e in range(segment.shape[0]):
        s = segment[e]
        if s < n_walls or owner[s] == one or owner[s] == two:
            blocked[same[2 * e] // 2] = True


@kernel
def _dark(
    segment: Ints, face: Ints, owner: Ints, pocket: Ints, n_walls: int, position: int, dark: Flags
) -> None:
    """Mark the faces behind the windows of a position, and those outside the floor by a wall."""
    for e in range(segment.shape[0]):
        s = segment[e]
        if s < n_walls:
            dark[face[2 * e + 1]] = True
        elif owner[s] == position:
            dark[face[2 * e] if pocket[s] > 0 else face[2 * e + 1]] = True


@kernel
def _mark_shown(
    segment: Ints, same: Ints, owner: Ints, shown: Flags, position: int, marks: Flags
) -> None:
    """Mark the edges that are seen from a position because they lie on its windows."""
    for e in range(segment.shape[0]):
        if owner[segment[e]] == position and shown[segment[e]]:
            marks[same[2 * e] // 2] = True


@kernel
def _number(
    first: Ints,
    face: Ints,
    same: Ints,
    segment: Ints,
    owner: Ints,
    n_walls: int,
    hidden: Flags,
    closed: Flags,
    counts: Flags,
    number: Ints,
) -> int:
    """Number the components of the hidden faces by where they are met first along the walls and
    then along the windows of the positions that count; return how many there are.

    Nobody crosses edges that are `closed`.
    """
    faces = hidden.shape[0]
    parent = np.arange(faces)
    for e in range(segment.shape[0]):
        left, right = face[2 * e], face[2 * e + 1]
        if hidden[left] and hidden[right] and same[2 * e] == 2 * e and not closed[e]:
            unite(parent, left, right)
    of_root = np.full(faces, -1, dtype=np.int64)
    total = 0
    for s in range(first.shape[0] - 1):
        if s >= n_walls and (owner[s] < 0 or not counts[owner[s]]):
            continue
        for h in range(2 * first[s], 2 * first[s + 1]):
            if hidden[face[h]]:
                r = root(parent, face[h])
                if of_root[r] < 0:
                    of_root[r] = total
                    total += 1
    for f in range(faces):
        number[f] = of_root[root(parent, f)] if hidden[f] else -1
    return total


@kernel
def classify(
    first: Ints,
    segment: Ints,
    face: Ints,
    same: Ints,
    faces: int,
    n_walls: int,
    owner: Ints,
    pocket: Ints,
    shown: Flags,
    anchors: Ints,
    movers: Ints,
    instant: bool,
) -> tuple[Flags, Ints, Ints, Ints, int, int, Flags]:
    """The fields of the `Regions` of a motion.

    Segment s is a window of position `owner[s]` (-1: of none) with its hidden side on the left
    where `pocket[s]` is 1, on the right where it is -1; `shown[s]`: all of it is seen from there.
    `anchors` (positions,) are segments that
    begin at each position. In an instant views change though nobody moves: who counts for the old
    or the new view sees at that moment.
    """
    n_edges = segment.shape[0]
    blocked = np.empty(n_edges, dtype=np.bool_)
    starts = np.zeros(faces, dtype=np.bool_)
    dark = np.zeros(faces, dtype=np.bool_)
    # Outside the floor: what walls have on their right, and what that is joined to.
    outside = np.zeros(faces, dtype=np.bool_)
    _block(segment, same, owner, n_walls, -2, -2, blocked)
    for h in range(1, 2 * first[n_walls], 2):
        starts[face[h]] = True
    _flood(face, same, blocked, starts, faces, outside)
    seen_old = outside.copy()
    seen_new = outside.copy()
    throughout = outside.copy()
    view = np.empty(faces, dtype=np.bool_)
    n_positions = anchors.shape[0]
    counts_old = np.zeros(n_positions, dtype=np.bool_)
    counts_new = np.zeros(n_positions, dtype=np.bool_)
    closed_old = np.zeros(n_edges, dtype=np.bool_)
    closed_new = np.zeros(n_edges, dtype=np.bool_)
    closed = np.zeros(n_edges, dtype=np.bool_)
    on_one = np.empty(n_edges, dtype=np.bool_)
    on_two = np.empty(n_edges, dtype=np.bool_)
    for i in range(movers.shape[0]):
        for end in range(2):
            position = movers[i, end]
            if end == 1 and movers[i, PATH] < 0:
                break
            view[:] = False
            starts[:] = False
            dark[:] = False
            _dark(segment, face, owner, pocket, n_walls, position, dark)
            begin = first[anchors[position]]
            for h in range(2 * begin, 2 * begin + 2):
                starts[face[h]] = not dark[face[h]]
            _block(segment, same, owner, n_walls, position, position, blocked)
            _flood(face, same, blocked, starts, faces, view)
            if end == 0 and movers[i, OLD] == 1:
                seen_old |= view
                counts_old[position] = True
                _mark_shown(segment, same, owner, shown, position, closed_old)
            if (end == 1 or movers[i, PATH] < 0) and movers[i, NEW] == 1:
                seen_new |= view
                counts_new[position] = True
                _mark_shown(segment, same, owner, shown, position, closed_new)
            if movers[i, PATH] < 0 and movers[i, THROUGHOUT] == 1:
                throughout |= view
        if movers[i, THROUGHOUT] == 1:
            # What lies on windows of both ends lies in line with them, and is seen throughout.
            on_one[:] = False
            on_two[:] = False
            _mark_shown(segment, same, owner, shown, movers[i, BEFORE], on_one)
            _mark_shown(segment, same, owner, shown, movers[i, AFTER], on_two)
            closed |= on_one & on_two
        if movers[i, PATH] >= 0 and movers[i, THROUGHOUT] == 1:
            starts[:] = False
            dark[:] = False
            path = movers[i, PATH]
            one, two = movers[i, BEFORE], movers[i, AFTER]
            _dark(segment, face, owner, pocket, n_walls, one, dark)
            _dark(segment, face, owner, pocket, n_walls, two, dark)
            for h in range(2 * first[path], 2 * first[path + 1]):
                starts[face[h]] = not dark[face[h]]
            _block(segment, same, owner, n_walls, one, two, blocked)
            view[:] = False
            _flood(face, same, blocked, starts, faces, view)
            throughout |= view
    old = np.empty(faces, dtype=np.int64)
    new = np.empty(faces, dtype=np.int64)
    unseen = np.empty(faces, dtype=np.int64)
    n_old = _number(
        first, face, same, segment, owner, n_walls, ~seen_old, closed_old, counts_old, old
    )
    n_new = _number(
        first, face, same, segment, owner, n_walls, ~seen_new, closed_new, counts_new, new
    )
    everybody = np.ones(n_positions, dtype=np.bool_)
    _number(first, face, same, segment, owner, n_walls, ~throughout, closed, everybody, unseen)
    links = np.zeros((n_old, n_new), dtype=np.bool_)
    if instant:
        for f in range(faces):
            if unseen[f] >= 0:
                links[old[f], new[f]] = True
    else:
        of_old = np.empty(n_old, dtype=np.int64)
        for f in range(faces):
            if old[f] >= 0:
                of_old[old[f]] = unseen[f]
        for f in range(faces):
            if new[f] >= 0:
                for i in range(n_old):
                    if of_old[i] == unseen[f]:
                        links[i, new[f]] = True
    return ~outside, old, new, unseen, n_old, n_new, links
