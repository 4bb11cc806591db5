"""One step of the world: sense, exchange, decide, move, all robots at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import new_scratch
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import STAY
from conav.messages.message import Message
from conav.simulation.conditions import recount, update_conditions
from conav.simulation.no_traffic import pass_through
from conav.simulation.radio_network import MAX_ROUNDS, exchange, links
from conav.simulation.sensing import Looker, look
from conav.simulation.slow_network import SPEECH, is_lost
from conav.simulation.told import Told
from conav.simulation.traffic import resolve
from conav.simulation.world_state import ABSENT, ACTIVE, DEAD, Scan, WorldState


class StepEvents(NamedTuple):
    """What happened in one step; `cells` and `headings` are those at its beginning."""

    step: int
    cells: NDArray[np.int32]  # (n,)
    headings: NDArray[np.int8]  # (n,)
    scans: list[Scan | None]  # per robot
    told: list[Told]
    said: list[Message]  # by minds
    actions: list[Action]  # per robot
    messages: int
    bytes: int
    condition: NDArray[np.uint8]  # (n,)


@dataclass(eq=False)
class Engine:
    """Working space and fixed tables for worlds of one problem; holds no state of a run."""

    lookers: list[Looker]
    scratch: NDArray[np.int32]
    gap: NDArray[np.float64]
    rate: NDArray[np.float64]
    turning: NDArray[np.uint8]
    wish: NDArray[np.int8]
    ways: NDArray[np.uint8]
    outcome: NDArray[np.uint8]
    heard_of: WorldState | None = None
    heard: tuple[list[NDArray[Any]], ...] = ()

    def sense_and_decide(self, state: WorldState, decision_ns: list[int]) -> StepEvents:
        """Everything of a step up to the actions; nobody has moved yet."""
        died = False
        if state.problem.breakable:
            dead = np.count_nonzero(state.condition == DEAD)
            update_conditions(state, self.gap)
            died = np.count_nonzero(state.condition == DEAD) > dead
        fresh = self._sense(state)
        outcome = exchange(state, fresh, self.scratch)
        # What only the dead knew does not count, unless it was under way to somebody.
        if died or (outcome.told and state.problem.lossy and (state.condition == DEAD).any()):
            recount(state)
        state.messages += outcome.messages
        state.bytes += outcome.bytes
        actions, said = self._decide(state, decision_ns)
        messages = outcome.messages + len(said)
        size = outcome.bytes
        for message in said:
            size += message.size_bytes
        if said:
            state.messages += len(said)
            state.bytes += size - outcome.bytes
        return StepEvents(
            state.step,
            state.cells.copy(),
            state.headings.copy(),
            fresh,
            outcome.told,
            said,
            actions,
            messages,
            size,
            state.condition.copy(),
        )

    def move(self, state: WorldState, actions: list[Action]) -> int:
        """The number of robots that moved; time goes on by a step."""
        # Robots leave, and are pushed, only by ways they know.
        for robot, action in enumerate(actions):
            self.wish[robot] = action[0]
            self.ways[robot] = state.beliefs[robot].moves.item(state.cells.item(robot))
            state.quiet[robot] = action[3]
        if state.problem.breakable:
            moved = self._move_some(state)
        else:
            moved = self._move_all(state)
        state.step += 1
        return moved

    def _move_all(self, state: WorldState) -> int:
        cols = state.problem.plan.lattice.cols
        where = (state.cells, self.wish, self.ways, cols, state.headings, self.turning)
        travel = (self.rate, state.credit, state.travelled, self.outcome)
        if state.problem.traffic == "none":
            moved = pass_through(*where, *travel)
        else:
            moved = resolve(state.step, *where, self.gap, *travel)
        np.equal(self.outcome, 1, out=state.must_look)
        return moved

    def _move_some(self, state: WorldState) -> int:
        """Moves those that can, as if the others were not there."""
        able = state.condition == ACTIVE
        cols = state.problem.plan.lattice.cols
        cells, headings = state.cells[able], state.headings[able]
        credit, travelled, outcome = state.credit[able], state.travelled[able], self.outcome[able]
        where = (cells, self.wish[able], self.ways[able], cols, headings, self.turning[able])
        travel = (self.rate[able], credit, travelled, outcome)
        if state.problem.traffic == "none":
            moved = pass_through(*where, *travel)
        else:
            moved = resolve(state.step, *where, self.gap[able], *travel)
        state.cells[able], state.headings[able] = cells, headings
        state.credit[able], state.travelled[able] = credit, travelled
        # One that is not there yet looks when it comes; others that stand have looked.
        state.must_look[state.condition != ABSENT] = False
        state.must_look[able] = outcome == 1
        return moved

    def _sense(self, state: WorldState) -> list[Scan | None]:
        plan = state.problem.plan
        lattice = plan.lattice
        walls = plan.walls
        fresh: list[Scan | None] = []
        for robot in range(len(self.lookers)):
            if not state.must_look[robot] or state.condition.item(robot) >= DEAD:
                fresh.append(None)
                continue
            looker = self.lookers[robot]
            cell = int(state.cells[robot])
            row, col = divmod(cell, lattice.cols)
            count = look(
                walls,
                state.beliefs[robot].cells,
                int(lattice.fine_row[row]),
                int(lattice.fine_col[col]),
                looker.occlusion,
                looker.limits,
                looker.lows,
                looker.highs,
                looker.out,
                looker.fresh,
                state.observable,
                state.sensed_by,
                robot,
                state.sensed,
                state.discovered,
                state.covered,
            )
            fresh.append(Scan(cell, looker.fresh[:count].copy()))
        return fresh

    def _decide(
        self, state: WorldState, decision_ns: list[int]
    ) -> tuple[list[Action], list[Message]]:
        n = len(self.lookers)
        actions = [_STAY] * n
        said: list[Message] = []
        inboxes: list[list[Message]] = [[] for _ in range(n)]
        asked: Sequence[int] = range(n)
        if state.problem.breakable:
            asked = np.flatnonzero(state.condition < DEAD).tolist()
        self._deliver(state, asked, inboxes)
        slow = state.problem.delay_steps > 0
        heard: NDArray[np.bool_] | None = None
        for number in range(MAX_ROUNDS):
            sent: list[Message] = []
            for robot in asked:
                view = self._view(state, robot)
                start = perf_counter_ns()
                if not state.started[robot]:
                    state.memories[robot] = state.strategy.start(view, state.generators[robot])
                    state.started[robot] = True
                memory, actions[robot], out = state.strategy.step(
                    state.memories[robot], view, inboxes[robot], state.generators[robot]
                )
                state.memories[robot] = memory
                decision_ns.append(perf_counter_ns() - start)
                if not state.quiet[robot]:
                    sent.extend(out)
            if not sent:
                break
            said.extend(sent)
            if heard is None:
                heard = links(state)
            inboxes = [[] for _ in range(n)]
            arriving = _arriving(state, sent, heard, number)
            if slow:
                due = state.step + state.problem.delay_steps
                state.in_flight += [(due, message) for message in arriving]
                break
            for message in arriving:
                inboxes[message.receiver].append(message)
            asked = [robot for robot in range(n) if inboxes[robot]]
        else:
            # Too many rounds for one step: the rest is read in the next.
            due = state.step + 1
            state.in_flight += [(due, message) for inbox in inboxes for message in inbox]
        for robot, action in enumerate(actions):
            state.finished[robot] = action.finished
            if action.quiet and not getattr(state.strategy, "may_be_quiet", False):
                raise ValueError(
                    f"robot {robot} switches its radio off; its strategy lacks may_be_quiet = True"
                )
        return actions, said

    def _deliver(self, state: WorldState, on: Sequence[int], inboxes: list[list[Message]]) -> None:
        """Put what is due into the inboxes of those who are there to read it."""
        if not state.in_flight:
            return
        slow = state.problem.delay_steps > 0
        for due, message in state.in_flight:
            robot = message.receiver
            # Without delay it has arrived already, and was only one too many to be read.
            if due <= state.step and robot in on and not (slow and state.quiet[robot]):
                inboxes[robot].append(message)
        state.in_flight = [item for item in state.in_flight if item[0] > state.step]

    def _heard_by(self, state: WorldState) -> tuple[list[NDArray[Any]], ...]:
        """Locked views of the rows of what each robot heard, made once per state."""
        if self.heard_of is not state:
            self.heard_of = state
            self.heard = ([], [], [])
            arrays = (state.heard_cell, state.heard_step, state.in_touch)
            for rows, array in zip(self.heard, arrays, strict=True):
                for robot in range(len(array)):
                    row = array[robot]
                    row.flags.writeable = False  # of the view; the state's array stays writable
                    rows.append(row)
        return self.heard

    def _view(self, state: WorldState, robot: int) -> TeamView:
        problem = state.problem
        heard_cell, heard_step, in_touch = self._heard_by(state)
        return TeamView(
            state.step,
            state.step * problem.step_s,
            robot,
            problem.robots[robot],
            int(state.cells[robot]),
            int(state.headings[robot]),
            state.beliefs[robot],
            problem.plan.lattice,
            heard_cell[robot],
            heard_step[robot],
            in_touch[robot],
            problem.delay_steps,
        )


_STAY = Action(STAY)


def _arriving(
    state: WorldState, sent: list[Message], heard: NDArray[np.bool_], number: int
) -> list[Message]:
    """The messages that get through, of those minds sent in this round."""
    n, problem = state.n_robots, state.problem
    arriving: list[Message] = []
    count: dict[tuple[int, int], int] = {}
    for message in sent:
        sender, receiver = message.sender, message.receiver
        if not 0 <= receiver < n:
            raise ValueError(f"robot {sender} sends to robot {receiver}; there are {n}")
        # What is sent to somebody out of reach is sent all the same, and lost.
        if not heard[sender, receiver]:
            continue
        if problem.loss > 0.0:
            kind = SPEECH + count.get((sender, receiver), 0)
            count[sender, receiver] = kind - SPEECH + 1
            way = (sender, receiver, kind)
            if is_lost(problem.seed, problem.loss, state.step, number, *way):
                continue
        arriving.append(message)
    return arriving


def engine_for(state: WorldState) -> Engine:
    """The engine for worlds of this state's problem."""
    problem = state.problem
    plan = problem.plan
    lattice = plan.lattice
    lookers = [
        Looker(
            # Farther than the map is large makes no difference but to memory.
            min(robot.sensor.range_m / lattice.resolution, sum(plan.walls.shape)),
            plan.walls.size,
            robot.sensor.occlusion,
        )
        for robot in problem.robots
    ]
    n = len(problem.robots)
    return Engine(
        lookers=lookers,
        scratch=new_scratch(plan),
        gap=np.array([robot.radius_m / lattice.cell_m for robot in problem.robots]),
        rate=problem.rates,
        turning=np.array(
            [robot.motion.turn_costs_step for robot in problem.robots], dtype=np.uint8
        ),
        wish=np.full(n, STAY, dtype=np.int8),
        ways=np.zeros(n, dtype=np.uint8),
        outcome=np.zeros(n, dtype=np.uint8),
    )
