"""Poses as controllers state them, against SciPy, and against numbers of makers and of public issues (docs/controllers.md)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ulna
from ulna import InputError
from ulna.description.controllers import CONTROLLERS

# What SciPy calls them: capital letters turn along.
SCIPY = {"Doosan": "ZYZ", "Fanuc": "xyz", "Kawasaki": "ZYZ", "Kinova": "xyz", "KUKA": "ZYX", "Staubli": "XYZ", "Yaskawa": "xyz"}
ANGLES = st.tuples(*[st.floats(-180, 180)] * 3)


def judged(name, numbers):
    """The rotation by SciPy."""
    turn = numbers[3:]
    if name == "ABB":
        return Rotation.from_quat(np.roll(turn, -1))
    return Rotation.from_rotvec(turn) if name == "UR" else Rotation.from_euler(SCIPY[name], turn, degrees=True)


def some(name, n=200):
    rng = np.random.default_rng(1)
    numbers = rng.uniform(-180, 180, (n, len(CONTROLLERS[name].labels)))
    if name in ("ABB", "UR"):
        numbers[:, 3:] /= 60.0
    return numbers


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_pose_is_what_scipy_makes_of_its_numbers(name):
    numbers = some(name)
    T = ulna.pose_from(numbers, name)
    meters = 1.0 if name in ("UR", "Kinova") else 1e-3
    np.testing.assert_allclose(T[:, :3, 3], meters * numbers[:, :3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(T[:, :3, :3], [judged(name, row).as_matrix() for row in numbers], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_numbers_of_a_pose_give_it_again_to_the_last_digits(name):
    T = ulna.pose_from(some(name), name)
    np.testing.assert_allclose(ulna.pose_from(ulna.pose_as(T, name), name), T, rtol=0, atol=1e-14)


@settings(max_examples=100, deadline=None)
@given(ANGLES, st.sampled_from([0.0, 90.0, -90.0, 180.0, 1e-7, 90.0 - 1e-7]))
def test_the_pose_comes_back_where_only_a_sum_of_angles_is_defined(angles, middle):
    for name in set(CONTROLLERS) - {"ABB", "UR"}:
        T = ulna.pose_from([0, 0, 0, angles[0], middle, angles[2]], name)
        np.testing.assert_allclose(ulna.pose_from(ulna.pose_as(T, name), name), T, rtol=0, atol=3e-15 * 1e3)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-4, 1.0, np.pi - 1e-9, np.pi])
def test_a_rotation_vector_is_exact_for_tiny_and_half_turns(angle):
    vector = angle * np.array([0.48, -0.6, 0.64])
    T = ulna.pose(rotvec=vector)
    np.testing.assert_allclose(T[:3, :3], Rotation.from_rotvec(vector).as_matrix(), rtol=0, atol=1e-15)
    back = ulna.pose_as(T, "UR")[3:]
    assert min(np.abs(back - vector).max(), np.abs(back + vector).max() + (angle < 3.1)) <= 1e-15 + 1e-14 * angle


def test_shapes_are_those_of_a_batch():
    assert ulna.pose_from(np.zeros((2, 3, 6)), "KUKA").shape == (2, 3, 4, 4)
    assert ulna.pose_as(np.tile(np.eye(4), (5, 1, 1)), "ABB").shape == (5, 7)
    assert ulna.pose(np.zeros((4, 3)), rotvec=(0, 0, 1)).shape == (4, 4, 4)


@pytest.mark.parametrize("name", ["kuka", "St\u00e4ubli", "staubli", "ur"])
def test_a_name_is_found_in_small_letters_and_with_its_umlaut(name):
    assert np.array_equal(ulna.pose_from(np.zeros(6), name), np.eye(4))


def test_what_is_no_pose_of_a_controller_is_refused_with_its_labels():
    with pytest.raises(InputError, match=r"^controller: 'Kukka' is not known; there are 'ABB', 'Doosan', 'Fanuc', .*'KUKA'"):
        ulna.pose_from(np.zeros(6), "Kukka")
    with pytest.raises(InputError, match=r"^numbers: shape \(6,\); ABB states x, y, z, q1, q2, q3, q4 \[mm\]$"):
        ulna.pose_from(np.zeros(6), "ABB")
    with pytest.raises(InputError, match=r"^numbers: has an entry that is not finite$"):
        ulna.pose_from([np.nan] * 6, "UR")
    with pytest.raises(InputError, match=r"^rpy, rotvec: give one of them, not both$"):
        ulna.pose(rpy=(0, 0, 0), rotvec=(0, 0, 0))


# ---- numbers that others printed


def test_abb_the_example_of_its_manual_is_thirty_degrees_about_y():
    """RAPID reference manual, data type orient: a tool turned by 30 degrees about y has [0.965926, 0, 0.258819, 0]."""
    T = ulna.pose_from([0, 0, 0, 0.965926, 0, 0.258819, 0], "ABB")
    np.testing.assert_allclose(T, ulna.pose(rpy=(0, np.radians(30), 0)), rtol=0, atol=1e-6)


def test_kinova_the_angles_of_its_web_page_are_the_quaternion_of_a_public_issue():
    """Kinova-kortex2_Gen3_G3L, issue 200: these angles of the web page are this quaternion x, y, z, w."""
    T = ulna.pose_from([0, 0, 0, -90.582, -178.79, 175.306], "Kinova")
    expected = ulna.pose(wxyz=(0.71035742, 0.70256971, -0.03630588, -0.02167998))
    np.testing.assert_allclose(T, expected, rtol=0, atol=1e-7)


def test_ur_the_pendant_shows_tool0_in_base_as_a_public_issue_has_it():
    """Universal_Robots_ROS2_Driver, issue 791: tf of base to flange, and the pendant's angles of the TCP, shown as RPY."""
    flange = ulna.pose(wxyz=(0.862, 0.170, 0.472, -0.074))
    tool = flange @ ulna.pose(rpy=(np.pi / 2, 0, np.pi / 2))  # tool0 in flange, by ur_description
    pendant = ulna.pose(rpy=np.radians([149.49, -12.78, 72.64]))
    assert np.degrees(np.arccos((np.trace(tool[:3, :3].T @ pendant[:3, :3]) - 1) / 2)) < 0.3
    assert np.abs(tool - ulna.pose(rotvec=np.radians([149.49, -12.78, 72.64]))).max() > 0.5  # they are no rotation vector


def test_ur_the_rotation_vector_of_a_tool_that_points_down_is_half_a_turn():
    """[2.2214, -2.2214, 0] points down: half a turn about the diagonal of x and -y."""
    T = ulna.pose_from([0.4, 0, 0.3, 2.22144147, -2.22144147, 0], "UR")
    np.testing.assert_allclose(T[:3, :3], [[0, -1, 0], [-1, 0, 0], [0, 0, -1]], rtol=0, atol=1e-8)


def test_doosan_the_rotation_is_that_of_its_makers_answer():
    """doosan-robot2, issue 314: SciPy's ZYZ in degrees, and not zyz."""
    angles = [89.904, -89.988, -179.068]  # printed by a controller, issue 109
    T = ulna.pose_from([-390.947, -154.829, 113.215, *angles], "Doosan")
    np.testing.assert_allclose(T[:3, :3], Rotation.from_euler("ZYZ", angles, degrees=True).as_matrix(), rtol=0, atol=1e-12)
    assert np.abs(T[:3, :3] - Rotation.from_euler("zyz", angles, degrees=True).as_matrix()).max() > 0.01


DOOSAN = {  # joints [deg] and the pose of the flange
    "fkin": ((30.0, 0.0, 90.0, 0.0, 90.0, 0.0), (466.9, 309.4, 651.5, 75.0, 180.0, 45.0)),
    "ikin": ((60.3, 24.0, 60.5, 0.0, 95.5, -29.7), (370.9, 719.7, 651.5, 90.0, -180.0, 0.0)),
}


@pytest.mark.parametrize("name", DOOSAN)
def test_doosan_the_pose_of_an_m1013_is_that_of_its_makers_own_test(name):
    """DoosanRobotics/doosan-robot2 at f56cbe92, dsr_tests/test/test_cli_dsr_system.py: what its controller answers."""
    q, numbers = DOOSAN[name]
    T = ulna.load("m1013").forward_kinematics(np.radians(q))
    np.testing.assert_allclose(ulna.pose_from(numbers, "Doosan")[:3, :3], T[:3, :3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(1e3 * T[:3, 3], numbers[:3], rtol=0, atol=0.3)  # joints to 0.1 deg
    wrong = [np.abs(ulna.pose_from(numbers, other)[:3, :3] - T[:3, :3]).max() for other in ("Fanuc", "Staubli")]
    assert min(wrong) > 0.9


def test_kuka_the_angles_of_a_telegram_are_those_of_its_joints():
    """A telegram of KUKA's Robot Sensor Interface in public code: search for ``AIPos A1="74.8478"``.

    The directions of the axes are those of every KUKA with six axes: here of a KR 6 R900, whose tool0 is the flange.
    """
    q = np.radians([74.8478, -128.7977, 75.8236, 102.2260, 0.0987, -56.5347])
    numbers = [93.9531, -347.9674, 1844.9703, -126.9460, 24.9226, -28.2871]
    R = ulna.load("kr6_r900").forward_kinematics(q)[:3, :3]
    np.testing.assert_allclose(ulna.pose_from(numbers, "KUKA")[:3, :3], R, rtol=0, atol=1e-5)
    assert min(np.abs(ulna.pose_from(numbers, other)[:3, :3] - R).max() for other in ("Fanuc", "Staubli", "Doosan")) > 0.3


def test_kawasaki_the_angles_that_its_controller_prints_are_those_of_its_joints():
    """What the command WHERE of a controller printed, in public code: search for ``-146.040   142.521    46.437``.

    The axes at q = 0 are those of Kawasaki-Robotics/khi_robot at 57200db5, khi_rs_description/urdf/rs007l_macro.xacro.
    """
    q = np.radians([-6.552, 23.595, -87.421, -147.271, 88.570, -167.663])
    numbers = [-214.985, 1355.266, -106.276, -146.040, 142.521, 46.437]
    R = np.eye(3)
    for angle, axis in zip(q, [(0, 0, -1), (-1, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 0), (0, 0, 1)], strict=True):
        R = R @ Rotation.from_rotvec(angle * np.array(axis)).as_matrix()
    np.testing.assert_allclose(ulna.pose_from(numbers, "Kawasaki")[:3, :3], R, rtol=0, atol=3e-3)  # its tool is turned by 0.1 deg
    assert min(np.abs(ulna.pose_from(numbers, other)[:3, :3] - R).max() for other in ("Fanuc", "Staubli", "KUKA")) > 0.5


FANUC = {  # W, P, R [deg], and the rotation as a matrix, or as x, y, z, w
    "lrmate-200id": (
        (22.168324, -66.680543, -153.971487),
        [[-0.355708, 0.717742, 0.598597], [-0.173709, -0.680099, 0.712243], [0.918312, 0.149368, 0.366595]],
    ),
    "lrmate-200id, next": (
        (143.581155, -5.258767, 28.459638),
        [[0.875453, 0.335633, 0.347755], [0.474534, -0.733383, -0.486792], [0.091654, 0.591185, -0.801312]],
    ),
    "angle_conversions": ((-50, 125, 67), (-0.606432, 0.562658, 0.543574, 0.142067)),
    "angle_conversions, next": ((160, 55, -35), (0.857216, -0.186206, -0.480004, 0.0101579)),
}


@pytest.mark.parametrize("name", FANUC)
def test_fanuc_the_rotation_is_that_of_public_drivers(name):
    """Tests of mattj23/lrmate-200id at 36b545f5 (python/tests), whose model was compared with the real arm, and of ROS's package
    industrial_robot_angle_conversions (InstitutMaupertuis)."""
    angles, rotation = FANUC[name]
    R = np.array(rotation) if np.ndim(rotation) == 2 else Rotation.from_quat(rotation).as_matrix()
    np.testing.assert_allclose(ulna.pose_from([0, 0, 0, *angles], "Fanuc")[:3, :3], R, rtol=0, atol=3e-6)


@pytest.mark.parametrize("name", ["Fanuc", "Yaskawa"])
def test_fanuc_and_yaskawa_the_quaternion_is_that_of_a_camera_makers_formula(name):
    """rc_visard, pose formats: the quaternion of W, P, R (or Rx, Ry, Rz), written out there."""
    W, P, R = np.radians([30.0, 45.0, -60.0]) / 2
    x = np.cos(R) * np.cos(P) * np.sin(W) - np.sin(R) * np.sin(P) * np.cos(W)
    y = np.cos(R) * np.sin(P) * np.cos(W) + np.sin(R) * np.cos(P) * np.sin(W)
    z = np.sin(R) * np.cos(P) * np.cos(W) - np.cos(R) * np.sin(P) * np.sin(W)
    w = np.cos(R) * np.cos(P) * np.cos(W) + np.sin(R) * np.sin(P) * np.sin(W)
    T = ulna.pose_from([0, 0, 0, 30, 45, -60], name)
    np.testing.assert_allclose(T, ulna.pose(wxyz=(w, x, y, z)), rtol=0, atol=1e-15)


def test_kuka_and_fanuc_state_one_pose_in_opposite_order():
    T = ulna.pose_from([280, 0, -10, 30, 40, 50], "KUKA")
    np.testing.assert_allclose(ulna.pose_as(T, "Fanuc"), [280, 0, -10, 50, 40, 30], rtol=0, atol=1e-12)
