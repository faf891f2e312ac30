"""Solves by the closed form, where the arm has one: the branch nearest to the seed. Used by ``ik.inverse_kinematics``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.drivers import entry
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.axes import N_AXES, turning_order
from ulna.ik.closed_form.choice import best_branches
from ulna.ik.closed_form.closed_form import closed_form_of, joints_at
from ulna.ik.closed_form.unsolved import no_steps, with_unsolved
from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.numeric import NumericSolver
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import make_problem
from ulna.ik.query import Query
from ulna.ik.result import IKResult
from ulna.ik.turns import TURN
from ulna.kernels.ik import search_layout as layout

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]
_MATRIX, _ONE_MATRIX, _ONE_SEED = (4, 4), (1, 4, 4), (1, N_AXES)
_LEAST_TARGETS = 512  # of a part
_MORE_THAN_ANY = 1e12  # m: what a whole turn of a joint that slides would add


class ClosedFormSolver:
    """The solver for arms of at most six joints with a closed form; see ``ik.solver.Solver``.

    Targets without a branch within the limits are left to the search, for the nearest configuration and the reason.
    """

    def __init__(self, query: Query) -> None:
        form = closed_form_of(query.tree, query.link, task=query.options.task)
        if form is None:
            raise AssertionError("no closed form")
        self._query, self._form, six = query, form, joints_at(form, query.home)
        tree, options = query.tree, query.options
        self._columns, self._n = np.array(form.columns), tree.n_dof
        self._alone = form.columns == tuple(range(N_AXES)) and self._n == N_AXES
        self._table, self._chain, self._nearest = six.table, six.chain, entry("closed_form.nearest_branches")
        turns = np.where(six.slides, _MORE_THAN_ANY, TURN)
        limits = tree.lower[self._columns], tree.upper[self._columns]
        self._plan = np.concatenate([options.tolerances, *limits, turns, 1.0 / turns])
        self._home, self._tolerances, self._trace = query.home.copy(), options.tolerances, options.trace
        self._own_axes = query.task_axes is None
        self._by_way = options.rank is None or options.rank == "nearest"
        self._search = NumericSolver(query)

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether the options ask for a pose by any way, and the arm has a closed form for the task, exact or near."""
        options = query.options
        if (
            options.method != LEVENBERG_MARQUARDT
            or options.max_step is not None
            or len(turning_order(query.tree.chain(query.link))) > N_AXES
        ):
            return False
        form = closed_form_of(query.tree, query.link, task=options.task)
        return form is not None and not form.n_at_rest

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult | None:
        """The nearest branch, or that of the best rank that is clear of the world; None where something else is asked for."""
        if posture is not None or held:
            return None
        if world is not None or not self._by_way:
            return best_branches(self._query, self._form, self._search, T, q_seed, world)
        T = as_floats("T", T)
        result = self._one(T, q_seed) if T.shape == _MATRIX and self._own_axes else None
        return self._many(T, q_seed) if result is None else result

    def _one(self, T: Array, q_seed: ArrayLike | None) -> IKResult | None:
        """The result for one target, if it is solved."""
        start = self._home if q_seed is None else as_floats("q_seed", q_seed)
        if start.shape != (self._n,) or not (self._alone or np.isfinite(start).all()):
            return None
        seed = start if self._alone else self._padded(start)
        q, info = np.empty((1, N_AXES)), np.empty((1, layout.N_INFO))
        if not self._nearest(self._table, self._chain, self._plan, T.reshape(_ONE_MATRIX), seed.reshape(_ONE_SEED), q, info):
            return None
        explanation = Explanation(trace=no_steps(info)) if self._trace else NOTHING_TO_EXPLAIN
        found = q[0]
        if not self._alone:
            found = np.clip(start, *self._query.tree.limits)
            found[self._columns] = q[0, : len(self._columns)]
        return IKResult(found, info, (), self._tolerances, explanation)

    def _many(self, T: Array, q_seed: ArrayLike | None) -> IKResult:
        problem = make_problem(self._query, T, q_seed)
        targets, seeds = problem.targets, self._padded(problem.seeds)
        angles, info = np.empty((len(targets), N_AXES)), np.empty((len(targets), layout.N_INFO))

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            self._nearest(self._table, self._chain, self._plan, targets[part], own, angles[part], info[part])
            return True

        in_parts(run, len(targets), _LEAST_TARGETS, self._query.options.threads)
        q = np.broadcast_to(problem.seeds, (len(targets), self._n)).copy()
        q[:, self._columns] = angles[:, : len(self._columns)]
        return with_unsolved(self._search, self._form, problem, q, info, None, None)

    def _padded(self, seeds: Array) -> Array:
        """What seeds (..., n_dof) say of six joints, (..., 6): 0 of those that were added."""
        six = np.zeros((*seeds.shape[:-1], N_AXES))
        six[..., : len(self._columns)] = seeds[..., self._columns]
        return six
