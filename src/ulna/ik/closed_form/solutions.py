"""Finds all solutions of targets, by closed form or by search, and says what is proved. Used by ``Robot.all_solutions``."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError
from ulna.ik.all_solutions import all_solutions
from ulna.ik.closed_form.branches import PROOFS, Branches, all_branches, sampled_branches
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of
from ulna.ik.closed_form.result import IKSolutions, Proof
from ulna.ik.closed_form.whole_turns import every_turn
from ulna.ik.problem import of_task
from ulna.ik.query import Query
from ulna.ik.turns import turning_columns
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_SAME = 1e-3  # rad or m: nearer than this to a branch of the closed form, what a search finds is that branch


def solutions(query: Query, T: ArrayLike, redundancy: str | None, n_samples: int, *, whole_turns: bool) -> IKSolutions:
    """See ``Robot.all_solutions``.

    Raises:
        InputError: T is not an array of poses, or ``redundancy`` is not a joint of an arm of seven.
        UnknownNameError: There is no such joint.
    """
    targets = as_pose(as_floats("T", T))
    if not n_samples:
        raise InputError("n_samples", "0; at least 1 is expected")
    batch, targets = targets.shape[:-2], np.ascontiguousarray(targets).reshape(-1, 4, 4)
    tree, form = query.tree, closed_form_of(query.tree, query.link, redundancy, query.options.task)
    found = _found(query, form, targets, n_samples)
    if whole_turns:
        found = _with_turns(tree, query.link, found)
    proof = np.array(PROOFS)[found.proof].reshape(batch)
    m, n_dof = found.q.shape[1:]
    return IKSolutions(
        q=found.q.reshape(*batch, m, n_dof),
        valid=found.valid.reshape(*batch, m),
        real=found.real.reshape(*batch, m),
        proof=proof if batch else Proof(str(proof)),
        family="" if form is None else form.family,
    )


def _found(query: Query, form: ClosedForm | None, targets: Array, n_samples: int) -> Branches:
    seeds, threads = query.home[None].copy(), query.options.threads
    if form is None:
        return _searched(query, targets, None)
    if form.held_column is not None:
        return sampled_branches(form, query.tree, of_task(query, targets), seeds, n_samples, threads)
    found = all_branches(form, query.tree, of_task(query, targets), seeds, threads)
    return found if form.is_exact else _searched(query, targets, found)


def _searched(query: Query, targets: Array, known: Branches | None) -> Branches:
    """What a search finds for each target, after what a closed form that is nearly right led to."""
    rows = []
    for i, T in enumerate(targets):
        first = np.empty((0, query.tree.n_dof)) if known is None else known.q[i, known.valid[i]]
        more = all_solutions(query, T, None, 16)
        new = [q for q in more if not (np.abs(first - q).max(axis=-1) < _SAME).any()]
        rows.append(np.vstack([first, *new]))
    q, real = _padded(rows, query.tree.n_dof)
    return Branches(q, real, real.copy(), np.full(len(targets), PROOFS.index(Proof.SEARCHED)))


def _padded(rows: list[Array], n_dof: int) -> tuple[Array, NDArray[np.bool_]]:
    """Rows of different lengths as one array, NaN where there is nothing, and where there is something."""
    m = max((len(row) for row in rows), default=0)
    q, real = np.full((len(rows), m, n_dof), np.nan), np.zeros((len(rows), m), dtype=bool)
    for i, row in enumerate(rows):
        q[i, : len(row)], real[i, : len(row)] = row, True
    return q, real


def _with_turns(tree: Tree, link: str, found: Branches) -> Branches:
    """Every solution with every whole turn within the limits; those beyond the limits are left out."""
    turning = turning_columns(tree.chain(link), tree.n_dof)
    turned = [[every_turn(q, tree.lower, tree.upper, turning) for q in found.q[i, found.valid[i]]] for i in range(len(found.q))]
    q, real = _padded([np.vstack([np.empty((0, tree.n_dof)), *rows]) for rows in turned], tree.n_dof)
    return Branches(q, real, real.copy(), found.proof)
