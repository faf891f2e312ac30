"""Names the parts of a robot and a world as the kernels take them. Used by every kernel and driver of collision.

An entry takes the parts one by one (``entry(*scene, q)``) and puts them together again: a call with a tuple takes 600 ns
longer than one with its arrays.
"""

from typing import NamedTuple

from numpy.typing import NDArray


class Scene(NamedTuple):
    """A robot and the objects of a world, in flat arrays (columns: ``kernels.layout``).

    Where all shapes are boxes, ``vertices`` and ``points`` are None: such scenes compile without the search for distances of
    convex shapes, in a fraction of the time.
    """

    joints: NDArray
    """The tree of joints, shape (n_joints, TABLE_WIDTH)."""
    bodies: NDArray
    """The collision bodies of the robot, shape (n_bodies, BODY_WIDTH)."""
    vertices: NDArray | None
    """Those of the robot's hulls, shape (m, 3)."""
    pairs: NDArray
    """The bodies that are tested against each other, shape (n_pairs, 2)."""
    objects: NDArray
    """The solids of the world, shape (n_objects, BODY_WIDTH); the first ``n_unindexed`` are tested one by one."""
    points: NDArray | None
    """The vertices of the world's hulls, shape (m, 3), or None."""
    nodes: NDArray
    """The BVH of the other solids (``bvh``), shape (6 n_nodes, 8)."""
    n_unindexed: int
    """How many solids are not in the BVH."""
