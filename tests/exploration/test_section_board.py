"""The blackboard of sections and Algorithm 1, by hand."""

import pickle

import numpy as np
import pytest

from conav.exploration.section_board import (
    Board,
    Claim,
    News,
    Section,
    Status,
    divide,
    section_capacities,
)

FREE, AWARDED, SCANNING = Status.UNSCANNED, Status.TO_BE_SCANNED, Status.BEING_SCANNED


@pytest.mark.parametrize(
    ("widths", "robots", "task", "expected"),
    [
        ([30, 10], 1, 8, [1, 1]),  # step 1 alone: more sections than robots
        ([30, 10], 2, 8, [1, 1]),
        # 30 is largest, then 22, then 14: all three go to the first.
        ([30, 10], 5, 8, [4, 1]),
        # ... then 10 beats 6.
        ([30, 10], 6, 8, [4, 2]),
        ([30, 0, 10], 6, 8, [4, 0, 2]),
        # 8 is used up at once: step 5 ends it with fewer than the robots.
        ([8], 5, 8, [2]),
        ([9], 5, 8, [3]),
        ([5, 5], 3, 8, [2, 1]),  # ties go to the first
        ([0, 0], 3, 8, [0, 0]),
        ([], 3, 8, []),
    ],
)
def test_algorithm_1_by_hand(
    widths: list[float], robots: int, task: float, expected: list[int]
) -> None:
    assert section_capacities(widths, robots, task) == expected


def test_sections_are_divided_in_whole_lanes() -> None:
    assert divide(0, 99, 1, 17) == [(0, 99)]
    assert divide(0, 99, 2, 17) == [(0, 50), (51, 99)]  # six lanes, three each
    assert divide(10, 128, 2, 17) == [(10, 77), (78, 128)]  # seven lanes, four and three
    assert divide(0, 20, 5, 17) == [(0, 16), (17, 20)]  # two lanes, so two parts
    assert divide(3, 3, 4, 17) == [(3, 3)]
    for width in range(1, 120):
        for parts in range(1, 8):
            pieces = divide(5, 5 + width - 1, parts, 17)
            assert [b for a, b in pieces for b in range(a, b + 1)] == list(range(5, 5 + width))
            assert len(pieces) <= parts


def test_sections_follow_from_what_was_scanned() -> None:
    board = Board(axis=0, voted_by=0, size=100)
    assert board.free([]) == [(0, 99)]
    assert board.total_width() == 100
    assert board.scan(20, 36) == (20, 36)
    assert board.scan(-5, 3) == (0, 3)
    assert board.scan(97, 120) == (97, 99)
    assert board.free([]) == [(4, 19), (37, 96)]
    assert board.unscanned(10, 40) == [(10, 19), (37, 40)]
    assert board.width(10, 40) == 14
    assert board.total_width() == 16 + 60
    assert board.width(5, 4) == 0
    board.scan(0, 99)
    assert board.total_width() == 0
    assert board.free([]) == []
    assert board.offer([], 3, 17, 17) == []


def test_unscanned_sections_come_first() -> None:
    board = Board(axis=0, voted_by=0, size=100)
    board.scan(30, 49)
    assert board.offer(board.held(), 1, 17, 17) == [
        Section(0, 29, 30, 1, FREE),
        Section(50, 99, 50, 1, FREE),
    ]
    # A third robot: the larger section gets capacity 2 and is divided, 2 lanes and 1.
    assert board.offer(board.held(), 3, 17, 17) == [
        Section(0, 29, 30, 1, FREE),
        Section(50, 83, 34, 1, FREE),
        Section(84, 99, 16, 1, FREE),
    ]


def test_the_blackboard_shows_every_section_with_its_capacity() -> None:
    board = Board(axis=0, voted_by=0, size=200)
    board.scan(30, 49)
    board.enter(4, (100, 150), AWARDED, 7)
    board.enter(2, (151, 199), SCANNING, 7, advance=1, begun=1)
    board.scan(151, 160)
    # Three free robots: 1 and 1, then one more for the larger one, 50 wide. Of those that have a
    # robot, four robots in all: 51 falls to 34, 17 and 0, so three more; 39 alike to 22 and 5.
    assert board.sections(board.held(), 3, 17) == [
        Section(0, 29, 30, 1, FREE),
        Section(50, 99, 50, 2, FREE),
        Section(100, 150, 51, 4, AWARDED, 4),
        Section(151, 199, 39, 4, SCANNING, 2),
    ]
    board.enter(3, (50, 99), SCANNING, 8, heading=1)  # a rectangle of stage 1
    assert [section.lower for section in board.sections(board.held(), 3, 17)] == [0, 100, 151]


def test_then_sections_to_be_scanned_then_those_being_scanned() -> None:
    board = Board(axis=0, voted_by=0, size=136)
    board.enter(4, (0, 67), AWARDED, 7)
    board.enter(2, (68, 135), SCANNING, 7, advance=-1, begun=2)
    assert board.free(board.held()) == []
    # Of four lanes the one who has them keeps two, the near ones.
    assert board.offer(board.held(), 1, 17, 17) == [Section(34, 67, 34, 1, AWARDED, 4)]
    board.enter(4, (0, 16), AWARDED, 8)
    board.scan(17, 67)
    # One lane is not divided, so it is the other's turn, which scans downwards.
    assert board.offer(board.held(), 1, 17, 17) == [Section(68, 101, 34, 1, SCANNING, 2)]
    board.enter(2, (102, 135), SCANNING, 9, advance=-1, begun=2)
    board.scan(68, 101)
    # It has begun both lanes.
    assert board.offer(board.held(), 1, 17, 17) == []
    board.enter(2, (102, 135), SCANNING, 9, advance=-1, begun=1)
    assert board.offer(board.held(), 1, 17, 17) == [Section(102, 118, 17, 1, SCANNING, 2)]


def test_rectangles_of_stage_1_are_not_divided() -> None:
    board = Board(axis=0, voted_by=0, size=51)
    board.enter(0, (0, 50), SCANNING, 0, heading=1)
    assert board.offer(board.held(), 2, 17, 17) == []


def test_claims_end_with_their_width_or_when_a_robot_falls_silent() -> None:
    board = Board(axis=0, voted_by=0, size=60)
    board.enter(0, (0, 19), AWARDED, 1)
    board.enter(1, (20, 39), AWARDED, 1)
    assert [claim.robot for claim in board.held()] == [0, 1]
    assert [claim.robot for claim in board.held([0])] == [1]
    assert board.free(board.held([0])) == [(0, 19), (40, 59)]
    board.scan(15, 45)
    assert [claim.robot for claim in board.held()] == [0]
    board.release(0, 3)
    assert board.held() == []
    assert board.free(board.held()) == [(0, 14), (46, 59)]


def random_board(rng: np.random.Generator, robots: int = 3) -> Board:
    board = Board(axis=0, voted_by=int(rng.integers(3)), size=40)
    for _ in range(int(rng.integers(5))):
        lower = int(rng.integers(40))
        board.scan(lower, lower + int(rng.integers(10)))
    for _ in range(int(rng.integers(6))):
        lower = int(rng.integers(40))
        status = (AWARDED, SCANNING)[int(rng.integers(2))]
        board.enter(int(rng.integers(robots)), (lower, lower + 5), status, int(rng.integers(9)))
    return board


def content(board: Board) -> tuple[object, ...]:
    return board.axis, board.voted_by, board.scanned, board.claims


def test_boards_merge_to_the_same_whatever_the_order() -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        boards = [random_board(rng) for _ in range(3)]
        results: list[tuple[object, ...]] = []
        for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0)):
            merged = pickle.loads(pickle.dumps(boards[order[0]]))
            for other in order[1:]:
                merged.merge(boards[other].news())
                assert not merged.merge(boards[other].news())  # once is enough
            results.append(content(merged))
        assert results[0] == results[1] == results[2]


def test_the_newer_entry_holds() -> None:
    ours, theirs = (Board(axis=0, voted_by=0, size=40) for _ in range(2))
    ours.enter(1, (0, 9), AWARDED, 5)
    theirs.merge(ours.news())
    theirs.enter(1, (0, 9), SCANNING, 6)
    assert ours.merge(theirs.news())
    assert ours.claims[1].status is SCANNING
    assert not ours.merge(News(0, 0, (), (Claim(1, 0, 9, AWARDED, 1, 5),)))
    assert ours.claims[1].status is SCANNING


def test_of_two_axes_that_of_the_lowest_voter_holds() -> None:
    ours = Board(axis=0, voted_by=2, size=40)
    ours.scan(0, 9)
    ours.enter(2, (10, 19), AWARDED, 5)
    theirs = Board(axis=1, voted_by=1, size=40)
    theirs.scan(30, 39)
    assert not theirs.merge(ours.news())
    assert content(theirs)[:2] == (1, 1)
    assert ours.merge(theirs.news())
    assert content(ours) == content(theirs)


def test_messages_have_defined_sizes() -> None:
    board = Board(axis=0, voted_by=0, size=40)
    assert board.news().size_bytes == 13
    board.scan(0, 3)
    board.scan(9, 9)
    board.enter(1, (20, 30), AWARDED, 5)
    assert board.news().scanned == ((0, 3), (9, 9))
    assert board.news().size_bytes == 13 + 2 * 8 + 24
