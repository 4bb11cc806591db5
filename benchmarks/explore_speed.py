"""Simulated steps per second, run file written: the figures of docs/performance.md.

    python benchmarks/explore_speed.py            # indoor maps of 250 x 250 cells at 0.1 m
    python benchmarks/explore_speed.py --big      # 2000 x 2000 cells, 64 robots, memory
    python benchmarks/explore_speed.py MAP ...    # map files, at planning cells of their own size

Each run is repeated in one process; the first one also compiles or loads the kernels and is shown
apart. Quoted: the median over the repetitions of steps over the wall time of the loop, which
includes writing the run file.
"""

import argparse
import resource
import statistics
import tempfile
from pathlib import Path
from time import perf_counter

import conav


def measure(map_name: object, repeat: int, **options: object) -> None:
    rates: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(repeat + 1):
            start = perf_counter()
            done = conav.explore(
                map_name, strategy="nearest", out=Path(folder) / "run.mcap", **options
            )
            whole = perf_counter() - start
            rate = done.metrics.steps / done.result.compute_s
            if turn == 0:
                print(f"  first run {whole:.2f} s with loading", flush=True)
            else:
                rates.append(rate)
    print(
        f"  {done.status}, {done.metrics.steps} steps, "
        f"median {statistics.median(rates):,.0f} steps/s "
        f"(lowest {min(rates):,.0f}, highest {max(rates):,.0f}), "
        f"decision {done.result.decision_ms['mean'] * 1e3:.1f} us mean"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*")
    parser.add_argument("--big", action="store_true")
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    if options.big:
        grid = conav.builtin_map("office", width_m=200.0, height_m=200.0, resolution=0.1)
        print(f"{grid.name}, {grid.cols} x {grid.rows} cells at 0.1 m, 64 robots, 7 m, cell 0.1 m")
        measure(grid, 1, robots=64, radius_m=0.035, cell_m=0.1, max_time_s=60.0)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"  peak memory {peak:,.0f} MiB")
        return
    indoor = [
        conav.builtin_map(name, width_m=25.0, height_m=25.0, resolution=0.1)
        for name in ("office", "cave", "maze")
    ]
    for item in options.maps or indoor:
        name = item if isinstance(item, str) else item.name
        for cell, radius in ((0.1, 0.035), (None, 0.1)):
            print(f"{name}: 2 robots, 7 m, cell {cell or 'default'}, radius {radius} m")
            measure(item, options.repeat, robots=2, seed=3, cell_m=cell, radius_m=radius)


if __name__ == "__main__":
    main()
