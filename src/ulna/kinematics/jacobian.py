"""Jacobians: how fast a link moves for a unit rate of each entry of q."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError, SingularityError, did_you_mean
from ulna.kernels.jacobian import BASE, LINK, SPATIAL, jacobian_batch, jacobian_one
from ulna.kernels.layout import COLUMN, FIXED, KIND
from ulna.kinematics.forward import forward_kinematics
from ulna.kinematics.positions import as_positions, flat, for_kernel, refuse_out_of_range
from ulna.model.pose import rpy_from_matrix
from ulna.model.tree import Tree

EXPRESSED_IN = {"base": BASE, "link": LINK, "spatial": SPATIAL}
LEAST_COS_PITCH = 1e-6


def geometric_jacobian(tree: Tree, q: ArrayLike, link: str, expressed_in: str) -> NDArray[np.float64]:
    """J, shape (..., 6, n_dof), linear rows first; see ``Robot.jacobian``."""
    frame, chain = as_frame(expressed_in), tree.chain(link)
    q = as_positions(q, tree)
    if q.ndim == 1:
        J = np.empty((6, tree.n_dof))
        good = jacobian_one(chain, frame, q if tree.n_dof else for_kernel(q), J)
    else:
        rows = flat(q)
        J = np.empty((*q.shape[:-1], 6, tree.n_dof))
        good = jacobian_batch(chain, frame, rows, J.reshape(len(rows), 6, tree.n_dof))
    if not good:
        refuse_out_of_range(q)
    return J


def as_frame(expressed_in: str) -> int:
    """The kernels' number of a frame, or an ``InputError`` that lists the frames."""
    frame = EXPRESSED_IN.get(expressed_in) if isinstance(expressed_in, str) else None
    if frame is None:
        raise InputError("expressed_in", f"{expressed_in!r} is not a frame{did_you_mean(str(expressed_in), EXPRESSED_IN)}")
    return frame


def analytical_jacobian(tree: Tree, q: ArrayLike, link: str) -> NDArray[np.float64]:
    """Rates of x, y, z, roll, pitch, yaw, shape (..., 6, n_dof); see ``Robot.analytical_jacobian``.

    The angular velocity in the axes of the base is w = E(pitch, yaw) (roll', pitch', yaw'), with the columns of E the axes
    about which the angles turn: the x axis of the turned frame, its y axis before roll, and the base's z axis. So the lower
    rows are E^-1 of the geometric ones. det E = cos(pitch). Source: Siciliano et al., Robotics (2009), section 3.6.
    """
    J = geometric_jacobian(tree, q, link, "base")
    rpy = rpy_from_matrix(forward_kinematics(tree, q, link))
    pitch, yaw = rpy[..., 1], rpy[..., 2]
    locked = np.abs(np.cos(pitch)) < LEAST_COS_PITCH
    if np.any(locked):
        raise SingularityError(_locked_message(locked), tuple(map(tuple, np.argwhere(locked).tolist())))
    wx, wy, wz = np.moveaxis(J[..., 3:, :], -2, 0)
    sin_yaw, cos_yaw, cos_pitch, tan_pitch = (f[..., None] for f in (np.sin(yaw), np.cos(yaw), np.cos(pitch), np.tan(pitch)))
    along = cos_yaw * wx + sin_yaw * wy
    rates = np.stack([along / cos_pitch, cos_yaw * wy - sin_yaw * wx, wz + tan_pitch * along], axis=-2)
    return np.concatenate([J[..., :3, :], rates], axis=-2)


def manipulability(tree: Tree, q: ArrayLike, link: str) -> NDArray[np.float64]:
    """sqrt(det(J J')), or of J' J for fewer than six entries of q that move the link: shape (...,).

    Source: Yoshikawa, Manipulability of robotic mechanisms (Int. J. Robotics Research 1985).
    """
    J = geometric_jacobian(tree, q, link, "base")
    chain = tree.chain(link)
    moving = np.unique(chain[chain[:, KIND] != FIXED, COLUMN].astype(int))
    J = J[..., moving]
    Jt = np.swapaxes(J, -1, -2)
    return np.sqrt(np.maximum(np.linalg.det(J @ Jt if len(moving) >= 6 else Jt @ J), 0.0))


def _locked_message(locked: NDArray[np.bool_]) -> str:
    rows = np.argwhere(locked)
    where = "here"
    if locked.ndim:
        names = [", ".join(str(int(k)) for k in row) for row in rows[:5]]
        where = f"at row{'s' * (len(rows) > 1)} {'; '.join(names)}" + (f" and {len(rows) - 5} more" if len(rows) > 5 else "")
    return (
        f"roll and yaw have no rates of their own where |cos(pitch)| < {LEAST_COS_PITCH:g}, as {where}; "
        "the geometric jacobian() is defined everywhere"
    )
