"""Clearing a known floor by delegation [Pellier2005], section 3.4.

Every pursuer clears a part on its own pursuit graph. One that cannot asks for help, and is helped
by whoever is least committed: idle, guard, explorer when it has ended, stuck, and at last a new
pursuer.
"""

from dataclasses import dataclass

import numpy as np

from conav.pursuit.catalogue import OnProgress
from conav.pursuit.delegation_team import Team
from conav.pursuit.navigation_graph import known_navigation_graph
from conav.pursuit.rounds import Rounds
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.shadow_parts import Cut, ShadowParts
from conav.pursuit.splitting import Order, Stopped
from conav.pursuit.standing_guards import StandingGuards
from conav.pursuit.team import known_floor, may_grow, out_of_budget, team_of
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.status import Status


@dataclass(frozen=True)
class Delegation:
    """Pursuers who ask each other for help."""

    cut: Cut = "geometry"
    """Where a stuck pursuer wants help: where the largest shadow left is smallest, at the place
    that sees most others, or where it is."""
    order: Order = "sequence"
    """Parts one after the other, or all at once, each with a pursuer of its own."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for."""
    budget: int = 500
    """States expanded for each part; who would need more is stuck."""
    halvings: int = 0
    """How often a drive is halved at most where halves tell more of what was seen in passing."""
    patience_s: float | None = None
    """Seconds until help must have come; without it, as long as the longest shortest way takes."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.weight < float("inf"):
            raise ValueError(f"weight is {self.weight:g}; give 0 or more")
        if self.budget < 1:
            raise ValueError(f"budget is {self.budget}; give 1 or more")
        if self.halvings < 0:
            raise ValueError(f"halvings is {self.halvings}; give 0 or more")
        if self.patience_s is not None and not self.patience_s >= 0.0:
            raise ValueError(f"patience_s is {self.patience_s:g}; give 0 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """What the team does until the floor is clear, or until nobody more may be sent.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range, a
        start off the floor.
        """
        team = self._team(problem, on_progress)
        reason = ""
        try:
            while team.dirty:
                team.talk()
                if team.dirty == 0 or self._give_parts(problem, team):
                    continue
                if team.movers():
                    team.drive()
                elif not _enlarge(problem, team):
                    reason = "nobody can help, and no more pursuers may be sent"
                    break
            team.talk()
        except Stopped:
            reason = "it was stopped"
        counters = _counters(team)
        if reason:
            return out_of_budget(team_of(problem, len(team.members)), reason, counters)
        return PursuitResult(
            Status.DONE,
            "",
            team.rounds.schedule(),
            tuple(team.rounds.pursuers),
            lower_bound=1,
            minimal_proved=len(team.rounds.pursuers) == 1,
            counters=counters,
            beliefs=team.beliefs,
            history=tuple(team.history),
        )

    def _team(self, problem: PursuitProblem, on_progress: OnProgress | None) -> Team:
        mesh = known_floor(problem, reach=True, faults=True)
        starts = [(float(x), float(y)) for x, y in (one.start for one in problem.pursuers)]
        graph = known_navigation_graph(problem.floor, mesh, starts)
        shadows = ShadowMoves(mesh, self.halvings)
        guards, labels = StandingGuards(shadows, graph), ShadowLabels(shadows)
        rounds = Rounds.of(problem.pursuers)

        def go_on(count: int) -> bool:
            if on_progress is not None and not on_progress(len(rounds.pursuers), count):
                raise Stopped
            return True

        parts = ShadowParts(guards, labels, self.cut, self.weight, self.budget, go_on)
        longest = float(np.max(graph.distances, initial=0.0, where=np.isfinite(graph.distances)))
        slowest = min(one.speed_mps for one in problem.pursuers)
        patience = longest / slowest if self.patience_s is None else self.patience_s
        deaths = {fault.robot: fault.at_s for fault in problem.faults}
        team = Team(
            graph=graph,
            guards=guards,
            labels=labels,
            parts=parts,
            rounds=rounds,
            deaths=deaths,
            patience_s=patience,
        )
        for _ in problem.pursuers:
            team.add_member()
        return team

    def _give_parts(self, problem: PursuitProblem, team: Team) -> bool:
        """Free members take contaminated shadows; whether one did."""
        if (self.order == "sequence" and team.tasks) or team.guard_goes():
            return False
        open_bits = team.dirty & ~team.taken()
        shadows = [i for i in range(open_bits.bit_length()) if open_bits >> i & 1]
        for _, i, shadow in team.offered(shadows):
            if team.take(i, shadow):
                return True
        alone = self.order == "parallel" and len(shadows) > 0 and not team.free()
        return alone and _enlarge(problem, team)


def _enlarge(problem: PursuitProblem, team: Team) -> bool:
    """One pursuer more, where that is allowed."""
    count = len(team.rounds.pursuers)
    if not may_grow(problem, count):
        return False
    team.rounds.enter(team_of(problem, count + 1)[count])
    team.add_member()
    team.history.append(
        {"time_s": team.rounds.now, "what": "joined", "pursuer": team.rounds.pursuers[-1].name}
    )
    return True


def _counters(team: Team) -> dict[str, int]:
    rounds = [count for (_, number), count in team.in_round.items() if number > 0]
    return {
        "moves": len(team.rounds.active),
        "states": team.parts.expanded,
        "largest": team.parts.largest,
        "places": len(team.graph.points),
        "messages": team.said["messages"],
        "bytes": team.said["bytes"],
        "deliberations": team.said["stuck"],
        "talks": len(rounds),
        "longest_talk": max(rounds, default=0),
        "guards": team.said["holds"],
        "parts": team.said["cleared"],
        "served_both": team.said["serves both"],
        "lost": team.said["lost"],
    }
