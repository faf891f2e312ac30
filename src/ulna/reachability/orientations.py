"""Spreads orientations evenly over SO(3), and finds the nearest of them. Used by ``grid`` and ``reachability_map``.

Super-Fibonacci spirals: point i of n lies on a spiral of the 3-sphere, whose two angles grow by irrational ratios.
Source: M. Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)", CVPR 2022, algorithm 1.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import quaternion_from_matrix

Array = NDArray[np.float64]
_PHI = np.sqrt(2.0)
_PSI = 1.533751168755204288118041  # the real root of psi^4 = psi + 4
_AT_ONCE = 1 << 22  # products of quaternions that are held in memory


def super_fibonacci(n: int) -> Array:
    """n unit quaternions, w first, spread evenly over SO(3): shape (n, 4).

    Example:
        >>> super_fibonacci(64).shape
        (64, 4)
    """
    s = np.arange(n) + 0.5
    r, R = np.sqrt(s / n), np.sqrt(1.0 - s / n)
    alpha, beta = 2.0 * np.pi * s / _PHI, 2.0 * np.pi * s / _PSI
    return np.stack([R * np.cos(beta), r * np.sin(alpha), r * np.cos(alpha), R * np.sin(beta)], axis=-1)


def nearest_orientation(T: Array, wxyz: Array) -> NDArray[np.int64]:
    """The index of the nearest of the quaternions (n, 4) to each pose or rotation (m, k, k): shape (m,).

    Nearest by the angle between them, 2 arccos |a . b|: a quaternion and its negative are the same rotation.
    """
    given = quaternion_from_matrix(T)
    step = max(1, _AT_ONCE // len(wxyz))
    parts = [np.abs(given[k : k + step] @ wxyz.T).argmax(axis=1) for k in range(0, len(given), step)]
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)
