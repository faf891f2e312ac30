"""The payload that motors bear, against a robot that holds it, and arms that can be worked out in the head."""

import numpy as np
import pytest

import ulna

POINT = (0.05, -0.1, 0.2)


@pytest.fixture
def ruler():
    """Two massless links of one meter in a vertical plane, each with two kilograms in its middle."""
    arm = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
    bar = ulna.Inertia(2.0, (0.5, 0, 0), np.zeros((3, 3)))
    return arm.with_gravity((0, -10, 0)).with_inertias({"link1": bar, "link2": bar})


def holding(robot, mass):
    link = robot.tree.leaves[-1]
    return robot.with_attached("ball", ulna.Sphere(0.0), ulna.pose(POINT), link=link, mass=float(mass))


def test_a_stretched_arm_bears_what_the_lever_says(ruler):
    """The second joint holds 10 Nm of its own, and the first 40 Nm; a kilogram adds 10 Nm, and 20."""
    assert ruler.payload([0, 0], torque=(100, 60), by_joint=True) == pytest.approx([3.0, 5.0])
    assert ruler.payload([0, 0], torque=(100, 60)) == pytest.approx(3.0)
    assert ruler.payload([0, 0], torque=(100, 30)) == pytest.approx(2.0)
    assert ruler.payload([0, 0], torque=(39, 60), by_joint=True) == pytest.approx([0.0, 5.0])
    assert ruler.payload([[0, np.pi], [np.pi / 2, 0]], torque=60) == pytest.approx([5.0, np.inf])  # folded; upright
    assert ruler.payload([0, 0], torque=60, link="link1", com=(0.5, 0, 0)) == pytest.approx(4.0)
    assert ruler.payload([0, 0], torque=60, link="base") == np.inf


def test_with_the_largest_mass_one_joint_is_at_its_limit(robot, motion):
    """And with a little more beyond it: of robots that hold it, at rest and in motion."""
    n, link = robot.n_dof, robot.tree.leaves[-1]
    most = np.abs([robot.inverse_dynamics(*motion), robot.gravity_torque(motion[0])]).max(axis=(0, 1)) + 50
    for rates in ((), motion[1:]):
        masses = robot.payload(motion[0], *rates, com=POINT, link=link, torque=most)
        assert np.isfinite(masses).all()
        assert (masses > 0).all()
        for k in range(len(masses)):
            given = motion[0][k], *(np.zeros((2, n)) if not rates else (rate[k] for rate in rates))
            share = [np.abs(holding(robot, m * masses[k]).inverse_dynamics(*given) / most).max() for m in (1.0, 1.001)]
            assert share[0] == pytest.approx(1.0, abs=1e-9)
            assert share[1] > 1.0


def test_it_is_zero_just_where_the_robot_alone_is_beyond_a_limit(robot):
    q, link = robot.random(200, seed=5), robot.tree.leaves[-1]
    most = np.quantile(np.abs(robot.gravity_torque(q)), 0.8, axis=0) + 1e-3
    masses = robot.payload(q, link=link, torque=most)
    assert ((masses == 0) == (np.abs(robot.gravity_torque(q)) > most).any(axis=-1)).all()
    assert 20 < (masses == 0).sum() < 180


def test_a_row_of_a_batch_has_the_same_bits_alone(panda):
    q = panda.random(21, seed=1).reshape(3, 7, 7)
    masses = panda.payload(q, com=POINT)
    assert masses.shape == (3, 7)
    assert panda.payload(q, com=POINT, by_joint=True).shape == (3, 7, 7)
    assert masses[2, 5] == panda.payload(q[2, 5], com=POINT)


def test_without_gravity_no_joint_feels_it(panda):
    assert panda.payload(panda.home, gravity=(0, 0, 0)) == np.inf
    assert panda.payload(panda.home, qdd=np.ones(7), gravity=(0, 0, 0)) < np.inf


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"com": (0, 0)}, "com: shape"),
        ({"com": (0, 0, np.nan)}, "com"),
        ({"torque": (1, 2)}, "torque"),
        ({"torque": -1.0}, "torque"),
        ({"gravity": (0, 0)}, "gravity"),
        ({"qd": np.zeros(3)}, "qd: shape"),
    ],
)
def test_what_does_not_fit_is_refused(panda, given, words):
    with pytest.raises(ulna.InputError, match=words):
        panda.payload(panda.home, **given)


def test_joints_without_a_limit_and_links_without_an_inertia_are_named(panda, ruler):
    with pytest.raises(ulna.InputError, match="no effort limit above 0 for joint1, joint2"):
        ruler.payload([0, 0])
    with pytest.raises(ulna.InertiaError, match="panda_link3"):
        panda.with_inertias({"panda_link3": None}).payload(panda.home)
    with pytest.raises(ulna.UnknownNameError, match="hand of god"):
        panda.payload(panda.home, link="hand of god")
