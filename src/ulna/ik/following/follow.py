"""Finds a joint path through poses, or the reason why there is none: the interface of this folder.

The idea. Every pose of the path is a *layer* of a graph. Its nodes are the solutions of inverse kinematics within the limits and
clear of the world. An edge joins nodes of neighboring layers if no joint moves by more than ``max_step`` and the straight line
between them is clear. A joint path is a chain of edges through all layers. The chain that minimizes

    sum over k of  weight |q_k - q_(k-1)|^2 + cost of the rank at q_k

is found by dynamic programming (Bellman 1957), layer by layer. The minimum sum to a node is that of a previous node plus the edge
between them (``graph``). A jump to another branch is a step longer than ``max_step``, so it is no edge.

1. ``course``: the poses, and the conditions on a joint path.
2. ``lifts``: joints that can make whole turns have several positions for one angle. A node is stored once, and its turns are a
   second index of the graph. Otherwise six joints of three turns each would make 729 nodes.
3. ``layers``: arms of six joints or fewer. The closed form gives every node of a layer, so the best chain is the best path. If no
   chain goes through all layers, no path exists (``complete``). Without a closed form, nodes come from a search, and nothing is
   proved.
4. ``self_motions``: if there are more joints than the task has components, a pose has infinitely many solutions. Layers are some
   of the poses, nodes are samples. The search fills in the edges of the best chain, and the path is smoothed.
5. ``ending``: the reason why no chain continues.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_floats, positive
from ulna.description.pose import as_pose
from ulna.errors import InputError
from ulna.ik.followed_path import FollowedPath
from ulna.ik.following.course import Course, Solve
from ulna.ik.following.ending import out_of_time, why_it_ends
from ulna.ik.following.layers import PathSoFar, along_branches
from ulna.ik.following.self_motions import along_self_motions
from ulna.ik.problem import Query
from ulna.ik.reason import NO_REASON
from ulna.ik.search.ranking import refuse_clearance_of_nothing
from ulna.ik.solutions import Proof
from ulna.ik.time_limit import TimeLimit
from ulna.kinematics.positions import as_configuration
from ulna.kinematics.tree import entry_names

Array = NDArray[np.float64]


def follow(
    query: Query,
    T_path: ArrayLike,
    q_start: ArrayLike | None,
    max_step: float,
    world: World | None,
    solve: Solve,
    limit: TimeLimit,
) -> FollowedPath:
    """See ``Robot.follow``; ``solve`` is inverse kinematics of one pose from a seed."""
    start, excess = _start(query, q_start)
    step = positive("max_step", max_step)
    course = Course(query, _targets(T_path), start, q_start is not None, step, world, solve, limit, excess)
    refuse_clearance_of_nothing(query.options.rank, world)
    found = _found(course)
    if course.excess(found.q).any():
        course = replace(course, one_sided=True)
        found = _found(course)
    return _result(course, found)


def _found(course: Course) -> PathSoFar:
    """The path, which may exceed a limit on one side unless ``one_sided``.

    If it exceeds one, no path within the limits has a lower cost.
    """
    return along_self_motions(course) if course.is_redundant else along_branches(course)


def _result(course: Course, found: PathSoFar) -> FollowedPath:
    n, k = len(course.targets), len(found.q)
    q = np.full((n, len(course.start)), np.nan)
    q[:k] = found.q
    ends = found.ends if k else course.start[None] if course.started else found.ends
    is_over = k < n and course.limit.is_over()
    if k == n:
        reason = NO_REASON
    elif is_over:
        reason = out_of_time(course, k, ends)
    else:
        reason = why_it_ends(course, k, ends, found.next_nodes, are_all=found.proved)
    is_contradicted = bool(reason) and reason.data.smallest_step <= course.max_step  # the search is less exact than the nodes
    return FollowedPath(
        q=q,
        q_start=course.start if course.started else None,
        max_step=course.max_step,
        ends_at=None if k == n else k,
        reason=reason,
        proof=Proof.COMPLETE if found.proved and not is_contradicted and not is_over else Proof.SEARCHED,
        joint_names=entry_names(course.query.tree),
    )


def _targets(T_path: ArrayLike) -> Array:
    targets = as_floats("T_path", T_path)
    if targets.ndim != 3 or targets.shape[1:] != (4, 4) or not len(targets):
        raise InputError("T_path", f"shape {targets.shape}; poses of shape (n, 4, 4), n at least 1, are expected")
    return np.ascontiguousarray(as_pose(targets, "T_path"))


def _start(query: Query, q_start: ArrayLike | None) -> tuple[Array, Array]:
    """The start within the limits, and the excess of the given start over them."""
    if q_start is None:
        return query.home.copy(), np.zeros(len(query.home))
    start = as_configuration(q_start, query.tree, "q_start")
    within = np.clip(start, query.tree.lower, query.tree.upper)
    return within, np.abs(start - within)
