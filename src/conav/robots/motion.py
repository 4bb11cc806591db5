"""How a robot moves between planning cells."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Motion:
    """A motion model.

    With `diagonal` there are eight directions and a diagonal costs sqrt(2) cells of travel, else
    four. With `turn_costs_step` the robot has a heading, drives only forward, and turning to
    another heading takes a step in which it stays in place: the simple forward turn of Lindsay
    (2011), papers/000 section 2.1.
    """

    name: str
    diagonal: bool
    turn_costs_step: bool


MOTIONS = {
    "4-connected": Motion("4-connected", diagonal=False, turn_costs_step=False),
    "8-connected": Motion("8-connected", diagonal=True, turn_costs_step=False),
    "forward-turn": Motion("forward-turn", diagonal=False, turn_costs_step=True),
}
