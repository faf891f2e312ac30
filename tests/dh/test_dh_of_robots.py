"""``robot.dh``: published tables, and the cases in which a table is not unique."""

import pickle
from math import pi

import numpy as np
import pytest

import formulas
import ulna
from assertions import assert_close
from matrix import matrix
from robots import UR5, every_joint, of_chain, unit
from ulna import DHTable, InputError, Robot
from ulna.description.names.panda import DH_ROWS
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link, Mimic
from ulna.kernels.layout import LARGEST

RNG = np.random.default_rng(31)
CONVENTIONS = ("modified", "standard")

# Corke and Armstrong-Helouvry, A search for consensus among model parameters reported for the PUMA 560 robot (1994), standard.
PUMA_A, PUMA_D, PUMA_ALPHA = [0, 0.4318, 0.0203, 0, 0, 0], [0, 0, 0.15005, 0.4318, 0, 0], [pi / 2, 0, -pi / 2, pi / 2, -pi / 2, 0]
# Spong, Hutchinson and Vidyasagar (2006), example 3.5: the Stanford arm (standard; its third joint slides); d2 and d6 chosen.
STANFORD = [(0, 0, -pi / 2, 0), (0, 0.154, pi / 2, 0), (0, 0, 0, 0), (0, 0, -pi / 2, 0), (0, 0, pi / 2, 0), (0, 0.263, 0, 0)]
STANFORD_TYPES = ["revolute", "revolute", "prismatic", "revolute", "revolute", "revolute"]


def by_the_textbook(table, positions):
    """T_base_tip at positions of the rows' joints."""
    T = formulas.dh_poses(table.rows, table.joint_types, positions, table.convention)
    return table.T_base_0 @ (T[-1] if T else np.eye(4)) @ table.T_n_tip


def assert_is_the_robot(table, description, atol=1e-12, n=20):
    """The table, multiplied out by the formulas of the textbooks, against the slow twin."""
    joints = formulas.joints_from_root(description)
    for _ in range(n):
        q = RNG.uniform(-1, 1, sum(formulas.N_POSITIONS[joint.type] for joint in joints if joint.mimic is None))
        positions = formulas.joint_positions(description, q)
        T = by_the_textbook(table, [positions[name][0] for name in table.joint_names])
        assert_close(T, formulas.link_pose(description, q, table.tip), atol=atol)


def test_the_table_of_the_panda_is_the_assignments_with_the_fixed_rows_in_the_tip(panda):
    table = panda.dh()
    assert_close(table.rows, DH_ROWS[:7])
    assert_close(table.T_base_0, np.eye(4))
    assert_close(table.T_n_tip, formulas.craig(*DH_ROWS[7]) @ formulas.craig(*DH_ROWS[8]), atol=1e-16)
    assert_close(panda.dh(link="panda_link8").T_n_tip, formulas.craig(*DH_ROWS[7]))
    assert table.joint_names == panda.joint_names
    assert table.max_position_difference < 1e-14
    assert table.max_rotation_difference < 1e-14


@pytest.mark.parametrize(
    ("rows", "types"),
    [
        (UR5, ["revolute"] * 6),
        (np.column_stack([PUMA_A, PUMA_D, PUMA_ALPHA, np.zeros(6)]), ["revolute"] * 6),
        (STANFORD, STANFORD_TYPES),
    ],
    ids=["UR5", "Puma 560", "Stanford arm"],
)
def test_a_published_table_comes_back_from_the_robot_number_for_number(rows, types):
    table = Robot.from_dh(rows, convention="standard", joint_types=types).dh(convention="standard")
    assert_close(table.rows, rows)
    assert_close([table.T_base_0, table.T_n_tip], [np.eye(4)] * 2)


def test_the_puma_in_the_other_convention_has_its_a_and_alpha_one_row_later():
    rows = np.column_stack([PUMA_A, PUMA_D, PUMA_ALPHA, np.zeros(6)])
    table = Robot.from_dh(rows, convention="standard").dh(convention="modified")
    assert_close(table.rows, np.column_stack([[0, *PUMA_A[:5]], PUMA_D, [0, *PUMA_ALPHA[:5]], np.zeros(6)]))


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("link", ["hand", "fingertip", "rail", "rotor", "base"])
def test_chains_with_skew_axes_slides_and_mimics_have_a_table(convention, link):
    description = every_joint()
    gone = ("tray", "drone", "propeller")
    joints = tuple(joint for joint in description.joints if joint.child not in gone)
    links = tuple(one for one in description.links if one.name not in gone)
    description = Description("every joint", links, joints)
    table = Robot(description).dh(convention=convention, link=link)
    assert_is_the_robot(table, description)
    assert table.max_position_difference < 1e-14


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("tilt", matrix([0, 1e-16, 1e-12, 1e-9, 1e-7, 9.99e-7, 1.01e-6, 1e-5, 1e-4, 9.9e-4, 1.01e-3, 1e-2], 4))
@pytest.mark.parametrize("gap", [0.0, 1e-7, 1e-5, 0.3])
def test_nearly_parallel_axes_give_finite_rows_and_no_loss_that_the_proof_does_not_report(convention, tilt, gap):
    chain = of_chain("revolute", "revolute", "revolute").joints
    tilted = [
        formulas.from_rpy((gap, 0.1, 0.2), (0.6 * tilt, 0.8 * tilt, 0)),
        formulas.from_rpy((0.4, 0, 0.1), (1.2, 0.3, 0)),
    ]
    joints = (chain[0], *(Joint(j.name, j.type, j.parent, j.child, T, j.axis) for j, T in zip(chain[1:], tilted, strict=True)))
    description = Description("tilted", tuple(Link(f"l{k}") for k in range(4)), joints)
    table = Robot(description).dh(convention=convention)
    assert np.abs(table.rows).max() <= LARGEST
    lost = 1e-9 if tilt > 1e-6 else max(tilt + (gap if gap < 1e-6 else 0), 1e-14)
    assert_is_the_robot(table, description, atol=1.5 * lost)
    assert table.max_position_difference <= 1.5 * lost
    assert bool(table.notes) == (1e-12 < tilt < 1e-3)
    told = max(table.max_position_difference, table.max_rotation_difference)
    assert_is_the_robot(table, description, atol=1.5 * told + 1e-15 * np.abs(table.rows).max() + 1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("dropped", [0.0, 1e-7, 9e-7, 9.99e-7])
@pytest.mark.parametrize("kept", [1.01e-6, 1.1e-6, 1e-5, 1e-4, 1e-3, 1.0])
def test_a_tilt_that_is_dropped_costs_no_more_behind_axes_that_are_nearly_parallel(convention, kind, dropped, kept):
    chain = of_chain("revolute", "revolute", kind, "revolute", "revolute").joints
    tilts = [(0, 0, 0), (kept, 0, 0), (0.6 * dropped, 0.8 * dropped, 0), (-kept, 0, 0), (dropped, 0, 0)]
    places = [formulas.from_rpy((0.1, 0.4, 0.05 * k), rpy) for k, rpy in enumerate(tilts)]
    joints = tuple(Joint(j.name, j.type, j.parent, j.child, T, j.axis) for j, T in zip(chain, places, strict=True))
    description = Description("tilted", tuple(Link(f"l{k}") for k in range(6)), joints)
    table = Robot(description).dh(convention=convention)
    rounding = 1e-14 * np.abs(table.rows[:, :2]).max()
    assert_is_the_robot(table, description, atol=5 * dropped + rounding + 1e-13)
    assert table.max_position_difference <= 5 * dropped + rounding + 1e-13


def test_a_wider_tolerance_takes_axes_as_parallel_and_says_what_that_costs():
    tilted = of_chain("revolute", "revolute", "revolute", origin=formulas.from_rpy((0.3, 0, 0.1), (0, 3.7e-6, 0)))
    robot = Robot(tilted)
    exact, rounded = robot.dh(), robot.dh(tolerance=1e-5)
    assert exact.max_position_difference < 1e-10
    assert 1e-7 < rounded.max_position_difference < 1e-5
    assert "not treated as parallel, as with tolerance=1e-05" in exact.notes[0]
    assert "treated as parallel (tolerance 1e-05)" in rounded.notes[0]
    assert f"{rounded.max_position_difference:.2g} m" in str(rounded)


def test_a_common_normal_out_of_reach_is_refused_with_the_tolerance_that_helps():
    robot = Robot.from_dh([(0, 0, 0, 0), (0, 0, 1e-9, 0), (0, 0, 0, 0)], T_n_tip=ulna.pose((0.3, 0.2, 0)))
    shifted = Robot(of_chain("revolute", "revolute", origin=formulas.from_rpy((0.3, 0.2, 0), (1e-9, 0, 0))))
    assert robot.dh(tolerance=0).max_position_difference < 1e-9
    with pytest.raises(
        InputError, match=r"^tolerance: the axes of 'j1' and 'j2' are 1e-09 rad from parallel.*tolerance=1e-0[89]"
    ):
        shifted.dh(tolerance=0)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_parallel_axes_leave_d_to_the_last_of_them(convention):
    rows = [(0, 0.1, 0, 0.2), (0.3, 0.1, 0, 0.4), (0.4, 0.1, pi, -0.3), (0.2, 0.5, pi / 2, 0)]
    table = Robot.from_dh(rows, convention=convention).dh(convention=convention)
    assert_close(table.rows[:2, 1], [0, 0])
    assert_close(table.rows[:, 0], np.array(rows)[:, 0])


def test_the_place_of_a_sliding_joint_does_not_matter():
    def slider(shift):
        there, back = formulas.transform(p=shift), formulas.transform(p=np.negative(shift))
        first = Joint("turn", JointType.REVOLUTE, "a", "b", formulas.from_rpy((0, 0, 0.2), (0, 0, 0)), unit(0, 0, 1))
        second = Joint(
            "slide",
            JointType.PRISMATIC,
            "b",
            "c",
            formulas.from_rpy((0.1, 0.2, 0), (1, 0, 0.3)) @ there,
            unit(1, 2, -1),
        )
        third = Joint("spin", JointType.REVOLUTE, "c", "d", back @ formulas.from_rpy((0.3, 0, 0.1), (0.2, 0.7, 0)), unit(0, 1, 0))
        return Description("slider", tuple(Link(name) for name in "abcd"), (first, second, third))

    here, there = (Robot(slider(shift)).dh() for shift in ([0, 0, 0], [0.5, -0.3, 0.8]))
    assert_close(here.rows, there.rows, atol=1e-12)
    assert_is_the_robot(there, slider([0.5, -0.3, 0.8]))
    assert_close([here.rows[2, 0], here.rows[2, 1]], [0, 0])


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (1, 2, -2)])
def test_one_joint_about_any_axis(convention, kind, axis):
    description = of_chain(kind, axis=unit(*axis), origin=formulas.from_rpy((0.1, -0.2, 0.3), (0.3, -0.5, 1.2)))
    table = Robot(description).dh(convention=convention)
    assert (table.rows.shape, table.joint_types) == ((1, 4), (kind,))
    assert_is_the_robot(table, description, atol=1e-14)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_no_joints_are_a_table_without_rows(convention, panda):
    for robot, link in (
        (panda, "panda_link0"),
        (Robot(of_chain("fixed", origin=formulas.from_rpy((1, 2, 3), (1, 2, 3)))), "l1"),
    ):
        table = robot.dh(convention=convention, link=link)
        assert table.rows.shape == (0, 4)
        assert_close(table.T_base_0 @ table.T_n_tip, robot.forward_kinematics(robot.home, link=link), atol=1e-15)
        assert Robot.from_dh(table).n_dof == 0


@pytest.mark.parametrize(("link", "joint"), [("tray", "planar joint 'table'"), ("propeller", "floating joint 'float'")])
def test_what_no_row_can_describe_is_refused_by_name(link, joint):
    with pytest.raises(InputError, match=f"^link: the chain from 'base' to '{link}' has the {joint}, which no row"):
        Robot(every_joint()).dh(link=link)


def gripper():
    """Two fingers that follow a joint off their own chain, one of them turned by a third that stands still."""
    turn, origin = Limits(-1, 1, 2, 3), formulas.from_rpy((0.1, 0, 0.2), (0.3, 0.4, 0))
    joints = (
        Joint("lead", JointType.REVOLUTE, "palm", "thumb", origin, unit(1, 0, 0), turn),
        Joint("near", JointType.REVOLUTE, "palm", "one", origin, unit(0, 1, 0), turn, Mimic("lead", -2.0, 0.1)),
        Joint("still", JointType.REVOLUTE, "one", "held", origin, unit(0, 1, 1), turn, Mimic("lead", 0.0, 0.7)),
        Joint("far", JointType.PRISMATIC, "held", "two", origin, unit(1, 1, 0), turn, Mimic("lead", 0.5, -0.2)),
    )
    return Description("gripper", tuple(Link(name) for name in ("palm", "thumb", "one", "held", "two")), joints)


def test_followers_of_a_joint_off_the_chain_follow_the_first_of_them():
    table = Robot(gripper()).dh(link="two")
    assert (table.joint_names, table.joint_types) == (("near", "far"), ("revolute", "prismatic"))
    assert table.mimics == (None, Mimic("near", -0.25, pytest.approx(-0.175)))
    assert_is_the_robot(table, gripper())
    rebuilt = Robot.from_dh(table)
    lead = np.array([0.3])
    assert_close(rebuilt.forward_kinematics(-2 * lead + 0.1), Robot(gripper()).forward_kinematics(lead, link="two"), atol=1e-14)


def test_the_robot_of_a_table_keeps_the_names_and_limits_of_the_joints(panda):
    rebuilt = Robot.from_dh(panda.dh(convention="standard"))
    for key in ("joint_names", "name"):
        assert getattr(rebuilt, key) == getattr(panda, key)
    for key in ("lower", "upper", "velocity_limits"):
        assert_close(getattr(rebuilt, key), getattr(panda, key))
    assert_close(ulna.load(rebuilt.to_urdf()).forward_kinematics(panda.home), panda.forward_kinematics(panda.home), atol=1e-14)


def test_from_dh_refuses_arguments_that_a_table_already_has(panda):
    with pytest.raises(InputError, match=r"^rows: a DHTable includes the other arguments"):
        Robot.from_dh(panda.dh(), convention="standard")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"convention": "craig"}, "convention: 'craig' is not known"),
        ({"tolerance": -1e-9}, "tolerance: -1e-09; a number from 0 to 0.1"),
        ({"tolerance": np.nan}, "tolerance: nan"),
        ({"tolerance": "wide"}, "tolerance: 'wide'"),
    ],
)
def test_wrong_arguments_are_refused_by_name(panda, arguments, message):
    with pytest.raises(InputError, match=f"^{message}"):
        panda.dh(**arguments)


def test_an_unknown_link_is_refused_with_a_suggestion(panda):
    with pytest.raises(ulna.UnknownNameError, match=r"did you mean 'panda_link"):
        panda.dh(link="panda_link9")


def test_a_printed_table_has_fractions_of_pi_and_q_where_it_enters(panda):
    shown = str(panda.dh())
    assert "3  panda_joint3        0  0.316         pi/2           q3" in shown
    assert "4  panda_joint4   0.0825      0         pi/2           q4" in shown
    assert "frame 0 in panda_link0: the identity" in shown
    assert "panda_ee in frame 7: xyz = (0, 0, 0.2104) m, rpy = (0, 0, 0) rad" in shown
    slide = Robot.from_dh([(0.1, -0.5, -3 * pi / 4, 0.25)], joint_types=["prismatic"])
    assert "1  joint1    0.1  q1 - 0.5       -3pi/4         0.25" in str(slide.dh())


def test_a_table_is_frozen_and_survives_pickle(panda):
    table = pickle.loads(pickle.dumps(panda.dh()))  # noqa: S301 - our own
    assert isinstance(table, DHTable)
    assert_close(table.rows, panda.dh().rows)
    with pytest.raises(ValueError, match="read-only"):
        table.rows[0, 0] = 1.0
    with pytest.raises(AttributeError):
        table.rows = ()


def test_with_no_tolerance_rounding_still_is_no_tilt():
    rows = [(0.1, 0.2, 0.7, 0.3), (0.3, 0, 0, 0.1), (0.3, 0, pi, -0.4), (0.3, 0.1, 0.3, 0.2)]
    table = Robot.from_dh(rows, T_base_0=formulas.from_rpy((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))).dh(tolerance=0)
    assert table.max_position_difference < 1e-12
    assert np.abs(table.rows[:, :2]).max() < 2
    assert table.notes == ()
