"""The assignment's files, used as a course script uses them; the expected numbers are those of the assignment's tables."""

import subprocess
import sys
from math import pi
from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna import pose

HW2 = Path(__file__).parents[3] / "hw2"
DH = [
    (0, 0.333, 0, 0),
    (0, 0, -pi / 2, 0),
    (0, 0.316, pi / 2, 0),
    (0.0825, 0, pi / 2, 0),
    (-0.0825, 0.384, -pi / 2, 0),
    (0, 0, pi / 2, 0),
    (0.088, 0, pi / 2, 0),
    (0, 0.107, 0, 0),
    (0, 0.1034, 0, 0),
]
ORIGIN = [
    (0, 0, 0.333, 0, 0, 0),
    (0, 0, 0, -pi / 2, 0, 0),
    (0, -0.316, 0, pi / 2, 0, 0),
    (0.0825, 0, 0, pi / 2, 0, 0),
    (-0.0825, 0.384, 0, -pi / 2, 0, 0),
    (0, 0, 0, pi / 2, 0, 0),
    (0.088, 0, 0, pi / 2, 0, 0),
    (0, 0, 0.107, 0, 0, 0),
    (0, 0, 0.1034, 0, 0, 0),
]
HOME = [0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4]


@pytest.fixture(scope="module")
def course():
    sys.path.insert(0, str(HW2))
    try:
        import franka_robot
    finally:
        sys.path.remove(str(HW2))
    return franka_robot


@pytest.fixture(scope="module")
def robot(course):
    return course.FrankaRobot(str(HW2 / "franka_robot.urdf"), np.array(DH), 7)


@pytest.mark.process
@pytest.mark.parametrize("script", ["test_forward_kinematics.py", "test_jacobian.py", "test_inverse_kinematics.py"])
def test_the_script_prints_true(script):
    run = subprocess.run([sys.executable, script], cwd=HW2, capture_output=True, text=True, check=True)
    assert run.stdout == "True\n"


def test_parse_urdf_returns_the_rows_of_the_table(course):
    parsed = course.parse_urdf(str(HW2 / "franka_robot.urdf"))
    np.testing.assert_allclose(parsed["origin"], ORIGIN, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(parsed["axis"], [(0, 0, 1)] * 7 + [(0, 0, 0)] * 2)


def test_both_forward_kinematics_equal_the_product_of_the_dh_transforms(robot):
    joints, T, frames = np.linspace(-1, 1, 7), np.eye(4), []
    for (a, d, alpha, _), theta in zip(DH, [*joints, 0, 0], strict=True):
        ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
        rotate_x = np.array([[1, 0, 0, 0], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
        rotate_z = np.array([[ct, -st, 0, 0], [st, ct, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        shift = np.eye(4)
        shift[0, 3], shift[2, 3] = a, d
        T = T @ rotate_x @ shift @ rotate_z
        frames.append(T)
    for found in (robot.forward_kinematics_urdf(joints), robot.forward_kinematics_dh(joints)):
        assert found.shape == (9, 4, 4)
        np.testing.assert_allclose(found, frames, rtol=0, atol=1e-12)


def test_the_roll_of_the_end_effector_at_home_is_plus_pi(robot):
    x, y, z, roll, pitch, yaw = robot.ee(HOME)
    # Home by hand: the upper arm and the elbow's offset lean 45 degrees, the fore arm is level, the wrist points down.
    lean = np.sqrt(0.5)
    by_hand = [0.384 + 0.088 - 0.316 * lean + 0.0825 * lean, 0, 0.333 + 0.316 * lean + 0.0825 * lean + 0.0825 - 0.107 - 0.1034]
    np.testing.assert_allclose([x, y, z, pitch], [*by_hand, 0], rtol=0, atol=1e-12)
    assert roll == pytest.approx(pi, abs=1e-12)
    assert yaw == pytest.approx(-pi / 4, abs=1e-12)


@pytest.mark.parametrize("kind", [list, tuple, np.array])
def test_finger_joints_are_accepted_and_arguments_are_not_changed(robot, kind):
    joints = kind([*HOME, 0.02, 0.02])
    before = np.array(joints)
    np.testing.assert_array_equal(robot.ee(joints), robot.ee(HOME))
    np.testing.assert_array_equal(robot.jacobian(joints), robot.jacobian(HOME))
    desired = robot.ee(joints)
    desired[1] += 0.01
    found = robot.inverse_kinematics(desired, joints)
    assert found.shape == (9,)
    np.testing.assert_array_equal(found[7:], [0.02, 0.02])
    assert np.allclose(robot.ee(found), desired)
    np.testing.assert_array_equal(np.array(joints), before)


def test_ik_from_zeros_outside_the_limits_of_joint_four_finds_home(robot):
    """0 is outside the limits of joint 4. A search that stays at that limit stops 0.23 m from the target."""
    assert np.allclose(robot.ee(robot.inverse_kinematics(robot.ee(HOME), np.zeros(7))), robot.ee(HOME), rtol=0, atol=1e-8)


@pytest.mark.slow
def test_ik_from_random_starts_finds_random_reachable_poses(robot):
    rng = np.random.default_rng(0)
    lower, upper = robot.lower, robot.upper
    for _ in range(10):
        start, desired = rng.uniform(lower, upper), robot.ee(rng.uniform(lower, upper))
        found = robot.inverse_kinematics(desired, start)
        x, y, z, *rpy = robot.ee(found)
        np.testing.assert_allclose((x, y, z), desired[:3], rtol=0, atol=1e-8)
        np.testing.assert_allclose(pose(rpy=rpy), pose(rpy=desired[3:]), rtol=0, atol=1e-8)
        assert ((lower <= found) & (found <= upper)).all()


@pytest.mark.parametrize("joints", [np.zeros((10, 7)), np.zeros(6), 0.0])
def test_a_wrong_shape_of_the_joints_is_refused(robot, joints):
    with pytest.raises(ValueError, match="one configuration of at least 7 numbers"):
        robot.forward_kinematics_urdf(joints)


def test_an_unreachable_pose_gives_a_warning(robot):
    with pytest.warns(UserWarning, match="inverse kinematics: unreachable: .* from the target"):
        found = robot.inverse_kinematics([3, 0, 0.5, pi, 0, 0], HOME)
    assert np.isfinite(found).all()


@pytest.mark.parametrize(
    ("place", "touches"),
    [((0.5, 0, 0.21), False), ((0.3, 0, 0.5), True), ((0, 0, 0.1), True), ((0, 0.8, 0.1), False)],
)
def test_a_box_collides_with_the_arm_or_not(robot, place, touches):
    assert robot.check_box_collision(HOME, [*place, 0, 0, 0, 0.15, 0.09, 0.126]) is touches


def test_a_box_wholly_inside_the_arm_collides(robot):
    assert robot.check_box_collision(HOME, [-0.04, 0, 0.05, 0.3, 0.2, 0.1, 0.01, 0.01, 0.01]) is True


@pytest.mark.parametrize("pose", [None, 0.5, [0.5] * 5, [0.5] * 7, [[0.5] * 6]])
def test_a_pose_that_is_not_six_numbers_is_refused(robot, pose):
    with pytest.raises(ValueError, match=r"desired_ee_pos: .* 6 numbers are expected: x, y, z, roll, pitch, yaw"):
        robot.inverse_kinematics(pose, HOME)


@pytest.mark.parametrize("box", [None, [0.5] * 8, [0.5] * 10])
def test_a_box_that_is_not_nine_numbers_is_refused(robot, box):
    with pytest.raises(ValueError, match=r"box: .* 9 numbers are expected: .* length, width, height"):
        robot.check_box_collision(HOME, box)


def test_the_parameters_of_the_robot_have_the_course_name(robot):
    assert np.allclose(robot.robot_params["origin"], ORIGIN)


def test_the_tables_of_the_file_are_those_of_the_assignment(course):
    np.testing.assert_array_equal(course.DH_PARAMS, DH)
    np.testing.assert_array_equal(course.HOME, HOME)
    panda = ulna.load("panda")
    shapes = [(link.name, body) for link in panda.description.links for body in link.collisions]
    for (link, position, rotation, size), (name, body) in zip(course.BOXES, shapes, strict=True):
        assert name == f"panda_link{link}"
        np.testing.assert_array_equal(body.shape.extents, size)
        np.testing.assert_allclose(body.pose, pose(position, wxyz=rotation), rtol=0, atol=1e-15)


def test_poses_and_jacobians_equal_those_of_ulna(robot, panda, q):
    links = [panda.link_names.index(f"panda_link{k}") for k in range(1, 9)]
    for joints in q:
        frames = robot.forward_kinematics_urdf(joints)
        np.testing.assert_allclose(frames[:8], panda.link_poses(joints)[links], rtol=0, atol=1e-14)
        np.testing.assert_allclose(frames[-1], panda.forward_kinematics(joints), rtol=0, atol=1e-14)
        np.testing.assert_allclose(robot.jacobian(joints), panda.jacobian(joints), rtol=0, atol=1e-14)


def test_the_verdicts_on_boxes_equal_those_of_ulna(robot, panda, rng):
    touching = 0
    for _ in range(150):
        joints = rng.uniform(panda.lower, panda.upper)
        T = pose(rng.normal((0.1, 0, 0.4), 0.25), rng.uniform(-pi, pi, 3))
        size, world = rng.uniform(0.01, 0.4, 3), ulna.World()
        world.add("box", ulna.Box(size), T)
        expected = panda.in_collision(joints, world, self_collision=False)
        rpy = ulna.description.pose.rpy_from_matrix(T)
        assert robot.check_box_collision(joints, [*T[:3, 3], *rpy, *size]) is bool(expected)
        touching += bool(expected)
    assert 30 < touching < 130


def test_the_transpose_method_alone_solves_the_example_of_the_assignment(course, robot, monkeypatch):
    monkeypatch.delattr(course.FrankaRobot, "_by_ulna")
    desired = robot.ee(HOME)
    desired[1] += 0.01
    assert np.allclose(robot.ee(robot.inverse_kinematics(desired, HOME)), desired, rtol=0, atol=1e-9)


def test_descent_never_climbs_and_ends_at_the_target(course, robot, monkeypatch):
    target = pose((0.1, 0.2, -0.1)) @ robot.forward_kinematics_urdf(HOME)[-1]
    monkeypatch.setattr(course, "PATIENCE", np.inf)
    squares = []
    for steps in range(0, 200, 5):
        monkeypatch.setattr(course, "MAX_STEPS", steps)
        q, has_arrived = robot._descend(target, np.array(HOME))
        e = course._error(target, robot.forward_kinematics_urdf(q)[-1])
        squares.append(e @ e)
        assert not has_arrived
    assert squares == sorted(squares, reverse=True)
    assert squares[-1] < 0.01 * squares[0]


def planar_arm(course, folder, n):
    """An arm of n joints about parallel axes, with links of one meter along x."""
    limits, meter = '<limit lower="-9" upper="9"/>', '<origin xyz="1 0 0"/>'
    inside = [f"{limits}{meter if k else ''}<axis xyz='0 0 1'/></joint>" for k in range(n)]
    joints = [joint(f"{k}", "revolute", f"link {k}", f"link {k + 1}").replace("</joint>", inside[k]) for k in range(n)]
    tip = joint("tip", "fixed", f"link {n}", "tip").replace("</joint>", f"{meter}</joint>")
    (folder / "arm.urdf").write_text(f"<robot name='arm'>{''.join(joints)}{tip}</robot>")
    return course.FrankaRobot(folder / "arm.urdf", np.zeros((n, 4)), n)


def test_descent_without_a_direction_ends_where_it_began(course, tmp_path):
    """A stretched arm cannot shorten to first order."""
    q, has_arrived = planar_arm(course, tmp_path, 2)._descend(pose((1, 0, 0.1034)), np.zeros(2))
    assert not has_arrived
    np.testing.assert_array_equal(q, [0, 0])


def test_descent_that_has_come_to_rest_is_at_the_least_error(course, tmp_path, monkeypatch):
    """One joint, a target beyond its circle: of 5 - 4 sin q + q^2 the least."""
    monkeypatch.setattr(course, "PATIENCE", np.inf)
    q, has_arrived = planar_arm(course, tmp_path, 1)._descend(pose((0, 2, 0.1034)), np.array([0.3]))
    assert not has_arrived
    assert 2 * np.cos(q[0]) == pytest.approx(q[0], abs=1e-6)


@pytest.mark.slow
def test_random_targets_from_random_starts_are_all_reached(course, robot, monkeypatch):
    """Within the limits, about half of them by the Jacobian transpose alone."""
    left_to_ulna, by_ulna = [], course.FrankaRobot._by_ulna
    monkeypatch.setattr(course.FrankaRobot, "_by_ulna", lambda *it: left_to_ulna.append(it) or by_ulna(*it))
    rng = np.random.default_rng(0)
    for _ in range(60):
        start, goal = rng.uniform(robot.lower, robot.upper, (2, 7))
        found = robot.inverse_kinematics(robot.ee(goal), start)
        e = course._error(*(robot.forward_kinematics_urdf(joints)[-1] for joints in (goal, found)))
        assert max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:])) < 1e-8
        assert ((robot.lower <= found) & (found <= robot.upper)).all()
    assert 15 < len(left_to_ulna) < 45


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1.0, pi - 1e-3, pi - 1e-5, pi - 1e-9, pi])
def test_the_rotation_vector_gives_the_rotation_back(course, rng, angle):
    for axis in [*np.eye(3), *-np.eye(3), *rng.normal(size=(20, 3))]:
        unit = axis / np.linalg.norm(axis)
        R = pose(wxyz=[np.cos(angle / 2), *np.sin(angle / 2) * unit])[:3, :3]
        vector = course.rotation_vector(R)
        assert np.linalg.norm(vector) == pytest.approx(angle, abs=1e-7)
        half = np.linalg.norm(vector) / 2
        again = np.eye(3) if half == 0 else pose(wxyz=[np.cos(half), *np.sin(half) * vector / (2 * half)])[:3, :3]
        np.testing.assert_allclose(again, R, rtol=0, atol=1e-8)


def joint(name, kind, parent, child):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (joint("a", "prismatic", "x", "y"), "joint a is prismatic"),
        (joint("a", "floating", "x", "y"), "joint a is floating"),
        (joint("a", "fixed", "x", "y") + joint("b", "fixed", "x", "z"), "joint b is the second at link x"),
        (joint("a", "fixed", "x", "y") + joint("b", "fixed", "v", "w"), "1 of 2 joints are in a chain"),
        (joint("a", "fixed", "x", "y") + joint("b", "fixed", "y", "x"), "0 of 2 joints are in a chain"),
        ("", "0 of 0 joints are in a chain"),
    ],
)
def test_a_urdf_that_is_no_chain_of_revolute_joints_is_refused(course, tmp_path, text, expected):
    (tmp_path / "arm.urdf").write_text(f"<robot name='arm'>{text}</robot>")
    with pytest.raises(ValueError, match=expected):
        course.parse_urdf(tmp_path / "arm.urdf")


def test_numbers_that_are_not_finite_are_refused(robot):
    with pytest.raises(ValueError, match=r"joints: .* finite"):
        robot.ee([*HOME[:6], np.nan])
    with pytest.raises(ValueError, match=r"desired_ee_pos: .* finite"):
        robot.inverse_kinematics([0.5, 0, np.inf, 0, 0, 0], HOME)
    with pytest.raises(ValueError, match=r"box: length, width and height .* positive"):
        robot.check_box_collision(HOME, [0.5, 0, 0.2, 0, 0, 0, 0.1, 0, 0.1])
