"""On which side of a line a point lies, and where lines cross: exact signs.

A float filter answers nearly always; where its error bound [Shewchuk1997] leaves doubt, expansion
arithmetic answers. Signs are right for all doubles that are zero or of magnitude 1e-60 to 1e60
(`LEAST` and `GREATEST`): beyond, products of products under- or overflow.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.expansions import (
    grow_by_product,
    grow_by_products,
    sign_of,
    two_product,
    two_sum,
)

LEAST = 1e-60  # [m] least magnitude of a coordinate that is not zero
GREATEST = 1e60  # [m] greatest magnitude of a coordinate

HALF_ULP = 1.1102230246251565e-16  # 2^-53
TURN_ERROR = (3.0 + 16.0 * HALF_ULP) * HALF_ULP
CIRCLE_ERROR = (10.0 + 96.0 * HALF_ULP) * HALF_ULP


@kernel
def orientation(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> int:
    """1 where c lies left of the line from a to b, -1 right of it, 0 on it. Exact."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    value = left - right
    limit = TURN_ERROR * (abs(left) + abs(right))
    if value > limit:
        return 1
    if -value > limit:
        return -1
    return _doubtful_orientation(ax, ay, bx, by, cx, cy)


@kernel
def _doubtful_orientation(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> int:
    # On maps of round numbers the differences are exact, and the two products decide.
    acx, low0 = two_sum(ax, -cx)
    bcy, low1 = two_sum(by, -cy)
    acy, low2 = two_sum(ay, -cy)
    bcx, low3 = two_sum(bx, -cx)
    if low0 == 0.0 and low1 == 0.0 and low2 == 0.0 and low3 == 0.0:
        left, left_low = two_product(acx, bcy)
        right, right_low = two_product(acy, bcx)
        if left != right:
            return 1 if left > right else -1
        if left_low != right_low:
            return 1 if left_low > right_low else -1
        return 0
    expansion = np.empty(12)
    return sign_of(expansion, orientation_expansion(expansion, ax, ay, bx, by, cx, cy))


@kernel
def orientation_expansion(
    out: NDArray[np.float64], ax: float, ay: float, bx: float, by: float, cx: float, cy: float
) -> int:
    """The count of the exact (a - c) x (b - c), twice the area of abc, written to `out` (12,)."""
    # In loops, not written out: every kernel that asks for a side compiles this.
    count = 0
    px, py = cx, cy
    qx, qy = ax, ay
    for _ in range(3):
        count = grow_by_product(out, count, px, qy)
        count = grow_by_product(out, count, -py, qx)
        px, py, qx, qy, ax, ay = qx, qy, bx, by, bx, by
        bx, by = cx, cy
    return count


@kernel
def _rounded_orientation(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float
) -> tuple[float, float]:
    """(a - c) x (b - c) and a bound on its error."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    return left - right, TURN_ERROR * (abs(left) + abs(right))


@kernel
def orientation_products(
    points: NDArray[np.float64],
    a: tuple[int, int, int],
    b: tuple[int, int, int],
    c: tuple[int, int, int],
    d: tuple[int, int, int],
) -> int:
    """The exact sign of A * B - C * D, orientations of three rows of `points` each.

    With it crossings of lines through points are compared without being computed: see
    `conav.geometry.crossings`.
    """
    va, ea = _rounded_orientation(*_three(points, a))
    vb, eb = _rounded_orientation(*_three(points, b))
    vc, ec = _rounded_orientation(*_three(points, c))
    vd, ed = _rounded_orientation(*_three(points, d))
    value = va * vb - vc * vd
    limit = abs(va) * eb + abs(vb) * ea + ea * eb + abs(vc) * ed + abs(vd) * ec + ec * ed
    # Generous: the roundings of the limit, the products and the difference.
    limit = limit * (1.0 + 64.0 * HALF_ULP) + 8.0 * HALF_ULP * (abs(va * vb) + abs(vc * vd))
    if value > limit:
        return 1
    if -value > limit:
        return -1
    first = np.empty(12)
    second = np.empty(12)
    total = np.empty(576)
    count = 0
    sign = 1.0
    one, other = a, b
    for _ in range(2):
        n = orientation_expansion(first, *_three(points, one))
        m = orientation_expansion(second, *_three(points, other))
        count = grow_by_products(total, count, first, n, second, m, sign)
        sign = -1.0
        one, other = c, d
    return sign_of(total, count)


@kernel
def _three(
    points: NDArray[np.float64], rows: tuple[int, int, int]
) -> tuple[float, float, float, float, float, float]:
    a, b, c = rows
    return (points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1])


@kernel
def direction_turn(points: NDArray[np.float64], a: int, b: int, c: int, d: int) -> int:
    """1 where the direction from c to d points left of that from a to b, -1 right, 0 neither.

    a, b, c, d are rows of `points`. Exact.
    """
    ax, ay = points[a, 0], points[a, 1]
    bx, by = points[b, 0], points[b, 1]
    cx, cy = points[c, 0], points[c, 1]
    dx, dy = points[d, 0], points[d, 1]
    left = (bx - ax) * (dy - cy)
    right = (by - ay) * (dx - cx)
    value = left - right
    limit = TURN_ERROR * (abs(left) + abs(right))
    if value > limit:
        return 1
    if -value > limit:
        return -1
    expansion = np.empty(16)
    count = 0
    for first, u, v in ((1.0, bx, by), (-1.0, ax, ay)):
        for second, s, t in ((1.0, dx, dy), (-1.0, cx, cy)):
            count = grow_by_product(expansion, count, first * second * u, t)
            count = grow_by_product(expansion, count, -first * second * v, s)
    return sign_of(expansion, count)


@kernel
def surely_in_circle(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> bool:
    """Whether d surely lies inside the circle through a, b, c (counter-clockwise).

    The filter alone, without an exact fallback: `False` where rounding leaves doubt. Edge flips
    under it raise a convex surface each time, so they end, and four points on a circle stay as
    they are.
    """
    adx = ax - dx
    ady = ay - dy
    bdx = bx - dx
    bdy = by - dy
    cdx = cx - dx
    cdy = cy - dy
    lift_a = adx * adx + ady * ady
    lift_b = bdx * bdx + bdy * bdy
    lift_c = cdx * cdx + cdy * cdy
    bc = bdx * cdy
    cb = cdx * bdy
    ca = cdx * ady
    ac = adx * cdy
    ab = adx * bdy
    ba = bdx * ady
    value = lift_a * (bc - cb) + lift_b * (ca - ac) + lift_c * (ab - ba)
    size = (
        (abs(bc) + abs(cb)) * lift_a + (abs(ca) + abs(ac)) * lift_b + (abs(ab) + abs(ba)) * lift_c
    )
    return value > CIRCLE_ERROR * size
