"""Solves for one pose from up to 64 starts: the fast path of default options."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.drivers import multi_start
from ulna.engine.bound import bind
from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import make_problem
from ulna.ik.query import SEEDED_STEPS, STEPS, Query
from ulna.ik.result import IKResult
from ulna.ik.trace import convergence
from ulna.ik.unit_samples import seed_sample, unit_samples
from ulna.kernels.ik import search_layout as layout

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]
_STARTS = 64  # eight in each lane; the next solver takes a target that needs more
_MATRIX = (4, 4)
_Search = Callable[[ArrayLike, ArrayLike], tuple[Array, Array] | None]


class SingleTargetSolver:
    """The fast path of one target with default options; see ``ik.solver.Solver``.

    ``solve`` may be called from many threads at once: nothing that it writes to is shared.
    """

    __slots__ = ("_chain", "_from_home", "_from_seed", "_home", "_n", "_query", "_search_one", "_tolerances", "in_c", "plan")

    def __init__(self, query: Query) -> None:
        tree, options, settings = query.tree, query.options, query.settings.copy()
        self._search_one, self._query = multi_start.search_one, query
        self._chain, self._n, self._tolerances, self._home = query.chain, tree.n_dof, options.tolerances, query.home.copy()
        settings[layout.FIRST_WINS] = layout.ANY
        from_seed, random = seed_sample(tree.n_dof), unit_samples(tree, query.link, options.seed, 0, _STARTS - 1)
        self.plan = np.concatenate([settings, query.limits.ravel(), query.home, from_seed.ravel(), random.ravel()])
        settings[layout.FIRST_WINS], settings[layout.SEEDED_STEPS] = layout.NEAREST, SEEDED_STEPS
        plan = np.concatenate([settings, self.plan[layout.N_SETTINGS :]])
        self._from_home, self._from_seed = self._search_by(self.plan), self._search_by(plan)
        self.in_c = self._from_home, self._home, self._from_seed

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
        found = self._from_home(T, self._home) if q_seed is None else self._from_seed(T, q_seed)
        if found is None:
            return None
        q, info = found
        explanation = self._trace(T, q_seed, info) if self._query.options.trace else NOTHING_TO_EXPLAIN
        return IKResult(q, info, (), self._tolerances, explanation)

    def _search_by(self, plan: Array) -> _Search:
        """A search with a plan (``drivers.multi_start.search_one``), in C if the extension is there."""
        in_python = partial(self._search, plan)
        return bind(self._search_one, "search", (self._chain, plan), self._n, (layout.N_INFO,), in_python) or in_python

    def _search(self, plan: Array, T: ArrayLike, start: ArrayLike) -> tuple[Array, Array] | None:
        """A solution and what is known about it; None if this is not one target, or there is none."""
        T = as_floats("T", T)
        if T.shape != _MATRIX:
            return None
        if start is not self._home:
            start = as_floats("q_seed", start)
            if start.shape != (self._n,):
                return None
        q, info = np.empty((1, self._n)), np.empty((1, layout.N_INFO))
        return (q[0], info) if self._search_one(self._chain, plan, T, start, q, info) else None

    def _trace(self, T: ArrayLike, q_seed: ArrayLike | None, info: Array) -> Explanation:
        return Explanation(trace=convergence(make_problem(self._query, T, q_seed), info[0]))
