"""How a run or a solver ended."""

from enum import StrEnum


class Status(StrEnum):
    """The one outcome every solver and every run has."""

    DONE = "done"
    """The task is complete."""
    INFEASIBLE = "infeasible"
    """Proved: no solution exists."""
    OUT_OF_BUDGET = "out_of_budget"
    """The budget (time, steps, samples) ran out first; what was found so far stands."""
    STUCK = "stuck"
    """Nothing more to do from here, the task is not complete, and nothing is proved."""
    INVALID_INPUT = "invalid_input"
    """The problem itself is wrong; see the error."""
