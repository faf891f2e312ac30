"""Composes, loads and stores poses of twelve numbers, and computes rotation vectors between them."""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, sqrt, store, where
from ulna.kernels.layout import LARGEST
from ulna.kernels.spatial.elementary import first_quadrant_angle, sincos

_TINY = 1e-150  # its square does not underflow


@kernel
def constant_pose(table, i, like):
    """The pose in the first twelve columns of row i of a table, as numbers of the type of ``like``."""
    return (
        splat(table[i, 0], like), splat(table[i, 1], like), splat(table[i, 2], like), splat(table[i, 3], like),
        splat(table[i, 4], like), splat(table[i, 5], like), splat(table[i, 6], like), splat(table[i, 7], like),
        splat(table[i, 8], like), splat(table[i, 9], like), splat(table[i, 10], like), splat(table[i, 11], like),
    )  # fmt: skip


@kernel
def compose(a, b):
    """The product of two poses: T_a_c = T_a_b @ T_b_c."""
    return (
        a[0] * b[0] + a[1] * b[4] + a[2] * b[8],
        a[0] * b[1] + a[1] * b[5] + a[2] * b[9],
        a[0] * b[2] + a[1] * b[6] + a[2] * b[10],
        a[0] * b[3] + a[1] * b[7] + a[2] * b[11] + a[3],
        a[4] * b[0] + a[5] * b[4] + a[6] * b[8],
        a[4] * b[1] + a[5] * b[5] + a[6] * b[9],
        a[4] * b[2] + a[5] * b[6] + a[6] * b[10],
        a[4] * b[3] + a[5] * b[7] + a[6] * b[11] + a[7],
        a[8] * b[0] + a[9] * b[4] + a[10] * b[8],
        a[8] * b[1] + a[9] * b[5] + a[10] * b[9],
        a[8] * b[2] + a[9] * b[6] + a[10] * b[10],
        a[8] * b[3] + a[9] * b[7] + a[10] * b[11] + a[11],
    )


@kernel
def turn_about_z(a, theta):
    """Rotate the pose a by theta about its own z axis: a @ Rz(theta)."""
    s, c = sincos(theta)
    return turned_about_z(a, s, c)


@kernel
def turned_about_z(a, s, c):
    """``turn_about_z`` by the angle with sine s and cosine c."""
    return (
        a[0] * c + a[1] * s, a[1] * c - a[0] * s, a[2], a[3],
        a[4] * c + a[5] * s, a[5] * c - a[4] * s, a[6], a[7],
        a[8] * c + a[9] * s, a[9] * c - a[8] * s, a[10], a[11],
    )  # fmt: skip


@kernel
def slide_along_z(a, distance):
    """Translate the pose a along its own z axis: a @ Tz(distance)."""
    return (
        a[0], a[1], a[2], a[3] + a[2] * distance,
        a[4], a[5], a[6], a[7] + a[6] * distance,
        a[8], a[9], a[10], a[11] + a[10] * distance,
    )  # fmt: skip


@kernel
def load_pose(rows, i):
    """Load pose i from rows, twelve rows each."""
    j = 12 * i
    return (
        load(rows, j), load(rows, j + 1), load(rows, j + 2), load(rows, j + 3),
        load(rows, j + 4), load(rows, j + 5), load(rows, j + 6), load(rows, j + 7),
        load(rows, j + 8), load(rows, j + 9), load(rows, j + 10), load(rows, j + 11),
    )  # fmt: skip


@kernel
def lane_pose(rows, i, lane):
    """One lane of pose i of the rows, as plain numbers."""
    j = 12 * i
    return (
        rows[j, lane], rows[j + 1, lane], rows[j + 2, lane], rows[j + 3, lane],
        rows[j + 4, lane], rows[j + 5, lane], rows[j + 6, lane], rows[j + 7, lane],
        rows[j + 8, lane], rows[j + 9, lane], rows[j + 10, lane], rows[j + 11, lane],
    )  # fmt: skip


@kernel
def store_pose(rows, i, a):
    """Write a pose to position i of the rows."""
    for k in range(12):
        store(rows, 12 * i + k, a[k])


@kernel
def matrix_pose(matrix):
    """The pose in a homogeneous 4x4 matrix, as plain numbers."""
    return (
        matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[0, 3],
        matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[1, 3],
        matrix[2, 0], matrix[2, 1], matrix[2, 2], matrix[2, 3],
    )  # fmt: skip


@kernel
def rigidity_defect(matrix):
    """The largest error of a 4x4 matrix as a rigid motion, in R R' - I and the last row.

    It is about 2 for a reflection, and infinite if an entry is not finite or a position exceeds LARGEST.
    """
    defect = 0.0
    for r in range(3):
        if not abs(matrix[r, 3]) <= LARGEST:
            defect = np.inf
        defect = worse(defect, matrix[3, r])
        for c in range(r + 1):
            dot = matrix[r, 0] * matrix[c, 0] + matrix[r, 1] * matrix[c, 1] + matrix[r, 2] * matrix[c, 2]
            defect = worse(defect, dot - (1.0 if r == c else 0.0))
    determinant = (
        matrix[0, 0] * (matrix[1, 1] * matrix[2, 2] - matrix[1, 2] * matrix[2, 1])
        - matrix[0, 1] * (matrix[1, 0] * matrix[2, 2] - matrix[1, 2] * matrix[2, 0])
        + matrix[0, 2] * (matrix[1, 0] * matrix[2, 1] - matrix[1, 1] * matrix[2, 0])
    )
    if determinant < 0.0:
        defect = worse(defect, determinant - 1.0)
    return worse(defect, matrix[3, 3] - 1.0)


@kernel
def worse(defect, fault):
    """The larger of two errors, in magnitude; infinite if the second is NaN, so that no later step hides it."""
    if not abs(fault) <= LARGEST:
        return np.inf
    return max(defect, abs(fault))


@kernel
def rotation_vector(r):
    """The rotation vector (axis times angle, angle in [0, pi]) of a rotation matrix, by rows: the logarithm of SO(3).

    1. The columns of 4 q q' are four candidates for the unit quaternion (Shepperd, J. Guidance and Control 1978). Take the one
       with the largest diagonal element, which avoids cancellation, also near pi.
    2. Choose the sign with w >= 0. The angle is 2 atan2(|v|, w), the axis v / |v|.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = r
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
    """The rotation vector from pose a's axes to pose b's, in the axes of their common frame: log(R_b R_a')."""
    r = (
        (
            b[0] * a[0] + b[1] * a[1] + b[2] * a[2],
            b[0] * a[4] + b[1] * a[5] + b[2] * a[6],
            b[0] * a[8] + b[1] * a[9] + b[2] * a[10],
        ),
        (
            b[4] * a[0] + b[5] * a[1] + b[6] * a[2],
            b[4] * a[4] + b[5] * a[5] + b[6] * a[6],
            b[4] * a[8] + b[5] * a[9] + b[6] * a[10],
        ),
        (
            b[8] * a[0] + b[9] * a[1] + b[10] * a[2],
            b[8] * a[4] + b[9] * a[5] + b[10] * a[6],
            b[8] * a[8] + b[9] * a[9] + b[10] * a[10],
        ),
    )
    return rotation_vector(r)
