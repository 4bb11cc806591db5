"""Discs for robots that another format moves from cell to cell."""

DISC_CELLS = 0.35
"""Radius of a robot, in sides of a cell.

Just under sqrt(2) / 4. When one robot enters a cell in the step in which another leaves it at a
right angle, their centres come as near as 1 / sqrt(2) of a side; in all other legal steps they stay
farther apart. So every plan from cell to cell without swaps is one of the discs too, and a scene
that is solvable there is solvable here.
"""

GOAL_CELLS = 0.1
"""Radius of a goal, in sides of a cell: at least 0.8 - 0.7 sides stay between robots at goals."""

HORIZON_FACTOR = 4.0
"""The horizon is that many times as long as the longest way, and `SHORTEST_S` at least."""

SHORTEST_S = 60.0
