"""The verifier's formulas by hand, and its words against dense sampling."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.trajectory import positions, straight
from conav.planning.types import Trajectory
from conav.planning.verify_regions import depth, stays_in, words
from conav.planning.verify_scene import Area
from conav.planning.verify_task import Unreadable, names_in, read_formula, satisfied

from .test_trajectory import any_piece

A, B, AB, NO = frozenset("a"), frozenset("b"), frozenset("ab"), frozenset()


@pytest.mark.parametrize(
    ("text", "word", "expected"),
    [
        ("F a", [NO, A], True),
        ("F a", [NO, B], False),
        ("G !a", [NO, B, NO], True),
        ("G !a", [NO, A, NO], False),
        ("!b U a", [NO, A, B], True),
        ("!b U a", [B, A], False),
        ("!b U a", [NO], False),
        ("!b W a", [NO], True),
        ("a R !b", [NO], True),
        ("a R !b", [NO, A, B], True),
        ("a R !b", [NO, AB], False),
        ("X a", [NO, A], True),
        ("X a", [A], False),
        ("WX a", [A], True),
        ("sequence(a, b)", [NO, A, NO, B], True),
        ("sequence(a, b)", [B, A], False),
        ("sequence(a, b)", [AB], True),
        ("coverage(a, b) and avoid(c)", [B, A], True),
        ("<> a => [] !b", [A, B], False),
        ("F a -> F b", [NO], True),
        ("a <-> b", [AB], True),
        ("a <-> b", [A], False),
        ("F a & F b | G a", [A], True),  # & binds stronger than |
        ("F a U b", [NO, B, A], True),  # (F a) U b
        ('eventually "a"', [A], True),
        ("a -> b -> a", [A], True),  # to the right
        ("true", [NO], True),
        ("false | TRUE", [NO], True),
        ("F (a & F b)", [A, B], True),
        ("G F a", [A, NO], False),
        ("F G a", [NO, A], True),
        ("F a", [], False),
    ],
)
def test_formulas_by_hand(text: str, word: list[frozenset[str]], expected: bool) -> None:
    assert satisfied(read_formula(text), word) == expected


@pytest.mark.parametrize(
    "text", ["", "F", "a b", "(a", "a)", "a & ", "coverage a", 'F "a', "a ? b"]
)
def test_texts_that_are_no_formula(text: str) -> None:
    with pytest.raises(Unreadable):
        read_formula(text)


def test_names() -> None:
    assert names_in(read_formula('F "room 1" & avoid(b, c) | F d')) == {"room 1", "b", "c", "d"}


DISC = Area((2.0, 0.0, 1.0), None)
SQUARE = Area(None, np.array([(4, -1), (6, -1), (6, 1), (4, 1.0)]))
L_SHAPE = Area(None, np.array([(-2, -2), (2, -2), (2, -1), (-1, -1), (-1, 2), (-2, 2.0)]))


def test_a_word_by_hand() -> None:
    track = straight([(0, 0), (7, 0)], [0, 7]).pieces
    assert words(track, {"a": DISC, "b": SQUARE}) == [(NO, A, NO, B, NO)]
    assert np.allclose(stays_in(track, DISC, 0.0), [(1, 3)])
    assert np.allclose(stays_in(track, SQUARE, 0.5), [(3.5, 6.5)])


def test_a_robot_that_stands() -> None:
    assert words(straight([(2, 0), (2, 0)], [0, 5]).pieces, {"a": DISC}) == [(A,)]
    moment = np.array([[0, 0, 2, 0, 0, 0, 0, 0, 0.0]])
    assert words(moment, {"a": DISC, "b": SQUARE}) == [(A,)]


def test_a_graze_may_be_read_either_way() -> None:
    touching = straight([(0, 1), (4, 1)], [0, 4]).pieces
    higher = np.array([0, 0, 0, 1e-5, 0, 0, 0, 0, 0])
    assert set(words(touching, {"a": DISC})) == {(NO,), (NO, A, NO)}
    assert words(touching + higher, {"a": DISC}) == [(NO,)]
    assert words(touching - higher, {"a": DISC}) == [(NO, A, NO)]


def test_regions_side_by_side() -> None:
    other = Area(None, np.array([(6, -1), (8, -1), (8, 1), (6, 1.0)]))
    track = straight([(5, 0), (7, 0)], [0, 2]).pieces
    found = words(track, {"a": SQUARE, "b": other})
    assert (A, AB, B) in found
    assert all(word[0] == A and word[-1] == B for word in found)


def test_many_turns_of_a_circle() -> None:
    arc = np.array([[0, 6 * pi, 0, 0, 0, 1, 0, 0, -1.0]])  # about (1, 0), to the right, 3 times
    assert words(arc, {"a": DISC}) == [(NO, A, NO, A, NO, A, NO)]


@settings(max_examples=200, deadline=None)
@given(any_piece(), st.sampled_from([DISC, SQUARE, L_SHAPE]), st.sampled_from([0.0, 0.3, -0.2]))
def test_stays_are_those_of_samples(piece: np.ndarray, area: Area, offset: float) -> None:
    stays = stays_in(piece[np.newaxis], area, offset)
    times = np.linspace(piece[0], piece[1], 500)
    for t, (x, y) in zip(times, positions(Trajectory(piece), times).tolist(), strict=True):
        deep = depth(area, x, y) + offset
        if abs(deep) > 1e-5:
            assert any(a - 1e-9 <= t <= b + 1e-9 for a, b in stays) == (deep > 0)
