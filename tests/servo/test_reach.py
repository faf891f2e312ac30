"""A servo at the end of its reach: it slows along the line, comes to rest without swinging, and names what holds it.

``python tests/servo/test_reach.py panda ur5`` tries these arms (all, unless named) in 26 directions at three speeds, and at
poses out of reach, and prints what fails: some hours. The tests are some of these, each known to pass.
"""

import sys
from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog

import servo_reach
from servo_reach import DIRECTIONS, SLOW, farthest, held, judge_pose, judge_twist

BESIDE = 0.02  # [m]
NEAR_ENOUGH = 0.01  # [m] of the farthest place
REST = 3.0  # [s]


@pytest.fixture(scope="module")
def arm():
    """The arms by name, each loaded once."""
    loaded = {}
    return lambda name: loaded.setdefault(name, servo_reach.arm(name))


def twist_of(arm, direction, speed):
    w = np.r_[speed * DIRECTIONS[direction], 0, 0, 0]
    return w, w if len(arm.links) == 1 else dict.fromkeys(arm.links, w)


def assert_rests(arm, direction, speed, seconds):
    w, goal = twist_of(arm, direction, speed)
    run = held(arm, seconds, twist=goal)
    found = judge_twist(arm, run, w)
    assert found.reversals <= 1, found
    assert found.rest <= REST, found
    assert found.off <= BESIDE, found
    assert found.unnamed == 0.0, found
    assert not found.singular, found
    # Neither an end of a joint nor its own body holds it, nor another hand.
    if run.statuses[-1] == "near a singularity" and len(arm.links) == 1:
        way = min(farthest(arm, DIRECTIONS[direction], link) for link in arm.links)
        assert found.along >= min(way, 0.99 * seconds * speed) - NEAR_ENOUGH, (found, way)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "direction", "speed"),
    [
        ("panda", 21, 0.5),
        ("panda", 15, 0.5),
        ("panda", 4, 0.5),
        ("panda", 13, 0.1),
        ("ur5", 21, 0.1),
        ("gen3", 13, 0.5),
        ("two hands", 21, 0.5),
        ("two hands", 2, 0.1),
        ("two hands", 3, 0.5),
    ],
)
def test_an_arm_that_a_twist_stretches_slows_along_its_line_and_rests_there(arm, name, direction, speed):
    assert_rests(arm(name), direction, speed, 8.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "direction", "beyond"),
    [("panda", 15, 0.05), ("panda", 21, 0.05), ("panda", 25, 1.0), ("panda", 15, 1.0), ("gen3", 8, 0.05), ("gen3", 24, 1.0)],
)
def test_a_pose_out_of_reach_is_approached_without_a_swing_at_the_end(arm, name, direction, beyond):
    found = judge_pose(arm(name), direction, beyond, 8.0)
    assert found.reversals <= 1, found
    assert found.rest <= REST, found


def test_with_a_limit_of_jerk_it_rests_too(arm):
    panda = arm("panda")
    w, goal = twist_of(panda, 21, 0.3)
    found = judge_twist(panda, held(panda, 8.0, twist=goal, options={"jerk": 5000.0}), w)
    assert found.reversals <= 1, found
    assert found.rest <= REST, found
    assert found.off <= BESIDE, found


def test_a_twist_away_from_the_end_of_the_reach_leads_back_along_the_line(panda):
    servo, back = panda.servo(acceleration=10.0), [-0.1, 0, 0, 0, 0, 0]
    servo.start(panda.home)
    for _ in range(10_000):
        rest = servo.step(twist=[0.1, 0, 0, 0, 0, 0])
    assert rest.status == "near a singularity"
    assert np.abs(rest.qd).max() < SLOW
    for _ in range(2000):
        command = servo.step(twist=back)
    moved = (panda.forward_kinematics(command.q) - panda.forward_kinematics(rest.q))[:3, 3]
    assert -0.2 < moved[0] < -0.12  # of the 0.2 m that it may go at most
    assert np.abs(moved[1:]).max() < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "direction"), [("panda", 1), ("panda", 10), ("panda", 11), ("panda", 17), ("gen3", 21)])
def test_a_twist_that_is_turned_round_leads_back_from_a_singularity_that_joints_to_spare_led_into(arm, name, direction):
    """At such a rest J leads nowhere along the twist, or to a dead end: the arm goes back the way that it came."""
    robot, start, (link,) = arm(name)
    servo, w = robot.servo(acceleration=5.0, rate=500, link=link), np.r_[0.4 * DIRECTIONS[direction], 0, 0, 0]
    servo.start(start)
    out = [servo.step(twist=w) for _ in range(2500)][-1]
    for _ in range(300):
        rest = servo.step()
    way = int(500 * 3 + 500 * 2.4)
    back = [servo.step(twist=-w) for _ in range(way)]
    places = robot.forward_kinematics(np.array([start, rest.q, *(command.q for command in back)]), link=link)[:, :3, 3]
    along, off = places @ DIRECTIONS[direction], places - places[0]
    off -= (off @ DIRECTIONS[direction])[:, None] * DIRECTIONS[direction]
    assert out.status == "near a singularity"
    assert along[1] - along[2:].min() > 0.4 * (along[1] - along[0])
    assert np.linalg.norm(off, axis=1).max() < BESIDE


def test_what_is_too_fast_for_the_joints_is_slowed_along_its_direction(panda):
    """A linear program finds the greatest share of a twist that the velocities of the joints allow exactly.

    And its own body, to which it comes nearer by a part of what is left in each 50 ms.
    """
    looked = 0
    for k in range(40):
        q = np.clip(panda.random(1, seed=k)[0], panda.lower + 0.4, panda.upper - 0.4)
        J = panda.jacobian(q)
        if np.linalg.svd(J, compute_uv=False)[-1] < 0.15 or panda.in_collision(q):
            continue
        looked += 1
        u = np.random.default_rng(k).normal(size=3)
        twist = np.r_[1.2 * u / np.linalg.norm(u), 0, 0, 0]
        servo = panda.servo(acceleration=1000.0)
        servo.start(q)
        for _ in range(6):
            command = servo.step(twist=twist)
        got = panda.jacobian(command.q) @ command.qd
        along, near = got @ twist / 1.2, panda.distances(command.q, within=0.06)
        best = linprog(
            np.r_[np.zeros(7), -1],
            A_eq=np.c_[panda.jacobian(command.q), -twist],
            b_eq=np.zeros(6),
            A_ub=np.c_[-near.gradient, np.zeros(len(near))],
            b_ub=np.maximum(near.signed_distance - 0.012, 0.0) / 0.051,
            bounds=[*((-v, v) for v in panda.velocity_limits), (0, 1)],
        )
        assert np.linalg.norm(got - along * twist / 1.2) < 0.03 * along, k  # J is that of where the tick begins
        assert along / 1.2 > 0.95 * best.x[-1], k
    assert looked > 8


def test_what_holds_it_is_named_and_it_does_not_slide_along_it(panda):
    """Its own body."""
    servo = panda.servo(acceleration=10.0)
    servo.start(panda.home)
    for _ in range(3000):
        command = servo.step(twist=[-0.5, 0, 0, 0, 0, 0])
    assert command.status == "limited by clearance"
    assert all(name in panda.collision_names for name in command.limiting.pair)
    moved = (panda.forward_kinematics(command.q) - panda.forward_kinematics(panda.home))[:3, 3]
    assert moved[0] < -0.15
    assert np.abs(moved[1:]).max() < 2e-3


def sweep(names):
    """Print what fails, and of how many."""
    failed = []
    for name in names:
        arm = servo_reach.arm(name)
        for direction, speed in product(range(len(DIRECTIONS)), (0.02, 0.1, 0.5)):
            try:
                assert_rests(arm, direction, speed, 20.0)
            except AssertionError as error:
                failed.append((name, direction, speed))
                print(f"{name}, direction {direction}, {speed} m/s: {error}", flush=True)  # noqa: T201
        for direction, beyond in product(range(len(DIRECTIONS)), (0.05, 0.3, 1.0)):
            found = judge_pose(arm, direction, beyond, 15.0)
            if found.reversals > 1 or found.rest > REST:
                failed.append((name, direction, beyond))
                print(f"{name}, direction {direction}, {beyond} m out of reach: {found}", flush=True)  # noqa: T201
    print(f"{len(failed)} of {len(names) * 2 * 3 * len(DIRECTIONS)} failed")  # noqa: T201


if __name__ == "__main__":
    sweep(sys.argv[1:] or servo_reach.ARMS)
