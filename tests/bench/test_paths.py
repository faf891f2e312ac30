"""The paths of tracking are followed on every arm: 10,000 poses, no step above the bound, judged without what found them."""

import numpy as np
import pytest

from ulna.bench.arms import NAMES, load_arm, path_positions
from ulna.bench.protocol import PROTOCOLS, STEP_BOUND, pose_errors, within_limits

INSTALLED = [name for name in NAMES if name != "iiwa14"]  # its data package is no dependency of the tests


@pytest.mark.slow
@pytest.mark.parametrize("name", INSTALLED)
def test_the_path_of_tracking_is_followed_from_its_beginning(name):
    robot = load_arm(name)
    known = path_positions(robot, 10_000, seed=1)
    T = robot.forward_kinematics(known)
    path = robot.follow(T, known[0])
    assert path.success, str(path)
    assert within_limits(robot, path.q).all()
    assert PROTOCOLS["reachable"].reached(pose_errors(robot.forward_kinematics(path.q), T)).all()
    assert np.abs(np.diff(path.q, axis=0)).max() <= STEP_BOUND
    assert np.abs(path.q[0] - known[0]).max() <= STEP_BOUND
