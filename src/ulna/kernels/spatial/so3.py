"""Computes the rotation vector of a matrix, or from one matrix to another."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt, where
from ulna.kernels.spatial.elementary import first_quadrant_angle

_TINY = 1e-150  # its square does not underflow


@kernel
def rotation_vector(r00, r01, r02, r10, r11, r12, r20, r21, r22):
    """The rotation vector (axis times angle, angle in [0, pi]) of a rotation matrix: the logarithm of SO(3).

    1. Four candidates for the unit quaternion, each a column of 4 q q' (Shepperd, J. Guidance and Control 1978);
       take the one with the largest diagonal element, so that nothing cancels, near pi either.
    2. Turn it so that w >= 0; the angle is 2 atan2(|v|, w) and the axis v / |v|.
    """
    w2, x2 = 1.0 + r00 + r11 + r22, 1.0 + r00 - r11 - r22
    y2, z2 = 1.0 - r00 + r11 - r22, 1.0 - r00 - r11 + r22
    wx, wy, wz = r21 - r12, r02 - r20, r10 - r01
    xy, xz, yz = r01 + r10, r02 + r20, r12 + r21
    w, x, y, z, largest = w2, wx, wy, wz, w2
    by_x = x2 > largest
    w, x, y, z, largest = where(by_x, wx, w), where(by_x, x2, x), where(by_x, xy, y), where(by_x, xz, z), where(by_x, x2, largest)
    by_y = y2 > largest
    w, x, y, z, largest = where(by_y, wy, w), where(by_y, xy, x), where(by_y, y2, y), where(by_y, yz, z), where(by_y, y2, largest)
    by_z = z2 > largest
    w, x, y, z = where(by_z, wz, w), where(by_z, xz, x), where(by_z, yz, y), where(by_z, z2, z)
    sign = where(w < 0.0, -1.0, 1.0)
    w = w * sign
    length = sqrt(x * x + y * y + z * z)
    scale = sign * where(length > _TINY, 2.0 * first_quadrant_angle(length, w) / where(length > _TINY, length, 1.0), 2.0 / w)
    return x * scale, y * scale, z * scale


@kernel
def rotation_between(a, b):
    """The rotation vector that turns pose a's axes into pose b's, in the axes in which both are given: log(R_b R_a')."""
    return rotation_vector(
        b[0] * a[0] + b[1] * a[1] + b[2] * a[2],
        b[0] * a[4] + b[1] * a[5] + b[2] * a[6],
        b[0] * a[8] + b[1] * a[9] + b[2] * a[10],
        b[4] * a[0] + b[5] * a[1] + b[6] * a[2],
        b[4] * a[4] + b[5] * a[5] + b[6] * a[6],
        b[4] * a[8] + b[5] * a[9] + b[6] * a[10],
        b[8] * a[0] + b[9] * a[1] + b[10] * a[2],
        b[8] * a[4] + b[9] * a[5] + b[10] * a[6],
        b[8] * a[8] + b[9] * a[9] + b[10] * a[10],
    )
