"""Holds the tables of a world's objects as they were at one moment."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.collision.solid_numbers import numbers_below, table_of
from ulna.kernels.layout import HALF_SPACE, REACH, SHAPE


@dataclass(eq=False, slots=True)
class Objects:
    """The solids that the objects of a world consist of, as they were at one moment. Nothing of it changes later.

    Attributes:
        table: What the kernels read of each (``kernels.layout``), shape (n, BODY_WIDTH); only rows from ``first`` to before
            ``end``, and those below ``root``, are of these objects. All balls of a cloud have one row.
        vertices: Those of all hulls, shape (m, 3).
        nodes: Of trees (``kernels.collision.bvh``), shape (NODE_ROWS n_nodes, 8).
        root: The root of the BVH, or NO_NODE where no object is in one.
        first: The first row of the solids that are not in the BVH.
        end: The row after the last of them.
        only_boxes: Whether all shapes are boxes.
        touch_sets: The sets of links that may touch objects, by the numbers in the table; the first is empty.
        names: The object that a solid is part of, by the number in its row.
    """

    table: NDArray[np.float64]
    vertices: NDArray[np.float64]
    nodes: NDArray[np.float64]
    root: int
    first: int
    end: int
    only_boxes: bool
    touch_sets: tuple[frozenset[str], ...]
    names: list[str]

    @property
    def numbers(self) -> NDArray[np.int64]:
        """The numbers of all solids (``kernels.collision.collision_layout``)."""
        return np.concatenate([np.arange(self.first, self.end), numbers_below(self.nodes, self.root)])

    @property
    def solids(self) -> NDArray[np.float64]:
        """All solids, each as a row of a table, shape (n, BODY_WIDTH)."""
        return table_of(self.table, self.nodes, self.numbers)

    @property
    def farthest(self) -> float:
        """How far from the base's origin the objects reach, half-spaces aside [m]; 0 if there are none."""
        table = self.solids
        bounded = table[table[:, SHAPE] != HALF_SPACE]
        return float(np.max(np.linalg.norm(bounded[:, 3:12:4], axis=1) + bounded[:, REACH], initial=0.0))
