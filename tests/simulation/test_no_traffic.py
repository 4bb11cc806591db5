"""Without a traffic rule robots pass through each other; everything else holds. And radios off."""

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.cli import run as command
from conav.errors import InputError
from conav.exploration.types import Action, ExplorationProblem, TeamView
from conav.exploration.verify import verify_exploration
from conav.geometry.directions import DCOL, DROW, SQRT2, STAY
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.messages.message import Message
from conav.robots.motion import MOTIONS
from conav.robots.radio import Radio, radio
from conav.runs.types import ExplorationRun
from conav.simulation.explore import exploration_problem
from conav.simulation.no_traffic import pass_through
from conav.simulation.observable import observable_cells
from conav.simulation.radio_network import links
from conav.simulation.traffic import MOVED, TURNED
from conav.simulation.world_state import new_world

E, N, W, S = range(4)


@dataclass(frozen=True)
class Plans:
    """Every robot plays its own list of directions, then stays."""

    lists: tuple[tuple[int, ...], ...] = ()

    def start(self, view: TeamView, rng: np.random.Generator) -> None:
        return None

    def step(
        self, memory: None, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[None, Action, Sequence[Message]]:
        mine = self.lists[view.robot]
        done = view.step >= len(mine)
        return None, Action(STAY if done else mine[view.step], finished=done), ()


def played(
    path: Path, picture: str, starts: list[tuple[float, float]], plans: Sequence[str], **more: Any
) -> ExplorationRun:
    """The run of robots that drive as letters say; `.` is to stay. They see one cell around."""
    lists = tuple(tuple("ENWS.".index(k) if k != "." else STAY for k in plan) for plan in plans)
    problem = {"range_m": 1.5, "cell_m": 1.0, "speed_mps": 1.0, "motion": "4-connected"} | more
    conav.explore(
        parse_ascii(picture),
        strategy=Plans(lists),
        robots=len(starts),
        starts=starts,
        out=path,
        **({"traffic": "none"} | problem),
    )
    return conav.read_run(path)


def places(run: ExplorationRun) -> list[list[int]]:
    return [step.cells.tolist() for step in run.steps]


def broken(run: ExplorationRun) -> tuple[str, ...]:
    return verify_exploration(run).broken()


def as_if(run: ExplorationRun, **header: Any) -> ExplorationRun:
    return replace(run, header={**copy.deepcopy(run.header), **header})


CORRIDOR = "." * 12


# --- meeting ------------------------------------------------------------------------------------


def test_robots_swap_and_share_cells(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    run = played(out, CORRIDOR, [(2.5, 0.5), (3.5, 0.5), (4.5, 0.5)], ["EEE", "WEE", "..."])
    assert places(run) == [[2, 3, 4], [3, 2, 4], [4, 3, 4], [5, 4, 4]]
    assert run.header["traffic"] == "none"
    assert broken(run) == ()
    # The same run under the rule that keeps robots apart is full of collisions, and of no others.
    assert broken(as_if(run, traffic="pibt")) == ("collisions",)


@pytest.mark.parametrize(
    ("plans", "faulty"),
    [
        (["E.", "W."], True),  # they swap
        (["E.", ".."], True),  # one drives into the other
        (["W.", "E."], False),  # they part
        (["EE", "EE"], False),  # one behind the other
    ],
)
def test_what_counts_as_a_collision_under_the_rule(
    plans: list[str], faulty: bool, tmp_path: Path
) -> None:
    run = played(tmp_path / "run.mcap", CORRIDOR, [(4.5, 0.5), (5.5, 0.5)], plans)
    assert broken(run) == ()
    assert broken(as_if(run, traffic="pibt")) == (("collisions",) if faulty else ())


def test_crossing_diagonally() -> None:
    grid = "\n".join(["....."] * 4)
    problem, _ = exploration_problem(
        parse_ascii(grid), robots=2, starts=[(1.5, 1.5), (2.5, 1.5)], cell_m=1.0, traffic="none"
    )
    cells = np.array(problem.starts, np.int32)
    drive(problem, cells, [4, 5], 2)  # a diagonal takes two steps from a standstill
    assert cells.tolist() == [2 * 5 + 2, 2 * 5 + 1]


def drive(problem: ExplorationProblem, cells: np.ndarray, wish: list[int], count: int) -> None:
    """All robots have the same wish for that many steps, at full speed."""
    n = len(cells)
    plan = problem.plan
    arrays = (np.zeros(n, np.int8), np.zeros(n, np.uint8), np.ones(n), np.zeros(n), np.zeros(n))
    for _ in range(count):
        ways = plan.moves.reshape(-1)[cells]
        pass_through(
            cells,
            np.array(wish, np.int8),
            ways,
            plan.lattice.cols,
            *arrays,
            np.zeros(n, np.uint8),
        )


def test_starts_may_coincide(tmp_path: Path) -> None:
    starts = [(4.5, 0.5)] * 3
    run = played(tmp_path / "run.mcap", CORRIDOR, starts, ["E", "W", "."])
    assert places(run) == [[4, 4, 4], [5, 3, 4]]
    assert broken(run) == ()
    with pytest.raises(InputError, match="too near another robot"):
        played(tmp_path / "run.mcap", CORRIDOR, starts, ["E", "W", "."], traffic="pibt")


def test_unknown_rules_are_refused(tmp_path: Path) -> None:
    run = played(tmp_path / "run.mcap", CORRIDOR, [(4.5, 0.5)], ["E"])
    for traffic in ("polite", "", None, 0, ["none"]):
        with pytest.raises(InputError, match="has a header that cannot be used"):
            verify_exploration(as_if(run, traffic=traffic))
    header = {key: value for key, value in run.header.items() if key != "traffic"}
    with pytest.raises(InputError, match="has a header that cannot be used"):
        verify_exploration(replace(run, header=header))
    with pytest.raises(InputError, match="use one of: pibt, none"):
        conav.explore("maze", traffic="polite")
    problem, _ = exploration_problem(parse_ascii(CORRIDOR), robots=1, cell_m=1.0)
    with pytest.raises(ValueError, match="none of pibt, none"):
        replace(problem, traffic="polite")


# --- what still holds ---------------------------------------------------------------------------


def test_walls_still_hold(tmp_path: Path) -> None:
    run = played(tmp_path / "run.mcap", "#####\n#.#.#\n#####", [(1.5, 1.5)] * 2, ["EE", "NN"])
    assert places(run) == [[6, 6]]  # all it can see it sees at once
    run = played(tmp_path / "run.mcap", "........#", [(5.5, 0.5)] * 2, ["EEEE", "WWWW"])
    assert [cells[0] for cells in places(run)] == [5, 6, 7, 7, 7]
    assert [cells[1] for cells in places(run)] == [5, 4, 3, 2, 1]
    assert broken(run) == ()


def test_driving_through_a_wall_is_found(tmp_path: Path) -> None:
    run = played(tmp_path / "run.mcap", "....#....", [(2.5, 0.5)] * 2, ["E...", "WW.."])
    for cell in (4, 5, 8):
        step = run.steps[1]
        cells = step.cells.copy()
        cells[0] = cell
        assert "walls" in broken(replace(run, steps=[run.steps[0], step._replace(cells=cells)]))


def test_a_turn_still_costs_a_step(tmp_path: Path) -> None:
    grid = "\n".join(["....."] * 5)
    starts = [(2.5, 2.5)] * 4
    plans = ["ENN", "NWW", "WSS", "SEE"]
    run = played(tmp_path / "run.mcap", grid, starts, plans, motion="forward-turn", range_m=1.0)
    assert broken(run) == ()
    before = run.steps[0].headings.tolist()
    wishes = [[E, N, N], [N, W, W], [W, S, S], [S, E, E]]
    expected = []
    for heading, mine in zip(before, wishes, strict=True):
        row = col = 2
        for k in mine:
            if heading == k:
                row, col = row + DROW[k], col + DCOL[k]
            heading = k
        expected.append(row * 5 + col)
    assert run.steps[3].cells.tolist() == expected


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(MOTIONS)))
def test_every_robot_moves_as_if_it_were_alone(seed: int, motion: str) -> None:
    """Against a plain model of one robot: moves that exist, turns, travel earned step by step."""
    rng = np.random.default_rng(seed)
    model = MOTIONS[motion]
    walls = (rng.random((6, 7)) < 0.2).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(walls, 1.0), cell_m=1.0, diagonal=model.diagonal)
    free = np.flatnonzero(plan.standable)
    n = int(rng.integers(1, 6))
    cells = rng.choice(free, n).astype(np.int32)
    heading = rng.integers(0, 4, n).astype(np.int8)
    rate = rng.choice([1.0, 0.5, 0.3], n)
    credit, travelled = np.zeros(n), np.zeros(n)
    outcome = np.zeros(n, np.uint8)
    turning = np.full(n, model.turn_costs_step, np.uint8)
    alone = [(int(c), int(h), 0.0, 0.0) for c, h in zip(cells, heading, strict=True)]
    wish = rng.integers(-1, 8, n)
    for _ in range(25):
        wish = np.where(rng.random(n) < 0.6, wish, rng.integers(-1, 8, n))
        ways = plan.moves.reshape(-1)[cells]
        before = cells.copy(), heading.copy()
        moved = pass_through(
            cells, wish.astype(np.int8), ways, 7, heading, turning, rate, credit, travelled, outcome
        )
        assert moved == (cells != before[0]).sum()
        assert np.array_equal(outcome == MOVED, cells != before[0])
        if model.turn_costs_step:
            turned = (heading != before[1]) & (cells == before[0])
            assert np.array_equal(outcome == TURNED, turned)
        for i in range(n):
            alone[i] = one_step(alone[i], int(wish[i]), int(ways[i]), float(rate[i]), model)
            cell, face, _, length = alone[i]
            assert (cells[i], heading[i]) == (cell, face)
            assert abs(travelled[i] - length) < 1e-9


def one_step(
    robot: tuple[int, int, float, float], wish: int, ways: int, rate: float, model: Any
) -> tuple[int, int, float, float]:
    """Cell, heading, travel earned and travelled after a step of a single robot."""
    cell, face, credit, length = robot
    credit += rate
    k = wish if wish >= 0 and ways >> wish & 1 else STAY
    price = SQRT2 if k >= 4 else 1.0
    if k < 0:
        return cell, face, min(credit, 1.0 - rate), length
    if model.turn_costs_step and face != k:
        return cell, k, 0.0, length
    if credit < price - 1e-9:
        return cell, face, credit, length
    face = k if k < 4 else face
    return cell + DROW[k] * 7 + DCOL[k], face, max(credit - price, 0.0), length + price


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    motion=st.sampled_from(list(MOTIONS)),
    sensor=st.sampled_from(["range", "disc"]),
    radio=st.sampled_from(["perfect", "off", 1.5]),
    strategy=st.sampled_from(["nearest", "potential", "potential-improved", "uncoordinated"]),
    cell_m=st.sampled_from([0.2, 0.3, 0.37]),
)
def test_whatever_the_simulator_does_is_accepted(
    seed: int, strategy: str, tmp_path_factory: pytest.TempPathFactory, **problem: Any
) -> None:
    rng = np.random.default_rng(seed)
    cells = (rng.random((14, 14)) < 0.1).astype(np.uint8)
    cells[:4, :4] = 0
    path = tmp_path_factory.mktemp("any") / "run.mcap"
    starts = [(0.15, 0.15), (0.15, 0.15), (0.5, 0.5)]
    try:
        conav.explore(
            OccupancyGrid(cells, 0.2),
            strategy=strategy,
            starts=starts,
            range_m=0.9,
            radius_m=0.05,
            traffic="none",
            max_time_s=40.0,
            seed=seed,
            out=path,
            **problem,
        )
    except InputError:
        return  # no such start on this map
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


# --- radios off -----------------------------------------------------------------------------------


def test_off_is_a_radio_of_no_range() -> None:
    assert radio("off") == radio("limited", 0) == Radio("off", 0.0)
    with pytest.raises(ValueError, match="no radio"):
        radio("limited")


@pytest.mark.parametrize("given", ["off", 0, 0.0, "0"])
def test_nobody_is_heard_even_in_the_same_cell(given: Any, tmp_path: Path) -> None:
    starts = [(4.5, 0.5)] * 3
    run = played(tmp_path / "run.mcap", CORRIDOR, starts, ["EEE", "EWE", "..E"], radio=given)
    radio = run.header["robots"][0]["radio"]
    assert (radio["name"], radio["range_m"]) == ("off", 0.0)
    assert all(step.messages == step.bytes == 0 for step in run.steps)
    assert all(len(step.told) == 0 for step in run.steps)
    # Each scan holds all that is new to the robot itself, also what the others saw before.
    assert [len(run.steps[0].scan(robot)[0]) for robot in range(3)] == [3, 3, 3]
    assert broken(run) == ()


def test_links_with_radios_off() -> None:
    for reach, heard in (("off", False), (0.4, True), ("perfect", True)):
        problem, _ = exploration_problem(
            parse_ascii(CORRIDOR),
            robots=2,
            starts=[(4.5, 0.5)] * 2,
            cell_m=1.0,
            radio=reach,
            traffic="none",
        )
        seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
        state = new_world(problem, Plans(((), ())), seen)
        assert links(state).tolist() == [[False, heard], [heard, False]]


def test_a_link_takes_both_ends() -> None:
    problem, _ = exploration_problem(
        parse_ascii(CORRIDOR), robots=2, starts=[(4.5, 0.5)] * 2, cell_m=1.0, traffic="none"
    )
    silent = replace(problem.robots[0], radio=radio("off"))
    problem = replace(problem, robots=(silent, problem.robots[1]))
    seen = observable_cells(problem.plan, problem.starts, silent.sensor)
    assert not links(new_world(problem, Plans(((), ())), seen)).any()


def test_the_verifier_knows_radios_that_are_off(tmp_path: Path) -> None:
    starts = [(4.5, 0.5)] * 2
    plans = ["EE", "WW"]
    heard = played(tmp_path / "heard.mcap", CORRIDOR, starts, plans, radio=0.5)
    silent = played(tmp_path / "silent.mcap", CORRIDOR, starts, plans, radio="off")
    assert broken(heard) == broken(silent) == ()
    assert any(len(step.told) for step in heard.steps)
    for run, reach in ((heard, 0.0), (silent, 0.5), (silent, 1e-9), (silent, None)):
        robots = copy.deepcopy(run.header["robots"])
        for robot in robots:
            robot["radio"]["range_m"] = reach
        assert {"messages"} <= set(broken(as_if(run, robots=robots)))
    # One report smuggled into the silent run.
    rows = np.array([0, 1, 1, 1], np.uint32)
    told = [silent.steps[0]._replace(told=rows), *silent.steps[1:]]
    assert "radio" in broken(replace(silent, steps=told))


# --- from the command line ------------------------------------------------------------------

QUICK = ("explore", "maze", "--robots", "2", "--seed", "3", "--max-time", "20", "--quiet")


def test_the_options_reach_the_run(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    options = ("--traffic", "none", "--radio", "off", "--starts", "0.7,0.7 0.7,0.7")
    assert command([*QUICK, *options, "--out", str(out)]) == 1  # time is up
    run = conav.read_run(out)
    assert run.header["traffic"] == "none"
    assert run.header["robots"][1]["radio"]["name"] == "off"
    assert run.steps[0].cells[0] == run.steps[0].cells[1]
    assert command(["verify", str(out)]) == 0
    assert command([*QUICK, "--out", str(out)]) == 1
    plain = conav.read_run(out)
    assert plain.header["traffic"] == "pibt"
    assert plain.header["robots"][0]["radio"]["name"] == "perfect"
    assert command([*QUICK, "--strategy", "uncoordinated-alone", "--out", str(out)]) == 1
    assert conav.read_run(out).header["robots"][0]["radio"]["name"] == "off"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--traffic", "polite"), "pibt, none"),
        (("--traffic", "None"), "pibt, none"),
        (("--traffic", ""), "pibt, none"),
        (("--radio", "of"), "off"),
        (("--radio", "-1"), "0 to 1e+06"),
        (("--radio", "nan"), "0 to 1e+06"),
        (("--strategy", "uncoordinated-alone", "--radio", "perfect"), "made for radio off"),
        (("--strategy", "uncoordinated-alone", "--radio", "3"), "made for radio off"),
        (("--strategy", "potential", "--set", "epsilon=2"), "docs/strategies/potential.md"),
        (("--strategy", "potential", "--set", "epsilon=a"), "docs/strategies/potential.md"),
    ],
)
def test_bad_values_give_one_line(
    options: tuple[str, ...], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command([*QUICK, *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err
    assert err.count("\n") == 1
