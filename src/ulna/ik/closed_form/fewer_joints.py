"""Takes from the branches of six joints, some of them added, those of the arm's own joints.

1. All branches of the six joints.
2. Where joints were added that have to be at rest: a branch in which they nearly are is a start. Newton steps of the other
   joints follow, for at the end of a branch a rounded target turns the added joints by the square root of its rounding, and
   behind two ends by more: there a start that does not lead to a solution leaves in doubt whether there is one. A start within
   the limits leads to a solution within them, if there is one as exact.
3. A branch that differs from one before it only in added joints is left out.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import closed_form
from ulna.ik.closed_form.axes import N_AXES
from ulna.ik.closed_form.six_joints import SixJoints, Workers
from ulna.kernels.chain import closed_form_layout as layout

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_NEARLY, _NEARLY_AT_END = 1e-3, 0.1  # rad: beyond it an added joint is not at rest; the same at the end of a branch
_SAME = 1e-7  # rad, or share of the reach
_STEPS = 8


def branches_of_fewer(
    six: SixJoints, targets: Array, seeds: Array, workers: Workers, lower: Array, upper: Array
) -> tuple[Array, NDArray[np.int64]]:
    """All branches of targets (n, 4, 4): q (n, 8, n_own), and what is known of them (n, 8); as ``SixJoints.branches``."""
    n_own, share = len(six.columns), six.table[layout.FORM, layout.INVERSE_REACH]
    padded = np.zeros((len(seeds), N_AXES))
    padded[:, :n_own] = seeds[:, six.columns]
    q, known, _ = six.branches(targets, padded, workers, six.plan(lower, upper))
    known = known.astype(np.int64)
    real = (known & layout.IS_REAL) > 0
    own, at_rest, free = np.split(q, [n_own, N_AXES - six.n_free], axis=-1)
    own = np.ascontiguousarray(own)
    if at_rest.shape[-1]:
        at_end = (known & layout.IS_COINCIDING) > 0
        real &= np.abs(_turned(at_rest)).max(axis=-1) <= np.where(at_end, _NEARLY_AT_END, _NEARLY)
        order, branch = np.nonzero(real)
        starts = np.hstack([own[order, branch], free[order, branch]])
        angles, errors = _polished(six, targets[order], starts, np.empty(0))
        some = np.flatnonzero(known[order, branch] & layout.IS_WITHIN)
        inside, there = _polished(six, targets[order[some]], starts[some], np.r_[lower[six.columns], upper[six.columns]])
        reached = there <= np.maximum(errors[some], layout.ENOUGH)
        angles[some[reached]] = inside[reached]
        own[order, branch], real[order, branch] = angles[:, :n_own], errors <= layout.REACHED
        lost = order[errors > layout.REACHED], branch[errors > layout.REACHED]
        known[lost] |= np.where(at_end[lost], layout.IS_HARDLY_DETERMINED, 0)
    real &= ~_repeated(np.where(six.slides, own * share, own), six.slides, real)
    return own, np.where(real, known | layout.IS_REAL, known & ~layout.IS_REAL)


def _polished(six: SixJoints, targets: Array, starts: Array, bounds: Array) -> tuple[Array, Array]:
    """Where Newton steps within bounds lead from starts (n, ...), joints at rest left there, and the errors (n,)."""
    q, errors, share = starts.copy(), np.full(len(starts), _NEARLY), six.table[layout.FORM, layout.INVERSE_REACH]
    closed_form.polish_all(six.without_rest, targets, q, bounds, share, _STEPS, errors)
    return q, errors


def _repeated(q: Array, slides: Truths, real: Truths) -> NDArray[Any]:
    """Whether a solution is one of those before it, shape (n, 8)."""
    difference = q[:, :, None] - q[:, None]
    same = (np.abs(np.where(slides, difference, _turned(difference))) <= _SAME).all(axis=-1)
    before = np.tri(layout.N_BRANCHES, k=-1, dtype=bool)
    return np.any(same & before & real[:, None], axis=-1)


def _turned(angle: Array) -> Array:
    """Angles in [-pi, pi)."""
    return np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
