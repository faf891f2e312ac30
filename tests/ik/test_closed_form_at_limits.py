"""Branches of closed forms at joint limits where their angles are known poorly: the configuration that made the target judges."""

import numpy as np
import pytest

import robots
from ulna import Robot
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link

H = np.pi / 2
PROVED = ("complete", "complete but for coinciding branches")
ARMS = {
    "UR5": robots.UR5,
    "PUMA": robots.PUMA,
    "IRB6640": [(0.32, 0.78, -H, 0), (1.075, 0, 0, -H), (0.2, 0, -H, 0), (0, 1.1425, H, 0), (0, 0, -H, 0), (0, 0.2, 0, 0)],
}
WRISTS = [1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]


def arm_and_configurations(name, wrist, rng, n=100):
    """An arm with limits at random, and configurations with joints at them, the wrist that near to its singularity."""
    limits = np.sort(rng.uniform(0.3, 3.0, (6, 2)) * [-1, 1], axis=1)
    q = rng.uniform(*limits.T, (n, 6))
    at = rng.random((n, 6)) < 0.3
    q = np.where(at, limits.T[rng.integers(0, 2, (n, 6)), np.arange(6)], q)
    q[:, 4] = wrist * rng.choice([-1, 1], n)
    return Robot.from_dh(ARMS[name], convention="standard", limits=limits.tolist()), q


def assert_valid(robot, q, found, T, near):
    """Each q is one of the valid solutions where all are claimed; and these are within the limits and reach the target."""
    for i in np.flatnonzero(np.isin(found.proof, PROVED)):
        valid = found.q[i][found.valid[i]]
        assert (np.abs(valid - q[i]).max(axis=-1) < near).any(), (i, found.proof[i])
        assert ((valid >= robot.lower) & (valid <= robot.upper)).all()
        assert np.abs(robot.forward_kinematics(valid) - T[i]).max() < 3e-9


@pytest.mark.parametrize("wrist", WRISTS)
@pytest.mark.parametrize("name", ARMS)
def test_the_configuration_of_a_target_is_valid_however_poorly_its_angles_are_known(name, wrist, rng):
    for _ in range(4):
        robot, q = arm_and_configurations(name, wrist, rng)
        T = robot.forward_kinematics(q)
        found = robot.all_solutions(T)
        assert_valid(robot, q, found, T, near=max(1e-6, 1e-11 / wrist))
        nearest = robot.inverse_kinematics(T, q)
        assert nearest.success.all()
        assert np.abs(nearest.q - q).max() < max(1e-3, 1e-9 / wrist)
        for i in range(0, len(T), 25):
            alone = robot.all_solutions(T[i])
            assert np.array_equal(alone.valid[:8], found.valid[i][:8])
            assert np.array_equal(alone.q[:8], found.q[i][:8], equal_nan=True)


@pytest.mark.parametrize("wrist", [1e-6, 1e-7])
def test_an_arm_in_a_larger_robot_is_put_at_its_limits_as_well(wrist, rng):
    robot, q = arm_and_configurations("IRB6640", wrist, rng)
    root = robot.description
    finger = Joint("finger", JointType.PRISMATIC, root.links[-1].name, "finger", np.eye(4), np.eye(3)[0], Limits(0.0, 0.1))
    larger = Robot(Description("larger", (*root.links, Link("finger")), (*root.joints, finger)))
    q = np.column_stack([q, np.full(len(q), larger.home[-1])])
    T = larger.forward_kinematics(q, link=root.links[-1].name)
    found = larger.all_solutions(T, link=root.links[-1].name)
    for i in np.flatnonzero(np.isin(found.proof, PROVED)):
        assert (np.abs(found.q[i][found.valid[i]] - q[i]).max(axis=-1) < 1e-3).any()


@pytest.mark.parametrize("wrist", [1e-5, 1e-6, 1e-7])
def test_five_joints_are_put_at_their_limits_as_well(wrist, rng):
    rows = [(0, 0.4, -H, 0), (0.5, 0, H, 0), (0, 0.5, H, 0), (0, 0, -H, 0), (0, 0.1, 0, 0)]
    limits = np.sort(rng.uniform(0.3, 3.0, (5, 2)) * [-1, 1], axis=1)
    robot = Robot.from_dh(rows, convention="standard", limits=limits.tolist())
    q = rng.uniform(*limits.T, (200, 5))
    q[:, 2], q[:, 3] = limits[2, 1], wrist * rng.choice([-1, 1], 200)
    T = robot.forward_kinematics(q)
    found = robot.all_solutions(T)
    assert np.isin(found.proof, PROVED).sum() > 100
    assert_valid(robot, q, found, T, near=1e-3)


@pytest.mark.parametrize(("wrist", "beyond"), [(0.5, 1e-8), (0.5, 1e-4), (1e-3, 1e-7), (1e-5, 1e-5), (1e-6, 1e-4)])
def test_a_solution_beyond_a_limit_by_more_than_its_angle_is_off_is_not_valid(wrist, beyond, rng):
    rows, limit = ARMS["IRB6640"], 0.9
    wide = Robot.from_dh(rows, convention="standard", limits=[(-3.0, 3.0)] * 6)
    narrow = Robot.from_dh(rows, convention="standard", limits=[(-3.0, 3.0)] * 3 + [(-limit, limit)] + [(-3.0, 3.0)] * 2)
    q = rng.uniform(-2, 2, (200, 6))
    q[:, 3], q[:, 4] = limit + beyond, wrist
    arm = wide.jacobian(q)[:, :3, :3]  # where the arm is nearly singular too, its joints make good what the wrist lacks
    q = q[np.linalg.svd(arm, compute_uv=False)[:, -1] > 0.2]
    T = wide.forward_kinematics(q)
    for robot, is_there in ((wide, True), (narrow, False)):
        found = robot.all_solutions(T)
        near = (np.abs(found.q - q[:, None]).max(axis=-1) < 2 * beyond + 1e-9 / wrist) & found.valid
        proved = np.isin(found.proof, PROVED)
        assert (near.any(axis=1) == is_there)[proved].all()
