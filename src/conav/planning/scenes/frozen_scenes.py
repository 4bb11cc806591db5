"""The scenes of the two experiments of [Zhu2014], as files that do not change.

Made scenes follow from their makers, which may get better; what was published about a scene is of
the scene as it was. Each file says how it was made, and how many samples of each robot the
reproduction spends on it. A test makes them anew and compares.
"""

from pathlib import Path
from typing import NamedTuple

from conav.planning.scene_writer import scene_text
from conav.planning.scenes.catalogue import make_scene

FOLDER = Path(__file__).parent / "frozen"

TRIALS = 20  # scenes of the first experiment, which are new in each trial


class Recipe(NamedTuple):
    """How a frozen scene was made."""

    scene: str  # a made scene
    robots: int
    seed: int
    samples: int  # of each robot, in the reproduction
    about: str


FROZEN: dict[str, Recipe] = {
    **{
        f"inash-discs-{trial}": Recipe(
            "random-discs", 8, trial, 6000, f"eight robots among random discs, trial {trial}"
        )
        for trial in range(TRIALS)
    },
    "inash-intersection": Recipe("intersection", 6, 0, 2600, "six robots at an intersection"),
}
"""By name; nothing in the second experiment is random."""


def frozen_path(name: str) -> Path:
    """The file of a frozen scene."""
    return FOLDER / f"{name}.toml"


def frozen_text(name: str) -> str:
    """What the file of a frozen scene says, by its maker: head and scene."""
    recipe = FROZEN[name]
    problem = make_scene(recipe.scene, {"robots": recipe.robots}, seed=recipe.seed)
    head = (
        f"# {recipe.about[0].upper()}{recipe.about[1:]}, after [Zhu2014]: {recipe.scene}:"
        f"{recipe.robots}, seed {recipe.seed}.\n"
        f"# Planned with {recipe.samples} samples of each robot by conav reproduce inash.\n\n"
    )
    return head + scene_text(problem)
