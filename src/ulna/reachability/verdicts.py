"""Decides which poses a robot reaches, and numbers the statuses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.ik.result import CODES, Status
from ulna.ik.solutions import Proof
from ulna.reachability.specification import Specification
from ulna.robot import Robot

NOT_COMPUTED = -1  # the pose was not computed yet
REACHED = 1
NUMBERS = {
    Status.SOLVED: REACHED,
    Status.UNREACHABLE: 2,
    Status.BUDGET_SPENT: 3,
    Status.IN_COLLISION: 4,
    Status.JOINT_LIMITS: 5,
    Status.SINGULAR: 6,
    Status.NOT_FOUND: 8,
    Status.BEYOND_MAX_STEP: 9,
    Status.HELD_JOINTS: 10,
}
OF_CODES = np.full(1 + max(CODES.values()), NUMBERS[Status.NOT_FOUND], dtype=np.int8)  # by the codes of the kernels
for _status, _code in CODES.items():
    OF_CODES[_code] = NUMBERS[_status]
Array = NDArray[np.float64]


class Verdicts(NamedTuple):
    """The results for n poses.

    Attributes:
        reached: The numbers of their statuses, shape (n,).
        q: A solution for each reached pose, shape (n, n_dof).
        known: All known solutions, and the index of each one's pose: shapes (m, n_dof) and (m,).
        branches: The number of solutions, shape (n,); None if they are not counted.
    """

    reached: NDArray[np.int8]
    q: Array
    known: tuple[Array, NDArray[np.int64]]
    branches: NDArray[np.int8] | None


def verdicts(specification: Specification, robot: Robot, world: World | None, targets: Array) -> Verdicts:
    """The verdicts of targets, shape (n, 4, 4)."""
    if not specification.branches:
        reached, q = _search(specification, robot, world, targets)
        poses = np.flatnonzero(reached == REACHED)
        return Verdicts(reached, q, (q[poses], poses), None)
    return _solve_in_closed_form(specification, robot, world, targets)


def _search(specification: Specification, robot: Robot, world: World | None, targets: Array) -> tuple[NDArray[np.int8], Array]:
    result = robot.inverse_kinematics(targets, world=world, **specification.search)
    return OF_CODES[result.info["status"]], result.q


def _solve_in_closed_form(specification: Specification, robot: Robot, world: World | None, targets: Array) -> Verdicts:
    """The verdicts for an arm with a closed form, which finds all solutions; q is the one nearest to ``home``.

    If a joint may have any angle, the closed form returns examples. If none of these is usable, a numeric search follows.
    """
    solutions = robot.all_solutions(targets, link=specification.link, task=specification.task)
    usable = solutions.valid.copy()
    if world is not None:
        usable[usable] = ~robot.in_collision(solutions.q[usable], world)
    reached = np.full(len(targets), NUMBERS[Status.UNREACHABLE], dtype=np.int8)
    reached[solutions.real.any(axis=1)] = NUMBERS[Status.JOINT_LIMITS]
    reached[solutions.valid.any(axis=1)] = NUMBERS[Status.IN_COLLISION]
    reached[usable.any(axis=1)] = REACHED
    change = np.where(usable, np.abs(solutions.q - robot.home).max(axis=-1), np.inf)
    q = solutions.q[np.arange(len(targets)), change.argmin(axis=1)]
    known, poses = solutions.q[usable], np.nonzero(usable)[0]
    unsolved = np.flatnonzero(~usable.any(axis=1) & ~np.isin(solutions.proof, [Proof.COMPLETE, Proof.COINCIDING]))
    if len(unsolved):
        reached[unsolved], q[unsolved] = _search(specification, robot, world, targets[unsolved])
        newly_solved = unsolved[reached[unsolved] == REACHED]
        known, poses = np.concatenate([known, q[newly_solved]]), np.concatenate([poses, newly_solved])
    return Verdicts(reached, q, (known, poses), usable.sum(axis=1, dtype=np.int8))
