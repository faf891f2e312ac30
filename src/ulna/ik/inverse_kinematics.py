"""Chooses the solver of inverse kinematics, and caches prepared solvers."""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.description.arrays import as_count
from ulna.ik.all_solutions import AllSolutions
from ulna.ik.closed_form_solver import ClosedFormSolver
from ulna.ik.followed_path import FollowedPath
from ulna.ik.following.follow import follow
from ulna.ik.options import DEFAULTS, N_SAMPLES, Options, Request
from ulna.ik.problem import Query
from ulna.ik.result import IKResult
from ulna.ik.search.numeric import NumericSolver
from ulna.ik.solutions import IKSolutions
from ulna.ik.time_limit import TimeLimit, as_time_limit
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Solver(Protocol):
    """A solver of a query, made once for any number of targets, in many threads at once."""

    def solve(self, request: Request) -> IKResult:
        """The result for the targets of a request."""
        ...

    def with_defaults(self, T: ArrayLike, q_seed: ArrayLike | None) -> IKResult:
        """The result for targets alone, of a query with default options."""
        ...


def solver_of(query: Query) -> Solver:
    """The solver of a query."""
    form = ClosedFormSolver.form_of(query)
    return NumericSolver(query) if form is None else ClosedFormSolver(query, form)


_MAX_KEPT = 64  # queries of a robot in the cache


class InverseKinematics:
    """The inverse kinematics of one robot. Its methods have the names of those of ``Robot``, which document them."""

    __slots__ = ("_all_solutions_of", "_default_all_solutions", "_default_solvers", "_query", "_solver")

    def __init__(self, tree: Tree, home: Array, checker: Checker) -> None:
        self._query = partial(_query, tree, home, checker)
        self._solver = lru_cache(_MAX_KEPT, typed=True)(partial(_solver_for, self._query))
        self._all_solutions_of = lru_cache(_MAX_KEPT, typed=True)(partial(_all_solutions_of, self._query))

        self._default_solvers: dict[
            str | None, Solver
        ] = {}  # by link: solvers with default options, which a dict finds in less time
        self._default_all_solutions: dict[str | None, AllSolutions] = {}

    def with_defaults(self, T: Array, q_seed: ArrayLike | None, link: str | None) -> IKResult:
        """The result for targets with default options."""
        try:
            solver = self._default_solvers.get(link)
        except TypeError:  # not hashable, so not the name of a link
            solver = None
        if solver is None:
            self._default_solvers[link] = solver = self._solver(self._query(link, DEFAULTS).link, *DEFAULTS)
        return solver.with_defaults(T, q_seed)

    def all_with_defaults(self, T: Array, link: str | None) -> IKSolutions:
        """All solutions for targets with default options."""
        try:
            solver = self._default_all_solutions.get(link)
        except TypeError:  # as above
            solver = None
        if solver is None:
            self._default_all_solutions[link] = solver = self._all_solutions_of(self._query(link, DEFAULTS).link, None, *DEFAULTS)
        solutions = solver.of_one(T)
        return solver.all_solutions(T, N_SAMPLES, whole_turns=False) if solutions is None else solutions

    def inverse_kinematics(self, request: Request) -> IKResult:
        """The result of the solver of the link and options; see ``Robot.inverse_kinematics``."""
        try:
            solver = self._solver(request.link, *request.options)
        except TypeError:  # an argument that has no hash
            solver = self._solver.__wrapped__(request.link, *request.options)
        return solver.solve(request)

    def all_solutions(
        self, request: Request, *, n_samples: int, redundancy: str | None = None, whole_turns: bool = False
    ) -> IKSolutions:
        """All solutions for poses, with their proofs; see ``Robot.all_solutions``."""
        n_samples = as_count("n_samples", n_samples, 1)
        try:
            solver = self._all_solutions_of(request.link, redundancy, *request.options)
        except TypeError:  # an argument that has no hash
            solver = self._all_solutions_of.__wrapped__(request.link, redundancy, *request.options)
        return solver.all_solutions(request.T, n_samples, whole_turns=whole_turns, q_seed=request.q_seed, world=request.world)

    def follow(
        self,
        T_path: ArrayLike,
        q_start: ArrayLike | None,
        link: str | None,
        options: Options,
        max_step: float,
        world: World | None,
    ) -> FollowedPath:
        """The joint path through poses; see ``Robot.follow``."""
        limit = TimeLimit(as_time_limit(options.time_limit))
        options = options._replace(time_limit=None)

        def solve(T: Array, seed: Array) -> IKResult:
            return self.inverse_kinematics(Request(T, seed, world=world, link=link, options=Options(task=options.task)))

        return follow(self._query(link, options), T_path, q_start, max_step, world, solve, limit)


def _query(tree: Tree, home: Array, checker: Checker, link: str | None, options: Options) -> Query:
    return Query(tree, home, checker, tree.link_or_tip(link), options)


def _solver_for(query_of: Callable[[str | None, Options], Query], link: str | None, *options: Any) -> Solver:
    return solver_of(query_of(link, Options(*options)))


def _all_solutions_of(
    query_of: Callable[[str | None, Options], Query], link: str | None, redundancy: str | None, *options: Any
) -> AllSolutions:
    return AllSolutions(query_of(link, Options(*options)), redundancy)
