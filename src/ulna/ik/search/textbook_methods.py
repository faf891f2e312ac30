"""Solves by the textbook methods: from the seed alone, wherever that leads."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.drivers import single_start
from ulna.engine.threads import in_parts
from ulna.errors import InputError
from ulna.ik.options import TEXTBOOK_BUDGET
from ulna.ik.problem import Problem, Query, make_problem, refuse_no_pose
from ulna.ik.reason import Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.units import solved_in_unit, too_far
from ulna.kernels.ik import search_layout as layout

Array = NDArray[np.float64]
_LEAST_TARGETS = 64  # of a part
_LONGEST_TRACE = 1_000_000
_CODES = {
    "jacobian_transpose": layout.JACOBIAN_TRANSPOSE,
    "damped_least_squares": layout.DAMPED_LEAST_SQUARES,
    "pseudo_inverse": layout.PSEUDO_INVERSE,
}


class TextbookSolver:
    """Jacobian transpose, damped least squares and pseudo-inverse steps, for teaching; see ``ik.inverse_kinematics.Solver``."""

    in_c: tuple | None = None

    def __init__(self, query: Query) -> None:
        options = query.options
        if options.trace and options.budget > _LONGEST_TRACE:
            raise InputError("max_iterations", f"{options.budget}; a trace keeps at most {_LONGEST_TRACE} steps")
        self._query = query

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult:
        """Where the method's steps lead from the seed."""
        options = self._query.options
        problem = make_problem(self._query, T, q_seed, None, held)
        for name, given in (("posture", posture), ("world", world)):
            if given is not None:
                raise options.refused_by_textbook(name)
        q, info, history = _follow(problem)
        if (info[:, layout.STATUS] == layout.NOT_A_POSE).any():
            refuse_no_pose(T)
        if options.budget < TEXTBOOK_BUDGET:
            info[info[:, layout.STATUS] == layout.NOT_FOUND, layout.STATUS] = CODES[Status.BUDGET_SPENT]
        trace = history[: int(info[0, layout.ITERATIONS]) + 1] if options.trace else None
        explanation = Explanation(task_axes=self._query.task_axes, trace=trace)
        return IKResult(q.reshape(*problem.batch, q.shape[-1]), info, problem.batch, options.tolerances, explanation)


def _follow(problem: Problem) -> tuple[Array, Array, Array]:
    """q (n, n_dof), info (n, N_INFO), and for one target with a trace the history of its steps (steps + 1, 4)."""
    options, unit = problem.query.options, problem.query.unit
    history = np.zeros((options.budget + 1 if options.trace else 0, 4))
    order = np.arange(len(problem.targets))
    q, info = solved_in_unit(problem, order, lambda problem, order: _follow_some(problem, order, history))
    if options.trace and not too_far(problem, order, unit).any():
        history[:, 0] *= unit
    return q, info, history


def _follow_some(problem: Problem, order: NDArray[np.int64], history: Array) -> tuple[Array, Array]:
    """q (m, n_dof) and info (m, N_INFO) of some targets (m,)."""
    options, some = problem.query.options, problem.some(order)
    q, info = np.empty((len(order), problem.query.tree.n_dof)), np.zeros((len(order), layout.N_INFO))
    settings = problem.settings.copy()
    settings[layout.STEPS] = options.budget
    method, follow_each = _CODES[options.method], single_start.follow_each

    def run(part: slice) -> bool:
        seeds, bounds = (rows[part] if len(rows) > 1 else rows for rows in (some.seeds, some.bounds))
        follow_each(method, problem.chain, some.targets[part], seeds, bounds, settings, q[part], info[part], history)
        return True

    in_parts(run, len(order), _LEAST_TARGETS, options.threads)
    return q, info
