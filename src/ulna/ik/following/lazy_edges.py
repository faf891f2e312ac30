"""Makes edges of a layered graph when they are first needed, less those found wrong."""

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.graph import Edges, edges_between
from ulna.ik.following.lifts import Lifts

Array = NDArray[np.float64]


class LazyEdges:
    """The edges between layers of nodes.

    Args:
        lifts: The whole turns.
        nodes: Of each layer, shape (m, n_dof).
        longest: The largest joint step of an edge from each layer to the next.
        weights: That of the squared joint steps.
    """

    def __init__(self, lifts: Lifts, nodes: list[Array], longest: Array, weights: Array) -> None:
        self._lifts, self._nodes, self._longest, self._weights = lifts, nodes, longest, weights
        self._known: dict[int, Edges] = {}
        self.removed: set[tuple[int, int, int]] = set()

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
