"""Holds a path of poses, and the conditions on a joint path through it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of
from ulna.ik.following.lifts import Lifts
from ulna.ik.problem import SEEDED_STEPS, STEPS, Problem, Query, excess_of, make_problem
from ulna.ik.result import IKResult
from ulna.ik.search.ranking import CollisionFilter, collisions_of, cost_of
from ulna.ik.search.restarts import Restart, run_from_each, run_starts
from ulna.ik.time_limit import TimeLimit
from ulna.kernels.chain.closed_form_layout import AT_LIMIT
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.turns import TURN, nearest_turns, turning_columns

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
Solve = Callable[[Array, Array], IKResult]
_TIE = 1e-9
_MAX_AT_ONCE = 1 << 17  # starts of a search between two checks of the time limit
_MAX_CHECKED = 1 << 13  # configurations or edges between two checks of the time limit


@dataclass(frozen=True, eq=False)
class Course:
    """A path of poses, and the conditions on the joint path.

    Attributes:
        query: The link and the options, including the rank.
        targets: The poses, shape (n, 4, 4).
        start: The configuration before the path, shape (n_dof,), within the limits; ``home`` if the caller gives none.
        started: Whether the caller gives the start.
        max_step: The largest allowed step of any joint from one pose to the next [rad or m].
        world: The world to stay clear of; None if collisions are not checked.
        solve: Inverse kinematics of one pose from a seed, clear of the world.
        limit: The time limit. Once it is over, searches stop, and unchecked configurations are left out.
        start_excess: The excess of the caller's start over the limits, shape (n_dof,).
        one_sided: Whether turns of joints with one finite limit are counted from the limit. Otherwise these joints count as
            unlimited.
    """

    query: Query
    targets: Array
    start: Array
    started: bool
    max_step: float
    world: World | None
    solve: Solve
    limit: TimeLimit
    start_excess: Array
    one_sided: bool = False

    @cached_property
    def problem(self) -> Problem:
        """The targets as a search problem from the start."""
        return make_problem(self.query, self.targets, self.start)

    @cached_property
    def lifts(self) -> Lifts:
        """The whole turns that the limits allow."""
        tree = self.query.tree
        return Lifts.make(tree.lower, tree.upper, self.turning, self.start, one_sided=self.one_sided)

    @cached_property
    def turning(self) -> Truths:
        """Mask of the entries of q whose whole turns change no pose, shape (n_dof,)."""
        return turning_columns(self.query.chain, self.query.tree.n_dof)

    @cached_property
    def form(self) -> ClosedForm | None:
        """The closed form of the link; None if it has none, or if the task is not the whole pose."""
        return closed_form_of(self.query.tree, self.query.link) if self.is_whole else None

    @property
    def is_whole(self) -> bool:
        """Whether the task is the whole pose."""
        return self.query.options.task.kind == layout.WHOLE_POSE

    @cached_property
    def collisions(self) -> CollisionFilter | None:
        """The filter that rejects colliding configurations."""
        return collisions_of(self.query, self.world)

    @cached_property
    def is_redundant(self) -> bool:
        """Whether more joints move the link than the task fixes components of a pose. Components with slack are not fixed."""
        return len(self.query.tree.moving_columns(self.query.link)) > self.query.options.task.slack.count(0.0)

    @property
    def weight(self) -> float:
        """The weight of squared joint steps relative to the costs of the rank."""
        return 1.0 if self.query.options.rank is None else 1.0 / self.max_step**2

    def begin_costs(self, q: Array) -> Array:
        """The cost of each lift of q (m, n_dof) as the first node: (m, n_lifts).

        It is infinite beyond the limits, or more than a step from the caller's start. Otherwise it is the cost of the step from
        the start. If the caller gives no start, the step from home may have any length. With a rank, home then only breaks ties
        between lifts.
        """
        lifts = self.lifts
        lifted_q = np.where(lifts.lifted, q[:, None] + TURN * lifts.table, q[:, None])
        steps = np.where(lifts.free, lifts.steps(self.start, lifted_q)[0], lifted_q - self.start)
        allowed = lifts.allowed(q)
        if self.started:
            allowed &= np.abs(steps).max(axis=-1, initial=0.0) <= self.max_step
        is_weighted = self.started or self.query.options.rank is None
        return np.where(allowed, (self.weight if is_weighted else _TIE) * (steps**2).sum(axis=-1), np.inf)

    def unwrap_from_start(self, q: Array) -> Array:
        """Remove steps above half a turn of free joints from a path (n, n_dof), and begin it near the start.

        If the caller gives no start, whole turns bring the path within a limit on one side.
        """
        if not len(q):
            return q
        free, lower, upper = self.lifts.free, self.query.tree.lower, self.query.tree.upper
        q = self.lifts.unwrapped(q)
        q = np.where(free, q - TURN * np.rint((q[0] - self.start) / TURN), q)
        if not self.started:
            q = np.where(free, q + TURN * np.ceil(np.maximum(lower - AT_LIMIT - q.min(axis=0), 0.0) / TURN), q)
            q = np.where(free, q - TURN * np.ceil(np.maximum(q.max(axis=0) - upper - AT_LIMIT, 0.0) / TURN), q)
        return np.where(self.excess(q) <= AT_LIMIT, np.clip(q, lower, upper), q)

    def steps_within(self, a: Array, b: Array) -> Array:
        """The steps from a to b by entry, with b moved nearest to a by whole turns within the limits."""
        tree = self.query.tree
        return nearest_turns(b, a, tree.lower - AT_LIMIT, tree.upper + AT_LIMIT, self.turning) - a

    def excess(self, q: Array) -> Array:
        """The excess of each entry of q (..., n_dof) over its limits [rad or m]."""
        return excess_of(q, self.query.tree.lower, self.query.tree.upper)

    def solutions_near(self, order: NDArray[np.int64], guesses: Array, *, beyond_limits: bool = False) -> tuple[Array, Truths]:
        """Solutions of some poses (m,) by a search from guesses (m, n_dof), and whether each search converged."""
        problem = self.problem
        if beyond_limits:
            bounds = self.query.limits.copy()
            bounds[:, 0], bounds[:, 1] = -np.inf, np.inf
            problem = replace(problem, bounds=bounds)
        else:
            guesses = np.clip(guesses, *self.query.tree.bounds)
        q, info = run_from_each(problem, order, guesses, SEEDED_STEPS)
        self.limit.begin(time.perf_counter())
        return q, info["status"] == layout.SOLVED

    def search(self, order: NDArray[np.int64], n_starts: int) -> list[Array]:
        """Solutions (k, n_dof) of each of some poses (m,), by a search from the start and random starts."""
        problem, found = replace(self.problem, nearest_to=None), []
        for part in np.array_split(order, max(1, len(order) * n_starts // _MAX_AT_ONCE)):
            if self.limit.is_over():
                break
            q, info = run_starts(problem, part, Restart(0, n_starts, STEPS, from_seed=True))
            found += [row[good] for row, good in zip(q, info["status"] == layout.SOLVED, strict=True)]
            self.limit.begin(time.perf_counter())
        return found + [np.empty((0, len(self.start)))] * (len(order) - len(found))

    def without_collisions(self, rows: list[Array]) -> list[Array]:
        """The configurations (m, n_dof) of each list that do not collide."""
        hit = self.collide(np.concatenate(rows))
        return [q[~bad] for q, bad in zip(rows, split_as(rows, hit), strict=True)]

    def collide(self, q: Array) -> Truths:
        """Whether configurations (m, n_dof) collide, shape (m,)."""
        if self.collisions is None or not len(q):
            return np.zeros(len(q), dtype=bool)
        return self._in_parts(self.collisions.collides, q)

    def edges_collide(self, a: Array, b: Array) -> Truths:
        """Whether the arm touches anything on straight lines from rows of a to rows of b (m, n_dof), shape (m,)."""
        if self.world is None or not len(a):
            return np.zeros(len(a), dtype=bool)
        checker, world = self.query.checker, self.world

        def hit(a: Array, b: Array) -> Truths:
            return np.asarray(checker.edge_in_collision(a, b, world, self_collision=True, resolution=1e-4).in_collision)

        return self._in_parts(hit, a, b)

    def _in_parts(self, hit: Callable[..., Truths], *rows: Array) -> Truths:
        """The result of a check for each row. Rows after the time limit count as colliding."""
        hits = np.ones(len(rows[0]), dtype=bool)
        for k in range(0, len(hits), _MAX_CHECKED):
            if self.limit.is_over():
                break
            part = slice(k, k + _MAX_CHECKED)
            hits[part] = hit(*(each[part] for each in rows))
        return hits

    def costs(self, q: Array) -> Array:
        """The costs of configurations (m, n_dof) by the rank, shape (m,); 0 without a rank."""
        if self.query.options.rank is None or not len(q):
            return np.zeros(len(q))
        cost = cost_of(self.problem, self.collisions)
        if cost is None:
            raise AssertionError("a rank gives a cost")
        nearest = self.lifts.nearest(q, self.start)
        return cost(np.zeros(len(q), dtype=np.int64), nearest).of_acceptable()


def split_as(rows: list[Array], values: NDArray) -> list[NDArray]:
    """Split the values of the concatenated rows of several lists by list."""
    return np.split(values, np.cumsum([len(row) for row in rows])[:-1])
