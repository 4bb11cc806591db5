"""Equal runs have equal digests: across runs, processes and processors; and only equal runs."""

import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import conav

CASES = (
    {"map": "maze", "robots": 2, "seed": 7, "motion": "8-connected", "radio": "perfect"},
    {"map": "office", "robots": 3, "seed": 7, "motion": "8-connected", "radio": 4.0},
    {"map": "maze", "robots": 3, "seed": 8, "motion": "forward-turn", "radio": "perfect"},
    {"map": "cave", "robots": 3, "seed": 7, "motion": "forward-turn", "radio": 4.0},
)

IN_ANOTHER_PROCESS = """
import sys
sys.path.insert(0, sys.argv[1])
import test_digest
print("\\n".join(test_digest.digests()))
"""


def digest_of(number: int) -> str:
    options = dict(CASES[number])
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        done = conav.explore(options.pop("map"), out=path, **options)  # type: ignore[arg-type]
        assert done.status == "done"
        run = conav.read_run(path)
        assert run.digest == done.result.digest
        return run.digest


def digests() -> list[str]:
    return [digest_of(number) for number in range(len(CASES))]


def elsewhere(**environment: str) -> list[str]:
    result = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS, str(Path(__file__).parent)],
        env={**os.environ, **environment},
        check=True,
        capture_output=True,
        text=True,
    )
    return result.stdout.split()


@cache
def usual() -> list[str]:
    return digests()


def test_repeats() -> None:
    assert len(set(usual())) == len(CASES)
    assert digests() == usual()


def test_the_seed_matters() -> None:
    first = conav.explore("maze", robots=2, seed=7).result.covered
    second = conav.explore("maze", robots=2, seed=8).result.covered
    assert first != second


def test_any_number_of_workers() -> None:
    for workers in (1, 2):
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            assert list(pool.map(digest_of, range(len(CASES)))) == usual()


def test_any_order_of_sets_and_any_number_of_threads() -> None:
    for seed, threads in (("0", "1"), ("4711", "2")):
        there = {"OMP_NUM_THREADS": threads, "NUMBA_NUM_THREADS": threads, "PYTHONHASHSEED": seed}
        assert elsewhere(**there) == usual()


def test_a_plain_processor(tmp_path: Path) -> None:
    """numpy and the compiled kernels without vector features, and another hash seed."""
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    found = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
    masked = {
        "NPY_DISABLE_CPU_FEATURES": " ".join(found),
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "CONAV_CACHE_DIR": str(tmp_path / "kernels"),
        "PYTHONHASHSEED": "12345",
    }
    assert elsewhere(**masked) == usual()
