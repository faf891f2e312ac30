"""Finds the best chain through layers of solutions by dynamic programming (Bellman 1957). Used by ``branches``, ``redundant``.

The cost of a chain is the sum of its nodes' costs and of the squared joint steps of its edges. Edges are listed once, whole turns
aside; a node is searched for every lift (``lifts``) that is within the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.lifts import Lifts

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges from one layer to the next, in the order of where they end.

    Attributes:
        begin: Nodes of the one layer, shape (m,).
        end: Nodes of the next, shape (m,).
        cost: Shape (m,).
        turns: By which the lifts shift, shape (m, n_dof).
    """

    begin: Counts
    end: Counts
    cost: Array
    turns: Counts

    def without(self, pairs: set[tuple[int, int]]) -> Edges:
        """These edges less some pairs of nodes."""
        kept = np.array([pair not in pairs for pair in zip(self.begin.tolist(), self.end.tolist(), strict=True)], dtype=bool)
        return Edges(self.begin[kept], self.end[kept], self.cost[kept], self.turns[kept])


def edges_between(lifts: Lifts, a: Array, b: Array, longest: float, weight: float) -> Edges:
    """The edges between nodes a (m, n_dof) and b (k, n_dof) whose largest joint step is at most ``longest``."""
    steps, turns = lifts.steps(a[None, :], b[:, None])
    end, begin = np.nonzero(np.abs(steps).max(axis=-1, initial=0.0) <= longest)
    return Edges(begin, end, weight * (steps[end, begin] ** 2).sum(axis=-1), turns[end, begin])


@dataclass(frozen=True, eq=False)
class Sweep:
    """The cheapest chains from the first layer as far as there are any.

    Attributes:
        cost: Of the cheapest chain to each lift of each node of the last layer reached, infinite where there is none.
        before: For each layer but the first the node and the lift, as one number, that a chain comes from; -1 if from none.
    """

    cost: Array
    before: list[Counts]

    @property
    def n_layers(self) -> int:
        """The number of layers that a chain leads through; 0 if the first has no node within the limits."""
        return len(self.before) + bool(np.isfinite(self.cost).any())

    def chain(self, place: int | None = None) -> Counts:
        """The nodes and lifts, shape (n_layers, 2), of the cheapest chain, or of that to one node and lift, as one number."""
        at = int(np.argmin(self.cost)) if place is None else place
        places = [at]
        for before in reversed(self.before):
            at = int(before.ravel()[at])
            places.append(at)
        return np.array([divmod(at, self.cost.shape[1]) for at in reversed(places)])


def sweep(lifts: Lifts, nodes: Sequence[Array], costs: Sequence[Array], edges: Callable[[int], Edges], begin: Array) -> Sweep:
    """Search layers of nodes (m, n_dof), in their first turn, with costs (m,); ``edges(k)`` lead from layer k to the next.

    begin: What each lift of each node of the first layer costs besides, infinite where no chain may begin, shape (m, n_lifts).
    """
    cost, before = costs[0][:, None] + begin, []
    for k in range(len(nodes) - 1):
        if not np.isfinite(cost).any():
            break
        reached, source = _advanced(lifts, cost, edges(k), len(nodes[k + 1]))
        total = np.where(lifts.allowed(nodes[k + 1]), reached + costs[k + 1][:, None], np.inf)
        if not np.isfinite(total).any():
            break
        cost = total
        before.append(source)
    return Sweep(cost, before)


def _advanced(lifts: Lifts, cost: Array, edges: Edges, n_nodes: int) -> tuple[Array, Counts]:
    """The cheapest sums over edges at each lift of the nodes of the next layer, and where they come from."""
    reached, before = np.full((n_nodes, cost.shape[1]), np.inf), np.full((n_nodes, cost.shape[1]), -1)
    if len(edges.end):
        sums, source = _through(lifts, cost, edges)
        first = np.flatnonzero(np.r_[True, np.diff(edges.end) > 0])
        best = np.minimum.reduceat(sums, first, axis=0)
        is_best = sums == np.repeat(best, np.diff(np.r_[first, len(sums)]), axis=0)
        reached[edges.end[first]] = best
        before[edges.end[first]] = np.maximum.reduceat(np.where(is_best, source, -1), first, axis=0)
    return reached, before


def _through(lifts: Lifts, cost: Array, edges: Edges) -> tuple[Array, Counts]:
    """The costs of chains through each edge to each lift, and the node and the lift that they come from, (m, n_lifts)."""
    n_lifts = cost.shape[1]
    if n_lifts == 1:
        return cost[edges.begin] + edges.cost[:, None], edges.begin[:, None]
    sums, source = np.full((len(edges.end), n_lifts), np.inf), np.full((len(edges.end), n_lifts), -1)
    shifts, which = np.unique(edges.turns * lifts.lifted, axis=0, return_inverse=True)
    for k, turns in enumerate(shifts):
        rows, come_from = np.flatnonzero(which.ravel() == k), lifts.shifted(turns)
        come = cost[edges.begin[rows]][:, come_from] + edges.cost[rows, None]
        sums[rows] = np.where(come_from >= 0, come, np.inf)
        source[rows] = edges.begin[rows, None] * n_lifts + come_from
    return sums, source
