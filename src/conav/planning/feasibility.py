"""Paths for all at once, so that nobody is locked out.

Robots that answer each other keep whom they have shut out waiting for others to move, and in the
paper's own tables a third of the robots at the crossing never get a path. So as long as a robot has
a path of its own but none past the others, all are planned anew on the same graphs:

1. In random orders, each heeding those before it. One that finds no path goes to the front of the
   next order. From the second order on robots choose by random costs, so that those with the
   choice also wait, or go around.
2. By repair, as MAPF-LNS2 does on grids [Li2022]: everybody takes a path that hits the fewest
   others, then again and again a robot that hits somebody, and those it hits, take their paths
   anew in a random order and by random costs; what hits more pairs than before is taken back.

How many repairs one call makes follows Luby's sequence [Luby1993], so that neither a hard scene
waits for more samples nor an easy one for more tries. Where nothing is found all is as before.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.planning.budget import Budget
from conav.planning.draws import Draws
from conav.planning.team import Team

MAX_HITS = 1 << 20
"""Tolerated of one path in repair: all of them."""

_MOST_TOGETHER = 8  # robots that take their paths anew in one repair


@dataclass(eq=False)
class Feasibility:
    """The stage, with its random draws and how often it was called."""

    draws: Draws
    orders: int  # in a call
    repairs: int  # in a call, times Luby's number
    samples: int  # more for each robot in trouble, in a call
    calls: int = 0

    def find(self, team: Team, robots: list[int], budget: Budget) -> bool:
        """Whether all these robots have paths now; otherwise everything is as it was."""
        self.calls += 1
        before = [(team.paths[robot], team.costs[robot].copy()) for robot in range(team.size)]
        locked_out = [robot for robot in robots if team.paths[robot] is None]
        team.count("feasibility_calls")
        if self._in_orders(team, robots, locked_out, budget):
            return True
        if self._by_repair(team, robots, budget):
            return True
        for robot, (path, costs) in enumerate(before):
            if path is None:
                team.drop(robot)
            else:
                team.put(robot, path, costs)
        return False

    def _in_orders(self, team: Team, robots: list[int], first: list[int], budget: Budget) -> bool:
        """Prioritized planning, those in `first` before the others of each order."""
        front = list(first)
        for attempt in range(self.orders):
            if budget.out_of_time:
                return False
            others = self.draws.shuffled([robot for robot in robots if robot not in front])
            for robot in robots:
                team.drop(robot)
            stuck = None
            for robot in [*front, *others]:
                whim = self.draws.seed_of_next() if attempt > 0 else None
                response = team.best_path(robot, team.everybody(), whim=whim)
                if response is None:
                    stuck = robot
                    break
                team.adopt(robot, response)
            if stuck is None:
                return True
            if stuck in front:
                front.remove(stuck)
            front.insert(0, stuck)
        return False

    def _by_repair(self, team: Team, robots: list[int], budget: Budget) -> bool:
        """Fewer and fewer pairs that hit each other."""
        for robot in robots:
            if team.paths[robot] is None:
                self._least_hits(team, robot)
        hit = np.zeros((team.size, team.size), np.bool_)
        renew_pairs(team, robots, hit)
        # Those in trouble look around the way they would like to go.
        for robot in np.flatnonzero(hit.any(axis=1)).tolist():
            team.grow(robot, self.samples)
            team.count("extra_samples", self.samples)
        for _ in range(self.repairs * luby(self.calls)):
            troubled = np.flatnonzero(hit.any(axis=1))
            if not len(troubled):
                return True
            if budget.out_of_time:
                return False
            team.count("repairs")
            robot = int(troubled[self.draws.below(len(troubled))])
            together = [robot, *np.flatnonzero(hit[robot]).tolist()]
            while len(together) < min(_MOST_TOGETHER, len(robots)):
                # Those who are in the way of these, and then anybody.
                near = np.flatnonzero(hit[together].any(axis=0))
                choice = [other for other in near.tolist() if other not in together]
                choice = choice or [other for other in robots if other not in together]
                together.append(choice[self.draws.below(len(choice))])
            together = self.draws.shuffled(together)[:_MOST_TOGETHER]
            before = [(team.paths[each], team.costs[each].copy()) for each in together]
            for each in together:
                team.drop(each)
            for each in together:
                self._least_hits(team, each)
            now = hit.copy()
            renew_pairs(team, together, now)
            if now.sum() <= hit.sum():
                hit = now
                continue
            for each, (path, costs) in zip(together, before, strict=True):
                assert path is not None
                team.put(each, path, costs)
        return not hit.any()

    def _least_hits(self, team: Team, robot: int) -> None:
        whim = self.draws.seed_of_next()
        response = team.best_path(robot, team.everybody(), MAX_HITS, whim)
        assert response is not None, "an active robot has a path when hits are tolerated"
        team.adopt(robot, response)


def renew_pairs(team: Team, robots: list[int], hit: NDArray[np.bool_]) -> None:
    """Writes which robots come too close to these into the table, (robots, robots)."""
    for robot in robots:
        hit[robot] = hit[:, robot] = team.traffic.conflicts(robot)


def luby(number: int) -> int:
    """The number-th of Luby's sequence 1 1 2 1 1 2 4 1 ..., from 1.

    >>> [luby(i) for i in range(1, 16)]
    [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]
    """
    while True:
        power = 1
        while power * 2 - 1 < number:
            power *= 2
        if power * 2 - 1 == number:
            return power
        number -= power - 1
