"""A team with errands on one office floor: all done, no gain left for anybody, and verified."""

from pathlib import Path

import numpy as np

from conav.planning.catalogue import make_solver, settings_of
from conav.planning.load_scene import load_scene
from conav.planning.recorder import PlanRecorder
from conav.planning.verify import verify_plan
from conav.runs.reader import read_plan


def test_sixteen_robots_on_one_office_floor(tmp_path: Path) -> None:
    problem = load_scene("office-delivery:16,office=0", seed=0)
    assert 25 < problem.floor.area / 16 < 35  # [m^2] of free floor for each robot
    solver = make_solver("inash", {"samples": 600})
    result = solver.solve(problem, 0)
    assert result.status == "done"
    assert result.epsilon is not None
    assert not np.any(result.epsilon)
    path = tmp_path / "run.mcap"
    with PlanRecorder(
        path, problem, solver="inash", settings=settings_of(solver), seed=0
    ) as recorder:
        recorder.finish(result, compute_s=0.0)
    report = verify_plan(read_plan(path))
    assert report.verdict == "verified", report.lines()
    looked = {check.name: check.looked for check in report.checks}
    assert (looked["tasks"], looked["equilibrium"]) == (16, 16)
    assert looked["collisions"] == 16 * 15 // 2
