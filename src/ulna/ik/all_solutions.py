"""All solutions for one pose: every branch of an arm whose solutions are isolated, or a spread set where they form a continuum.

1. Search from random starts, half of them with the joints that can turn all the way round let free (and then turned back
   into their limits by whole turns), which no limit stops on the way to a branch.
2. Keep what lies within the limits and differs from all that is kept, whole turns aside, by more than DISTINCT in some joint.
3. Where the Jacobian has as many independent rows as the arm has joints, a solution is isolated. Double the starts until that
   many more have found nothing new.
4. Elsewhere take ``n_spread`` of what was found, each as far as can be from those taken before (Gonzalez 1985).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.ik.bounds import limit_bounds
from ulna.ik.problem import STEPS, Problem
from ulna.ik.restarts import Restart, jobs
from ulna.ik.turns import nearest_turns, turning_columns
from ulna.ik.units import jacobian_in_unit, unit_of
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.jacobian import geometric_jacobian

Array = NDArray[np.float64]
DISTINCT = 1e-3  # rad or m
EXACT = 1e-9  # rad, and of the unit of the search
_FIRST, _MOST = 256, 16_384  # starts
_MOST_BRANCHES = 256  # more than any arm of six joints has (16): what is found beyond is a continuum
_ISOLATED = 1e-6  # of the largest singular value


def all_solutions(problem: Problem, n_spread: int) -> Array:
    """Distinct solutions for the problem's one target, nearest to the seed first: shape (n, n_dof).

    They are met to EXACT: near a singularity the caller's tolerance would make a whole family of each. Only a target that is met
    no better, at the border of the reach, is left to the tolerance.
    """
    settings = problem.settings.copy()
    for tolerance, exact in (
        (layout.POSITION_TOLERANCE, EXACT * unit_of(problem.tree, problem.link)),
        (layout.ROTATION_TOLERANCE, EXACT),
    ):
        settings[tolerance] = min(settings[tolerance], exact)
    found = _branches(replace(problem, settings=settings), n_spread)
    return found if len(found) else _branches(problem, n_spread)


def _branches(problem: Problem, n_spread: int) -> Array:
    found = np.empty((0, problem.tree.n_dof))
    free, clamped = _let_free(problem), problem
    first, count = 0, _FIRST
    while first < _MOST:
        before = len(found)
        for part, start in ((free, first), (clamped, first + count // 2)):
            found = _merge(problem, found, _solutions(part, Restart(start, count // 2, 3 * STEPS)))
        if _is_continuum(problem, found):
            found = _spread(problem, found, n_spread)
            break
        if first and len(found) == before:
            break
        first, count = first + count, first + count
    return found[np.argsort(_distances(problem, found, problem.seeds[0]), kind="stable")]


def _solutions(problem: Problem, part: Restart) -> Array:
    """What the starts of a round find, within the limits."""
    q, info = jobs(problem, np.zeros(1, dtype=np.int64), part)
    q = _turned_within_limits(problem, q[0, info[0, :, layout.STATUS] == layout.SOLVED])
    tree = problem.tree
    return q[((q >= tree.lower) & (q <= tree.upper)).all(axis=1)]


def _whole_turns(problem: Problem) -> NDArray[np.bool_]:
    """The entries of q that may turn all the way round."""
    tree = problem.tree
    return turning_columns(problem.chain, tree.n_dof) & (tree.upper - tree.lower >= 2 * np.pi)


def _let_free(problem: Problem) -> Problem:
    turning = _whole_turns(problem)
    bounds = limit_bounds(problem.tree.bounds).copy()
    middle = (bounds[0, 2] + bounds[0, 3]) / 2
    bounds[0, 0, turning], bounds[0, 1, turning] = -np.inf, np.inf
    bounds[0, 2, turning], bounds[0, 3, turning] = middle[turning] - np.pi, middle[turning] + np.pi
    return replace(problem, bounds=bounds)


def _turned_within_limits(problem: Problem, q: Array) -> Array:
    """q with whole turns added where a joint can make them: within the limits, as near to the seed as that allows."""
    tree = problem.tree
    return nearest_turns(q, problem.seeds[0], tree.lower, tree.upper, _whole_turns(problem))


def _differences(problem: Problem, a: Array, b: Array) -> Array:
    """|a - b| by entry, whole turns aside for joints that can make them."""
    difference = np.abs(a - b)
    turned = np.abs(difference - 2 * np.pi * np.rint(difference / (2 * np.pi)))
    return np.where(_whole_turns(problem), turned, difference)


def _distances(problem: Problem, found: Array, q: Array) -> Array:
    return _differences(problem, found, q).max(axis=-1, initial=0.0)


def _merge(problem: Problem, found: Array, more: Array) -> Array:
    for q in more:
        if len(found) < _MOST_BRANCHES and (_distances(problem, found, q) > DISTINCT).all():
            found = np.vstack([found, q])
    return found


def _is_continuum(problem: Problem, found: Array) -> bool:
    """Whether the solutions are not isolated: more joints than rows, or far more solutions than any arm has branches."""
    moving = problem.tree.moving_columns(problem.link)
    asked = int((np.asarray(problem.task.slack) == 0.0).sum())
    if len(moving) > asked or len(found) >= _MOST_BRANCHES:
        return True
    if not len(found):
        return False
    J = jacobian_in_unit(
        problem, geometric_jacobian(problem.tree, found, problem.link, "base"), unit_of(problem.tree, problem.link)
    )[..., moving]
    values = np.linalg.svd(J, compute_uv=False)
    return bool((values[:, len(moving) - 1] < _ISOLATED * values[:, 0]).all())


def _spread(problem: Problem, found: Array, n: int) -> Array:
    """n of the configurations, the first nearest to the seed, each next as far as can be from all before."""
    if not len(found):
        return found
    chosen = [int(_distances(problem, found, problem.seeds[0]).argmin())]
    nearest = _distances(problem, found, found[chosen[0]])
    while len(chosen) < min(n, len(found)):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, _distances(problem, found, found[chosen[-1]]))
    return found[chosen]
