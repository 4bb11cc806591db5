"""Golden runs: short text traces, so that a change of behaviour is read in review.

After a change that is meant:  python tests/golden/test_golden.py   writes them anew.
"""

from pathlib import Path
from typing import Any

import pytest

import conav
from conav.runs.reader import read_run

FOLDER = Path(__file__).parent
EVERY = 25  # steps between two lines of a trace

SCENARIOS: dict[str, dict[str, Any]] = {
    "office": {"map": "office", "strategy": "nearest", "robots": 3, "seed": 1},
    "office-default": {"map": "office", "robots": 3, "seed": 1},
    "field-default": {"map": "field", "robots": 4, "seed": 1, "range_m": 4.0},
    "maze-4-connected": {
        "map": "maze",
        "strategy": "nearest",
        "robots": 2,
        "seed": 4,
        "motion": "4-connected",
    },
    "cave-limited-radio": {
        "map": "cave",
        "strategy": "nearest",
        "robots": 4,
        "seed": 2,
        "radio": 5.0,
    },
    "three-obstacles-forward-turn": {
        "map": "three-obstacles",
        "strategy": "nearest",
        "robots": 3,
        "seed": 3,
        "motion": "forward-turn",
        "sensor": "disc",
        "range_m": 2.0,
    },
    "maze-fine-cells-wide-robots": {
        "map": "maze",
        "strategy": "nearest",
        "robots": 3,
        "seed": 5,
        "cell_m": 0.17,
        "radius_m": 0.2,
    },
}


def trace(name: str, folder: Path) -> str:
    """The text of one run: who stood where and what was covered, then the result."""
    options = dict(SCENARIOS[name])
    path = folder / f"{name}.mcap"
    done = conav.explore(options.pop("map"), out=path, **options)
    run = read_run(path)
    lines = [f"{key}: {value}" for key, value in SCENARIOS[name].items()]
    for step in run.steps:
        if step.step % EVERY == 0 or step.step == len(run.steps) - 1:
            cells = " ".join(str(cell) for cell in step.cells)
            lines.append(f"step {step.step}: at {cells}; seen {done.result.covered[step.step]}")
    metrics = done.metrics
    lines += [
        f"{done.status} after {metrics.time_s:g} s, {metrics.messages} messages, "
        f"{metrics.bytes} bytes",
        f"90 % {metrics.t90_s} s, 95 % {metrics.t95_s} s, 99 % {metrics.t99_s} s",
        f"digest {run.digest}",
    ]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", SCENARIOS)
def test_run_is_as_recorded(name: str, tmp_path: Path) -> None:
    assert trace(name, tmp_path) == (FOLDER / f"{name}.txt").read_text()


if __name__ == "__main__":
    import tempfile

    for scenario in SCENARIOS:
        with tempfile.TemporaryDirectory() as scratch:
            (FOLDER / f"{scenario}.txt").write_text(trace(scenario, Path(scratch)))
