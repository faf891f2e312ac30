"""Arms whose joint is turned by another one too, as Fanuc's J3 by J2 and a parallelogram's elbow: they keep their closed form."""

import numpy as np
import pytest

import ulna
from ulna.ik.solutions import Proof

WIDE = 9.0  # rad


def joint(name, parent, child, xyz, axis, limits=(-WIDE, WIDE), inside=""):
    limit = f'<limit lower="{limits[0]}" upper="{limits[1]}" velocity="2" effort="1"/>'
    place = f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>{place}{limit}{inside}</joint>'


def arm(ratio=1, offset=0.0, *, axis="0 -1 0", behind=False, limits=(-2.4, 3.5)):
    """An arm with a spherical wrist; with a ratio J3 is turned by J2 too, by a follower in front of it or behind it."""
    links = "".join(f'<link name="{name}"/>' for name in ("base", "l1", "l2", "l3", "l4", "l5", "l6", "x"))
    mimic = f'<mimic joint="J2" multiplier="{ratio}" offset="{offset}"/>'
    first, second = "0 0 0.26", "0 0 0"
    if behind:
        between = joint("J3", "l2", "x", first, "0 -1 0", limits) + joint("follower", "x", "l3", second, axis, inside=mimic)
    else:
        between = joint("follower", "l2", "x", first, axis, inside=mimic) + joint("J3", "x", "l3", second, "0 -1 0", limits)
    if not ratio:
        between, links = joint("J3", "l2", "l3", first, "0 -1 0"), links.replace('<link name="x"/>', "")
    return ulna.load(
        f'<robot name="arm">{links}{joint("J1", "base", "l1", "0 0 0.33", "0 0 1", (-3.1, 3.1))}'
        f"{joint('J2', 'l1', 'l2', '0.075 0 0', '0 1 0', (-1.7, 2.5))}{between}{joint('J4', 'l3', 'l4', '0 0 0.02', '-1 0 0')}"
        f"{joint('J5', 'l4', 'l5', '0.29 0 0', '0 -1 0', (-2.1, 2.1))}{joint('J6', 'l5', 'l6', '0.07 0 0', '-1 0 0')}</robot>"
    )


CASES = [
    {"ratio": 1}, {"ratio": -1}, {"ratio": 2, "offset": 0.3}, {"ratio": 1, "axis": "0 1 0"}, {"ratio": -1, "behind": True},
    {"ratio": 1, "offset": -0.7, "axis": "0 1 0", "behind": True},
]  # fmt: skip


@pytest.fixture(scope="module")
def plain():
    """The same arm without a coupling, and without limits of J3."""
    return arm(0)


@pytest.mark.parametrize("case", CASES)
def test_all_solutions_are_those_of_the_arm_without_a_coupling_that_are_within_the_limits(case, plain):
    coupled, sign = arm(**case), 1 if case.get("axis", "0 -1 0") == "0 -1 0" else -1
    assert coupled.closed_form.family == plain.closed_form.family
    q = coupled.random(200, seed=1)
    T = coupled.forward_kinematics(q)
    ours, theirs = coupled.all_solutions(T), plain.all_solutions(T)
    assert (ours.proof == Proof.COMPLETE).all()
    np.testing.assert_allclose(
        coupled.forward_kinematics(ours.q[ours.valid]), np.repeat(T, ours.valid.sum(axis=1), axis=0), atol=1e-9
    )
    assert (ours.q[ours.valid] >= coupled.lower).all()
    assert (ours.q[ours.valid] <= coupled.upper).all()
    for i in range(len(q)):
        expected = theirs.q[i, theirs.real[i]].copy()
        expected[:, 2] -= sign * (case["ratio"] * expected[:, 1] + case.get("offset", 0.0))
        whole = expected + 2 * np.pi * np.rint((middle_of(coupled) - expected) / (2 * np.pi))
        inside = ((whole >= coupled.lower - 1e-9) & (whole <= coupled.upper + 1e-9)).all(axis=1)
        assert inside.sum() == ours.valid[i].sum(), i
        assert np.abs(np.exp(1j * ours.q[i, ours.valid[i]]) - np.exp(1j * q[i])).max(axis=1).min() < 1e-6


def middle_of(robot):
    """The middle of each joint's range: no range here has room for two whole turns of one angle but those of WIDE."""
    return (robot.lower + robot.upper) / 2


@pytest.mark.parametrize("case", CASES)
def test_inverse_kinematics_finds_the_nearest_of_them_and_proves_what_is_out_of_reach(case):
    robot = arm(**case)
    q = robot.random(300, seed=2)
    T = robot.forward_kinematics(q)
    found = robot.inverse_kinematics(T, q_seed=q)
    assert found.success.all()
    np.testing.assert_allclose(found.q, q, atol=1e-5)
    away = robot.inverse_kinematics(T)
    assert away.success.all()
    np.testing.assert_allclose(robot.forward_kinematics(away.q), T, atol=1e-5)
    far = T[0].copy()
    far[:3, 3] *= 5 / np.linalg.norm(far[:3, 3])
    assert robot.inverse_kinematics(far).status == "unreachable"


def test_a_share_of_another_joint_that_is_no_whole_one_is_solved_by_search():
    robot = arm(0.5)
    assert robot.closed_form is None
    q = robot.random(20, seed=3)
    assert robot.inverse_kinematics(robot.forward_kinematics(q)).success.all()


def test_a_follower_beside_the_axis_has_no_closed_form():
    text = arm(1).to_urdf().replace('xyz="0 0 0.26"', 'xyz="0.001 0 0.26"', 1)
    assert ulna.load(text).closed_form is not None  # both axes moved
    moved = arm(1).to_urdf()
    before = moved.index('name="J3"')
    moved = moved[:before] + moved[before:].replace('xyz="0 0 0"', 'xyz="0.001 0 0"', 1)
    assert ulna.load(moved).closed_form is None
