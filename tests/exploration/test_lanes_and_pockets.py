"""Whole runs of lanes and pockets: how long they take in the open, and that they end everywhere."""

import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.catalogue import make_strategy, settings_of
from conav.exploration.lanes_and_pockets import LanesAndPockets, LanesMemory
from conav.exploration.sweep_drive import Sweep
from conav.exploration.team_assignment import Order, Request
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.occupancy_grid import OccupancyGrid
from conav.messages.message import HEADER_BYTES, Message
from conav.runs.reader import read_run
from conav.simulation.engine import engine_for
from conav.simulation.explore import Exploration, exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world

NAME = "lanes-and-pockets"


def explored(folder: Path, map: Any, **options: Any) -> Exploration:
    """A run that saw everything and was accepted by the verifier."""
    path = folder / "run.mcap"
    done = conav.explore(map, **{"strategy": NAME, "out": path} | options)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(read_run(path))
    assert report.accepted, report.lines()
    return done


def empty_world(side_m: float, resolution: float = 0.5) -> OccupancyGrid:
    size = int(side_m / resolution)
    return OccupancyGrid(np.zeros((size, size), dtype=np.uint8), resolution)


# --- in the open ------------------------------------------------------------------------------


@pytest.mark.parametrize("robots", [1, 2, 4, 6])
def test_near_the_least_time_there_is_in_an_empty_world(robots: int) -> None:
    """Robots anywhere in 100 x 100 m: within 1.3 of what no team can beat, by three starts."""
    ratios: list[float] = []
    for seed in range(3):
        starts = np.random.default_rng(100 + seed).uniform(2, 98, (robots, 2))
        done = conav.explore(
            empty_world(100.0),
            strategy=NAME,
            robots=robots,
            range_m=4.0,
            cell_m=0.5,
            speed_mps=0.2,
            starts=[(float(x), float(y)) for x, y in starts],
            seed=seed,
        )
        assert done.status == "done"
        problem = done.problem
        seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
        least = lower_bounds(problem, seen, 1.0, witnesses=0).lower_s
        assert done.metrics.t100_s is not None
        ratios.append(done.metrics.t100_s / least)
    assert min(ratios) >= 1.0
    assert sum(ratios) / 3 <= 1.3


@pytest.mark.parametrize("robots", [1, 3])
def test_planning_cells_larger_than_map_cells(robots: int) -> None:
    """Three map cells a planning cell: no slivers are left between lanes."""
    done = conav.explore(
        empty_world(40.0, 0.25), strategy=NAME, robots=robots, range_m=4.0, cell_m=0.75, seed=1
    )
    problem = done.problem
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    least = lower_bounds(problem, seen, 1.0, witnesses=0).lower_s
    assert done.metrics.t100_s is not None
    assert done.metrics.t100_s <= 1.6 * least


def test_in_the_open_it_is_earlier_than_by_frontiers_and_pockets_alone() -> None:
    times = {
        name: sum(
            conav.explore(
                empty_world(30.0), strategy=name, robots=3, range_m=4.0, seed=seed
            ).metrics.time_s
            for seed in range(2)
        )
        for name in (NAME, "pocket-assignment")
    }
    assert times[NAME] < 0.9 * times["pocket-assignment"]


# --- everywhere -------------------------------------------------------------------------------


def small(name: str, seed: int) -> OccupancyGrid:
    sides = {} if name == "three-obstacles" else {"width_m": 12, "height_m": 9}
    return builtin_map(name, seed=seed, **sides)


@pytest.mark.parametrize("motion", ["8-connected", "4-connected", "forward-turn"])
@pytest.mark.parametrize("name", ["office", "cave", "maze", "field", "three-obstacles"])
def test_finishes_and_is_accepted(name: str, motion: str, tmp_path: Path) -> None:
    explored(tmp_path, small(name, 1), robots=3, range_m=3.0, motion=motion, seed=2)


ALWAYS = {"open_below": 1e9, "closed_above": 1e9}
OFTEN = {"open_below": 3.0, "closed_above": 3.0}


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("office", ALWAYS),
        ("office", OFTEN),
        ("cave", ALWAYS),
        ("cave", OFTEN),
        ("maze", ALWAYS),
        ("three-obstacles", ALWAYS),
    ],
)
def test_whenever_it_sweeps_lanes(name: str, values: dict[str, float], tmp_path: Path) -> None:
    """Among walls most sweeps are blocked."""
    explored(tmp_path, small(name, 3), robots=2, range_m=3.0, seed=1, settings=values)


@pytest.mark.parametrize(
    ("name", "radio"),
    [("office", 6.0), ("field", 5.0), ("field", "off"), ("cave", "path-loss")],
)
def test_with_a_limited_radio(name: str, radio: str | float, tmp_path: Path) -> None:
    explored(tmp_path, small(name, 1), robots=4, range_m=3.0, radio=radio, seed=2)


def test_when_messages_are_late_and_lost(tmp_path: Path) -> None:
    explored(tmp_path, empty_world(30.0), robots=4, range_m=4.0, loss=0.3, delay_s=5.0, seed=2)


@pytest.mark.parametrize("speed_mps", [0.5, 2.0])
def test_with_wide_robots_and_a_sensor_that_sees_through_walls(
    speed_mps: float, tmp_path: Path
) -> None:
    grid = builtin_map("field", width_m=30, height_m=30, seed=4)
    explored(
        tmp_path, grid, robots=3, range_m=5.0, radius_m=0.4, sensor="disc", speed_mps=speed_mps
    )


# Path under the data folder, the range [m], and whether the robot is to meet lanes there.
REAL = [
    ("maps/navigation2/depot.yaml", 3.5, True),
    ("maps/navigation2/tb3_sandbox.yaml", 2.0, False),
]


@pytest.mark.parametrize(("file", "range_m", "lanes"), REAL)
def test_real_maps(file: str, range_m: float, lanes: bool, tmp_path: Path) -> None:
    data = os.environ.get("CONAV_DATA")
    if not data or not (Path(data) / file).is_file():
        pytest.skip("needs the real maps of the folder CONAV_DATA names")
    sweeps = 0

    def note(state: WorldState) -> None:
        nonlocal sweeps
        sweeps += sum(memory.sweep is not None for memory in state.memories)

    values = {"open_below": 1.5, "closed_above": 2.5} if lanes else {}
    explored(
        tmp_path,
        Path(data) / file,
        robots=1,
        range_m=range_m,
        seed=1,
        settings=values,
        progress=note,
    )
    assert sweeps > 100 or not lanes


# --- indoors ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "radio"), [("office", "perfect"), ("field", "perfect"), ("cave", 4.0)]
)
def test_never_open_it_is_pocket_assignment(name: str, radio: str | float, tmp_path: Path) -> None:
    """Step for step: the same places, goals and messages."""
    grid = small(name, 2)
    runs = []
    for strategy, values in (
        (NAME, {"advantage": 0.7, "open_below": 0.0}),
        ("pocket-assignment", {"advantage": 0.7}),
    ):
        path = tmp_path / f"{strategy}.mcap"
        options: dict[str, Any] = {"robots": 3, "range_m": 3.0, "radio": radio, "seed": 5}
        conav.explore(grid, strategy=strategy, settings=values, out=path, **options)
        runs.append(read_run(path))
    one, two = runs
    assert len(one.steps) == len(two.steps) > 10
    for first, second in zip(one.steps, two.steps, strict=True):
        assert np.array_equal(first.cells, second.cells)
        assert np.array_equal(first.goals, second.goals)
        assert (first.messages, first.bytes) == (second.messages, second.bytes)


# --- settings, messages, determinism ----------------------------------------------------------


@pytest.mark.parametrize(
    "values",
    [
        {"advantage": "-1"},
        {"advantage": "inf"},
        {"open_below": "-0.1"},
        {"open_below": "1.6"},  # more than closed_above
        {"closed_above": "0.9"},  # less than open_below
        {"closed_above": "inf"},
        {"open_below": "nan"},
        {"closed_above": "nan"},
        {"open_below": "wide"},
    ],
)
def test_settings_that_mean_nothing_are_refused(values: dict[str, str]) -> None:
    with pytest.raises(InputError, match=r"lanes-and-pockets\.md"):
        make_strategy(NAME, values)


def test_settings() -> None:
    expected = {"advantage": 0.5, "open_below": 1.0, "closed_above": 1.5}
    assert settings_of(make_strategy(NAME)) == expected
    assert make_strategy(NAME, {"open_below": "0", "closed_above": "0"}) == LanesAndPockets(
        open_below=0.0, closed_above=0.0
    )


def test_sizes_of_messages() -> None:
    sweep = Sweep(0, 3, 2, 9, 1, 10)
    sizes = {
        Request(): 0,
        Request(sweep): 21,  # five coordinates and an axis
        sweep: 21,
        Order(5): 4,
        Order(5, 77): 8,
    }
    for body, size in sizes.items():
        assert body.size_bytes == size
        assert Message(0, 1, 0.0, body).size_bytes == HEADER_BYTES + size


def world(**options: Any) -> WorldState:
    problem, _ = exploration_problem(
        empty_world(25.0), **{"robots": 3, "range_m": 3.0, "seed": 3} | options
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, LanesAndPockets(), seen)


def went_on(state: WorldState, steps: int) -> list[list[Any]]:
    engine = engine_for(state)
    trace: list[list[Any]] = []
    for _ in range(steps):
        events = engine.sense_and_decide(state, [])
        trace.append([events.cells.tolist(), events.actions, events.said])
        engine.move(state, events.actions)
    return trace


def test_reports_and_orders_are_sent() -> None:
    said = [message.body for _, _, said in went_on(world(), 120) for message in said]
    assert any(isinstance(body, Sweep) for body in said)
    assert any(isinstance(body, Request) and body.report is not None for body in said)
    assert all(isinstance(body, (Sweep, Order, Request)) for body in said)


@pytest.mark.parametrize("radio", ["perfect", 8.0])
def test_a_world_pickled_in_the_middle_of_a_sweep_goes_on_the_same(radio: str | float) -> None:
    state = world(radio=radio)
    went_on(state, 40)
    memories = state.memories
    assert all(isinstance(memory, LanesMemory) for memory in memories)
    assert any(memory.sweep is not None and memory.sweep.sweeping for memory in memories)
    again = pickle.loads(pickle.dumps(state))
    assert went_on(again, 80) == went_on(state, 80)


def test_the_same_seed_gives_the_same_run() -> None:
    assert went_on(world(), 150) == went_on(world(), 150)


def test_a_robot_that_gives_a_sweep_up_is_not_finished() -> None:
    """It says nothing of the kind while anything is left: all who do end a run."""
    state = world(robots=2)
    engine = engine_for(state)
    for _ in range(400):
        events = engine.sense_and_decide(state, [])
        if state.covered[0] == state.n_observable:
            return
        assert not any(action.finished for action in events.actions)
        engine.move(state, events.actions)
    raise AssertionError("it has not finished")
