"""The search itself: the method by its name, the kernel below, the result above."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError, did_you_mean
from ulna.ik.problem import as_count, make_problem, random_starts
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
_STATUS = {SOLVED: Status.SOLVED, NOT_FOUND: Status.NOT_FOUND, STATIONARY: Status.STATIONARY}


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
    chain, n = tree.chain(link), len(problem.targets)
    q, info = np.empty((n, tree.n_dof)), np.empty((n, N_INFO))
    if method == "levenberg_marquardt":
        starts = random_starts(tree.bounds, as_count("seed", seed))
        solve_each(chain, tree.limits, starts, problem.seeds, problem.posture, problem.targets, problem.settings, q, info)
    else:
        transpose_each(chain, tree.limits, problem.seeds, problem.targets, problem.settings, q, info)
    result = _one(q, info, tolerances) if not problem.batch else _many(problem.batch, q, info, tolerances)
    if result is None:
        as_pose(problem.targets.reshape(*problem.batch, 4, 4))
        raise InputError("T", "is further than 1e-6 from a rigid motion, so it is not a pose")  # by the last bit only
    return result


def _one(q: NDArray[np.float64], info: NDArray[np.float64], tolerances: tuple[float, float]) -> IKResult | None:
    """The result for one target; None if it was not a pose."""
    status, position_error, rotation_error, iterations = info[0].tolist()
    if status == NOT_A_POSE:
        return None
    return IKResult(q[0], status == SOLVED, _STATUS[status], position_error, rotation_error, int(iterations), tolerances)


def _many(
    batch: tuple[int, ...], q: NDArray[np.float64], info: NDArray[np.float64], tolerances: tuple[float, float]
) -> IKResult | None:
    """The result for a batch; None if a target was not a pose."""
    status = info[:, STATUS]
    if (status == NOT_A_POSE).any():
        return None
    words = np.empty(len(info), dtype="<U16")
    for code, word in _STATUS.items():
        words[status == code] = word
    return IKResult(
        q=q.reshape(*batch, q.shape[-1]),
        success=(status == SOLVED).reshape(batch),
        status=words.reshape(batch),
        position_error=info[:, POSITION_ERROR].reshape(batch),
        rotation_error=info[:, ROTATION_ERROR].reshape(batch),
        iterations=info[:, ITERATIONS].astype(np.int64).reshape(batch),
        tolerances=tolerances,
    )
