"""Computes all branches of an arm by its closed form, with whole turns that bring them into the limits."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.closed_form.axes import N_AXES
from ulna.ik.closed_form.closed_form import ClosedForm, held_range, joints_at
from ulna.ik.closed_form.six_joints import SixJoints, Workers, proofs_of
from ulna.ik.entries import closed_form
from ulna.ik.solutions import PROOFS, Proof
from ulna.kernels.chain import closed_form_layout as layout
from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, RATIO
from ulna.kinematics.size import units_of
from ulna.kinematics.tree import Tree, motion_along_z, row_pose
from ulna.kinematics.turns import nearest_turns, turning_columns

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_Result = tuple[Array, NDArray[np.int8], NDArray[np.int64]]

# rad: the maximum rotation of an added joint at rest; the same at the end of a branch, where two branches meet.
_MAX_REST, _MAX_REST_AT_END = 1e-3, 0.1
_DISTINCT = 1e-7  # rad, or share of the reach
_STEPS = 8
_MAX_FORMS, _MAX_SAMPLES = 64, 256  # entries of the caches, and the most samples of one


@dataclass(frozen=True, eq=False)
class Branches:
    """All branches of n targets.

    Attributes:
        q: Shape (n, m, n_dof), nearest to the seeds by whole turns within the limits; NaN where a branch is not real.
        real: Whether they reach the target, shape (n, m).
        valid: Whether they are also within the limits, shape (n, m).
        proof: Indices into ``PROOFS``, shape (n,); -1 where the target is no pose.
    """

    q: Array
    real: Truths
    valid: Truths
    proof: NDArray[np.int64]


def all_branches(form: ClosedForm, tree: Tree, targets: Array, seeds: Array, workers: Workers = None) -> Branches:
    """The eight branches of an arm of at most six joints.

    Args:
        form: Its closed form.
        tree: The robot.
        targets: Rigid motions, shape (n, 4, 4).
        seeds: Shape (n or 1, n_dof). They give the values of undetermined joints, and of joints that do not move the link.
        workers: Computes in place of threads, if given.
    """
    q, known, proof = _compute(form, tree, targets, seeds, workers)
    real = (known & layout.IS_REAL) > 0
    if not form.is_exact:
        proof = np.full(len(targets), PROOFS.index(Proof.SEARCHED))
    elif form.n_joints < N_AXES:
        proof = proofs_of(known, real, form.n_at_rest)
    if form.n_joints == N_AXES == tree.n_dof and not form.couplings:  # they are within the limits already
        return Branches(q, real, (known & layout.IS_WITHIN) > 0, proof)
    return within_limits(_limits_of_form(form, tree), q, real, proof, seeds)


def _compute(form: ClosedForm, tree: Tree, targets: Array, seeds: Array, workers: Workers) -> _Result:
    """Compute q, the flags of each branch, and the proof of a form of six joints.

    Joints at a limit up to rounding are put at the limit.
    """
    six = joints_at(form, seeds[0] if len(seeds) else np.zeros(tree.n_dof))
    lower, upper, shifted_seeds = tree.lower, tree.upper, seeds
    if form.couplings:  # the limits do not apply to the sums
        lower, upper, shifted_seeds = np.full(tree.n_dof, -np.inf), np.full(tree.n_dof, np.inf), seeds.copy()
        for column, leader, ratio in form.couplings:
            shifted_seeds[:, column] += ratio * seeds[:, leader]
    plan = six.plan(lower, upper) if form.couplings else _plan_within(six, tree)
    q, known, proof = six.branches(targets, six.entries_of(shifted_seeds), workers, plan)
    if form.n_joints < N_AXES:
        q, known = _drop_added_joints(six, targets, q, known, tree.lower[six.columns], tree.upper[six.columns])
    if form.columns != tuple(range(tree.n_dof)):
        angles, q = q, np.broadcast_to(seeds[:, None], (len(targets), layout.N_BRANCHES, tree.n_dof)).copy()
        q[..., six.columns] = angles
    for column, leader, ratio in form.couplings:
        q[..., column] -= ratio * q[..., leader]
    return q, known.astype(np.int8), proof.astype(np.int64)


@lru_cache(maxsize=_MAX_FORMS)
def _plan_within(six: SixJoints, tree: Tree) -> Array:
    """The kernels' bounds and units of six joints within a robot's limits."""
    return six.plan(tree.lower, tree.upper)


def sampled_branches(
    form: ClosedForm, tree: Tree, targets: Array, seeds: Array, n_samples: int, workers: Workers = None
) -> Branches:
    """The branches of an arm of seven joints at ``n_samples`` positions of the held joint, shape (n, 8 n_samples, ...)."""
    if form.held_column is None:
        raise AssertionError("an arm of six joints has no joint to hold")
    n, samples_of = len(targets), _samples_of if n_samples <= _MAX_SAMPLES else _samples_of.__wrapped__
    places, back = samples_of(form, *held_range(tree, form.held_column), n_samples)
    seeds, places = np.broadcast_to(seeds, (n, tree.n_dof)), np.broadcast_to(places, (n, n_samples))
    return branches_at(form, tree, targets, seeds, places, workers, None if back is None else np.tile(back, (n, 1, 1)))


def branches_at(
    form: ClosedForm,
    tree: Tree,
    targets: Array,
    seeds: Array,
    places: Array,
    workers: Workers = None,
    back: Array | None = None,
) -> Branches:
    """The branches of an arm of seven joints at given positions of the held joint for each target.

    A held joint at either end moves the target instead of the axes, so all positions are targets of one form.

    Args:
        form: Its closed form.
        tree: The robot.
        targets: Shape (n, 4, 4).
        seeds: Shape (n, n_dof).
        places: The positions of the held joint, shape (n, k).
        workers: Computes in place of threads, if given.
        back: The inverses of the held joint's motions at these positions, shape (n k, 4, 4), if they are known.

    Returns:
        The branches, shape (n, 8 k, ...).
    """
    (n, k), column = places.shape, form.held_column
    if column is None:
        raise AssertionError("an arm of six joints has no joint to hold")
    held_seeds, end = np.repeat(seeds, k, axis=0), _held_end(form)
    if end is not None:
        moved = end.at_zero(np.repeat(targets, k, axis=0), end.back_from(places.ravel()) if back is None else back)
        held_seeds[:, column] = 0.0
        q, known, _ = _compute(form, tree, moved, held_seeds, workers)
        q[..., column] = places.reshape(-1, 1)
    else:
        targets = np.repeat(targets, k, axis=0)
        q, known = np.empty((n * k, layout.N_BRANCHES, tree.n_dof)), np.empty((n * k, layout.N_BRANCHES), dtype=np.int8)
        held_seeds[:, column] = places.ravel()
        for place in np.unique(places):  # one form for each position
            rows = np.flatnonzero(held_seeds[:, column] == place)
            q[rows], known[rows], _ = _compute(form, tree, targets[rows], held_seeds[rows], workers)
    held_seeds[:, column] = places.ravel()
    m = layout.N_BRANCHES * k
    real = ((known & layout.IS_REAL) > 0).reshape(n, m)
    proof = np.where(real.any(axis=1) & form.is_exact, PROOFS.index(Proof.CONTINUUM), PROOFS.index(Proof.SEARCHED))
    found = within_limits(_limits_of_form(form, tree), q, real.reshape(n * k, layout.N_BRANCHES), proof, held_seeds)
    return Branches(found.q.reshape(n, m, tree.n_dof), real, found.valid.reshape(n, m), proof)


class JointLimits(NamedTuple):
    """The limits of the entries of q, and how they are compared with a branch.

    Attributes:
        lower: Shape (n_dof,).
        upper: Shape (n_dof,).
        rounding: An entry beyond a limit by at most this counts as at the limit, shape (n_dof,).
        turning: Mask of the entries that may be turned by whole turns, shape (n_dof,).
    """

    lower: Array
    upper: Array
    rounding: Array
    turning: Truths


def limits_of(chain: Array, tree: Tree) -> JointLimits:
    """The limits of a robot's joints for the branches of a chain."""
    rounding = layout.AT_LIMIT * units_of(chain, tree.lower, tree.upper)
    return JointLimits(tree.lower, tree.upper, rounding, turning_columns(chain, tree.n_dof))


@lru_cache(maxsize=_MAX_FORMS)
def _limits_of_form(form: ClosedForm, tree: Tree) -> JointLimits:
    return limits_of(form.chain, tree)


def within_limits(limits: JointLimits, q: Array, real: Truths, proof: NDArray[np.int64], seeds: Array) -> Branches:
    """Bring branches near the seeds by whole turns, and put joints at a limit up to rounding at the limit."""
    lower, upper, at_limit, turning = limits
    q = nearest_turns(q, seeds[:, None], lower - at_limit, upper + at_limit, turning)
    valid = real & ((q >= lower - at_limit) & (q <= upper + at_limit)).all(axis=-1)
    q = np.where(valid[..., None], np.clip(q, lower, upper), np.where(real[..., None], q, np.nan))
    return Branches(q, real, valid, proof)


def _drop_added_joints(
    six: SixJoints, targets: Array, q: Array, known: NDArray[Any], lower: Array, upper: Array
) -> tuple[Array, NDArray[np.int64]]:
    """The branches of an arm of fewer than six joints, from those of the six joints: q and ``known``.

    1. If some added joints must be at rest, a branch in which they nearly are is a start for Newton steps of the other joints.
       These steps are needed at the end of a branch, where two branches meet. A rounded target rotates the added joints there by
       the square root of its rounding, and after two such ends by more. A start there that leads to no solution leaves it open
       whether there is one. A start within the limits leads to a solution within them, if there is one as exact.
    2. Drop a branch that differs from an earlier one only in added joints.
    """
    n_own, share = len(six.columns), six.table[layout.FORM, layout.INVERSE_REACH]
    known = known.astype(np.int64)
    real = (known & layout.IS_REAL) > 0
    own, at_rest, free = np.split(q, [n_own, N_AXES - six.n_free], axis=-1)
    own = np.ascontiguousarray(own)
    if at_rest.shape[-1]:
        at_end = (known & layout.IS_COINCIDING) > 0
        real &= np.abs(_wrapped(at_rest)).max(axis=-1) <= np.where(at_end, _MAX_REST_AT_END, _MAX_REST)
        order, branch = np.nonzero(real)
        starts = np.hstack([own[order, branch], free[order, branch]])
        angles, errors = _polish(six, targets[order], starts, np.empty(0))
        inside_rows = np.flatnonzero(known[order, branch] & layout.IS_WITHIN)
        inside, errors_inside = _polish(six, targets[order[inside_rows]], starts[inside_rows], np.r_[lower, upper])
        reached = errors_inside <= np.maximum(errors[inside_rows], layout.ENOUGH)
        angles[inside_rows[reached]] = inside[reached]
        own[order, branch], real[order, branch] = angles[:, :n_own], errors <= layout.REACHED
        lost = order[errors > layout.REACHED], branch[errors > layout.REACHED]
        known[lost] |= np.where(at_end[lost], layout.IS_HARDLY_DETERMINED, 0)
    real &= ~_is_repeated(np.where(six.slides, own * share, own), six.slides, real)
    return own, np.where(real, known | layout.IS_REAL, known & ~layout.IS_REAL)


def _polish(six: SixJoints, targets: Array, starts: Array, bounds: Array) -> tuple[Array, Array]:
    """The results (n, ...) of Newton steps from starts within bounds, and their errors (n,); joints at rest stay there."""
    q, errors, share = starts.copy(), np.full(len(starts), _MAX_REST), six.table[layout.FORM, layout.INVERSE_REACH]
    closed_form.polish_all(six.without_rest, targets, q, bounds, share, _STEPS, errors)
    return q, errors


def _is_repeated(q: Array, slides: Truths, real: Truths) -> NDArray[Any]:
    """Whether a solution repeats an earlier one, shape (n, 8)."""
    difference = q[:, :, None] - q[:, None]
    same = (np.abs(np.where(slides, difference, _wrapped(difference))) <= _DISTINCT).all(axis=-1)
    before = np.tri(layout.N_BRANCHES, k=-1, dtype=bool)
    return np.any(same & before & real[:, None], axis=-1)


def _wrapped(angle: Array) -> Array:
    """Angles wrapped to [-pi, pi)."""
    return np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi


class _HeldEnd(NamedTuple):
    """A held joint at an end of the chain. The targets for any position of the joint are moved to targets for position 0.

    1. The last joint: T = A M(x) B, so A M(0) B = T B^-1 M(x)^-1 M(0) B.
    2. The first joint: T = A M(x) B, so A M(0) B = A M(0) M(x)^-1 A^-1 T.

    Attributes:
        row: The row of the joint in the chain's table.
        is_last: Whether the joint is the last.
        left: The factor before M(x)^-1: B^-1 or A M(0), shape (4, 4).
        right: The factor behind M(x)^-1: M(0) B or A^-1, shape (4, 4).
    """

    row: Array
    is_last: bool
    left: Array
    right: Array

    def back_from(self, places: Array) -> Array:
        """M(x)^-1 at positions (n,), shape (n, 4, 4)."""
        return inverse(_motion_of(self.row, places))

    def at_zero(self, targets: Array, back: Array) -> Array:
        """The targets (n, 4, 4) for position 0. back: M(x)^-1, shape (n, 4, 4)."""
        return targets @ self.left @ back @ self.right if self.is_last else self.left @ back @ self.right @ targets


@lru_cache(maxsize=_MAX_FORMS)
def _held_end(form: ClosedForm) -> _HeldEnd | None:
    """The held joint of a form; None if it is at neither end of the chain."""
    chain = form.chain
    moving = [i for i, row in enumerate(chain) if int(row[KIND]) != FIXED and row[RATIO] != 0.0]
    own = [i for i in moving if int(chain[i][COLUMN]) == form.held_column]
    if len(own) != 1 or own[0] not in {moving[0], moving[-1]}:
        return None
    row, is_last = chain[own[0]], own[0] == moving[-1]
    zero = _motion_of(row, 0.0)
    if is_last:
        behind = _product(chain[own[0] + 1 :])
        return _HeldEnd(row, is_last, inverse(behind), zero @ behind)
    before = _product(chain[: own[0] + 1])
    return _HeldEnd(row, is_last, before @ zero, inverse(before))


@lru_cache(maxsize=_MAX_FORMS)
def _samples_of(form: ClosedForm, low: float, high: float, n_samples: int) -> tuple[Array, Array | None]:
    """Positions of the held joint, spread over its range, shape (n_samples,); the inverses of its motions, if it is at an end."""
    places, end = low + (np.arange(n_samples) + 0.5) / n_samples * (high - low), _held_end(form)
    return places, None if end is None else end.back_from(places)


def _motion_of(row: Array, places: float | Array) -> Array:
    """The motion of the joint of a table's row, shape (..., 4, 4), at positions (...)."""
    return motion_along_z(int(row[KIND]), row[RATIO] * places + row[OFFSET])


def _product(rows: Array) -> Array:
    """The pose of rows of a chain, without joint motion."""
    pose = np.eye(4)
    for row in rows:
        pose = pose @ row_pose(row)
    return pose
