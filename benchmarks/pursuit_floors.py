"""What clearing takes on all published floor plans and maps: docs/pursuit.md, Measured.

    python benchmarks/pursuit_floors.py --out floors.jsonl          # goes on where it was stopped
    python benchmarks/pursuit_floors.py --out floors.jsonl --table  # what the journal has

Floors are those of the folder CONAV_DATA: `floorplans` and `agp` as they are, and grid maps of
`maps`, polygonised, with `--maps`. A floor that takes more than `--limit` seconds of processor time
ends the process that works on it, and another one goes on with the next. What is found out about a
floor goes to the journal, a line when it is planned and another when it is verified. Times leave
out what compiling takes: a small floor comes first.
"""

import argparse
import json
import multiprocessing
import os
import resource
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from conav.errors import InputError
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import Polygonising
from conav.maps.read_floor_plan import FloorPlanReading
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem
from conav.pursuit.verify import verify_schedule

SUFFIXES = {"floorplans": (".json", ".geojson"), "agp": (".pol", ".environment")}


def floors(data: Path, *, maps: bool) -> list[str]:
    """Files by their names in the data folder, floor plans before maps, small files first."""
    plans: list[Path] = []
    for folder, suffixes in SUFFIXES.items():
        plans += [path for path in (data / folder).rglob("*") if path.suffix in suffixes]
    grids: list[Path] = []
    for path in (data / "maps").rglob("*") if maps else ():
        bare = "images_only" in path.parts and path.suffix in (".png", ".pgm")
        if path.suffix == ".yaml" or bare:
            grids.append(path)
    found = [
        sorted(paths, key=lambda path: (path.stat().st_size, path)) for paths in (plans, grids)
    ]
    return [str(path.relative_to(data)) for path in (*found[0], *found[1])]


def work(data: Path, names: list[str], out: Path, limit: int, tolerance: float) -> None:
    """Clear these floors and write about them, until one takes too long and ends the process."""
    clear(load_floor_plan("spider:2,2,2"), lambda _: None)
    for name in names:

        def write(found: dict[str, Any], name: str = name) -> None:
            with out.open("a") as journal:
                journal.write(json.dumps({"floor": name} | found) + "\n")

        soft = int(process_time()) + limit
        resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.RLIM_INFINITY))
        resolution = 0.05 if "images_only" in name else None
        cells = Polygonising(tolerance=tolerance)
        try:
            floor = load_floor_plan(
                str(data / name), FloorPlanReading(resolution=resolution, cells=cells)
            )
        except InputError as error:
            write({"status": "refused", "reason": str(error)})
            continue
        write({"vertices": len(floor.vertices), "holes": len(floor.holes)})
        clear(floor, write)


def clear(floor: PolygonMap, write: Callable[[dict[str, Any]], None]) -> None:
    """Plan and verify, and write about both."""
    problem = PursuitProblem(floor, (Pursuer("pursuer_1", default_start(floor)),))
    begin = process_time()
    result = ClearKnownMap().solve(problem)
    write(
        {
            "status": str(result.status),
            "pursuers": len(result.pursuers),
            "lower_bound": result.lower_bound,
            "moves": len(result.schedule.active),
            "distance_m": round(result.schedule.distance_m, 3),
            "plan_s": round(process_time() - begin, 2),
        }
    )
    if result.status == "done":
        begin = process_time()
        found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
        write({"verdict": str(found.verdict), "verify_s": round(process_time() - begin, 2)})


def read(out: Path) -> dict[str, dict[str, Any]]:
    """What a journal has about each floor."""
    known: dict[str, dict[str, Any]] = {}
    for line in out.read_text().splitlines() if out.exists() else ():
        found = json.loads(line)
        known.setdefault(found["floor"], {}).update(found)
    return known


def table(lines: list[dict[str, Any]]) -> None:
    """Print the journal by kind and size of floors."""
    groups = (("up to 120", 0, 120), ("121 to 500", 121, 500), ("more", 501, 10**9))
    print("| floors | corners | number | cleared and verified | proved fewest | pursuers | plan, "
          "median | 90 % | longest |")  # fmt: skip
    for kind in ("agp", "floorplans", "maps"):
        for words, least, most in groups:
            chosen = [
                one
                for one in lines
                if one["floor"].startswith(kind) and least <= one.get("vertices", -1) <= most
            ]
            done = [one for one in chosen if one.get("verdict") == "captured"]
            if not chosen:
                continue
            proved = sum(one["pursuers"] == one["lower_bound"] for one in done)
            sizes = [one["pursuers"] for one in done]
            times = np.array([one.get("plan_s", np.inf) for one in chosen])
            middle, high = np.quantile(times, (0.5, 0.9), method="higher")
            team = f"{min(sizes)} to {max(sizes)}" if sizes else "-"
            print(
                f"| {kind} | {words} | {len(chosen)} | {len(done)} | {proved} | {team} | "
                f"{middle:.1f} s | {high:.1f} s | {times.max():.1f} s |"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description="Clearing all published floors")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--limit", type=int, default=120, help="seconds of processor time a floor")
    parser.add_argument("--maps", action="store_true", help="grid maps too")
    parser.add_argument("--tolerance", type=float, default=0.0, help="of grid maps' walls [m]")
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    out: Path = arguments.out
    if arguments.table:
        table(list(read(out).values()))
        return
    data = Path(os.environ["CONAV_DATA"])
    spawn = multiprocessing.get_context("spawn")
    while True:
        known = read(out)
        left = [name for name in floors(data, maps=arguments.maps) if name not in known]
        if not left:
            break
        job = (data, left, out, arguments.limit, arguments.tolerance)
        process = spawn.Process(target=work, args=job)
        process.start()
        process.join()
        if read(out).keys() == known.keys():
            raise SystemExit(f"nothing came of {left[0]}")


if __name__ == "__main__":
    main()
