"""What each robot could gain alone on its final graph, found anew.

The graph is built from its vertices (`verify_graph`). The search goes backwards, from where a path
may end, over vertices and the states of the formula read backwards (`verify_backward`). All paths
of the graph that nobody is in the way of are covered by one pass in the order of falling times.
"""

from collections.abc import Sequence
from math import hypot, inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_backward import Table, backward_table
from conav.planning.verify_claims import costs_of
from conav.planning.verify_graph import (
    Edges,
    Rule,
    default_gamma,
    edges_of,
    label_at,
)
from conav.planning.verify_scene import LARGEST, TOLERANCE, Body, Check, Scene, Violation, is_number
from conav.planning.verify_task import Unreadable, names_in, read_formula
from conav.planning.verify_traffic import CLEAR, PERHAPS, crowd_around, way_of_edges, way_of_rests
from conav.runs.types import PlanRun

_SOLVERS = ("inash", "inash-restarts", "social-optimum")
_MARGIN = 1e-9  # [m] of clearance within which rounding may decide

Costs = tuple[float, ...]


def check_equilibrium(run: PlanRun, scene: Scene, check: Check) -> None:
    """Nobody can gain more alone on its graph than `epsilon` says, and its path is on its graph."""
    claimed = (run.result or {}).get("epsilon")
    if claimed is None:
        return
    if not isinstance(claimed, list) or len(claimed) != len(scene.bodies):
        check.fault(Violation("there is no epsilon for every robot"))
        return
    if run.header.get("solver") not in _SOLVERS or not run.graphs:
        check.skip("epsilon, without graphs of a solver whose rule is known")
        return
    for number, body in enumerate(scene.bodies):
        if body.motion != "single-integrator":
            check.skip(f"epsilon of robots with the motion {body.motion}")
            continue
        vertices = run.graphs.get(number)
        if (
            vertices is None
            or vertices.shape[1:] != (3,)
            or not (np.abs(vertices) <= LARGEST).all()
        ):
            check.fault(Violation("has no graph", (body.name,)))
            continue
        check.looked += 1
        said = claimed[number]
        if not is_number(said):
            check.fault(Violation(f"epsilon is said to be {said!r}", (body.name,)))
            continue
        try:
            problem = _robot(run, scene, number, body, vertices, float(said), check)
        except (KeyError, TypeError, ValueError) as error:
            problem = f"has settings or a task that cannot be used ({error})"
        if problem:
            check.fault(Violation(problem, (body.name,)))


def _robot(
    run: PlanRun,
    scene: Scene,
    number: int,
    body: Body,
    vertices: NDArray[np.float64],
    said: float,
    check: Check,
) -> str:
    """What is wrong with a robot's epsilon or graph, "" for nothing."""
    x, y, t = vertices[0].tolist()
    if hypot(x - body.start[0], y - body.start[1]) > TOLERANCE or t != 0.0:
        return "has a graph that does not begin at its start"
    track = scene.tracks[number]
    if track is not None:
        problem = _off_graph(track, vertices)
        if problem:
            return problem
    rule = rule_of(run, scene, body)
    try:
        formula = read_formula(body.task)
    except Unreadable:
        return ""  # told by another check
    names = sorted(names_in(formula), key=lambda name: (body.areas[name].disc is None, name))
    discs, rings, sides = region_arrays([body.areas[name] for name in names])
    shapes = shapes_around(scene, body)
    edges = edges_of(vertices, rule, body.speed, shapes, discs, rings, sides)
    lonely = np.setdiff1d(np.arange(1, len(vertices)), edges.heads)
    if len(lonely):
        vx, vy, vt = vertices[lonely[0]].tolist()
        return f"vertex {lonely[0]} at ({vx:.6g}, {vy:.6g}) and {vt:.6g} s has no edge to it"
    present = (inf,) * len(scene.costs) if track is None else tuple(costs_of(track, scene.costs))
    labels = np.array(
        [label_at(vx, vy, discs, rings, sides) for vx, vy in vertices[:, :2].tolist()],
        dtype=np.int64,
    )
    masks = sorted({*labels.tolist(), *edges.labels.tolist()})
    table = backward_table(formula, names, masks)
    sure, at_most = _gains(scene, number, body, vertices, edges, labels, table, present)
    if sure == inf:
        return "has no path, and there is one on its graph"
    if sure > said + TOLERANCE:
        return f"could gain {sure:.9g} alone, and epsilon is {said:.9g}"
    if at_most < said - TOLERANCE:
        return f"could gain no more than {at_most:.9g} alone, and epsilon is {said:.9g}"
    if at_most > said + TOLERANCE:
        check.notes.append(f"{body.name} might gain {at_most:.3g} if rounding had it otherwise")
    return ""


def _off_graph(track: NDArray[np.float64], vertices: NDArray[np.float64]) -> str:
    """What is wrong where a trajectory leaves its graph."""
    corners = [(float(piece[2]), float(piece[3]), float(piece[0])) for piece in track]
    last = track[-1]
    duration = float(last[1] - last[0])
    corners.append(
        (float(last[2] + duration * last[4]), float(last[3] + duration * last[5]), float(last[1]))
    )
    for x, y, t in corners:
        off = np.abs(vertices - [x, y, t]).max(axis=1)
        if off.min() > TOLERANCE:
            return f"is at ({x:.6g}, {y:.6g}) at {t:.6g} s, which is no vertex of its graph"
    return ""


def rule_of(run: PlanRun, scene: Scene, body: Body) -> Rule:
    """The rule of edges that a run's settings give a robot. Raises `KeyError` without settings."""
    settings: dict[str, Any] = run.header["settings"]
    gamma = settings["gamma_m"]
    if gamma is None:
        gamma = default_gamma(scene.area_m2, body.speed, scene.horizon)
    root = {"d": 3, "d+1": 4}[settings["exponent"]]
    forward = {"forward": True, "paper": False}[settings["mode"]]
    return Rule(float(settings["eta_m"]), float(gamma), root, forward)


def shapes_around(scene: Scene, body: Body) -> NDArray[np.float64]:
    """What a robot's centre stays away from, (n, 5): segments and how far."""
    walls = np.column_stack([scene.walls, np.full(len(scene.walls), body.radius)])
    at, reach = scene.discs[:, :2], scene.discs[:, 2] + body.radius
    return np.vstack([walls, np.column_stack([at, at, reach])])


def region_arrays(
    areas: Sequence[Any],
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Regions as arrays; those with a disc come first."""
    discs = np.array([area.disc for area in areas if area.disc is not None], dtype=np.float64)
    corners = [area.corners for area in areas if area.corners is not None]
    ends = np.cumsum([0, *map(len, corners)])
    rings = np.column_stack([ends[:-1], ends[1:]]).astype(np.int64)
    sides = [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in corners]
    return discs.reshape(-1, 3), rings, np.concatenate([np.empty((0, 4)), *sides])


def _gains(
    scene: Scene,
    number: int,
    body: Body,
    vertices: NDArray[np.float64],
    edges: Edges,
    labels: NDArray[np.int64],
    table: Table,
    present: Costs,
) -> tuple[float, float]:
    """The most a path on the graph gains in one component without losing in another.

    First without, then with all that rounding could decide. Infinite where the robot has no path
    and there is one; 0 where nothing can be gained.
    """
    crowd = crowd_around(scene, number)
    lengths = np.hypot(*(vertices[edges.heads, :2] - vertices[edges.tails, :2]).T)
    times = vertices[:, 2]
    parts = {
        "length": lengths,
        "duration": times[edges.heads] - times[edges.tails],
    }
    costs = np.column_stack([parts[name] for name in scene.costs])
    so_far = {
        "length": np.hypot(*(vertices[:, :2] - vertices[0, :2]).T),
        "duration": times,
    }
    least = np.column_stack([so_far[name] for name in scene.costs])
    useful = np.flatnonzero(
        (least[edges.tails] + costs <= np.array(present) + TOLERANCE).all(axis=1)
    )
    ways = way_of_edges(vertices, edges.tails[useful], edges.heads[useful], crowd, _MARGIN)
    rests = np.full(len(vertices), CLEAR, np.int8)
    if body.stays:
        rests = way_of_rests(vertices, scene.horizon, crowd, _MARGIN)
    column = {mask: i for i, mask in enumerate(table.masks)}
    letters = np.array([column[mask] for mask in labels.tolist()], dtype=np.int64)
    words = np.array([column[mask] for mask in edges.labels.tolist()], dtype=np.int64)

    def gain(used: NDArray[np.int64], can_end: NDArray[np.bool_]) -> float:
        if len(scene.costs) == 1:
            best = _least_to_end(
                letters, can_end, used, edges.tails, edges.heads, edges.first, words,
                costs[:, 0], table.ends, table.before, table.good,
            )  # fmt: skip
            found = [(best,)] if best < inf else []
        else:
            found = _pareto_to_end(letters, can_end, used, edges, words, costs, table, present)
        gains = [
            max(a - b for a, b in zip(present, one, strict=True))
            for one in found
            if all(b <= a + 1e-9 for a, b in zip(present, one, strict=True))
        ]
        return max([0.0, *gains])

    sure = useful[(ways == CLEAR) & edges.sure[useful]]
    return gain(sure, rests == CLEAR), gain(useful[ways >= PERHAPS], rests >= PERHAPS)


@kernel
def _least_to_end(
    letters: NDArray[np.int64],
    can_end: NDArray[np.bool_],
    used: NDArray[np.int64],
    tails: NDArray[np.int64],
    heads: NDArray[np.int64],
    first: NDArray[np.int64],
    words: NDArray[np.int64],
    costs: NDArray[np.float64],
    ends: NDArray[np.int64],
    before: NDArray[np.int64],
    good: NDArray[np.bool_],
) -> float:
    """The least cost of a path from vertex 0 whose word satisfies the formula."""
    best = np.full((len(letters), len(good)), np.inf)
    for vertex in range(len(letters)):
        if can_end[vertex]:
            best[vertex, ends[letters[vertex]]] = 0.0
    changed = True
    while changed:  # once, and once more to see that it was enough
        changed = False
        for edge in used:
            tail = tails[edge]
            head = heads[edge]
            for state in range(len(good)):
                cost = best[head, state] + costs[edge]
                if cost == np.inf:
                    continue
                now = state
                if first[edge + 1] > first[edge]:
                    for k in range(first[edge + 1] - 2, first[edge] - 1, -1):
                        now = before[now, words[k]]
                    now = before[now, letters[tail]]
                if cost < best[tail, now]:
                    best[tail, now] = cost
                    changed = True
    least = np.inf
    for state in range(len(good)):
        if good[state]:
            least = min(least, best[0, state])
    return least


def _pareto_to_end(
    letters: NDArray[np.int64],
    can_end: NDArray[np.bool_],
    used: NDArray[np.int64],
    edges: Edges,
    words: NDArray[np.int64],
    costs: NDArray[np.float64],
    table: Table,
    present: Costs,
) -> list[Costs]:
    """The cost vectors of paths from vertex 0 none of which is at least as good as another."""
    zero = (0.0,) * len(present)
    best: list[dict[int, list[Costs]]] = [
        {int(table.ends[letters[vertex]]): [zero]} if can_end[vertex] else {}
        for vertex in range(len(letters))
    ]
    for edge in used.tolist():  # falling times of tails: what comes after a tail is known
        tail, head = int(edges.tails[edge]), int(edges.heads[edge])
        more = tuple(costs[edge].tolist())
        for state, vectors in best[head].items():
            now = state
            if edges.first[edge + 1] > edges.first[edge]:
                for k in range(int(edges.first[edge + 1]) - 2, int(edges.first[edge]) - 1, -1):
                    now = int(table.before[now, words[k]])
                now = int(table.before[now, letters[tail]])
            kept = best[tail].setdefault(now, [])
            for vector in vectors:
                new = tuple(a + b for a, b in zip(vector, more, strict=True))
                if any(a > b + 1e-9 for a, b in zip(new, present, strict=True)):
                    continue
                if any(all(a <= b for a, b in zip(old, new, strict=True)) for old in kept):
                    continue
                kept[:] = [old for old in kept if any(a < b for a, b in zip(old, new, strict=True))]
                kept.append(new)
    return [vector for state, found in best[0].items() if table.good[state] for vector in found]
