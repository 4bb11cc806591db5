"""No traffic rule: robots pass through each other, as in papers that do without one."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import STAY
from conav.simulation.traffic import able_and_wanted, carry_out


@kernel
def pass_through(
    cells: NDArray[np.int32],
    wish: NDArray[np.int8],
    ways: NDArray[np.uint8],
    width: int,
    heading: NDArray[np.int8],
    turning: NDArray[np.uint8],
    rate: NDArray[np.float64],
    credit: NDArray[np.float64],
    travelled: NDArray[np.float64],
    outcome: NDArray[np.uint8],
) -> int:
    """The number of robots that moved: every robot makes the move it wants.

    Parameters as in `conav.simulation.traffic.resolve`; all else, speed and turning, is as there.
    """
    n = cells.shape[0]
    able = np.zeros(n, dtype=np.uint8)
    wanted = np.empty(n, dtype=np.int8)
    nobody = np.full(n, STAY, dtype=np.int8)
    chosen = np.full(n, STAY, dtype=np.int8)
    able_and_wanted(wish, ways, rate, credit, able, wanted)
    for i in range(n):
        k = wanted[i]
        if k < 0 or (able[i] >> (1 if k >= 4 else 0)) & 1 == 0:
            continue
        if turning[i] == 0 or (k < 4 and heading[i] == k):
            chosen[i] = k
    return carry_out(
        chosen,
        nobody,
        wanted,
        able,
        width,
        rate,
        turning,
        cells,
        heading,
        credit,
        travelled,
        outcome,
    )
