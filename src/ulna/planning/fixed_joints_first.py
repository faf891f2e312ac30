"""Holds the joints that have the same position at a start and a goal, as long as a path is found with them held.

Fingers that hold a part, the wheels of a base, a lift, a head, the other arm: what need not move stays. So searches with joints
held come first, each of a bounded number of edges, with fewer and fewer of them held:

1. All joints whose position is the same at both ends.
2. All but those that turn, farther along the chain of a joint that moves: the rest of an arm that goes round something.
3. All but these and those that turn, before it in the chain.
4. All but the joints of that chain and those that carry it: a lift, a torso, the slide of an arm.
5. None.

Each search has its near goals alone before it has all. The straight way to a far one may be free, as with another elbow, where
the way to a near one goes round an obstacle.

A chain ends where the robot branches: into joints, or a joint and a link without child links, as a hand and its one jaw.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import BASE, COLUMN, KIND, PARENT, REVOLUTE
from ulna.kinematics.tree import Tree
from ulna.planning.space import endless_entries

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_CHECKS = 3  # edges of a search, to the power of how many joints may move
_MAX_POWER = 7
_LONGER = 4  # times as many where the whole arm may move: only joints beside it are held then
_NOT_FAR, _CHECKS_NEAR = 2.0, 300  # times as far as the nearest goal; edges of a search for such goals alone
_MAX_GROUPS = 4  # of goals that agree with the start in the same entries


class Trial(NamedTuple):
    """A search with joints held, which comes before the one without.

    Attributes:
        fixed: Which entries of q keep their positions, shape (n_dof,).
        goals: Which of the goals it may end in: those that agree with the start in these entries, shape (n,).
        checks: How many edges it checks at most.
    """

    fixed: Mask
    goals: NDArray[np.int64]
    checks: int


def trials_of(tree: Tree, same: Mask, fixed: Mask) -> list[Trial]:
    """The searches with joints held, in order; none where no joint that may move has the same position at both ends.

    same: which entries of each goal are those of the start, shape (n, n_dof), the nearest goal first; fixed: those that keep
    their positions anyway, shape (n_dof,).
    """
    still = same & ~fixed
    still[(still | fixed).all(axis=1)] = False  # a goal that is the start
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
        trials += [Trial(mask, goals, checks) for mask, checks in _held_in_turn(tree, masks[k], fixed, alone=alone)]
    return trials


def near_first(trials: Iterable[Trial], lengths: Array) -> list[Trial]:
    """The trials, each after one for the near of its goals, if these are not all.

    lengths: how far the goals are from the start, shape (n,).
    """
    found = []
    for trial in trials:
        far = lengths[trial.goals]
        near = trial.goals[far <= _NOT_FAR * far.min()]
        if len(near) < len(far):
            found.append(Trial(trial.fixed, near, min(trial.checks, _CHECKS_NEAR)))
        found.append(trial)
    return found


def arm_beyond(tree: Tree, moved: Mask) -> Mask:
    """Which entries of q turn joints farther along the chain of a joint that moves, shape (n_dof,).

    moved: which entries of q move joints, shape (n_dof,).
    """
    parents, columns, n_children = _rows(tree)
    beyond, found = np.zeros(len(parents), dtype=bool), np.zeros(tree.n_dof, dtype=bool)
    for row, parent in enumerate(parents.tolist()):  # a parent comes before its children
        if parent != BASE and n_children[parent] == 1:
            beyond[row] = beyond[parent] or moved[columns[parent]]
    found[columns[beyond]] = True
    return found & _turns_alone(tree) & ~moved


def arm_of(tree: Tree, moved: Mask) -> Mask:
    """Which entries of q turn joints of the chain of a joint that moves, shape (n_dof,)."""
    parents, columns, n_children = _rows(tree)
    before, found = moved[columns], arm_beyond(tree, moved)
    for row in range(len(parents) - 1, -1, -1):
        if parents[row] != BASE and n_children[parents[row]] == 1 and before[row]:
            before[parents[row]] = True
    found[columns[before]] = True
    return found & _turns_alone(tree) & ~moved


def _held_in_turn(tree: Tree, still: Mask, fixed: Mask, *, alone: bool) -> list[tuple[Mask, int]]:
    """The entries of q held in each search and its checks, most held first, for goals that agree with the start in ``still``.

    Without searches in which there is only the straight way; and, if these are all the goals, without that of ``fixed`` itself.
    """
    moved, endless = ~(still | fixed), endless_entries(tree)
    arms = np.zeros_like(moved), arm_beyond(tree, moved), arm_of(tree, moved)
    found: list[tuple[Mask, int]] = []
    for free, longer in (*((arm, 1) for arm in arms[:2]), (arms[2], _LONGER), (_chain_of(tree, moved), _LONGER)):
        mask = fixed | (still & ~free)
        is_last = alone and np.array_equal(mask, fixed)
        is_straight = np.count_nonzero(~mask) == 1 and not endless[~mask].any()
        if is_last or is_straight:
            continue
        if found and np.array_equal(mask, found[-1][0]):
            found.pop()
        found.append((mask, longer * _checks_for(mask)))
    return found


def _chain_of(tree: Tree, moved: Mask) -> Mask:
    """Which entries of q move joints of the chains in which joints move, or joints that carry these, shape (n_dof,)."""
    parents, columns, n_children = _rows(tree)
    of_chain, found = moved[columns], np.zeros(tree.n_dof, dtype=bool)
    for row, parent in enumerate(parents.tolist()):
        if parent != BASE and n_children[parent] == 1 and of_chain[parent]:
            of_chain[row] = True
    for row in range(len(parents) - 1, -1, -1):
        if parents[row] != BASE and of_chain[row]:
            of_chain[parents[row]] = True
    found[columns[of_chain]] = True
    return found


def _rows(tree: Tree) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Of each row of the table of joints: the row that carries it, the entry of q that moves it, and how much it carries itself.

    That counts rows, and links without child links.
    """
    parents, columns = (tree.joints[:, column].astype(np.int64) for column in (PARENT, COLUMN))
    carriers = [row for row in (*parents.tolist(), *(tree.link_row[link] for link in tree.leaves)) if row != BASE]
    return parents, columns, np.bincount(np.array(carriers, dtype=np.int64), minlength=len(parents))


def _turns_alone(tree: Tree) -> Mask:
    """Which entries of q turn joints and are all of their position: neither slides, nor those of a base that moves in a plane."""
    found = np.zeros(tree.n_dof, dtype=bool)
    for part in tree.joint_slices:
        found[part] = part.stop - part.start == 1
    slides = tree.joints[:, KIND] != REVOLUTE
    columns = tree.joints[slides, COLUMN].astype(np.int64)
    found[columns] = False
    return found


def _checks_for(fixed: Mask) -> int:
    """Edges that a search may check with these entries of q held: the more joints may move, the larger the space is."""
    return _CHECKS ** min(int(np.count_nonzero(~fixed)), _MAX_POWER)
