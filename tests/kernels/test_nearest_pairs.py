"""The pairs that a servo keeps: the nearest of each body, though a cloud beside one body has thousands."""

import numpy as np
import pytest

import ulna
from kernel_modes import compiled
from ulna.collision.entries.contacts import near_of
from ulna.kernels.collision.collision_layout import DISTANCE, PAIR_BODY, PAIR_OTHER
from ulna.kernels.collision.contacts import PAIRS_OF_BODY, find_near_pairs
from ulna.kernels.collision.posed_pair import place_bodies

ROOM, CLEARANCE, WITHIN = 24, 0.01, 0.05


def nearest(scene, q, near, excess):
    place_bodies(scene.joints, scene.bodies, q, near.joint_rows, near.body_rows)
    return find_near_pairs(scene, CLEARANCE, None, WITHIN, near, excess)


@pytest.mark.slow
def test_a_cloud_beside_the_hand_leaves_room_for_a_crate_beside_the_elbow(panda, rng):
    hand, elbow = panda.forward_kinematics(panda.home)[:3, 3], panda.forward_kinematics(panda.home, link="panda_link4")[:3, 3]
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(hand + [0, 0, -0.05] + rng.uniform(-0.02, 0.02, (3000, 3)) * [1, 1, 0.1], 0.001))
    world.add("crate", ulna.Box(extents=(0.02, 0.02, 0.02)), ulna.pose(xyz=elbow + np.array([0, 0, 0.12])))
    scene = panda._checker.scene_of(world, True)
    near, excess = near_of(scene, ROOM, 0), np.full(ROOM + 1, WITHIN)
    with np.errstate(all="ignore"):  # absent children of a node are far away
        count = compiled(nearest)(scene, panda.home, near, excess)
        beside = panda.check_collision(panda.home, world, self_collision=False, max_distance=CLEARANCE + WITHIN).pairs
    n, rows = len(scene.bodies), near.pair_rows[:count]
    bodies = rows[rows[:, PAIR_OTHER] >= n, PAIR_BODY].tolist()
    assert {panda._checker.bodies.names[k] for k in bodies} == {pair.name_a for pair in beside}
    assert {pair.name_b for pair in beside} == {"cloud", "crate"}
    assert max(map(bodies.count, bodies)) == PAIRS_OF_BODY
    of_world = near.contact_rows[:count][rows[:, PAIR_OTHER] >= n, DISTANCE]
    assert min(of_world) == min(pair.signed_distance for pair in beside)
