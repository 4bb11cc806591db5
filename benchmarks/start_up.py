"""Start-up times as whole processes: the figures of docs/performance.md.

python benchmarks/start_up.py
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

REPEAT = 9


def wall(command: list[str], **environment: str) -> float:
    start = perf_counter()
    subprocess.run(
        command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, **environment}
    )
    return perf_counter() - start


def show(what: str, times: list[float]) -> None:
    print(
        f"{what}: median {statistics.median(times):.3f} s "
        f"(lowest {min(times):.3f}, highest {max(times):.3f}, {len(times)} runs)"
    )


def main() -> None:
    python = sys.executable
    for what, command in (
        ("python -c pass", [python, "-c", "pass"]),
        ("import conav", [python, "-c", "import conav"]),
        ("conav --help", [python, "-m", "conav", "--help"]),
    ):
        wall(command)
        show(what, [wall(command) for _ in range(REPEAT)])
    explore = [python, "-m", "conav", "explore", "three-obstacles", "--quiet"]
    with tempfile.TemporaryDirectory() as folder:
        kernels = str(Path(folder) / "cache")
        cold = wall(explore, CONAV_CACHE_DIR=kernels)
        files = sum(1 for path in Path(kernels).rglob("*.nbc"))
        warm = [wall(explore, CONAV_CACHE_DIR=kernels) for _ in range(REPEAT)]
        again = sum(1 for path in Path(kernels).rglob("*.nbc"))
    print(f"conav explore three-obstacles, compiling {files} kernels: {cold:.2f} s")
    show(f"the same again, {again - files} kernels compiled", warm)


if __name__ == "__main__":
    main()
