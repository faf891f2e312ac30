"""What inverse kinematics refuses, each by the name of its argument."""

import numpy as np
import pytest

from ulna import InputError, Robot, UnknownNameError

METHODS = ("levenberg_marquardt", "jacobian_transpose")
REFUSED = {
    "position_tolerance": [0, -1e-5, np.nan, np.inf, "fine", None, (1e-5, 1e-5), 1e-5 + 0j],
    "rotation_tolerance": [0, -1e-5, np.nan, np.inf, "fine", None],
    "max_iterations": [-1, 2**31, np.nan, 1.5, "many"],
    "seed": [-1, 1.5, "lucky", [1, 2], None],
    "q_seed": [np.zeros(6), np.zeros((2, 7)), [np.nan] * 7, [np.inf] * 7, ["a"] * 7, np.full(7, 1e9)],
    "method": ["lm", None, ""],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in REFUSED.items() for value in values])
def test_an_argument_that_cannot_be_is_refused_by_its_name(panda, name, value):
    T = panda.forward_kinematics(panda.home)
    with pytest.raises(InputError) as caught:
        panda.inverse_kinematics(T, **{"q_seed": panda.home + 0.1, name: value})
    assert caught.value.argument.split("[")[0] == name


@pytest.mark.parametrize("posture", [np.zeros(3), np.zeros((2, 7)), [np.nan] * 7, "home"], ids=["short", "batch", "NaN", "word"])
def test_a_posture_that_cannot_be_is_refused(panda, posture):
    with pytest.raises(InputError, match=r"^posture"):
        panda.inverse_kinematics(panda.forward_kinematics(panda.home), posture=posture)


NO_POSES = {
    "NaN": (np.full((4, 4), np.nan), "T: has an entry that is not finite"),
    "a scaled matrix": (2 * np.eye(4), "T: has a last row"),
    "a reflection": (np.diag([1.0, 1.0, -1.0, 1.0]), "T: is a reflection"),
    "a stretch": (np.diag([2.0, 1.0, 1.0, 1.0]), "T: has a rotation part whose columns are not orthonormal"),
    "one bad in a batch": (np.stack([np.eye(4), np.diag([2.0, 1, 1, 1])]), r"T\[1\]: has a rotation part"),
    "a rotation": (np.eye(3), r"T: shape \(3, 3\), but targets have shape \(\.\.\., 4, 4\)"),
    "six numbers": ([0.3, 0, 0.5, 0, 0, 0], r"T: shape \(6,\), but targets have shape .*; ulna\.pose\(xyz, rpy\) makes one"),
    "a word": ("home", "T: not an array of numbers"),
    "nothing": (None, "T: not an array of numbers"),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NO_POSES)
def test_what_is_not_a_pose_is_not_a_target(panda, name, method):
    target, message = NO_POSES[name]
    with pytest.raises(InputError, match=f"^{message}"):
        panda.inverse_kinematics(target, method=method)


def test_a_rotation_is_refused_only_beyond_a_millionth(panda):
    T = panda.forward_kinematics(panda.home)
    for defect, refused in ((5e-7, False), (2e-6, True)):
        bent = T.copy()
        bent[:3, 0] *= 1 + defect / 2
        if refused:
            with pytest.raises(InputError, match="columns are not orthonormal"):
                panda.inverse_kinematics(bent)
        else:
            assert panda.inverse_kinematics(bent).success


def test_a_method_or_a_link_that_does_not_exist_is_refused_with_those_that_do(panda):
    with pytest.raises(InputError, match=r"method: 'jacobian_transposed' is not a method; did you mean 'jacobian_transpose'\?"):
        panda.inverse_kinematics(np.eye(4), method="jacobian_transposed")
    with pytest.raises(UnknownNameError, match=r"no link is called 'panda_link9'; did you mean 'panda_link\d'\?"):
        panda.inverse_kinematics(np.eye(4), link="panda_link9")
    with pytest.raises(InputError, match=r"posture: the method 'jacobian_transpose' takes none"):
        panda.inverse_kinematics(np.eye(4), method="jacobian_transpose", posture=panda.home)


def test_a_robot_that_cannot_move_says_so():
    with pytest.raises(InputError, match="no moving joints"):
        Robot.from_dh([(0, 0, 0, 0)], joint_types=["fixed"]).inverse_kinematics(np.eye(4))


def test_a_link_that_no_joint_moves_is_reached_where_it_stands_and_nowhere_else(panda):
    there = panda.inverse_kinematics(np.eye(4), link="panda_link0")
    assert (bool(there.success), int(there.iterations)) == (True, 0)
    away = np.eye(4)
    away[0, 3] = 0.1
    missed = panda.inverse_kinematics(away, link="panda_link0")
    assert not missed.success
    assert missed.position_error == pytest.approx(0.1)


def test_numbers_of_other_kinds_are_numbers(panda):
    T = panda.forward_kinematics(panda.home + 0.1)
    plain = panda.inverse_kinematics(T, seed=3, max_iterations=100, position_tolerance=1e-6)
    numpy = panda.inverse_kinematics(T, seed=np.int64(3), max_iterations=np.int32(100), position_tolerance=np.float64(1e-6))
    assert np.array_equal(plain.q, numpy.q)
    assert panda.inverse_kinematics(T.astype(np.float32), q_seed=panda.home.astype(np.float32)).success
