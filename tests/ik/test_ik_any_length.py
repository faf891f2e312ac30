"""Arms of one to twenty joints, turning and sliding: whatever they can reach is solved."""

import numpy as np
import pytest

import formulas
from ulna import Robot


def random_arm(n, rng):
    """A serial arm of n joints, one in five of which slides, with limits."""
    rows = np.column_stack(
        [
            rng.uniform(-0.4, 0.4, n),
            rng.uniform(-0.3, 0.3, n),
            rng.choice([0, np.pi / 2, -np.pi / 2, 0.7], n),
            rng.uniform(-1, 1, n),
        ]
    )
    types = ["prismatic" if rng.random() < 0.2 else "revolute" for _ in range(n)]
    limits = [
        (-0.3, 0.5) if kind == "prismatic" else np.sort(rng.uniform(-2.9, 2.9, 2)) + np.array([-0.5, 0.5]) for kind in types
    ]
    return Robot.from_dh(rows, joint_types=types, limits=limits)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20])
def test_every_pose_that_an_arm_can_take_is_found(n):
    rng = np.random.default_rng(n)
    for _ in range(3):
        arm = random_arm(n, rng)
        T = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (100, n)))
        found = arm.inverse_kinematics(T)
        assert np.all(found.success)
        assert ((found.q >= arm.lower) & (found.q <= arm.upper)).all()
        for k in (0, 50, 99):
            np.testing.assert_allclose(formulas.link_pose(arm.description, found.q[k], f"link{n}"), T[k], atol=3e-5)
        one = arm.inverse_kinematics(T[0])
        assert one.success
