"""``robot.follow(task=)``: paths of which a part of each pose is free; judged by forward kinematics and by whole poses."""

import numpy as np
import pytest

import robots
import ulna
from ulna import InputError, Robot, Task

TURN = 2 * np.pi
BAND = Task((0.0, 0.0, 0.0, 0.1, 0.1, np.inf))
SIDEWAYS = Task((0.02, 0.0, 0.0, 0.0, 0.0, 0.0))
Q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])


@pytest.fixture(scope="module")
def ur5():
    return Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)


@pytest.fixture(scope="module")
def circle(ur5):
    """A circle of the tool's origin on which the tool's frame makes two turns about its own z: more than the last joint can."""
    T = np.tile(ur5.forward_kinematics(Q), (80, 1, 1))
    angle = np.linspace(0.0, TURN, len(T))
    T[:, 0, 3] += 0.08 * np.cos(angle) - 0.08
    T[:, 1, 3] += 0.08 * np.sin(angle)
    for pose, each in zip(T, 2 * angle, strict=True):
        pose[:3, :3] = pose[:3, :3] @ ulna.pose(rpy=(0, 0, each))[:3, :3]
    return T


def errors(robot, path, T):
    """From the poses to the hand, in the axes of each pose: displacements, and the direction of its z, shape (n, 3) each."""
    R, hand = T[:, :3, :3].swapaxes(1, 2), robot.forward_kinematics(path.q)
    return (R @ (hand - T)[:, :3, 3:])[..., 0], (R @ hand[:, :3, 2:3])[..., 0]


def assert_steps(robot, path, max_step):
    every = path.q if path.q_start is None else np.vstack([path.q_start, path.q])
    assert path.success, str(path)
    assert np.abs(np.diff(every, axis=0)).max() <= max_step
    assert ((path.q >= robot.lower) & (path.q <= robot.upper)).all()


def test_a_free_turn_about_the_tool_leads_where_whole_poses_do_not(ur5, circle):
    assert not ur5.follow(circle, Q, max_step=0.2)
    path = ur5.follow(circle, Q, max_step=0.2, task="pointing")
    assert_steps(ur5, path, 0.2)
    moved, z = errors(ur5, path, circle)
    assert np.abs(moved).max() < 3e-5
    assert np.abs(z - [0, 0, 1]).max() < 3e-5
    assert path.proof == "searched"


def test_within_a_band_the_way_is_shorter(ur5, circle):
    pointing, band = (ur5.follow(circle, Q, max_step=0.2, task=task) for task in ("pointing", BAND))
    assert_steps(ur5, band, 0.2)
    moved, z = errors(ur5, band, circle)
    assert np.abs(moved).max() < 3e-5
    tilt = np.arccos(np.clip(z[:, 2], -1, 1))
    assert 0.01 < tilt.max() <= np.hypot(0.1, 0.1) + 1e-4
    assert (band.steps**2).sum() < (pointing.steps**2).sum()


def test_a_band_of_positions_is_kept(ur5, circle):
    straight = circle.copy()
    straight[:, :3, :3] = circle[0, :3, :3]
    path = ur5.follow(straight, Q, task=SIDEWAYS)
    assert_steps(ur5, path, 0.1)
    moved, z = errors(ur5, path, straight)
    assert 1e-3 < np.abs(moved[:, 0]).max() <= 0.02 + 3e-5
    assert np.abs(moved[:, 1:]).max() < 3e-5
    assert np.abs(z - [0, 0, 1]).max() < 3e-5
    assert (path.steps**2).sum() < (ur5.follow(straight, Q).steps ** 2).sum()


def test_seven_joints_have_a_turn_free_besides(panda):
    T = np.tile(panda.forward_kinematics(panda.home), (60, 1, 1))
    T[:, 1, 3] = np.linspace(-0.3, 0.4, 60)
    whole, free = panda.follow(T), panda.follow(T, task="pointing")
    assert_steps(panda, free, 0.1)
    _, z = errors(panda, free, T)
    assert np.abs(z - [0, 0, 1]).max() < 3e-5
    assert (free.steps**2).sum() <= (whole.steps**2).sum()


def test_five_joints_draw_a_line_that_they_can_point_along():
    arm = Robot.from_dh(robots.UR5[:5], convention="standard", limits=[(-np.pi, np.pi)] * 5)
    q = Q[:5] + np.linspace(0, 0.6, 40)[:, None] * [1, -0.5, 0.4, 0.3, 0.8]
    T = arm.forward_kinematics(q)
    for pose, angle in zip(T, np.linspace(0, 3, len(T)), strict=True):
        pose[:3, :3] = pose[:3, :3] @ ulna.pose(rpy=(0, 0, angle))[:3, :3]  # which five joints cannot
    assert not arm.follow(T, q[0])
    path = arm.follow(T, q[0], task="pointing")
    assert_steps(arm, path, 0.1)
    moved, z = errors(arm, path, T)
    assert np.abs(moved).max() < 3e-5
    assert np.abs(z - [0, 0, 1]).max() < 3e-5


def test_the_tool_turns_away_from_what_is_in_its_way(panda):
    """Beside a post the hand fits past with some of its turns alone, and not with that of the poses."""
    T = np.tile(panda.forward_kinematics(panda.home), (40, 1, 1))
    T[:, 1, 3] = np.linspace(-0.2, 0.2, 40)
    world = ulna.World()
    world.add("post", ulna.Cylinder(0.02, 0.5), ulna.pose((T[0, 0, 3] + 0.08, 0.0, T[0, 2, 3] + 0.15)))
    assert panda.follow(T, world=world).status == "in collision"
    path, blind = (panda.follow(T, task="pointing", world=around) for around in (world, None))
    assert_steps(panda, path, 0.1)
    hits = [panda.edge_in_collision(q[:-1], q[1:], world).in_collision.any() for q in (path.q, blind.q)]
    assert hits == [False, True]


@pytest.mark.slow
def test_where_none_leads_on_the_reason_is_that_of_the_task(ur5, circle):
    far = circle.copy()
    far[40:, 0, 3] += np.linspace(0, 1.5, 40)
    path = ur5.follow(far, Q, max_step=0.3, task="pointing")
    assert not path
    assert path.ends_at > 40
    assert path.status in {"unreachable", "no continuous branch", "joint limits"}
    assert path.status == "unreachable" or ur5.inverse_kinematics(far[path.ends_at], task="pointing")


def test_a_task_that_is_none_is_refused(ur5, circle):
    with pytest.raises(InputError, match="task"):
        ur5.follow(circle, task="pointin")
