"""A controller that is gone in the middle of a motion."""

import threading

import numpy as np
import pytest

import ulna
from simulators import simulator
from ulna.arms import Franka


def test_a_lost_connection_is_named(fr3, tmp_path):
    with simulator("franka-sim", tmp_path) as process, Franka(robot=fr3) as arm:
        goal = arm.q + np.eye(7)[0] * 1.5
        motion = fr3.plan(arm.q, goal, None).trajectory(limits="fr3", velocity=0.5, acceleration=5.0)
        timer = threading.Timer(1.0, process.kill)
        timer.start()
        with pytest.raises(ulna.ArmConnectionError, match="connection was lost while the arm moved: libfranka") as caught:
            arm.run(motion)
        timer.join()
    q, record = caught.value.q, caught.value.record
    assert np.array_equal(q, record.measured[-1])
    assert motion.q[0][0] < q[0] < motion.q[-1][0]
