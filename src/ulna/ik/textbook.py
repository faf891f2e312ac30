"""The textbook methods by name: from the seed alone, wherever that leads."""

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.single_start import DAMPED_LEAST_SQUARES, JACOBIAN_TRANSPOSE, PSEUDO_INVERSE, follow_each
from ulna.errors import InputError
from ulna.ik.problem import Problem
from ulna.kernels.ik import search_layout as layout

Array = NDArray[np.float64]
_LONGEST_TRACE = 1_000_000
TEXTBOOK = {
    "jacobian_transpose": JACOBIAN_TRANSPOSE,
    "damped_least_squares": DAMPED_LEAST_SQUARES,
    "pseudo_inverse": PSEUDO_INVERSE,
}


def follow(problem: Problem, method: str, *, trace: bool) -> tuple[Array, Array, dict]:
    """q (n, n_dof), info (n, N_INFO) and the notes of the result."""
    n = len(problem.targets)
    if trace and problem.budget > _LONGEST_TRACE:
        raise InputError("max_iterations", f"{problem.budget}; a trace keeps at most {_LONGEST_TRACE} steps")
    q, info = np.empty((n, problem.tree.n_dof)), np.zeros((n, layout.N_INFO))
    settings = problem.settings.copy()
    settings[layout.STEPS] = problem.budget
    history = np.zeros((problem.budget + 1 if trace else 0, 4))
    follow_each(TEXTBOOK[method], problem.chain, problem.targets, problem.seeds, problem.bounds, settings, q, info, history)
    notes: dict = {"turn": problem.task.turn}
    if trace:
        notes["trace"] = history[: int(info[0, layout.ITERATIONS]) + 1]
    return q, info, notes
