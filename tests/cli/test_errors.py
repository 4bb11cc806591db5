"""Bad input ends with exit code 2 and one line that names the place and the remedy."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FAST = ("explore", "three-obstacles", "--robots", "2")
NEAREST = (*FAST, "--strategy", "nearest")


def refused(outcome: Any) -> str:
    """The one line a refusal prints."""
    assert outcome.code == 2
    assert outcome.out == ""
    lines = outcome.err.splitlines()
    assert len(lines) == 1, outcome.err
    assert lines[0].startswith("conav: ")
    return lines[0].removeprefix("conav: ")


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        # Names
        (
            ["explore", "offices"],
            ["map 'offices'", "neither a file nor a built-in map", "office, "],
        ),
        (["explore", "missing.yaml"], ["missing.yaml: does not exist", "check the path"]),
        (["explore", "missing.png"], ["missing.png: does not exist"]),
        (["maps", "offices"], ["map 'offices'", "office, "]),
        ([*FAST, "--strategy", "nearst"], ["strategy 'nearst'", "did you mean nearest?"]),
        ([*FAST, "--motion", "fly"], ["motion 'fly'", "4-connected, 8-connected, forward-turn"]),
        ([*FAST, "--sensor", "nose"], ["sensor 'nose'", "range, disc"]),
        (
            [*FAST, "--radio", "loud"],
            ["radio 'loud'", 'give "perfect", "off", "path-loss" or metres'],
        ),
        ([*FAST, "--loss", "1"], ["loss 1", "give 0 to 0.99"]),
        ([*FAST, "--delay", "-1"], ["delay -1", "is out of range"]),
        ([*FAST, "--energy", "0"], ["energy 0", "is out of range"]),
        # Faults
        ([*FAST, "--fault", "robot_7:dies:3"], ["fault 'robot_7:dies:3'", "robot_0 to robot_"]),
        ([*FAST, "--fault", "robot_0:rests:3"], ["robot_0:rests:3", "robot_2:stalls:50:200"]),
        ([*FAST, "--fault", "robot_0:dies:soon"], ["has times that are no numbers"]),
        (
            [*FAST, "--fault", "robot_0:dies:3", "--fault", "robot_0:dies:4"],
            ["faults: cannot be: robot 0 dies twice"],
        ),
        # Settings of the strategy
        ([*NEAREST, "--set", "keepgoal=1"], ["setting 'keepgoal'", "did you mean keep_goal?"]),
        ([*NEAREST, "--set", "colour=red"], ["setting 'colour'", "its settings: keep_goal"]),
        ([*NEAREST, "--set", "keep_goal=maybe"], ["setting 'keep_goal'", "'maybe'", "nearest.md"]),
        ([*FAST, "--set", "keep_goal"], ["--set keep_goal", "write --set name=value"]),
        ([*NEAREST, "--set", "=1"], ["--set =1", "write --set name=value"]),
        # Numbers
        ([*FAST[:2], "--robots", "0"], ["robots 0", "give 1 to 1024"]),
        ([*FAST[:2], "--robots", "-1"], ["robots -1", "give 1 to 1024"]),
        ([*FAST[:2], "--robots", "abc"], ["--robots", '"abc" is not a whole number']),
        ([*FAST[:2], "--robots", "1.5"], ["--robots", '"1.5" is not a whole number']),
        ([*FAST[:2], "--robots", "1025"], ["robots 1025", "give 1 to 1024"]),
        ([*FAST, "--seed", "-1"], ["seed -1", "give 0 to"]),
        ([*FAST, "--seed", "2.5"], ["--seed", '"2.5" is not a whole number']),
        ([*FAST, "--cell", "0"], ["cell 0", "is not a positive length", "--cell"]),
        ([*FAST, "--cell", "nan"], ["cell nan", "--cell"]),
        ([*FAST, "--cell", "-0.2"], ["cell -0.2", "--cell"]),
        ([*FAST, "--cell", "1e-9"], ["planning cells", "give a larger --cell"]),
        ([*FAST, "--cell", "1000"], ["larger than the map", "give a smaller --cell"]),
        ([*FAST, "--range", "nan"], ["range nan", "give 0 to"]),
        ([*FAST, "--range", "-3"], ["range -3", "give 0 to"]),
        ([*FAST, "--range", "inf"], ["range inf", "give 0 to"]),
        ([*FAST, "--range", "far"], ["--range", '"far"', "float"]),
        ([*FAST, "--radius", "-0.1"], ["radius -0.1", "give 0 to"]),
        ([*FAST, "--speed", "0"], ["speed 0", "give"]),
        ([*FAST, "--radio", "-2"], ["radio -2", "give 0 to"]),
        ([*FAST, "--max-time", "nan"], ["max-time nan", "give 0 to"]),
        ([*FAST, "--resolution", "0"], ["resolution", "positive number of metres", "try 1"]),
        # Starts
        ([*FAST, "--starts", "1"], ["--starts", "'1' is not x,y", '"1,2 1.5,2"']),
        ([*FAST, "--starts", "1,2,3 4,5"], ["--starts", "'1,2,3' is not x,y"]),
        ([*FAST, "--starts", "a,b"], ["--starts", "'a,b' is not x,y"]),
        ([*FAST, "--starts", "1.5,1.5"], ["1 points for 2 robots", "one x,y per robot"]),
        ([*FAST, "--starts", "-1,2 3.5,3.5"], ["start -1,2 of robot_0", "is off the map"]),
        ([*FAST, "--starts", "nan,2 3.5,3.5"], ["start nan,2 of robot_0", "is off the map"]),
        ([*FAST, "--starts", "1.5,1.5 1.5,1.5"], ["robot_1", "too near another robot"]),
        (
            ["explore", "office", "--robots", "1", "--starts", "0,0"],
            ["start 0,0 of robot_0", "in a wall", "the nearest place that fits is"],
        ),
        # Files to write
        ([*FAST, "--out", "no/run.mcap"], ["no/run.mcap", "folder that does not exist", "make"]),
        ([*FAST, "--out", "."], [".: is a folder", "name a file, for example run.mcap"]),
        ([*FAST, "--png", "picture.jpg"], ["picture.jpg", "end it in .png"]),
        ([*FAST, "--gif", "no/moving.gif"], ["no/moving.gif", "make the folder first"]),
        (["maps", "--out", "x.yaml"], ["--out", "name a map"]),
        (["maps", "office", "--size", "3"], ["--size 3", "for example 40x25"]),
        (["maps", "office", "--size", "0x5"], ["width must be a positive number"]),
        # Floor plans
        (["maps", "comb:x"], ["comb:x", "'x' is no whole number", "write it as comb:6"]),
        (["maps", "comb:6", "--size", "3x3"], ["--size: is for grid maps", "leave it out"]),
        (["maps", "comb:6", "--seed", "3"], ["--seed: is for grid maps", "seed=3"]),
        (["maps", "comb:6", "--floor-plan"], ["--floor-plan: is for grid maps"]),
        (["maps", "comb:6", "--out", "x.yaml"], ["x.yaml", "end the name in .json or .geojson"]),
        (["maps", "office", "--tolerance", "1"], ["--tolerance: is for floor plans", "--floor-"]),
        (["maps", "office", "--part", "1"], ["--part: is for files of polygons"]),
        (["maps", "office", "--floor-plan", "--at", "1"], ["--at 1", "is not X,Y"]),
        (["maps", "office", "--floor-plan", "--unknown", "no"], ["unknown", "give free or wall"]),
        (["maps", "missing.pol"], ["missing.pol", "does not exist"]),
        # Files to read
        (["verify", "missing.mcap"], ["missing.mcap: cannot be read (No such file"]),
        (["verify", "."], [".: cannot be read (Is a directory)"]),
        (["repair", "missing.mcap", "--out", "new.mcap"], ["missing.mcap: cannot be read"]),
        # The command line itself
        (["explore"], ["MAP requires an argument", "conav --help"]),
        (["verify"], ["RUN requires an argument", "conav --help"]),
        (["repair", "run.mcap"], ["--out requires an argument", "conav --help"]),
        ([*FAST, "--robot", "3"], ["Unknown option: --robot.", "Did you mean --robots?"]),
        ([*FAST, "--bogus"], ["Unknown option: --bogus.", "conav --help"]),
        ([*FAST, "extra"], ["extra", "conav --help"]),
        (["explorer"], ['Unknown command "explorer"', "explore", "conav --help"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_refusals(conav: Any, arguments: list[str], parts: list[str]) -> None:
    line = refused(conav(*arguments))
    for part in parts:
        assert part in line


def test_files_that_are_no_runs(conav: Any) -> None:
    Path("text.mcap").write_text("hello")
    Path("empty.mcap").touch()
    Path("short.mcap").write_bytes(b"\x89MCAP0\r\n")
    for name in ("text.mcap", "empty.mcap"):
        assert f"{name}: is no run file" in refused(conav("verify", name))
    assert "was cut short before the run began" in refused(conav("verify", "short.mcap"))
    assert "give a file written by conav" in refused(conav("repair", "text.mcap", "--out", "x"))
    assert not Path("x").exists()
    assert "is not the suffix of a map" in refused(conav("explore", "text.mcap"))


def test_what_is_no_run_is_not_written_over(conav: Any) -> None:
    precious = Path("precious.mcap")
    precious.write_text("precious")
    line = refused(conav(*FAST, "--out", precious))
    assert "exists and is no run file; it is left alone; choose another --out" in line
    assert precious.read_text() == "precious"


def test_bad_input_leaves_an_older_run_alone(conav: Any) -> None:
    assert conav(*FAST, "--out", "run.mcap").code == 0
    before = Path("run.mcap").read_bytes()
    refused(conav(*FAST, "--out", "run.mcap", "--cell", "0"))
    refused(conav(*FAST, "--out", "run.mcap", "--starts", "0,0"))
    refused(conav(*FAST, "--out", "run.mcap", "--png", "no.jpg"))
    assert Path("run.mcap").read_bytes() == before


def test_the_full_disk(conav: Any) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("needs a device that is always full")
    assert "/dev/full: cannot be written (No space left" in refused(
        conav(*FAST, "--out", "/dev/full")
    )


def test_the_same_from_outside(tmp_path: Path) -> None:
    """No traceback, nothing on standard output, and the exit code reaches the shell."""
    for arguments, code, part in (
        (["explore", "nowhere"], 2, "conav: map 'nowhere': is neither a file"),
        (["verify", "missing.mcap"], 2, "conav: missing.mcap: cannot be read"),
        (["--bogus"], 2, "conav: "),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "conav", *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == code
        assert done.stdout == ""
        assert done.stderr.startswith(part)
        assert done.stderr.count("\n") == 1
