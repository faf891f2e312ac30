"""Objects that some links may touch: they are checked against the other bodies of the robot, apart from the rest of the world.

The kernels check every body of a robot against every object. So objects that the same links may touch are a scene of their own,
with a robot that lacks these links; what is asked of the whole is asked of each scene, and the results are combined.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.objects import Objects
from ulna.description.robot_description import frozen

Scene = tuple
"""What kernels take: joints, bodies, their vertices, pairs of bodies; objects, their vertices, BVH, how many are not in it."""
NO_PAIRS = np.zeros((0, 2), dtype=np.int64)
NO_PAIRS.setflags(write=False)  # as those of a robot are: kernels are compiled for one kind


class Part(NamedTuple):
    """A part of what is checked.

    Attributes:
        scene: What the kernels take.
        bodies: The robot's bodies in it.
        object_names: Those of its objects.
    """

    scene: Scene
    bodies: Bodies
    object_names: tuple[str, ...]


def scene_of(joints: NDArray[np.float64], bodies: Bodies, pairs: NDArray[np.int64], objects: Objects) -> Scene:
    """Bodies, those pairs of them, and objects, as the kernels take them."""
    boxes = bodies.only_boxes and objects.only_boxes
    vertices, points = (None, None) if boxes else (bodies.vertices, objects.vertices)
    return joints, bodies.table, vertices, pairs, objects.table, points, objects.nodes, objects.n_unindexed


def shapes_of(scene: Scene) -> tuple:
    """What of a scene says where things are and what they are like."""
    joints, bodies, vertices, _, objects, points, _, _ = scene
    return joints, bodies, vertices, objects, points


def touchable_parts(joints: NDArray[np.float64], bodies: Bodies, objects: Objects) -> tuple[Part, ...]:
    """A part for the objects of each set of links that may touch them: with the other links, and without self-collision."""
    parts = []
    for links, some in objects.touchable:
        rows = [k for k, owner in enumerate(bodies.owners) if owner not in links]
        if rows:
            others = _some_of(bodies, rows)
            parts.append(Part(scene_of(joints, others, NO_PAIRS, some), others, some.names))
    return tuple(parts)


def _some_of(bodies: Bodies, rows: list[int]) -> Bodies:
    """Some of the bodies; their vertices are where they were."""
    names, links, owners = (tuple(each[k] for k in rows) for each in (bodies.names, bodies.links, bodies.owners))
    table = bodies.table[rows]
    return replace(bodies, names=names, links=links, owners=owners, table=frozen(table, table.shape))
