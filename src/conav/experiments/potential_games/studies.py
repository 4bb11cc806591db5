"""The studies of the reproduction, in the page's order."""

from collections.abc import Callable

from conav.experiments.potential_games.cost import decision_cost
from conav.experiments.potential_games.figures import coordination, figure_3, figure_6
from conav.experiments.potential_games.lab import Lab
from conav.experiments.potential_games.rates import exploration_rate, overlap, responses
from conav.experiments.potential_games.report import Section
from conav.experiments.potential_games.simulated import information, marginal, meetings

STUDIES: dict[str, Callable[[Lab], Section]] = {
    "figure-3": figure_3,
    "figure-6": figure_6,
    "coordination": coordination,
    "epsilon": exploration_rate,
    "overlap": overlap,
    "responses": responses,
    "information": information,
    "traffic": meetings,
    "cost": decision_cost,
    "marginal": marginal,
}
"""Study name -> function."""
