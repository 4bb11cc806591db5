"""The two-stage strategy: what the paper says of it, on small worlds by hand, and end to end."""

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.rectangle_drive import half_footprint, lanes
from conav.exploration.section_auction import Announce, Award, Bid
from conav.exploration.section_board import Status
from conav.exploration.two_stage import TwoStage
from conav.exploration.two_stage_flow import FLOW, Phase, flow_table
from conav.exploration.two_stage_turn import TwoStageMemory
from conav.exploration.two_stage_vote import Vote
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.messages.message import Message
from conav.simulation.engine import StepEvents, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world
from conav.testing import check_strategy

PAGE = Path(__file__).parents[2] / "docs/strategies/two-stage.md"
PAPER = {"range_m": 4.0, "speed_mps": 0.2, "motion": "4-connected"}


def empty(side: int = 200) -> OccupancyGrid:
    """An empty square of cells of 0.5 m inside a wall of one cell."""
    cells = np.ones((side, side), dtype=np.uint8)
    cells[1:-1, 1:-1] = 0
    return OccupancyGrid(cells, 0.5, name="empty")


def world(
    strategy: TwoStage, starts: list[tuple[int, int]], side: int = 200, **more: Any
) -> WorldState:
    """A state with robots in these (row, col) of the empty world."""
    problem, _ = exploration_problem(
        empty(side),
        robots=len(starts),
        starts=[((col + 0.5) * 0.5, (row + 0.5) * 0.5) for row, col in starts],
        **PAPER | more,
    )
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, strategy, observable)


def play(state: WorldState, steps: int = 10**6) -> Iterator[StepEvents]:
    """The events of each step until everything is seen; the state is that before the moves."""
    engine = engine_for(state)
    for _ in range(steps):
        events = engine.sense_and_decide(state, [])
        yield events
        if state.covered[0] == state.n_observable:
            return
        engine.move(state, events.actions)


def mind(state: WorldState, robot: int = 0) -> TwoStageMemory:
    return state.memories[robot]


# --- stage 1 --------------------------------------------------------------------------------------


def test_alone_it_closes_a_rectangle_from_border_to_border() -> None:
    """Up is nearest, right next: up, right by a footprint, all the way down, back, and up."""
    state = world(TwoStage(), [(120, 150)])
    corners: list[tuple[int, int]] = []
    before = -1
    for events in play(state):
        if mind(state).phase is not Phase.FIRST:
            break
        direction = events.actions[0].direction
        if direction != before:
            corners.append(divmod(int(events.cells[0]), 200))
            before = direction
    # Nearest border at the start: right. So lanes are horizontal.
    assert corners == [(120, 150), (120, 198), (137, 198), (137, 1), (120, 1)]
    row, col = divmod(int(events.cells[0]), 200)
    # It stops when the last eight cells show nothing but known ones.
    assert row == 120
    assert 120 <= col <= 150
    assert mind(state).board is not None
    assert mind(state).board.unscanned(0, 199) == [(0, 111), (146, 199)]


def test_always_closing_it_comes_back_to_where_it_began() -> None:
    state = world(TwoStage(closing="always"), [(120, 150)])
    events = next(events for events in play(state) if mind(state).phase is not Phase.FIRST)
    assert divmod(int(events.cells[0]), 200) == (120, 150)


@pytest.mark.parametrize(
    ("sense", "expected"), [("minimise", [3, 1]), ("maximise", [1, 3]), ("simple", None)]
)
def test_directions_follow_entropy(sense: str, expected: list[int] | None) -> None:
    """Two robots above each other: to minimise entropy they go towards each other."""
    strategy = TwoStage(measure="simple") if sense == "simple" else TwoStage(sense=sense)  # type: ignore[arg-type]
    state = world(strategy, [(160, 60), (30, 60)])
    next(play(state))
    candidates = [mind(state, robot).candidate for robot in range(2)]
    if expected is None:
        # One cluster each, before and after: all are equal, so the nearest borders decide.
        expected = [1, 3]
    assert candidates == expected


def test_the_vote_is_counted_as_in_the_paper() -> None:
    """Vertical only if up and down are more than left and right; who disagrees picks again."""
    two_up_one_right = world(
        TwoStage(tie="near", measure="simple"), [(190, 60), (190, 130), (90, 197)]
    )
    events = next(play(two_up_one_right))
    assert [mind(two_up_one_right, robot).candidate for robot in range(3)] == [1, 1, 0]
    for robot in range(3):
        board = mind(two_up_one_right, robot).board
        assert board is not None
        assert (board.axis, board.voted_by) == (0, 0)
    # The third goes for the nearer of up and down.
    assert [action.direction for action in events.actions] == [1, 1, 3]
    even = world(TwoStage(measure="simple"), [(190, 60), (90, 197)])
    next(play(even))
    board = mind(even).board
    assert board is not None
    assert board.axis == 1
    votes = [message for message in events.said if isinstance(message.body, Vote)]
    assert len(votes) == 6
    assert {message.size_bytes for message in votes} == {25}


def test_on_one_lane_the_higher_robot_goes_to_stage_2() -> None:
    state = world(TwoStage(), [(100, 60), (98, 60)])
    for _ in play(state, 2):
        pass
    phases = [mind(state, robot).phase for robot in range(2)]
    lanes_of = {mind(state, robot).rectangle is not None for robot in range(2)}
    headings = {claim.heading for claim in mind(state).board.claims.values()}  # type: ignore[union-attr]
    assert phases == [Phase.FIRST, Phase.AUCTION] or (len(headings) == 2 and lanes_of == {True})


def test_lanes_are_a_footprint_apart() -> None:
    lattice = world(TwoStage(), [(9, 9)], side=30).problem.plan.lattice
    assert half_footprint(4.0, lattice) == 8
    assert lanes(0, 99, 1, 8) == (8, 25)
    assert lanes(0, 99, -1, 8) == (91, 74)
    assert lanes(10, 33, 1, 8) == (18, 25)  # room for less than two footprints
    assert lanes(10, 26, 1, 8) == (18, 18)  # one lane
    assert lanes(10, 12, 1, 8) == (4, 4)  # no farther than needed


# --- stage 2 --------------------------------------------------------------------------------------


def test_statuses_follow_award_and_arrival_and_widths_end_at_0() -> None:
    state = world(TwoStage(), [(100, 60)])
    seen: list[str] = []
    widths: list[int] = []
    for _ in play(state):
        memory = mind(state)
        board = memory.board
        assert board is not None
        claim = board.claims[0]
        assert (claim.status is Status.TO_BE_SCANNED) <= (memory.phase is Phase.APPROACH)
        if not seen or seen[-1] != claim.status:
            seen.append(claim.status)
        widths.append(board.total_width())
    assert seen[:4] == ["being_scanned", "unscanned", "to_be_scanned", "being_scanned"]
    assert widths == sorted(widths, reverse=True)
    assert widths[-1] <= 2 * 17  # the last rectangle need not be closed


@pytest.mark.parametrize(("wait_s", "steps"), [(5.0, 2), (12.0, 5), (0.0, 0)])
def test_robots_stand_still_in_an_auction_period(wait_s: float, steps: int) -> None:
    """A step takes 2.5 s."""
    state = world(TwoStage(auction_wait_s=wait_s), [(40, 40)], side=80)
    still = [
        events.step for events in play(state) if events.actions[0].direction < 0 and events.step > 0
    ]
    auctions = mind(state).auctions
    assert auctions == 2
    assert len(still) in (auctions * steps, auctions * max(steps, 1))


def test_sections_of_a_team_do_not_overlap() -> None:
    state = world(TwoStage(), [(20, 20), (100, 90), (150, 170), (60, 140)])
    sold = 0
    for events in play(state):
        boards = [mind(state, robot).board for robot in range(4)]
        assert all(board == boards[0] for board in boards if board is not None) or events.said
        board = boards[0]
        assert board is not None
        taken = [claim for claim in board.held() if claim.heading == 0]
        for claim in taken:
            for other in taken:
                assert claim is other or claim.upper < other.lower or other.upper < claim.lower
        sold = sum(mind(state, robot).auctions for robot in range(4))
    assert sold > 4
    assert [mind(state, robot).auctions for robot in (1, 2, 3)] == [0, 0, 0]  # 0 hears all
    assert all(mind(state, robot).refused == 0 for robot in range(4))


def test_illegal_messages_are_refused_and_counted() -> None:
    state = world(TwoStage(), [(20, 20), (60, 60)], side=80)
    for _ in play(state, 3):
        pass
    before = pickle.dumps((mind(state).board, mind(state).bidder, mind(state).auctioneer))
    wrong = [Announce(()), Announce(((0, 9),)), Award((0, 9)), Bid((0, 9), 3.0)]
    state.in_flight = [(0, Message(1, 0, 0.0, body)) for body in wrong]
    next(play(state))
    assert mind(state).refused == 4
    assert pickle.dumps((mind(state).board, mind(state).bidder, mind(state).auctioneer)) == before


def test_a_silent_robot_s_section_is_free_again() -> None:
    state = world(TwoStage(silence_s=100.0), [(30, 30), (30, 100)], side=120)
    events = next(events for events in play(state) if mind(state, 1).phase is Phase.SCAN)
    memory = mind(state, 0)
    board = memory.board
    assert board is not None
    assert [c.robot for c in board.held(board.silent([events.step] * 2, events.step, 40, 0))].count(
        1
    )
    heard = [events.step, events.step]
    later = events.step + 41
    assert board.silent(heard, later, 40.0, 0) == [1]
    assert all(claim.robot == 0 for claim in board.held([1]))


# --- the flowchart --------------------------------------------------------------------------------


def test_the_page_has_the_flowchart_of_the_program() -> None:
    assert flow_table() in PAGE.read_text()


def test_every_phase_is_reached_and_left() -> None:
    assert {phase for phase, _ in FLOW} == set(Phase)
    assert set(FLOW.values()) == set(Phase) - {Phase.VOTE}


def test_robots_go_by_the_flowchart() -> None:
    allowed = {(phase, then) for (phase, _), then in FLOW.items()}
    # Within a step a robot may pass through several phases.
    for _ in range(4):
        allowed |= {(a, d) for a, b in allowed for c, d in allowed if b is c}
    state = world(TwoStage(), [(20, 20), (100, 90)])
    before = [Phase.VOTE] * 2
    for _ in play(state):
        for robot in range(2):
            now = mind(state, robot).phase
            assert now is before[robot] or (before[robot], now) in allowed
            before[robot] = now


# --- end to end -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("robots", "times_the_bound"), [(1, 1.3), (2, 1.55), (4, 1.8)])
def test_an_empty_world_takes_little_more_than_it_must(robots: int, times_the_bound: float) -> None:
    """The bound is the paper's world's: area not seen from the starts over 2 r v n."""
    rng = np.random.default_rng(1)
    starts = [(float(x), float(y)) for x, y in rng.uniform(2, 98, (robots, 2))]
    done = conav.explore(empty(), strategy=TwoStage(), robots=robots, starts=starts, **PAPER)
    assert done.status == "done"
    bound = (99.0**2 - robots * 3.15 * 16) / (2 * 4 * 0.2 * robots)
    assert done.metrics.time_s < times_the_bound * bound


@pytest.mark.parametrize("motion", ["8-connected", "4-connected", "forward-turn"])
def test_it_is_a_strategy_like_any_other(motion: str) -> None:
    check_strategy(TwoStage(), motion=motion)


def test_other_settings_are_as_good() -> None:
    check_strategy(
        TwoStage("maximise", "simple", 3.0, 1.0, "random", 2.0, "always", 0.0, 10.0), steps=200
    )


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("office", {"robots": 4}),
        ("office", {"robots": 3, "motion": "forward-turn", "radio": 5.0}),
        ("cave", {"robots": 2, "motion": "4-connected"}),
        ("maze", {"robots": 3, "radio": "off"}),
        ("maze", {"robots": 4, "traffic": "none"}),
        ("three-obstacles", {"robots": 1}),
        ("three-obstacles", {"robots": 4, "radio": 6.0}),
        ("field", {"robots": 4}),
    ],
)
def test_finishes_and_is_accepted(name: str, more: dict[str, Any], tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    done = conav.explore(name, strategy=TwoStage(), seed=2, out=out, **more)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_a_post_on_a_lane_is_passed() -> None:
    rows = ["#" * 40, *["#" + "." * 38 + "#"] * 28, "#" * 40]
    rows[14] = "#" + "." * 9 + "##" + "." * 27 + "#"
    grid = parse_ascii("\n".join(rows), resolution=0.5)
    done = conav.explore(
        grid, strategy=TwoStage(tie="order"), robots=1, starts=[(5.25, 2.25)], **PAPER
    )
    assert done.status == "done"


@pytest.mark.parametrize(
    "wrong",
    [
        {"cluster_m": 0.0},
        {"probe_m": -1.0},
        {"task_width_m": float("nan")},
        {"auction_wait_s": -1.0},
        {"silence_s": float("inf")},
    ],
)
def test_settings_out_of_range_are_named(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        TwoStage(**wrong)  # type: ignore[arg-type]
