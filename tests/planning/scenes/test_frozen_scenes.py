"""Frozen scenes: their files are what their makers make, and what the reproduction plays."""

import numpy as np
import pytest

from conav.errors import InputError
from conav.experiments.inash.world import EXPERIMENTS, INASH, Case, frozen_scene, problem_of
from conav.planning.load_scene import load_scene
from conav.planning.scene_writer import scene_text
from conav.planning.scenes.catalogue import make_scene
from conav.planning.scenes.frozen_scenes import FOLDER, FROZEN, frozen_path, frozen_text


@pytest.mark.parametrize("name", FROZEN)
def test_makers_still_make_exactly_these(name: str) -> None:
    assert frozen_path(name).read_text() == frozen_text(name), (
        'python -c "from conav.planning.scenes.frozen_scenes import *; '
        '[frozen_path(n).write_text(frozen_text(n)) for n in FROZEN]" writes them anew; numbers '
        "that were published of them are then of other scenes"
    )


@pytest.mark.parametrize("name", ["inash-discs-3", "inash-intersection"])
def test_what_is_read_is_what_was_made(name: str) -> None:
    recipe = FROZEN[name]
    made = make_scene(recipe.scene, {"robots": recipe.robots}, seed=recipe.seed)
    read = load_scene(name)
    assert scene_text(read) == scene_text(made)
    assert np.array_equal(read.discs, made.discs)
    assert np.array_equal(read.floor.segments, made.floor.segments)
    assert [robot.start for robot in read.robots] == [robot.start for robot in made.robots]


def test_there_are_no_other_files() -> None:
    assert {path.stem for path in FOLDER.glob("*")} == set(FROZEN)


def test_the_reproduction_plays_them() -> None:
    case = Case("discs", INASH, 8, 7)
    assert frozen_scene(case) == "inash-discs-7"
    assert np.array_equal(problem_of(case).discs, load_scene("inash-discs-7").discs)
    assert frozen_scene(Case("intersection", INASH, 6, 31)) == "inash-intersection"
    later = Case("discs", INASH, 8, 31)
    assert frozen_scene(later) is None
    assert len(problem_of(later).robots) == 8
    for name, experiment in EXPERIMENTS.items():
        recipes = [recipe for key, recipe in FROZEN.items() if key.startswith(f"inash-{name}")]
        assert {recipe.samples for recipe in recipes} == {experiment.samples}
        assert {f"{r.scene}:{r.robots}" for r in recipes} == {experiment.scene}


def test_only_their_robots_can_be_counted() -> None:
    assert len(load_scene("inash-intersection:4").robots) == 4
    assert len(load_scene("inash-discs-0", robots=3).robots) == 3
    with pytest.raises(InputError, match="frozen"):
        load_scene("inash-discs-0:8,obstacles=3")
    with pytest.raises(InputError, match="did you mean inash-intersection"):
        load_scene("inash-intersections")
