"""The generators of bulk games give the numbers of the robots' own generators, one for one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.simulation.bulk_random import (
    name_words,
    next_double,
    next_quarter,
    next_word,
    seed_generator,
)
from conav.simulation.world_state import generator_for

# One and two words of seed, and their borders; robots take seeds up to 2**63.
SEEDS = [0, 1, 7, 2**31, 2**32 - 1, 2**32, 2**32 + 1, 2**40 + 7, 2**63 - 1, 2**63, 2**64 - 1]
# With the seed, names of up to three bytes fit into the pool of four words and longer ones do not.
NAMES = [
    "",
    "a",
    "ab",
    "abc",
    "abcd",
    "robot_0",
    "robot_1023",
    "Zoë",
    "机器人",
    "🤖" * 3,
    "\0",
    "x" * 999,
]


def seeded(seed: int, names: list[str]) -> NDArray[np.uint64]:
    """The states of new generators for these names, in one table as games have them."""
    rows = name_words(names)
    # Rubbish from another game must not matter.
    states = np.full((len(names), 4), 2**64 - 1, dtype=np.uint64)
    for i in range(len(names)):
        seed_generator(np.uint64(seed), rows[i], states, i)
    return states


@pytest.mark.parametrize("seed", SEEDS)
def test_a_heading_and_then_numbers(seed: int) -> None:
    states = seeded(seed, NAMES)
    for i, name in enumerate(NAMES):
        rng = generator_for(seed, name)
        assert next_quarter(states, i) == int(rng.integers(4))
        assert [next_double(states, i) for _ in range(100)] == rng.random(100).tolist()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_state_is_that_of_pcg64(seed: int) -> None:
    for name, row in zip(NAMES, seeded(seed, NAMES).tolist(), strict=True):
        state = generator_for(seed, name).bit_generator.state["state"]
        assert (row[0] << 64) + row[1] == state["state"]
        assert (row[2] << 64) + row[3] == state["inc"]


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 2**64 - 1), st.text(max_size=30))
def test_any_seed_and_any_name(seed: int, name: str) -> None:
    states = seeded(seed, ["another", name, "a third, with a longer name than any other"])
    rng = generator_for(seed, name)
    assert next_quarter(states, 1) == int(rng.integers(4))
    for _ in range(5):
        assert next_double(states, 1) == rng.random()


def test_a_long_run_of_words() -> None:
    # Long enough for every carry and every rotation of the output.
    states = seeded(2**40 + 7, ["robot_0"])
    raw = generator_for(2**40 + 7, "robot_0").bit_generator.random_raw(50_000).tolist()
    assert [int(next_word(states, 0)) for _ in raw] == raw


def test_generators_do_not_disturb_each_other() -> None:
    names = ["robot_0", "robot_1", "robot_10"]
    together = seeded(5, names)
    rngs = [generator_for(5, name) for name in names]
    for i in np.random.default_rng(0).integers(3, size=300).tolist():
        assert next_double(together, i) == rngs[i].random()


def test_a_heading_for_every_quarter() -> None:
    rows = name_words(["robot_0"])
    states = np.zeros((1, 4), dtype=np.uint64)
    found = []
    for seed in range(400):
        seed_generator(np.uint64(seed), rows[0], states, 0)
        found.append(next_quarter(states, 0))
        assert found[-1] == int(generator_for(seed, "robot_0").integers(4))
    # Within five standard deviations of even, so that four equal numbers do not go unnoticed.
    assert all(abs(found.count(k) - 100) < 5 * 8.7 for k in range(4))


def test_names_become_rows_of_bytes() -> None:
    assert name_words(["", "ab", "é"]).tolist() == [[0, 0, 0], [2, 97, 98], [2, 195, 169]]
    assert name_words([]).shape == (0, 1)
