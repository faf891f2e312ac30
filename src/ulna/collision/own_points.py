"""Finds the points of a cloud that are on a robot, or on what it holds."""

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.clouds import PointCloud
from ulna.collision.near_pairs import find_near_pairs
from ulna.collision.object_tables import make_objects
from ulna.collision.object_tree import compact_order
from ulna.collision.scene_tables import NO_PAIRS, may_touch_of, scene_of
from ulna.kernels.collision.collision_layout import FIRST_BALL, PAIR_BODY, PAIR_OTHER
from ulna.kinematics.positions import refuse_out_of_range

Array = NDArray[np.float64]


def owners_near(
    cloud: PointCloud, T: Array, q: Array, joints: Array, bodies: Bodies, within: float
) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """The links and attached objects, and which of them is nearest to each ball of a cloud: -1 if all are beyond ``within`` [m].

    T: T_base_cloud, shape (4, 4); q: one configuration, shape (n_dof,).
    """
    names = tuple(dict.fromkeys(bodies.owners))
    nearest = np.full(len(cloud.points), -1)
    objects = make_objects({"cloud": cloud}, {"cloud": T}, {})
    scene = scene_of(joints, bodies, NO_PAIRS, objects, may_touch_of(bodies, objects.touch_sets))
    found = find_near_pairs(q[None], scene, 0, within, gradients=False)
    if found is None:
        refuse_out_of_range(q)
        raise AssertionError("an entry of q is out of range")
    pairs = found.pairs[::-1]  # of the bodies near a point the nearest is written last
    place = (
        pairs[:, PAIR_OTHER] - len(bodies.names) - FIRST_BALL
    )  # the cloud is the only object, so its balls are numbered from 0
    owner_of_body = np.array([names.index(owner) for owner in bodies.owners])
    nearest[compact_order(cloud.points)[place]] = owner_of_body[pairs[:, PAIR_BODY]]
    return names, nearest
