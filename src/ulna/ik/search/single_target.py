"""Solves for one pose from up to 64 starts: the fast path of default options."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.drivers import multi_start
from ulna.engine.bound import bind
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import SEEDED_STEPS, STEPS, Query, make_problem
from ulna.ik.reason import Explanation
from ulna.ik.result import IKResult
from ulna.ik.search.numeric import convergence
from ulna.ik.search.starts import unit_samples
from ulna.kernels.ik import search_layout as layout

Array = NDArray[np.float64]
_STARTS = 64  # eight in each lane; the next solver takes a target that needs more
_MATRIX, _OF_INFO = (4, 4), (1, layout.N_INFO)
OfOneTarget = Callable[[ArrayLike, ArrayLike], tuple[Array, Array] | None]
"""From T and a start to q (n_dof,) and its information (1, N_INFO); None if this is not one target, or it is not solved."""


def bound_to_one_target(run: Any, tables: tuple[Array, ...], home: Array) -> OfOneTarget:
    """The entry ``run(*tables, T, start, q, info)``, in C if the extension is there. ``home`` as a start is not checked."""
    n, of_q = len(home), (1, len(home))

    def in_python(T: ArrayLike, start: ArrayLike) -> tuple[Array, Array] | None:
        T = as_floats("T", T)
        if T.shape != _MATRIX:
            return None
        if start is not home:
            start = as_floats("q_seed", start)
            if start.shape != (n,):
                return None
        q, info = np.empty(of_q), np.empty(_OF_INFO)
        return (q[0], info) if run(*tables, T, start, q, info) else None

    return bind(run, "search", tables, n, (layout.N_INFO,), in_python) or in_python


class SingleTargetSolver:
    """The fast path of one target with default options; see ``ik.inverse_kinematics.Solver``.

    ``solve`` may be called from many threads at once: nothing that it writes to is shared.
    """

    __slots__ = ("_from_home", "_from_seed", "_query", "_tolerances", "_trace", "home", "in_c", "plan")

    def __init__(self, query: Query) -> None:
        tree, settings, run = query.tree, query.settings.copy(), multi_start.search_one
        self._query, self.home = query, query.home.copy()
        self._tolerances, self._trace = query.options.tolerances, query.options.trace
        settings[layout.FIRST_WINS] = layout.ANY
        starts = unit_samples(tree, query.link, query.options.seed, 0, _STARTS, from_seed=True)
        self.plan = np.concatenate([settings, query.limits.ravel(), query.home, starts.ravel()])
        settings[layout.FIRST_WINS], settings[layout.SEEDED_STEPS] = layout.NEAREST, SEEDED_STEPS
        plan = np.concatenate([settings, self.plan[layout.N_SETTINGS :]])
        self._from_home = bound_to_one_target(run, (query.chain, self.plan), self.home)
        self._from_seed = bound_to_one_target(run, (query.chain, plan), self.home)
        self.in_c = self._from_home, self.home, self._from_seed

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether the options are those of the fast path, and the arm is measured in metres."""
        options = query.options
        return (
            options.method == LEVENBERG_MARQUARDT
            and options.task.kind == layout.WHOLE_POSE
            and query.task_axes is None
            and options.rank is None
            and options.max_step is None
            and options.budget >= SEEDED_STEPS + (_STARTS - 1) * STEPS
            and options.time_limit != 0.0
            and query.unit == 1.0
        )

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult | None:
        """The result if it is a solution; None if this is not one target, or one that needs a longer search or has none."""
        if posture is not None or world is not None or held:
            return None
        found = self._from_home(T, self.home) if q_seed is None else self._from_seed(T, q_seed)
        if found is None:
            return None
        q, info = found
        if self._trace:
            explanation = Explanation(trace=convergence(make_problem(self._query, T, q_seed), info[0]))
            return IKResult(q, info, (), self._tolerances, explanation)
        return IKResult(q, info, (), self._tolerances)
