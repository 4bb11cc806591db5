"""How a team comes to an equilibrium: rounds while graphs grow, and answers when they do not."""

from collections.abc import Sequence

from conav.planning.budget import Budget
from conav.planning.draws import Draws
from conav.planning.feasibility import Feasibility
from conav.planning.team import Team


def settle(team: Team, order: Sequence[int], budget: Budget) -> bool:
    """Whether nobody in the order could find a better path any more; False when time ends before.

    Each answer makes a robot's cost better and leaves the others' as they are, so on fixed graphs
    the rounds come to an end.
    """
    improved = True
    while improved:
        improved = False
        for robot in order:
            if budget.out_of_time:
                return False
            found = team.better_path(robot, team.everybody())
            if found is not None:
                team.adopt(robot, found)
                improved = True
    return True


def play_round(team: Team, active: list[int], feasibility: Feasibility, budget: Budget) -> None:
    """Paths for all that are active if they can be found, and one better answer of each."""
    if any(team.paths[robot] is None for robot in active):
        feasibility.find(team, active, budget)
    for robot in active:
        if budget.out_of_time:
            return
        found = team.better_path(robot, team.everybody())
        if found is not None:
            team.adopt(robot, found)
        if team.straighten(robot, team.everybody()):
            straighter = team.better_path(robot, team.everybody())
            if straighter is not None:
                team.adopt(robot, straighter)


def choose_in_turn(team: Team, order: Sequence[int], whims: Draws | None = None) -> bool:
    """Whether everybody in the order found a path past those before it, all having been dropped.

    With `whims` each is the best of random costs, so that other ways around others are tried.
    """
    for robot in order:
        team.drop(robot)
    for robot in order:
        whim = None if whims is None else whims.seed_of_next()
        found = team.best_path(robot, team.everybody(), whim=whim)
        if found is None:
            return False
        team.adopt(robot, found)
    return True
