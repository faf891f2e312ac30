"""Computes gradients of poses and Jacobians, for the arrays of any library with NumPy's methods.

Reverse-mode differentiation passes the cotangent G of a result: the derivative of some number by each entry of the result. The
gradient is then the derivative of that number by q. The formulas use operations that the library differentiates itself, so second
derivatives need no formulas of their own.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Library(Protocol):
    """The operations that the formulas need from a library of arrays, besides operators."""

    def evaluate(self, function: Any, q: Any) -> Any:
        """The results of a ``FunctionOfQ`` at q, differentiable."""
        ...

    def cross(self, a: Any, b: Any) -> Any:
        """The cross products of vectors that are columns: along the second to last axis."""
        ...

    def constant(self, numbers: NDArray[np.float64], like: Any) -> Any:
        """Numbers as an array of the same kind as another one."""
        ...


def pose_gradient(library: Library, T: Any, J: Any, G: Any) -> Any:
    """The gradient by q, shape (..., n_dof), for the cotangent G of a pose T, both (..., 4, 4).

    J: the geometric Jacobian in the axes of the base, shape (..., 6, n_dof). The last row of T is constant, so the last row of G
    is not used. A rate of q moves the origin with v, and each column b of the rotation with w x b. So the gradient is J_v' G_p +
    J_w' (sum over b of R_b x G_b), with G_p the last column of G.
    """
    turn = library.cross(T[..., :3, :3], G[..., :3, :3]).sum(-1)[..., None]
    return (J[..., :3, :] * G[..., :3, 3:] + J[..., 3:, :] * turn).sum(-2)


def jacobian_gradient(library: Library, J: Any, G: Any, expressed_in: str) -> Any:
    """The gradient by a chain's joint positions, shape (..., k), for the cotangent G of J, both (..., 6, k).

    J: the geometric Jacobian with a column for each joint, in the order of the chain, in the frame ``expressed_in``.

    With columns (v_i; w_i), the derivative of column i by joint k depends on whether joint k is nearer to the base than joint i:

    ========= ==================================== ==================================
    frame     k < i                                k >= i
    ========= ==================================== ==================================
    base      (w_k x v_i; w_k x w_i)               (w_i x v_k; 0)
    link      (0; 0)                               (w_i x v_k + v_i x w_k; w_i x w_k)
    spatial   (w_k x v_i + v_k x w_i; w_k x w_i)   (0; 0)
    ========= ==================================== ==================================

    A prismatic joint has w = 0. With the cotangents (a_i; b_i) of the columns, let f_i = a_i x w_i and m_i = v_i x a_i + w_i x
    b_i. Then the gradient is v_k . (sum of f_i) + w_k . (sum of m_i), over the i of ``_sides``. So no array of 6 k^2 numbers is
    made.

    Source, base: Haviland and Corke, A systematic approach to computing the manipulator Jacobian and Hessian using the elementary
    transform sequence (2020). Source, link and spatial: Mueller, Screw and Lie group theory in multibody kinematics (Multibody
    System Dynamics 2018).
    """
    v, w, a, b = J[..., :3, :], J[..., 3:, :], G[..., :3, :], G[..., 3:, :]
    force, moment = library.cross(a, w), library.cross(v, a) + library.cross(w, b)
    of_force, of_moment = (library.constant(side, J) for side in _sides(expressed_in, J.shape[-1]))
    return (v * (force @ of_force) + w * (moment @ of_moment)).sum(-2)


def _sides(expressed_in: str, k: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The signed selections of rows i to add up for column k: of f, and of m, shape (k, k)."""
    nearer = np.triu(np.ones((k, k)), 1)  # i < k
    farther = nearer.T
    if expressed_in == "link":
        return nearer, -nearer
    if expressed_in == "spatial":
        return -farther, farther
    return nearer, farther + np.eye(k)
