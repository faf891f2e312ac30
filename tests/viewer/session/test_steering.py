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


def test_the_jerk_is_limited_if_it_is_to_be(panda, clock):
    steered = Steering(Session(panda, ulna.World()), jerk=50.0)
    steered.turn(on=True)
    went = run(steered, clock, 0.5, (1, 1))
    assert steered._servo.limits.jerk.max() <= 50.0
    assert np.abs(went[-1] - panda.home).max() > 1e-3
    run(steered, clock, 1.5)
    assert steered.sentence == "at rest"


def test_axes_of_the_hand(panda, steered, clock):
    steered.expressed_in = "link"
    T = panda.forward_kinematics(panda.home)
    went = run(steered, clock, 0.5, (2, 1))
    way = np.linalg.inv(T) @ panda.forward_kinematics(went[-1])
    assert way[2, 3] > 0.02


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
    assert "not certainly free" in steered.sentence
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
    assert steered.sentence == "steering waits for the compiler"
