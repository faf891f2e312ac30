"""The search itself: the method by its name, the kernel below, the result above."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError, did_you_mean
from ulna.ik.problem import Problem, make_problem, random_starts
from ulna.ik.result import IKResult, Status
from ulna.kernels.jacobian_transpose import transpose_each
from ulna.kernels.levenberg_marquardt import solve_each
from ulna.kernels.search_layout import (
    ITERATIONS,
    N_INFO,
    NOT_A_POSE,
    NOT_FOUND,
    POSITION_ERROR,
    ROTATION_ERROR,
    SOLVED,
    STATIONARY,
    STATUS,
)
from ulna.model.pose import as_pose
from ulna.model.tree import Tree

METHODS = ("levenberg_marquardt", "jacobian_transpose")
DEFAULT_ITERATIONS = {"levenberg_marquardt": 2000, "jacobian_transpose": 10_000}
_STATUS = np.zeros(4, dtype="<U16")
_STATUS[[SOLVED, NOT_FOUND, STATIONARY]] = Status.SOLVED, Status.NOT_FOUND, Status.STATIONARY


def inverse_kinematics(
    tree: Tree,
    T: ArrayLike,
    link: str,
    home: NDArray[np.float64],
    *,
    q_seed: ArrayLike | None,
    method: str,
    seed: int,
    posture: ArrayLike | None,
    tolerances: tuple[float, float],
    max_iterations: int | None,
) -> IKResult:
    """Configurations at which ``link`` stands at T; see ``Robot.inverse_kinematics``."""
    if method not in METHODS:
        raise InputError("method", f"{method!r} is not a method{did_you_mean(str(method), METHODS)}")
    if posture is not None and method != "levenberg_marquardt":
        raise InputError("posture", f"the method {method!r} takes none")
    if not tree.n_dof:
        raise InputError("T", "the robot has no moving joints, so nothing can be solved for")
    budget = DEFAULT_ITERATIONS[method] if max_iterations is None else max_iterations
    problem = make_problem(tree, T, home, q_seed, posture, tolerances, budget)
    limits, chain = np.array([tree.lower, tree.upper]), tree.chain(link)
    q, info = np.empty_like(problem.seeds), np.zeros((len(problem.targets), N_INFO))
    if method == "levenberg_marquardt":
        starts = random_starts(tuple(tree.lower), tuple(tree.upper), seed)
        solve_each(chain, limits, starts, problem.seeds, problem.posture, problem.targets, problem.settings, q, info)
    else:
        transpose_each(chain, limits, problem.seeds, problem.targets, problem.settings, q, info)
    if (info[:, STATUS] == NOT_A_POSE).any():
        as_pose(problem.targets.reshape(*problem.batch, 4, 4))
    return _result(problem, q, info, tolerances)


def _result(problem: Problem, q: NDArray[np.float64], info: NDArray[np.float64], tolerances: tuple[float, float]) -> IKResult:
    codes = info[:, STATUS].astype(np.int64)
    return IKResult(
        q=q.reshape(*problem.batch, -1),
        success=(codes == SOLVED).reshape(problem.batch)[()],
        status=_STATUS[codes].reshape(problem.batch)[()],
        position_error=info[:, POSITION_ERROR].reshape(problem.batch)[()],
        rotation_error=info[:, ROTATION_ERROR].reshape(problem.batch)[()],
        iterations=info[:, ITERATIONS].astype(np.int64).reshape(problem.batch)[()],
        tolerances=tolerances,
    )
