"""What every exploration strategy must do, checked on one of yours.

    from conav.testing import check_strategy
    check_strategy(MyStrategy())

Raises `AssertionError` with a sentence that says what was wrong.
"""

import pickle
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from conav.exploration.types import Action, ExplorationProblem, Strategy, TeamView
from conav.exploration.verify import verify_exploration
from conav.geometry.directions import STAY
from conav.maps.ascii_art import parse_ascii
from conav.messages.message import Message
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_exploration
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration
from conav.simulation.world_state import WorldState, new_world

TWO_ROOMS = """
#######################
#..........#..........#
#..........#..........#
#.....................#
#..........#..........#
#..........#....#.....#
#..........#....#.....#
#######################
"""

CONDITIONS: tuple[dict[str, Any], ...] = (
    {"radio": "perfect"},
    {"radio": 3.0},
    {"radio": "path-loss", "loss": 0.2, "delay_s": 2.0},
    {"faults": ("robot_0:dies:12", "robot_1:stalls:5:20", "robot_2:joins:4")},
)
"""What a strategy is checked in."""


def check_strategy(strategy: Strategy, *, steps: int = 60, motion: str = "8-connected") -> None:
    """Run the strategy on small teams and check what the simulator and its users rely on.

    - The same seed gives the same run; memory and settings pickle, and a pickled world goes on as
      the original does.
    - It changes nothing it is given but its memory, and asks for directions that exist.
    - The run it makes is accepted by the verifier: no knowledge from nowhere, no illegal move.

    All this with a perfect radio and a short one; with one that loses messages and is slow; and in
    a team whose first robot dies, whose second stalls, and whose third joins late. `steps` bounds
    each run. Raises `AssertionError` otherwise.
    """
    for options in CONDITIONS:
        problem = _problem(motion, options)
        _check_repeats(strategy, problem, steps)
        _check_resumes(strategy, problem, steps)
        _check_accepted(strategy, problem)


def _problem(motion: str, options: dict[str, Any]) -> ExplorationProblem:
    grid = parse_ascii(TWO_ROOMS.strip(), resolution=0.5, name="two rooms")
    problem, _ = exploration_problem(
        grid, robots=3, range_m=2.5, motion=motion, seed=5, max_time_s=100.0, **options
    )
    return problem


def _world(strategy: Strategy, problem: ExplorationProblem) -> WorldState:
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, _Watched(strategy), observable)


def _walk(state: WorldState, steps: int) -> list[tuple[tuple[int, ...], tuple[Any, ...]]]:
    """The cells and actions of the next steps."""
    engine = engine_for(state)
    trace: list[tuple[tuple[int, ...], tuple[Any, ...]]] = []
    for _ in range(steps):
        events = engine.sense_and_decide(state, [])
        engine.move(state, events.actions)
        trace.append((tuple(events.cells.tolist()), tuple(events.actions)))
    return trace


def _check_repeats(strategy: Strategy, problem: ExplorationProblem, steps: int) -> None:
    first = _walk(_world(strategy, problem), steps)
    second = _walk(_world(pickle.loads(pickle.dumps(strategy)), problem), steps)
    for number, (a, b) in enumerate(zip(first, second, strict=True)):
        assert a == b, f"the same seed gave another run from step {number} on: {a} and {b}"


def _check_resumes(strategy: Strategy, problem: ExplorationProblem, steps: int) -> None:
    state = _world(strategy, problem)
    _walk(state, steps // 2)
    copy = pickle.loads(pickle.dumps(state))
    assert _walk(state, steps // 2) == _walk(copy, steps // 2), (
        "a world that was pickled and loaded went on otherwise: something the strategy needs is "
        "neither in its memory nor in the random generator"
    )


def _check_accepted(strategy: Strategy, problem: ExplorationProblem) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        with ExplorationWriter(path) as writer:
            run_exploration(problem, strategy, name=type(strategy).__name__, writer=writer)
        report = verify_exploration(read_exploration(path))
    assert report.accepted, "\n".join(["the verifier rejects the run", *report.lines()])


class _Watched:
    """Passes everything on to a strategy and checks what comes back."""

    def __init__(self, strategy: Strategy) -> None:
        self.strategy = strategy
        self.may_be_quiet: bool = getattr(strategy, "may_be_quiet", False)

    def start(self, view: TeamView, rng: np.random.Generator) -> Any:
        return self.strategy.start(view, rng)

    def step(
        self, memory: Any, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[Any, Action, Sequence[Message]]:
        before = _content(view)
        result = self.strategy.step(memory, view, inbox, rng)
        assert _content(view) == before, "the strategy changed what it was given"
        _, action, messages = result
        assert STAY <= action.direction < 8, f"there is no direction {action.direction}"
        size = view.lattice.rows * view.lattice.cols
        assert -1 <= action.goal < size, f"there is no planning cell {action.goal}"
        for message in messages:
            assert message.sender == view.robot, f"robot {view.robot} forges a sender"
            assert message.size_bytes > 0, "a message has no size"
        return result


def _content(view: TeamView) -> tuple[bytes, ...]:
    belief = view.belief
    heard = (view.heard_cell, view.heard_step, view.in_touch)
    arrays = (belief.cells, belief.moves, belief.marks, *heard)
    return tuple(array.tobytes() for array in arrays)
