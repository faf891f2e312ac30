"""Holds the solids, hull vertices and tree nodes of worlds in growing arrays. Written rows never change."""

import threading

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import NODE_ROWS
from ulna.kernels.layout import BODY_WIDTH

Array = NDArray[np.float64]


class Arena:
    """Append-only arrays with spare room: writers append rows, and never disturb readers of earlier rows.

    A world and its copies share one arena. A writer holds ``lock``.

    Attributes:
        table: Solids (``kernels.layout``), shape (room, BODY_WIDTH). The first ``n_rows`` rows are written.
        vertices: Vertices of hulls, shape (room, 3). The first ``n_vertices`` rows are written.
        read_only: Read-only views of ``table`` and ``vertices``, for queries.
        nodes: Nodes of trees (``kernels.collision.bvh``), shape (NODE_ROWS room, 8). The first ``n_nodes`` nodes are written.
        names: The object's name, by the object number in a solid's row.
    """

    def __init__(self, n_rows: int = 0, n_vertices: int = 0, n_nodes: int = 0) -> None:
        """Allocate room for these numbers of rows, vertices and nodes."""
        self.lock = threading.Lock()
        self.table, self.vertices = np.empty((n_rows, BODY_WIDTH)), np.empty((n_vertices, 3))
        self.read_only = self.table.view(), self.vertices.view()
        for array in self.read_only:
            array.setflags(write=False)
        self.nodes = _aligned(NODE_ROWS * n_nodes)
        self.names: list[str] = []
        self.n_rows = self.n_vertices = self.n_nodes = 0

    def has_room(self, n_rows: int, n_vertices: int, n_nodes: int) -> bool:
        """Whether this many more rows, vertices and nodes fit."""
        return (
            self.n_rows + n_rows <= len(self.table)
            and self.n_vertices + n_vertices <= len(self.vertices)
            and NODE_ROWS * (self.n_nodes + n_nodes) <= len(self.nodes)
        )

    def add_name(self, name: str) -> int:
        """Append an object's name; its number."""
        self.names.append(name)
        return len(self.names) - 1

    def add_rows(self, rows: Array) -> int:
        """Append solids; the row of the first."""
        first, self.n_rows = self.n_rows, self.n_rows + len(rows)
        self.table[first : self.n_rows] = rows
        return first

    def add_vertices(self, vertices: Array) -> int:
        """Append the vertices of a hull, shape (n, 3); the row of the first."""
        first, self.n_vertices = self.n_vertices, self.n_vertices + len(vertices)
        self.vertices[first : self.n_vertices] = vertices
        return first

    def add_nodes(self, nodes: Array) -> int:
        """Append nodes, shape (n, NODE_ROWS, 8); the number of the first."""
        first, self.n_nodes = self.n_nodes, self.n_nodes + len(nodes)
        self.nodes[NODE_ROWS * first : NODE_ROWS * self.n_nodes] = nodes.reshape(-1, WIDTH)
        return first


def _aligned(n: int) -> Array:
    """n rows of eight numbers, each row aligned to 64 bytes: a load of one row reads one cache line."""
    room = np.empty((n + 1) * WIDTH)
    first = -room.ctypes.data % (WIDTH * room.itemsize) // room.itemsize
    return room[first : first + n * WIDTH].reshape(n, WIDTH)
