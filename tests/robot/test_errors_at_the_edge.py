"""What every public method of a robot and of a world refuses: the class of the error, its text, and its data."""

import numpy as np
import pytest

import robots
import ulna
from ulna import Box, GeometryError, InputError, Robot, SingularityError, UlnaError, UnknownNameError, World
from ulna.description.robot_description import Body, Description, Link
from ulna.description.shapes import Mesh

Q = np.zeros(7)
WORLD = World()
WORLD.add("crate", Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.2)))

TAKE_Q = {
    "forward_kinematics": lambda robot, q: robot.forward_kinematics(q),
    "link_poses": lambda robot, q: robot.link_poses(q),
    "jacobian": lambda robot, q: robot.jacobian(q),
    "analytical_jacobian": lambda robot, q: robot.analytical_jacobian(q),
    "in_collision": lambda robot, q: robot.in_collision(q, WORLD),
    "check_collision": lambda robot, q: robot.check_collision(q, WORLD),
    "signed_distance": lambda robot, q: robot.signed_distance(q, WORLD),
    "distance_gradient": lambda robot, q: robot.distance_gradient(q, WORLD),
    "collision_poses": lambda robot, q: robot.collision_poses(q),
    "q_seed": lambda robot, q: robot.inverse_kinematics(ulna.pose((0.4, 0, 0.4)), q_seed=q),
    "posture": lambda robot, q: robot.inverse_kinematics(ulna.pose((0.4, 0, 0.4)), posture=q),
}
TAKE_SWITCH = {
    "self_collision of in_collision": lambda robot, on: robot.in_collision(robot.home, WORLD, self_collision=on),
    "self_collision of check_collision": lambda robot, on: robot.check_collision(robot.home, WORLD, self_collision=on),
    "self_collision of distances": lambda robot, on: robot.distances(robot.home, WORLD, within=0.1, self_collision=on),
    "self_collision of signed_distance": lambda robot, on: robot.signed_distance(robot.home, WORLD, self_collision=on),
    "self_collision of distance_gradient": lambda robot, on: robot.distance_gradient(robot.home, WORLD, self_collision=on),
    "self_collision of edge_in_collision": lambda robot, on: robot.edge_in_collision(
        robot.home, robot.home, WORLD, self_collision=on
    ),
    "whole_turns of all_solutions": lambda robot, on: robot.all_solutions(ulna.pose((0.4, 0, 0.4)), whole_turns=on),
    "trace of inverse_kinematics": lambda robot, on: robot.inverse_kinematics(ulna.pose((0.4, 0, 0.4)), trace=on),
    "certify of plan": lambda robot, on: robot.plan(robot.home, robot.home, certify=on),
    "shorten of plan": lambda robot, on: robot.plan(robot.home, robot.home, shorten=on),
    "escape of plan": lambda robot, on: robot.plan(robot.home, robot.home, escape=on),
    "lead_out of start": lambda robot, on: robot.servo(WORLD, acceleration=1.0).start(robot.home, lead_out=on),
    "resume of reachability_map": lambda robot, on: ulna.reachability_map(
        robot, "none.zarr", voxel=0.5, orientations=1, resume=on
    ),
    "keep_clearance of reachability_map": lambda robot, on: ulna.reachability_map(
        robot, "none.zarr", voxel=0.5, orientations=1, keep_clearance=on
    ),
    "steer of view": lambda robot, on: ulna.view(robot, steer=on),
    "open_browser of view": lambda robot, on: ulna.view(robot, open_browser=on),
}
TAKE_LINK = {
    "forward_kinematics": lambda robot, link: robot.forward_kinematics(np.zeros(robot.n_dof), link=link),
    "jacobian": lambda robot, link: robot.jacobian(np.zeros(robot.n_dof), link=link),
    "analytical_jacobian": lambda robot, link: robot.analytical_jacobian(np.zeros(robot.n_dof), link=link),
    "inverse_kinematics": lambda robot, link: robot.inverse_kinematics(np.eye(4), link=link),
}


def refusal(kind, call, *arguments, **named):
    """The error that a call raises, which must be of one class, of Ulna's, and said in one line."""
    with pytest.raises(kind) as caught:
        call(*arguments, **named)
    assert isinstance(caught.value, UlnaError)
    assert type(caught.value) is kind
    assert "\n" not in str(caught.value)
    return caught.value


@pytest.mark.parametrize("what", TAKE_SWITCH)
@pytest.mark.parametrize("on", ["no", "False", "", 0, 1, None, [], np.ones(2, dtype=bool)], ids=repr)
def test_a_switch_is_true_or_false_and_nothing_that_python_takes_for_one(panda, what, on):
    before = panda._checker._last if what.startswith("self") else None
    error = refusal(InputError, TAKE_SWITCH[what], panda, on)
    assert error.argument == what.split()[0]
    assert str(error).endswith("True or False is expected")
    assert before is None or panda._checker._last is before


@pytest.mark.parametrize("on", [True, False])
def test_a_switch_of_numpy_is_one(panda, on):
    for name in ("in_collision", "signed_distance"):
        ask = getattr(panda, name)
        assert ask(panda.home, WORLD, self_collision=np.bool_(on)) == ask(panda.home, WORLD, self_collision=on)


def name_of(method):
    return method if method in ("q_seed", "posture") else "q"


# ---- joint positions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", TAKE_Q)
@pytest.mark.parametrize("shape", [(), (6,), (8,), (2, 6), (7, 1), (0,), (3, 7, 0)])
def test_positions_of_another_shape_are_refused_with_both_shapes_and_the_joints(panda, method, shape):
    error = refusal(InputError, TAKE_Q[method], panda, np.zeros(shape))
    assert error.argument == name_of(method)
    for words in (f"{name_of(method)}: shape {shape}", "shape (..., 7) is expected", "panda_joint1, panda_joint2"):
        assert words in str(error)


@pytest.mark.parametrize("method", TAKE_Q)
@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (np.nan, "nan is not a finite number"),
        (np.inf, "inf is not a finite number"),
        (-np.inf, "-inf is not a finite number"),
        (1e9, "1000000000.0 is beyond 1e+06, where angles lose their digits"),
        (-1e300, "-1e+300 is beyond 1e+06, where angles lose their digits"),
    ],
)
def test_an_entry_that_is_no_usable_number_is_refused_with_its_place(panda, method, bad, reason):
    q = Q.copy()
    q[3] = bad
    error = refusal(InputError, TAKE_Q[method], panda, q)
    assert str(error) == f"{name_of(method)}[3]: {reason}"
    assert error.argument == f"{name_of(method)}[3]"


@pytest.mark.parametrize("method", [m for m in TAKE_Q if m not in ("check_collision", "posture", "q_seed")])
def test_in_a_batch_the_place_has_all_its_indices(panda, method):
    q = np.zeros((2, 9, 7))
    q[1, 8, 6] = np.nan
    assert str(refusal(InputError, TAKE_Q[method], panda, q)) == "q[1, 8, 6]: nan is not a finite number"


@pytest.mark.parametrize("method", TAKE_Q)
@pytest.mark.parametrize("q", ["home", [0, 1, [2]], object(), ["a"] * 7, {"panda_joint1": 0.0}, [1j] * 7])
def test_what_is_no_array_of_numbers_is_refused(panda, method, q):
    assert str(refusal(InputError, TAKE_Q[method], panda, q)).startswith(f"{name_of(method)}: ")


def test_complex_positions_lose_no_imaginary_part_in_silence(panda):
    refusal(InputError, panda.forward_kinematics, np.full(7, 1j))


def test_a_robot_without_joints_says_so():
    error = refusal(InputError, Robot(robots.two_links("fixed", robots.Z)).forward_kinematics, [0.0])
    assert str(error) == "q: shape (1,), but shape (..., 0) is expected: the robot has no moving joints"


# ---- names --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", TAKE_LINK)
def test_an_unknown_link_is_refused_with_the_nearest_name(panda, method):
    error = refusal(UnknownNameError, TAKE_LINK[method], panda, "panda_lnk4")
    assert str(error) == "no link is called 'panda_lnk4'; did you mean 'panda_link4'?"
    assert isinstance(error, LookupError)
    assert (error.kind, error.name, error.known) == ("link", "panda_lnk4", panda.link_names)


@pytest.mark.parametrize("method", TAKE_LINK)
def test_an_unknown_name_gets_a_list_of_the_known_ones(method):
    error = refusal(UnknownNameError, TAKE_LINK[method], Robot(robots.two_links("revolute", robots.Z)), "gripper")
    assert str(error) == "no link is called 'gripper'; there are 'a', 'b'"


@pytest.mark.parametrize("method", TAKE_LINK)
def test_of_several_tips_one_must_be_named(method):
    error = refusal(InputError, TAKE_LINK[method], Robot(robots.every_joint()), None)
    assert str(error) == "link: 'every joint' has several tips; name one of fingertip, tray, propeller, or any other link"


@pytest.mark.parametrize(
    ("frame", "hint"), [("bas", "did you mean 'base'?"), ("world", "there are 'base', 'link', 'spatial'"), (0, "there are")]
)
def test_an_unknown_frame_is_refused_with_the_known_ones(panda, frame, hint):
    error = refusal(InputError, panda.jacobian, Q, expressed_in=frame)
    assert error.argument == "expressed_in"
    assert f"{frame!r} is not a frame; {hint}" in str(error)


# ---- singularities and geometry -----------------------------------------------------------------------------------------


def test_roll_and_yaw_without_rates_are_refused_with_the_rows():
    arm = Robot(robots.of_chain("revolute", axis=robots.Y))
    error = refusal(SingularityError, arm.analytical_jacobian, [[[0.0], [np.pi / 2]], [[-np.pi / 2 + 1e-7], [1.0]]])
    assert isinstance(error, ValueError)
    assert error.rows == ((0, 1), (1, 0))
    assert "as at rows 0, 1; 1, 0; the geometric jacobian() is defined everywhere" in str(error)
    alone = refusal(SingularityError, arm.analytical_jacobian, [np.pi / 2])
    assert "as here; " in str(alone)
    many = refusal(SingularityError, arm.analytical_jacobian, np.full((9, 1), np.pi / 2))
    assert "as at rows 0; 1; 2; 3; 4 and 4 more; " in str(many)
    for beside in (np.pi / 2 - 2e-6, np.pi / 2 + 2e-6):
        assert np.isfinite(arm.analytical_jacobian([beside])).all()


ASK_OF_SHAPES = {
    "in_collision": lambda robot: robot.in_collision(np.zeros(robot.n_dof), WORLD),
    "check_collision": lambda robot: robot.check_collision(np.zeros(robot.n_dof), WORLD),
    "signed_distance": lambda robot: robot.signed_distance(np.zeros(robot.n_dof), WORLD),
    "distance_gradient": lambda robot: robot.distance_gradient(np.zeros(robot.n_dof), WORLD),
    "edge_in_collision": lambda robot: robot.edge_in_collision(np.zeros(robot.n_dof), np.zeros(robot.n_dof), WORLD),
    "allowed_collisions": lambda robot: robot.allowed_collisions,
    "collision_poses": lambda robot: robot.collision_poses(np.zeros(robot.n_dof)),
    "collision_names": lambda robot: robot.collision_names,
}


@pytest.mark.parametrize("method", ASK_OF_SHAPES)
def test_a_robot_without_shapes_is_never_called_free(method):
    error = refusal(GeometryError, ASK_OF_SHAPES[method], Robot(robots.two_links("revolute", robots.Z)))
    assert str(error).startswith("robot 'two links' has no collision shapes, so its collisions cannot be checked: ")


@pytest.mark.parametrize("method", ASK_OF_SHAPES)
def test_a_shape_that_cannot_be_checked_is_never_called_free(method):
    bodies = (Body("hull", Box((1, 1, 1)), np.eye(4)), Body("part", Mesh("part.stl"), np.eye(4)))
    error = refusal(GeometryError, ASK_OF_SHAPES[method], Robot(Description("r", (Link("a", collisions=bodies),), ())))
    assert str(error).startswith("link 'a': collision shape 'part': a Mesh has no collision kernel")
