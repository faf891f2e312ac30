"""Solves by Levenberg-Marquardt from many starts, and says why a target was not reached: the face of this folder.

The idea. With e(q) the pose that is left, six numbers (m, rad) in the axes of the base, and J the Jacobian, a step

    dq = J' (J J' + lambda I)^-1 e,    lambda = 0.05 |e|^2 + 1e-12    (Sugihara 2011)

is long and careful far from the target, and Newton's near it, where lambda vanishes. Every step is kept within the limits
(``kernels/ik``). It may end in a local minimum of |e|, so there are many starts (``starts``): the caller's seed, random ones, for
seven joints branches of the closed form. Eight searches run at a time, one a lane; one that has ended makes room for the next.

1. ``single_target``: the fast path, one call of the kernels for one target with default options.
2. ``restarts``: rounds for a batch, of one start each, then of more and more for the targets that are left. ``ranking``: which of
   several solutions is taken. ``units``: arms that are far from a metre long are searched in a unit of their own.
3. ``diagnosis``: for targets without a solution the nearest pose, and whether reach, limits, collision or a singularity is why.
4. ``branch_search``: all solutions of one target. ``textbook_methods``: other steps from the seed alone, for teaching.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.ik.options import LEVENBERG_MARQUARDT
from ulna.ik.problem import STEPS, Problem, Query, make_problem, refuse_no_pose
from ulna.ik.reason import Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.diagnosis import close_unreachable, explain_open, reach_in_words, settle_open
from ulna.ik.search.ranking import CollisionFilter, collisions_of, cost_of, refuse_clearance_of_nothing
from ulna.ik.search.restarts import Restart, Search, run_from_each, search_with_restarts
from ulna.ik.search.starts import unit_samples
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.tree import entry_names

Array = NDArray[np.float64]
_FEW, _MANY = 2, 16  # random starts of the first round: if any solution will do, and if the best is chosen
_MOST = 64  # starts where there is no solution to find


class NumericSolver:
    """The solver for any query; see ``ik.inverse_kinematics.Solver``."""

    def __init__(self, query: Query) -> None:
        self._query = query

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether this method was chosen."""
        return query.options.method == LEVENBERG_MARQUARDT

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult:
        """The best that the restarts find."""
        query, options = self._query, self._query.options
        problem = make_problem(query, T, q_seed, posture, held)
        refuse_clearance_of_nothing(options.rank, world)
        collisions = collisions_of(query, world)
        search = _search(problem, collisions)
        if (search.info[:, layout.STATUS] == layout.NOT_A_POSE).any():
            refuse_no_pose(T)
        q = search.q.reshape(*problem.batch, search.q.shape[-1])
        return IKResult(q, search.info, problem.batch, options.tolerances, _explanation(search, collisions))


def nearest_poses(problem: Problem) -> Search:
    """The nearest configurations to targets without a solution within the limits; and which of them are out of reach."""
    search = Search.of(problem, None)
    search.run(Restart(0, _MOST, STEPS, from_seed=True))
    close_unreachable(search)
    settle_open(search, out_of_time=False)
    return search


def _search(problem: Problem, collisions: CollisionFilter | None) -> Search:
    """Restarts; then, for unsolved targets, the best pose that can be reached and the reason."""
    rank = problem.query.options.rank
    cost, count = cost_of(problem, collisions), _FEW if rank is None and collisions is None else _MANY
    search = Search.of(problem, cost)
    out_of_time = search_with_restarts(search, count, close_unreachable, seed_alone=rank is None)
    if not (search.info[:, layout.STATUS] == layout.SOLVED).all():
        settle_open(search, out_of_time=out_of_time)
        explain_open(search, out_of_time=out_of_time)
    return search


def _explanation(search: Search, collisions: CollisionFilter | None) -> Explanation:
    query, problem = search.problem.query, search.problem
    hit = np.flatnonzero(search.info[:, layout.STATUS] == CODES[Status.IN_COLLISION])
    return Explanation(
        reach_excess=search.reach_excess,
        limit_excess=search.limit_excess,
        collisions={} if collisions is None else {int(i): collisions.pairs(search.q[i]) for i in hit},
        reach="" if problem.batch or not search.reach_excess else reach_in_words(problem, 0),
        entry_names=entry_names(query.tree) if search.limit_excess else (),
        task_axes=query.task_axes,
        trace=_trace(search) if query.options.trace else None,
    )


def _trace(search: Search) -> Array:
    return convergence(search.problem, search.info[0], search.origins.get(0), with_posture=bool(search.with_posture[0]))


def convergence(problem: Problem, info: Array, origin: Array | None = None, *, with_posture: bool = False) -> Array:
    """A row a step towards the result with this information: errors [m] and [rad], largest joint step, damping; (steps + 1, 4).

    origin: where the result was searched from, (n_dof,), if by no start of a round.

    A step depends on the configuration alone, so taking them one at a time gives the same result.
    """
    start, steps = int(info[layout.START]), int(info[layout.ITERATIONS])
    q = _start(problem, start) if origin is None else origin
    rows, alone = [], np.zeros(1, dtype=np.int64)
    for k in range(steps + 1):
        _, (before,) = run_from_each(problem, alone, q[None], 0, with_posture=with_posture)
        (after,), _ = run_from_each(problem, alone, q[None], 1, with_posture=with_posture)
        step = np.abs(after - q).max() if k < steps else 0.0
        rows.append([*before[[layout.POSITION_ERROR, layout.ROTATION_ERROR]], step, before[layout.DAMPING]])
        q = after
    table = np.array(rows)
    table[1:, 2], table[0, 2] = table[:-1, 2].copy(), 0.0
    return table


def _start(problem: Problem, start: int) -> Array:
    if start == 0:
        return problem.seeds[0]
    query = problem.query
    lower, upper, low, high = problem.bounds[0]
    share = unit_samples(query.tree, query.link, query.options.seed, start - 1, 1)[0]
    return np.clip(np.where(np.isnan(share), problem.seeds[0], low + share * (high - low)), lower, upper)
