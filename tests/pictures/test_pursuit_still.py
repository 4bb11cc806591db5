"""Pictures of pursuits: what has which colour."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pictures.floor_plan import FloorCanvas, page_colour
from conav.pictures.palette import CURVE, PAGE
from conav.pictures.pursuit_still import save_pursuit_still
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.types import HiddenRegion, Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.runs.reader import read_pursuit
from conav.runs.types import PursuitRun
from conav.status import Status

CORNERS = PolygonMap([(0, 0), (9, 0), (9, 6), (8, 6), (8, 1), (1, 1), (1, 6), (0, 6)])
"""A corridor with an arm up at either end."""
RED, GREEN, ORANGE = (246, 200, 178), (196, 226, 214), (213, 94, 0)


def written(path: Path, known: bool) -> PursuitRun:
    """From the left corner into the left arm and back to the corridor; none sees the right arm."""
    way = np.array([[(1.0, 1.0)], [(0.5, 5.0)], [(3.0, 0.5)]])
    schedule = Schedule(np.array([0.0, 5.0, 11.0]), way, np.ones((2, 1), np.bool_))
    arm = HiddenRegion(np.array([(0.0, 2.0), (1.0, 2.0), (1.0, 6.0), (0.0, 6.0)]), (), clear=True)
    corridor = HiddenRegion(np.array([(2.0, 0.0), (8.0, 0.0), (8.0, 1.0), (2.0, 1.0)]))
    team = (Pursuer("one", (1.0, 1.0)),)
    beliefs = {0: (corridor,), 1: (arm,)}
    result = PursuitResult(
        Status.STUCK, "by hand", schedule, team, 1, False, beliefs=beliefs, explored=0.5
    )
    problem = PursuitProblem(CORNERS, team, known)
    record_pursuit(path, problem, result, method="hand", settings={}, seed=0, compute_s=0.0)
    return read_pursuit(path)


def colours(path: Path, *places: tuple[float, float]) -> list[object]:
    canvas = FloorCanvas(CORNERS.bounds, max_pixels=600)
    with Image.open(path) as picture:
        pixels = picture.convert("RGB")
        margin = 0.02 * 9
        return [
            pixels.getpixel(
                (
                    round((x + margin) * canvas.pixels_per_m),
                    round((6 + margin - y) * canvas.pixels_per_m),
                )
            )
            for x, y in places
        ]


def test_seen_clear_contaminated_and_not_seen(tmp_path: Path) -> None:
    run, file = written(tmp_path / "run.mcap", known=False), tmp_path / "p.png"
    places = [(0.5, 0.7), (0.2, 4.0), (5.0, 0.3), (8.6, 5.0)]
    white, grey = page_colour(PAGE), page_colour(CURVE)
    save_pursuit_still(run, file, after=1, max_pixels=600)
    assert colours(file, *places) == [white, white, RED, grey]
    save_pursuit_still(run, file, max_pixels=600)
    assert colours(file, *places) == [white, GREEN, white, grey]
    # From (3, 0.5) a window hangs on (8, 1).
    assert colours(file, (8.5, 1.05)) == [ORANGE]


def test_of_a_known_floor_nothing_is_unseen(tmp_path: Path) -> None:
    run, file = written(tmp_path / "run.mcap", known=True), tmp_path / "p.png"
    save_pursuit_still(run, file, after=1, max_pixels=600)
    assert colours(file, (5.0, 0.3), (8.6, 5.0)) == [RED, page_colour(PAGE)]


def test_there_are_only_so_many_drives(tmp_path: Path) -> None:
    run = written(tmp_path / "run.mcap", known=False)
    for after in (-1, 3):
        with pytest.raises(InputError, match="is none of 2 drives"):
            save_pursuit_still(run, tmp_path / "p.png", after=after)
