"""A servo keeps the speed of the hand at all times, whatever it is sent to, and in the stop after any tick."""

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

SLOW = ulna.HandLimits(speed=0.25)
PARTS = 5  # of a tick, between which the hand is measured


def goals(robot):
    far = robot.home + np.array([1.2, 0.3, 0, 0.4, 0.5, 1, 0])
    return {
        "twist": {"twist": [0.3, 0.8, 0.2, 0, 0, 1.0]},
        "q": {"q": far},
        "velocity": {"velocity": [1, 1, 0, 0, -1, 0, 1.0]},
        "pose": {"pose": robot.forward_kinematics(far)},
    }


def measured(robot, servo, goal, n, link=None):
    """The greatest speed and angular speed of a link in n ticks and the stop after them, by differences of poses."""
    period, ways = 1 / servo.rate, [servo.q[None]]
    t = period * np.arange(1, PARTS + 1)[:, None] / PARTS
    for k in range(n + 10_000):
        q, qd, qdd = servo.q, servo.qd, servo._now.joints["qdd"].copy()
        command = servo.step(**(goal if k < n else {}))
        jerk = (command.qdd - qdd) / period if servo.limits.jerk is not None else 0.0
        start = qdd if servo.limits.jerk is not None else command.qdd
        ways.append(q + t * (qd + t * (start / 2 + t * jerk / 6)))
        assert np.allclose(ways[-1][-1], command.q, atol=1e-12)
        if k >= n and not command.qd.any():
            break
    T = robot.forward_kinematics(np.concatenate(ways), link=link)
    turns = T[1:, :3, :3] @ np.swapaxes(T[:-1, :3, :3], 1, 2)
    off = np.stack([turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]]) / 2
    sizes = np.linalg.norm(np.diff(T[:, :3, 3], axis=0), axis=1), np.linalg.norm(off, axis=0)
    return [float(size.max()) * PARTS / period for size in sizes]


@pytest.mark.parametrize("options", [{"rate": 250}, {"rate": 250, "jerk": 100.0}, {"rate": 50}], ids=str)
@pytest.mark.parametrize("kind", ["twist", "q", "velocity", "pose"])
def test_the_hand_is_never_faster_and_nearly_as_fast(panda, options, kind):
    for hand, which, limit in ((SLOW, 0, 0.25), (ulna.HandLimits(angular_speed=0.3), 1, 0.3)):
        servo = panda.servo(acceleration=5.0, hand=hand, **options)
        servo.start(panda.home)
        fastest = measured(panda, servo, goals(panda)[kind], int(0.6 * servo.rate))[which]
        assert 0.9 * limit < fastest <= limit


def test_it_arrives_as_without_a_limit(panda):
    goal = panda.home + 0.1
    servo = panda.servo(acceleration=5.0, rate=100, hand=ulna.HandLimits(speed=0.1))
    servo.start(panda.home)
    statuses = {str(servo.step(q=goal).status) for _ in range(400)}
    assert np.allclose(servo.q, goal, atol=1e-6)
    assert "limited by velocity" in statuses


def test_several_links_keep_their_own_speeds(panda):
    hands = [SLOW, ulna.HandLimits(speed=0.05, link="panda_link4")]
    for link, limit in ((None, 0.25), ("panda_link4", 0.05)):
        servo = panda.servo(acceleration=5.0, rate=100, hand=hands)
        servo.start(panda.home)
        assert measured(panda, servo, goals(panda)["velocity"], 80, link)[0] <= limit


def test_a_start_that_is_too_fast_and_an_acceleration_are_refused(panda):
    servo = panda.servo(acceleration=5.0, hand=SLOW)
    with pytest.raises(InputError, match="qd: a hand is faster than its limit, now or until the arm rests"):
        servo.start(panda.home, [1.0, 0, 0, 0, 0, 0, 0])
    servo.start(panda.home, [0.1, 0, 0, 0, 0, 0, 0])
    with pytest.raises(InputError, match="hand: a servo limits the speed and the angular_speed of a hand"):
        panda.servo(acceleration=5.0, hand=ulna.HandLimits(acceleration=1.0))
    with pytest.raises(InputError, match=r"hand: 0\.25; an ulna\.HandLimits"):
        panda.servo(acceleration=5.0, hand=0.25)  # pyright: ignore[reportArgumentType]
