"""A servo keeps torques within the limits of the motors, in every tick and in the stop after it, by another library's torques."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from ulna.errors import InputError

LIMITS = np.array([12.0, 16.0, 12.0, 26.0, 2.5, 3.5, 1.0])  # less than a Panda has, so that they count
PARTS = 10  # of a tick, at which torques are measured


@pytest.fixture(scope="module")
def peer(panda):
    model = pin.buildModelFromXML(panda.to_urdf())
    return model, model.createData()


def largest_share(peer, servo, goal, n):
    """The greatest torque as a share of its limit, in n ticks and in the stop after them."""
    (model, data), period, worst = peer, 1 / servo.rate, 0.0
    for k in range(n + 5_000):
        q, qd, before = servo.q, servo.qd, servo._now.joints["qdd"].copy()
        command = servo.step(**(goal if k < n else {}))
        jerk = (command.qdd - before) / period if servo.limits.jerk is not None else np.zeros(7)
        start = before if servo.limits.jerk is not None else command.qdd
        for t in period * np.arange(PARTS + 1) / PARTS:
            at = q + t * (qd + t * (start / 2 + t * jerk / 6)), qd + t * (start + t * jerk / 2), start + t * jerk
            worst = max(worst, np.abs(pin.rnea(model, data, *at) / LIMITS).max())
        if k >= n and not command.qd.any():
            break
    return worst


@pytest.mark.parametrize("options", [{"rate": 250}, {"rate": 250, "jerk": 400.0}], ids=str)
@pytest.mark.parametrize("kind", ["velocity", "twist", "q"])
def test_torques_stay_within_their_limits_and_are_used(panda, peer, options, kind):
    far = panda.home + np.array([1.2, 0.3, 0, 0.4, 0.5, 1, 0])
    goals = {"velocity": [1, 1.5, 0, -1.5, -1, 2, 1.0], "twist": [0.3, 0.8, 0.4, 0, 0, 1.0], "q": far}
    goal = {kind: goals[kind]}
    free, limited = (panda.servo(acceleration=12.0, torque=torque, **options) for torque in (None, LIMITS))
    shares = []
    for servo in (free, limited):
        servo.start(panda.home)
        shares.append(largest_share(peer, servo, goal, 125))
    assert shares[0] > 1.0
    assert 0.6 < shares[1] <= 1.0


def test_what_limits_is_said(panda):
    servo = panda.servo(acceleration=12.0, torque=LIMITS, rate=250)
    servo.start(panda.home)
    commands = [servo.step(velocity=[1, 1.5, 0, -1.5, -1, 2, 1.0]) for _ in range(60)]
    limited = [command for command in commands if command.status == "limited by torque"]
    assert limited
    assert {command.limiting.joint for command in limited} <= set(panda.joint_names)


def test_an_arm_that_its_motors_cannot_hold_is_refused(panda):
    held = panda.with_attached("part", ulna.Box((0.05, 0.05, 0.05)), np.eye(4), mass=20.0)
    servo = held.servo(acceleration=5.0, torque=True)
    with pytest.raises(InputError, match=r"the torque of panda_joint\d is beyond its limit, now or until the arm rests"):
        servo.start(panda.home)
    panda.servo(acceleration=5.0, torque=True).start(panda.home)


def test_arguments_are_those_of_a_trajectory(panda):
    with pytest.raises(InputError, match="torque"):
        panda.servo(acceleration=5.0, torque=-1.0)
    with pytest.raises(ulna.InertiaError):
        panda.with_inertias({"panda_link5": None}).servo(acceleration=5.0, torque=True)
