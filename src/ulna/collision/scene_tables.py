"""Puts the bodies of a robot and the objects of a world into the tables that kernels take."""

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.objects import Objects
from ulna.kernels.collision.scene import Scene

NO_PAIRS = np.zeros((0, 2), dtype=np.int64)
NO_PAIRS.setflags(write=False)  # as those of a robot are: kernels are compiled for one kind


def scene_of(
    joints: NDArray[np.float64], bodies: Bodies, pairs: NDArray[np.int64], objects: Objects, may_touch: NDArray[np.bool_]
) -> Scene:
    """Bodies, those pairs of them, and objects, as the kernels take them."""
    boxes = bodies.only_boxes and objects.only_boxes
    vertices, points = (None, None) if boxes else (bodies.vertices, objects.vertices)
    of_world = objects.table, points, objects.nodes, objects.root, objects.first, objects.end
    return Scene(joints, bodies.table, vertices, pairs, *of_world, may_touch)


def may_touch_of(bodies: Bodies, touch_sets: tuple[frozenset[str], ...]) -> NDArray[np.bool_]:
    """Which bodies may touch the objects of which sets, shape (n_bodies, n_sets)."""
    may_touch = np.array([[owner in links for links in touch_sets] for owner in bodies.owners])
    may_touch.setflags(write=False)
    return may_touch
