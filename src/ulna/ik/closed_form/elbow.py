"""Computes the branches of arms with a spherical shoulder and wrist at samples of the elbow's angle.

The three axes at the shoulder S intersect, and so do the three at the wrist W; axis 4 is the elbow's. The redundancy is the
rotation of the arm about the line from S to W. Its angle is 0 if the first axis lies in the plane of the elbow.

1. The distance of S and W gives two values of q_4: the rotation about axis 4 brings W to this distance from S (subproblem 3).
2. The elbow angle then determines the rotation of the shoulder, which brings S W to its place and rotates the elbow about it.
3. A rotation R of the shoulder or the wrist is a product of rotations about three axes with directions h_a, h_b and h_c. The
   component h_a . R h_c gives two angles about h_b (subproblem 4). For each, the angles about h_a and h_c bring one vector onto
   another (subproblem 1). So there are two solutions for the shoulder and two for the wrist.

The subproblems are numbered as by Elias and Wen, IK-Geo (2022), section 3.

Source: Shimizu, Kakuya, Yoon, Kitagaki and Kosuge, Analytical inverse kinematic computation for 7-DOF redundant manipulators with
joint limits and its application to redundancy resolution (2008).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.closed_form.axes import Axes, axes_of, nearest_point, turning_order
from ulna.ik.entries import closed_form
from ulna.kernels.chain.closed_form_layout import REACHED
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
ELBOW = "elbow"
FAMILY = "spherical shoulder and wrist, at angles of the elbow"
_N, _EXACT, _NEARLY, _STEPS = 7, 1e-12, 1e-9, 4


@dataclass(frozen=True, eq=False)
class Elbow:
    """An arm of seven joints with a spherical shoulder and wrist.

    Attributes:
        axes: Its axes.
        columns: Their entries of q.
        shoulder: S in the zero configuration, shape (3,) [m].
        wrist: W in the zero configuration, shape (3,) [m].
    """

    axes: Axes
    columns: tuple[int, ...]
    shoulder: Array
    wrist: Array

    def branches(self, targets: Array, n_samples: int) -> tuple[Array, Truths]:
        """q (n, 8 n_samples, 7) for targets (n, 4, 4), and whether each reaches its target."""
        h, n = self.axes.directions, len(targets)
        G = targets @ inverse(self.axes.end)
        R, p = G[:, None, :3, :3], G[:, :3, :3] @ self.wrist + G[:, :3, 3] - self.shoulder
        upper, lower = self.axes.points[3] - self.shoulder, self.wrist - self.axes.points[3]
        square = (p * p).sum(axis=-1)
        q4, real = _angles_to_plane(upper, lower, h[3], 0.5 * (square - upper @ upper - lower @ lower))
        angles = (np.arange(n_samples) + 0.5) / n_samples * 2.0 * np.pi - np.pi
        direction = p / np.linalg.norm(p, axis=-1)[:, None]
        elbow_rotations = rotations(direction[:, None], np.broadcast_to(angles, (n, n_samples)))
        angles_by_branch, is_real = [], []
        for elbow in range(2):
            R_4 = rotations(h[3], q4[elbow])
            shoulder_to_wrist = upper + R_4 @ lower
            alignment = _rotations_onto(shoulder_to_wrist, np.cross(h[3], shoulder_to_wrist), p, h[0])
            R_123 = elbow_rotations @ alignment[:, None]
            R_567 = np.swapaxes(R_123 @ R_4[:, None], -1, -2) @ R
            for first, is_first in _decompositions(h[:3], R_123):
                for last, is_last in _decompositions(h[4:], R_567):
                    middle = np.broadcast_to(q4[elbow][:, None, None], (n, n_samples, 1))
                    angles_by_branch.append(np.concatenate([first, middle, last], axis=-1))
                    is_real.append(is_first & is_last & real[:, None])
        q = np.stack(angles_by_branch, axis=2).reshape(n, -1, _N)
        return self._verified(targets, q, np.stack(is_real, axis=2).reshape(n, -1))

    def _verified(self, targets: Array, q: Array, good: Truths) -> tuple[Array, Truths]:
        order, branch = np.nonzero(good)
        starts, errors = np.ascontiguousarray(q[order, branch]), np.full(len(order), _NEARLY)
        scale = 1.0 / self.axes.unit
        closed_form.polish_all(self.axes.chain, targets[order], starts, np.empty(0), scale, _STEPS, errors)
        q[order, branch], good[order, branch] = starts, errors <= REACHED
        return q, good


def elbow_of(tree: Tree, link: str) -> Elbow | None:
    """The arm of a link, if it has seven joints with a spherical shoulder and wrist; else None."""
    chain = tree.chain(link)
    columns = turning_order(chain)
    axes = axes_of(chain, columns, np.zeros(tree.n_dof), 0.0) if len(columns) == _N else None
    if axes is None or axes.slides.any():
        return None
    (shoulder, far_1), (wrist, far_2) = (_common_point(axes, part) for part in (slice(0, 3), slice(4, 7)))
    if max(far_1, far_2) > _EXACT * axes.reach:
        return None
    return Elbow(axes, columns, shoulder, wrist)


def _common_point(axes: Axes, part: slice) -> tuple[Array, float]:
    """The point nearest to three axes, and its maximum distance from them."""
    h, c = axes.directions[part], axes.points[part]
    if np.linalg.cond(len(h) * np.eye(3) - h.T @ h) > 1e9:
        return c[0], np.inf
    return nearest_point(h, c)


def rotations(k: Array, angle: Array) -> Array:
    """Rotations about unit vectors k (..., 3) by angles (...), shape (..., 3, 3)."""
    k = np.broadcast_to(k, (*angle.shape, 3))
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    x, y, z = np.moveaxis(k, -1, 0)
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    return c * np.eye(3) + s * K + (1.0 - c) * k[..., :, None] * k[..., None, :]


def _rotations_onto(a: Array, a_side: Array, b: Array, b_side: Array) -> Array:
    """Rotations (n, 3, 3) that take directions a (n, 3) to b, and half-planes of a_side to those of b_side."""
    return _frame(b, np.broadcast_to(b_side, b.shape)) @ np.swapaxes(_frame(a, a_side), -1, -2)


def _frame(a: Array, side: Array) -> Array:
    x = a / np.linalg.norm(a, axis=-1)[..., None]
    z = np.cross(x, side)
    weak = np.linalg.norm(z, axis=-1) < 1e-9 * np.linalg.norm(side, axis=-1)  # any side will do
    z = np.where(weak[..., None], np.cross(x, np.eye(3)[np.abs(x).argmin(axis=-1)]), z)
    z = z / np.linalg.norm(z, axis=-1)[..., None]
    return np.stack([x, np.cross(z, x), z], axis=-1)


def _angles_to_plane(h: Array, p: Array, k: Array, d: Array) -> tuple[tuple[Array, Array], Truths]:
    """Subproblem 4: both angles with h . rot(k, angle) p = d, and whether they exist."""
    constant = (h @ k) * (k @ p)
    a_s, a_c = h @ np.cross(k, p), h @ p - constant
    size = np.hypot(a_s, a_c)
    cosine = (d - constant) / np.where(size > 0.0, size, 1.0)
    middle, half = np.arctan2(a_s, a_c), np.arccos(np.clip(cosine, -1.0, 1.0))
    return (middle + half, middle - half), np.abs(cosine) <= 1.0 + _NEARLY


def _decompositions(h: Array, R: Array) -> list[tuple[Array, Truths]]:
    """Both decompositions of R (..., 3, 3) into rotations about three axes (3, 3).

    Each is the angles (..., 3), and whether they exist. The last axis rotates first.
    """
    axis = R @ h[2]
    both, real = _angles_to_plane(h[0], h[2], h[1], axis @ h[0])
    solutions = []
    for second in both:
        moved_axis = rotations(h[1], second) @ h[2]
        first = _angle_about(h[0], moved_axis, axis)
        remaining = np.swapaxes(rotations(h[0], first) @ rotations(h[1], second), -1, -2) @ R
        normal = np.cross(h[2], h[1])
        third = _angle_about(h[2], np.broadcast_to(normal, axis.shape), remaining @ normal)
        solutions.append((np.stack([first, second, third], axis=-1), real))
    return solutions


def _angle_about(k: Array, a: Array, b: Array) -> Array:
    """Subproblem 1: the angle about k that brings a (..., 3) nearest to b."""
    across_a, across_b = np.cross(k, a), np.cross(k, b)
    return np.arctan2(np.cross(across_a, across_b) @ k, (across_a * across_b).sum(axis=-1))
