"""Searches for all solutions of one pose: every branch, or a spread set of a continuum.

1. Search from random starts. For half of them, the joints that can make whole turns are unlimited, so that no limit stops them on
   the way to a branch. Whole turns bring them back into their limits.
2. Keep results within the limits that differ from all kept ones, up to whole turns, by more than DISTINCT in some joint.
3. If the Jacobian has as many independent rows as the arm has joints, a solution is isolated. Double the number of starts until
   as many more find nothing new.
4. Otherwise choose ``n_spread`` of the results, each as far as possible from the earlier ones (Gonzalez 1985).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import replaced
from ulna.ik.problem import STEPS, Problem, Query, make_problem
from ulna.ik.search.restarts import Restart, run_starts
from ulna.ik.search.starts import limit_starts
from ulna.ik.search.units import jacobian_in_unit
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.jacobian import geometric_jacobian
from ulna.kinematics.turns import nearest_turns, turning_columns

Array = NDArray[np.float64]
DISTINCT = 1e-3  # rad, or a share of the arm's size for a prismatic joint
EXACT = 1e-9  # rad, or in the unit of the search
_FIRST, _MAX_STARTS, _MAX_AT_LIMITS = 256, 16_384, 2048  # starts
_MAX_BRANCHES = 256  # more than any arm of six joints has (16): more solutions are a continuum
_ISOLATED = 1e-6  # relative to the largest singular value


def searched_solutions(query: Query, T: Array, seed: Array, n_spread: int) -> Array:
    """Distinct solutions of one target (4, 4) within the limits, nearest to the seed first: shape (n, n_dof).

    Their error is at most EXACT: near a singularity the caller's tolerance would turn each solution into a whole family. The
    caller's tolerance applies only if no solution is so exact, as at the border of the reach.
    """
    problem = make_problem(query, T, seed)
    tolerances = problem.settings[0]
    exact = replaced(
        problem.settings,
        position_tolerance=min(tolerances.position_tolerance, EXACT * query.unit),
        rotation_tolerance=min(tolerances.rotation_tolerance, EXACT),
    )
    found = _branches(replace(problem, settings=exact), n_spread)
    if not len(found):
        found = _branches(problem, n_spread)
    return found if len(found) else _at_limits(problem, n_spread)


def _branches(problem: Problem, n_spread: int) -> Array:
    found = np.empty((0, problem.query.tree.n_dof))
    free, clamped = _without_turn_limits(problem), problem
    first, count = 0, _FIRST
    while first < _MAX_STARTS:
        n_before = len(found)
        for part, start in ((free, first), (clamped, first + count // 2)):
            found = _merge(problem, found, _solutions(part, Restart(start, count // 2, 3 * STEPS)))
        if _is_continuum(problem, found):
            found = _choose_spread(problem, found, n_spread)
            break
        if first and len(found) == n_before:
            break
        first, count = first + count, first + count
    return _nearest_first(problem, found)


def _nearest_first(problem: Problem, found: Array) -> Array:
    return found[np.argsort(_distances(problem, found, problem.seeds[0]), kind="stable")]


def _at_limits(problem: Problem, n_spread: int) -> Array:
    """The solutions found from configurations with joints at their limits only."""
    starts = limit_starts(problem, np.zeros(1, dtype=np.int64), _MAX_AT_LIMITS)[0]
    problems = replace(problem, seeds=starts, targets=np.repeat(problem.targets, len(starts), axis=0))
    q, info = run_starts(problems, np.arange(len(starts)), Restart(0, 1, 3 * STEPS, from_seed=True))
    found = _merge(problem, np.empty((0, q.shape[-1])), q[info["status"] == layout.SOLVED])
    found = _choose_spread(problem, found, n_spread) if _is_continuum(problem, found) else found
    return _nearest_first(problem, found)


def _solutions(problem: Problem, part: Restart) -> Array:
    """The solutions within the limits from the starts of a round."""
    q, info = run_starts(problem, np.zeros(1, dtype=np.int64), part)
    q = _turn_within_limits(problem, q[0, info["status"][0] == layout.SOLVED])
    tree = problem.query.tree
    return q[((q >= tree.lower) & (q <= tree.upper)).all(axis=1)]


def _whole_turns(problem: Problem) -> NDArray[np.bool_]:
    """Mask of the entries of q that can make whole turns."""
    tree = problem.query.tree
    return turning_columns(problem.chain, tree.n_dof) & (tree.upper - tree.lower >= 2 * np.pi)


def _without_turn_limits(problem: Problem) -> Problem:
    turning = _whole_turns(problem)
    bounds = problem.query.limits.copy()
    middle = (bounds[0, 2] + bounds[0, 3]) / 2
    bounds[0, 0, turning], bounds[0, 1, turning] = -np.inf, np.inf
    bounds[0, 2, turning], bounds[0, 3, turning] = middle[turning] - np.pi, middle[turning] + np.pi
    return replace(problem, bounds=bounds)


def _turn_within_limits(problem: Problem, q: Array) -> Array:
    """q with whole turns added: within the limits, and as near to the seed as possible."""
    tree = problem.query.tree
    return nearest_turns(q, problem.seeds[0], tree.lower, tree.upper, _whole_turns(problem))


def _differences(problem: Problem, a: Array, b: Array) -> Array:
    """|a - b| by entry, up to whole turns, and in shares of the arm's size for prismatic joints."""
    difference = np.abs(a - b) / problem.query.units
    turned = np.abs(difference - 2 * np.pi * np.rint(difference / (2 * np.pi)))
    return np.where(_whole_turns(problem), turned, difference)


def _distances(problem: Problem, found: Array, q: Array) -> Array:
    return _differences(problem, found, q).max(axis=-1, initial=0.0)


def _merge(problem: Problem, found: Array, more: Array) -> Array:
    for q in more:
        if len(found) < _MAX_BRANCHES and (_distances(problem, found, q) > DISTINCT).all():
            found = np.vstack([found, q])
    return found


def _is_continuum(problem: Problem, found: Array) -> bool:
    """Whether the solutions are not isolated: more joints than rows, or far more solutions than branches of any arm."""
    query = problem.query
    moving = query.tree.moving_columns(query.link)
    n_required = int((np.asarray(query.options.task.slack) == 0.0).sum())
    if len(moving) > n_required or len(found) >= _MAX_BRANCHES:
        return True
    if not len(found) or not len(moving):
        return False
    J = _task_jacobian(problem, found)[..., moving]
    values = np.linalg.svd(J, compute_uv=False)
    return bool((values[:, len(moving) - 1] < _ISOLATED * values[:, 0]).all())


def _task_jacobian(problem: Problem, q: Array) -> Array:
    """The rows of the Jacobian that the task requires, in its axes, shape (..., n_rows, n_dof)."""
    query = problem.query
    rows = jacobian_in_unit(problem, geometric_jacobian(query.tree, q, query.link, "link"), query.unit)
    if query.task_axes is not None:
        rows = np.concatenate([query.task_axes.T @ rows[..., :3, :], query.task_axes.T @ rows[..., 3:, :]], axis=-2)
    return rows[..., np.asarray(query.options.task.slack) == 0.0, :]


def _choose_spread(problem: Problem, found: Array, n: int) -> Array:
    """n of the configurations, the first nearest to the seed, each next one farthest from all before."""
    if not len(found):
        return found
    chosen = [int(_distances(problem, found, problem.seeds[0]).argmin())]
    nearest = _distances(problem, found, found[chosen[0]])
    while len(chosen) < min(n, len(found)):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, _distances(problem, found, found[chosen[-1]]))
    return found[chosen]
