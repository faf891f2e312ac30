"""Limits hold for every joint, those that follow others too; and the pose comes before the posture."""

import numpy as np
import pytest

import ulna

MIMIC = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
<joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
<limit lower="{lower}" upper="{upper}"/><mimic joint="j1" multiplier="{ratio}" offset="{offset}"/></joint></robot>"""


@pytest.mark.parametrize(
    ("lower", "upper", "ratio", "offset", "expected"),
    [
        (-1, 1, 2, 0, (-0.5, 0.5)),
        (-1, 3, -2, 0, (-1.5, 0.5)),
        (-1, 1, 1, 0.5, (-1.5, 0.5)),
        (-9, 9, 1, 0, (-2, 2)),
        (0, 2, 0, 1, (-2, 2)),
        (0, 0.5, -1, -2, (-2, 2)),  # leaves one point, -2: a description that contradicts itself
    ],
)
def test_the_limits_of_a_follower_narrow_those_of_its_leader(lower, upper, ratio, offset, expected):
    robot = ulna.load(MIMIC.format(lower=lower, upper=upper, ratio=ratio, offset=offset))
    assert (robot.lower[0], robot.upper[0]) == pytest.approx(expected)


def test_inverse_kinematics_keeps_a_follower_within_its_own_limits():
    robot = ulna.load(MIMIC.format(lower=-1, upper=1, ratio=2, offset=0))
    beyond = robot.inverse_kinematics(robot.forward_kinematics([1.4]))
    assert not beyond.success
    assert abs(2 * beyond.q[0]) <= 1
    assert robot.inverse_kinematics(robot.forward_kinematics([0.4])).success


@pytest.mark.parametrize("seeded", [True, False])
def test_a_posture_costs_no_solution(panda, rng, seeded):
    T = panda.forward_kinematics(rng.uniform(panda.lower, panda.upper, (1000, 7)))
    found = panda.inverse_kinematics(T, panda.home if seeded else None, posture=panda.home)
    assert found.success.all()
    assert ((found.q >= panda.lower) & (found.q <= panda.upper)).all()
    np.testing.assert_allclose(panda.forward_kinematics(found.q), T, rtol=0, atol=3e-5)


def test_two_shapes_of_one_name_get_different_names():
    box = '<collision name="hull"><geometry><box size="1 1 1"/></geometry></collision>'
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="5 0 0"/></joint>'
    text = f'<robot name="r"><link name="a">{box}{box}</link><link name="b">{box}</link>{joint}</robot>'
    assert ulna.load(text).collision_names == ("a/hull (1)", "a/hull (2)", "b/hull")
