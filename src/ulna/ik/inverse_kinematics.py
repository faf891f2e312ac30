"""Chooses the solvers of inverse kinematics by their interface, and keeps what is prepared for the next call."""

from collections.abc import Callable, Iterable
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
from ulna.ik.options import Options
from ulna.ik.problem import Query, as_names
from ulna.ik.reason import NOTHING_TO_EXPLAIN
from ulna.ik.result import IKResult
from ulna.ik.search.numeric import NumericSolver
from ulna.ik.search.single_target import SingleTargetSolver
from ulna.ik.search.textbook_methods import TextbookSolver
from ulna.ik.solutions import IKSolutions
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Solver(Protocol):
    """One way to solve a query. It is made once for a query, then solves any number of targets, from many threads at once."""

    def __init__(self, query: Query) -> None:
        """Prepare what does not depend on the target; called only where ``applies`` is true."""
        ...

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether this solver can solve such queries."""
        ...

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult | None:
        """The result for the targets T, shape (..., 4, 4); None leaves them to the next solver.

        The arguments are those of ``Robot.inverse_kinematics``.

        Raises:
            InputError: An argument that the solver cannot take.
        """
        ...


# In the order in which they are tried.
SOLVERS: tuple[type[Solver], ...] = (ClosedFormSolver, SingleTargetSolver, NumericSolver, TextbookSolver)
_MOST_KEPT = 64  # queries of a robot
_DEFAULTS = Options()


class InverseKinematics:
    """The inverse kinematics of one robot. Its methods are named as those of ``Robot``; see there.

    Args:
        tree: The robot.
        home: Where a search without a seed starts [rad or m], shape (n_dof,).
        checker: The robot's collision checker.
    """

    __slots__ = ("_all_of", "_make_all_of", "_prepare", "_prepared", "_query", "quick", "quick_solutions")

    def __init__(self, tree: Tree, home: Array, checker: Checker) -> None:
        self._query = partial(_query, tree, home, checker)
        self.quick: dict[str | None, tuple] = {}
        """By link: what ``native/method.c`` needs to solve for it with default options, after the first call."""
        self._prepare = partial(_solvers, self._query, self.quick)
        self._prepared = lru_cache(maxsize=_MOST_KEPT, typed=True)(self._prepare)
        self.quick_solutions: dict[str | None, tuple] = {}
        """By link: what ``native/method.c`` needs to list all solutions with default options, after the first call."""
        self._make_all_of = partial(_all_of, self._query, self.quick_solutions)
        self._all_of = lru_cache(maxsize=_MOST_KEPT, typed=True)(self._make_all_of)

    def inverse_kinematics(
        self,
        T: ArrayLike,
        q_seed: ArrayLike | None,
        posture: ArrayLike | str | None,
        held: Iterable[str],
        world: World | None,
        link: str | None,
        options: Options = _DEFAULTS,
    ) -> IKResult:
        """The result of the first solver that has one; see ``Robot.inverse_kinematics``.

        Raises:
            InputError: An argument that the search cannot take; its name is in the message.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.
        """
        held = held if type(held) is tuple else as_names(held)
        try:
            solvers = self._prepared(link, *options)
        except TypeError:  # an argument that has no hash
            solvers = self._prepare(link, *options)
        for solver in solvers:
            result = solver.solve(T, q_seed, posture, held, world)
            if result is not None:
                return result
        raise AssertionError("the last solver has a result for any target")

    def all_solutions(
        self,
        T: ArrayLike,
        q_seed: ArrayLike | None,
        world: World | None,
        link: str | None,
        options: Options,
        *,
        n_samples: int,
        redundancy: str | None = None,
        whole_turns: bool = False,
    ) -> IKSolutions:
        """All solutions for poses, with what is proved of them; see ``Robot.all_solutions``.

        Raises:
            InputError: An argument that cannot be taken.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.
        """
        n_samples = as_count("n_samples", n_samples, 1)
        try:
            every = self._all_of(link, redundancy, *options)
        except TypeError:  # an argument that has no hash
            every = self._make_all_of(link, redundancy, *options)
        return every.all_solutions(T, n_samples, whole_turns=whole_turns, q_seed=q_seed, world=world)

    def follow(
        self,
        T_path: ArrayLike,
        q_start: ArrayLike | None,
        link: str | None,
        options: Options,
        max_step: float,
        world: World | None,
    ) -> FollowedPath:
        """The joint path through poses; see ``Robot.follow``.

        Raises:
            InputError: An argument that cannot be taken.
            UnknownNameError: There is no such link.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.
        """

        def solve(T: Array, seed: Array) -> IKResult:
            return self.inverse_kinematics(T, seed, None, (), world, link)

        return follow(self._query(link, options), T_path, q_start, max_step, world, solve)


def _query(tree: Tree, home: Array, checker: Checker, link: str | None, options: Options) -> Query:
    return Query(tree, home, checker, tree.link_or_tip(link), options)


def _solvers(
    query_of: Callable[[str | None, Options], Query], quick: dict[str | None, tuple], link: str | None, *options: Any
) -> tuple[Solver, ...]:
    query = query_of(link, Options(*options))
    solvers = tuple(solver(query) for solver in SOLVERS if solver.applies(query))
    in_c = getattr(solvers[0], "in_c", None)
    if in_c is not None and query.options == _DEFAULTS:
        others = solvers[1:] if isinstance(solvers[0], SingleTargetSolver) else solvers
        fields = {"_batch": (), "tolerances": query.options.tolerances, "explanation": NOTHING_TO_EXPLAIN}
        quick[link] = *in_c, IKResult, fields, partial(_first_result, others)
    return solvers


def _first_result(
    solvers: tuple[Solver, ...],
    T: ArrayLike,
    q_seed: ArrayLike | None,
    posture: ArrayLike | str | None = None,
    held: tuple[str, ...] = (),
    world: World | None = None,
) -> IKResult:
    for solver in solvers:
        result = solver.solve(T, q_seed, posture, held, world)
        if result is not None:
            return result
    raise AssertionError("the last solver has a result for any target")


def _all_of(
    query_of: Callable[[str | None, Options], Query],
    quick: dict[str | None, tuple],
    link: str | None,
    redundancy: str | None,
    *options: Any,
) -> AllSolutions:
    query = query_of(link, Options(*options))
    every = AllSolutions(query, redundancy)
    if every.in_c is not None and redundancy is None and query.options == _DEFAULTS:
        quick[link] = every.in_c
    return every
