"""Solves by the closed form, if there is one: the branch nearest to the seed, or best in rank.

A target without a branch within the limits is either proved to have none, or left to the search. Its nearest configuration and
the reason come from the search.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import as_pose
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.axes import N_AXES, turning_order
from ulna.ik.closed_form.branches import Branches, all_branches
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of, joints_at
from ulna.ik.entries import closed_form
from ulna.ik.options import Request
from ulna.ik.problem import Problem, Query, excess_of, make_problem, mid_range, refuse_no_pose
from ulna.ik.reason import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.numeric import NumericSolver, bound_to_one_target, nearest_poses, result_of, searched, trace_of
from ulna.ik.search.ranking import CollisionFilter, Cost, collisions_of, cost_of, refuse_clearance_of_nothing
from ulna.ik.search.restarts import PoseSearch, run_from_each
from ulna.ik.solutions import PROOFS, Proof
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_records import Results, SearchResult
from ulna.kinematics.turns import turn_towards_middle, turning_columns

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_MIN_TARGETS = 512  # of a part


class ClosedFormSolver:
    """The solver for arms of at most six joints with a closed form; see ``ik.inverse_kinematics.Solver``.

    A query with a posture or with held joints goes to the numeric search.
    """

    def __init__(self, query: Query, form: ClosedForm) -> None:
        self._query, self._form, self._six_joints = query, form, (six := joints_at(form, query.home))
        tree, options = query.tree, query.options
        self._n = tree.n_dof
        self._tables = six.table, six.chain, six.plan(tree.lower, tree.upper, options.tolerances)
        self._home, self._tolerances, self._trace = query.home.copy(), options.tolerances, options.trace
        self._is_ranked_by_distance = options.rank is None or options.rank == "nearest"
        self._search, run = NumericSolver(query), closed_form.nearest_branch_of_one
        alone = form.columns == tuple(range(N_AXES)) and self._n == N_AXES and query.task_axes is None and not form.couplings
        self._one = bound_to_one_target(run, self._tables, self._home) if alone else None

    @staticmethod
    def form_of(query: Query) -> ClosedForm | None:
        """The closed form for this task, exact or approximate; None if there is none, or if ``max_step`` bounds the path."""
        if query.options.max_step is not None or len(turning_order(query.tree.chain(query.link))) > N_AXES:
            return None
        form = closed_form_of(query.tree, query.link, task=query.options.task)
        return None if form is None or form.n_at_rest else form

    def solve(self, request: Request) -> IKResult:
        """The nearest branch, or the best-ranked branch that is clear of the world."""
        T, q_seed = request.T, request.q_seed
        if request.posture is not None or request.held:
            return self._search.search(request)
        if request.world is not None or not self._is_ranked_by_distance:
            return self._best_branch(request)
        if self._one is not None:
            found = self._one(T, self._home if q_seed is None else q_seed)
            if found is not None:
                explanation = Explanation(trace=_no_steps(found[1])) if self._trace else NOTHING_TO_EXPLAIN
                return IKResult(found[0], found[1], (), self._tolerances, explanation)
        return self._nearest(request)

    def with_defaults(self, T: ArrayLike, q_seed: ArrayLike | None) -> IKResult:
        """``solve`` of a query with default options, for targets alone."""
        found = None if self._one is None else self._one(T, self._home if q_seed is None else q_seed)
        return self._nearest(Request(T, q_seed)) if found is None else IKResult(*found, (), self._tolerances)

    def _nearest(self, request: Request) -> IKResult:
        """The nearest branch of each target."""
        problem = make_problem(self._query, request.T, request.q_seed)
        if self._form.couplings:
            return self._nearest_of_all(problem)
        targets, seeds = problem.targets, self._six_joints.entries_of(problem.seeds)
        angles, info = np.empty((len(targets), N_AXES)), np.empty(len(targets), SearchResult.structure)
        nearest = closed_form.nearest_branches

        def run(part: slice) -> bool:
            part_seeds = seeds[part] if len(seeds) > 1 else seeds
            nearest(*self._tables, targets[part], part_seeds, angles[part], info[part])
            return True

        in_parts(run, len(targets), _MIN_TARGETS)
        q = np.broadcast_to(problem.seeds, (len(targets), self._n)).copy()
        q[:, self._six_joints.columns] = angles[:, : len(self._six_joints.columns)]
        if self._form.n_free:  # the errors of the link itself, without the added joints
            solved = np.flatnonzero(info["status"] == layout.SOLVED)
            info[solved] = run_from_each(problem, solved, q[solved], 0)[1]
        return self._complete(problem, q, info, info["status"] == layout.SOLVED, None)

    def _nearest_of_all(self, problem: Problem) -> IKResult:
        """The nearest branch within the limits, for arms whose limits do not apply to the kernels' angles (couplings)."""
        as_pose(problem.targets.reshape(*problem.batch, 4, 4))
        branches = all_branches(self._form, self._query.tree, problem.targets, problem.seeds)
        seeds = np.broadcast_to(problem.seeds, (len(problem.targets), self._n))
        distances = np.where(branches.valid, np.abs(branches.q - seeds[:, None]).max(axis=-1), np.inf)
        chosen, rows = distances.argmin(axis=1), np.arange(len(distances))
        found = branches.valid[rows, chosen]
        q, info = run_from_each(problem, rows, np.where(found[:, None], branches.q[rows, chosen], seeds), 0)
        return self._complete(problem, q, info, found & (info["status"] == layout.SOLVED), None)

    def _best_branch(self, request: Request) -> IKResult:
        """The best branch of each target."""
        query, tree = self._query, self._query.tree
        refuse_clearance_of_nothing(query.options.rank, request.world)
        problem = make_problem(query, request.T, request.q_seed)
        as_pose(problem.targets.reshape(*problem.batch, 4, 4))
        collisions = collisions_of(query, request.world)
        cost = cost_of(problem, collisions)
        if cost is None:
            raise AssertionError("a rank or a world gives a cost")
        goal = mid_range(tree)[None] if query.options.rank == "mid_range" else problem.seeds
        q, found = _best_branch(all_branches(self._form, tree, problem.targets, goal), cost, problem)
        q, info = run_from_each(problem, np.arange(len(q)), q, 0)
        return self._complete(problem, q, info, found & (info["status"] == layout.SOLVED), collisions)

    def _complete(
        self, problem: Problem, q: Array, info: Results, solved: Truths, collisions: CollisionFilter | None
    ) -> IKResult:
        """Complete the result for q (n, n_dof) and info (n,), some of them solved."""
        if (info["status"] == layout.NOT_A_POSE).any():
            refuse_no_pose(problem.targets.reshape(*problem.batch, 4, 4))
        search, unsolved = PoseSearch(problem, None, q, info, ~solved, np.zeros(len(q), dtype=bool)), np.flatnonzero(~solved)
        if len(unsolved):
            proved, excess = self._prove_unreachable(problem.subset(unsolved))
            proved &= not self._trace  # a trace comes from the search
            for order, solve_some in (
                (unsolved[proved], nearest_poses),
                (unsolved[~proved], lambda some: searched(some, collisions)),
            ):
                if len(order):
                    search.copy_results(order, solve_some(problem.subset(order)))
            # Some are nevertheless within the tolerances.
            proved_unsolved = unsolved[proved & (info["status"][unsolved] != layout.SOLVED)]
            beyond_limits = {int(unsolved[i]): x for i, x in excess.items() if unsolved[i] in proved_unsolved}
            info["status"][proved_unsolved] = CODES[Status.UNREACHABLE]
            info["status"][list(beyond_limits)] = CODES[Status.JOINT_LIMITS]
            search.limit_excess.update(beyond_limits)
        trace = None if not self._trace else trace_of(search) if len(unsolved) else _no_steps(info)
        return result_of(search, collisions, trace, f"the closed form has no solution, whatever the limits ({self._form.family})")

    def _prove_unreachable(self, problem: Problem) -> tuple[Truths, dict[int, Array]]:
        """Mask of the targets proved to have no solution within the limits, and their smallest excess over these."""
        tree, form = self._query.tree, self._form
        branches = all_branches(form, tree, problem.targets, problem.seeds)
        is_proof = np.isin(branches.proof, [PROOFS.index(proof) for proof in (Proof.COMPLETE, Proof.COINCIDING)])
        proved, turning = is_proof & ~branches.valid.any(axis=1), turning_columns(form.chain, tree.n_dof)
        min_excess = {}
        for i in np.flatnonzero(proved & branches.real.any(axis=1)).tolist():
            q = turn_towards_middle(branches.q[i, branches.real[i]], tree.lower, tree.upper, turning)
            excess = excess_of(q, tree.lower, tree.upper)
            min_excess[i] = excess[excess.max(axis=1).argmin()]
        return proved, min_excess


def _best_branch(branches: Branches, cost: Cost, problem: Problem) -> tuple[Array, NDArray[np.bool_]]:
    """The branch of minimum cost of each target, shape (n, n_dof), and whether there is an acceptable one."""
    order, which = np.nonzero(branches.valid)
    costs, acceptable = np.full(branches.valid.shape, np.inf), np.zeros(branches.valid.shape, dtype=bool)
    of_valid = cost(order, branches.q[order, which])
    costs[order, which], acceptable[order, which] = of_valid.of_acceptable(), of_valid.acceptable
    chosen, rows = costs.argmin(axis=1), np.arange(len(costs))
    found = acceptable[rows, chosen]
    seeds = np.broadcast_to(problem.seeds, (len(costs), problem.seeds.shape[1]))
    return np.where(found[:, None], branches.q[rows, chosen], seeds), found


def _no_steps(info: Results) -> Array:
    """The trace (1, 4) of one target without steps: its errors."""
    return np.array([[info["position_error"][0], info["rotation_error"][0], 0.0, 0.0]])
