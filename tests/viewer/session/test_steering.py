"""Steering by held buttons, without a page: the hand moves while one is held, touches nothing, and says what limits it."""

import numpy as np
import pytest

import ulna
from ulna.viewer.session import steering
from ulna.viewer.session.session import Session
from ulna.viewer.session.steering import Steering


@pytest.fixture
def clock(monkeypatch):
    """A clock that is moved on by hand."""
    now = [0.0]
    monkeypatch.setattr(steering.time, "monotonic", lambda: now[0])
    return now


def run(steered, clock, seconds, *buttons):
    """Frames while some buttons are held; the configurations of each."""
    went = []
    for _ in range(round(60 * seconds)):
        clock[0] += 1 / 60
        for entry, sign in buttons:
            steered.hold(entry, sign)
        steered.frame(1 / 60)
        went.append(steered._session.q)
    return np.array(went)


@pytest.fixture
def world():
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2.0, 2.0)), ulna.pose((0.6, 0, 0.5)))
    return world


@pytest.fixture
def steered(panda, world):
    steered = Steering(Session(panda, world))
    steered.turn(on=True)
    return steered


@pytest.mark.parametrize(("entry", "sign"), [(1, 1), (1, -1), (2, -1), (5, 1)])
def test_the_hand_moves_as_the_button_says_and_rests_when_it_is_let_go(panda, steered, clock, entry, sign):
    before = panda.forward_kinematics(panda.home)
    went = run(steered, clock, 1.0, (entry, sign))
    after = panda.forward_kinematics(went[-1])
    if entry < 3:
        way = (after - before)[:3, 3]
        assert 0.05 < sign * way[entry] < 0.1
        assert np.abs(np.delete(way, entry)).max() < 2e-3
    else:
        turn = after[:3, :3] @ before[:3, :3].T
        assert 0.15 < sign * np.arctan2(turn[1, 0], turn[0, 0]) < 0.3
    assert steered.command.status == "following"
    assert steered.moving
    still = run(steered, clock, 1.5)
    assert not steered.moving
    np.testing.assert_array_equal(still[-1], still[-2])
    assert steered.sentence == "at rest"


def test_the_way_out_is_a_free_pose_near_by_from_which_it_can_be_steered(panda, steered, clock):
    steered._session.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), panda.forward_kinematics(panda.home))
    run(steered, clock, 0.1)
    steered.go_free()
    q, world = steered._session.q, steered._session.world
    assert panda.signed_distance(q, world, self_collision=False) > 0.009
    assert np.abs(q - panda.home).max() < 0.8
    run(steered, clock, 0.1)
    assert steered.can_move
    assert (run(steered, clock, 0.3, (2, 1))[-1] != q).any()


def test_where_no_free_pose_is_near_it_says_so(panda, steered, clock):
    steered._session.world.add("all of it", ulna.Box((4.0, 4.0, 4.0)))
    run(steered, clock, 0.1)
    steered.go_free()
    assert "no collision-free pose" in steered.sentence
    assert np.array_equal(steered._session.q, panda.home)


def test_the_jerk_is_limited_if_it_is_to_be(panda, clock):
    steered = Steering(Session(panda, ulna.World()), jerk=50.0)
    steered.turn(on=True)
    went = run(steered, clock, 0.5, (1, 1))
    assert steered._servo.limits.jerk.max() <= 50.0
    assert np.abs(went[-1] - panda.home).max() > 1e-3
    run(steered, clock, 1.5)
    assert steered.sentence == "at rest"


def test_a_step_is_as_long_as_it_says_and_then_the_arm_rests(panda, steered, clock):
    before = panda.forward_kinematics(panda.home)
    run(steered, clock, 0.1)
    steered.step(1, -1, 0.02)
    after = panda.forward_kinematics(run(steered, clock, 1.5)[-1])
    np.testing.assert_allclose((after - before)[:3, 3], (0, -0.02, 0), atol=1e-3)
    assert steered.sentence == "at rest"


def test_a_single_joint_is_moved_while_held_and_by_a_step(panda, steered, clock):
    steered.expressed_in = "joints"
    went = run(steered, clock, 0.5, (3, 1))
    assert went[-1][3] - panda.home[3] > 0.05
    np.testing.assert_allclose(np.delete(went[-1] - panda.home, 3), 0.0, atol=1e-9)
    rest = run(steered, clock, 1.0)[-1]
    steered.step(0, 1, np.radians(5))
    np.testing.assert_allclose(run(steered, clock, 1.5)[-1] - rest, np.eye(7)[0] * np.radians(5), atol=2e-3)


def test_axes_of_the_hand(panda, steered, clock):
    steered.expressed_in = "link"
    T = panda.forward_kinematics(panda.home)
    went = run(steered, clock, 0.5, (2, 1))
    way = np.linalg.inv(T) @ panda.forward_kinematics(went[-1])
    assert way[2, 3] > 0.02


def test_axes_of_a_link_that_stands_still(clock):
    """Those of ``base`` of a UR are turned by half a turn about z: its x is minus that of base_link."""
    ur5 = ulna.load("ur5", meshes="hulls")
    bent = np.array([0.0, -1.2, 1.5, -1.8, -1.5, 0.0])
    steered = Steering(Session(ur5, q=bent))
    steered.turn(on=True)
    steered.axes_of = "base"
    before = ur5.forward_kinematics(bent, link=steered._session.link)
    way = (ur5.forward_kinematics(run(steered, clock, 0.5, (0, -1))[-1], link=steered._session.link) - before)[:3, 3]
    assert way @ ur5.forward_kinematics(bent, link="base")[:3, 0] < -0.02
    assert np.abs(way[1:]).max() < 2e-3


def test_before_a_wall_it_says_so_and_touches_nothing(panda, world, steered, clock):
    went = run(steered, clock, 4.0, (0, 1))
    assert steered.sentence.startswith("limited by clearance: ")
    assert "wall" in steered.sentence
    assert panda.signed_distance(went, world, self_collision=False).min() >= 0.009
    assert panda.signed_distance(went[-1], world, self_collision=False) < 0.02


def test_where_it_touches_already_it_refuses_and_says_why_until_it_was_moved(panda, steered, clock):
    steered._session.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), panda.forward_kinematics(panda.home))
    went = run(steered, clock, 0.3, (1, 1))
    assert (went == panda.home).all()
    assert steered.sentence.startswith("panda_link7 (box 12) and crate")
    assert "go to a free pose" in steered.sentence
    assert not steered.can_move
    steered._session.world.remove("crate")
    assert (run(steered, clock, 0.3, (1, 1))[-1] != panda.home).any()


def test_moved_by_other_means_it_goes_on_from_there(panda, steered, clock):
    run(steered, clock, 0.5, (1, 1))
    q = panda.home + 0.1
    steered._session.q = q
    went = run(steered, clock, 1 / 60, (1, -1))
    assert np.abs(went[-1] - q).max() < 0.01


def test_while_it_is_off_nothing_moves(panda, world, clock):
    steered = Steering(Session(panda, world))
    assert (run(steered, clock, 0.2, (1, 1)) == panda.home).all()
    assert steered.sentence == ""
    assert not steered.moving


def test_while_its_kernels_are_compiled_it_waits(panda, world, clock):
    session = Session(panda, world, ask=lambda *_, **__: None)
    steered = Steering(session)
    steered.turn(on=True)
    assert (run(steered, clock, 0.2, (1, 1)) == panda.home).all()
    assert steered.sentence == "waiting for the servo to compile"


def test_an_obstacle_that_comes_into_a_resting_arm_is_named_at_once(panda, steered, clock):
    run(steered, clock, 0.1)
    assert steered.can_move
    steered._session.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), panda.forward_kinematics(panda.home))
    run(steered, clock, 0.1)
    assert "and crate touch" in steered.sentence
    assert not steered.can_move
