"""Poses and twists in a named frame: that of a UR's pendant, a link, a work object."""

import numpy as np
import pytest

import ulna
from ulna import DescriptionError, InputError, UnknownNameError

PI, H = "3.141592653589793", "1.5707963267948966"


def _fixed(name, parent, child, rpy="0 0 0"):
    return f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/><origin rpy="{rpy}"/></joint>'


def _turning(name, parent, child, xyz="0 0 0", rpy="0 0 0"):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
        '<axis xyz="0 0 1"/><limit lower="-6.28" upper="6.28" velocity="2" effort="1"/></joint>'
    )


LINKS = ["base_link", "base", "inertia", "l1", "l2", "l3", "l4", "l5", "l6", "tool0"]
UR = (
    '<robot name="ur">'
    + "".join(f'<link name="{name}"/>' for name in LINKS)
    + _fixed("b", "base_link", "base", f"0 0 {PI}")
    + _fixed("i", "base_link", "inertia", f"0 0 {PI}")
    + _turning("q1", "inertia", "l1", "0 0 0.1625")
    + _turning("q2", "l1", "l2", rpy=f"{H} 0 0")
    + _turning("q3", "l2", "l3", "-0.425 0 0")
    + _turning("q4", "l3", "l4", "-0.3922 0 0.1333")
    + _turning("q5", "l4", "l5", "0 -0.0997 0", f"{H} 0 0")
    + _turning("q6", "l5", "l6", "0 0.0996 0", f"{H} {PI} {PI}")
    + _fixed("t", "l6", "tool0")
    + "</robot>"
)
Q = np.array([0.3, -1.2, 1.1, -1.4, -1.5, 0.2])
WORK = ulna.pose((0.4, -0.1, 0.2), (0.1, -0.3, 0.7))


@pytest.fixture(scope="module")
def ur():
    return ulna.load(UR)


def test_the_pendants_frame_is_the_link_base(ur):
    """The pendant shows tool0 in base, which is turned by 180 degrees in the root of the URDF."""
    shown = ur.forward_kinematics(Q, link="tool0", frame="base")
    plain = ur.forward_kinematics(Q, link="tool0")
    np.testing.assert_allclose(shown[:3, 3], plain[:3, 3] * [-1, -1, 1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", ["base", "base_link", WORK, "tool0", "l3"], ids=str)
def test_a_reading_is_in_any_frame(ur, frame):
    q = np.array([Q, Q + 0.1])
    T_base_frame = ur.forward_kinematics(q, link=frame) if isinstance(frame, str) else frame
    expected = np.linalg.inv(T_base_frame) @ ur.forward_kinematics(q, link="tool0")
    np.testing.assert_allclose(ur.forward_kinematics(q, link="tool0", frame=frame), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", ["base", WORK], ids=["pendant", "work object"])
def test_targets_in_a_frame_are_reached_there(ur, frame):
    T = ur.forward_kinematics(Q, link="tool0", frame=frame)
    found = ur.inverse_kinematics(T, Q, link="tool0", frame=frame)
    np.testing.assert_allclose(found.q, Q, rtol=0, atol=1e-9)
    many = ur.all_solutions(T, link="tool0", frame=frame)
    assert len(many.q[many.valid]) > 1
    reached = ur.forward_kinematics(many.q[many.valid], link="tool0", frame=frame)
    np.testing.assert_allclose(reached, np.broadcast_to(T, reached.shape), rtol=0, atol=1e-8)


def test_a_plan_and_a_followed_path_end_where_the_frame_says(panda):
    goal = ulna.pose((0.4, 0.1, 0.5), (np.pi, 0, 0))
    for given in (np.linalg.inv(WORK) @ goal, {panda.tip: np.linalg.inv(WORK) @ goal}):
        plan = panda.plan(panda.home, given, frame=WORK)
        np.testing.assert_allclose(panda.forward_kinematics(plan.path[-1]), goal, rtol=0, atol=1e-4)
    q = panda.home + np.linspace(0, 0.3, 5)[:, None]
    path = panda.follow(panda.forward_kinematics(q, frame=WORK), frame=WORK)
    np.testing.assert_allclose(panda.forward_kinematics(path.q), panda.forward_kinematics(q), rtol=0, atol=1e-4)


def test_a_twist_along_the_axes_of_a_frame_moves_the_hand_along_them(panda):
    qd = panda.differential_ik(panda.home, [0.1, 0, 0, 0, 0, 0], 0.001, frame=WORK, damping=1e-3)
    moved = (panda.jacobian(panda.home) @ qd)[:3]
    np.testing.assert_allclose(moved, 0.1 * WORK[:3, 0], rtol=0, atol=1e-4)
    with pytest.raises(InputError, match="frame, expressed_in: give one of them"):
        panda.differential_ik(panda.home, np.zeros(6), 0.001, frame=WORK, expressed_in="link")


def test_a_frame_that_moves_or_is_none_is_refused_with_what_to_do(ur):
    T = np.eye(4)
    with pytest.raises(InputError, match=r"^frame: link 'l3' moves in the base 'base_link', but .* must be fixed"):
        ur.inverse_kinematics(T, Q, link="tool0", frame="l3")
    with pytest.raises(UnknownNameError, match="'bas'"):
        ur.all_solutions(T, link="tool0", frame="bas")
    with pytest.raises(InputError, match=r"^frame: .*rigid|^frame: shape"):
        ur.inverse_kinematics(T, Q, link="tool0", frame=np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"^frame: needs a goal of poses"):
        ur.plan(Q, Q + 0.1, frame="base")
    with pytest.raises(InputError, match=r"^out: cannot be combined with frame="):
        ur.forward_kinematics(Q, link="tool0", frame="base", out=np.empty((4, 4)))


def test_a_base_that_is_not_above_the_tip_is_refused_by_both_names_with_what_to_do():
    advice = "load from 'base_link' on, and frame='base' states poses in 'base'"
    with pytest.raises(DescriptionError, match=rf"'tool0' is not below 'base': the chain from it ends at 'base_link'. {advice}"):
        ulna.load(UR, base="base", tip="tool0")
