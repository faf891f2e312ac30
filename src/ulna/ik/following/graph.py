"""Finds the best chain through layers of solutions by dynamic programming (Bellman 1957).

The cost of a chain is the sum of its nodes' costs and of the squared joint steps of its edges. Edges are listed once, up to whole
turns. A node is searched for every lift (``lifts``) within the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.course import Course
from ulna.ik.following.lifts import Lifts
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
_MAX_PAIRS = 1_000_000  # compared at once
SAME = 1e-6  # rad, or a share of the arm's size for a prismatic joint: nearer configurations count as one
Key = tuple[int, int, int]  # identifies an edge: the layer, and the nodes at both ends; whole turns make no difference


@dataclass(frozen=True, eq=False)
class LayerEdges:
    """Edges from one layer to the next, sorted by their end nodes.

    Attributes:
        begin: Nodes of the first layer, shape (m,).
        end: Nodes of the next layer, shape (m,).
        cost: Shape (m,).
        shift: Shift of the lifts, as an index into ``sources``, shape (m,).
        sources: For each shift, the lift that each lift comes from, or -1, shape (k, n_lifts).
    """

    begin: Counts
    end: Counts
    cost: Array
    shift: Counts
    sources: Counts

    def without(self, begin: int, end: int) -> LayerEdges:
        """The edges without one of them."""
        is_other = (self.begin != begin) | (self.end != end)
        return LayerEdges(self.begin[is_other], self.end[is_other], self.cost[is_other], self.shift[is_other], self.sources)


def edges_between(lifts: Lifts, a: Array, b: Array, longest: float, weight: float) -> LayerEdges:
    """The edges between nodes a (m, n_dof) and b (k, n_dof) whose largest joint step is at most ``longest``."""
    begin, end, steps, turns = _short_steps(lifts, a, b, longest) if longest < TURN / 2 else _all_steps(lifts, a, b, longest)
    codes, shift = np.unique(lifts.code(turns), return_inverse=True)
    sources = np.array([lifts.sources(int(code)) for code in codes], dtype=np.int64).reshape(len(codes), len(lifts.table))
    return LayerEdges(begin, end, weight * (steps**2).sum(axis=-1), shift, sources)


def _short_steps(lifts: Lifts, a: Array, b: Array, longest: float) -> tuple[Counts, Counts, Array, Counts]:
    """Begin, end, joint steps and turns of each edge, below half a turn: two nodes are joined at most once."""
    found = [
        (begin[short], end[short], steps[short], turns[short])
        for begin, end in _near_pairs(lifts, a, b, longest)
        for steps, turns in [lifts.steps(a[begin], b[end])]
        for short in [np.abs(steps).max(axis=-1, initial=0.0) <= longest]
    ]
    begin, end, steps, turns = map(np.concatenate, zip(*found, strict=True))
    return begin, end, steps, turns


def _near_pairs(lifts: Lifts, a: Array, b: Array, longest: float) -> Iterator[tuple[Counts, Counts]]:
    """The pairs (begin, end) that are near each other in the entry with the largest spread.

    All other pairs are farther than ``longest`` apart. Pairs are sorted by end, and come in blocks.
    """
    n, reach = len(a), longest + 1e-9
    j = int(np.argmax(np.ptp(np.vstack([a, b]), axis=0))) if n and b.size else 0
    x, y = (rows[:, j] if rows.size else np.zeros(len(rows)) for rows in (a, b))
    if x.size and (lifts.lifted | lifts.free)[j]:
        x, y = np.mod(x, TURN), np.mod(y, TURN)
        x = np.concatenate([x - TURN, x, x + TURN])
    order = np.argsort(x, kind="stable")
    low, high = np.searchsorted(x[order], y - reach, "left"), np.searchsorted(x[order], y + reach, "right")
    rows = max(1, _MAX_PAIRS // max(1, n))
    for k in range(0, max(1, len(b)), rows):
        each = high[k : k + rows] - low[k : k + rows]
        place = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each) + np.repeat(low[k : k + rows], each)
        pairs = np.repeat(np.arange(k, k + len(each)), each) * max(1, n) + order[place] % max(1, n)
        end, begin = np.divmod(np.unique(pairs), max(1, n))
        yield begin, end


def _all_steps(lifts: Lifts, a: Array, b: Array, longest: float) -> tuple[Counts, Counts, Array, Counts]:
    """Begin, end, joint steps and turns of each edge, of any length.

    Two nodes are joined once for every shift that is short enough.
    """
    steps, turns = lifts.steps(a[None, :], b[:, None])
    end, begin = np.nonzero(np.where(lifts.lifted, 0.0, np.abs(steps)).max(axis=-1, initial=0.0) <= longest)
    steps, turns = steps[end, begin], turns[end, begin]
    longest = np.nextafter(TURN, 0.0) if lifts.omits(longest) else longest
    for j in np.flatnonzero(lifts.lifted):
        turns_added = np.arange(-lifts.counts[j], lifts.counts[j] + 1)
        short = np.abs(steps[:, j, None] + TURN * turns_added) <= longest
        row, index = np.nonzero(short & (np.abs(turns[:, j, None] + turns_added) < lifts.counts[j]))
        begin, end, steps, turns = begin[row], end[row], steps[row], turns[row]
        steps[:, j] += TURN * turns_added[index]
        turns[:, j] += turns_added[index]
    return begin, end, steps, turns


@dataclass(frozen=True, eq=False)
class Sweep:
    """The cheapest chains from the first layer on, up to the last reachable layer.

    Attributes:
        costs: For each reached layer, the costs of the cheapest chain to each lift of each node, infinite without a chain.
        previous: For each reached layer but the first, each chain's previous node and lift, as one number; -1 without a chain.
    """

    costs: list[Array]
    previous: list[Counts]

    @property
    def n_layers(self) -> int:
        """The number of layers that a chain passes through; 0 if the first has no node within the limits."""
        return len(self.previous) + bool(np.isfinite(self.costs[-1]).any())

    def chain(self) -> Counts:
        """The nodes and lifts of the cheapest chain, shape (n_layers, 2)."""
        index = int(np.argmin(self.costs[-1]))
        places = [index]
        for previous in reversed(self.previous):
            index = int(previous.ravel()[index])
            places.append(index)
        return np.array([divmod(index, self.costs[-1].shape[1]) for index in reversed(places)])

    def first_layers(self, n_layers: int) -> Sweep:
        """The sweep of the first layers alone."""
        return Sweep(self.costs[:n_layers], self.previous[: n_layers - 1])


def _advance(cost: Array, edges: LayerEdges, n_nodes: int) -> tuple[Array, Counts]:
    """The minimum sums over edges at each lift of the next layer's nodes, and their sources."""
    costs, previous = np.full((n_nodes, cost.shape[1]), np.inf), np.full((n_nodes, cost.shape[1]), -1)
    if len(edges.end):
        sums, source = _chain_costs(cost, edges)
        first = np.flatnonzero(np.r_[True, np.diff(edges.end) > 0])
        best = np.minimum.reduceat(sums, first, axis=0)
        is_best = sums == np.repeat(best, np.diff(np.r_[first, len(sums)]), axis=0)
        costs[edges.end[first]] = best
        previous[edges.end[first]] = np.maximum.reduceat(np.where(is_best, source, -1), first, axis=0)
    return costs, previous


def _chain_costs(cost: Array, edges: LayerEdges) -> tuple[Array, Counts]:
    """The costs of chains through each edge to each lift, and their previous node and lift, (m, n_lifts)."""
    source_lifts = edges.sources[edges.shift]
    costs = cost[edges.begin[:, None], source_lifts] + edges.cost[:, None]
    return np.where(source_lifts >= 0, costs, np.inf), edges.begin[:, None] * cost.shape[1] + source_lifts


class Graph:
    """The nodes of all layers, the edges between them, and the cheapest known chains.

    Args:
        course: The conditions on a path.
        nodes: The nodes of each layer, in their first turn, shape (m, n_dof).
        costs: The costs of the nodes of each layer, shape (m,).
        longest: The largest joint step of an edge from each layer to the next.
        weights: The weights of the squared joint steps.
    """

    def __init__(self, course: Course, nodes: list[Array], costs: list[Array], longest: Array, weights: Array) -> None:
        self.course, self.nodes, self._costs, self._longest, self._weights = course, nodes, costs, longest, weights
        self._edges: dict[int, LayerEdges] = {}
        self.removed: set[Key] = set()
        self.done = Sweep([costs[0][:, None] + course.begin_costs(nodes[0])], [])

    def edges(self, k: int) -> LayerEdges:
        """The edges from layer k to the next, computed at their first use, without removed edges."""
        if k not in self._edges:
            nodes, next_nodes = self.nodes[k], self.nodes[k + 1]
            edges = edges_between(self.course.lifts, nodes, next_nodes, self._longest[k], self._weights[k])
            for _, begin, end in filter(lambda key: key[0] == k, self.removed):
                edges = edges.without(begin, end)
            self._edges[k] = edges
        return self._edges[k]

    def add(self, k: int, nodes: Array) -> None:
        """Append nodes (m, n_dof) to layer k; the chains to it are searched again."""
        self.nodes[k] = np.vstack([self.nodes[k], nodes])
        self._costs[k] = np.r_[self._costs[k], self.course.costs(nodes)]
        self.done = self.done.first_layers(k)
        self._edges.pop(k - 1, None)
        self._edges.pop(k, None)

    def best(self, wrong_edges: Callable[[Array, Counts], list[Key]], most_rounds: int) -> tuple[Array, Counts, list[Key]]:
        """The cheapest chain without wrong edges: its path (n_layers, n_dof), its nodes and lifts, and remaining wrong edges.

        Edges are tested only on the cheapest chain. Wrong edges are removed, and the layers after the first of them are swept
        again. Wrong edges remain after the last round, or when the time is over.
        """
        for left in reversed(range(most_rounds)):
            self._sweep()
            q, chain = self._path()
            wrong = wrong_edges(q, chain)
            if not wrong or not left or self.course.limit.is_over():
                return q, chain, wrong
            for k, begin, end in wrong:
                self.removed.add((k, begin, end))
                self._edges[k] = self.edges(k).without(begin, end)
            self.done = self.done.first_layers(min(wrong)[0] + 1)
        raise AssertionError("the last round returns")

    def ends(self) -> Array:
        """Every configuration in which a chain ends, shape (m, n_dof)."""
        done, lifts = self.done, self.course.lifts
        if not done.n_layers:
            return np.empty((0, len(self.course.start)))
        node, lift = np.nonzero(np.isfinite(done.costs[-1]))
        last = self.nodes[done.n_layers - 1]
        q = np.array([lifts.apply(last[i], j) for i, j in zip(node.tolist(), lift.tolist(), strict=True)])
        _, first = np.unique(np.rint(q / (SAME * self.course.query.units)), axis=0, return_index=True)
        return q[np.sort(first)]

    def _sweep(self) -> None:
        """Search the remaining layers, up to the last one that a chain reaches."""
        costs, previous = [*self.done.costs], [*self.done.previous]
        for k in range(len(costs) - 1, len(self.nodes) - 1):
            if self.course.limit.is_over():
                break
            nodes = self.nodes[k + 1]
            reached, source = _advance(costs[k], self.edges(k), len(nodes))
            total = np.where(self.course.lifts.allowed(nodes), reached + self._costs[k + 1][:, None], np.inf)
            if not np.isfinite(total).any():
                break
            costs.append(total)
            previous.append(source)
        self.done = Sweep(costs, previous)

    def _path(self) -> tuple[Array, Counts]:
        """The joint path of the cheapest chain, and its nodes and lifts."""
        if not self.done.n_layers:
            return np.empty((0, len(self.course.start))), np.empty((0, 2), dtype=np.int64)
        chain = self.done.chain()
        q = np.array([self.course.lifts.apply(self.nodes[k][node], lift) for k, (node, lift) in enumerate(chain.tolist())])
        return self.course.unwrap_from_start(q), chain
