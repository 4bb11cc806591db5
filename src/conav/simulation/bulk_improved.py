"""Games of the improved algorithm in bulk: the twin of `conav.exploration.potential_improved`.

Beside the numbers of undiscovered points around each place, of `conav.simulation.bulk_potential`,
every point has a state: unknown, discovered, or left out. A point that robots see in the same step
is discovered when one of them adds it.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.turn_sequences import in_range
from conav.simulation.bulk_choice import best_of_four
from conav.simulation.bulk_random import next_double, next_quarter, seed_generator

OFF_MAP = 2
_UNKNOWN = 0
_DISCOVERED = 1
_LEFT_OUT = 2


@kernel
def _near_predicted(
    predicted: NDArray[np.int64], i: int, limits: NDArray[np.int32], place: int, width: int
) -> bool:
    """Whether a place is within range of a position robot i has predicted for the others."""
    near = False
    for k in range(predicted.shape[1]):
        other = predicted[i, k]
        if other >= 0:
            near = near or in_range(
                limits, other // width - place // width, other % width - place % width
            )
    return near


@kernel
def _count(
    state: NDArray[np.uint8],
    predicted: NDArray[np.int64],
    i: int,
    limits: NDArray[np.int32],
    width: int,
    place: int,
    offsets: NDArray[np.int64],
) -> int:
    """The points of an area around a place that are not discovered and left to robot i."""
    found = 0
    for j in range(offsets.shape[0]):
        p = place + offsets[j]
        if state[p] != _DISCOVERED and not _near_predicted(predicted, i, limits, p, width):
            found += 1
    return found


@kernel
def play_improved(
    seeds: NDArray[np.uint64],
    names: NDArray[np.uint64],
    starts: NDArray[np.int64],
    walls: NDArray[np.uint8],
    free: NDArray[np.uint8],
    limits: NDArray[np.int32],
    pad: int,
    width: int,
    disc: NDArray[np.int64],
    crescent: NDArray[np.int64],
    cols: int,
    steps: int,
    epsilon: float,
    baseline_wins: bool,
    per_sequence: bool,
    covered: NDArray[np.uint32],
    decisions: NDArray[np.int64],
    turns: NDArray[np.int64],
    free_steps: NDArray[np.int64],
    discovered: NDArray[np.int64],
    left_out: NDArray[np.int64],
    trace: NDArray[np.int32],
    faced: NDArray[np.int8],
) -> None:
    """Play the games; parameters as in `conav.simulation.bulk_potential`."""
    n = names.shape[0]
    size = walls.shape[0]
    ahead_of = np.array([1, width, -1, -width])
    around = np.zeros(size, dtype=np.int32)
    for p in range(size):
        if walls[p] != OFF_MAP:
            for j in range(disc.shape[0]):
                around[p + disc[j]] += 1
    state = np.zeros(size, dtype=np.uint8)
    left = np.zeros(size, dtype=np.int32)  # points within range of each place not discovered
    states = np.zeros((n, 4), dtype=np.uint64)
    at = np.zeros(n, dtype=np.int64)
    heading = np.zeros(n, dtype=np.int64)
    old_at = np.zeros(n, dtype=np.int64)
    old_heading = np.zeros(n, dtype=np.int64)
    bound = np.zeros(n, dtype=np.uint8)
    predicted = np.zeros((n, 2 * n), dtype=np.int64)
    predicted_at = np.zeros(n, dtype=np.int64)
    # Marks of what was added or left out in a step, for all robots at once.
    changed = np.zeros(n * disc.shape[0], dtype=np.int64)
    added = np.zeros(n * disc.shape[0], dtype=np.uint8)
    for game in range(seeds.shape[0]):
        left[:] = around
        for p in range(size):
            state[p] = _DISCOVERED if walls[p] == OFF_MAP else _UNKNOWN
        total = 0
        for i in range(n):
            seed_generator(seeds[game], names[i], states, i)
            heading[i] = next_quarter(states, i)
            at[i] = (starts[i] // cols + pad) * width + starts[i] % cols + pad
            bound[i] = 0
            predicted_at[i] = -3
        for step in range(steps + 1):
            changes = 0
            for i in range(n):
                if left[at[i]] == 0:
                    continue
                for j in range(disc.shape[0]):
                    p = at[i] + disc[j]
                    if state[p] != _DISCOVERED:
                        out = step - predicted_at[i] <= 2 and _near_predicted(
                            predicted, i, limits, p, width
                        )
                        if not out:
                            discovered[game, i] += 1
                        changed[changes] = p
                        added[changes] = 0 if out else 1
                        changes += 1
            for k in range(changes):
                p = changed[k]
                if state[p] == _UNKNOWN:
                    total += free[p]
                    state[p] = _LEFT_OUT
            for k in range(changes):
                p = changed[k]
                if added[k] == 1 and state[p] != _DISCOVERED:
                    state[p] = _DISCOVERED
                    for j in range(disc.shape[0]):
                        left[p + disc[j]] -= 1
            covered[game, step] = total
            if trace.shape[1] > 0:
                for i in range(n):
                    trace[game, step, i] = (at[i] // width - pad) * cols + at[i] % width - pad
                    faced[game, step, i] = heading[i]
            if step == steps:
                break
            old_at[:] = at
            old_heading[:] = heading
            for i in range(n):
                here = at[i]
                forward = ahead_of[heading[i]]
                ahead = walls[here + forward] == 0
                if bound[i] == 1 and ahead:
                    bound[i] = 0
                    at[i] += forward
                    continue
                bound[i] = 0
                free_steps[game] += 1
                turn = 0
                if not ahead or (step > 0 and next_double(states, i) < epsilon):
                    decisions[game] += 1
                    predicted_at[i] = step
                    for other in range(n):
                        predicted[i, 2 * other] = -1
                        predicted[i, 2 * other + 1] = -1
                        if other == i:
                            continue
                        p = old_at[other]
                        for k in range(2):
                            q = p + ahead_of[old_heading[other]]
                            # It stops at what is known to be an obstacle.
                            if walls[q] == 0 or (walls[q] == 1 and state[q] == _UNKNOWN):
                                p = q
                            predicted[i, 2 * other + k] = p
                    gain0 = -1
                    if ahead:
                        p = here + forward
                        gain0 = _count(state, predicted, i, limits, width, p, disc)
                        p += forward
                        if walls[p] == 0 or (walls[p] == 1 and state[p] == _UNKNOWN):
                            gain0 += _count(
                                state, predicted, i, limits, width, p, crescent[heading[i]]
                            )
                    gain1 = -1
                    gain2 = -1
                    gain3 = -1
                    for t in range(1, 4):
                        d = (heading[i] + t) & 3
                        p = here + ahead_of[d]
                        gain = -1
                        if walls[p] == 0:
                            gain = 0
                            if left[p] > 0:
                                gain = _count(state, predicted, i, limits, width, p, disc)
                            if left[here] > 0:
                                # Left out points that only the first step, in place, has in range.
                                gain += _count(
                                    state, predicted, i, limits, width, here, crescent[(d + 2) & 3]
                                )
                        if t == 1:
                            gain1 = gain
                        elif t == 2:
                            gain2 = gain
                        else:
                            gain3 = gain
                    turn = best_of_four(gain0, gain1, gain2, gain3, baseline_wins, states, i)
                if turn == 0 and ahead:
                    at[i] += forward
                if turn > 0:
                    heading[i] = (heading[i] + turn) & 3
                    turns[game] += 1
                bound[i] = 1 if turn > 0 or (turn == 0 and per_sequence) else 0
        for p in range(size):
            if state[p] == _LEFT_OUT:
                left_out[game] += free[p]
