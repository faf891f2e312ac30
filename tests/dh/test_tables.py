"""Denavit-Hartenberg tables against the matrices of the textbooks, written out entry by entry."""

from functools import reduce
from math import inf, pi

import numpy as np
import pytest

import formulas
import ulna
from formulas import DH_FORMULAS, craig, dh_poses
from ulna import InputError, Robot, UlnaError
from ulna.description.names.panda import DH_JOINT_TYPES, DH_LINKS, DH_ROWS

RNG = np.random.default_rng(20)
PI = np.pi
# a [m], d [m], alpha [rad], theta_offset [rad]: no entry zero, alphas in every quadrant, a negative a and d
ROWS = [
    (0.1, 0.333, 0.4, 0.3),
    (-0.2, 0.1, -pi / 2, -1.2),
    (0.3, -0.316, 2.2, pi / 2),
    (0.0825, 0.05, -2.8, 3.0),
    (0.07, 0.4, pi, 0.01),
]


TYPES = {
    "all revolute": ["revolute"] * 5,
    "a continuous joint": ["revolute", "continuous", "revolute", "revolute", "revolute"],
    "prismatic rows": ["prismatic", "revolute", "prismatic", "prismatic", "revolute"],
    "fixed rows in every place": ["fixed", "revolute", "fixed", "prismatic", "fixed"],
}


@pytest.mark.parametrize("convention", DH_FORMULAS)
@pytest.mark.parametrize("name", TYPES)
def test_every_frame_is_the_running_product_of_the_written_matrices(convention, name):
    types = TYPES[name]
    robot = Robot.from_dh(ROWS, convention=convention, joint_types=types)
    assert robot.n_dof == sum(kind != "fixed" for kind in types)
    for q in RNG.uniform(-3, 3, (20, robot.n_dof)):
        expected = dh_poses(ROWS, types, q, convention)
        for k, T in enumerate(expected, start=1):
            np.testing.assert_allclose(robot.forward_kinematics(q, link=f"link{k}"), T, rtol=0, atol=1e-13)
        np.testing.assert_array_equal(robot.forward_kinematics(q), robot.forward_kinematics(q, link="link5"))


def test_the_two_conventions_differ_in_one_row():
    q = [0.7]
    modified, standard = (Robot.from_dh(ROWS[:1], convention=name).forward_kinematics(q) for name in DH_FORMULAS)
    assert np.abs(modified - standard).max() > 0.05
    np.testing.assert_allclose(Robot.from_dh(ROWS[:1]).forward_kinematics(q), modified, atol=0)


def test_a_prismatic_row_adds_q_to_d():
    along_z = Robot.from_dh([(0, 0.5, 0, 0)], joint_types=["prismatic"]).forward_kinematics([0.25])
    np.testing.assert_allclose(along_z, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.75], [0, 0, 0, 1]], atol=1e-15)


def test_the_nine_rows_of_the_panda_are_its_urdf_in_all_nine_frames():
    panda, table = ulna.load("panda"), Robot.from_dh(DH_ROWS, joint_types=DH_JOINT_TYPES)
    q = np.vstack([panda.home, np.zeros(7), panda.lower, panda.upper, RNG.uniform(panda.lower, panda.upper, (1000, 7))])
    assert table.n_dof == 7
    for k, link in enumerate(DH_LINKS, start=1):
        T = table.forward_kinematics(q, link=f"link{k}")
        np.testing.assert_allclose(T, panda.forward_kinematics(q, link=link), rtol=0, atol=1e-12, err_msg=link)


def test_the_rows_of_the_panda_are_those_of_the_assignment():
    rows = [(0, 0.333, 0), (0, 0, -PI / 2), (0, 0.316, PI / 2), (0.0825, 0, PI / 2), (-0.0825, 0.384, -PI / 2)]
    rows += [(0, 0, PI / 2), (0.088, 0, PI / 2), (0, 0.107, 0), (0, 0.1034, 0)]
    np.testing.assert_array_equal(DH_ROWS, np.column_stack([rows, np.zeros(9)]))


def test_the_home_of_the_panda_is_where_the_written_product_puts_it():
    panda = ulna.load("panda")
    T = reduce(
        np.matmul, (craig(a, d, alpha, theta) for (a, d, alpha, _), theta in zip(DH_ROWS, [*panda.home, 0, 0], strict=True))
    )
    np.testing.assert_allclose(panda.forward_kinematics(panda.home), T, rtol=0, atol=1e-12)


def test_limits_are_given_for_the_moving_joints_in_their_order():
    types = ["revolute", "fixed", "prismatic", "fixed", "revolute"]
    robot = Robot.from_dh(ROWS, joint_types=types, limits=[(-1, 2), (0, 0.5), (-inf, 3)])
    np.testing.assert_array_equal(robot.lower, [-1, 0, -inf])
    np.testing.assert_array_equal(robot.upper, [2, 0.5, 3])
    assert robot.joint_names == ("joint1", "joint3", "joint5")


def test_every_joint_has_the_number_of_its_row_fixed_ones_too():
    robot = Robot.from_dh(ROWS[:3], joint_types=["revolute", "revolute", "fixed"])
    assert [joint.name for joint in robot.description.joints] == ["joint1", "joint2", "joint3"]


@pytest.mark.parametrize("convention", DH_FORMULAS)
def test_the_ends_of_a_table_stand_before_and_behind_its_rows(convention):
    T_base_0, T_n_tip = (
        formulas.from_rpy((0.1, 0.2, 0.3), (0.4, -0.5, 0.6)),
        formulas.from_rpy((0, -0.2, 0.1), (1.4, 0.5, -2.6)),
    )
    robot = Robot.from_dh(ROWS, convention=convention, T_base_0=T_base_0, T_n_tip=T_n_tip)
    assert (robot.base, robot.tip) == ("base", "tip")
    for q in RNG.uniform(-3, 3, (20, 5)):
        expected = [np.eye(4), *dh_poses(ROWS, ["revolute"] * 5, q, convention)]
        for k, T in enumerate(expected):
            np.testing.assert_allclose(robot.forward_kinematics(q, link=f"link{k}"), T_base_0 @ T, rtol=0, atol=1e-13)
        np.testing.assert_allclose(robot.forward_kinematics(q), T_base_0 @ expected[-1] @ T_n_tip, rtol=0, atol=1e-13)


def test_a_table_without_rows_is_the_way_from_its_base_to_its_tip():
    T_n_tip = formulas.from_rpy((0, -0.2, 0.1), (1.4, 0.5, -2.6))
    robot = Robot.from_dh(np.empty((0, 4)), T_n_tip=T_n_tip)
    assert robot.n_dof == 0
    np.testing.assert_allclose(robot.forward_kinematics([]), T_n_tip, rtol=0, atol=1e-15)


def test_without_limits_there_are_none():
    robot = Robot.from_dh(ROWS)
    assert np.isneginf(robot.lower).all()
    assert np.isposinf(robot.upper).all()


@pytest.mark.parametrize(
    ("rows", "options", "message"),
    [
        ([], {}, r"rows: shape \(0,\), but \(n, 4\) is expected: a, d, alpha, theta_offset"),
        ([(0, 0, 0)], {}, r"rows: shape \(1, 3\), but \(n, 4\) is expected"),
        ([(0, 0, 0, 0), (1, 2)], {}, "rows: not an array of numbers"),
        ([("a", "d", "alpha", "theta")], {}, "rows: not an array of numbers"),
        (None, {}, "rows: "),
        ([(0, np.nan, 0, 0)], {}, "rows: has an entry that is not finite"),
        ([(0, 0, np.inf, 0)], {}, "rows: has an entry that is not finite"),
        (ROWS, {"convention": "craig"}, "convention: 'craig' is not known; there are 'modified', 'standard'"),
        (ROWS, {"convention": "modifed"}, r"convention: 'modifed' is not known; did you mean 'modified'\?"),
        (ROWS, {"convention": None}, "convention: None is not known"),
        (ROWS, {"joint_types": ["revolute"]}, "joint_types: 1 for 5 rows"),
        (ROWS, {"joint_types": ["revolut"] * 5}, r"joint_types: 'revolut' is not known in a DH table; did you mean 'revolute'\?"),
        (ROWS, {"joint_types": ["floating"] * 5}, "joint_types: 'floating' is not known in a DH table"),
        (ROWS, {"joint_types": 5}, "joint_types: "),
        (ROWS, {"T_base_0": np.zeros((4, 4))}, "T_base_0: has a last row"),
        (ROWS, {"T_n_tip": np.eye(3)}, r"T_n_tip: shape \(3, 3\)"),
        (ROWS, {"limits": [(-1, 1)]}, r"limits: shape \(1, 2\); 5 pairs of lower <= upper are expected"),
        (ROWS, {"limits": [(1, -1)] * 5}, "limits: .*lower <= upper"),
        (ROWS, {"limits": [(np.nan, 1)] * 5}, "limits: "),
        (ROWS, {"limits": "wide"}, "limits: "),
    ],
)
def test_a_table_that_cannot_be_is_refused_by_the_name_of_the_argument(rows, options, message):
    with pytest.raises(InputError, match=f"^{message}"):
        Robot.from_dh(rows, **options)


@pytest.mark.parametrize("convention", DH_FORMULAS)
@pytest.mark.parametrize("name", TYPES)
def test_the_urdf_that_a_table_is_written_as_is_the_same_robot_when_read(convention, name):
    limits = [(-3, 2.5)] * sum(kind != "fixed" for kind in TYPES[name])
    table = Robot.from_dh(ROWS, convention=convention, joint_types=TYPES[name], limits=limits)
    read = ulna.load(table.to_urdf())
    assert read.joint_names == table.joint_names
    q = RNG.uniform(-3, 2.5, (20, table.n_dof))
    np.testing.assert_allclose(read.link_poses(q), table.link_poses(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("limits", [(-inf, inf), (-inf, 3), (-3, inf)], ids=["none", "upper only", "lower only"])
def test_limits_that_a_urdf_cannot_say_survive_it_or_are_refused_but_are_never_lost(kind, limits):
    table = Robot.from_dh(ROWS[:1], joint_types=[kind], limits=[limits])
    try:
        text = table.to_urdf()
    except UlnaError:
        return
    read = ulna.load(text)
    for side in ("lower", "upper"):
        kept, written = getattr(read, side)[0], getattr(table, side)[0]
        assert kept == written or (np.isinf(written) and abs(kept) > 1e3)


def test_an_arm_of_a_table_is_checked_by_what_is_attached_to_its_links_and_the_error_says_so():
    arm = ulna.Robot.from_dh([[0.3, 0.4, np.pi / 2, 0], [0.3, 0, 0, 0], [0.2, 0, 0, 0]], convention="standard")
    start, goal = np.zeros(3), np.array([1.0, 0.3, 0.2])
    for ask in (
        lambda: arm.plan(start, goal),
        lambda: arm.in_collision(start),
        lambda: arm.servo(velocity=1.0, acceleration=1.0).start(start),
    ):
        with pytest.raises(ulna.GeometryError, match=r"no collision shapes.*robot\.with_attached\(name, shape, T, link=\)"):
            ask()
    for link, length in (("link2", 0.3), ("link3", 0.2)):
        arm = arm.with_attached(
            f"tube of {link}",
            ulna.Box((length, 0.05, 0.05)),
            ulna.pose(xyz=(-length / 2, 0, 0)),
            link=link,
            touch_links=["tube of link2"] if link == "link3" else [],
        )
    assert arm.plan(start, goal)
    servo = arm.servo(velocity=1.0, acceleration=1.0)
    servo.start(start)
    assert servo.step(velocity=[0.1, 0, 0]).qd[0] > 0.0
    tip = arm.forward_kinematics(goal)[:3, 3]
    world = ulna.World()
    world.add("there", ulna.Sphere(0.02), ulna.pose(xyz=tip))
    assert arm.plan(start, goal, world).status == "goal in collision"
    assert arm.check_collision(goal, world).pairs[0].name_a == "tube of link3"
