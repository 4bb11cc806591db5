"""The paper's two experiments, and what is played in them.

The paper gives the numbers of robots, the methods and the tables; arena, radii, speeds, budgets
and who starts where are ours. So that a robot's number says only when it chooses, and not where it
has to go, every trial of the first experiment has obstacles, starts and goals of its own, and in
every trial of the second the numbers are dealt anew.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any, NamedTuple

import numpy as np

from conav import __version__
from conav.experiments.compare.source import source_hash
from conav.planning.load_scene import load_scene
from conav.planning.scenes.frozen_scenes import FROZEN, frozen_path
from conav.planning.types import PlanningProblem

PLAIN, ANYTIME, INASH, OURS = "prioritized", "any-time prioritized", "iNash", "ours"

PAPER_GRAPHS: Mapping[str, object] = {"mode": "paper", "shortcut_tries": 0, "guide": False}
"""Algorithm 2 as it stands, and nothing that makes paths better than their graphs."""

METHODS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    INASH: ("inash", {**PAPER_GRAPHS, "response": "first", "feasibility": False}),
    PLAIN: ("prioritized", PAPER_GRAPHS),
    ANYTIME: ("anytime-prioritized", PAPER_GRAPHS),
    OURS: ("inash", {}),
}
"""Method -> our solver, and the settings that make it the paper's."""

ON_PAPER_GRAPHS = (INASH, PLAIN, ANYTIME)
"""The same graphs in a trial: their samples depend on the seed and the robot's name alone."""


@dataclass(frozen=True)
class Experiment:
    """One of the paper's, with the trials, of 20, in which its robots reached their goals."""

    title: str
    scene: str
    robots: int
    dealt: bool  # numbers anew in each trial; else the scene is made anew
    samples: int  # of each robot
    reached: Mapping[str, tuple[int, ...]]


EXPERIMENTS: Mapping[str, Experiment] = {
    "discs": Experiment(
        "Eight robots among random obstacles",
        "random-discs:8",
        8,
        False,
        6000,
        {
            INASH: (20, 19, 18, 20, 16, 15, 18, 17),
            PLAIN: (20, 20, 18, 19, 20, 18, 18, 15),
            ANYTIME: (20, 20, 18, 20, 19, 20, 20, 20),
        },
    ),
    "intersection": Experiment(
        "Six robots at an intersection",
        "intersection:6",
        6,
        True,
        2600,
        {
            INASH: (11, 14, 12, 14, 16, 15),
            PLAIN: (19, 18, 19, 13, 12, 4),
            ANYTIME: (19, 18, 20, 19, 20, 15),
        },
    ),
}
TRIALS_OF_PAPER = 20


@dataclass(frozen=True)
class Effort:
    """How much is planned."""

    samples: int | None = None  # of each robot; None: as calibrated for each experiment
    batch: int = 20  # samples of each robot in an iteration; the paper's is 1

    def samples_of(self, experiment: str) -> int:
        """The samples of each robot in an experiment."""
        return EXPERIMENTS[experiment].samples if self.samples is None else self.samples


class Case(NamedTuple):
    """A plan: an experiment's first robots, by a method, in a trial, whose number is the seed."""

    experiment: str
    method: str
    robots: int
    trial: int


def all_cases(trials: int, seed: int) -> list[Case]:
    """Every case, trial by trial; smaller teams are planned for by iNash alone."""
    return [
        Case(name, method, robots, trial)
        for trial in range(seed, seed + trials)
        for name, experiment in EXPERIMENTS.items()
        for method in METHODS
        for robots in team_sizes(name)
        if method == INASH or robots == experiment.robots
    ]


def team_sizes(experiment: str) -> Sequence[int]:
    """The numbers of robots at which checks are counted, the whole team last."""
    return range(2, EXPERIMENTS[experiment].robots + 1, 2)


def problem_of(case: Case) -> PlanningProblem:
    """The problem of a case; a smaller team is the first robots of the whole one.

    Scenes are the frozen ones, and made where there are more trials than of those.
    """
    experiment = EXPERIMENTS[case.experiment]
    frozen = frozen_scene(case)
    problem = load_scene(frozen or experiment.scene, seed=case.trial)
    robots = problem.robots
    if experiment.dealt:
        rng = np.random.Generator(np.random.PCG64(case.trial))
        dealt = rng.permutation(len(robots)).tolist()
        robots = tuple(
            replace(robots[place], name=f"robot_{number}") for number, place in enumerate(dealt)
        )
    return replace(problem, robots=robots[: case.robots])


def frozen_scene(case: Case) -> str | None:
    """The name of the frozen scene a case is played in; None: it is made."""
    name = f"inash-{case.experiment}"
    if not EXPERIMENTS[case.experiment].dealt:
        name += f"-{case.trial}"
    return name if name in FROZEN else None


def settings_of(case: Case, effort: Effort) -> tuple[str, dict[str, Any]]:
    """The solver of a case, and its settings."""
    solver, settings = METHODS[case.method]
    made = {**settings, "samples": effort.samples_of(case.experiment)}
    if case.method in (INASH, ANYTIME):
        made["batch"] = effort.batch
    return solver, made


_PLAYS = (
    "conav.experiments.inash.play",
    "conav.planning.scenes.random_discs",
    "conav.planning.scenes.intersection",
    "conav.planning.inash",
    "conav.planning.prioritized",
    "conav.planning.anytime_prioritized",
)
"""What cases follow from; scenes and solvers are imported by name only."""


def case_key(case: Case, effort: Effort) -> str:
    """All that a case's plan follows from, as JSON."""
    solver, settings = settings_of(case, effort)
    code = source_hash(*_PLAYS)
    frozen = frozen_scene(case)
    scene = sha256(frozen_path(frozen).read_bytes()).hexdigest()[:16] if frozen else None
    known = {"conav": __version__, "code": code, "scene": scene}
    return json.dumps({**known, **case._asdict(), "solver": solver, **settings}, sort_keys=True)
