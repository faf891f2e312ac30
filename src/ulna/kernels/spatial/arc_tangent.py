"""Computes the angle of a sine and a cosine, without a division."""

import math

from ulna.engine.decorators import kernel
from ulna.engine.lanes import where

_SIN_EIGHTH, _ROOT_HALF = 0.3826834323650898, 0.7071067811865476  # sin(pi / 8), sqrt(1 / 2)


@kernel
def full_circle_angle(s, c):
    """The angle in [-pi, pi] whose sine is s and whose cosine is c, with s^2 + c^2 = 1 to rounding: within 2 ulp of pi.

    1. Reflect into the first octant, and turn by an eighth of a turn what lies beyond half of it: |u| <= sin(pi/8).
    2. Evaluate asin(u) = u + u z P(z), z = u^2. P interpolates (asin(u) / u - 1) / z at the ten Chebyshev nodes of
       0 <= z <= sin(pi/8)^2, and misses asin(u) by at most 2.2e-17 of it.
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
