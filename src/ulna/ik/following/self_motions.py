"""Finds the joint path of a redundant arm: a graph over some poses, filled in between.

1. *Knots* are poses spread evenly over the path's length. The nodes of a knot are its solutions at samples of the redundancy.
   They come from a search with random starts and, with a closed form, from all branches at positions of the held joint.
2. An edge joins nodes of neighboring knots that are near each other. The best chain is found over all edges (``graph``).
3. Each edge of that chain is filled. Guesses on the straight line between its nodes are brought to the poses by the search,
   within the limits. If a pose is not reached, a step is too long or something collides, the edge is removed, and step 2 is
   repeated.
4. If no chain is left, the longest is continued pose by pose (``_continue``). If that ends too, more samples and more knots are
   taken. A path between the samples may still be missed.
5. The path is smoothed (``_smooth``).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.branches import sampled_branches
from ulna.ik.following.course import Course
from ulna.ik.following.graph import Graph, Key
from ulna.ik.following.layers import PathSoFar, at_both_limits, with_start

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


class _Density(NamedTuple):
    """The density of an attempt's samples over path and redundancy.

    Attributes:
        samples: Positions of the held joint.
        starts: Random starts of the search.
        min_distance: Nodes of a knot nearer than about this count as one [rad or m].
        length: The path's length between knots [units of the arm and rad].
        knots: The maximum number of knots.
    """

    samples: int
    starts: int
    min_distance: float
    length: float
    knots: int


_ATTEMPTS = (_Density(16, 512, 0.12, 0.15, 300), _Density(48, 1536, 0.06, 0.1, 450), _Density(128, 4096, 0.04, 0.05, 900))
_MIN_KNOTS = 8
_NEAR = 0.6  # rad or m: a straight line between solutions farther apart leaves the branch
_MAX_ROUNDS, _MAX_BESIDE = 400, 3000
_MAX_ENDS, _GUESSES = 64, 6  # configurations in which a path ends, and guesses from each
_ROUNDS = 12  # of smoothing


def along_self_motions(course: Course) -> PathSoFar:
    """A path through all poses, or the longest path of all attempts."""
    best = np.empty((0, len(course.start)))
    ends = best
    for density in _ATTEMPTS:
        knots = _knots(course, density)
        q, last = _continue(course, _path(course, knots, _nodes(course, knots, density)))
        if len(q) == len(course.targets):
            return PathSoFar(_smooth(course, q, int(np.diff(knots).max(initial=1))), last, best[:0], proved=False)
        if len(q) > len(best):
            best, ends = q, last
        if course.limit.is_over():
            break
    return PathSoFar(best, ends, best[:0], proved=False)


def _knots(course: Course, density: _Density) -> Counts:
    """The indices of poses spread evenly over the path's length [units of the arm and rad], including its ends."""
    T = course.targets
    moved = np.linalg.norm(np.diff(T[:, :3, 3], axis=0), axis=1) / course.query.unit
    turned = np.linalg.norm(np.diff(T[:, :3, :3], axis=0), axis=(1, 2)) / np.sqrt(2.0)  # 2 sin(angle / 2)
    length = np.cumsum(np.r_[0.0, moved + turned])
    count = int(np.clip(np.ceil(length[-1] / density.length), _MIN_KNOTS, density.knots)) + 1
    return np.unique(np.r_[np.searchsorted(length, np.linspace(0.0, length[-1], count)), 0, len(T) - 1])


def _nodes(course: Course, knots: Counts, density: _Density) -> list[Array]:
    """Solutions of every knot that are clear of the world, in their first turn, thinned."""
    sources = [course.search(knots, density.starts)]
    if course.form is not None and not course.limit.is_over():
        sources.append(_sampled(course, knots, density.samples))
    rows = [_thin(course.lifts.first_turn(np.concatenate(parts)), density.min_distance) for parts in zip(*sources, strict=True)]
    rows[0] = with_start(course, rows[0])
    return at_both_limits(course, course.without_collisions(rows))


def _sampled(course: Course, knots: Counts, n_samples: int) -> list[Array]:
    form, tree = course.form, course.query.tree
    if form is None or form.held_column is None:
        raise AssertionError("a joint is held where there are seven")
    seeds = course.start[None].copy()
    found = sampled_branches(form, tree, course.targets[knots], seeds, n_samples)
    return [q[valid] for q, valid in zip(found.q, found.valid, strict=True)]


def _thin(q: Array, min_distance: float) -> Array:
    """The first row of q (m, n_dof) in each cell of a grid."""
    _, first = np.unique(np.rint(q / min_distance), axis=0, return_index=True)
    return q[np.sort(first)]


def _path(course: Course, knots: Counts, nodes: list[Array]) -> Array:
    """The path along the best chain whose edges can all be filled, or the longest one, shape (k, n_dof)."""
    gaps = np.diff(knots).astype(np.float64)
    longest = np.minimum(course.max_step * gaps, _NEAR)
    costs = [course.costs(q) * gap for q, gap in zip(nodes, np.r_[gaps, 1.0], strict=True)]
    graph = Graph(course, nodes, costs, longest, course.weight / gaps)
    filler = _EdgeFiller(graph, knots)
    q, chain, _ = graph.best(filler.wrong_edges, _MAX_ROUNDS)
    return filler.path_along(q, chain)


class _EdgeFiller:
    """The poses between knots, on the edges that were tried; each edge is tried once."""

    def __init__(self, graph: Graph, knots: Counts) -> None:
        self._graph, self._course, self._knots = graph, graph.course, knots
        self._known: dict[Key, Array | None] = {}

    def wrong_edges(self, q: Array, chain: Counts) -> list[Key]:
        """The edges of a chain that cannot be filled, and other such edges of these layers.

        q: The chain's nodes, shape (m, n_dof).
        """
        keys = self._keys(chain)
        self._try([(key, q[k], q[k + 1]) for k, key in enumerate(keys)])
        wrong = [k for k, key in enumerate(keys) if self._known[key] is None]
        if self._course.limit.is_over():
            return [keys[k] for k in wrong]
        neighbors = [edge for k in wrong for edge in self._neighboring_edges(k, q[k])]
        self._try(neighbors)
        return [keys[k] for k in wrong] + [key for key, *_ in neighbors if self._known[key] is None]

    def _neighboring_edges(self, k: int, q: Array) -> list[tuple[Key, Array, Array]]:
        """The cheapest edges from layer k that stay within the limits with the turns nearest to a configuration q (n_dof,)."""
        edges, lifts, tree = self._graph.edges(k), self._course.lifts, self._course.query.tree
        cheapest = np.argsort(edges.cost, kind="stable")[:_MAX_BESIDE]
        begin, end = edges.begin[cheapest], edges.end[cheapest]
        a = lifts.nearest(self._graph.nodes[k][begin], q)
        b = a + lifts.steps(self._graph.nodes[k][begin], self._graph.nodes[k + 1][end])[0]
        good = np.flatnonzero(((b >= tree.lower) & (b <= tree.upper)).all(axis=1))
        return [((k, int(begin[i]), int(end[i])), a[i], b[i]) for i in good]

    def path_along(self, q: Array, chain: Counts) -> Array:
        """The path along a chain with all of its poses, up to its last knot or first wrong edge."""
        rows = [q[:1]]
        for k, key in enumerate(self._keys(chain)):
            steps = self._known[key]
            if steps is None:
                break
            rows.append(q[k] + steps)
        return np.concatenate(rows)

    def _keys(self, chain: Counts) -> list[Key]:
        return [(k, int(chain[k, 0]), int(chain[k + 1, 0])) for k in range(len(chain) - 1)]

    def _try(self, edges: list[tuple[Key, Array, Array]]) -> None:
        """Fill the unknown ones of some edges from a to b, all at once.

        The result is stored relative to an edge's first node.
        """
        new = list({key: (key, a, b) for key, a, b in edges if key not in self._known}.values())
        if not new:
            return
        course, knots = self._course, self._knots
        order = np.concatenate([np.arange(knots[k] + 1, knots[k + 1]) for (k, *_), _, _ in new])
        guesses = np.concatenate([_straight(a, b, int(knots[k + 1] - knots[k])) for (k, *_), a, b in new])
        between, found = course.solutions_near(order, guesses)
        found &= ~course.collide(between)
        ends = np.cumsum([knots[k + 1] - knots[k] - 1 for (k, *_), _, _ in new])[:-1]
        for (key, a, b), rows, good in zip(new, np.split(between, ends), np.split(found, ends), strict=True):
            line = np.vstack([a, rows, b])
            is_right = (
                good.all()
                and np.abs(np.diff(line, axis=0)).max() <= course.max_step
                and not course.edges_collide(line[:-1], line[1:]).any()
            )
            self._known[key] = line[1:] - a if is_right else None


def _straight(a: Array, b: Array, n: int) -> Array:
    """The points that divide the line from a to b into n equal parts, shape (n - 1, n_dof)."""
    share = np.arange(1, n)[:, None] / n
    return a + share * (b - a)


def _continue(course: Course, q: Array) -> tuple[Array, Array]:
    """Continue a path (k, n_dof) pose by pose as far as possible; and all known ends, shape (m, n_dof).

    Each pose has a set of configurations in which a path ends. Guesses are these, and points at random distances from them,
    brought to the next pose by the search. The results within the limits, within a step and clear of the world are kept, and
    thinned.
    """
    if not len(q):
        return q, q
    sets, parents = [q[-1:]], [np.zeros(1, dtype=np.int64)]
    rng = np.random.default_rng(course.query.options.seed)
    for k in range(len(q), len(course.targets)):
        if course.limit.is_over():
            break
        following, come_from = _next(course, k, sets[-1], rng)
        if not len(following):
            break
        sets.append(following)
        parents.append(come_from)
    return np.vstack([q, _trace_back(sets, parents)]), sets[-1]


def _next(course: Course, k: int, ends: Array, rng: np.random.Generator) -> tuple[Array, Counts]:
    """Configurations of pose k, shape (m, n_dof), and the end that each comes from, shape (m,)."""
    parent = np.tile(np.arange(len(ends)), _GUESSES)
    offsets = rng.normal(size=(len(parent), ends.shape[1])) * course.max_step * rng.random((len(parent), 1))
    offsets[: len(ends)] = 0.0
    q, good = course.solutions_near(np.full(len(parent), k), ends[parent] + offsets)
    good &= np.abs(q - ends[parent]).max(axis=1) <= course.max_step
    good &= ~course.collide(q)
    q, parent = q[good], parent[good]
    _, first = np.unique(np.rint(q / (course.max_step / 2)), axis=0, return_index=True)
    first = np.sort(first)
    first = first[~course.edges_collide(ends[parent[first]], q[first])]
    if len(first) > _MAX_ENDS:
        first = np.sort(rng.permutation(first)[:_MAX_ENDS])
    return q[first], parent[first]


def _trace_back(sets: list[Array], parents: list[Counts]) -> Array:
    """The path through the sets, without the first one, to the first configuration of the last."""
    index, rows = 0, []
    for q, parent in zip(sets[:0:-1], parents[:0:-1], strict=True):
        rows.append(q[index])
        index = int(parent[index])
    return np.array(rows[::-1]).reshape(-1, sets[0].shape[1])


def _smooth(course: Course, q: Array, width: int) -> Array:
    """Smooth a path (n, n_dof) through the same poses, so that its cost does not increase.

    Guesses are the means over up to 2 ``width`` + 1 poses, brought to the poses by the search. A round is undone, and the width
    halved, if the path becomes longer, jumps, exceeds the limits or collides.
    """
    for _ in range(_ROUNDS):
        if course.limit.is_over():
            break
        better = _smooth_once(course, q, width)
        if better is not None:
            q = better
        elif width > 1:
            width = max(1, width // 2)
        else:
            break
    return q


def _smooth_once(course: Course, q: Array, width: int) -> Array | None:
    guesses = _means(q, width)
    if course.started:
        guesses[0] = q[0]
    smoothed, found = course.solutions_near(np.arange(len(q)), guesses)
    if (
        not found.all()
        or _length(course, smoothed) >= _length(course, q)
        or np.abs(np.diff(smoothed, axis=0)).max() > course.max_step
    ):
        return None
    return None if course.collide(smoothed).any() or course.edges_collide(smoothed[:-1], smoothed[1:]).any() else smoothed


def _length(course: Course, q: Array) -> float:
    """The smoothing's objective: the costs of the rank and the squared steps."""
    return float(course.costs(q).sum() + course.weight * (np.diff(q, axis=0) ** 2).sum())


def _means(q: Array, width: int) -> Array:
    """The means of each row and up to ``width`` rows on either side, symmetrically."""
    n = len(q)
    sums = np.vstack([np.zeros(q.shape[1]), np.cumsum(q, axis=0)])
    k = np.arange(n)
    half = np.minimum(np.minimum(k, n - 1 - k), width)
    return (sums[k + half + 1] - sums[k - half]) / (2 * half + 1)[:, None]
