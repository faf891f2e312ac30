"""Poses, roll-pitch-yaw and quaternions: round trips, gimbal lock, angles of -pi, and what is refused."""

import numpy as np
import pytest

import formulas
import ulna
from assertions import assert_close
from ulna.description.pose import (
    as_pose,
    inverse,
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
    rpy_from_matrix,
)
from ulna.errors import InputError

X, Y, Z = np.eye(3)
PI = np.pi


def random_rotations(rng, n):
    return np.array([formulas.rotation(rng.normal(size=3), rng.uniform(-PI, PI)) for _ in range(n)])


def test_roll_pitch_yaw_are_rotations_about_the_fixed_x_y_and_z_axes(rng):
    for rpy in rng.uniform(-PI, PI, (50, 3)):
        T = ulna.pose((0.1, -0.2, 0.3), rpy)
        assert_close(T, formulas.from_rpy((0.1, -0.2, 0.3), rpy), atol=1e-15)
    assert_close(ulna.pose(rpy=(PI / 2, 0, 0))[:3, :3] @ Y, Z, atol=1e-16)
    assert_close(ulna.pose(rpy=(0, PI / 2, 0))[:3, :3] @ Z, X, atol=1e-16)
    assert_close(ulna.pose(rpy=(0, 0, PI / 2))[:3, :3] @ X, Y, atol=1e-16)


def test_a_pose_without_arguments_is_the_identity():
    assert np.array_equal(ulna.pose(), np.eye(4))


def test_roll_pitch_yaw_survive_a_round_trip(rng):
    rpy = rng.uniform((-PI, -PI / 2, -PI), (PI, PI / 2, PI), (500, 3))
    assert_close(rpy_from_matrix(matrix_from_rpy(rpy)), rpy, atol=1e-12)
    assert_close(rpy_from_matrix(ulna.pose((1, 2, 3), rpy)), rpy, atol=1e-12)


def test_every_rotation_survives_a_round_trip_with_angles_in_range(rng):
    R = random_rotations(rng, 500)
    rpy = rpy_from_matrix(R)
    assert_close(matrix_from_rpy(rpy), R, atol=2e-15)
    assert (abs(rpy[:, 1]) <= PI / 2).all()
    assert ((rpy > -PI) & (rpy <= PI)).all()


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("short", [0.0, 1e-16, 1e-13, 9e-13, 1.1e-12, 1e-9, 1e-6, 1e-3])
def test_roll_pitch_yaw_at_gimbal_lock_give_the_same_matrix(rng, side, short):
    for roll, yaw in rng.uniform(-3, 3, (20, 2)):
        R = matrix_from_rpy((roll, side * (PI / 2 - short), yaw))
        rpy = rpy_from_matrix(R)
        assert_close(matrix_from_rpy(rpy), R, atol=3e-12)  # at the border cos(pitch) = 1e-12 is taken for zero
        assert_close(rpy[1], side * (PI / 2 - short), atol=2e-8 if short < 1e-3 else 1e-12)
        assert rpy[0] == 0.0 or short > 1e-13


@pytest.mark.parametrize("short", [0.0, 1e-13, 9e-13, 1.1e-12, 3e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 0.1])
def test_a_computed_rotation_near_gimbal_lock_is_that_of_its_angles(rng, short):
    for roll, yaw, base in zip(*rng.uniform(-3, 3, (2, 50)), random_rotations(rng, 50), strict=True):
        turned = formulas.rotation(Z, yaw) @ formulas.rotation(Y, PI / 2 + short) @ formulas.rotation(X, roll)
        R = base @ (base.T @ turned)  # each entry rounded on its own
        assert_close(matrix_from_rpy(rpy_from_matrix(R)), R, atol=3e-15 if short > 1e-12 else 3e-12)


def test_an_angle_of_minus_pi_is_returned_as_pi():
    for R in (np.diag([1.0, -1, -1]), np.array([[1.0, 0, 0], [0, -1, -0.0], [0, -0.0, -1]]), matrix_from_rpy((-PI, 0, 0))):
        assert abs(rpy_from_matrix(R)[0]) == rpy_from_matrix(R)[0]
    for R in (np.diag([-1.0, -1, 1]), np.array([[-1.0, 0, 0], [-0.0, -1, 0], [0, 0, 1]])):
        assert rpy_from_matrix(R)[2] == PI


def test_quaternions_have_the_real_part_first_and_are_normalised():
    half = np.sqrt(0.5)
    assert_close(matrix_from_quaternion((half, 0, 0, half)), formulas.rotation(Z, PI / 2), atol=1e-15)
    assert_close(ulna.pose(wxyz=(3, 0, 3, 0))[:3, :3], formulas.rotation(Y, PI / 2), atol=1e-15)
    assert_close(ulna.pose(wxyz=(-1e-9, 0, 0, 0)), np.eye(4), atol=0)
    assert_close(ulna.pose(wxyz=(0, 1e9, 0, 0))[:3, :3], formulas.rotation(X, PI), atol=1e-15)


def test_a_quaternion_is_that_of_its_axis_and_angle(rng):
    for axis, angle in zip(rng.normal(size=(100, 3)), rng.uniform(-PI, PI, 100), strict=True):
        wxyz = [np.cos(angle / 2), *(np.sin(angle / 2) * axis / np.linalg.norm(axis))]
        assert_close(matrix_from_quaternion(wxyz), formulas.rotation(axis, angle), atol=2e-15)
        assert_close(quaternion_from_matrix(formulas.rotation(axis, angle)), wxyz, atol=2e-15)


@pytest.mark.parametrize("axis", [X, Y, Z, X + Y, Y - Z, Z + X, X + Y + Z, X - Y + 1e-3 * Z])
@pytest.mark.parametrize("short", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-3])
def test_quaternions_near_a_half_turn_are_accurate(axis, short):
    angle, unit = PI - short, axis / np.linalg.norm(axis)
    found = quaternion_from_matrix(formulas.rotation(axis, angle))
    expected = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * unit)])
    assert found[0] >= 0
    assert min(abs(found - expected).max(), abs(found + expected).max()) < 1e-15


def test_quaternions_of_batches_survive_a_round_trip(rng):
    R = random_rotations(rng, 24).reshape(2, 3, 4, 3, 3)
    wxyz = quaternion_from_matrix(R)
    assert wxyz.shape == (2, 3, 4, 4)
    assert_close(np.linalg.norm(wxyz, axis=-1), 1, atol=1e-15)
    assert_close(matrix_from_quaternion(wxyz), R, atol=3e-15)
    assert_close(quaternion_from_matrix(ulna.pose(wxyz=wxyz)), wxyz, atol=1e-15)


def test_positions_and_orientations_are_broadcast(rng):
    xyz, rpy = rng.normal(size=(5, 1, 3)), rng.normal(size=(4, 3))
    T = ulna.pose(xyz, rpy)
    assert T.shape == (5, 4, 4, 4)
    assert_close(T[2, 3], ulna.pose(xyz[2, 0], rpy[3]), atol=0)
    assert ulna.pose(np.zeros((0, 3))).shape == (0, 4, 4)


def test_the_inverse_of_a_pose_is_the_inverse_matrix(rng):
    T = ulna.pose(rng.normal(size=(20, 3)), rng.normal(size=(20, 3)))
    assert_close(inverse(T), np.linalg.inv(T), atol=2e-15)


def test_arguments_are_not_changed(rng):
    xyz, rpy, wxyz = rng.normal(size=3), rng.normal(size=3), rng.normal(size=4)
    kept = [v.copy() for v in (xyz, rpy, wxyz)]
    ulna.pose(xyz, rpy)
    ulna.pose(xyz, wxyz=wxyz)
    assert all(np.array_equal(a, b) for a, b in zip((xyz, rpy, wxyz), kept, strict=True))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"xyz": (1, 2)}, r"xyz: shape \(2,\), but shape \(..., 3\) is expected"),
        ({"xyz": 1.0}, r"xyz: shape \(\), but shape \(..., 3\) is expected"),
        ({"xyz": "here"}, "xyz: not an array of numbers"),
        ({"xyz": (0, np.nan, 0)}, "xyz: has an entry that is not finite"),
        ({"rpy": (0, 0, np.inf)}, "rpy: has an entry that is not finite"),
        ({"rpy": np.zeros((2, 4))}, r"rpy: shape \(2, 4\), but shape \(..., 3\) is expected"),
        ({"rpy": (0, 0, 0), "wxyz": (1, 0, 0, 0)}, "rpy, wxyz: give one of them, not both"),
        ({"wxyz": (1, 0, 0)}, r"wxyz: shape \(3,\), but shape \(..., 4\) is expected"),
        ({"wxyz": (0, 0, 0, 0)}, "wxyz: a quaternion of length zero does not describe a rotation"),
        ({"wxyz": (np.nan, 0, 0, 1)}, "wxyz: has an entry that is not finite"),
        ({"xyz": np.zeros((2, 3)), "rpy": np.zeros((3, 3))}, r"\(2,\).*\(3,\)"),
    ],
)
def test_bad_arguments_of_pose_are_refused_by_name(arguments, message):
    with pytest.raises(InputError, match=message):
        ulna.pose(**arguments)


def test_a_huge_quaternion_gives_the_right_rotation_or_an_error():
    try:
        R = matrix_from_quaternion((1e200, 1e200, 0, 0))
    except InputError:
        return
    assert_close(R, formulas.rotation(X, PI / 2), atol=1e-15)


@pytest.mark.parametrize("fault", [2e-6, 1e-3, 1.0])
def test_a_matrix_is_accepted_as_a_pose_within_one_in_a_million(rng, fault):
    T = ulna.pose((1, 2, 3), rng.normal(size=3))
    assert np.array_equal(as_pose(T), T)
    for entry in [(0, 0), (1, 2), (2, 1), (3, 0), (3, 3)]:
        off = T.copy()
        off[entry] += fault
        with pytest.raises(InputError, match=r"^T: has a (last row|rotation part)"):
            as_pose(off)
        off[entry] = T[entry] + 1e-7
        as_pose(off)
