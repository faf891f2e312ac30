"""Computes Jacobians, with NumPy arrays in and out."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import rpy_from_matrix
from ulna.errors import InputError, SingularityError, did_you_mean
from ulna.kernels.layout import IN_BASE, IN_LINK, IN_SPATIAL
from ulna.kinematics.entries import jacobian
from ulna.kinematics.forward import FunctionOfLink, forward_kinematics
from ulna.kinematics.positions import as_out, as_positions
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
EXPRESSED_IN = {"base": IN_BASE, "link": IN_LINK, "spatial": IN_SPATIAL}
MIN_COS_PITCH = 1e-6


class CompiledJacobian(FunctionOfLink):
    """The geometric Jacobian of one link, shape (..., 6, n_dof): ``robot.compile_jacobian(link, expressed_in=...)``.

    It validates its arguments like ``robot.jacobian``, in less time. It can be pickled, and called from many threads at once if
    each has its own ``out``.
    """

    __slots__ = ("_expressed_in", "_number")

    def __init__(self, tree: Tree, link: str, expressed_in: str) -> None:
        self._expressed_in, self._number = expressed_in, as_frame(expressed_in)
        shape = 6, tree.n_dof
        super().__init__(tree, link, jacobian.jacobian_one, jacobian.jacobian_batch, (self._number,), shape)

    def __reduce__(self):
        return CompiledJacobian, (self._tree, self._link, self._expressed_in)

    def __repr__(self) -> str:
        return f"<CompiledJacobian {self._link!r} expressed in {self._expressed_in!r}, {self._tree.n_dof} dof>"


class JacobianByLink(dict[tuple[str | None, str], CompiledJacobian]):
    """The geometric Jacobians of one robot by link and frame, each compiled at its first use; None is the tip."""

    def __init__(self, tree: Tree) -> None:
        super().__init__()
        self._tree = tree

    def of(self, link: str | None, expressed_in: str) -> CompiledJacobian:
        """The Jacobian of a link in a frame. If two threads make it at once, both get the first.

        Raises:
            UnknownNameError: There is no such link.
            InputError: There is no such frame.
        """
        name = self._tree.link_or_tip(link)
        as_frame(expressed_in)  # raises an error for an unknown frame
        self._tree.chain(name)  # and for an unknown link
        known = self.get((name, expressed_in))
        function = known or self.setdefault((name, expressed_in), CompiledJacobian(self._tree, name, expressed_in))
        return self.setdefault((link, expressed_in), function)


def as_frame(expressed_in: str) -> int:
    """The kernels' number of a frame."""
    frame = EXPRESSED_IN.get(expressed_in) if isinstance(expressed_in, str) else None
    if frame is None:
        raise InputError("expressed_in", f"{expressed_in!r} is not a frame{did_you_mean(str(expressed_in), EXPRESSED_IN)}")
    return frame


def geometric_jacobian(tree: Tree, q: ArrayLike, link: str, expressed_in: str, out: Array | None = None) -> Array:
    """J, shape (..., 6, n_dof), linear rows first; see ``Robot.jacobian``."""
    return CompiledJacobian(tree, link, expressed_in)(q, out)


def analytical_jacobian(tree: Tree, q: ArrayLike, link: str, out: Array | None = None) -> Array:
    """Rates of x, y, z, roll, pitch, yaw, shape (..., 6, n_dof); see ``Robot.analytical_jacobian``.

    The angular velocity in the axes of the base is w = E(pitch, yaw) (roll', pitch', yaw'). The columns of E are the axes of the
    three rotations: the x axis of the rotated frame, its y axis before roll, and the base's z axis. So the lower rows are E^-1
    times the geometric ones. det E = cos(pitch). Source: Siciliano et al., Robotics (2009), section 3.6.
    """
    q = as_positions(q, tree)
    J = geometric_jacobian(tree, q, link, "base", out)
    rpy = rpy_from_matrix(forward_kinematics(tree, q, link))
    pitch, yaw = rpy[..., 1], rpy[..., 2]
    locked = np.abs(np.cos(pitch)) < MIN_COS_PITCH
    if np.any(locked):
        raise SingularityError(_locked_message(locked), tuple(map(tuple, np.argwhere(locked).tolist())))
    wx, wy, wz = np.moveaxis(J[..., 3:, :].copy(), -2, 0)
    sin_yaw, cos_yaw, cos_pitch, tan_pitch = (f[..., None] for f in (np.sin(yaw), np.cos(yaw), np.cos(pitch), np.tan(pitch)))
    rotated = cos_yaw * wx + sin_yaw * wy
    J[..., 3, :], J[..., 4, :], J[..., 5, :] = rotated / cos_pitch, cos_yaw * wy - sin_yaw * wx, wz + tan_pitch * rotated
    return J


def manipulability(tree: Tree, q: ArrayLike, link: str, out: Array | None = None) -> Any:
    """The manipulability sqrt(det(J J')), or sqrt(det(J' J)) if fewer than six entries of q move the link: shape (...,).

    Source: Yoshikawa, Manipulability of robotic mechanisms (Int. J. Robotics Research 1985).
    """
    q = as_positions(q, tree)
    measure = as_out(out, q.shape[:-1], q)
    moving = tree.moving_columns(link)
    J = geometric_jacobian(tree, q, link, "base")[..., moving]
    Jt = np.swapaxes(J, -1, -2)
    np.sqrt(np.maximum(np.linalg.det(J @ Jt if len(moving) >= 6 else Jt @ J), 0.0), out=measure)
    if not len(moving):  # the determinant of an empty matrix is 1
        measure[...] = 0.0
    return measure if q.ndim > 1 or out is not None else measure[()]


def _locked_message(locked: NDArray[np.bool_]) -> str:
    rows = np.argwhere(locked)
    where = "here"
    if locked.ndim:
        names = [", ".join(str(int(k)) for k in row) for row in rows[:5]]
        where = f"at row{'s' * (len(rows) > 1)} {'; '.join(names)}" + (f" and {len(rows) - 5} more" if len(rows) > 5 else "")
    return (
        f"roll and yaw have no rates of their own where |cos(pitch)| < {MIN_COS_PITCH:g}, as {where}; "
        "the geometric jacobian() is defined everywhere"
    )
