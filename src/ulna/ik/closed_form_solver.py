"""Solves by the closed form, where the arm has one: the branch nearest to the seed, or that of the best rank.

Targets without a branch within the limits are either proved to have none, or left to the search; the nearest configuration and
the reason are those of the search.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.pose import as_pose
from ulna.drivers import closed_form
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.axes import N_AXES, turning_order
from ulna.ik.closed_form.branches import Branches, all_branches
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of, joints_at
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import Problem, Query, make_problem, mid_range, refuse_no_pose
from ulna.ik.reason import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.diagnosis import reach_in_words
from ulna.ik.search.numeric import NumericSolver, nearest_poses
from ulna.ik.search.ranking import Cost, collisions_of, cost_of, refuse_clearance_of_nothing
from ulna.ik.search.restarts import run_from_each
from ulna.ik.search.single_target import bound_to_one_target
from ulna.ik.solutions import PROOFS, Proof
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.tree import entry_names
from ulna.kinematics.turns import turned_towards, turning_columns

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_LEAST_TARGETS = 512  # of a part


class ClosedFormSolver:
    """The solver for arms of at most six joints with a closed form; see ``ik.inverse_kinematics.Solver``.

    Targets without a branch within the limits are left to the search, for the nearest configuration and the reason.
    """

    def __init__(self, query: Query) -> None:
        form = closed_form_of(query.tree, query.link, task=query.options.task)
        if form is None:
            raise AssertionError("no closed form")
        self._query, self._form, self._six = query, form, (six := joints_at(form, query.home))
        tree, options = query.tree, query.options
        self._n = tree.n_dof
        self._tables = six.table, six.chain, six.plan(tree.lower, tree.upper, options.tolerances)
        self._home, self._tolerances, self._trace = query.home.copy(), options.tolerances, options.trace
        self._by_way = options.rank is None or options.rank == "nearest"
        self._search, run = NumericSolver(query), closed_form.nearest_branch_of_one
        alone = form.columns == tuple(range(N_AXES)) and self._n == N_AXES and query.task_axes is None
        self._one = bound_to_one_target(run, self._tables, self._home) if alone else None
        self.in_c = None if self._one is None else (self._one, self._home, self._one)

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether any way to the target will do, and the arm has a closed form for the task, exact or near."""
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
        """The nearest branch, or that of the best rank that is clear of the world; None with a posture or held joints."""
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

    def _many(self, T: ArrayLike, q_seed: ArrayLike | None) -> IKResult:
        problem = make_problem(self._query, T, q_seed)
        targets, seeds = problem.targets, self._six.entries_of(problem.seeds)
        angles, info = np.empty((len(targets), N_AXES)), np.empty((len(targets), layout.N_INFO))
        nearest = closed_form.nearest_branches

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            nearest(*self._tables, targets[part], own, angles[part], info[part])
            return True

        in_parts(run, len(targets), _LEAST_TARGETS, self._query.options.threads)
        q = np.broadcast_to(problem.seeds, (len(targets), self._n)).copy()
        q[:, self._six.columns] = angles[:, : len(self._six.columns)]
        if self._form.n_free:  # the errors of the link itself, of which the joints that were added are no part
            solved = np.flatnonzero(info[:, layout.STATUS] == layout.SOLVED)
            info[solved] = run_from_each(problem, solved, q[solved], 0)[1]
        return with_unsolved(self._search, self._form, problem, q, info, None, None)


def best_branches(
    query: Query, form: ClosedForm, search: NumericSolver, T: ArrayLike, q_seed: ArrayLike | None, world: World | None
) -> IKResult:
    """The best branch of each target."""
    refuse_clearance_of_nothing(query.options.rank, world)
    problem = make_problem(query, T, q_seed)
    as_pose(problem.targets.reshape(*problem.batch, 4, 4))
    collisions = collisions_of(query, world)
    cost = cost_of(problem, collisions)
    if cost is None:
        raise AssertionError("a rank or a world gives a cost")
    goal = mid_range(query.tree)[None] if query.options.rank == "mid_range" else problem.seeds
    branches = all_branches(form, query.tree, problem.targets, goal, query.options.threads)
    q, found = _best(branches, cost, problem)
    q, info = run_from_each(problem, np.arange(len(q)), q, 0)
    return with_unsolved(search, form, problem, q, info, found, world)


def _best(branches: Branches, cost: Cost, problem: Problem) -> tuple[Array, NDArray[np.bool_]]:
    """The branch of the least cost of each target, shape (n, n_dof), and whether there is one that is acceptable."""
    order, which = np.nonzero(branches.valid)
    costs = np.full(branches.valid.shape, np.inf)
    costs[order, which] = cost(order, branches.q[order, which])
    chosen, rows = costs.argmin(axis=1), np.arange(len(costs))
    found = np.isfinite(costs[rows, chosen])
    seeds = np.broadcast_to(problem.seeds, (len(costs), problem.seeds.shape[1]))
    return np.where(found[:, None], branches.q[rows, chosen], seeds), found


def with_unsolved(
    search: NumericSolver, form: ClosedForm, problem: Problem, q: Array, info: Array, found: Truths | None, world: World | None
) -> IKResult:
    """The result for q (n, n_dof) and info (n, N_INFO), of which some are not solved.

    found: Whether a target has a branch that is acceptable; None where the information says it.

    Raises:
        InputError: A target is no rigid motion.
    """
    options = problem.query.options
    if (info[:, layout.STATUS] == layout.NOT_A_POSE).any():
        refuse_no_pose(problem.targets.reshape(*problem.batch, 4, 4))
    solved = info[:, layout.STATUS] == layout.SOLVED
    rest = np.flatnonzero(~solved if found is None else ~(solved & found))
    explanation = Explanation(trace=no_steps(info) if options.trace else None)
    if len(rest):
        proved, excess = proved_unsolved(form, _some(problem, rest))
        if not options.trace:
            explanation = _nearest(form, problem, rest[proved], q, info, {int(rest[i]): x for i, x in excess.items()})
        else:
            proved[:] = False  # a trace is one of the search
        explanation = _searched(search, problem, rest[~proved], q, info, world, explanation)
    explanation = replace(explanation, task_axes=problem.query.task_axes)
    return IKResult(q.reshape(*problem.batch, q.shape[-1]), info, problem.batch, options.tolerances, explanation)


def proved_unsolved(form: ClosedForm, problem: Problem) -> tuple[Truths, dict[int, Array]]:
    """Which targets are proved to have no solution within the limits; and for those that have some beyond, the least excess."""
    branches = all_branches(form, problem.query.tree, problem.targets, problem.seeds, problem.query.options.threads)
    is_proof = np.isin(branches.proof, [PROOFS.index(proof) for proof in (Proof.COMPLETE, Proof.COINCIDING)])
    proved = is_proof & ~branches.valid.any(axis=1)
    beyond = np.flatnonzero(proved & branches.real.any(axis=1))
    return proved, {int(i): _least_excess(form, problem, branches.q[i, branches.real[i]]) for i in beyond}


def _some(problem: Problem, order: NDArray[np.int64]) -> Problem:
    """The problem of some targets."""
    seeds, bounds = (rows[order] if len(rows) > 1 else rows for rows in (problem.seeds, problem.bounds))
    goal = problem.nearest_to if problem.nearest_to is None or len(problem.nearest_to) == 1 else problem.nearest_to[order]
    return replace(problem, targets=problem.targets[order], seeds=seeds, bounds=bounds, nearest_to=goal, batch=(len(order),))


def _nearest(
    form: ClosedForm, problem: Problem, order: NDArray[np.int64], q: Array, info: Array, excess: dict[int, Array]
) -> Explanation:
    """Write the nearest configurations to targets without solutions, and why they have none."""
    if not len(order):
        return NOTHING_TO_EXPLAIN
    search = nearest_poses(_some(problem, order))
    q[order], info[order] = search.q, search.info
    open_ = order[search.info[:, layout.STATUS] != layout.SOLVED]  # within the tolerances although there is no solution
    is_beyond = np.isin(open_, list(excess))
    info[open_, layout.STATUS] = np.where(is_beyond, CODES[Status.JOINT_LIMITS], CODES[Status.UNREACHABLE])
    reach = {int(order[i]): x for i, x in search.reach_excess.items()}
    words = f"the closed form has no solution, whatever the limits ({form.family})"
    return Explanation(
        reach_excess=reach,
        limit_excess={i: x for i, x in excess.items() if i in set(open_.tolist())},
        reach=reach_in_words(problem, 0) if reach and not problem.batch else words,
        entry_names=entry_names(problem.query.tree) if excess else (),
    )


def _searched(
    search: NumericSolver,
    problem: Problem,
    order: NDArray[np.int64],
    q: Array,
    info: Array,
    world: World | None,
    known: Explanation,
) -> Explanation:
    """Write the results of the search for other targets; what is known of them too is added."""
    if not len(order):
        return known
    seeds = None if not problem.seeded else problem.seeds[order] if len(problem.seeds) > 1 else problem.seeds[0]
    targets = problem.targets[order] if problem.batch else problem.targets[0]
    some = search.solve(targets, seeds, None, (), world)
    q[order], info[order] = some.q.reshape(len(order), -1), some.info
    more = some.explanation.renumbered(order)
    return replace(
        more,
        reach_excess={**known.reach_excess, **more.reach_excess},
        limit_excess={**known.limit_excess, **more.limit_excess},
        reach=more.reach or known.reach,
        entry_names=more.entry_names or known.entry_names,
    )


def no_steps(info: Array) -> Array:
    """The trace (1, 4) of one target that took no step: its errors."""
    return np.array([[info[0, layout.POSITION_ERROR], info[0, layout.ROTATION_ERROR], 0.0, 0.0]])


def _least_excess(form: ClosedForm, problem: Problem, q: Array) -> Array:
    """How far beyond the limits that solution of some (k, n_dof) is, each turned towards them, that is the least so."""
    tree = problem.query.tree
    q = turned_towards(q, tree.lower, tree.upper, turning_columns(form.chain, tree.n_dof))
    excess = np.maximum(np.maximum(tree.lower - q, q - tree.upper), 0.0)
    return excess[excess.max(axis=1).argmin()]
