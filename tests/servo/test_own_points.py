"""Beside a cloud that holds the arm's own points, as a camera sees them: a tick measures few of them, and says if not all."""

import numpy as np
import pytest

import ulna

TWIST = [-0.1, 0, 0.05, 0, 0, 0]
ROUNDING = 1e-8  # [m]


def on_the_hand(robot, n):
    T = robot.forward_kinematics(robot.home)
    return T[:3, 3] - 0.05 * T[:3, 2] + 0.03 * np.random.default_rng(0).normal(size=(n, 3))


def in_a_line(robot, n):
    T = robot.forward_kinematics(robot.home)
    return T[:3, 3] - 0.05 * T[:3, 2] + np.linspace(-1, 1, n)[:, None] * [0, 0.3, 0]


def seen(points):
    world = ulna.World()
    world.add("seen", ulna.PointCloud(points, radius=0.002))
    return world


def started(robot, world, q):
    servo = robot.servo(world, acceleration=10.0)
    servo.start(q, lead_out=True)
    return servo


def hull_on_a_slide():
    """A hull that slides along x, and turns."""
    limit = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    slide = f'<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>{limit}</joint>'
    turn = f'<joint name="turn" type="revolute"><parent link="cart"/><child link="hand"/><axis xyz="0 1 1"/>{limit}</joint>'
    links = "".join(f'<link name="{name}"/>' for name in ("base", "cart"))
    links += '<link name="hand"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    robot = ulna.load(f'<robot name="slider">{links}{slide}{turn}</robot>')
    points = np.random.default_rng(1).normal(size=(40, 3))
    return robot.with_attached(
        "hull", ulna.ConvexMesh(0.1 * points / np.linalg.norm(points, axis=1)[:, None]), np.eye(4), link="hand"
    )


@pytest.mark.parametrize("cloud", [on_the_hand, in_a_line])
def test_the_deepest_pair_is_named_and_no_motion_makes_it_deeper(panda, cloud):
    world = seen(cloud(panda, 3000))
    servo, depth = started(panda, world, panda.home), panda.signed_distance(panda.home, world, self_collision=False)
    for _ in range(60):
        command = servo.step(twist=TWIST)
        assert command.status == "in collision"
        if not command.limiting.bounded:
            assert command.limiting.distance == pytest.approx(depth, abs=ROUNDING)
        before, depth = depth, panda.signed_distance(command.q, world, self_collision=False)
        assert depth >= before - ROUNDING


def test_so_it_is_of_a_hull_whose_distances_are_searched():
    robot, rng = hull_on_a_slide(), np.random.default_rng(2)
    points = rng.normal(size=(4000, 3))
    points *= (0.11 * rng.uniform(0.8, 1.2, (4000, 1))) / np.linalg.norm(points, axis=1)[:, None]
    world = seen(points)
    servo, depth = started(robot, world, [0.0, 0.0]), robot.signed_distance([0.0, 0.0], world, self_collision=False)
    assert depth < -1e-3
    for _ in range(20):
        command = servo.step(velocity=[0.3, 0.1])
        if not command.limiting.bounded:
            assert command.limiting.distance == pytest.approx(depth, abs=1e-6)
        before, depth = depth, robot.signed_distance(command.q, world, self_collision=False)
        assert depth >= before - 1e-6


def test_out_of_its_own_points_the_arm_is_led(panda):
    servo = started(panda, seen(on_the_hand(panda, 3000)), panda.home)
    for _ in range(200):
        command = servo.step(twist=TWIST)
    assert not command.limiting.bounded
    moved = panda.forward_kinematics(command.q)[:3, 3] - panda.forward_kinematics(panda.home)[:3, 3]
    assert np.linalg.norm(moved) > 2e-3


def test_a_tick_that_did_not_measure_all_says_so(panda):
    few, many = (started(panda, seen(in_a_line(panda, n)), panda.home).step(twist=TWIST) for n in (100, 20_000))
    assert (few.limiting.bounded, many.limiting.bounded) == (False, True)
    assert str(many).endswith("; too much is near to measure all of it")
    assert "too much" not in str(few)
