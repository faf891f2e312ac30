"""The textbook methods by name: from the seed alone, wherever that leads."""

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import entry
from ulna.engine.threads import in_parts
from ulna.errors import InputError
from ulna.ik.problem import Problem
from ulna.kernels.ik import search_layout as layout

Array = NDArray[np.float64]
LEAST_TARGETS = 64  # of a part
_LONGEST_TRACE = 1_000_000
TEXTBOOK = {
    "jacobian_transpose": layout.JACOBIAN_TRANSPOSE,
    "damped_least_squares": layout.DAMPED_LEAST_SQUARES,
    "pseudo_inverse": layout.PSEUDO_INVERSE,
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
    follow_each = entry("single_start.follow_each")

    def run(part: slice) -> bool:
        seeds, bounds = (rows[part] if len(rows) > 1 else rows for rows in (problem.seeds, problem.bounds))
        follow_each(TEXTBOOK[method], problem.chain, problem.targets[part], seeds, bounds, settings, q[part], info[part], history)
        return True

    in_parts(run, n, LEAST_TARGETS, problem.threads)
    notes: dict = {"turn": problem.task.turn}
    if trace:
        notes["trace"] = history[: int(info[0, layout.ITERATIONS]) + 1]
    return q, info, notes
