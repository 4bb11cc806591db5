"""The compiled rendezvous against the same rules in plain Python, state by state."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.games.rendezvous import TIE, rendezvous_game, sequences
from conav.games.rendezvous_play import play_games, playthrough, share_of_consensus
from conav.games.responses import better_responses

MASK = 2**64 - 1
STEP = {0: (1, 0), 1: (0, 1), 2: (-1, 0), 3: (0, -1)}


def draw(seed: int, number: int) -> int:
    z = (seed + (number + 1) * 0x9E3779B97F4A7C15) & MASK
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & MASK
    z = (z ^ z >> 27) * 0x94D049BB133111EB & MASK
    return z ^ z >> 31


def pick(seed: int, number: int, of: list[int]) -> int:
    return of[(draw(seed, number) >> 33) * len(of) >> 31]


@dataclass
class Walker:
    x: int
    y: int
    heading: int
    turned: bool = False


class Team:
    """Robots that play by the rules of `rendezvous_step`, slowly."""

    def __init__(self, seed: int, epsilon: float, robots: int, width: int, height: int) -> None:
        self.seed, self.epsilon = seed, epsilon
        self.width, self.height = width, height
        self.t = 0
        self.walkers = [
            Walker(
                pick(seed, 3 * i, list(range(width))),
                pick(seed, 3 * i + 1, list(range(height))),
                pick(seed, 3 * i + 2, [0, 1, 2, 3]),
            )
            for i in range(robots)
        ]

    def move(self, x: int, y: int, heading: int) -> tuple[int, int]:
        """A move forward, or none at the border."""
        x2, y2 = x + STEP[heading][0], y + STEP[heading][1]
        return (x2, y2) if 0 <= x2 < self.width and 0 <= y2 < self.height else (x, y)

    def going_on(self, walker: Walker) -> tuple[int, int]:
        once = self.move(walker.x, walker.y, walker.heading)
        return self.move(*once, walker.heading)

    def utility(self, i: int, end: tuple[int, int]) -> float:
        others = [self.going_on(walker) for j, walker in enumerate(self.walkers) if j != i]
        return -sum(abs(complex(end[0] - x, end[1] - y)) for x, y in others)

    def decide(self, i: int) -> int:
        """How many quarter turns to the left the robot makes now; 0 goes forward."""
        walker = self.walkers[i]
        here = (walker.x, walker.y)
        after = {k: self.move(*here, (walker.heading + k) % 4) for k in (1, 2, 3)}
        turns = [k for k in after if after[k] != here]
        number = 3 * len(self.walkers) + 2 * (self.t * len(self.walkers) + i)
        if self.move(*here, walker.heading) == here:
            worth = {k: self.utility(i, after[k]) for k in turns}
            best = [k for k in turns if worth[k] >= max(worth.values()) - TIE]
            return pick(self.seed, number + 1, best)
        if walker.turned or self.t == 0:
            return 0
        if (draw(self.seed, number) >> 11) / 2**53 >= self.epsilon:
            return 0
        turn = pick(self.seed, number + 1, [0, *turns])
        if turn == 0:
            return 0
        gain = self.utility(i, after[turn]) - self.utility(i, self.going_on(walker))
        return turn if gain > TIE else 0

    def step(self) -> None:
        turns = [self.decide(i) for i in range(len(self.walkers))]
        for walker, turn in zip(self.walkers, turns, strict=True):
            if turn:
                walker.heading = (walker.heading + turn) % 4
            else:
                walker.x, walker.y = self.move(walker.x, walker.y, walker.heading)
            walker.turned = turn > 0
        self.t += 1

    def state(self) -> list[list[int]]:
        return [[w.x, w.y, w.heading, int(w.turned)] for w in self.walkers]

    def apart(self) -> int:
        return max(max(abs(a.x - b.x), abs(a.y - b.y)) for a in self.walkers for b in self.walkers)


grids = st.sampled_from([(2, 1), (1, 5), (2, 2), (4, 3), (7, 7), (20, 11)])
epsilons = st.sampled_from([0.0, 0.05, 0.5, 1.0])


@settings(deadline=None)
@given(grids, st.integers(2, 4), epsilons, st.integers(0, MASK), st.integers(0, 9))
def test_every_state_is_the_same(
    grid: tuple[int, int], robots: int, epsilon: float, seed: int, game: int
) -> None:
    size = {"robots": robots, "width": grid[0], "height": grid[1], "seed": seed}
    states = playthrough(epsilon, game, 60, **size)
    team = Team(draw(seed, game), epsilon, robots, *grid)
    near = met = -1
    for t, state in enumerate(states):
        if t > 0:
            team.step()
        assert state.tolist() == team.state(), t
        near = t if near < 0 and team.apart() <= 1 else near
        met = t if met < 0 and team.apart() == 0 else met
    assert len(states) == (61 if met < 0 else met + 1)
    played = play_games(epsilon, game + 1, 60, **size)
    assert (played.met[game], played.near[game]) == (met, near)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, MASK))
def test_turns_away_from_the_border_are_better_responses(seed: int) -> None:
    turns = 0
    states = playthrough(1.0, 0, 80, robots=3, width=9, height=9, seed=seed)
    for before, after in pairwise(states):
        positions = [(int(x), int(y)) for x, y in before[:, :2]]
        headings = [int(heading) for heading in before[:, 2]]
        game = rendezvous_game(positions, headings, 9, 9)
        own = [sequences(*at, h, 9, 9) for at, h in zip(positions, headings, strict=True)]
        if any(ends[0].turn != 0 for ends in own):
            continue  # one cannot go forward
        for i in np.flatnonzero(after[:, 3]):
            turn = int(after[i, 2] - before[i, 2]) % 4
            action = [end.turn for end in own[i]].index(turn)
            assert action in better_responses(game, int(i), (0, 0, 0), TIE)
            assert not before[i, 3]
            turns += 1
    assert turns > 0 or len(states) < 20


def test_without_exploring_robots_turn_at_the_border_only() -> None:
    states = playthrough(0.0, 0, 300, robots=4, width=6, height=8, seed=3)
    seen = 0
    for before, after in pairwise(states):
        for i in np.flatnonzero(after[:, 3]):
            x, y, heading, _ = (int(value) for value in before[i])
            assert sequences(x, y, heading, 6, 8)[0].turn != 0
            seen += 1
    assert seen > 20


def test_longer_and_more_games_begin_alike() -> None:
    short = play_games(0.2, 50, 100, width=8, height=8, seed=4)
    long = play_games(0.2, 80, 400, width=8, height=8, seed=4)
    assert np.array_equal(np.where(long.met[:50] <= 100, long.met[:50], -1), short.met)
    assert np.array_equal(np.where(long.near[:50] <= 100, long.near[:50], -1), short.near)
    assert (long.met >= 0).sum() > (short.met >= 0).sum() > 0
    together = long.met >= 0
    assert (long.near[together] <= long.met[together]).all()


def test_shares_of_known_games() -> None:
    # The same on every machine.
    counts = [share_of_consensus(epsilon, 200, 500, seed=1).successes for epsilon in (0.01, 0.1, 1)]
    assert counts == [35, 147, 200]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"epsilon": -0.1}, "probability"),
        ({"epsilon": 1.1}, "probability"),
        ({"games": 0}, "0 games"),
        ({"steps": -1}, "-1 steps"),
        ({"robots": 1}, "two can meet"),
        ({"width": 1, "height": 1}, "no room"),
        ({"seed": -1}, "seed -1"),
        ({"seed": 2**64}, "seed"),
    ],
)
def test_bad_numbers_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        play_games(**{"epsilon": 0.1, "games": 1, "steps": 1, **arguments})
    if "games" not in arguments:
        with pytest.raises(ValueError, match=message):
            playthrough(**{"epsilon": 0.1, "game": 0, "steps": 1, **arguments})
