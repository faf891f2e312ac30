"""Finds the joint path of an arm with isolated solutions: every pose is a layer with all of its branches.

With an exact closed form the layers contain every solution. The graph then contains every path with steps up to the maximum. The
best chain is the best path, and if no chain goes through all layers, no path exists.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.axes import N_AXES
from ulna.ik.closed_form.branches import all_branches
from ulna.ik.entries import closed_form
from ulna.ik.following.course import Course, split_as
from ulna.ik.following.graph import SAME, Graph, Key
from ulna.ik.solutions import PROOFS, Proof
from ulna.kernels.chain.closed_form_layout import AT_LIMIT, ENOUGH, HARDLY_BEYOND
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]
_PROVED = tuple(PROOFS.index(proof) for proof in (Proof.COMPLETE, Proof.COINCIDING))
_MAX_KNOTS, _STARTS, _MAX_BRANCHES = 64, 256, 16
_MAX_ROUNDS = 200
_MAX_ADDED = 50  # maximum number of times that solutions of the search are added where no path continues
_STEPS = 16


@dataclass(frozen=True, eq=False)
class PathSoFar:
    """The beginning of a joint path, and the facts at its end.

    Attributes:
        q: Shape (k, n_dof).
        ends: Other configurations in which chains end, shape (m, n_dof).
        next_nodes: The known solutions of the first unreached pose, shape (m, n_dof).
        proved: Whether it is proved that no path goes further.
    """

    q: Array
    ends: Array
    next_nodes: Array
    proved: bool


def along_branches(course: Course) -> PathSoFar:
    """The best chain of solutions through all poses, or the longest chain."""
    nodes, all_known = make_layers(course)
    nodes = at_both_limits(course, [with_start(course, nodes[0]), *nodes[1:]])
    ones = np.ones(len(nodes))
    costs = split_as(nodes, course.costs(np.concatenate(nodes)))
    graph = Graph(course, nodes, costs, course.max_step * ones, course.weight * ones)
    q = _best_path(graph)
    for _ in range(_MAX_ADDED):
        k = len(q)
        added = _continuations(graph, k)
        if not len(added) or graph.done.n_layers > k or course.limit.is_over():
            break
        graph.add(k, added)
        all_known[k] = False
        q = _best_path(graph)
    next_nodes = nodes[len(q)] if len(q) < len(nodes) else np.empty((0, q.shape[1]))
    has_all_edges = not graph.removed and not course.lifts.cut.any() and not course.lifts.omits(course.max_step)
    proved = bool(all_known[: len(q) + 1].all()) and has_all_edges
    return PathSoFar(q, graph.ends(), next_nodes, proved=proved)


def _continuations(graph: Graph, k: int) -> Array:
    """New nodes of pose k within a step of the ends, by search, in their first turn, shape (m, n_dof).

    At the end of the arm's reach a pose may have a solution within the tolerance of the search, but no exact one.
    """
    course, ends = graph.course, graph.ends()
    if not 0 < k < len(graph.nodes) or not len(ends):
        return ends[:0]
    ends = ends[:: max(1, len(ends) // _MAX_BRANCHES)]
    q, found = course.solutions_near(np.full(len(ends), k), ends)
    steps = course.steps_within(ends, q)
    found &= np.abs(steps).max(axis=1, initial=0.0) <= course.max_step
    found &= ~course.collide(q) & ~course.edges_collide(ends, ends + steps)
    q = _distinct(course, course.lifts.first_turn(q[found]))
    distances = np.abs(course.lifts.steps(graph.nodes[k], q[:, None])[0]) / course.query.units
    is_new = distances.max(axis=2).min(axis=1, initial=np.inf) > SAME
    return at_both_limits(course, [q[is_new]])[0]


def _best_path(graph: Graph) -> Array:
    """The cheapest path without colliding edges."""

    def colliding(q: Array, chain: NDArray[np.int64]) -> list[Key]:
        hit = np.flatnonzero(graph.course.edges_collide(q[:-1], q[1:]))
        return [(int(k), int(chain[k, 0]), int(chain[k + 1, 0])) for k in hit]

    q, _, wrong = graph.best(colliding, _MAX_ROUNDS)
    return q[: wrong[0][0] + 1] if wrong else q


def make_layers(course: Course) -> tuple[list[Array], Truths]:
    """The valid solutions (m, n_dof) of every pose, in their first turn, clear of the world.

    They come from the closed form or from a search. The second result states whether they are proved to be all solutions of a
    pose, shape (n,). Arms of fewer than six joints reach few poses exactly: if the closed form misses a pose, the search may
    reach it within the tolerance.
    """
    form, rows, proved = course.form, None, np.zeros(len(course.targets), dtype=bool)
    if form is not None and form.is_exact and form.held_column is None:
        rows, known = _layers_in_closed_form(course)
        rows, proved = (rows, known) if form.n_joints == N_AXES or all(map(len, rows)) else (None, proved)
    rows = _search_layers(course) if rows is None else rows
    return course.without_collisions(split_as(rows, course.lifts.first_turn(np.concatenate(rows)))), proved


def _layers_in_closed_form(course: Course) -> tuple[list[Array], Truths]:
    form = course.form
    if form is None:
        raise AssertionError("only arms with a closed form")
    found = all_branches(form, course.query.tree, course.targets, course.start[None].copy())
    rows, proved = [q[valid] for q, valid in zip(found.q, found.valid, strict=True)], np.isin(found.proof, _PROVED)
    rows = with_solutions_at_limits(course, rows)
    lines = [_continued_lines(course, rows, proved, towards) for towards in (1, -1)]
    for k in np.flatnonzero(~proved).tolist():
        rows[k] = _distinct(course, np.vstack([rows[k], *(line[k] for line in lines)]))
    return rows, proved


def _continued_lines(course: Course, rows: list[Array], proved: Truths, towards: int) -> dict[int, Array]:
    """Continuations from the neighboring pose, for each pose without a proof. Its own solutions may not fit its neighbors.

    If a joint may have any angle at many consecutive poses, the same lines continue through all of them. A pose's own solutions
    begin new lines while there are fewer than _MAX_BRANCHES.
    """
    lines: dict[int, Array] = {}
    for k in np.flatnonzero(~proved).tolist()[::towards]:
        if course.limit.is_over():
            lines[k] = rows[k]
            continue
        ends = lines.get(k - towards, rows[k - towards] if 0 <= k - towards < len(rows) else rows[k][:0])
        q, found = course.solutions_near(np.full(len(ends), k), ends)
        lines[k] = _distinct(course, np.vstack([q[found], rows[k]]))[:_MAX_BRANCHES]
    return lines


def _search_layers(course: Course) -> list[Array]:
    """Solutions of some poses from many starts, continued to all others."""
    n, n_dof = len(course.targets), course.query.tree.n_dof
    knots = np.unique(np.linspace(0, n - 1, min(n, _MAX_KNOTS)).round().astype(np.int64))
    found = course.search(knots, _STARTS)
    by_knot = {int(k): _distinct(course, q)[:_MAX_BRANCHES] for k, q in zip(knots, found, strict=True)}
    rows = [[by_knot.get(k, np.empty((0, n_dof)))] for k in range(n)]
    for towards in (1, -1):
        _continue_all(course, knots, by_knot, rows, towards)
    return [_distinct(course, np.vstack(parts)) for parts in rows]


def _continue_all(
    course: Course, knots: NDArray[np.int64], by_knot: dict[int, Array], rows: list[list[Array]], towards: int
) -> None:
    """Continue the solutions of all knots at once, pose by pose, until one pose before the next knot."""
    ends = np.r_[knots[1:], len(rows)] if towards > 0 else np.r_[-1, knots[:-1]]
    pose = np.concatenate([np.full(len(by_knot[int(k)]), k) for k in knots])
    last = np.concatenate([np.full(len(by_knot[int(k)]), end) for k, end in zip(knots, ends, strict=True)])
    q = np.concatenate([by_knot[int(k)] for k in knots])
    while len(pose) and not course.limit.is_over():
        pose = pose + towards
        going = pose != last
        pose, last, q = pose[going], last[going], q[going]
        if not len(pose):
            break
        q, found = course.solutions_near(pose, q)
        pose, last, q = pose[found], last[found], q[found]
        for k in np.unique(pose):
            rows[int(k)].append(q[pose == k])


def _distinct(course: Course, q: Array) -> Array:
    """Rows of q without duplicates, up to whole turns."""
    chosen, others = _is_isolated(course, q), []
    for i in np.flatnonzero(~chosen).tolist():
        distances = np.abs(course.lifts.steps(np.array(others).reshape(-1, q.shape[1]), q[i])[0]) / course.query.units
        if distances.max(axis=1).min(initial=np.inf) > SAME:
            chosen[i] = True
            others.append(q[i])
    return q[chosen]


def _is_isolated(course: Course, q: Array) -> Truths:
    """Mask of the rows of q (m, n_dof) that differ from all others in the entry with the largest spread."""
    if not q.size:
        return np.ones(len(q), dtype=bool)
    j = int(np.argmax(np.ptp(q, axis=0)))
    turns = bool((course.lifts.lifted | course.lifts.free)[j])
    x = np.mod(q[:, j], TURN) if turns else q[:, j]
    order = np.argsort(x, kind="stable")
    wrap_gap = x[order[0]] + TURN - x[order[-1]] if turns else np.inf
    is_apart = np.r_[wrap_gap, np.diff(x[order]), wrap_gap] > 2 * SAME * course.query.units[j]
    isolated = np.empty(len(q), dtype=bool)
    isolated[order] = is_apart[:-1] & is_apart[1:]
    return isolated


def with_start(course: Course, q: Array) -> Array:
    """Add the solution of the first pose that the search finds from the start."""
    from_start, found = course.solutions_near(np.zeros(1, dtype=np.int64), course.start[None])
    from_start = course.lifts.first_turn(from_start[found & ~course.collide(from_start)])
    return _distinct(course, np.vstack([from_start, q]))


def at_both_limits(course: Course, nodes: list[Array]) -> list[Array]:
    """Nodes of layers; nodes at a limit also at the other limit, if they are whole turns apart."""
    if not course.lifts.closed.any():
        return nodes
    every = np.concatenate(nodes)
    at_limit = np.any(course.lifts.closed & (every <= course.lifts.lower + AT_LIMIT), axis=1)
    return [course.lifts.at_both_limits(q) if some.any() else q for q, some in zip(nodes, split_as(nodes, at_limit), strict=True)]


def with_solutions_at_limits(course: Course, rows: list[Array]) -> list[Array]:
    """The solutions of each pose (m, n_dof) within the limits, followed by those that whole turns bring to a limit.

    The closed form puts a joint that hardly exceeds a limit at the limit, in the turn nearest to a seed. In another turn the
    joint may hardly exceed a limit as well. There it is another solution: the joint at the limit, the others moved to reach the
    pose.
    """
    tree, q = course.query.tree, np.concatenate(rows)
    pose = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    for j in np.flatnonzero(course.lifts.lifted).tolist():
        for limit, outwards in ((tree.lower[j], -1.0), (tree.upper[j], 1.0)):
            if not np.isfinite(limit):
                continue
            beyond = outwards * (q[:, j] - limit)
            beyond -= TURN * np.rint(beyond / TURN)
            indices = np.flatnonzero((beyond > AT_LIMIT) & (beyond <= HARDLY_BEYOND))
            at_limit, reached = _solved_at(course, pose[indices], q[indices], j, limit)
            q, pose = np.vstack([q, at_limit[reached]]), np.r_[pose, pose[indices[reached]]]
    order = np.argsort(pose, kind="stable")
    return np.split(q[order], np.searchsorted(pose[order], np.arange(1, len(rows))))


def _solved_at(course: Course, pose: NDArray[np.int64], q: Array, j: int, limit: float) -> tuple[Array, NDArray[np.bool_]]:
    """Configurations (m, n_dof) with joint j at a limit, the others by Newton steps, and whether they are solutions."""
    tree, errors = course.query.tree, np.ones(len(pose))
    q = q.copy()
    q[:, j] = limit
    bounds, share = np.r_[tree.lower, tree.upper], 1.0 / course.query.unit
    closed_form.polish_all(tree.chain(course.query.link), course.targets[pose], q, bounds, share, _STEPS, errors)
    return q, (errors <= ENOUGH) & (q[:, j] == limit)
