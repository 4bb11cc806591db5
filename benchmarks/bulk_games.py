"""Robot-steps a second of potential games played in bulk, on one core.

Three robots, 40 x 40 points, three obstacles, sRange 2, games of 2,000 steps from seeding to the
coverage curve. Prints the median and the spread over repetitions.
"""

import argparse
from statistics import median
from time import perf_counter

from conav.exploration.catalogue import make_strategy
from conav.simulation.bulk_potential import play_games
from conav.simulation.explore import exploration_problem

STEPS = 2000
ROBOTS = 3
TEAMS = (
    ("potential", {"epsilon": 0.1}),
    ("potential", {"epsilon": 0.3}),
    ("potential", {"epsilon": 0.1, "tie": "baseline"}),
    ("better-response", {"epsilon": 0.1}),
    ("uncoordinated", {}),
    ("potential-improved", {"epsilon": 0.1}),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("--games", type=int, default=1000)
    options = parser.parse_args()
    problem, _ = exploration_problem(
        "three-obstacles",
        robots=ROBOTS,
        range_m=2.0,
        cell_m=1.0,
        speed_mps=1.0,
        motion="forward-turn",
        sensor="disc",
        traffic="none",
        starts=[(1.5, 1.5), (2.5, 1.5), (1.5, 2.5)],
    )
    print("million robot-steps a second: median (lowest to highest)")
    for name, settings in TEAMS:
        strategy = make_strategy(name, settings)
        play_games(problem, strategy, range(2), STEPS)  # compiles
        rates: list[float] = []
        for repetition in range(options.repeat):
            seeds = range(repetition * options.games, (repetition + 1) * options.games)
            start = perf_counter()
            play_games(problem, strategy, seeds, STEPS)
            rates.append(options.games * STEPS * ROBOTS / (perf_counter() - start) / 1e6)
        text = " ".join(f"{key}={value}" for key, value in settings.items())
        print(f"{name:20}{text:28}{median(rates):6.1f} ({min(rates):.1f} to {max(rates):.1f})")


if __name__ == "__main__":
    main()
