"""Plans trials that hold joints with the same position at the start and the goal, before trials that move them.

Joints that need not move should stay: fingers that hold a part, the wheels of a base, a lift, a head, the other arm. Trials with
a bounded number of edges hold these sets of joints, in order:

1. All joints with the same position at both ends.
2. All of these except the revolute joints farther along the chain of a moving joint: the rest of an arm that avoids something.
3. All of these except the revolute joints of the whole chain.
4. All of these except the joints of the chain and the joints that carry it: a lift, a torso, the slide of an arm.
5. None.

Each trial is first limited to its near goals. Otherwise a free straight edge to a far goal, such as another elbow, would win
against a path around an obstacle to a near goal.

A chain ends where the robot branches into several joints, or into a joint and a leaf link, such as a hand with one jaw.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import BASE, COLUMN, KIND, PARENT, REVOLUTE
from ulna.kinematics.tree import Tree
from ulna.planning.space import endless_entries

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_CHECKS = 3  # a trial with n free entries checks at most this number to the power n
_MAX_POWER = 7
_ARM_FACTOR = 4  # factor of the edges of a trial in which the whole arm may move
_NEAR_RATIO, _CHECKS_NEAR = 2.0, 300  # near goals: distance relative to the nearest goal; edges of their trial
_MAX_TREES = 16  # entries of the caches
_MAX_GROUPS = 4  # maximum number of groups of goals that agree with the start in the same entries


class Trial(NamedTuple):
    """A search with joints held.

    Attributes:
        fixed: Mask of the entries of q that keep their positions, shape (n_dof,).
        goals: The indices of its goals, which agree with the start in these entries, shape (n,).
        checks: The maximum number of edges that it checks.
    """

    fixed: Mask
    goals: NDArray[np.int64]
    checks: int


def make_trials(tree: Tree, same: Mask, fixed: Mask) -> list[Trial]:
    """The trials with joints held, in order; none if no free joint has the same position at both ends.

    same: mask of each goal's entries that equal the start's, shape (n, n_dof), nearest goal first. fixed: mask of the entries
    that are fixed in every trial, shape (n_dof,).
    """
    still = same & ~fixed
    still[(still | fixed).all(axis=1)] = False  # goals equal to the start
    if not still.any():
        return []
    masks, group = np.unique(still, axis=0, return_inverse=True)
    group = group.reshape(-1)
    if len(masks) > _MAX_GROUPS:
        masks, group = np.logical_and.reduce(still, axis=0, keepdims=True), np.zeros(len(still), dtype=np.int64)
    trials = []
    for k in dict.fromkeys(group.tolist()):
        goals = np.flatnonzero(group == k)
        alone = len(masks) == 1
        trials += [Trial(mask, goals, checks) for mask, checks in _held_sets(tree, masks[k], fixed, alone=alone)]
    return trials


def prepend_near_trials(trials: Iterable[Trial], lengths: Array) -> list[Trial]:
    """Put before each trial a trial with its near goals only, if not all its goals are near.

    lengths: the distances of the goals from the start, shape (n,).
    """
    found = []
    for trial in trials:
        far = lengths[trial.goals]
        near = trial.goals[far <= _NEAR_RATIO * far.min()]
        if len(near) < len(far):
            found.append(Trial(trial.fixed, near, min(trial.checks, _CHECKS_NEAR)))
        found.append(trial)
    return found


def distal_joints(tree: Tree, moved: Mask) -> Mask:
    """Mask of the entries of q of revolute joints farther along the chain of a moving joint, shape (n_dof,).

    moved: mask of the entries of q that move, shape (n_dof,).
    """
    parents, columns, n_children = _joint_rows(tree)
    beyond, found = np.zeros(len(parents), dtype=bool), np.zeros(tree.n_dof, dtype=bool)
    for row, parent in enumerate(parents.tolist()):  # a parent comes before its children
        if parent != BASE and n_children[parent] == 1:
            beyond[row] = beyond[parent] or moved[columns[parent]]
    found[columns[beyond]] = True
    return found & _revolute_entries(tree) & ~moved


def chain_joints(tree: Tree, moved: Mask) -> Mask:
    """Mask of the entries of q of revolute joints in the chain of a moving joint, shape (n_dof,)."""
    parents, columns, n_children = _joint_rows(tree)
    before, found = moved[columns], distal_joints(tree, moved)
    for row in range(len(parents) - 1, -1, -1):
        if parents[row] != BASE and n_children[parents[row]] == 1 and before[row]:
            before[parents[row]] = True
    found[columns[before]] = True
    return found & _revolute_entries(tree) & ~moved


def _held_sets(tree: Tree, still: Mask, fixed: Mask, *, alone: bool) -> list[tuple[Mask, int]]:
    """The mask of held entries of q and the maximum number of checks of each trial, most held first.

    still: mask of the entries in which the goals equal the start. Trials with only one free entry are left out, since they have
    only the straight edge. If ``alone``, the trial with only ``fixed`` held is left out too, since it comes last.
    """
    moved, endless = ~(still | fixed), endless_entries(tree)
    arms = np.zeros_like(moved), distal_joints(tree, moved), chain_joints(tree, moved)
    found: list[tuple[Mask, int]] = []
    for free, longer in (*((arm, 1) for arm in arms[:2]), (arms[2], _ARM_FACTOR), (_supporting_chain(tree, moved), _ARM_FACTOR)):
        mask = fixed | (still & ~free)
        is_last = alone and np.array_equal(mask, fixed)
        is_straight = np.count_nonzero(~mask) == 1 and not endless[~mask].any()
        if is_last or is_straight:
            continue
        if found and np.array_equal(mask, found[-1][0]):
            found.pop()
        found.append((mask, longer * _max_checks(mask)))
    return found


def _supporting_chain(tree: Tree, moved: Mask) -> Mask:
    """Mask of the entries of q that move the chains of moving joints or carry these, shape (n_dof,)."""
    parents, columns, n_children = _joint_rows(tree)
    of_chain, found = moved[columns], np.zeros(tree.n_dof, dtype=bool)
    for row, parent in enumerate(parents.tolist()):
        if parent != BASE and n_children[parent] == 1 and of_chain[parent]:
            of_chain[row] = True
    for row in range(len(parents) - 1, -1, -1):
        if parents[row] != BASE and of_chain[row]:
            of_chain[parents[row]] = True
    found[columns[of_chain]] = True
    return found


@lru_cache(maxsize=_MAX_TREES)
def _joint_rows(tree: Tree) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The parent row, the entry of q and the number of children (rows, leaf links) of each joint row."""
    parents, columns = (tree.joints[:, column].astype(np.int64) for column in (PARENT, COLUMN))
    carriers = [row for row in (*parents.tolist(), *(tree.link_row[link] for link in tree.leaves)) if row != BASE]
    return parents, columns, np.bincount(np.array(carriers, dtype=np.int64), minlength=len(parents))


@lru_cache(maxsize=_MAX_TREES)
def _revolute_entries(tree: Tree) -> Mask:
    """Mask of the entries of q of revolute joints: neither slides nor parts of planar or floating joints, shape (n_dof,)."""
    found = np.zeros(tree.n_dof, dtype=bool)
    for part in tree.joint_slices:
        found[part] = part.stop - part.start == 1
    slides = tree.joints[:, KIND] != REVOLUTE
    columns = tree.joints[slides, COLUMN].astype(np.int64)
    found[columns] = False
    return found


def _max_checks(fixed: Mask) -> int:
    """The maximum number of edges of a trial; it grows with the number of free entries of q."""
    return _CHECKS ** min(int(np.count_nonzero(~fixed)), _MAX_POWER)
