"""Probes of the kernels of closed forms; see ``kernel_modes``."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store, where
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.subproblems import angle_onto, angles_to_direction, angles_to_plane, angles_to_sphere, one_of_two
from ulna.kernels.chain.two_circles import angle_of_pair, lines_of, other_of_pair, passing, pencil
from ulna.kernels.spatial.elementary import full_circle_angle

FREE = 0.6, 0.8  # the sine and cosine of an undetermined angle


@kernel
def vector_at(x, i):
    return load(x, i), load(x, i + 1), load(x, i + 2)


def onto(x, out):
    angle, size = angle_onto(vector_at(x, 0), vector_at(x, 3), vector_at(x, 6), FREE)
    store(out, 0, angle[0])
    store(out, 1, angle[1])
    store(out, 2, size)


def to_plane(x, out):
    both, size, apart = angles_to_plane(vector_at(x, 0), vector_at(x, 3), vector_at(x, 6), load(x, 9), FREE)
    angle = one_of_two(both, load(x, 10))
    store(out, 0, angle[0])
    store(out, 1, angle[1])
    store(out, 2, size)
    store(out, 3, apart)


def to_sphere(x, out):
    both, size, apart = angles_to_sphere(vector_at(x, 0), vector_at(x, 3), vector_at(x, 6), load(x, 9), FREE)
    angle = one_of_two(both, load(x, 10))
    store(out, 0, angle[0])
    store(out, 1, angle[1])
    store(out, 2, size)
    store(out, 3, apart)


def to_direction(x, out):
    """v in the frame of h."""
    bends = load(x, 12), load(x, 13)
    both, size, apart = angles_to_direction(vector_at(x, 0), vector_at(x, 3), vector_at(x, 6), vector_at(x, 9), bends, FREE)
    angle = one_of_two(both, load(x, 14))
    store(out, 0, angle[0])
    store(out, 1, angle[1])
    store(out, 2, size)
    store(out, 3, apart)


def arc_tangent(x, out):
    store(out, 0, full_circle_angle(load(x, 0), load(x, 1)))


def pair_of_circles(x, out):
    """x: u, the columns of B, two signs, what it is off by; out: the angle of x, how sure, ``apart``, and the angle of y."""
    u, b_1, b_2 = (load(x, 0), load(x, 1)), (load(x, 2), load(x, 3)), (load(x, 4), load(x, 5))
    axes, form, lines, size = pencil(u, b_1, b_2)
    angle, sure, slope, is_root = angle_of_pair(axes, form, lines, size, load(x, 6), load(x, 7), FREE)
    one, other = passing(form, lines, load(x, 8))
    store(out, 0, angle[0])
    store(out, 1, angle[1])
    store(out, 2, sure)
    passes = ((load(x, 6) > 0.0) & one) | ((load(x, 6) < 0.0) & other)
    store(out, 3, where(is_root, slope, where(passes, -1.0, -1e-40)))
    second = other_of_pair(u, b_1, b_2, angle)
    store(out, 4, second[0])
    store(out, 5, second[1])


def pair_of_lines(x, out):
    """x: k, a, b, d of k + a cos + b sin + d cos 2 angle, and what it is off by; out: 1 for a line that passes (``passing``)."""
    form = load(x, 0), load(x, 1), load(x, 2), load(x, 3)
    one, other = passing(form, lines_of(form[0], form[1], form[2], form[3]), load(x, 4))
    store(out, 0, where(one, 1.0, 0.0))
    store(out, 1, where(other, 1.0, 0.0))


def one_branch(table, x, out):
    """x: a pose, three signs, and twelve sines and cosines of free angles; out: six angles and what is known of them."""
    closed_form(table, x[:12], x[12:15], 1, x[15:27], out[:6], out[6:9])


def eight_branches(table, x, out):
    """x: a pose, and twelve sines and cosines; the signs are written to the outputs behind the 48 angles and 24 numbers."""
    for k in range(6):
        store(out, 72 + k, load(x, 0) * 0.0 + (1.0 - 2.0 * (k % 2)))
    closed_form(table, x[:12], out[72:78], 2, x[12:24], out[:48], out[48:72])
