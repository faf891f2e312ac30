"""Says how much of their digits angles keep that are computed one from the other.

An equation for an angle has two roots. With ``sure``, a^4 for an amplitude a, and ``apart``, the share of a^2 that its
discriminant is, what the equation is off by, delta, moves the angle by delta / (a sqrt(apart)): at a double root by
sqrt(delta / a). The equations of the angles behind it are off by that much instead of a rounding.

1. The product of a^2 apart over all angles before one is called near: its equation is off by eps / sqrt(near).
2. sure, times (1e9 near)^2 if that is less than 1, is compared with HARDLY_DETERMINED: an amplitude counts as 0 if it is
   less than about thirty times what it is off by.
3. apart, as a signed square, times 1e4 near a^2, or 1e10 near a^2 below 0, if that is less than 1, is compared with COINCIDING
   and COMPLEX. So two roots count as one, and a pair as neither real nor complex for certain, if they are nearer than about
   ten, or a hundred, times what apart is off by.
4. A branch that misses its target is certainly no solution if one of its pairs is certainly complex. If it is in doubt whether
   a pair is complex, the branch stays in doubt, whatever its other angles are.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt, where
from ulna.kernels.chain.closed_form_layout import COMPLEX, LAST, POINTS, UNDETERMINED
from ulna.kernels.spatial.elementary import maximum, minimum

DOUBLE, DOUBLE_OF_QUARTIC = 1e-15, 1e-20  # least apart: what rounding leaves of a double root, and of a threefold one


@kernel
def accuracy(near, sure, apart, least):
    """Steps 1 to 3 for an angle that is one of two: near behind it, and sure and apart, as they are compared."""
    amplitude = near_behind(near, sure)
    compared = apart * abs(apart) * minimum(where(apart < 0.0, 1e10, 1e4) * amplitude, 1.0)
    return amplitude * where(compared < COMPLEX, 1.0, minimum(maximum(apart, least), 1.0)), sure_behind(near, sure), compared


@kernel
def near_behind(near, sure):
    """Step 1 for an angle whose equation has one root; an angle that is given by the caller is not off."""
    return near * minimum(sqrt(where(sure > UNDETERMINED, sure, 1.0)), 1.0)


@kernel
def sure_behind(near, sure):
    """Step 2."""
    share = minimum(1e9 * near, 1.0)
    return sure * share * share


@kernel
def near_base(table):
    """Step 1 for the first angle: where the base is far from the arm, a position is the small difference of large numbers."""
    x, y, z = table[POINTS, 0], table[POINTS, 1], table[POINTS, 2]
    u, v, w = table[LAST, 0], table[LAST, 1], table[LAST, 2]
    return 1.0 / (1.0 + x * x + y * y + z * z + u * u + v * v + w * w)


@kernel
def worse(apart, next_apart):
    """Step 4: of two angles, as ``apart`` is compared."""
    return where((apart < 0.0) & (apart >= COMPLEX), apart, minimum(apart, next_apart))
