"""Makes and checks poses as 4x4 matrices, from roll-pitch-yaw and quaternions.

``T_a_b`` maps coordinates in b to coordinates in a; adjacent names cancel: ``T_a_c = T_a_b @ T_b_c``.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.kernels.layout import EXACT_DEFECT, LARGEST, LARGEST_DEFECT

_ROUNDING = 2 * EXACT_DEFECT
_THREE_TURNS = 6 * np.pi  # [rad]: larger angles are likely degrees


def pose(
    xyz: ArrayLike = (0.0, 0.0, 0.0),
    rpy: ArrayLike | None = None,
    *,
    wxyz: ArrayLike | None = None,
    rotvec: ArrayLike | None = None,
) -> NDArray[np.float64]:
    """The homogeneous matrix of a position and an orientation.

    Args:
        xyz: Position [m], shape (..., 3).
        rpy: Roll, pitch, yaw [rad], shape (..., 3); the rotation is Rz(yaw) Ry(pitch) Rx(roll), as in URDF.
        wxyz: A quaternion instead, shape (..., 4), w first; normalized here.
        rotvec: A rotation vector instead [rad], shape (..., 3): along the axis, with the angle as its length, as in Universal
            Robots. ``pose_from`` takes poses of other controllers.

    Returns:
        T, shape (..., 4, 4).

    Raises:
        InputError: A shape is wrong, an entry is not finite, a quaternion has length zero, or two of ``rpy``, ``wxyz`` and
            ``rotvec`` are given.

    Example:
        >>> pose((0.5, 0.0, 0.21))[:3, 3]
        array([0.5 , 0.  , 0.21])
    """
    xyz = _finite("xyz", xyz, 3)
    given = [name for name, turn in (("rpy", rpy), ("wxyz", wxyz), ("rotvec", rotvec)) if turn is not None]
    if len(given) > 1:
        raise InputError(", ".join(given), f"give one of them, not {'both' if len(given) == 2 else 'all'}")
    if rpy is not None and (largest := float(np.abs(_finite("rpy", rpy, 3)).max(initial=0.0))) > _THREE_TURNS:
        from ulna.description.likely_units import warn_of_rpy  # noqa: PLC0415 - it needs shapes, which need poses

        warn_of_rpy(largest)
    if rotvec is not None:
        rotation = matrix_from_rotation_vector(rotvec)
    else:
        rotation = matrix_from_quaternion(wxyz) if wxyz is not None else matrix_from_rpy((0, 0, 0) if rpy is None else rpy)
    try:
        batch = np.broadcast_shapes(xyz.shape[:-1], rotation.shape[:-2])
    except ValueError:
        message = f"{xyz.shape[:-1]} positions do not go with {rotation.shape[:-2]} orientations"
        raise InputError("xyz", message) from None
    T = np.zeros((*batch, 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = rotation, xyz, 1.0
    return T


def matrix_from_rpy(rpy: ArrayLike) -> NDArray[np.float64]:
    """R = Rz(yaw) Ry(pitch) Rx(roll), shape (..., 3, 3), of angles [rad], shape (..., 3)."""
    rpy = _finite("rpy", rpy, 3)
    (sr, sp, sy), (cr, cp, cy) = np.moveaxis(np.sin(rpy), -1, 0), np.moveaxis(np.cos(rpy), -1, 0)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rpy_from_matrix(R: ArrayLike) -> NDArray[np.float64]:
    """Roll, pitch, yaw [rad], shape (..., 3), of rotation matrices (..., 3, 3) or poses (..., 4, 4).

    Roll and yaw lie in (-pi, pi], pitch in [-pi/2, pi/2]. If cos(pitch) vanishes, only a combination of roll and yaw is defined;
    then roll is 0. If it is small, roll is less accurate, and yaw is computed for that roll: the second column of R Rx(-roll) =
    Rz(yaw) Ry(pitch) is (-sin(yaw), cos(yaw), 0).
    """
    rows = np.asarray(R, dtype=np.float64)
    cos_pitch = np.hypot(rows[..., 0, 0], rows[..., 1, 0])
    roll = np.where(cos_pitch < 1e-12, 0.0, np.arctan2(rows[..., 2, 1], rows[..., 2, 2]))
    pitch = np.arctan2(-rows[..., 2, 0], cos_pitch)
    s, c = np.sin(roll), np.cos(roll)
    yaw = np.arctan2(s * rows[..., 0, 2] - c * rows[..., 0, 1], c * rows[..., 1, 1] - s * rows[..., 1, 2])
    rpy = np.stack([roll, pitch, yaw], axis=-1)
    return np.where(rpy == -np.pi, np.pi, rpy)


def matrix_from_quaternion(wxyz: ArrayLike) -> NDArray[np.float64]:
    """The rotation matrix, shape (..., 3, 3), of quaternions (..., 4), w first, normalized here."""
    wxyz = _finite("wxyz", wxyz, 4)
    largest = np.abs(wxyz).max(axis=-1, keepdims=True)
    if np.any(largest < 1e-12):
        raise InputError("wxyz", "a quaternion of length zero does not describe a rotation")
    scaled = wxyz / largest  # so that no square overflows
    w, x, y, z = np.moveaxis(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def matrix_from_rotation_vector(rotvec: ArrayLike) -> NDArray[np.float64]:
    """The rotation matrix, shape (..., 3, 3), of rotation vectors [rad], shape (..., 3)."""
    rotvec = _finite("rotvec", rotvec, 3)
    angle = np.linalg.norm(rotvec, axis=-1, keepdims=True)
    return matrix_from_quaternion(np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) / 2 * rotvec], axis=-1))


def rotation_vector_from_matrix(R: ArrayLike) -> NDArray[np.float64]:
    """The rotation vector [rad], shape (..., 3), at most pi long; R: shape (..., 3, 3) or (..., 4, 4)."""
    wxyz = quaternion_from_matrix(R)
    half = np.linalg.norm(wxyz[..., 1:], axis=-1, keepdims=True)  # the sine of half the angle
    angle = 2 * np.arctan2(half, wxyz[..., :1])
    return wxyz[..., 1:] * np.where(half < 1e-150, 2.0, angle / np.where(half < 1e-150, 1.0, half))


def quaternion_from_matrix(R: ArrayLike) -> NDArray[np.float64]:
    """The unit quaternion (..., 4), w first and not negative, of matrices (..., 3, 3) or poses (..., 4, 4).

    Shepperd's method: the column of 4 q q' with the largest diagonal entry, out of four.
    """
    rows = np.asarray(R, dtype=np.float64)
    (a, b, c), (d, e, f), (g, h, i) = (tuple(rows[..., r, k] for k in range(3)) for r in range(3))
    outer = np.stack(
        [
            np.stack([1 + a + e + i, h - f, c - g, d - b], axis=-1),
            np.stack([h - f, 1 + a - e - i, b + d, c + g], axis=-1),
            np.stack([c - g, b + d, 1 - a + e - i, f + h], axis=-1),
            np.stack([d - b, c + g, f + h, 1 - a - e + i], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    return column / np.linalg.norm(column, axis=-1, keepdims=True) * np.where(column[..., :1] < 0, -1.0, 1.0)


def as_pose(T: ArrayLike, name: str = "T") -> NDArray[np.float64]:
    """T as an array of poses, shape (..., 4, 4)."""
    poses = as_floats(name, T)
    if poses.shape[-2:] != (4, 4):
        hint = "; ulna.pose(xyz, rpy) makes one" if poses.shape[-1:] == (3,) and poses.shape[-2:] != (3, 3) else ""
        raise InputError(name, f"shape {poses.shape}, but poses have shape (..., 4, 4){hint}")
    if poses.ndim == 2 and _is_exact(poses):
        return poses
    R = poses[..., :3, :3]
    faults = {
        "has an entry that is not finite": ~np.isfinite(poses).all(axis=(-2, -1)),
        f"has a position beyond {LARGEST:g} m": np.abs(poses[..., :3, 3]).max(axis=-1) > LARGEST,
        "has a last row that is not (0, 0, 0, 1)": np.abs(poses[..., 3, :] - [0, 0, 0, 1]).max(axis=-1) > LARGEST_DEFECT,
    }
    with np.errstate(invalid="ignore", over="ignore"):
        faults["has a rotation part whose columns are not orthonormal"] = (
            np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(axis=(-2, -1)) > LARGEST_DEFECT
        )
        faults["is a reflection: its determinant is negative"] = np.linalg.det(R) < 0
    for fault, where in faults.items():
        if np.any(where):
            row = f"[{', '.join(str(int(k)) for k in np.argwhere(where)[0])}]" if poses.ndim > 2 else ""
            raise InputError(f"{name}{row}", f"{fault}, so it is not a pose")
    return poses


def as_one_pose(T: ArrayLike, name: str = "T") -> NDArray[np.float64]:
    """One pose to store, shape (4, 4): a copy, orthonormal to the last digits.

    A rounded matrix is accepted to 1e-6, but computations with it, such as separating axes, need an exact rotation.
    """
    if type(T) is np.ndarray and T.dtype == np.float64 and T.shape == (4, 4) and _is_exact(T):
        return T.copy()
    pose = as_pose(T, name)
    if pose.shape != (4, 4):
        raise InputError(name, f"shape {pose.shape}, but one pose has shape (4, 4)")
    return orthonormal(pose)


def _is_exact(T: NDArray[np.float64]) -> bool:
    """Whether a pose, shape (4, 4), is rigid up to rounding; plain numbers take a tenth of ``as_pose``'s time."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z), last = T.tolist()
    return (
        -LARGEST <= x <= LARGEST
        and -LARGEST <= y <= LARGEST
        and -LARGEST <= z <= LARGEST
        and last == [0.0, 0.0, 0.0, 1.0]
        and abs(a * a + b * b + c * c - 1.0) < EXACT_DEFECT
        and abs(d * d + e * e + f * f - 1.0) < EXACT_DEFECT
        and abs(g * g + h * h + i * i - 1.0) < EXACT_DEFECT
        and abs(a * d + b * e + c * f) < EXACT_DEFECT
        and abs(a * g + b * h + c * i) < EXACT_DEFECT
        and abs(d * g + e * h + f * i) < EXACT_DEFECT
        and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0.0
    )


def orthonormal(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """A copy of poses (..., 4, 4), with inexact rotations replaced by those of their quaternions."""
    copy = T.copy()
    R = copy[..., :3, :3]
    rounded = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(axis=(-2, -1)) > _ROUNDING
    if rounded.any():
        R[rounded] = matrix_from_quaternion(quaternion_from_matrix(R[rounded]))
    copy[..., 3, :] = (0.0, 0.0, 0.0, 1.0)
    return copy


def inverse(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """T_b_a of poses T_a_b, shape (..., 4, 4)."""
    T_inverse = np.zeros_like(T)
    R_inverse = np.swapaxes(T[..., :3, :3], -1, -2)
    T_inverse[..., :3, :3] = R_inverse
    T_inverse[..., :3, 3] = -(R_inverse @ T[..., :3, 3:])[..., 0]
    T_inverse[..., 3, 3] = 1.0
    return T_inverse


def angle_between(T_a: NDArray[np.float64], T_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The angle [rad] between the rotations of two poses, shape (...): |R_a - R_b| = sqrt(8) sin(angle / 2)."""
    defect = np.linalg.norm((T_a - T_b)[..., :3, :3], axis=(-2, -1))
    return 2 * np.arcsin(np.minimum(defect / np.sqrt(8), 1.0))


def _finite(name: str, values: ArrayLike, width: int) -> NDArray[np.float64]:
    values = as_floats(name, values)
    if values.shape[-1:] != (width,):
        raise InputError(name, f"shape {values.shape}, but shape (..., {width}) is expected")
    if not np.isfinite(values).all():
        raise InputError(name, "has an entry that is not finite")
    return values
