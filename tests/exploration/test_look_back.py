"""Views that are kept against views made anew, while a map gets known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.exploration.belief import BLOCK, new_scratch
from conav.exploration.look_back import Views
from conav.exploration.types import Action
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.maps.occupancy_grid import OccupancyGrid
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world


class Wander:
    """Goes anywhere it can, straight on most of the time."""

    def start(self, view, rng):
        return 0

    def step(self, memory, view, inbox, rng):
        ways = [k for k in range(8) if int(view.belief.moves.item(view.cell)) >> k & 1]
        if memory not in ways or rng.random() < 0.05:
            memory = ways[int(rng.integers(len(ways)))] if ways else 0
        return memory, Action(memory if ways else -1), ()


def world(seed: int, cell_m: float, range_m: float, sensor: str) -> WorldState:
    """Robots among walls and blocks, on a map of some blocks in which changes are counted."""
    rng = np.random.default_rng(seed)
    walls = np.zeros((2 * BLOCK + 11, 3 * BLOCK + 5), np.uint8)
    for _ in range(25):
        r, c = rng.integers(0, walls.shape)
        high, wide = (1, int(rng.integers(1, 40))) if rng.random() < 0.5 else rng.integers(1, 9, 2)
        walls[r : r + high, c : c + wide] = 1
    problem, _ = exploration_problem(
        OccupancyGrid(walls, 1.0),
        robots=2,
        range_m=range_m,
        cell_m=cell_m,
        radius_m=0.3,
        sensor=sensor,
        seed=seed,
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, Wander(), seen)


@pytest.mark.parametrize(
    ("cell_m", "range_m", "sensor"),
    [(1.0, 30.0, "range"), (3.0, 70.0, "range"), (0.5, 12.0, "range"), (2.0, 25.0, "disc")],
)
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_kept_is_what_a_look_finds(
    seed: int, cell_m: float, range_m: float, sensor: str
) -> None:
    state = world(seed, cell_m, range_m, sensor)
    engine = engine_for(state)
    for step in range(60):
        events = engine.sense_and_decide(state, [])
        if step % 5 == 0:
            view = engine._view(state, 0)
            kept, anew = Views(view), Views(view._replace(belief=view.belief.copy()))
            hidden = unknown_beside_frontier(view.belief)
            for cell in hidden[:: max(len(hidden) // 40, 1)].tolist():
                assert np.array_equal(kept.places(cell), anew.places(cell))
            kept.keep()
        engine.move(state, events.actions)


def test_only_what_may_have_changed_is_looked_at_again(monkeypatch: pytest.MonkeyPatch) -> None:
    state = world(7, 1.0, 12.0, "range")
    engine = engine_for(state)
    for _ in range(60):
        engine.move(state, engine.sense_and_decide(state, []).actions)
    engine.sense_and_decide(state, [])
    view = engine._view(state, 0)
    belief, plan = view.belief, state.problem.plan
    hidden = unknown_beside_frontier(belief).tolist()
    first = Views(view)
    found = {cell: first.places(cell) for cell in hidden}
    first.keep()
    looked: list[int] = []
    look_back = Views._look_back

    def watched(views: Views, cell: int):
        looked.append(cell)
        return look_back(views, cell)

    monkeypatch.setattr(Views, "_look_back", watched)
    for cell in hidden:
        Views(view).places(cell)
    assert not looked
    # Somebody looks from a place that some of them may see, and others lie far from.
    place = int(next(places for places in found.values() if len(places))[0])
    belief.hear(plan, place, np.empty(0, np.int32), new_scratch(plan))
    for cell in hidden:
        places = Views(view).places(cell)
        assert np.array_equal(places, found[cell][found[cell] != place])
    seeing = {cell for cell in hidden if place in found[cell]}
    assert seeing <= set(looked)
    assert len(looked) < len(hidden) / 2
