"""Computes the angle of a sine and a cosine, with one division. Used by ``chain.subproblems``."""

import math

from ulna.engine.decorators import kernel
from ulna.engine.lanes import where

_TAN_EIGHTH = 0.41421356237309503  # tan(pi / 8)


@kernel
def full_circle_angle(s, c):
    """The angle in [-pi, pi] whose sine and cosine are in the ratio of s and c, not both zero: atan2, within 2 ulp of pi.

    1. Reflect into the first octant, and turn by an eighth of a turn what lies beyond half of it: |u| <= tan(pi/8).
    2. Evaluate the polynomial of fdlibm's s_atan.c for arguments below 7/16.
    3. Undo step 1.
    """
    y, x = abs(s), abs(c)
    steep = y > x
    low, high = where(steep, x, y), where(steep, y, x)
    turned = low > _TAN_EIGHTH * high
    u = where(turned, low - high, low) / where(turned, low + high, high)
    z = u * u
    angle = where(turned, math.pi / 4, 0.0) + (u - u * z * (
        3.33333333333329318027e-1
        + z * (-1.99999999998764832476e-1
        + z * (1.42857142725034663711e-1
        + z * (-1.11111104054623557880e-1
        + z * (9.09088713343650656196e-2
        + z * (-7.69187620504482999495e-2
        + z * (6.66107313738753120669e-2
        + z * (-5.83357013379057348645e-2
        + z * (4.97687799461593236017e-2
        + z * (-3.65315727442169155270e-2
        + z * 1.62858201153657823623e-2))))))))))
    )  # fmt: skip
    angle = where(steep, math.pi / 2 - angle, angle)
    angle = where(c < 0.0, math.pi - angle, angle)
    return where(s < 0.0, -angle, angle)
