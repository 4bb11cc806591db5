"""conav plan and conav scenes: what they print, write and refuse, and Ctrl-C."""

import json
import signal
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import conav as package
from conav.cli.plan_progress import PlanProgress
from conav.planning.budget import Progress
from conav.planning.inash import INash
from conav.planning.load_scene import load_scene
from conav.planning.recorded import recorded_problem, recorded_trajectories
from conav.planning.scene_writer import scene_text

ROOT = Path(__file__).parents[2]
QUICK = ("plan", "random-discs:2,obstacles=2,side_m=9,seed=1", "--samples", "400")


def test_a_plan_is_printed(conav: Callable[..., Any]) -> None:
    outcome = conav(*QUICK)
    assert outcome.code == 0
    lines = outcome.out.splitlines()
    assert lines[0] == "random-discs: 2 robots, inash, seed 0"
    assert lines[1] == "  done"
    assert "times a lower bound on any plan's" in outcome.out
    assert "  an equilibrium: on its graph no robot can do better alone" in lines
    assert any(line.startswith("  robot_1: ") and "arrives at" in line for line in lines)


def test_json_png_gif_and_run_say_the_same(conav: Callable[..., Any], tmp_path: Path) -> None:
    files = ("--out", "a.mcap", "--png", "a.png", "--gif", "a.gif")
    outcome = conav(*QUICK, "--json", *files)
    assert outcome.code == 0, outcome.err
    summary = json.loads(outcome.out)
    assert summary["status"] == "done"
    assert summary["run"] == "a.mcap"
    assert summary["sum_cost"] == sum(robot["cost"][0] for robot in summary["robots"])
    assert summary["sum_cost"] == pytest.approx(sum(r["length_m"] for r in summary["robots"]))
    assert summary["ratio"] >= 1
    assert summary["min_clearance_m"] >= 0
    assert summary["first_solution_compute_s"] <= summary["compute_s"]
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.format == "PNG"
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames > 20  # type: ignore[attr-defined]
    run = package.read_plan(tmp_path / "a.mcap")
    assert scene_text(recorded_problem(run)) == scene_text(load_scene(QUICK[1]))
    arrivals = [way.arrival_s if way else None for way in recorded_trajectories(run)]
    assert arrivals == [robot["arrival_s"] for robot in summary["robots"]]
    assert run.result is not None
    assert run.result["interrupted"] is False


def test_the_same_seed_gives_the_same_plan(conav: Callable[..., Any]) -> None:
    timing = ("compute_s", "first_solution_compute_s")

    def robots(*more: str) -> dict[str, Any]:
        summary = json.loads(conav(*QUICK, "--json", *more).out)
        return {key: value for key, value in summary.items() if key not in timing}

    assert robots() == robots()
    assert robots()["robots"] != robots("--seed", "5")["robots"]


def test_options_reach_the_solver_and_the_scene(
    conav: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[tuple[INash, Any, int]] = []

    def solve(self: INash, problem: Any, seed: int = 0, on_progress: Any = None) -> Any:
        heard.append((self, problem, seed))
        raise package.InputError("heard", "enough")

    monkeypatch.setattr(INash, "solve", solve)
    warmed: list[str] = []
    monkeypatch.setattr("conav.planning.warm_up.warm_up", lambda name, _: warmed.append(name))
    conav("plan", "antipodal-circle", "--robots", "5", "--seed", "3", "--set", "batch=50")
    conav("plan", "random-discs:3", "--time", "2.5")
    conav("plan", "random-discs:3", "--time", "2.5", "--samples", "70")
    (first, problem, seed), (timed, drawn, _), (both, _, _) = heard
    assert warmed == ["inash", "inash"]  # where there is a clock
    assert (len(problem.robots), seed, first.batch, first.time_s) == (5, 3, 50, None)
    # Without a number of samples time alone ends it.
    assert (timed.time_s, timed.samples) == (2.5, None)
    assert (both.time_s, both.samples) == (2.5, 70)
    assert scene_text(drawn) == scene_text(load_scene("random-discs:3", seed=0))


def test_what_cannot_be_done_exits_with_one(conav: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "wall.toml").write_text(
        "horizon_s = 20\n[floor]\nbox = [0, 0, 6, 4]\n[[walls]]\nbox = [4, 0, 6, 4]\n"
        "[[robots]]\nname = 'lost'\nstart = [1, 1]\ngoal = [5, 2, 0.2]\n"
    )
    outcome = conav("plan", "wall.toml", "--samples", "100")
    assert outcome.code == 1
    assert "  infeasible: " in outcome.out
    assert "lost" in outcome.out
    summary = json.loads(conav("plan", "wall.toml", "--samples", "100", "--json").out)
    assert summary["status"] == "infeasible"
    assert summary["sum_cost"] is None
    # A picture shows the scene; there is nothing to animate.
    outcome = conav("plan", "wall.toml", "--png", "a.png", "--gif", "a.gif", "--samples", "100")
    assert (tmp_path / "a.png").exists()
    assert not (tmp_path / "a.gif").exists()
    assert "nobody has a path, so there is no animation" in outcome.err
    assert "  nobody has a path" in outcome.out


def test_who_has_no_path_is_told_in_one_line(conav: Callable[..., Any]) -> None:
    outcome = conav(
        "plan", "narrow-passage:2,bay=yes", "--solver", "prioritized", "--samples", "100"
    )
    assert outcome.code == 1
    assert "  robot_0: 6.2 m, arrives at" in outcome.out
    assert "  no path: robot_1" in outcome.out.splitlines()


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["plan", "intersektion"], ["scene 'intersektion'", "did you mean intersection?"]),
        (["plan", "missing.toml"], ["missing.toml: does not exist"]),
        (["plan", "no/missing.toml"], ["there is no folder no"]),
        (["plan", "bad.toml"], ["bad.toml: horizon: there is no key", "mean horizon_s?"]),
        ([*QUICK, "--solver", "inach"], ["solver 'inach'", "did you mean inash?"]),
        ([*QUICK, "--set", "eta=2"], ["setting 'eta'", "did you mean"]),
        ([*QUICK, "--set", "eta"], ["--set eta", "write --set name=value"]),
        ([*QUICK, "--set", "samples=2"], ["--set samples", "its own option"]),
        ([*QUICK, "--png", "a.gif"], ["a.gif: is no .png file name"]),
        ([*QUICK, "--out", "no/a.mcap"], ["no/a.mcap: lies in a folder that does not exist"]),
        (["plan", "random-discs", "--robots", "0"], ["setting 'robots'"]),
        (["plan", "random-discs", "--robots", "1.5"], ['"1.5" is not a whole number']),
        (["scenes", "intersektion"], ["did you mean intersection?"]),
        (["scenes", "intersection", "--out", "a.json"], ["a.json", "end the name in .toml"]),
        (["scenes", "--out", "a.toml"], ["--out", "name a scene"]),
        (["scenes", "--png", "no"], ["no: is no folder"]),
        (["schema", "scenes"], ["schema 'scenes'", "known: scene"]),
    ],
    ids=lambda value: " ".join(value[-2:]),
)
def test_bad_input_is_one_line(
    conav: Callable[..., Any], tmp_path: Path, arguments: list[str], parts: list[str]
) -> None:
    (tmp_path / "bad.toml").write_text("horizon = 3\n[floor]\nbox = [0, 0, 1, 1]\n")
    outcome = conav(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1
    for part in parts:
        assert part in outcome.err


def test_a_wrong_task_is_shown_with_a_caret(conav: Callable[..., Any], tmp_path: Path) -> None:
    text = "horizon_s = 3\n[floor]\nbox = [0, 0, 9, 9]\n[regions]\ndock = { disc = [5, 5, 1] }\n"
    (tmp_path / "a.toml").write_text(f"{text}[[robots]]\nstart = [1, 1]\ntask = 'F dokc'\n")
    outcome = conav("plan", "a.toml")
    assert outcome.code == 2
    first, shown, caret = outcome.err.splitlines()
    assert "a.toml: robots[0].task" in first
    assert "did you mean dock?" in first
    assert shown.endswith("F dokc")
    assert shown[caret.index("^")] == "d"


# Ctrl-C


@pytest.fixture
def _heard_interrupts() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("_heard_interrupts")
def test_an_interrupt_keeps_the_best_so_far(
    conav: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    step = PlanProgress.step
    iterations: list[int] = []
    asked: list[int] = []

    def interrupted(self: PlanProgress, state: Progress) -> None:
        step(self, state)
        iterations.append(state.iteration)
        if np.isfinite(state.costs).all() and not asked and len(iterations) > 1:
            asked.append(state.iteration)
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(PlanProgress, "step", interrupted)
    outcome = conav("plan", QUICK[1], "--samples", "1000000", "--json", "--out", "a.mcap")
    assert outcome.code == 1
    summary = json.loads(outcome.out)
    assert summary["interrupted"] is True
    assert summary["status"] == "out_of_budget"
    assert all(robot["arrival_s"] is not None for robot in summary["robots"])
    assert max(iterations) <= asked[0] + 1
    run = package.read_plan(tmp_path / "a.mcap")
    assert run.result is not None
    assert run.result["interrupted"] is True
    assert None not in recorded_trajectories(run)


def test_progress_says_samples_robots_and_costs() -> None:
    problem = load_scene("antipodal-circle:3")
    progress = PlanProgress(problem, shown=True)
    costs = np.array([[12.5], [np.inf], [7.25]])
    state = Progress("game", 4, 800, costs)
    assert progress.words(state) == (
        "game: 2,400 samples, 2 of 3 robots have a path, 19.75 m in all"
    )
    none = SimpleNamespace(stage="sampling", samples=200, costs=np.full((3, 1), np.inf))
    assert progress.words(none) == "sampling: 600 samples, 0 of 3 robots have a path"


# conav scenes and conav schema


def test_made_scenes_are_listed(conav: Callable[..., Any]) -> None:
    outcome = conav("scenes")
    assert outcome.code == 0
    for name in ("random-discs", "intersection", "antipodal-circle", "narrow-passage"):
        assert f"{name}: " in outcome.out
    assert max(map(len, outcome.out.splitlines())) <= 100
    made = json.loads(conav("scenes", "--json").out)["made"]
    assert [row["name"] for row in made][-1] == "office-delivery"
    assert made[0]["settings"]["robots"] == 8


def test_a_scene_is_described_converted_and_drawn(
    conav: Callable[..., Any], tmp_path: Path
) -> None:
    outcome = conav("scenes", "narrow-passage:4", "--out", "a.toml", "--png", "a.png")
    assert outcome.code == 0
    assert "narrow-passage, " in outcome.out
    assert "robot_3: F goal; single-integrator from" in outcome.out
    assert tomllib.loads((tmp_path / "a.toml").read_text())["name"] == "narrow-passage"
    assert scene_text(load_scene(tmp_path / "a.toml")) == (tmp_path / "a.toml").read_text()
    facts = json.loads(conav("scenes", tmp_path / "a.toml", "--json", "--robots", "3").out)
    assert (facts["job"], len(facts["robots"])) == ("scenes", 3)


def test_all_made_scenes_are_drawn(conav: Callable[..., Any], tmp_path: Path) -> None:
    assert conav("scenes", "--png", tmp_path).code == 0
    assert len(list(tmp_path.glob("*.png"))) == 5


def test_the_schema_is_printed(conav: Callable[..., Any]) -> None:
    schema = json.loads(conav("schema", "scene").out)
    assert schema["title"] == "SceneFile"
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize(
    "path", sorted((ROOT / "examples/scenes").glob("*.toml")), ids=lambda path: path.stem
)
def test_every_example_has_a_plan(conav: Callable[..., Any], path: Path) -> None:
    coupled = bool(load_scene(path).couplings)
    how = ("--solver", "coupled", "--samples", "60") if coupled else ("--samples", "6000")
    summary = json.loads(conav("plan", path, *how, "--json").out)
    assert summary["status"] == "done"
    assert summary["min_clearance_m"] >= load_scene(path).margin_m


def test_couplings_are_told_of_and_refused(conav: Callable[..., Any]) -> None:
    path = ROOT / "examples/scenes/handover.toml"
    told = conav("scenes", path).out
    assert "  ann and bob meet in shop, within 1.5 m" in told
    assert "  bob is not in gate before ann has been in shop" in told
    refused = conav("plan", path)
    assert refused.code == 2
    assert "--solver coupled" in refused.err
