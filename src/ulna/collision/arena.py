"""Holds the solids, hull vertices and tree nodes of worlds in growing arrays, of which what is written never changes."""

import threading

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import NODE_ROWS
from ulna.kernels.layout import BODY_WIDTH

Array = NDArray[np.float64]


class Arena:
    """Arrays with room behind what is written. A reader of what is written is not disturbed by a writer behind it.

    A world and its copies share one; ``lock`` is held while any of them writes.

    Attributes:
        table: Solids (``kernels.layout``), shape (room, BODY_WIDTH), of which ``n_rows`` are written.
        vertices: Those of hulls, shape (room, 3), of which ``n_vertices`` are written.
        read_only: ``table`` and ``vertices`` as queries get them.
        nodes: Of trees (``kernels.collision.bvh``), shape (NODE_ROWS room, 8), of which ``n_nodes`` are written.
        names: The object that a solid is part of, by the number in its row.
    """

    def __init__(self, n_rows: int = 0, n_vertices: int = 0, n_nodes: int = 0) -> None:
        """With room for so many."""
        self.lock = threading.Lock()
        self.table, self.vertices = np.empty((n_rows, BODY_WIDTH)), np.empty((n_vertices, 3))
        self.read_only = self.table.view(), self.vertices.view()
        for array in self.read_only:
            array.setflags(write=False)
        self.nodes = _aligned(NODE_ROWS * n_nodes)
        self.names: list[str] = []
        self.n_rows = self.n_vertices = self.n_nodes = 0

    def has_room(self, n_rows: int, n_vertices: int, n_nodes: int) -> bool:
        """Whether there is room for so many more."""
        return (
            self.n_rows + n_rows <= len(self.table)
            and self.n_vertices + n_vertices <= len(self.vertices)
            and NODE_ROWS * (self.n_nodes + n_nodes) <= len(self.nodes)
        )

    def add_name(self, name: str) -> int:
        """The number of an object."""
        self.names.append(name)
        return len(self.names) - 1

    def add_rows(self, rows: Array) -> int:
        """Write solids; the row of the first."""
        first, self.n_rows = self.n_rows, self.n_rows + len(rows)
        self.table[first : self.n_rows] = rows
        return first

    def add_vertices(self, vertices: Array) -> int:
        """Write the vertices of a hull, shape (n, 3); the row of the first."""
        first, self.n_vertices = self.n_vertices, self.n_vertices + len(vertices)
        self.vertices[first : self.n_vertices] = vertices
        return first

    def add_nodes(self, nodes: Array) -> int:
        """Write nodes, shape (n, NODE_ROWS, 8); the number of the first."""
        first, self.n_nodes = self.n_nodes, self.n_nodes + len(nodes)
        self.nodes[NODE_ROWS * first : NODE_ROWS * self.n_nodes] = nodes.reshape(-1, WIDTH)
        return first


def _aligned(n: int) -> Array:
    """n rows of eight numbers, each of which begins at a multiple of its 64 bytes, so that a load reads one line of the cache."""
    room = np.empty((n + 1) * WIDTH)
    first = -room.ctypes.data % (WIDTH * room.itemsize) // room.itemsize
    return room[first : first + n * WIDTH].reshape(n, WIDTH)
