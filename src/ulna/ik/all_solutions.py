"""Finds all solutions of targets, by closed form or by search, and states what is proved."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_floats, as_switch
from ulna.description.pose import as_pose
from ulna.engine.bound import bind
from ulna.errors import InputError
from ulna.ik.closed_form.axes import N_AXES, turning_order
from ulna.ik.closed_form.branches import Branches, all_branches, limits_of, sampled_branches, within_limits
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of, joints_at
from ulna.ik.closed_form.elbow import ELBOW, FAMILY, Elbow, elbow_of
from ulna.ik.closed_form.six_joints import Workers
from ulna.ik.entries import closed_form
from ulna.ik.problem import Query, make_problem, of_task
from ulna.ik.search.branch_search import searched_solutions
from ulna.ik.search.ranking import collisions_of, cost_of, refuse_clearance_of_nothing
from ulna.ik.solutions import PROOFS, IKSolutions, Proof
from ulna.kernels.chain.closed_form_layout import N_BRANCHES, UNPROVED
from ulna.kernels.ik.search_layout import WHOLE_POSE
from ulna.kinematics.positions import as_configuration
from ulna.kinematics.tree import Tree, entry_names
from ulna.kinematics.turns import all_turns, turning_columns

Array = NDArray[np.float64]
_One = tuple[Array, NDArray[np.bool_], NDArray[np.bool_], int]
_ONE, _MATRIX, _TRUTHS = (N_BRANCHES, N_AXES), (4, 4), (2, N_BRANCHES)
# rad, or a share of the arm's size for a prismatic joint: a search result nearer than this to a branch is that branch
_SAME = 1e-3


class AllSolutions:
    """All solutions for one link and task; made once, for any number of targets.

    Args:
        query: The link and the options.
        redundancy: The joint to hold, for arms of seven joints, or ``"elbow"``.
        workers: Computes the branches in place of threads, if given.
    """

    __slots__ = ("_elbow", "_family", "_form", "_of_one", "_query", "_run", "_six_joints", "_tables", "_workers")

    def __init__(self, query: Query, redundancy: str | None, workers: Workers = None) -> None:
        self._query, self._workers, tree = query, workers, query.tree
        if redundancy is not None and not isinstance(redundancy, str):
            raise InputError("redundancy", f"{redundancy!r}; the name of a joint, or 'elbow', is expected")
        by_elbow = redundancy == ELBOW and ELBOW not in entry_names(tree)
        self._elbow = _elbow(query) if by_elbow else None
        self._form = form = None if by_elbow else closed_form_of(tree, query.link, redundancy, query.options.task)
        if redundancy is not None and not by_elbow and form is None:
            raise InputError("redundancy", f"{redundancy!r}; {_joints_to_hold(query)}")
        self._family = FAMILY if self._elbow else "" if form is None else form.geometry
        self._six_joints = None
        in_order = form is not None and form.is_exact and form.columns == tuple(range(N_AXES)) and tree.n_dof == N_AXES
        if form is not None and in_order and not form.couplings and query.task_axes is None and workers is None:
            self._six_joints = joints_at(form, query.home)
            self._tables = (
                self._six_joints.table,
                self._six_joints.chain,
                self._six_joints.plan(tree.lower, tree.upper),
                query.home.copy(),
            )
            self._run = closed_form.all_branches_of_one
        self._of_one = None if self._six_joints is None else self._one_by_entry()

    def all_solutions(
        self, T: ArrayLike, n_samples: int, *, whole_turns: bool, q_seed: ArrayLike | None = None, world: World | None = None
    ) -> IKSolutions:
        """See ``Robot.all_solutions``."""
        rank = self._query.options.rank
        if whole_turns is not False:
            as_switch("whole_turns", whole_turns)
        if not whole_turns and q_seed is None and world is None and rank is None and (one := self.of_one(T)) is not None:
            return one
        refuse_clearance_of_nothing(rank, world)
        targets = as_floats("T", T)
        if self._six_joints is None or targets.shape[-2:] != _MATRIX:  # the kernel of six joints finds targets that are no poses
            targets = as_pose(targets)
        batch, targets = targets.shape[:-2], np.ascontiguousarray(targets).reshape(-1, 4, 4)
        query, tree = self._query, self._query.tree
        seed = query.home.copy() if q_seed is None else np.clip(as_configuration(q_seed, tree, "q_seed"), tree.lower, tree.upper)
        if self._elbow is not None:
            found = _elbow_branches(query, self._elbow, targets, seed, n_samples)
        else:
            found = _found(query, self._form, targets, seed, n_samples, self._workers)
        if (found.proof < 0).any():
            as_pose(targets.reshape(*batch, 4, 4))
        if whole_turns:
            found = _add_turns(tree, query.link, found)
        colliding = np.zeros(len(targets), dtype=np.int64)
        if world is not None or rank is not None:
            found, colliding = _rank(query, targets, seed, found, world)
        m, n_dof = found.q.shape[1:]
        q, valid, real = found.q.reshape(*batch, m, n_dof), found.valid.reshape(*batch, m), found.real.reshape(*batch, m)
        if not batch:
            return IKSolutions(q, valid, real, PROOFS[found.proof[0]], self._family, int(colliding[0]))
        return IKSolutions.of_many(q, valid, real, found.proof.reshape(batch), self._family, colliding.reshape(batch))

    def of_one(self, T: ArrayLike) -> IKSolutions | None:
        """All solutions for one target, by one call of the kernels; None if this is impossible or proves nothing."""
        found = None if self._of_one is None else self._of_one(T)
        if found is None:
            return None
        q, valid, real, proved = found
        return IKSolutions.of_one(q, valid, real, PROOFS[proved], self._family)

    def _one_by_entry(self) -> Callable[[ArrayLike], _One | None]:
        """The function for one target, in C if the extension is there."""
        return bind(self._run, "branches", self._tables, N_AXES, (N_BRANCHES, UNPROVED), self._in_python)

    def _in_python(self, T: ArrayLike) -> _One | None:
        """q, valid, real and the index of the proof; None for anything but one pose, or if nothing is proved."""
        target = as_floats("T", T)
        if target.shape != _MATRIX:
            return None
        q, truths = np.empty(_ONE), np.empty(_TRUTHS, dtype=np.bool_)
        proved = self._run(*self._tables, target, q, truths)
        q.setflags(write=False)
        truths.setflags(write=False)
        return (q, truths[0], truths[1], proved) if 0 <= proved < UNPROVED else None


def _joints_to_hold(query: Query) -> str:
    """The joints that may be held for a closed form, in words."""
    tree = query.tree
    order = turning_order(tree.chain(query.link))
    names = [name for k, name in enumerate(entry_names(tree)) if k in order and closed_form_of(tree, query.link, name)]
    if not names or query.options.task.kind != WHOLE_POSE:
        return "there is no closed form with this joint held, nor with another"
    return f"there is no closed form with this joint held; there is one with {', '.join(names)}"


def _elbow(query: Query) -> Elbow:
    elbow = elbow_of(query.tree, query.link) if query.options.task.kind == WHOLE_POSE and query.task_axes is None else None
    if elbow is None:
        raise InputError("redundancy", "'elbow': that is an angle of arms of seven joints with a spherical shoulder and wrist")
    return elbow


def _rank(query: Query, targets: Array, seed: Array, found: Branches, world: World | None) -> tuple[Branches, NDArray[np.int64]]:
    """Mark colliding solutions as not valid, count them, and sort by the rank if there is one.

    Solutions that are not valid come last.
    """
    collisions = collisions_of(query, world)
    cost, (order, place) = cost_of(make_problem(query, targets, seed), collisions), np.nonzero(found.valid)
    costs, valid = np.full(found.valid.shape, np.inf), np.zeros(found.valid.shape, dtype=bool)
    if cost is not None and len(order):
        of_valid = cost(order, found.q[order, place])
        costs[order, place], valid[order, place] = of_valid.of_acceptable(), of_valid.acceptable
    colliding = (found.valid & ~valid).sum(axis=1)
    if query.options.rank is None:
        return replace(found, valid=valid), colliding
    order_by_cost = np.argsort(costs, axis=1, kind="stable")
    real, valid = (np.take_along_axis(each, order_by_cost, axis=1) for each in (found.real, valid))
    return Branches(np.take_along_axis(found.q, order_by_cost[..., None], axis=1), real, valid, found.proof), colliding


def _elbow_branches(query: Query, elbow: Elbow, targets: Array, seed: Array, n_samples: int) -> Branches:
    """The branches at sampled elbow angles."""
    angles, real = elbow.branches(targets, n_samples)
    q = np.broadcast_to(seed, (*real.shape, query.tree.n_dof)).copy()
    q[..., list(elbow.columns)] = angles
    proof = np.where(real.any(axis=1), PROOFS.index(Proof.CONTINUUM), PROOFS.index(Proof.SEARCHED))
    found = within_limits(limits_of(query.chain, query.tree), q, real, proof, seed[None])
    return _add_searched(query, targets, seed, n_samples, found, ~real.any(axis=1))


def _found(query: Query, form: ClosedForm | None, targets: Array, seed: Array, n_samples: int, workers: Workers) -> Branches:
    seeds = seed[None]
    if form is None:
        return _searched(query, targets, seed, n_samples, None)
    if form.held_column is not None:
        found = sampled_branches(form, query.tree, of_task(query, targets), seeds, n_samples, workers)
        return _add_searched(query, targets, seed, n_samples, found, ~found.real.any(axis=1))
    found = all_branches(form, query.tree, of_task(query, targets), seeds, workers)
    if form.is_exact:
        return _add_searched(query, targets, seed, n_samples, found, found.proof == PROOFS.index(Proof.SEARCHED))
    return _searched(query, targets, seed, n_samples, found)


def _add_searched(query: Query, targets: Array, seed: Array, n_samples: int, found: Branches, which: ArrayLike) -> Branches:
    """Add solutions from a search to the branches of some of the targets; which: A mask, shape (n,)."""
    n, m, n_dof = found.q.shape
    new = {int(i): _new_solutions(query, targets[i], seed, n_samples, found.q[i, found.valid[i]]) for i in np.flatnonzero(which)}
    width = m + max(map(len, new.values()), default=0)
    if width == m:
        return found
    q, real, valid = np.full((n, width, n_dof), np.nan), np.zeros((n, width), dtype=bool), np.zeros((n, width), dtype=bool)
    q[:, :m], real[:, :m], valid[:, :m] = found.q, found.real, found.valid
    for i, rows in new.items():
        q[i, m : m + len(rows)], real[i, m : m + len(rows)], valid[i, m : m + len(rows)] = rows, True, True
    return Branches(q, real, valid, found.proof)


def _new_solutions(query: Query, T: Array, seed: Array, n_samples: int, known: Array) -> Array:
    """Solutions from a search for a target (4, 4) that are not among the known ones, shape (n, n_dof)."""
    searched = searched_solutions(query, T, seed, n_samples)
    is_new = [not (np.abs((known - q) / query.units).max(axis=-1) < _SAME).any() for q in searched]
    return searched[np.array(is_new, dtype=bool)]


def _searched(query: Query, targets: Array, seed: Array, n_samples: int, known: Branches | None) -> Branches:
    """Solutions from a search for each target, after those from a nearly exact closed form."""
    rows = []
    for i, T in enumerate(targets):
        first = np.empty((0, query.tree.n_dof)) if known is None else known.q[i, known.valid[i]]
        rows.append(np.vstack([first, _new_solutions(query, T, seed, n_samples, first)]))
    q, real = _pad(rows, query.tree.n_dof)
    return Branches(q, real, real.copy(), np.full(len(targets), PROOFS.index(Proof.SEARCHED)))


def _pad(rows: list[Array], n_dof: int) -> tuple[Array, NDArray[np.bool_]]:
    """Pack rows of different lengths into one array, padded with NaN, and a mask of the entries in use."""
    m = max((len(row) for row in rows), default=0)
    q, real = np.full((len(rows), m, n_dof), np.nan), np.zeros((len(rows), m), dtype=bool)
    for i, row in enumerate(rows):
        q[i, : len(row)], real[i, : len(row)] = row, True
    return q, real


def _add_turns(tree: Tree, link: str, found: Branches) -> Branches:
    """Every solution with every whole turn within the limits; solutions beyond the limits are left out."""
    turning = turning_columns(tree.chain(link), tree.n_dof)
    turned = [[all_turns(q, tree.lower, tree.upper, turning) for q in found.q[i, found.valid[i]]] for i in range(len(found.q))]
    q, real = _pad([np.vstack([np.empty((0, tree.n_dof)), *rows]) for rows in turned], tree.n_dof)
    return Branches(q, real, real.copy(), found.proof)
