"""The eccentricity bound: the last cells a share needs are far from every start."""

import numpy as np
from numpy.typing import NDArray

from conav.exploration.bounds.views import Survey


def eccentricity_steps(survey: Survey, observable: NDArray[np.uint8], needed: int) -> float:
    """The step before which fewer than `needed` cells can have been seen; inf for never.

    Whoever sees `needed` cells sees one whose earliest step is not below the `needed`-th smallest.
    """
    if needed <= 0:
        return 0.0
    first = survey.first[observable.reshape(-1) == 1]
    return float(np.partition(first, needed - 1)[needed - 1])
