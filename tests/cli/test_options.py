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
        *("--loss", "0.25", "--delay", "1.5", "--energy", "9000"),
        *("--fault", "robot_1:stalls:2:4", "--fault", "robot_0:dies:400"),
        *("--starts", "0.7,0.7 1.3,0.7", "--strategy", "nearest"),
        *("--set", "keep_goal=true", "--outside"),
    )
    run([*QUICK, *options, "--out", str(path), "--quiet"])
    header = conav.read_run(path).header
    robot = header["robots"][0]
    assert robot["sensor"] == {"name": "disc", "occlusion": False, "range_m": 3.0}
    assert header["cell_m"] == 0.2
    assert robot["radius_m"] == 0.05
    assert robot["speed_mps"] == 1.5
    assert robot["motion"]["name"] == "4-connected"
    radio = robot["radio"]
    assert (radio["name"], radio["range_m"]) == ("limited", 4.0)
    assert (radio["loss"], radio["delay_s"], radio["path_loss"]) == (0.25, 1.5, None)
    assert robot["energy_j"] == 9000.0
    assert header["faults"] == [
        {"robot": 1, "kind": "stalls", "at_s": 2.0, "until_s": 4.0},
        {"robot": 0, "kind": "dies", "at_s": 400.0, "until_s": None},
    ]
    assert header["max_time_s"] == 500.0
    assert header["settings"] == {"keep_goal": True}
    assert header["seed"] == 3
    assert len(header["starts"]) == 2
