"""Solves by the closed form, where the arm has one: the branch nearest to the seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.drivers import closed_form
from ulna.engine.bound import bind
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.axes import N_AXES, turning_order
from ulna.ik.closed_form.choice import best_branches
from ulna.ik.closed_form.closed_form import closed_form_of, joints_at
from ulna.ik.closed_form.unsolved import no_steps, with_unsolved
from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.numeric import NumericSolver
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import Problem, make_problem
from ulna.ik.query import Query
from ulna.ik.restarts import Restart, run_starts
from ulna.ik.result import IKResult
from ulna.kernels.ik import search_layout as layout

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]
_MATRIX, _SEED, _ONE_Q, _ONE_INFO = (4, 4), (N_AXES,), (1, N_AXES), (1, layout.N_INFO)
_Search = Callable[[ArrayLike, ArrayLike], tuple[Array, Array] | None]
_LEAST_TARGETS = 512  # of a part


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
        self._tables = six.table, six.chain, six.plan(tree.lower, tree.upper, options.tolerances)
        self._home, self._tolerances, self._trace = query.home.copy(), options.tolerances, options.trace
        self._by_way = options.rank is None or options.rank == "nearest"
        self._search, self._nearest_of_one = NumericSolver(query), closed_form.nearest_branch_of_one
        alone = form.columns == tuple(range(N_AXES)) and self._n == N_AXES and query.task_axes is None
        self._one = self._one_by_entry() if alone else None
        self.in_c = None if self._one is None else (self._one, self._home, self._one)

    def _one_by_entry(self) -> _Search:
        """The way of one target of an arm whose joints are all of q, in C if the extension is there."""
        return bind(self._nearest_of_one, "search", self._tables, N_AXES, (layout.N_INFO,), self._in_python) or self._in_python

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
        if self._one is not None:
            found = self._one(T, self._home if q_seed is None else q_seed)
            if found is not None:
                explanation = Explanation(trace=no_steps(found[1])) if self._trace else NOTHING_TO_EXPLAIN
                return IKResult(found[0], found[1], (), self._tolerances, explanation)
        return self._many(T, q_seed)

    def _in_python(self, T: ArrayLike, start: ArrayLike) -> tuple[Array, Array] | None:
        """The branch for one target and what is known about it; None if this is not one target, or it has none."""
        T = as_floats("T", T)
        if T.shape != _MATRIX:
            return None
        if start is not self._home:
            start = as_floats("q_seed", start)
            if start.shape != _SEED:
                return None
        q, info = np.empty(_ONE_Q), np.empty(_ONE_INFO)
        return (q[0], info) if self._nearest_of_one(*self._tables, T, start, q, info) else None

    def _many(self, T: ArrayLike, q_seed: ArrayLike | None) -> IKResult:
        problem = make_problem(self._query, T, q_seed)
        targets, seeds = problem.targets, self._padded(problem.seeds)
        angles, info = np.empty((len(targets), N_AXES)), np.empty((len(targets), layout.N_INFO))

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            closed_form.nearest_branches(*self._tables, targets[part], own, angles[part], info[part])
            return True

        in_parts(run, len(targets), _LEAST_TARGETS, self._query.options.threads)
        q = np.broadcast_to(problem.seeds, (len(targets), self._n)).copy()
        q[:, self._columns] = angles[:, : len(self._columns)]
        if self._form.n_free:
            info = _with_errors(problem, q, info)
        return with_unsolved(self._search, self._form, problem, q, info, None, None)

    def _padded(self, seeds: Array) -> Array:
        """What seeds (..., n_dof) say of six joints, (..., 6): 0 of those that were added."""
        six = np.zeros((*seeds.shape[:-1], N_AXES))
        six[..., : len(self._columns)] = seeds[..., self._columns]
        return six


def _with_errors(problem: Problem, q: Array, info: Array) -> Array:
    """The information with the errors of the link itself, which the joints that were added are no part of."""
    solved = np.flatnonzero(info[:, layout.STATUS] == layout.SOLVED)
    each = replace(problem, targets=problem.targets[solved], seeds=q[solved], nearest_to=None)
    info[solved] = run_starts(each, np.arange(len(solved)), Restart(0, 1, 0, from_seed=True))[1][:, 0]  # no step
    return info
