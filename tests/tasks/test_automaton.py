"""What an automaton says of itself."""

import pickle
from collections.abc import Callable
from itertools import product
from random import Random

import numpy as np
import pytest

from conav.errors import InputError
from conav.tasks.automaton import INITIAL, Automaton, stutter_free
from conav.tasks.formula import Formula
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, disjoint_letters, every_letter

GOAL = automaton_of(parse_formula("F goal & G safe"))


def test_the_task_of_the_paper_by_hand() -> None:
    """States: under way, lost, done; letters {}, {goal}, {safe}, {goal, safe}."""
    assert [sorted(letter) for letter in GOAL.letters] == [
        [], ["goal"], ["safe"], ["goal", "safe"],
    ]  # fmt: skip
    assert GOAL.propositions == ("goal", "safe")
    assert GOAL.transition.tolist() == [[1, 1, 0, 2], [1, 1, 1, 1], [1, 1, 2, 2]]
    assert GOAL.accepting.tolist() == [False, False, True]
    assert GOAL.sink.tolist() == [False, True, False]
    assert GOAL.distance_to_accept.tolist() == [1, -1, 0]
    assert GOAL.transition.dtype == GOAL.distance_to_accept.dtype == np.int32
    assert GOAL.satisfiable
    assert not GOAL.valid


def test_a_word_has_a_letter() -> None:
    """The robot is somewhere: not even a tautology accepts the empty word."""
    for text in ("true", "G a", "F a | G !a"):
        task = automaton_of(parse_formula(text))
        assert not task.accepts([])
        assert task.state_after([]) == INITIAL


def test_acceptance_is_read_at_the_end_only() -> None:
    task = automaton_of(parse_formula("F G a"))
    assert task.accepts([{"a"}])
    assert not task.accepts([{"a"}, ()])
    assert task.accepts([{"a"}, (), {"a"}])


def test_distances_are_the_shortest_words(random_formula: Callable[..., Formula]) -> None:
    """Against trying all words from every state."""
    rng = Random(4)
    longest = 0
    for _ in range(60):
        task = automaton_of(random_formula(rng, 6, "ab", True), every_letter("ab"))
        for start in range(task.n_states):
            reached, steps = {start}, 0
            while not any(task.accepting[s] for s in reached) and steps <= task.n_states:
                reached = {int(t) for s in reached for t in task.transition[s]}
                steps += 1
            expected = steps if steps <= task.n_states else -1
            assert task.distance_to_accept[start] == expected
            assert task.sink[start] == (expected == -1)
            longest = max(longest, expected)
    assert longest >= 2


def test_satisfiable_and_valid_by_all_short_words(random_formula: Callable[..., Formula]) -> None:
    rng = Random(5)
    seen: set[tuple[bool, bool]] = set()
    letters = every_letter("ab")
    for _ in range(200):
        task = automaton_of(random_formula(rng, 3, "ab", False), letters)
        if task.n_states > 4:
            continue
        outcomes = [
            task.accepts(word) for length in range(1, 5) for word in product(letters, repeat=length)
        ]
        assert task.satisfiable == any(outcomes)
        assert task.valid == all(outcomes)
        seen.add((task.satisfiable, task.valid))
        word = task.shortest_word()
        if word is None:
            assert not task.satisfiable
            continue
        assert task.accepts(word)
        assert len(stutter_free(word)) == len(word)
        assert not any(
            task.accepts(other)
            for length in range(1, len(word))
            for other in product(letters, repeat=length)
        )
    assert seen == {(False, False), (True, False), (True, True)}


def test_the_empty_alphabet_of_names() -> None:
    task = automaton_of(parse_formula("true"))
    assert task.letters == (frozenset(),)
    assert task.accepts([{"anything"}])
    assert task.shortest_word() == (frozenset(),)


def test_arrays_cannot_be_changed_and_are_copies() -> None:
    rows, ends = np.array([[0]], dtype=np.int32), np.array([True])
    task = Automaton((), (frozenset(),), rows, ends)
    ends[0] = False
    assert task.accepting[0]
    for array in (task.transition, task.accepting, task.sink, task.distance_to_accept):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_pickled_and_back() -> None:
    again = pickle.loads(pickle.dumps(GOAL))
    assert again == GOAL
    assert hash(again) == hash(GOAL)
    assert again.accepts([{"safe"}, {"safe", "goal"}])


@pytest.mark.parametrize(
    ("rows", "ends", "letters", "problem"),
    [
        ([[0]], [True, False], [()], "shape"),
        ([[0, 0]], [True], [()], "shape"),
        (np.zeros((0, 1)), [], [()], "shape"),
        (np.zeros((1, 0)), [True], [], "shape"),
        ([[1]], [True], [()], "states are 0 to 0"),
        ([[-1]], [True], [()], "states are 0 to 0"),
        ([[0, 0]], [True], [(), ()], "twice"),
    ],
)
def test_automata_that_do_not_fit_together(
    rows: object, ends: object, letters: list[tuple[str, ...]], problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        Automaton((), tuple(map(frozenset, letters)), np.array(rows), np.array(ends))


def test_letters_of_regions_that_do_not_overlap() -> None:
    assert disjoint_letters(["b", "a", "b"]) == tuple(map(frozenset, ("", "a", "b")))
