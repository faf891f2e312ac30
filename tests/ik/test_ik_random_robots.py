"""Robots drawn at random: of all sizes, with long and unlimited slides, turns of +-360 degrees and a mimic joint.

A target is the pose at a random q, so it can be reached. What is not solved may be ``not found``, or found only beyond the
limits; no other reason is true.
"""

from collections import Counter

import numpy as np
import pytest

import ulna

PER_ROBOT, ROBOTS = 40, 5
FARTHEST = 50.0  # sizes of the robot: no target is farther along a slide


def random_robot(rng, size, slide):
    """Two slides and four turns about random axes; the last follows the one before it at half the angle."""
    text = '<link name="l0"/>'
    for k in range(6):
        kind, limit = ("prismatic", slide) if k < 2 else ("revolute", 2 * np.pi)
        origin, axis = (" ".join(map(repr, map(float, v))) for v in (rng.uniform(-0.4, 0.4, 3) * size, rng.normal(size=3)))
        mimic = '<mimic joint="j4" multiplier="0.5" offset="0.2"/>' if k == 5 else ""
        text += (
            f'<link name="l{k + 1}"/><joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="{origin}"/><axis xyz="{axis}"/><limit lower="{-limit!r}" upper="{limit!r}" velocity="1" effort="1"/>'
            f"{mimic}</joint>"
        )
    return ulna.load(f'<robot name="drawn">{text}</robot>')


def solve_own_poses(rng, size, slide):
    """Statuses of the targets of one random robot; what is solved is checked by forward kinematics."""
    robot = random_robot(rng, size, slide)
    far = np.where(np.abs(robot.upper) == slide, FARTHEST * size, np.inf)
    q = rng.uniform(np.maximum(robot.lower, -far), np.minimum(robot.upper, far), (PER_ROBOT, robot.n_dof))
    T = robot.forward_kinematics(q)
    result = robot.inverse_kinematics(T, position_tolerance=1e-5 * size)
    reached = robot.forward_kinematics(result.q[result.success])
    off = np.linalg.norm(reached[:, :3, 3] - T[result.success][:, :3, 3], axis=1)
    assert (off <= 1.001e-5 * size).all()
    assert ((robot.lower <= result.q) & (result.q <= robot.upper))[result.success].all()
    return map(str, result.status)


@pytest.mark.parametrize("slide", ["2 sizes", "200 sizes", "unlimited"])
@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0, 100.0])
def test_reachable_targets_of_a_random_robot_get_a_solution_and_never_a_false_reason(size, slide):
    limit = 1e16 if slide == "unlimited" else float(slide.split()[0]) * size  # descriptions write 1e16 for "no limit"
    rng, statuses = np.random.default_rng([7, int(1e4 * size), len(slide)]), Counter()
    for _ in range(ROBOTS):
        statuses.update(solve_own_poses(rng, size, limit))
    assert set(statuses) <= {"solved", "not found", "joint limits"}, statuses
    assert statuses["solved"] >= 0.97 * PER_ROBOT * ROBOTS, statuses  # two slides that are nearly parallel are hard
