"""The verifier's own count of everything a run's result reports, and why it ended."""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.exploration import verify_geometry as geometry
from conav.exploration import verify_sight as sight
from conav.exploration.verify_faults import ABSENT, DEAD
from conav.exploration.verify_knowledge import Seen
from conav.exploration.verify_world import Check, World
from conav.runs.types import ExplorationRun

SHARES = (90, 95, 99, 100)  # [%]
STILL_STEPS = 4096  # steps without a move after which a run is stuck


def observable_cells(world: World) -> NDArray[np.uint8]:
    """1 for each free fine cell the team can observe, by its definition."""
    reached = geometry.reachable_cells(
        world.walls,
        world.rows,
        world.cols,
        world.ratio,
        float(world.radii[0]),
        world.diagonal[0],
        world.starts,
    )
    places = np.zeros(world.walls.shape, dtype=np.uint8)
    for cell in np.flatnonzero(reached):
        places[world.fine(int(cell))] = 1
    if world.occlusion[0]:
        owner = sight.nearest_places(world.walls, places)
        return sight.observable_from_nearest(world.walls, owner, float(world.squares[0]))
    return sight.within_range(world.walls, places, float(world.squares[0]))


def check_metrics(run: ExplorationRun, world: World, total: int, seen: Seen, check: Check) -> None:
    """Everything reported in the result, computed again from the events."""
    result = run.result
    if result is None:
        return
    expected = _metrics(run, world, total, seen)
    said = result.get("metrics")
    check.looked += len(expected) + 1
    if not isinstance(said, dict) or set(cast("dict[str, Any]", said)) != set(expected):
        check.fault("the result has not the measures a result has")
        return
    if not _close(result.get("observable"), total):
        check.fault(
            f"the result says {result.get('observable')} observable cells; there are {total}"
        )
    for key, value in expected.items():
        claim = cast("dict[str, Any]", said)[key]
        if not _close(claim, value):
            check.fault(f"the result says {key} {claim}; the events say {value}")


def check_ending(
    run: ExplorationRun,
    world: World,
    found: NDArray[np.uint8],
    total: int,
    seen: Seen,
    check: Check,
) -> None:
    """The run went on for as long as it had to, and its status says why it ended."""
    covered = seen.covered
    last = len(covered) - 1
    check.looked += 1
    if last > world.steps_allowed:
        check.fault(f"the run has {last} steps; its time limit allows {world.steps_allowed}")
    early = next((k for k, count in enumerate(covered[:-1]) if count >= total), None)
    if early is not None:
        check.fault(f"the run went on after all was seen in step {early}")
    if run.result is None:
        return
    said = run.result.get("status")
    interrupted = run.result.get("interrupted")
    if not isinstance(interrupted, bool):
        check.fault("the result does not say whether the run was interrupted")
    allowed = {
        _status(run, world, found, covered[-1] == total),
        *(("out_of_budget",) * bool(interrupted)),
    }
    if said not in allowed:
        check.fault(
            f"the result says {said} with {covered[-1]} of {total} cells seen in {last} steps; "
            f"it is {' or '.join(map(str, allowed))}"
        )


def _status(run: ExplorationRun, world: World, found: NDArray[np.uint8], everything: bool) -> str:
    """How a run that was not interrupted ends after these steps."""
    if everything:
        return "done"
    if _is_over(run, world, found[-1]) or _stands_still(run, world, found):
        return "stuck"
    return "out_of_budget" if len(run.steps) - 1 >= world.steps_allowed else "unfinished"


def _is_over(run: ExplorationRun, world: World, now: NDArray[np.uint8]) -> bool:
    """Whether those that live are done, and nobody is to come."""
    if (now == DEAD).all():
        return True
    step = run.steps[-1]
    last = len(run.steps) - 1 >= world.steps_allowed
    if world.delay and last and len(step.said):
        return False  # a message under way might have changed somebody's mind
    return bool((now != ABSENT).all()) and bool(step.finished[now != DEAD].all())


def _stands_still(run: ExplorationRun, world: World, found: NDArray[np.uint8]) -> bool:
    """Whether nobody has moved, or was to move again, for as long as a run waits."""
    if len(run.steps) <= STILL_STEPS:
        return False
    cells = run.steps[-1].cells
    if not all(np.array_equal(step.cells, cells) for step in run.steps[-1 - STILL_STEPS :]):
        return False
    begin = len(run.steps) - STILL_STEPS  # of the first of these steps without a move
    for fault in world.faults:
        when = fault.at if fault.kind == "joins" else fault.until
        if when is not None and begin < when and found[begin - 1, fault.robot] != DEAD:
            return False
    return True


def _metrics(run: ExplorationRun, world: World, total: int, seen: Seen) -> dict[str, Any]:
    covered = seen.covered
    last = len(covered) - 1
    final = covered[-1]
    lengths = _lengths(run, world)
    times = {
        f"t{share}_s": next(
            (k * world.step_s for k, count in enumerate(covered) if 100 * count >= share * total),
            None,
        )
        for share in SHARES
    }
    return {
        "steps": last,
        "time_s": last * world.step_s,
        "coverage": final / total if total else 1.0,
        **times,
        "path_m": lengths.tolist(),
        "overlap": int(seen.sensed.sum()) / final - 1.0 if final else 0.0,
        "balance": {"seen": _spread(seen.discovered), "path": _spread(lengths)},
        "messages": sum(int(step.messages) for step in run.steps),
        "bytes": sum(int(step.bytes) for step in run.steps),
    }


def _lengths(run: ExplorationRun, world: World) -> NDArray[np.float64]:
    """How far each robot drove, shape (n,) [m]."""
    places = np.stack([world.places(step.cells) for step in run.steps])
    moves = np.diff(places, axis=0).astype(float)
    return np.sqrt((moves**2).sum(axis=2)).sum(axis=0) * world.cell_m


def _spread(values: NDArray[Any]) -> float:
    total = float(values.sum())
    return float(np.std(values / total)) if total else 0.0


def _close(said: Any, value: Any) -> bool:
    """Whether a claim equals a value: same shape, same names, numbers but for rounding."""
    if isinstance(value, dict):
        parts = cast("dict[str, Any]", value)
        return (
            isinstance(said, dict)
            and set(cast("dict[str, Any]", said)) == set(parts)
            and all(_close(said[key], part) for key, part in parts.items())
        )
    if isinstance(value, list):
        items = cast("list[Any]", value)
        return (
            isinstance(said, list)
            and len(cast("list[Any]", said)) == len(items)
            and all(_close(a, b) for a, b in zip(cast("list[Any]", said), items, strict=True))
        )
    if value is None or said is None:
        return said is value
    if isinstance(said, bool) or not isinstance(said, int | float):
        return False
    if isinstance(value, int):
        return said == value
    return abs(float(said) - float(value)) <= 1e-9 * max(1.0, abs(float(value)))
