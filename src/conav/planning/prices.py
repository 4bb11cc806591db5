"""Prices of anarchy and of stability, exactly, for a few paths of each robot.

A `PathGame` has for each robot some paths with their costs, and says which two paths of different
robots keep apart. A profile is a path of each robot, all apart. It is an equilibrium when no robot
has another path apart from all others' that dominates its own: nowhere dearer, somewhere cheaper
(with one cost: that is cheaper). It is a social optimum when no profile's sum of costs dominates
its own [Zhu2014, Definitions 1 and 2].

Everything is found by going through profiles: paths apart from all chosen so far are a row of
booleans, and of the last robot only paths are looked at that nothing dominates among those left. So
a game has an answer when the paths of all robots but one can be combined in a few million ways.

Every social optimum is an equilibrium: a robot that could do better alone would make a profile with
a better sum, since nobody else's cost changes. So the price of stability, best equilibrium over
optimum, is 1; `prices` checks both and fails loudly if they do not hold.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Profile = tuple[int, ...]
"""The number of each robot's path."""


@dataclass(frozen=True, eq=False)
class PathGame:
    """Paths of robots. Costs are compared exactly, so let them be whole numbers or share a grid.

    `costs[i]` has shape (paths of i, components); `apart[i][j]`, for i != j, shape (paths of i,
    paths of j), says which keep apart.
    """

    costs: tuple[NDArray[np.float64], ...]
    apart: tuple[tuple[NDArray[np.bool_], ...], ...]

    @property
    def size(self) -> int:
        """The number of robots."""
        return len(self.costs)

    def cost(self, profile: Profile) -> NDArray[np.float64]:
        """The sum of costs, (components,)."""
        return np.sum([self.costs[i][p] for i, p in enumerate(profile)], axis=0)

    def restricted(self, allowed: tuple[NDArray[np.int64], ...]) -> "PathGame":
        """The game with only these paths of each robot."""
        return PathGame(
            tuple(costs[keep] for costs, keep in zip(self.costs, allowed, strict=True)),
            tuple(
                tuple(
                    np.empty((0, 0), np.bool_)
                    if i == j
                    else rows[j][np.ix_(allowed[i], allowed[j])]
                    for j in range(self.size)
                )
                for i, rows in enumerate(self.apart)
            ),
        )

    def priced(self, tolls: tuple[NDArray[np.float64], ...]) -> "PathGame":
        """The game in which each path costs a toll more, (paths,), in every component."""
        costs = tuple(c + t[:, None] for c, t in zip(self.costs, tolls, strict=True))
        return PathGame(costs, self.apart)


@dataclass(frozen=True)
class Prices:
    """What `prices` found. Sums are None where costs are vectors, profiles are examples."""

    optima: tuple[Profile, ...]  # one profile for each sum that is a social optimum's
    equilibria: int  # how many profiles are equilibria
    optimum: float | None  # the least sum of costs
    best_equilibrium: float | None
    worst_equilibrium: float | None
    worst_profile: Profile | None

    @property
    def price_of_anarchy(self) -> float | None:
        """Worst equilibrium over optimum: 1 when nobody pays at all."""
        return _ratio(self.worst_equilibrium, self.optimum)

    @property
    def price_of_stability(self) -> float | None:
        """Best equilibrium over optimum."""
        return _ratio(self.best_equilibrium, self.optimum)


def prices(game: PathGame) -> Prices | None:
    """The optimum and all equilibria of a game; None when no profile keeps everybody apart."""
    optima = social_optima(game)
    if not optima:
        return None
    for profile in optima:
        assert is_equilibrium(game, profile), "every social optimum is an equilibrium"
    count = 0
    scalar = game.costs[0].shape[1] == 1
    best = worst = None
    worst_profile = None
    for profile in equilibria(game):
        count += 1
        if scalar:
            total = float(game.cost(profile)[0])
            best = total if best is None else min(best, total)
            if worst is None or total > worst:
                worst, worst_profile = total, profile
    optimum = float(game.cost(optima[0])[0]) if scalar else None
    assert best == optimum, "the price of stability is 1"
    return Prices(tuple(optima), count, optimum, best, worst, worst_profile)


def equilibria(game: PathGame) -> Iterator[Profile]:
    """All profiles that are equilibria, in lexicographic order."""
    best: dict[tuple[int, Profile], NDArray[np.float64]] = {}  # answers do not depend on one's own
    for before, left in _beginnings(game):
        for last in _undominated(game.costs[-1], left):
            profile = (*before, last)
            for robot in range(game.size - 1):
                others = robot, (*profile[:robot], -1, *profile[robot + 1 :])
                if others not in best:
                    best[others] = _best_costs(game, profile, robot)
                if _dominated(game.costs[robot][profile[robot]], best[others]):
                    break
            else:
                yield profile


def is_equilibrium(game: PathGame, profile: Profile) -> bool:
    """Whether nobody can do better alone."""
    return not any(
        _dominated(game.costs[robot][path], _best_costs(game, profile, robot))
        for robot, path in enumerate(profile)
    )


def social_optima(game: PathGame) -> list[Profile]:
    """A profile for each sum of costs that no profile's sum dominates, by increasing sum."""
    kept: dict[tuple[float, ...], Profile] = {}
    rows: list[list[list[float]]] = [costs.tolist() for costs in game.costs]
    for before, left in _beginnings(game):
        seen: set[tuple[float, ...]] = set()
        for last in _undominated(game.costs[-1], left):
            profile = (*before, last)
            own = tuple(rows[-1][last])
            if own in seen:
                continue
            seen.add(own)
            parts = (rows[i][p] for i, p in enumerate(profile))
            total = tuple(map(sum, zip(*parts, strict=True)))
            if any(_covers(other, total) for other in kept):
                continue
            kept = {other: p for other, p in kept.items() if not _covers(total, other)}
            kept[total] = profile
    return [kept[total] for total in sorted(kept)]


def profiles(game: PathGame) -> Iterator[Profile]:
    """All profiles, in lexicographic order."""
    for before, left in _beginnings(game):
        for last in np.flatnonzero(left).tolist():
            yield (*before, last)


def free_paths(game: PathGame, profile: Profile, robot: int) -> NDArray[np.bool_]:
    """Which of a robot's paths keep apart from all others' of a profile, (paths,)."""
    left = np.ones(len(game.costs[robot]), np.bool_)
    for other, path in enumerate(profile):
        if other != robot:
            left &= game.apart[other][robot][path]
    return left


def _beginnings(game: PathGame) -> Iterator[tuple[Profile, NDArray[np.bool_]]]:
    """Paths of all but the last robot that keep apart, and which of the last's are left then."""
    free = [np.ones(len(costs), np.bool_) for costs in game.costs]
    stack: list[tuple[Profile, list[NDArray[np.bool_]]]] = [((), free)]
    while stack:
        before, left = stack.pop()
        robot = len(before)
        if robot == game.size - 1:
            if left[0].any():
                yield before, left[0]
            continue
        for path in np.flatnonzero(left[0])[::-1].tolist():
            later = [
                mask & game.apart[robot][robot + 1 + i][path] for i, mask in enumerate(left[1:])
            ]
            if all(mask.any() for mask in later):
                stack.append(((*before, path), later))


def _undominated(costs: NDArray[np.float64], left: NDArray[np.bool_]) -> list[int]:
    """Those of the paths left that none of them dominates."""
    paths = np.flatnonzero(left)
    if costs.shape[1] == 1:
        own = costs[paths, 0]
        return paths[own == own.min()].tolist()
    return [p for p in paths.tolist() if not _dominated(costs[p], costs[paths])]


def _best_costs(game: PathGame, profile: Profile, robot: int) -> NDArray[np.float64]:
    """The costs of a robot's paths past the others of which none dominates another."""
    free = free_paths(game, profile, robot)
    return np.unique(game.costs[robot][_undominated(game.costs[robot], free)], axis=0)


def _dominated(cost: NDArray[np.float64], others: NDArray[np.float64]) -> bool:
    """Whether one of the others is nowhere above a cost, and below in a component."""
    return bool(((others <= cost).all(axis=1) & (others < cost).any(axis=1)).any())


def _covers(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return all(x <= y for x, y in zip(a, b, strict=True))


def _ratio(above: float | None, below: float | None) -> float | None:
    if above is None or below is None:
        return None
    return 1.0 if above == below else above / below if below > 0.0 else float("inf")
