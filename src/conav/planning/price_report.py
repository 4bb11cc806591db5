"""What selfish robots cost the team in a scene: exactly where it is small, by samples where not.

A grid scene whose robots have few enough paths within the slack is gone through
(`conav.planning.grid_prices`). On larger ones equilibria are reached from paths chosen in random
orders, and the optimum is looked for by conflict-based search; in a scene of the plane they are
those of `inash-restarts` on sampled graphs. Sampled equilibria say what chance leads to: a better
or a worse one may exist, so their ratio to the optimum is a lower bound on the price of anarchy.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path

from conav.errors import InputError
from conav.maps.image import file_bytes
from conav.planning.grid_game import grid_equilibria
from conav.planning.grid_motion import (
    UNREACHED,
    Cells,
    GridProblem,
    distances,
    grid_of_text,
    neighbours,
    read_grid_scenario,
)
from conav.planning.grid_optimum import grid_optimum
from conav.planning.grid_prices import INSTANCES, GridGame, grid_game
from conav.planning.load_scene import load_scene
from conav.planning.mechanisms import outcomes
from conav.planning.plan import plan
from conav.planning.prices import Profile, prices
from conav.planning.types import PlanningProblem
from conav.status import Status

DRAWN = {problem.name.replace(" ", "-"): problem for problem, _ in INSTANCES}
"""Instances that come with conav, by name."""

MOST_PROFILES = 100_000
"""Ways to combine the paths of all robots but the last that are gone through."""

MOST_WITH_RULES = 100_000
"""Profiles that are gone through once more under each rule."""

Path2D = tuple[tuple[int, int], ...]
"""Cells of a path, row and column from 0, the first row on top."""


@dataclass(frozen=True)
class RuleRow:
    """A rule against anarchy, by all its equilibria; sums without payments."""

    rule: str
    equilibria: int
    best: float
    worst: float
    least_collected: float
    most_collected: float
    may_lose: tuple[str, ...]
    counterexample: tuple[Path2D, ...] | None  # an equilibrium dearer than the optimum, if any


@dataclass(frozen=True)
class PriceReport:
    """Prices of a scene. Sums of costs are steps on grids, else metres or seconds."""

    name: str
    robots: tuple[str, ...]
    unit: str  # "steps", "m" or "s"
    exact: bool  # all equilibria within the slack were gone through
    horizon: float  # [steps or s]
    slack: int | None  # [steps] of paths above each robot's solo cost; None: sampled
    paths: tuple[int, ...]  # of each robot within the slack; none: not counted
    solo: float | None  # sum of the solo costs
    starts: int | None  # sampled: from how many starts
    equilibria: int  # all there are, or how many were met, a proved optimum included
    sums: tuple[float, ...]  # their different sums of costs, rising; if exact only the two ends
    optimum: float | None  # the least sum of costs; None: not proved
    lower_bound: float | None  # on every plan's sum of costs, or on plans within the slack
    certain: bool  # the optimum is that of all plans, longer paths included
    worst_paths: tuple[Path2D, ...]  # of a worst equilibrium; none where not on a grid
    rules: tuple[RuleRow, ...]

    @property
    def price_of_anarchy(self) -> float | None:
        """Worst equilibrium found over the optimum; None where that is not known."""
        return _ratio(self.sums[-1], self.optimum) if self.sums else None

    @property
    def price_of_stability(self) -> float | None:
        """Best equilibrium found over the optimum."""
        return _ratio(self.sums[0], self.optimum) if self.sums else None

    @property
    def spread(self) -> float | None:
        """Worst equilibrium found over the best one found."""
        return _ratio(self.sums[-1], self.sums[0]) if self.sums else None


def price_scene(
    source: str, *, robots: int | None = None, horizon: int | None = None, seed: int = 0
) -> GridProblem | PlanningProblem:
    """The scene behind a name: an instance of `DRAWN`, a drawing, or what `load_scene` takes.

    A `.txt` file is a drawing as `grid_of_text` reads it, a `.scen` file a grid scenario. Raises
    `InputError` for what is none.
    """
    name, _, count = source.rpartition(":")
    if source in DRAWN:
        found: GridProblem | PlanningProblem = DRAWN[source]
    elif source.lower().endswith(".txt"):
        found = grid_of_text(_text(Path(source)), horizon or 64, Path(source).stem)
    elif source.lower().endswith(".scen") or name.lower().endswith(".scen"):
        path, number = (name, count) if name.lower().endswith(".scen") else (source, "8")
        if not number.isdigit():
            raise InputError(source, f"{number!r} is no number of robots", f"write {path}:4")
        found = read_grid_scenario(path, robots or int(number), horizon)
    else:
        found = load_scene(source, robots=robots, seed=seed)
    if isinstance(found, PlanningProblem):
        if horizon is not None:
            raise InputError("--horizon", "is for grids", "say horizon_s in the scene")
        return found
    if robots is not None and robots != found.size:
        if not 1 <= robots <= found.size:
            raise InputError(source, f"has {found.size} robots", f"ask for 1 to {found.size}")
        found = GridProblem(
            found.free, found.starts[:robots], found.goals[:robots], found.horizon, found.name
        )
    if horizon is not None and horizon != found.horizon:
        found = GridProblem(found.free, found.starts, found.goals, horizon, found.name)
    return found


def price_report(
    problem: GridProblem | PlanningProblem,
    *,
    slack: int = 2,
    starts: int = 20,
    samples: int = 500,
    seed: int = 0,
    rules: bool = False,
    sampled: bool = False,
) -> PriceReport:
    """The prices of a scene: exact for a small grid, unless `sampled` asks for samples.

    Raises `InputError` where somebody has no path, and for rules where not all is gone through.
    """
    if slack < 0 or starts < 1 or samples < 1:
        raise InputError("prices", "slack, starts and samples must be positive", "give others")
    if isinstance(problem, PlanningProblem):
        if rules:
            raise _no_rules("a scene of the plane has too many paths to go through")
        return _on_graphs(problem, starts, samples, seed)
    counts = tuple(count_paths(problem, robot, slack) for robot in range(problem.size))
    for robot, count in enumerate(counts):
        if count == 0:
            raise InputError(
                problem.name, f"robot {_letter(robot)} has no path within {problem.horizon} steps",
                "raise the horizon, or mend the walls",
            )  # fmt: skip
    small = prod(counts[:-1]) <= MOST_PROFILES and max(counts) <= MOST_PROFILES
    if small and not sampled:
        if rules and prod(counts) > MOST_WITH_RULES:
            raise _no_rules(f"they have {prod(counts):,} profiles within a slack of {slack}")
        return _gone_through(problem, slack, rules)
    if rules:
        raise _no_rules("equilibria are sampled")
    return _on_grid(problem, starts, seed)


def count_paths(problem: GridProblem, robot: int, slack: int) -> int:
    """How many paths `paths_within` gives, without making them; at most a little above the limit.

    Counting stops where there are more than `MOST_PROFILES`.
    """
    start, goal = problem.starts[robot], problem.goals[robot]
    far = distances(problem.free, goal)
    if far[start] >= UNREACHED:
        return 0
    near = neighbours(problem.free).tolist()
    most = min(far[start] + slack, problem.horizon)
    ways = {start: 1}
    found = 1 if start == goal else 0
    for step in range(1, most + 1):
        after: dict[int, int] = {}
        for cell, count in ways.items():
            for head in near[cell]:
                if head == problem.free.size or step + far[head] > most:
                    continue
                after[head] = after.get(head, 0) + count
                if head == goal and cell != goal:
                    found += count
        ways = after
        if found > MOST_PROFILES:
            break
    return found


def _gone_through(problem: GridProblem, slack: int, rules: bool) -> PriceReport:
    built = grid_game(problem, slack)
    found = prices(built.game)
    if found is None:
        raise InputError(
            problem.name, f"no paths of up to {slack} steps above the shortest keep all apart",
            "raise --slack",
        )  # fmt: skip
    assert found.optimum is not None
    assert found.best_equilibrium is not None
    assert found.worst_equilibrium is not None
    assert found.worst_profile is not None
    solo = sum(built.solo)
    return PriceReport(
        name=problem.name,
        robots=_letters(problem.size),
        unit="steps",
        exact=True,
        horizon=problem.horizon,
        slack=slack,
        paths=tuple(len(own) for own in built.paths),
        solo=solo,
        starts=None,
        equilibria=found.equilibria,
        sums=tuple(sorted({found.best_equilibrium, found.worst_equilibrium})),
        optimum=found.optimum,
        lower_bound=found.optimum,
        certain=found.optimum <= solo + slack + 1,
        worst_paths=_shown(built, found.worst_profile),
        rules=_rules(built, found.optimum) if rules else (),
    )


def _rules(built: GridGame, optimum: float) -> tuple[RuleRow, ...]:
    letters = _letters(built.problem.size)
    return tuple(
        RuleRow(
            row.rule,
            row.equilibria,
            row.best,
            row.worst,
            row.least_collected,
            row.most_collected,
            tuple(letters[robot] for robot in row.may_lose),
            _shown(built, row.worst_profile) if row.worst > optimum else None,
        )
        for row in outcomes(built.game)
    )


def _on_grid(problem: GridProblem, starts: int, seed: int) -> PriceReport:
    best = grid_optimum(problem, seed=seed)
    if best.status == Status.INFEASIBLE:
        raise InputError(problem.name, best.reason, "raise the horizon, or ask for fewer robots")
    found = grid_equilibria(problem, starts, seed)
    proved = best.status == Status.DONE
    if proved:  # every social optimum is an equilibrium
        found = [best, *found]
    solo = sum(distances(problem.free, g)[s] for s, g in zip(problem.starts, problem.goals,
                                                            strict=True))  # fmt: skip
    return PriceReport(
        name=problem.name,
        robots=_letters(problem.size),
        unit="steps",
        exact=False,
        horizon=problem.horizon,
        slack=None,
        paths=(),
        solo=solo,
        starts=starts,
        equilibria=len(found),
        sums=tuple(sorted({float(sum(each.costs)) for each in found})),
        optimum=float(sum(best.costs)) if proved else None,
        lower_bound=float(best.lower_bound),
        certain=proved,
        worst_paths=_cells(problem, found[-1].paths) if found else (),
        rules=(),
    )


def _on_graphs(problem: PlanningProblem, starts: int, samples: int, seed: int) -> PriceReport:
    found = plan(problem, "inash-restarts", seed, samples=samples, starts=starts)
    if found.status == Status.INFEASIBLE:
        raise InputError(problem.name, found.reason, "change the scene")
    if found.status != Status.DONE:
        raise InputError(problem.name, found.reason, "raise --samples")
    # The last of "last answers" is an equilibrium too; equal sums in a row have one line.
    last = [entry for entry in found.history if entry["stage"] == "last answers"][-1:]
    settled = [*last, *(entry for entry in found.history if entry["stage"] == "start")]
    sums: set[float] = {round(sum(costs[0] for costs in entry["costs"]), 9) for entry in settled}
    sums.add(round(float(found.costs[:, 0].sum()), 9))
    return PriceReport(
        name=problem.name,
        robots=tuple(robot.name for robot in problem.robots),
        unit="m" if problem.costs[0] == "length" else "s",
        exact=False,
        horizon=problem.horizon_s,
        slack=None,
        paths=(),
        solo=float(found.solo[:, 0].sum()) if found.solo is not None else None,
        starts=starts,
        equilibria=found.counters.get("equilibria", 0) + 1,
        sums=tuple(sorted(sums)),
        optimum=None,
        lower_bound=found.lower_bound,
        certain=False,
        worst_paths=(),
        rules=(),
    )


def _shown(built: GridGame, profile: Profile) -> tuple[Path2D, ...]:
    return _cells(built.problem, [own[k] for own, k in zip(built.paths, profile, strict=True)])


def _cells(problem: GridProblem, paths: Sequence[Cells]) -> tuple[Path2D, ...]:
    columns = problem.free.shape[1]
    return tuple(tuple(divmod(cell, columns) for cell in path.tolist()) for path in paths)


def _letters(count: int) -> tuple[str, ...]:
    return tuple(map(_letter, range(count)))


def _letter(robot: int) -> str:
    return chr(ord("a") + robot) if robot < 26 else f"robot {robot}"


def _text(path: Path) -> str:
    if not path.exists():
        raise InputError(path, "does not exist", "give a drawing of robots on a grid")
    try:
        return file_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(path, "is not UTF-8 text", "save it as UTF-8") from None


def _no_rules(why: str) -> InputError:
    return InputError("--mechanisms", why, "give a smaller scene or --slack")


def _ratio(above: float, below: float | None) -> float | None:
    if below is None:
        return None
    return 1.0 if above == below else above / below if below > 0.0 else float("inf")
