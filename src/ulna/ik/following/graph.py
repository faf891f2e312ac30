"""Finds the best chain through layers of solutions by dynamic programming (Bellman 1957).

The cost of a chain is the sum of its nodes' costs and of the squared joint steps of its edges. Edges are listed once, whole turns
aside; a node is searched for every lift (``lifts``) that is within the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.lifts import Lifts
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Key = tuple[int, int, int]  # tells edges apart: the layer, and the nodes at both ends; whole turns make no difference


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges from one layer to the next, in the order of where they end.

    Attributes:
        begin: Nodes of the one layer, shape (m,).
        end: Nodes of the next, shape (m,).
        cost: Shape (m,).
        shift: Of the lifts, the number of one of ``sources``, shape (m,).
        sources: For each shift the lift that each lift comes from, -1 where there is none, shape (k, n_lifts).
    """

    begin: Counts
    end: Counts
    cost: Array
    shift: Counts
    sources: Counts

    def without(self, begin: int, end: int) -> Edges:
        """These edges less one."""
        kept = (self.begin != begin) | (self.end != end)
        return Edges(self.begin[kept], self.end[kept], self.cost[kept], self.shift[kept], self.sources)


def edges_between(lifts: Lifts, a: Array, b: Array, longest: float, weight: float) -> Edges:
    """The edges between nodes a (m, n_dof) and b (k, n_dof) whose largest joint step is at most ``longest``."""
    begin, end, steps, turns = _short_steps(lifts, a, b, longest) if longest < TURN / 2 else _all_steps(lifts, a, b, longest)
    codes, shift = np.unique(lifts.code(turns), return_inverse=True)
    sources = np.array([lifts.sources(int(code)) for code in codes], dtype=np.int64).reshape(len(codes), len(lifts.table))
    return Edges(begin, end, weight * (steps**2).sum(axis=-1), shift, sources)


def _short_steps(lifts: Lifts, a: Array, b: Array, longest: float) -> tuple[Counts, Counts, Array, Counts]:
    """Begin, end, joint steps and turns of each edge, none as long as half a turn: no two nodes are joined twice."""
    steps, turns = lifts.steps(a[None, :], b[:, None])
    end, begin = np.nonzero(np.abs(steps).max(axis=-1, initial=0.0) <= longest)
    return begin, end, steps[end, begin], turns[end, begin]


def _all_steps(lifts: Lifts, a: Array, b: Array, longest: float) -> tuple[Counts, Counts, Array, Counts]:
    """Begin, end, joint steps and turns for steps of any length: nodes are joined once for every shift that is short enough."""
    steps, turns = lifts.steps(a[None, :], b[:, None])
    end, begin = np.nonzero(np.where(lifts.lifted, 0.0, np.abs(steps)).max(axis=-1, initial=0.0) <= longest)
    steps, turns = steps[end, begin], turns[end, begin]
    longest = np.nextafter(TURN, 0.0) if lifts.leaves_out(longest) else longest
    for j in np.flatnonzero(lifts.lifted):
        more = np.arange(-lifts.counts[j], lifts.counts[j] + 1)
        short = np.abs(steps[:, j, None] + TURN * more) <= longest
        row, which = np.nonzero(short & (np.abs(turns[:, j, None] + more) < lifts.counts[j]))
        begin, end, steps, turns = begin[row], end[row], steps[row], turns[row]
        steps[:, j] += TURN * more[which]
        turns[:, j] += more[which]
    return begin, end, steps, turns


@dataclass(frozen=True, eq=False)
class Sweep:
    """The cheapest chains from the first layer as far as there are any.

    Attributes:
        costs: For each layer reached those of the cheapest chain to each lift of each node, infinite where there is none.
        before: For each of them but the first the node and the lift, as one number, that a chain comes from; -1 if from none.
    """

    costs: list[Array]
    before: list[Counts]

    @property
    def n_layers(self) -> int:
        """The number of layers that a chain leads through; 0 if the first has no node within the limits."""
        return len(self.before) + bool(np.isfinite(self.costs[-1]).any())

    def chain(self) -> Counts:
        """The nodes and lifts of the cheapest chain, shape (n_layers, 2)."""
        at = int(np.argmin(self.costs[-1]))
        places = [at]
        for before in reversed(self.before):
            at = int(before.ravel()[at])
            places.append(at)
        return np.array([divmod(at, self.costs[-1].shape[1]) for at in reversed(places)])

    def first(self, n_layers: int) -> Sweep:
        """The sweep of the first layers alone."""
        return Sweep(self.costs[:n_layers], self.before[: n_layers - 1])


def sweep(lifts: Lifts, nodes: Sequence[Array], costs: Sequence[Array], edges: Callable[[int], Edges], begun: Sweep) -> Sweep:
    """Search layers of nodes (m, n_dof), in their first turn, with costs (m,); ``edges(k)`` lead from layer k to the next.

    begun: What is known of the first layers; at least the costs of beginning at each lift of the first.
    """
    known, before = [*begun.costs], [*begun.before]
    for k in range(len(known) - 1, len(nodes) - 1):
        reached, source = _advanced(known[k], edges(k), len(nodes[k + 1]))
        total = np.where(lifts.allowed(nodes[k + 1]), reached + costs[k + 1][:, None], np.inf)
        if not np.isfinite(total).any():
            break
        known.append(total)
        before.append(source)
    return Sweep(known, before)


def _advanced(cost: Array, edges: Edges, n_nodes: int) -> tuple[Array, Counts]:
    """The cheapest sums over edges at each lift of the nodes of the next layer, and where they come from."""
    reached, before = np.full((n_nodes, cost.shape[1]), np.inf), np.full((n_nodes, cost.shape[1]), -1)
    if len(edges.end):
        sums, source = _through(cost, edges)
        first = np.flatnonzero(np.r_[True, np.diff(edges.end) > 0])
        best = np.minimum.reduceat(sums, first, axis=0)
        is_best = sums == np.repeat(best, np.diff(np.r_[first, len(sums)]), axis=0)
        reached[edges.end[first]] = best
        before[edges.end[first]] = np.maximum.reduceat(np.where(is_best, source, -1), first, axis=0)
    return reached, before


def _through(cost: Array, edges: Edges) -> tuple[Array, Counts]:
    """The costs of chains through each edge to each lift, and the node and the lift that they come from, (m, n_lifts)."""
    come_from = edges.sources[edges.shift]
    come = cost[edges.begin[:, None], come_from] + edges.cost[:, None]
    return np.where(come_from >= 0, come, np.inf), edges.begin[:, None] * cost.shape[1] + come_from


class LayerEdges:
    """The edges between all layers of nodes: each layer's are made when they are first needed, less those found wrong.

    Args:
        lifts: The whole turns.
        nodes: Of each layer, shape (m, n_dof).
        longest: The largest joint step of an edge from each layer to the next.
        weights: That of the squared joint steps.
    """

    def __init__(self, lifts: Lifts, nodes: list[Array], longest: Array, weights: Array) -> None:
        self._lifts, self._nodes, self._longest, self._weights = lifts, nodes, longest, weights
        self._known: dict[int, Edges] = {}
        self.removed: set[Key] = set()

    def of(self, k: int) -> Edges:
        """Those from layer k to the next."""
        if k not in self._known:
            nodes, following = self._nodes[k], self._nodes[k + 1]
            edges = edges_between(self._lifts, nodes, following, self._longest[k], self._weights[k])
            for _, begin, end in filter(lambda key: key[0] == k, self.removed):
                edges = edges.without(begin, end)
            self._known[k] = edges
        return self._known[k]

    def renew(self, k: int) -> None:
        """Make the edges to and from layer k again: nodes were added behind its others."""
        self._known.pop(k - 1, None)
        self._known.pop(k, None)

    def remove(self, k: int, begin: int, end: int) -> None:
        """Leave out an edge from layer k."""
        self.removed.add((k, begin, end))
        self._known[k] = self.of(k).without(begin, end)
