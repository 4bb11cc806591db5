"""Every option of a problem reaches the run."""

from pathlib import Path

import conav
from conav.cli import run

QUICK = ("explore", "maze", "--robots", "2", "--seed", "3")


def test_every_problem_option_is_heard(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    options = (
        *("--range", "3", "--cell", "0.2", "--radius", "0.05", "--speed", "1.5"),
        *("--motion", "4-connected", "--sensor", "disc", "--radio", "4", "--max-time", "500"),
        *("--starts", "0.7,0.7 1.3,0.7", "--set", "keep_goal=true", "--outside"),
    )
    run([*QUICK, *options, "--out", str(path), "--quiet"])
    header = conav.read_run(path).header
    robot = header["robots"][0]
    assert robot["sensor"] == {"name": "disc", "occlusion": False, "range_m": 3.0}
    assert header["cell_m"] == 0.2
    assert robot["radius_m"] == 0.05
    assert robot["speed_mps"] == 1.5
    assert robot["motion"]["name"] == "4-connected"
    assert robot["radio"] == {"name": "limited", "range_m": 4.0}
    assert header["max_time_s"] == 500.0
    assert header["settings"] == {"keep_goal": True}
    assert header["seed"] == 3
    assert len(header["starts"]) == 2
