"""Less anarchy: rules that leave fewer bad equilibria, each judged by counting them all.

In a `PathGame` a robot's cost is that of its own path, and others only bar paths from it. So

- **Payments for what others suffer change nothing.** What a robot pays for the others' costs, as a
  Clarke pivot (the marginal delay it causes) or in Groves form (all of them), does not depend on
  its own path while the others' stand. So its best answers, and all equilibria, are the same.
- **Tolls on paths may leave bad equilibria standing.** With a plan announced, a robot pays for each
  reserved path its own runs into. But where the others bar all paths without a toll from it, it
  pays and stays.
- **Right of way leaves none.** When a robot may only take paths apart from everybody else's
  reserved one, its own reserved path is open to it whatever the others take. So in an equilibrium
  nobody's path costs more than its reserved one; and when the plan is a social optimum, every
  equilibrium costs the same as it, however long paths may be. Nothing is paid. A robot that is
  better off in another equilibrium than in the plan loses; `side_payments` shares what the team
  saves, sums to 0, and then nobody loses.

Costs are taken as known: no claim is made of robots that lie about theirs.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.planning.prices import (
    PathGame,
    Profile,
    equilibria,
    free_paths,
    profiles,
    social_optima,
)

Charge = Callable[[int, Profile], float]
"""What a robot pays at a profile, beside its cost."""


@dataclass(frozen=True)
class Outcome:
    """A rule on a game of one cost, by all its equilibria. Costs are without payments."""

    rule: str
    equilibria: int
    best: float  # sums of costs
    worst: float
    worst_profile: Profile  # of the game without the rule
    least_collected: float  # of all robots together, over the equilibria
    most_collected: float
    may_lose: tuple[int, ...]
    """Robots that pay more at an equilibrium under the rule than at one without, payments included.
    """


def marginal_delay(game: PathGame) -> Charge:
    """The Clarke pivot: what the others pay at a profile beyond what they would without the robot.

    It is 0 or more, so the sum collected is too: it is no balanced budget.
    """
    least = [_least_of_others(game, robot) for robot in range(game.size)]
    return lambda robot, profile: _others(game, robot, profile) - least[robot]


def team_cost(game: PathGame) -> Charge:
    """Groves form: all others' costs, so that each robot's cost is the team's."""
    return lambda robot, profile: _others(game, robot, profile)


def equilibria_under(game: PathGame, charge: Charge) -> list[Profile]:
    """All equilibria when each robot minds its cost and its charge; by trying every deviation."""
    found: list[Profile] = []
    for profile in profiles(game):
        for robot in range(game.size):
            own = _burden(game, charge, robot, profile)
            free = np.flatnonzero(free_paths(game, profile, robot)).tolist()
            changed = ((*profile[:robot], path, *profile[robot + 1 :]) for path in free)
            if any(_burden(game, charge, robot, other) < own for other in changed):
                break
        else:
            found.append(profile)
    return found


def tolls(game: PathGame, plan: Profile, rate: float) -> tuple[NDArray[np.float64], ...]:
    """What each path pays, (paths,) of each robot: `rate` for each reserved path it runs into."""
    return tuple(rate * hit.astype(np.float64) for hit in _run_into(game, plan))


def right_of_way(game: PathGame, plan: Profile) -> tuple[NDArray[np.int64], ...]:
    """The paths each robot may take: those apart from everybody else's reserved path."""
    return tuple(np.flatnonzero(hit == 0) for hit in _run_into(game, plan))


def side_payments(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each robot pays (negative: gets) when costs go from `before` to `after`, (robots,).

    They sum to 0, and every robot gains the same: an equal share of what the team saves.
    """
    return (before - after) - (before.sum() - after.sum()) / len(before)


def outcomes(game: PathGame) -> list[Outcome]:
    """What becomes of a game of one cost without a rule and under each of them.

    The plan announced is the first social optimum; tolls are higher than any path's cost. The rules
    of payments for others' costs are gone through by `equilibria_under`, so let the game be small.
    """
    plan = social_optima(game)[0]
    before = list(equilibria(game))
    pivot, groves = marginal_delay(game), team_cost(game)
    high = 1.0 + max(float(costs.max()) for costs in game.costs)
    toll = tolls(game, plan, high)
    allowed = right_of_way(game, plan)
    under_way = (
        tuple(int(allowed[i][p]) for i, p in enumerate(profile))
        for profile in equilibria(game.restricted(allowed))
    )
    return [
        _outcome(game, "none", before, before, _nothing),
        _outcome(game, "marginal delay", before, equilibria_under(game, pivot), pivot),
        _outcome(game, "team cost", before, equilibria_under(game, groves), groves),
        _outcome(
            game,
            "tolls",
            before,
            equilibria(game.priced(toll)),
            lambda robot, profile: float(toll[robot][profile[robot]]),
        ),
        _outcome(game, "right of way", before, under_way, _nothing),
    ]


def _outcome(
    game: PathGame, rule: str, before: Sequence[Profile], after: Iterable[Profile], charge: Charge
) -> Outcome:
    robots = range(game.size)
    found = list(after)
    assert found, "a plan announced is an equilibrium under every rule here"
    totals = [float(game.cost(profile)[0]) for profile in found]
    paid = [sum(charge(robot, profile) for robot in robots) for profile in found]
    lowest = [min(_burden(game, _nothing, robot, p) for p in before) for robot in robots]
    highest = [max(_burden(game, charge, robot, p) for p in found) for robot in robots]
    return Outcome(
        rule,
        len(found),
        min(totals),
        max(totals),
        found[totals.index(max(totals))],
        min(paid),
        max(paid),
        tuple(robot for robot in robots if highest[robot] > lowest[robot]),
    )


def _nothing(robot: int, profile: Profile) -> float:
    return 0.0


def _burden(game: PathGame, charge: Charge, robot: int, profile: Profile) -> float:
    return float(game.costs[robot][profile[robot], 0]) + charge(robot, profile)


def _others(game: PathGame, robot: int, profile: Profile) -> float:
    return sum(float(game.costs[i][p, 0]) for i, p in enumerate(profile) if i != robot)


def _least_of_others(game: PathGame, robot: int) -> float:
    """The optimum of the others, with the robot away."""
    rest = [i for i in range(game.size) if i != robot]
    if not rest:
        return 0.0
    without = PathGame(
        tuple(game.costs[i] for i in rest),
        tuple(tuple(game.apart[i][j] for j in rest) for i in rest),
    )
    return float(without.cost(social_optima(without)[0])[0])


def _run_into(game: PathGame, plan: Profile) -> list[NDArray[np.int64]]:
    """How many others' paths of a plan each path runs into, (paths,) of each robot."""
    return [
        np.sum(
            [~game.apart[other][robot][plan[other]] for other in range(game.size) if other != robot]
            or [np.zeros(len(game.costs[robot]), np.bool_)],
            axis=0,
        )
        for robot in range(game.size)
    ]
