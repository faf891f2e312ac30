"""What inverse kinematics refuses of a target and of its options, and what a world refuses of its objects."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import robots
import ulna
from invalid_poses import INVALID_POSES, TARGET, mirrored, spoilt
from ulna import Box, DescriptionError, FileError, GeometryError, InputError, Mesh, Robot, UlnaError, UnknownNameError, World
from ulna.errors import SingularityError, UnknownArgumentError
from ulna.kernels.layout import LARGEST


def refused(kind, call, *arguments, **named):
    with pytest.raises(kind) as caught:
        call(*arguments, **named)
    assert type(caught.value) is kind
    assert isinstance(caught.value, UlnaError)
    return str(caught.value)


@pytest.mark.parametrize("case", INVALID_POSES)
def test_a_target_that_is_no_pose_is_refused_by_its_fault(panda, case):
    T, fault = INVALID_POSES[case]
    assert refused(InputError, panda.inverse_kinematics, T) == f"T: {fault}, so it is not a pose"


def test_in_a_batch_of_targets_the_faulty_one_is_named(panda):
    T = np.tile(TARGET, (2, 9, 1, 1))
    T[1, 8] = mirrored()
    assert refused(InputError, panda.inverse_kinematics, T).startswith("T[1, 8]: is a reflection")


@pytest.mark.parametrize("fault", [2e-7, 4e-7, 6e-7, 9e-7, 1.2e-6, 3e-6])
@pytest.mark.parametrize("kind", ["scaled", "last row", "sheared"])
def test_a_target_at_the_border_of_rigid_is_either_searched_for_or_refused(panda, kind, fault):
    """A matrix counts as a pose to 1e-6: whoever decides, kernel or error message, must not leave an answer that is neither."""
    T = panda.forward_kinematics(panda.home)
    if kind == "scaled":
        T[:3, :3] *= 1 + fault
    elif kind == "last row":
        T[3, :2] = fault
    else:
        T[0, :3] += fault * T[1, :3]
    try:
        s = panda.inverse_kinematics(T, q_seed=panda.home)
    except InputError:
        return
    assert s.status == "solved"
    assert abs(s.q - panda.home).max() < 1e-2
    assert s.position_error <= 1e-5


def test_a_rotation_is_refused_only_beyond_a_millionth(panda):
    there = panda.forward_kinematics(panda.home)
    bent, broken = (there * [1 + defect / 2, 1, 1, 1] for defect in (5e-7, 2e-6))
    assert panda.inverse_kinematics(bent, q_seed=panda.home).success
    message = refused(InputError, panda.inverse_kinematics, broken, q_seed=panda.home)
    assert message == "T: has a rotation part whose columns are not orthonormal, so it is not a pose"


def test_a_target_as_far_as_may_be_is_not_found_within_the_limits(panda):
    s = panda.inverse_kinematics(spoilt(((0, 3), LARGEST)), max_iterations=60)
    assert s.status == "unreachable"
    assert ((s.q >= panda.lower) & (s.q <= panda.upper)).all()
    assert s.position_error > 0.5 * LARGEST


@pytest.mark.parametrize("far", [np.nextafter(LARGEST, np.inf), 1e9, 1e155, 1e308])
def test_a_target_farther_than_that_is_refused(panda, far):
    message = refused(InputError, panda.inverse_kinematics, spoilt(((0, 3), -far)))
    assert message == "T: has a position beyond 1e+06 m, so it is not a pose"


def test_targets_of_another_shape_are_refused(panda):
    for shape in [(), (4,), (3, 4), (16,), (2, 3, 3), (7,)]:
        message = refused(InputError, panda.inverse_kinematics, np.zeros(shape))
        assert message == f"T: shape {shape}, but targets have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one"
    for word in ("home", None):
        assert refused(InputError, panda.inverse_kinematics, word).startswith("T: not an array of numbers")


def test_several_postures_are_refused(panda):
    message = refused(InputError, panda.inverse_kinematics, TARGET, posture=np.zeros((2, 7)))
    assert message == "posture: shape (2, 7), but one posture, shape (7,), is expected for all targets"


@pytest.mark.parametrize("method", ["levenberg_marquardt", "jacobian_transpose", None])
def test_the_former_method_is_refused_with_where_the_textbook_methods_are(panda, method):
    """The files that the error names are there."""
    message = refused(UnknownArgumentError, panda.inverse_kinematics, TARGET, method=method)
    assert message.startswith("inverse_kinematics() got an unexpected keyword argument 'method'; ")
    files = [word.strip("()") for word in message.split() if "/" in word]
    assert files == ["docs/lessons/3_inverse_kinematics.ipynb", "hw2/franka_robot.py"]
    assert all((Path(__file__).parents[2] / file).is_file() for file in files)


def test_an_argument_that_inverse_kinematics_does_not_have_is_refused_by_name(panda):
    with pytest.raises(TypeError) as caught:
        panda.inverse_kinematics(TARGET, restarts=3)
    assert str(caught.value) == "inverse_kinematics() got an unexpected keyword argument 'restarts'"
    assert pickle.loads(pickle.dumps(caught.value)).argument == "restarts"  # noqa: S301


@pytest.mark.parametrize("name", ["position_tolerance", "rotation_tolerance"])
@pytest.mark.parametrize("value", [0, -1e-5, np.nan, np.inf, "fine", None, (1e-5, 1e-5), 1e-5 + 0j])
def test_a_tolerance_that_is_no_number_above_zero_is_refused(panda, name, value):
    message = refused(InputError, panda.inverse_kinematics, TARGET, **{name: value})
    assert message == f"{name}: {value!r}; a number above 0 is expected"


@pytest.mark.parametrize("name", ["max_iterations", "seed"])
@pytest.mark.parametrize("value", [-1, 2**31, np.nan, 1.5, "many", [1, 2]])
def test_a_count_that_is_no_whole_number_is_refused(panda, name, value):
    message = refused(InputError, panda.inverse_kinematics, TARGET, **{name: value})
    assert message == f"{name}: {value!r}; a whole number from 0 to 2147483647 is expected"


def test_no_seed_is_refused_for_the_result_would_depend_on_more_than_its_arguments(panda):
    assert refused(InputError, panda.inverse_kinematics, TARGET, seed=None).startswith("seed: ")


def test_numbers_of_other_kinds_are_numbers(panda):
    T = panda.forward_kinematics(panda.home + 0.1)
    plain = panda.inverse_kinematics(T, seed=3, max_iterations=100, position_tolerance=1e-6)
    numpy = panda.inverse_kinematics(T, seed=np.int64(3), max_iterations=np.int32(100), position_tolerance=np.float64(1e-6))
    assert np.array_equal(plain.q, numpy.q)
    assert panda.inverse_kinematics(T.astype(np.float32), q_seed=panda.home.astype(np.float32)).success


def test_seeds_must_go_with_the_targets(panda):
    T = np.tile(TARGET, (3, 1, 1))
    for shape in [(2, 7), (4, 7), (3, 2, 7)]:
        message = refused(InputError, panda.inverse_kinematics, T, q_seed=np.zeros(shape))
        assert message.startswith(f"q_seed: shape {shape} does not go with targets of batch shape (3,)")


def test_a_robot_without_joints_has_nothing_to_solve_for():
    message = refused(InputError, Robot(robots.two_links("fixed", robots.Z)).inverse_kinematics, np.eye(4))
    assert message == "T: the robot has no moving joints, so nothing can be solved for"


def test_a_link_that_no_joint_moves_is_reached_at_its_pose_and_nowhere_else(panda):
    there = panda.inverse_kinematics(np.eye(4), link="panda_link0")
    assert (bool(there.success), int(there.iterations)) == (True, 0)
    missed = panda.inverse_kinematics(ulna.pose((0.1, 0, 0)), link="panda_link0")
    assert not missed.success
    assert missed.position_error == pytest.approx(0.1)


# ---- worlds -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def world():
    world = World()
    world.add("crate", Box((0.1, 0.2, 0.3)), TARGET)
    return world


@pytest.mark.parametrize("case", INVALID_POSES)
def test_a_world_refuses_what_is_no_pose_and_stays_as_it_was(world, case):
    T, fault = INVALID_POSES[case]
    for call in (lambda: world.add("lid", Box((1, 1, 1)), T), lambda: world.move("crate", T)):
        assert refused(InputError, call) == f"pose: {fault}, so it is not a pose"
    assert world.names == ("crate",)
    assert np.array_equal(world.pose("crate"), TARGET)


def test_an_object_has_one_pose(world):
    message = refused(InputError, world.move, "crate", np.tile(TARGET, (2, 1, 1)))
    assert message == "pose: shape (2, 4, 4), but one pose has shape (4, 4)"
    assert refused(InputError, world.move, "crate", np.eye(3)).startswith("pose: shape (3, 3), but poses have shape")
    assert refused(InputError, world.move, "crate", "there").startswith("pose: not an array of numbers")


@pytest.mark.parametrize("call", ["move", "remove", "shape", "pose"])
def test_an_object_that_is_not_there_is_refused_with_the_nearest_name(world, call):
    arguments = (TARGET,) if call == "move" else ()
    message = refused(UnknownNameError, getattr(world, call), "crat", *arguments)
    assert message == "no object of the world is called 'crat'; did you mean 'crate'?"
    world.remove("crate")
    assert refused(UnknownNameError, getattr(world, call), "crate", *arguments).endswith("; there are none")


def test_a_name_is_that_of_one_object(world):
    message = refused(InputError, world.add, "crate", Box((1, 1, 1)))
    assert message == "name: the world already has an object 'crate'; move() moves it"
    assert world.shape("crate") == Box((0.1, 0.2, 0.3))


def test_a_shape_that_cannot_be_checked_is_refused(world):
    message = "object 'part' is a Mesh, which cannot be checked; ulna.ConvexMesh.from_points() makes a hull"
    assert refused(GeometryError, world.add, "part", Mesh("part.stl")) == message
    assert refused(GeometryError, world.add, "ball", (1, 1, 1)).startswith("object 'ball' is a tuple")
    assert world.names == ("crate",)


@pytest.mark.parametrize("points", [np.zeros((5, 3)), [(0.5, 0, 0.2)], np.zeros((4, 6))])
def test_points_in_place_of_a_shape_are_refused_with_the_name_of_a_cloud(world, points):
    message = refused(GeometryError, world.add, "cloud", points)
    assert message == (
        f"object 'cloud' is a {type(points).__name__}, which cannot be checked; ulna.PointCloud(points, radius) makes a cloud of"
        " points, ulna.HeightMap(heights, cell) terrain, and ulna.ConvexMesh.from_points() makes a hull"
    )


@pytest.mark.parametrize("position", [(0.5, 0, 0.2), np.zeros(3), np.zeros((2, 3))])
def test_a_position_in_place_of_a_pose_is_refused_with_what_makes_one(world, panda, position):
    message = f"shape {np.shape(position)}, but poses have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one"
    assert refused(InputError, world.add, "lid", Box((1, 1, 1)), position) == f"pose: {message}"
    assert refused(InputError, world.move, "crate", position) == f"pose: {message}"
    assert refused(InputError, panda.all_solutions, position) == f"T: {message}"


def test_an_argument_that_check_collision_does_not_have_is_refused_with_the_one_that_is_meant(panda):
    message = "check_collision() got an unexpected keyword argument 'within'; max_distance= is the largest distance of a pair"
    assert refused(UnknownArgumentError, panda.check_collision, panda.home, within=0.1) == message


@pytest.mark.parametrize("extents", [(1, 1), (1, 1, -1), (1, np.nan, 1), (np.inf, 1, 1), "abc", 1.0, None])
def test_a_box_has_three_lengths(extents):
    assert refused(InputError, Box, extents).startswith("extents: ")


@pytest.mark.parametrize("home", [np.zeros(6), np.zeros((2, 7)), np.full(7, np.nan), ["a"] * 7])
def test_a_home_that_is_no_configuration_is_refused(panda, home):
    assert refused(InputError, Robot, panda.description, home=home).startswith("home")


@pytest.mark.parametrize(
    "error",
    [
        DescriptionError("no links", "arm.urdf", 3),
        InputError("q", "shape"),
        UnknownNameError("link", "b", ("a",)),
        FileError("arm.urdf", "is not there"),
        GeometryError("no shapes"),
        SingularityError("locked", ((0,),)),
    ],
)
def test_errors_survive_the_way_between_processes(error):
    back = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)
