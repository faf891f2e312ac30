"""Names the arrays of a search and of the path that it finds, as an entry takes them one by one (``entry(*trees)``)."""

from typing import NamedTuple

from numpy.typing import NDArray


class Trees(NamedTuple):
    """The two trees of a search: tree 0 from the start, tree 1 from the goals. Room for ``capacity`` nodes, a multiple of 8."""

    rows: NDArray
    """The nodes (``space``), shape (2, capacity / 8 * n_dof, 8)."""
    parents: NDArray
    """Of each node, -1 for a root, shape (2, capacity)."""
    radii: NDArray
    """Of each node's domain, shape (2, capacity)."""
    costs: NDArray
    """The cost to reach each node, infinite in unused places, shape (2, capacity / 8, 8); for RRT_CONNECT (2, 0, 8)."""
    refused: NDArray
    """The last edges that were not free, in a ring, shape (MOST_REFUSED, 2, n_dof)."""


class Path(NamedTuple):
    """A path that was found, with room to shorten it."""

    waypoints: NDArray
    """Shape (capacity, n_dof)."""
    known: NDArray
    """1 where the edge from a waypoint was found free as it is, else 0, shape (capacity,)."""
    spreads: NDArray
    """How far beside each edge all is to be free too, shape (n - 1, n_dof), or (0, n_dof)."""
