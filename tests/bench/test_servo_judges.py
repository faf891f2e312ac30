"""The benchmark of servos: its judges find what is put in their way, and its goals and paths are what they are called."""

import numpy as np
import pytest
from benchmarks import servo, servo_scenes
from benchmarks.servo_judges import chatter, contacts, curve, off_path, overlaps, shares_of_limits

import ulna


@pytest.mark.parametrize("thick", [0.02, 0.002])
def test_a_contact_between_two_ticks_is_found(panda, thick):
    """The hand goes from one side of a plate to the other within one tick, and is free before and after it."""
    q = np.tile(panda.home, (4, 1))
    q[:2, 0], q[2:, 0] = -0.6, 0.6
    world = ulna.World()
    world.add("plate", ulna.Box((0.1, thick, 0.3)), ulna.pose(panda.forward_kinematics(panda.home)[:3, 3]))
    fine = curve(q)
    assert not panda.in_collision(q, world).any()
    touched, depth = contacts(panda, world, fine)
    assert touched == overlaps(panda, world, fine) == 1
    assert 0.0 < depth < 0.2
    assert contacts(panda, ulna.World(), fine) == (0, 0.0)


def test_the_curve_is_that_of_constant_acceleration():
    q, qd = np.array([[0.0], [0.001]]), np.array([[1.0], [1.0]])
    np.testing.assert_allclose(curve(q)[0], curve(q, qd)[0])
    stops = curve(np.array([[0.0], [0.0005]]), np.array([[1.0], [0.0]]))[0, :, 0]
    t = np.arange(16) / 16
    np.testing.assert_allclose(stops, 1e-3 * (t - t * t / 2))


def test_limits_are_shares_of_what_was_commanded(panda):
    q = np.tile(panda.home, (4, 1))
    q[2:, 0] += 2e-3  # 2 rad/s for one tick, from rest
    found = shares_of_limits(panda, q, 10.0)
    assert found["velocity"] == pytest.approx(2.0 / panda.velocity_limits[0])
    assert found["acceleration"] == pytest.approx(200.0)
    assert found["beyond_rad"] == 0.0
    assert found["violations"] == 2  # it stops as suddenly
    q[3, 1] = panda.upper[1] + 0.25
    assert shares_of_limits(panda, q, 10.0)["beyond_rad"] == pytest.approx(0.25)


@pytest.mark.parametrize(("hertz", "expected"), [(5.0, 0.0), (200.0, 1.0)])
def test_chatter_is_what_is_quick(hertz, expected):
    q = np.sin(2 * np.pi * hertz * np.arange(4000) / 1000)[:, None]
    assert chatter(q) == pytest.approx(expected, abs=1e-6)


def test_a_point_beside_a_path_is_as_far_from_it_as_it_is_beside():
    path = np.outer(np.arange(300), [1e-3, 0.0, 0.0])
    np.testing.assert_allclose(off_path(path + np.array([0.02, 0.003, 0.004]), path)[:250], 0.005, atol=1e-12)


def test_hostile_goals_are_of_every_kind_and_of_their_seed(panda):
    goals = list(servo_scenes.hostile(panda, 20_000, 3))
    assert len(goals) == 20_000
    assert {key for goal in goals for key in goal} == {"pose", "q", "velocity", "twist", "expressed_in"}
    assert {} in goals
    again = list(servo_scenes.hostile(panda, 20_000, 3))
    assert all(str(a) == str(b) for a, b in zip(goals[::97], again[::97], strict=True))
    assert all(set(goal) == {"pose"} for goal in servo_scenes.hostile(panda, 2000, 3, servo_scenes.POSES))


def test_an_arm_starts_far_from_a_scene(panda):
    world = servo_scenes.scene(panda, 10, 2)
    assert len(world.names) == 10
    assert panda.signed_distance(servo_scenes.start_of(panda, world), world) > servo_scenes.SPARE


@pytest.mark.slow
def test_a_servo_is_found_safe_and_a_follower_that_knows_no_world_is_not(panda, monkeypatch):
    monkeypatch.setattr(servo, "arm", lambda _: panda)
    row = servo.safety_row("panda", "shapes", 1, 1000)
    assert (row["contacts_Coal"], row["contacts_Ulna"], row["violations"], row["dead_ends"]) == (0, 0, 0, 0)
    assert max(row["velocity"], row["acceleration"]) <= 1.0

    class Blind(servo.OwnFollower):
        def __init__(self, robot, _world, q, acceleration):
            super().__init__(robot, None, q, acceleration)

    assert servo.followed(panda, Blind, "hostile", 0, 5000)["contacts_Coal"] > 0
