"""Whole runs: how they end, what they repeat, what their file says."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import conav
from conav.exploration.types import Action, TeamView
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import UNKNOWN, OccupancyGrid
from conav.messages.message import Message
from conav.simulation.run_exploration import STILL_STEPS
from conav.simulation.world_state import WorldState

ROOMS = parse_ascii("""
###########################
#..........#......#.......#
#..........#......#.......#
#..........#..............#
#.................#.......#
#..........#......#####.###
#..........#......#.......#
#####.######......#.......#
#.................#.......#
#..........#..............#
#..........#......#.......#
###########################
""")
TEAM: dict[str, Any] = {"robots": 3, "range_m": 3.0, "speed_mps": 1.0}


def accepted(path: Path) -> conav.Exploration | Any:
    run = conav.read_run(path)
    report = verify_exploration(run)
    assert report.accepted, "\n".join(report.lines())
    return run


def test_the_same_seed_gives_the_same_run(tmp_path: Path) -> None:
    one, other, third = (
        conav.explore(ROOMS, seed=seed, out=tmp_path / f"{number}.mcap", **TEAM)
        for number, seed in enumerate((4, 4, 5))
    )
    assert one.status == "done"
    assert one.result.covered == other.result.covered
    assert one.result.digest == other.result.digest
    assert one.metrics == other.metrics
    assert np.array_equal(one.result.team_map, other.result.team_map)
    assert one.result.digest != third.result.digest
    assert one.result.covered != third.result.covered
    runs = [accepted(tmp_path / f"{number}.mcap") for number in range(3)]
    assert [run.digest for run in runs] == [one.result.digest] * 2 + [third.result.digest]
    for step, same in zip(runs[0].steps, runs[1].steps, strict=True):
        assert np.array_equal(step.cells, same.cells)


def test_a_run_without_a_file_is_the_same(tmp_path: Path) -> None:
    with_file = conav.explore(ROOMS, seed=4, out=tmp_path / "run.mcap", **TEAM)
    without = conav.explore(ROOMS, seed=4, **TEAM)
    assert without.result.covered == with_file.result.covered
    assert without.metrics == with_file.metrics
    assert without.result.digest is None
    assert without.run is None


def test_coverage_never_falls_and_ends_at_all() -> None:
    done = conav.explore(ROOMS, seed=2, **TEAM)
    covered = done.result.covered
    assert list(covered) == sorted(covered)
    assert covered[-1] == done.result.observable
    assert done.metrics.coverage == 1.0
    seen = done.result.team_map != UNKNOWN
    assert np.array_equal(done.result.team_map[seen], ROOMS.cells[seen])


@pytest.mark.parametrize(
    "variant",
    [
        {},
        {"radio": 3.0, "robots": 6},
        {"motion": "4-connected"},
        {"motion": "forward-turn", "radio": 5.0},
        {"sensor": "disc"},
        {"robots": 1},
        {"cell_m": 2.0, "radius_m": 0.3},
        {"cell_m": 1.7, "radius_m": 0.4, "radio": 6.0},
        {"cell_m": 0.5, "radius_m": 0.1},
        {"cell_m": 0.5, "radius_m": 0.4},
        {"range_m": 1.0, "robots": 4},
    ],
)
def test_every_kind_of_run_is_accepted(variant: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(ROOMS, seed=3, out=path, max_time_s=400.0, **(TEAM | variant))
    accepted(path)
    assert done.metrics.coverage > 0.5


@pytest.mark.parametrize("seed", range(6))
def test_the_default_cell_on_a_fine_map_is_accepted(seed: int, tmp_path: Path) -> None:
    """Planning cells of 0.3 m on 0.05 m: discs that just fit between walls everywhere."""
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid((rng.random((60, 60)) < 0.04).astype(np.uint8), 0.05)
    path = tmp_path / "run.mcap"
    conav.explore(grid, robots=1, range_m=0.5, seed=seed, out=path)
    accepted(path)


def test_the_time_limit_ends_a_run(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(ROOMS, seed=4, max_time_s=7.0, out=path, **TEAM)
    assert done.status == "out_of_budget"
    assert done.metrics.steps == 7
    assert done.metrics.time_s == 7.0
    assert not done.result.interrupted
    run = accepted(path)
    assert run.result is not None
    assert run.result["status"] == "out_of_budget"
    whole = conav.explore(ROOMS, seed=4, **TEAM)
    assert whole.result.covered[:8] == done.result.covered


def test_no_time_at_all_is_one_look() -> None:
    done = conav.explore(ROOMS, seed=4, max_time_s=0.0, **TEAM)
    assert (done.status, done.metrics.steps, len(done.result.covered)) == ("out_of_budget", 0, 1)
    assert done.result.covered[0] > 0


def test_one_look_may_be_enough() -> None:
    room = parse_ascii("#####\n#...#\n#...#\n#####")
    done = conav.explore(room, robots=2, range_m=10.0, max_time_s=0.0)
    assert (done.status, done.metrics.steps, done.metrics.t100_s) == ("done", 0, 0.0)


@dataclass(frozen=True)
class Still:
    """Never moves; says it is finished or not."""

    finished: bool = True

    def start(self, view: TeamView, rng: np.random.Generator) -> int:
        return 0

    def step(
        self, memory: int, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[int, Action, Sequence[Message]]:
        return memory, Action(finished=self.finished), ()


def test_a_team_that_gives_up_is_stuck(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(ROOMS, strategy=Still(), seed=4, out=path, **TEAM)
    assert (done.status, done.metrics.steps) == ("stuck", 0)
    assert done.strategy == "Still"
    assert 0 < done.metrics.coverage < 1
    run = accepted(path)
    assert run.header["strategy"] == "Still"
    assert run.header["settings"] == {"finished": True}


def test_a_team_that_does_nothing_for_long_is_stuck() -> None:
    done = conav.explore(ROOMS, strategy=Still(finished=False), seed=4, **(TEAM | {"robots": 1}))
    assert (done.status, done.metrics.steps) == ("stuck", STILL_STEPS)


def test_places_nobody_can_reach_do_not_keep_a_team() -> None:
    closed = parse_ascii("#########\n#...#...#\n#...#...#\n#########")
    done = conav.explore(closed, robots=1, starts=[(1.5, 1.5)], range_m=2.0)
    assert (done.status, done.result.observable) == ("done", 6)


class Word(NamedTuple):
    """A body of ten bytes."""

    text: str

    @property
    def size_bytes(self) -> int:
        return 10


@dataclass(frozen=True)
class Talkative:
    """Drives at random and tells everybody about it."""

    talk: bool = True

    def start(self, view: TeamView, rng: np.random.Generator) -> int:
        return -1

    def step(
        self, memory: int, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[int, Action, Sequence[Message]]:
        moves = view.belief.moves.item(view.cell)
        possible = [k for k in range(8) if moves >> k & 1]
        action = Action(int(rng.choice(possible)) if possible else -1)
        if memory == view.step or not self.talk:
            return memory, action, ()
        others = [robot for robot in range(len(view.heard_cell)) if robot != view.robot]
        said = [Message(view.robot, other, view.time_s, Word("here")) for other in others]
        return view.step, action, said


@pytest.mark.parametrize("radio", ["perfect", 100.0])
def test_a_run_of_minds_that_talk_is_accepted(radio: str | float, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    silent = conav.explore(ROOMS, strategy=Still(), seed=4, radio=radio, max_time_s=0.0, **TEAM)
    done = conav.explore(
        ROOMS, strategy=Talkative(), seed=4, radio=radio, max_time_s=0.0, out=path, **TEAM
    )
    assert done.metrics.messages == silent.metrics.messages + 6
    assert done.metrics.bytes == silent.metrics.bytes + 6 * (24 + 10)
    accepted(path)


class Plain:
    """A strategy that is no dataclass."""

    def start(self, view: TeamView, rng: np.random.Generator) -> int:
        return 0

    def step(
        self, memory: int, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[int, Action, Sequence[Message]]:
        return memory, Action(finished=True), ()


def test_a_strategy_need_not_be_a_dataclass(tmp_path: Path) -> None:
    assert conav.explore(ROOMS, strategy=Plain(), seed=4, **TEAM).status == "stuck"
    path = tmp_path / "run.mcap"
    conav.explore(ROOMS, strategy=Plain(), seed=4, out=path, **TEAM)
    assert accepted(path).header["strategy"] == "Plain"


@pytest.mark.parametrize("at", [0, 9])
def test_an_interrupt_between_steps_leaves_a_readable_file(at: int, tmp_path: Path) -> None:
    def stop(state: WorldState) -> None:
        if state.step == at:
            raise KeyboardInterrupt

    path = tmp_path / "run.mcap"
    done = conav.explore(ROOMS, seed=4, out=path, progress=stop, **TEAM)
    assert (done.status, done.result.interrupted) == ("out_of_budget", True)
    assert done.metrics.steps == at
    assert done.summary()["interrupted"] is True
    run = accepted(path)
    assert run.intact
    assert len(run.steps) == at + 1
    assert run.result is not None
    assert (run.result["status"], run.result["interrupted"]) == ("out_of_budget", True)
    whole = conav.explore(ROOMS, seed=4, **TEAM)
    assert whole.result.covered[: at + 1] == done.result.covered


@dataclass(frozen=True)
class Interrupted(Talkative):
    """Ctrl-C while one of the robots is thinking, which is where a run spends its time."""

    at: int = 5
    robot: int = 1

    def step(self, memory: int, view: TeamView, *rest: Any) -> Any:
        if (view.step, view.robot) == (self.at, self.robot):
            raise KeyboardInterrupt
        return super().step(memory, view, *rest)


@pytest.mark.parametrize("radio", [100.0, "perfect"])
def test_an_interrupt_within_a_step_leaves_an_acceptable_file(
    radio: str | float, tmp_path: Path
) -> None:
    """The step under way is not in the file, so it is in no number of the result either."""
    path = tmp_path / "run.mcap"
    strategy = Interrupted(talk=False, at=5)
    done = conav.explore(ROOMS, strategy=strategy, seed=4, radio=radio, out=path, **TEAM)
    assert (done.status, done.result.interrupted) == ("out_of_budget", True)
    run = accepted(path)
    assert len(run.steps) == len(done.result.covered) == 5
    assert run.result is not None
    assert run.result["interrupted"] is True


def test_an_interrupt_within_the_first_step_leaves_a_readable_file(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    strategy = Interrupted(talk=False, at=0)
    done = conav.explore(ROOMS, strategy=strategy, seed=4, out=path, **TEAM)
    assert (done.status, done.result.interrupted) == ("out_of_budget", True)
    run = conav.read_run(path)
    assert run.intact
    assert run.steps == []


def test_progress_is_called_after_every_step() -> None:
    steps: list[int] = []
    done = conav.explore(ROOMS, seed=4, progress=lambda state: steps.append(state.step), **TEAM)
    assert steps == list(range(done.metrics.steps + 1))
