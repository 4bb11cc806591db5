"""Deterministic automata over words of label sets, and when they accept.

The word of a robot. Wherever it is, the robot has a label: the set of regions it is in. Its word
is the label at the start, and then the new label at each change; no letter follows its equal. So a
word has a letter at least, says nothing of how long the robot stays, and is over when the robot
stops; only then is acceptance read, and a task is done if the word up to there is accepted.

The empty word belongs to no robot and is never accepted. What `accepting[0]` says before a letter
was read means nothing; it is chosen so that there are as few states as possible.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError

Letter = frozenset[str]
"""A label: the names of the regions a robot is in."""

INITIAL = 0
"""The state before the first letter."""


@dataclass(frozen=True, eq=False)
class Automaton:
    """A complete deterministic automaton; its states are 0 (`INITIAL`) and up.

    The arrays are copied and read-only. `conav.tasks.translate` makes them minimal and numbers
    states as a breadth-first search from 0 meets them, letters in order, so that automata over the
    same letters are equal where they accept the same words.

    Raises `InputError` for arrays that do not fit together.
    """

    propositions: tuple[str, ...]
    """The names that matter, sorted; those a label has beside them are ignored."""
    letters: tuple[Letter, ...]
    """The label sets that can occur."""
    transition: NDArray[np.int32]
    """The next state, (n_states, n_letters)."""
    accepting: NDArray[np.bool_]
    """Whether a word may end in a state, (n_states,)."""
    distance_to_accept: NDArray[np.int32] = field(init=False)
    """The fewest letters from a state to an accepting one, 0 from those, (n_states,).

    Every label set counts as being possible after every other, so a robot has at least so many
    changes of its label before it. -1 where no letters lead to an accepting state.
    """
    sink: NDArray[np.bool_] = field(init=False)
    """Whether no accepting state can be reached, (n_states,): a plan that comes here is lost."""
    _index: dict[Letter, int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        transition = np.array(self.transition, dtype=np.int32)
        accepting = np.array(self.accepting, dtype=np.bool_)
        shape = (len(accepting), len(self.letters))
        if transition.shape != shape or 0 in shape:
            raise InputError(
                "automaton", f"transition has shape {transition.shape} and not {shape}",
                "give a next state for each state and letter, one of each at least",
            )  # fmt: skip
        if transition.min() < 0 or transition.max() >= len(accepting):
            raise InputError("automaton", f"states are 0 to {len(accepting) - 1}", "use these")
        index = {letter: i for i, letter in enumerate(self.letters)}
        if len(index) < len(self.letters):
            raise InputError("automaton", "a letter is there twice", "leave it out once")
        distance = _distances(transition, accepting)
        sink = distance < 0
        for name, array in (
            ("transition", transition),
            ("accepting", accepting),
            ("distance_to_accept", distance),
            ("sink", sink),
        ):
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, "_index", index)

    @property
    def n_states(self) -> int:
        return len(self.accepting)

    @property
    def stutter_invariant(self) -> bool:
        """Whether repeated letters change nothing, as it is for every formula without X and WX.

        Where it is not, some words that are accepted may be words of no robot.
        """
        each = np.arange(len(self.letters))
        return bool((self.transition[self.transition, each] == self.transition).all())

    @property
    def satisfiable(self) -> bool:
        """Whether it accepts any word, be it one that repeats letters."""
        return not bool(self.sink[self.transition[INITIAL]].all())

    @property
    def valid(self) -> bool:
        """Whether it accepts every word that has a letter, also those that repeat letters."""
        reached = self._reached_by_words()
        return bool(self.accepting[reached].all())

    def letter(self, label: Collection[str]) -> int:
        """The number of a label. Raises `InputError` for one that was said not to occur."""
        known = frozenset(label).intersection(self.propositions)
        if known not in self._index:
            raise InputError(
                f"label {shown_letter(known)}",
                f"is none of the {len(self.letters)} that can occur",
                "make the automaton with it",
            )
        return self._index[known]

    def state_after(self, word: Iterable[Collection[str]]) -> int:
        """The state a word leads to. Raises `InputError` as `letter` does."""
        state = INITIAL
        for label in word:
            state = int(self.transition[state, self.letter(label)])
        return state

    def accepts(self, word: Iterable[Collection[str]]) -> bool:
        """Whether the task is done when the robot stops after this word.

        Labels that repeat the one before change nothing where it is `stutter_invariant`; elsewhere
        give a `stutter_free` word. Raises `InputError` as `letter` does.
        """
        labels = list(word)
        return bool(labels) and bool(self.accepting[self.state_after(labels)])

    def shortest_word(self) -> tuple[Letter, ...] | None:
        """A shortest word that is accepted, the first in order of letters; `None` without one.

        It repeats no letter where the automaton is `stutter_invariant`.
        """
        if not self.satisfiable:
            return None
        word: list[Letter] = []
        state = INITIAL
        while not word or not self.accepting[state]:
            after = self.transition[state]
            ahead = self.distance_to_accept[after]
            nearest = int(np.flatnonzero(ahead == ahead[ahead >= 0].min())[0])
            word.append(self.letters[nearest])
            state = int(after[nearest])
        return tuple(word)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Automaton):
            return NotImplemented
        return (
            self.letters == other.letters
            and np.array_equal(self.transition, other.transition)
            and np.array_equal(self.accepting, other.accepting)
        )

    def __hash__(self) -> int:
        return hash((self.letters, self.transition.tobytes(), self.accepting.tobytes()))

    def _reached_by_words(self) -> NDArray[np.bool_]:
        reached = np.zeros(self.n_states, dtype=np.bool_)
        fresh = np.unique(self.transition[INITIAL])
        while fresh.size:
            reached[fresh] = True
            ahead = np.unique(self.transition[fresh])
            fresh = ahead[~reached[ahead]]
        return reached


def stutter_free(labels: Iterable[Collection[str]]) -> tuple[Letter, ...]:
    """The word of a robot that had these labels one after the other: repetitions left out.

    >>> [sorted(letter) for letter in stutter_free([{"a"}, {"a"}, (), (), {"a"}])]
    [['a'], [], ['a']]
    """
    word: list[Letter] = []
    for label in map(frozenset, labels):
        if not word or word[-1] != label:
            word.append(label)
    return tuple(word)


def shown_letter(letter: Collection[str]) -> str:
    """A label for people.

    >>> shown_letter({"b", "a"}), shown_letter(())
    ('{a, b}', '{}')
    """
    return "{" + ", ".join(sorted(letter)) + "}"


def _distances(transition: NDArray[np.int32], accepting: NDArray[np.bool_]) -> NDArray[np.int32]:
    """The fewest letters to an accepting state, -1 where there are none."""
    far = len(accepting)
    distance = np.where(accepting, 0, far).astype(np.int32)
    while True:
        nearer = np.minimum(distance, distance[transition].min(axis=1) + 1).astype(np.int32)
        if np.array_equal(nearer, distance):
            break
        distance = nearer
    distance[distance >= far] = -1
    return distance
