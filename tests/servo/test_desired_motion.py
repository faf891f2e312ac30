"""The rate at which a servo approaches a pose: that of the joints which can move towards it."""

import numpy as np
import pytest

from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.servo.desired_motion import approach_rate
from ulna.kernels.servo.servo_records import JointLimits, ServoSettings

SPEED, SMALL = 1.0, 0.05  # [rad/s]; what a joint that is nearly at a singularity moves the hand by [m/rad]


def rate_at(q):
    """Two joints without a coupling, one of which has to go far for what is desired: by 1 m / SMALL, the other by 1 rad."""
    limits, jacobian = JointLimits.records(2), np.zeros((2, 6))
    limits["lower"], limits["upper"], limits["speed"], limits["acceleration"] = -2, 2, SPEED, 10
    jacobian[0, 0], jacobian[1, 1] = SMALL, 1.0
    e, settings = (1.0, 1.0, 0.0, 0.0, 0.0, 0.0), ServoSettings.records()[0]
    settings.lag, settings.damping = 1e-3, 1e-4
    return approach_rate(e, limits, settings, jacobian.ravel(), np.empty(N_SYSTEM), np.empty(12), np.array(q))


def test_a_joint_that_has_to_go_far_makes_the_others_slow_so_that_the_hand_goes_straight():
    assert rate_at([0.0, 0.0]) == pytest.approx(SPEED * (SMALL + 0.02**2 / SMALL), rel=1e-6)
    assert rate_at([-2.0, 0.0]) == rate_at([0.0, 0.0])  # at a limit, and away from it


def test_a_joint_at_its_limit_does_not():
    """It cannot go there. The others crept: a UR5 took eight seconds for what takes two."""
    assert rate_at([2.0, 0.0]) == pytest.approx(SPEED, rel=1e-3)
    assert rate_at([1.995, 0.0]) == rate_at([2.0, 0.0])
    assert rate_at([2.0, 2.0]) == pytest.approx(250.0)  # nothing can move: only the ticks bound the rate
