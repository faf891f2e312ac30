"""Both arms of a real robot, planned together: Baxter, with the convex hulls of its meshes and the pairs of its SRDF."""

import numpy as np
import pytest

import two_arms
from robot_files import load_baxter

HANDS = "left_gripper_base_link", "right_gripper_base_link"


@pytest.fixture(scope="module")
def baxter():
    return load_baxter()


@pytest.fixture(scope="module")
def crossings(baxter):
    """Pairs of free configurations with the hands near each other, between which the arms touch on the straight way."""
    moving = np.unique(np.concatenate([baxter.tree.moving_columns(hand) for hand in HANDS]))
    rng, q = np.random.default_rng(1), np.tile(baxter.home, (3000, 1))
    q[:, moving] = rng.uniform(baxter.lower, baxter.upper, q.shape)[:, moving]
    q = q[~baxter.in_collision(q)]
    left, right = (baxter.forward_kinematics(q, link=hand)[:, :3, 3] for hand in HANDS)
    near = q[np.argsort(np.linalg.norm(left - right, axis=1))[:12]]
    pairs = [(a, b) for a in near for b in near if baxter.edge_in_collision(a, b).in_collision]
    assert len(pairs) > 3
    return pairs[:3]


def touching_sides(robot, q):
    """The sides whose links touch at q: {"left", "right"} if the arms touch each other."""
    owners = [{pair.name_a[:4], pair.name_b[:4]} for pair in robot.check_collision(q).pairs if pair.signed_distance <= 0]
    return {"left", "righ"} in owners


def test_each_arm_is_free_of_the_other_along_the_whole_path(baxter, crossings):
    crossed = 0
    for start, end in crossings:
        straight = start + np.linspace(0, 1, 201)[:, None] * (end - start)
        crossed += any(touching_sides(baxter, q) for q in straight[baxter.in_collision(straight)])
        goal = {hand: baxter.forward_kinematics(end, link=hand) for hand in HANDS}
        plan = baxter.plan(start, goal)
        two_arms.assert_arrives(baxter, plan, goal)
    assert crossed
