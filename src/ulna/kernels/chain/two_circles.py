"""Finds the pairs of plane unit vectors x and y with ``y = u - B x``, up to four.

This is subproblem 6 of Elias and Wen (IK-Geo, 2022, section 3): two equations linear in the sines and cosines of two angles. They
solve a quartic; here its geometry is used: the image of one circle, an ellipse, meets another circle. The angle of x is theta.

1. Choose axes along which B'B is diagonal. There |u - B x|^2 - 1 = k + a cos + b sin + d cos 2 theta, with d >= 0; it is
   divided by its size.
2. Add lambda (cos^2 + sin^2 - 1), which is 0. For a root lambda of a cubic the sum is a product of two lines (the resolvent of
   Ferrari's solution of the quartic). The cubic is >= 0 at -d and <= 0 at d, so it has a root between. The lines are real there:
   alpha cos -+ beta sin + (n_a +- n_b) = 0; alpha^2 = lambda + d; beta^2 = d - lambda; n_a = a / (2 alpha); n_b = b / (2 beta);
   n_a^2 - n_b^2 = k - lambda. Newton's method within the bracket finds the root.
3. Each line meets the circle in two points (subproblem 4). One sign chooses the line, one the point.
4. Newton steps on the equation of step 1 restore the digits lost by ill-conditioned lines.
5. Rounding changes the number of roots only if it moves the equation of step 1 across an equation with a double root. Both lines
   are normalized. Then the equation's discriminant is the product of the lines' discriminants and the square of the lines'
   resultant. A line certainly misses the circle in two cases. In the first, the line's discriminant times the square of the
   resultant exceeds the error of the equation. In the second, both lines miss the circle, and the product of their discriminants
   exceeds the error. This product is a lower bound of the equation's left side for every angle. If all roots are within a small
   angle r, the test is made for the angle divided by r. Discriminants are then divided by r^2, and the resultant and the error by
   r^4.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt, where
from ulna.kernels.chain.subproblems import angles_of_two, one_of_two
from ulna.kernels.spatial.elementary import maximum, minimum

_STEPS, _NEWTON_STEPS = 40, 3
_STRAIGHT = 1e-13  # of d: below it there is only one line
_DAMPING = 1e-16  # of the square of a slope: at a double root value and slope are rounding, and so is their ratio
_FOUND = 1e-14  # value of step 1 before the last step, above which the line is not accurate enough
_FAR = 1e-4  # rad: a longer Newton step does not lead to this root
_CERTAIN = 10.0  # times the error of the equation
_MEETS = -1e-10  # of the discriminant: a line that misses the circle has no root, and Newton steps would find another line's root


@kernel
def pencil(u, b_1, b_2):
    """Steps 1 and 2: the axes (cos and sin), (k, a, b, d), (alpha, beta, n_a, n_b), and the size.

    b_1, b_2: The columns of B.
    """
    g_11, g_12, g_22 = b_1[0] * b_1[0] + b_1[1] * b_1[1], b_1[0] * b_2[0] + b_1[1] * b_2[1], b_2[0] * b_2[0] + b_2[1] * b_2[1]
    e = 0.5 * (g_11 - g_22)
    d = sqrt(e * e + g_12 * g_12)
    share = where(d > 0.0, e / where(d > 0.0, d, 1.0), 1.0)
    larger = sqrt(0.5 + 0.5 * abs(share))
    smaller = 0.5 * where(d > 0.0, g_12 / where(d > 0.0, d, 1.0), 0.0) / larger
    cos = where(share >= 0.0, larger, abs(smaller))
    sin = where(share >= 0.0, smaller, where(smaller >= 0.0, larger, -larger))
    w_1, w_2 = u[0] * b_1[0] + u[1] * b_1[1], u[0] * b_2[0] + u[1] * b_2[1]
    k = u[0] * u[0] + u[1] * u[1] - 1.0 + 0.5 * (g_11 + g_22)
    a, b = -2.0 * (w_1 * cos + w_2 * sin), -2.0 * (w_2 * cos - w_1 * sin)
    size = abs(k) + abs(a) + abs(b) + d
    r = 1.0 / where(size > 0.0, size, 1.0)
    k, a, b, d = k * r, a * r, b * r, d * r
    return (cos, sin), (k, a, b, d), lines_of(k, a, b, d), size


@routine
def lines_of(k, a, b, d):
    """Step 2."""
    low, high = -d, d
    quarter_a, quarter_b = 0.25 * a * a, 0.25 * b * b
    x = 0.0 * d
    for _ in range(_STEPS):
        value = (x * x - d * d) * (k - x) - (x + d) * quarter_b - (x - d) * quarter_a
        slope = 2.0 * x * (k - x) - (x * x - d * d) - quarter_b - quarter_a
        low, high = where(value >= 0.0, x, low), where(value >= 0.0, high, x)
        newton = x - value / where(abs(slope) > 0.0, slope, 1.0)
        inside = (newton >= low) & (newton <= high) & (abs(slope) > 0.0)
        x = where(inside, newton, 0.5 * (low + high))
    alpha, beta = sqrt(maximum(d + x, 0.0)), sqrt(maximum(d - x, 0.0))
    # The n of the larger factor comes first. The other follows by its quotient or from the first, whichever is more accurate.
    small_alpha = alpha < beta
    larger, smaller = where(small_alpha, beta, alpha), where(small_alpha, alpha, beta)
    of_larger, of_smaller = where(small_alpha, b, a), where(small_alpha, a, b)
    n_larger = of_larger / where(larger > 0.0, 2.0 * larger, 1.0)
    root = sqrt(maximum(n_larger * n_larger + where(small_alpha, k - x, x - k), 0.0))
    by_root = root > smaller
    quotient = abs(of_smaller) / where(by_root | (smaller <= 0.0), 1.0, 2.0 * smaller)
    smaller = where(by_root, 0.5 * abs(of_smaller) / where(by_root, root, 1.0), smaller)
    n_smaller = where(by_root, root, quotient)
    n_smaller = where(of_smaller >= 0.0, n_smaller, -n_smaller)
    alpha, beta = where(small_alpha, smaller, larger), where(small_alpha, larger, smaller)
    n_a, n_b = where(small_alpha, n_smaller, n_larger), where(small_alpha, n_larger, n_smaller)
    return alpha, beta, n_a, n_b


@kernel
def angle_of_pair(axes, form, lines, size, line, sign, free):
    """Steps 3 and 4: theta for two signs; determination; the square of the slope; whether it is a root."""
    (k, a, b, d), (alpha, beta, n_a, n_b) = form, lines
    straight = d < _STRAIGHT
    a_c, a_s = where(straight, a, alpha), where(straight, b, -line * beta)
    at = where(straight, where(line > 0.0, -k, 3.0), -(n_a + line * n_b))
    both, determination, share = angles_of_two(a_s, a_c, at, a_s * a_s + a_c * a_c - at * at, free)
    s, c = one_of_two(both, sign)
    slope, value = 0.0 * s, 0.0 * s
    for _ in range(_NEWTON_STEPS):
        value = k + a * c + b * s + d * (c * c - s * s)
        slope = b * c - a * s - 4.0 * d * s * c
        step = -value * slope / (slope * slope + _DAMPING)
        step = where((abs(step) <= _FAR) & (share >= _MEETS), step, 0.0)
        s, c = s + step * c, c - step * s
        r = 1.5 - 0.5 * (s * s + c * c)
        s, c = s * r, c * r
    cos, sin = axes
    return (
        (s * cos + c * sin, c * cos - s * sin),
        minimum(determination, size * size * size * size),
        slope * slope,
        (share >= 0.0) & (abs(value) <= _FOUND),
    )


@kernel
def passing(form, lines, off):
    """Step 5: masks of the first and second line that certainly miss the circle; off: the error of step 1."""
    (k, a, b, d), (alpha, beta, n_a, n_b) = form, lines
    straight = d < _STRAIGHT
    amplitude = sqrt(where(straight, a * a + b * b, 2.0 * d))
    one, other = abs(where(straight, k, n_a + n_b)), abs(n_a - n_b)
    size_1, size_2 = one + amplitude, where(straight, 1.0, other + amplitude)
    x, y, z = alpha * n_b, beta * n_a, alpha * beta
    resultant = where(straight, amplitude * amplitude, 4.0 * (x * x + y * y - z * z)) / (size_1 * size_1 * size_2 * size_2)
    passes_1, passes_2 = (one - amplitude) / size_1, where(straight, 1.0, (other - amplitude) / size_2)
    scale = abs(passes_1) + abs(passes_2) + sqrt(abs(resultant))
    least, both = (
        resultant * resultant / where(scale > 0.0, scale * scale * scale, 1.0),
        where((passes_1 > 0.0) & (passes_2 > 0.0), passes_1 * passes_2, 0.0),
    )
    left = k - where(straight, k, n_a * n_a - n_b * n_b + 0.5 * (alpha * alpha - beta * beta))
    off = _CERTAIN * (off + abs(left) + where(straight, 0.0, abs(2.0 * alpha * n_a - a) + abs(2.0 * beta * n_b - b)))
    return maximum(passes_1 * least, both) > off, maximum(passes_2 * least, both) > off


@kernel
def other_of_pair(u, b_1, b_2, angle):
    """The angle of y, normalized: its sine and cosine."""
    s, c = angle
    x, y = u[0] - b_1[0] * c - b_2[0] * s, u[1] - b_1[1] * c - b_2[1] * s
    square = x * x + y * y
    r = 1.0 / sqrt(where(square > 0.0, square, 1.0))
    return y * r, x * r
