"""How soon everybody has a path in the scenes of iNash-trajectory's two experiments.

Seconds until the first plan in which all robots have a path and no two collide, kernels compiled
and cached before: of the first run in this process, which loads them, and the median and the range
of later ones with other seeds. Processor time, and in brackets by the clock on the wall.
"""

import argparse
from statistics import median
from time import perf_counter, process_time

import numpy as np

from conav.planning.load_scene import load_scene
from conav.planning.plan import plan

SCENES = ("random-discs:8", "intersection:6")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=20)
    options = parser.parse_args()
    for scene in SCENES:
        first = until_first(scene, 0)
        later = [until_first(scene, seed) for seed in range(1, options.repeat + 1)]
        processor, wall = (sorted(times) for times in zip(*later, strict=True))
        print(f"{scene}: first {first[0]:.3f} s ({first[1]:.3f})")
        print(
            f"  later, median {median(processor):.3f} s ({median(wall):.3f}), "
            f"{processor[0]:.3f} ({wall[0]:.3f}) to {processor[-1]:.3f} ({wall[-1]:.3f})"
        )


def until_first(scene: str, seed: int) -> tuple[float, float]:
    """Processor time and wall time [s]."""
    problem = load_scene(scene, seed=seed)
    processor, wall = process_time(), perf_counter()
    result = plan(
        problem,
        seed=seed,
        samples=20_000,
        on_progress=lambda progress: not np.isfinite(progress.costs).all(),
    )
    assert all(result.trajectories)
    return process_time() - processor, perf_counter() - wall


if __name__ == "__main__":
    main()
