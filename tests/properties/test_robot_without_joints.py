"""A robot that cannot move has poses and shapes like any other, for one q without entries and for batches of them."""

import numpy as np
import pytest

import robots
import ulna
from ulna.description.robot_description import Body, Description, Joint, JointType, Link

BATCHES = [(), (1,), (3,), (9,), (2, 4), (0,), (2, 0)]
ROCK = Description("rock", (Link("stone", collisions=(Body("stone", ulna.Box((1, 1, 1)), np.eye(4)),)),), ())
STATUE = Description(
    "statue",
    (Link("foot"), Link("head", collisions=(Body("head", ulna.Box((1, 1, 1)), np.eye(4)),))),
    (Joint("neck", JointType.FIXED, "foot", "head", robots.place(1), robots.X),),
)


@pytest.fixture(params=[ROCK, STATUE], ids=lambda description: description.name)
def robot(request):
    return ulna.Robot(request.param)


def test_its_properties_are_empty(robot):
    assert robot.n_dof == 0
    assert robot.joint_names == ()
    assert robot.joint_slices == ()
    assert robot.base == robot.link_names[0]
    assert robot.tip == robot.link_names[-1]
    for limits in (robot.lower, robot.upper, robot.velocity_limits, robot.home):
        assert limits.shape == (0,)


@pytest.mark.parametrize("batch", BATCHES)
def test_its_links_stand_where_the_description_puts_them(robot, batch):
    q = np.zeros((*batch, 0))
    expected = np.eye(4) if not robot.description.joints else robot.description.joints[0].origin
    assert np.array_equal(robot.forward_kinematics(q), np.broadcast_to(expected, (*batch, 4, 4)))
    poses = robot.link_poses(q)
    assert poses.shape == (*batch, len(robot.link_names), 4, 4)
    assert np.array_equal(poses[..., -1, :, :], np.broadcast_to(expected, (*batch, 4, 4)))


@pytest.mark.parametrize("batch", BATCHES)
def test_its_jacobians_have_no_columns(robot, batch):
    for frame in ("base", "link", "spatial"):
        assert robot.jacobian(np.zeros((*batch, 0)), expressed_in=frame).shape == (*batch, 6, 0)
    assert robot.analytical_jacobian(np.zeros((*batch, 0))).shape == (*batch, 6, 0)


@pytest.mark.parametrize("batch", BATCHES)
def test_it_can_be_run_into(robot, batch):
    q, world = np.zeros((*batch, 0)), ulna.World()
    assert np.array_equal(robot.in_collision(q, world), np.zeros(batch, dtype=bool))
    world.add("ball", ulna.Box((0.1, 0.1, 0.1)), robot.collision_poses([])[0])
    assert np.array_equal(robot.in_collision(q, world), np.ones(batch, dtype=bool))
    assert len(robot.check_collision([], world).pairs) == 1
