"""A servo keeps how fast torques change within limits, in every tick and in the stop after it, by another library's torques."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from ulna.errors import InputError

RATE = 1000.0  # a Franka's
ACCELERATION, JERK = [15, 7.5, 10, 12.5, 15, 20, 20], [7500, 3750, 5000, 6250, 7500, 10000, 10000]
PARTS = 10  # of a tick, at which torques are computed


@pytest.fixture(scope="module")
def peer(panda):
    model = pin.buildModelFromXML(panda.to_urdf())
    return model, model.createData()


def moment(q, qd, qdd, jerk, t):
    """The motion a time after another one, at a constant jerk."""
    return q + t * (qd + t * (qdd / 2 + t * jerk / 6)), qd + t * (qdd + t * jerk / 2), qdd + t * jerk


def largest_rate(peer, servo, goals):
    """The greatest rate of a torque while a servo gets goals, one a tick, and in the stop after them."""
    (model, data), h, worst = peer, 1 / servo.rate, 0.0
    for k in range(len(goals) + 5_000):
        q, qd, before = servo.q, servo.qd, servo._now.joints["qdd"].copy()
        command = servo.step(**(goals[k] if k < len(goals) else {}))
        times, jerk = h * np.arange(PARTS + 1) / PARTS, (command.qdd - before) / h
        torques = [pin.rnea(model, data, *moment(q, qd, before, jerk, t)) for t in times]
        worst = max(worst, np.abs(np.diff(torques, axis=0)).max() * PARTS / h)
        if k >= len(goals) and not command.qd.any():
            return worst
    raise AssertionError("the arm does not come to rest")


@pytest.mark.parametrize("options", [{"jerk": JERK}, {"jerk": JERK, "torque": True}, {}], ids=str)
@pytest.mark.parametrize("kind", ["velocity", "twist", "q"])
def test_torques_change_no_faster_than_allowed(panda, peer, options, kind):
    far = panda.home + np.array([1.2, 0.3, 0, 0.4, 0.5, 1, 0])
    goals = {"velocity": [1, 1.5, 0, -1.5, -1, 2, 1.0], "twist": [0.3, 0.8, 0.4, 0, 0, 1.0], "q": far}
    free = panda.servo(acceleration=ACCELERATION, jerk=JERK)
    limited = panda.servo(acceleration=ACCELERATION, torque_rate=RATE, **options)
    rates = []
    for servo in (free, limited):
        servo.start(panda.home)
        rates.append(largest_rate(peer, servo, [{kind: goals[kind]}] * 500))
    assert rates[0] > RATE
    assert 0.05 * RATE < rates[1] <= RATE


@pytest.mark.parametrize("seed", range(3))
def test_goals_that_change_at_random_find_no_way_around(panda, peer, seed):
    rng = np.random.default_rng(seed)
    servo = panda.servo(acceleration=ACCELERATION, jerk=JERK, torque=True, torque_rate=0.5 * RATE, rate=500)
    servo.start(panda.home)
    goals = [
        {"velocity": rng.uniform(-2, 2, 7)}
        if k % 2
        else {"twist": rng.uniform(-1, 1, 6)}
        if k % 3
        else {"q": panda.random(seed=k)}
        for k in range(12)
    ]
    assert largest_rate(peer, servo, [goal for goal in goals for _ in range(rng.integers(5, 80))]) <= 0.5 * RATE


def test_a_goal_is_reached_and_what_limits_is_said(panda):
    servo = panda.servo(acceleration=ACCELERATION, torque_rate=RATE, rate=250)
    servo.start(panda.home)
    far = panda.home + np.array([0.8, 0.2, 0, 0.3, 0.4, 0.6, 0])
    commands = [servo.step(q=far) for _ in range(1500)]
    assert {"limited by torque"} <= {str(command.status) for command in commands}
    np.testing.assert_allclose(servo.q, far, atol=1e-6)


@pytest.mark.parametrize("wrong", [0, -1.0, [1.0, 2.0], np.nan, True, "fast"])
def test_what_is_no_limit_is_refused(panda, wrong):
    with pytest.raises(InputError, match="torque_rate"):
        panda.servo(acceleration=5.0, torque_rate=wrong)


def test_a_robot_without_inertias_is_refused(panda):
    with pytest.raises(ulna.InertiaError):
        panda.with_inertias({"panda_link5": None}).servo(acceleration=5.0, torque_rate=RATE)
