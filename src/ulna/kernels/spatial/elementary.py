"""Computes minimum, maximum, sine, cosine and two arc tangents, and checks ranges of numbers."""

import math

from ulna.engine.decorators import exact_kernel, kernel
from ulna.engine.lanes import any_lane, load, logical_not, rint, where
from ulna.kernels.layout import LARGEST

_LARGEST_FINITE = 1.7976931348623157e308
_SIN_EIGHTH, _ROOT_HALF = 0.3826834323650898, 0.7071067811865476  # sin(pi / 8), sqrt(1 / 2)


@kernel
def minimum(x, y):
    """The smaller of two numbers."""
    return where(x < y, x, y)


@kernel
def maximum(x, y):
    """The larger of two numbers."""
    return where(x > y, x, y)


@kernel
def clamp(x, limit):
    """The number x clamped to the range from -limit to limit."""
    return minimum(maximum(x, -limit), limit)


@exact_kernel
def sincos(x):
    """Sine and cosine, within about 1 ulp for |x| <= 1e6.

    1. Reduce to |r| <= pi/4 by subtracting k pi/2, with pi/2 in three parts of 33 bits (Cody and Waite).
    2. Evaluate the polynomials of fdlibm's k_sin.c and k_cos.c.
    3. Swap and sign by the quarter turn k mod 4.
    """
    k = rint(x * (2 / math.pi))
    r = ((x - k * 1.57079632673412561417) - k * 6.07710050630396597660e-11) - k * 2.02226624879595063154e-21
    z = r * r
    s = r + r * z * (
        -1.66666666666666324348e-1
        + z * (8.33333333332248946124e-3
        + z * (-1.98412698298579493134e-4
        + z * (2.75573137070700676789e-6
        + z * (-2.50507602534068634195e-8
        + z * 1.58969099521155010221e-10))))
    )  # fmt: skip
    c = 1.0 - (0.5 * z - z * z * (
        4.16666666666666019037e-2
        + z * (-1.38888888888741095749e-3
        + z * (2.48015872894767294178e-5
        + z * (-2.75573143513906633035e-7
        + z * (2.08757232129817482790e-9
        + z * -1.13596475577881948265e-11))))
    ))  # fmt: skip
    quarter = k - 4.0 * rint(0.25 * k - 0.125)  # in -1 .. 2: the offset of 1/8 maps half a turn to 2, never to -2
    sin_is_negative = quarter * quarter - quarter > 1.0  # true for -1 and 2
    cos_is_negative = quarter > 0.5  # true for 1 and 2
    odd = sin_is_negative ^ cos_is_negative
    sin_sign, cos_sign = where(sin_is_negative, -1.0, 1.0), where(cos_is_negative, -1.0, 1.0)
    return where(odd, c, s) * sin_sign, where(odd, s, c) * cos_sign


@kernel
def first_quadrant_angle(y, x):
    """The angle atan2(y, x) in [0, pi/2] for x, y >= 0, not both zero, within 2 ulp.

    Reflection and rotation by an eighth of a turn bring the tangent below tan(pi/8). Then the rational approximation of Cephes'
    atan.c (Moshier) is evaluated.
    """
    steep = y > x
    t = where(steep, x, y) / where(steep, y, x)  # in [0, 1]
    turned = t > 0.41421356237309503
    u = where(turned, (t - 1.0) / (t + 1.0), t)
    z = u * u
    p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z
         - 1.228866684490136173410e2) * z - 6.485021904942025371773e1  # fmt: skip
    q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z
         + 4.853903996359136964868e2) * z + 1.945506571482613964425e2  # fmt: skip
    angle = u + u * z * p / q + where(turned, math.pi / 4, 0.0)
    return where(steep, math.pi / 2 - angle, angle)


@kernel
def full_circle_angle(s, c):
    """The angle in [-pi, pi] with sine s and cosine c, within 2 ulp of pi.

    Up to rounding s^2 + c^2 must be 1.

    1. Reflect into the first octant, and rotate angles in its second half by an eighth of a turn: |u| <= sin(pi/8).
    2. Evaluate asin(u) = u + u z P(z), z = u^2. P interpolates (asin(u) / u - 1) / z at the ten Chebyshev nodes of
       0 <= z <= sin(pi/8)^2. The relative error of asin(u) is at most 2.2e-17.
    3. Undo step 1.
    """
    y, x = abs(s), abs(c)
    steep = y > x
    low, high = where(steep, x, y), where(steep, y, x)
    tilted = low > _SIN_EIGHTH
    u = where(tilted, (low - high) * _ROOT_HALF, low)
    z = u * u
    angle = where(tilted, math.pi / 4, 0.0) + (u + u * z * (
        0.16666666666666655
        + z * (0.07500000000017083
        + z * (0.04464285710448711
        + z * (0.030381947777332136
        + z * (0.022372012607820138
        + z * (0.01735644410070623
        + z * (0.013908985887225864
        + z * (0.012070112265967884
        + z * (0.006925299097327478
        + z * 0.016467470525365784)))))))))
    )  # fmt: skip
    angle = where(steep, math.pi / 2 - angle, angle)
    angle = where(c < 0.0, math.pi - angle, angle)
    return where(s < 0.0, -angle, angle)


@kernel
def all_finite(x_rows):
    """Whether every number is finite, for at least one number."""
    good = abs(load(x_rows, 0)) <= _LARGEST_FINITE
    for i in range(1, x_rows.shape[0]):
        good = good & (abs(load(x_rows, i)) <= _LARGEST_FINITE)
    return not any_lane(logical_not(good))


@kernel
def all_in_range(x_rows):
    """Whether every number is finite and at most LARGEST in magnitude."""
    if x_rows.shape[0] == 0:
        return True
    good = abs(load(x_rows, 0)) <= LARGEST
    for i in range(1, x_rows.shape[0]):
        good = good & (abs(load(x_rows, i)) <= LARGEST)
    return not any_lane(logical_not(good))
