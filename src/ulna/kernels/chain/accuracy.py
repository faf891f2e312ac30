"""Estimates the accuracy of angles that are computed one from the other.

An equation for an angle has two roots. Its amplitude is a. Three numbers describe its accuracy:

- the determination a^4;
- the separation s of the roots: the discriminant as a share of a^2;
- the conditioning c: the product of a^2 s over all previous angles.

An error delta of the equation moves the angle by delta / (a sqrt(s)), and at a double root by sqrt(delta / a). The equations of
the next angles then have an error of that size instead of a rounding.

1. The error of the equation is eps / sqrt(c).
2. The determination is multiplied by (1e9 c)^2 if that is less than 1, and compared with HARDLY_DETERMINED. So an amplitude
   counts as 0 if it is less than about thirty times its error.
3. The separation s is negative if the roots are complex. Its square with the sign of s, s |s|, is multiplied by ``1e4 c a^2``, or
   by ``1e10 c a^2`` if s is negative. A factor above 1 is replaced by 1. The product is compared with COINCIDING and COMPLEX. So
   two roots count as one if they are nearer than about ten times the error of the separation. Within about a hundred times the
   error, a pair is neither certainly real nor certainly complex.
4. A branch that misses its target is certainly no solution if one of its pairs is certainly complex. If it is in doubt whether a
   pair is complex, the branch stays in doubt, whatever its other angles are.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt, where
from ulna.kernels.chain.closed_form_layout import COMPLEX, LAST, POINTS, UNDETERMINED
from ulna.kernels.spatial.elementary import maximum, minimum

DOUBLE, DOUBLE_OF_QUARTIC = 1e-15, 1e-20  # minimum of the separation: the rounding of a double root, and of a threefold one


@kernel
def accuracy(conditioning, determination, separation, min_separation):
    """Steps 1 to 3 for an angle with two roots: the next conditioning; the compared determination and separation."""
    amplitude = next_conditioning(conditioning, determination)
    compared = separation * abs(separation) * minimum(where(separation < 0.0, 1e10, 1e4) * amplitude, 1.0)
    return (
        amplitude * where(compared < COMPLEX, 1.0, minimum(maximum(separation, min_separation), 1.0)),
        compared_determination(conditioning, determination),
        compared,
    )


@kernel
def next_conditioning(conditioning, determination):
    """Step 1 for an angle whose equation has one root. An angle given by the caller has no error."""
    return conditioning * minimum(sqrt(where(determination > UNDETERMINED, determination, 1.0)), 1.0)


@kernel
def compared_determination(conditioning, determination):
    """Step 2: the compared value of the determination."""
    share = minimum(1e9 * conditioning, 1.0)
    return determination * share * share


@kernel
def base_conditioning(table):
    """Step 1 for the first angle.

    If the base is far from the arm, a position is a small difference of large numbers.
    """
    x, y, z = table[POINTS, 0], table[POINTS, 1], table[POINTS, 2]
    u, v, w = table[LAST, 0], table[LAST, 1], table[LAST, 2]
    return 1.0 / (1.0 + x * x + y * y + z * z + u * u + v * v + w * w)


@kernel
def worse_separation(separation, next_separation):
    """Step 4: the worse of two angles' compared separations."""
    return where((separation < 0.0) & (separation >= COMPLEX), separation, minimum(separation, next_separation))
