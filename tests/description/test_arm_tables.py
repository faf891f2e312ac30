"""The arms that have tables: their kinematics by their makers' figures, their limits, shapes and names."""

from itertools import pairwise

import numpy as np
import pytest

import formulas
import ulna
from doc_pages import ROOT
from robot_files import EXAMPLES
from ulna.description.names.arm_tables import arm_tables
from ulna.description.names.by_name import known_robots
from ulna.errors import FileError
from ulna.planning.arm_limits import ARMS

NAMES = sorted(arm_tables())
X, Y, Z = np.eye(3)
RIGHT = np.pi / 2

# Standard rows d, a, alpha of a UR, from "DH Parameters for calculations of kinematics and dynamics" of universal-robots.com.
UR = {  # d1, a2, a3, d4, d5, d6
    "ur3e": (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "ur16e": (0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
    "ur20": (0.2363, -0.862, -0.7287, 0.201, 0.1593, 0.1543),
    "ur30": (0.2363, -0.637, -0.5037, 0.201, 0.1593, 0.1543),
}
# Modified rows a, alpha, d, offset, from UFACTORY's developer manual.
UFACTORY = {
    "xarm6": [
        (0, 0, 0.267, 0), (0, -RIGHT, 0, -1.3849179), (0.28948866, 0, 0, 1.3849179), (0.0775, -RIGHT, 0.3425, 0),
        (0, RIGHT, 0, 0), (0.076, -RIGHT, 0.097, 0),
    ],
    "xarm7": [
        (0, 0, 0.267, 0), (0, -RIGHT, 0, 0), (0, RIGHT, 0.293, 0), (0.0525, RIGHT, 0, 0), (0.0775, RIGHT, 0.3425, 0),
        (0, RIGHT, 0, 0), (0.076, -RIGHT, 0.097, 0),
    ],
}  # fmt: skip
# Standard rows alpha, a, d, offset behind a half turn about x, from Kinova's user guide of the Gen3, to a tenth of a millimeter.
KINOVA = {
    "gen3_7": [
        (RIGHT, 0, -0.2848, 0), (RIGHT, 0, -0.0118, np.pi), (RIGHT, 0, -0.4208, np.pi), (RIGHT, 0, -0.0128, np.pi),
        (RIGHT, 0, -0.3143, np.pi), (RIGHT, 0, 0, np.pi), (np.pi, 0, -0.1674, np.pi),
    ],
    "gen3_6": [
        (RIGHT, 0, -0.2848, 0), (np.pi, 0.41, -0.0054, -RIGHT), (RIGHT, 0, -0.0064, -RIGHT), (RIGHT, 0, -0.3143, np.pi),
        (RIGHT, 0, 0, np.pi), (np.pi, 0, -0.1674, np.pi),
    ],
}  # fmt: skip
# Axis, a point of it and the tip where all joints are zero, from the makers' dimensions [m].
UPRIGHT = [Z, Y, Y, X, Y, X]
SCREWS = {
    "iiwa7": ([Z, Y, Z, -Y, Z, Y, Z], [(0, 0, z) for z in (0, 0.34, 0, 0.74, 0, 1.14, 0)], (0, 0, 1.266)),
    "iiwa14": ([Z, Y, Z, -Y, Z, Y, Z], [(0, 0, z) for z in (0, 0.36, 0, 0.78, 0, 1.18, 0)], (0, 0, 1.306)),
    "irb120": (UPRIGHT, [(0, 0, 0), (0, 0, 0.29), (0, 0, 0.56), (0, 0, 0.63), (0.302, 0, 0.63), (0, 0, 0.63)], (0.374, 0, 0.63)),
    "irb6640_185_280": (
        UPRIGHT,
        [(0, 0, 0), (0.32, 0, 0.78), (0.32, 0, 1.855), (0, 0, 2.055), (1.712, 0, 2.055), (0, 0, 2.055)],
        (1.912, 0, 2.055),
    ),
    "kr6_r700": (
        [-Z, Y, Y, -X, Y, -X],
        [(0, 0, 0), (0.025, 0, 0.4), (0.34, 0, 0.4), (0, 0, 0.435), (0.705, 0, 0.435), (0, 0, 0.435)],
        (0.785, 0, 0.435),
    ),
    "kr6_r900": (
        [-Z, Y, Y, -X, Y, -X],
        [(0, 0, 0), (0.025, 0, 0.4), (0.48, 0, 0.4), (0, 0, 0.435), (0.9, 0, 0.435), (0, 0, 0.435)],
        (0.98, 0, 0.435),
    ),
    "crx10ia": (
        [Z, Y, -Y, -X, -Y, -X],
        [(0, 0, 0), (0, 0, 0.245), (0, 0, 0.785), (0, 0, 0.785), (0.54, 0, 0.785), (0, -0.15, 0.785)],
        (0.7, -0.15, 0.785),
    ),
    "m1013": (
        [Z, Y, Y, Z, Y, Z],
        [(0, 0, 0), (0, 0.0345, 0.1525), (0, 0.0345, 0.7725), (0, 0.0345, 0), (0, 0.0345, 1.3315), (0, 0.0345, 0)],
        (0, 0.0345, 1.4525),
    ),
    "lite6": (
        [Z, Y, -Y, -Z, Y, -Z],
        [(0, 0, 0), (0, 0, 0.2435), (0, 0, 0.4437), (0.087, 0, 0), (0.087, 0, 0.21609), (0.087, 0, 0)],
        (0.087, 0, 0.15359),
    ),
    "tm5_700": (
        [Z, Y, Y, Y, Z, -Y],
        [(0, 0, 0), (0, 0, 0.1452), (0, 0, 0.4742), (0, -0.1223, 0.7857), (0, -0.1223, 0), (0, -0.1223, 0.8917)],
        (0, -0.1223 - 0.11315, 0.8917),
    ),
    "vx300s": (  # Interbotix, "X-Series Arms: ViperX-300 6DOF", the screw axes and M
        UPRIGHT,
        [(0, 0, 0), (0, 0, 0.12705), (0.05955, 0, 0.42705), (0, 0, 0.42705), (0.35955, 0, 0.42705), (0, 0, 0.42705)],
        (0.536494, 0, 0.42705),
    ),
}


def robots(names=NAMES):
    return pytest.mark.parametrize("robot", names, indirect=True)


@pytest.fixture(scope="module")
def robot(request):
    return ulna.load(request.param)


def some(robot, n=20, seed=3):
    """Configurations within the limits, shape (n, n_dof)."""
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (n, robot.n_dof))


def turn(axis, angle):
    return formulas.transform(formulas.rotation(axis, angle), np.zeros(3))


def shift(x=0.0, y=0.0, z=0.0):
    return formulas.transform(np.eye(3), np.array([x, y, z]))


@robots(sorted(UR))
def test_a_ur_is_where_its_makers_dh_table_puts_it(robot):
    d1, a2, a3, d4, d5, d6 = UR[robot.name]
    rows = [(d1, 0, RIGHT), (0, a2, 0), (0, a3, 0), (d4, 0, RIGHT), (d5, 0, -RIGHT), (d6, 0, 0)]
    for q in some(robot):
        place = turn(Z, np.pi)  # of the base on the pendant, in the link base_link of ROS
        for angle, (d, a, alpha) in zip(q, rows, strict=True):
            place = place @ turn(Z, angle) @ shift(z=d) @ shift(x=a) @ turn(X, alpha)
        np.testing.assert_allclose(robot.forward_kinematics(q), place, atol=1e-12)


@robots(sorted(UFACTORY))
def test_an_arm_of_ufactory_is_where_its_makers_dh_table_puts_it(robot):
    for q in some(robot):
        place = np.eye(4)
        for angle, (a, alpha, d, offset) in zip(q, UFACTORY[robot.name], strict=True):
            place = place @ shift(x=a) @ turn(X, alpha) @ turn(Z, angle + offset) @ shift(z=d)
        np.testing.assert_allclose(
            robot.forward_kinematics(q), place, atol=5e-6
        )  # a length and an angle of the xArm 6's are rounded


@robots(sorted(KINOVA))
def test_a_gen3_is_where_its_makers_dh_table_puts_it(robot):
    for q in some(robot):
        place = turn(X, np.pi)
        for angle, (alpha, a, d, offset) in zip(q, KINOVA[robot.name], strict=True):
            place = place @ turn(Z, angle + offset) @ shift(z=d) @ shift(x=a) @ turn(X, alpha)
        found = robot.forward_kinematics(q)
        np.testing.assert_allclose(found[:3, 3], place[:3, 3], atol=6e-4)  # the table's lengths are rounded
        np.testing.assert_allclose(found[:3, :3], place[:3, :3], atol=1e-12)


@robots(sorted(SCREWS))
def test_an_arm_is_where_its_makers_dimensions_put_it(robot):
    axes, points, tip = SCREWS[robot.name]
    zero = robot.forward_kinematics(np.zeros(robot.n_dof))
    np.testing.assert_allclose(zero[:3, 3], tip, atol=1e-12)
    for q in some(robot):
        place = np.eye(4)
        for angle, axis, point in zip(q, axes, points, strict=True):
            place = place @ shift(*point) @ turn(axis, angle) @ shift(*(-value for value in point))
        np.testing.assert_allclose(robot.forward_kinematics(q), place @ zero, atol=1e-12)


def test_a_variant_differs_in_two_lengths():
    short, long = (ulna.load(name).forward_kinematics(np.zeros(6))[:3, 3] for name in ("tm5_700", "tm5_900"))
    np.testing.assert_allclose(long - short, [0, 0, 0.2], atol=1e-12)


def test_every_arm_is_judged_by_figures_of_its_maker():
    assert {*UR, *UFACTORY, *KINOVA, *SCREWS, "tm5_900"} == set(NAMES)


def test_the_xarm7_is_that_of_example_robot_data():
    file = next(EXAMPLES.rglob("xarm7.urdf"))
    theirs, ours = ulna.load(file, base="link_base", tip="link_eef"), ulna.load("xarm7")
    assert theirs.joint_names == ours.joint_names
    for q in some(ours):
        np.testing.assert_allclose(ours.forward_kinematics(q), theirs.forward_kinematics(q), atol=2e-5)  # its angles are 1.5708


@robots()
def test_every_arm_has_one_tip_limits_and_a_home_free_of_itself_and_of_a_floor(robot):
    assert robot.tip == robot.description.joints[-1].child
    endless = [joint.type == "continuous" for joint in robot.description.joints if joint.type != "fixed"]
    assert (np.isfinite(robot.lower) & np.isfinite(robot.upper) | endless).all()
    assert ((robot.velocity_limits > 0) & np.isfinite(robot.velocity_limits)).all()
    assert ((robot.lower < robot.home) & (robot.home < robot.upper)).all()
    world = ulna.World()
    world.add("floor", ulna.HalfSpace())
    assert not robot.check_collision(robot.home, world).in_collision
    assert float(robot.signed_distance(robot.home, world)) > 0.0
    assert robot.manipulability(robot.home) > 1e-4  # bent


@robots()
def test_the_shapes_of_links_that_a_joint_joins_touch_each_other(robot):
    """As the links themselves do; a shape that were turned or shifted by mistake would not."""
    alone = robot.with_allowed_collisions(robot.allowed_collisions.minus(*robot.allowed_collisions))
    bearing = [link.name for link in robot.description.links if link.collisions]
    assert len(bearing) >= robot.n_dof
    for q in some(robot, 3):
        report = alone.check_collision(q, max_distance=0.5)
        for a, b in pairwise(bearing):
            assert min(pair.signed_distance for pair in report.pairs if {pair.link_a, pair.link_b} == {a, b}) < 0.005, (a, b)


@robots()
def test_every_arm_moves_without_touching_itself_in_a_good_part_of_its_configurations(robot):
    free = ~robot.in_collision(some(robot, 400))
    assert free.mean() > 0.3


@robots()
def test_the_farthest_place_of_the_flange_fits_the_reach_that_the_maker_states(robot):
    farthest = np.linalg.norm(robot.forward_kinematics(some(robot, 20_000))[:, :2, 3], axis=1).max()
    assert 0.99 < farthest / arm_tables()[robot.name].reach < 1.25  # makers measure to the wrist, or to the flange


@robots()
def test_inverse_kinematics_finds_a_pose_of_every_arm(robot):
    q = robot.home + 0.1
    found = robot.inverse_kinematics(robot.forward_kinematics(q), q_seed=robot.home)
    assert found.success
    np.testing.assert_allclose(robot.forward_kinematics(found.q), robot.forward_kinematics(q), atol=1e-4)


@robots()
def test_arms_of_a_family_have_an_exact_closed_form(robot):
    """The wrists of the CRX and the xArm 6 are not spherical, and that of a Gen3 is so but for 0.2 mm."""
    if robot.name in ("crx10ia", "xarm6"):
        assert robot.closed_form is None
        return
    assert robot.closed_form is not None
    assert robot.closed_form.miss < (1e-3 if robot.name.startswith("gen3") else 1e-12)
    if robot.n_dof == 6:
        T = robot.forward_kinematics(robot.home + 0.2)
        found = robot.all_solutions(T)
        assert np.abs(found.q[found.real] - robot.home - 0.2).max(axis=1).min() < 1e-6
        for q in found.q[found.real]:
            np.testing.assert_allclose(robot.forward_kinematics(q), T, atol=1e-8)


@robots()
def test_a_motion_of_every_arm_round_a_post_is_planned(robot):
    start, goal = robot.home.copy(), robot.home.copy()
    start[0], goal[0] = robot.home[0] - 0.8, robot.home[0] + 0.8
    reach = float(np.linalg.norm(robot.forward_kinematics(robot.home)[:2, 3]))
    world = ulna.World()
    angle = np.arctan2(*robot.forward_kinematics(robot.home)[1::-1, 3])
    world.add("post", ulna.Box((0.05, 0.05, 4.0)), ulna.pose((1.02 * reach * np.cos(angle), 1.02 * reach * np.sin(angle), 0)))
    plan = robot.plan(start, goal, world)
    motion = plan.trajectory(limits=robot.name, acceleration=2.0)
    assert motion.duration > 0
    assert not robot.in_collision(plan.at(np.linspace(0, 1, 200)), world).any()


@pytest.mark.parametrize("name", NAMES)
def test_a_table_states_its_source_and_the_limits_of_motions_are_those_of_the_arm(name):
    arm, robot = arm_tables()[name], ulna.load(name)
    assert " at " in arm.source
    assert arm.license
    assert arm.shapes_from.startswith("our own")
    np.testing.assert_array_equal(ARMS[name].velocity, robot.velocity_limits)
    if ARMS[name].acceleration is not None:
        np.testing.assert_array_equal(ARMS[name].acceleration, robot.acceleration_limits)


def test_the_page_names_every_arm_with_its_source():
    page = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    for name, arm in arm_tables().items():
        repository, commit = arm.source.split(" at ")
        assert f"| `{name}` | [{repository}](https://github.com/{repository}), {commit} | {arm.license} | {arm.files} |" in page


def test_other_names_give_the_same_arm_and_are_listed_with_its_maker():
    listed = {robot.name: robot for robot in known_robots()}
    for name, arm in arm_tables().items():
        assert (listed[name].maker, listed[name].payload, listed[name].also) == (arm.maker, arm.payload, tuple(arm.also))
        for other in arm.also:
            assert ulna.load(other).name == name


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("UR10e", ["ur10e"]),
        ("ur10-e", ["ur10e"]),
        ("xArm 7", ["xarm7"]),
        ("kr6", ["kr6_r700", "kr6_r900"]),
        ("irb", ["irb120", "irb6640"]),
        ("TM5-700", ["tm5_700"]),
        ("iiwa", ["iiwa7", "iiwa14"]),
    ],
)
def test_a_name_that_is_nearly_one_or_has_variants_suggests_them(name, meant):
    with pytest.raises(FileError, match=r"did you mean") as caught:
        ulna.load(name)
    assert all(f"{one!r} (bundled)" in str(caught.value) for one in meant)


def test_the_urdf_of_an_arm_is_read_again_as_the_same_arm():
    robot = ulna.load("ur10e")
    again = ulna.load(robot.to_urdf())
    assert again.joint_names == robot.joint_names
    np.testing.assert_allclose(again.forward_kinematics(robot.home), robot.forward_kinematics(robot.home), atol=1e-12)
    assert again.collision_names == robot.collision_names
