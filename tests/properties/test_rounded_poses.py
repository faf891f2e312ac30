"""Poses that were rounded, by printing or by float32, are accepted to 1e-6; nothing may be read wrongly because of it."""

import numpy as np
import pytest

import ulna
from ulna.description.robot_description import Body, Description, Link


def one_box_robot(T):
    return ulna.Robot(Description("box", (Link("base", collisions=(Body("a", ulna.Box((1, 1, 1)), T),)),), ()))


def random_pose(rng):
    return ulna.pose(rng.uniform(-1, 1, 3), wxyz=rng.normal(size=4))


@pytest.mark.parametrize("rounded", [lambda T: np.round(T, 7), lambda T: T.astype(np.float32)], ids=["7 digits", "float32"])
def test_cubes_of_one_orientation_collide_as_their_distance_says(rng, rounded):
    """Edges are parallel but for the rounding: an axis made of that would separate what overlaps by half a meter."""
    for _ in range(300):
        T, shift = random_pose(rng), rng.uniform(-1.6, 1.6, 3)
        world = ulna.World()
        world.add("b", ulna.Box((1, 1, 1)), rounded(T @ ulna.pose(shift)))
        gap = np.abs(shift).max() - 1
        if abs(gap) > 1e-5:
            assert one_box_robot(T).in_collision([], world) == (gap < 0)


def test_what_the_world_keeps_is_orthonormal(rng):
    world = ulna.World()
    world.add("b", ulna.Box((1, 1, 1)), np.round(random_pose(rng), 7))
    R = world.pose("b")[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-14)


def test_a_rounded_tool_gives_poses_that_inverse_kinematics_takes(panda, rng):
    robot = panda.with_tool(np.round(ulna.pose((0, 0, 0.1), (1, 0.3, 2)), 6))
    T = robot.forward_kinematics(rng.uniform(robot.lower, robot.upper, (50, 7)))
    assert robot.inverse_kinematics(T).success.all()


def test_an_exact_pose_is_kept_to_the_bit(rng):
    T, world = random_pose(rng), ulna.World()
    world.add("b", ulna.Box((1, 1, 1)), T)
    np.testing.assert_array_equal(world.pose("b"), T)
