"""The curves of a motion, and their limits."""

import numpy as np
import pytest

import ulna
from ulna.viewer.session.planned_motion import JERK, Curve, Planning
from ulna.viewer.session.session import Session

HEIGHT = 0.35


def curves(robot, *, jerk):
    planning = Planning(Session(robot, ulna.World()))
    planning.turn(on=True)
    planning.jerk = JERK if jerk else None
    T = planning.hand_pose
    T[2, 3] = HEIGHT
    planning.send(T)
    planning.frame(0.0)
    return planning.shown.motion, planning.shown.curves


def test_curves_are_those_of_the_motion_and_each_the_change_of_the_one_before(panda):
    motion, found = curves(panda, jerk=True)
    assert list(found) == ["position", "velocity", "acceleration", "jerk"]
    t = found["position"].t
    assert (t[0], t[-1]) == (0.0, motion.duration)
    for before, after in zip(list(found)[:-2], list(found)[1:-1], strict=True):
        change = np.gradient(found[before].values, t, axis=0)
        assert np.allclose(change[1:-1], found[after].values[1:-1], atol=0.02 * np.abs(found[after].values).max())


@pytest.mark.parametrize("jerk", [False, True])
def test_shares_are_within_one_and_reach_it(panda, jerk):
    _, found = curves(panda, jerk=jerk)
    assert ("jerk" in found) == jerk
    assert all(np.abs(curve.shares).max() <= 1 + 1e-6 for curve in found.values())
    assert max(np.abs(curve.shares).max() for name, curve in found.items() if name != "position") > 0.9
    position = found["position"]
    assert np.array_equal(position.low, panda.lower)
    middle = (panda.lower + panda.upper) / 2
    assert np.allclose(position.shares * (panda.upper - middle) + middle, position.values)


def test_a_joint_without_limits_has_no_share():
    ends = np.array([np.inf, 1.0])
    shares = Curve(np.zeros(3), np.full((3, 2), 0.5), -ends, ends).shares
    assert np.isnan(shares[:, 0]).all()
    assert (shares[:, 1] == 0.5).all()
