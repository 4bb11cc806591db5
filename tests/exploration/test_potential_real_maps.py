"""The strategies of potential games on real maps: they run, and the verifier accepts."""

import os
from pathlib import Path

import pytest

import conav
from conav.exploration.catalogue import STRATEGIES

FAMILY = [name for name in STRATEGIES if name != "nearest"]
# Path under the data folder, and the resolution where the map has none [m].
MAPS = [
    ("maps/navigation2/tb3_sandbox.yaml", None),
    ("maps/navigation2/depot.yaml", None),
    ("maps/aws_small_house/map.yaml", None),
    ("maps/patrolling_sim/cumberland.yaml", None),
    ("maps/patrolling_sim/1r5.yaml", None),
    ("maps/patrolling_sim/move_base_arena.yaml", None),
    ("maps/comprobo22/gauntlet.yaml", None),
    ("maps/explore_bench/corner.yaml", None),
    ("maps/explore_bench/room_with_corner.yaml", None),
    ("maps/images_only/ipa/lab_intel.png", 0.05),
]


@pytest.mark.parametrize(("file", "resolution"), MAPS)
@pytest.mark.parametrize("name", FAMILY)
def test_runs_and_is_accepted(
    name: str, file: str, resolution: float | None, tmp_path: Path
) -> None:
    data = os.environ.get("CONAV_DATA")
    if not data or not (Path(data) / file).is_file():
        pytest.skip("needs the real maps of the folder CONAV_DATA names")
    path = tmp_path / "run.mcap"
    done = conav.explore(
        Path(data) / file,
        strategy=name,
        resolution=resolution,
        range_m=2.5,
        motion="forward-turn" if len(file) % 2 else "8-connected",
        max_time_s=40.0,
        seed=3,
        out=path,
    )
    assert done.result.covered[-1] > done.result.covered[0]
    assert done.metrics.messages == 0 or name != "uncoordinated-alone"
    report = conav.verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()
