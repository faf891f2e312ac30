"""Lengths and angles from outside that are likely in another unit give one warning at the caller's line, and right ones none."""

import warnings

import numpy as np
import pytest

import robots
import ulna
from ulna import InputError, UnitWarning

K = (150, 150, 79.5, 59.5)
DEPTH = np.full((120, 160), 0.8, dtype=np.float32)  # a wall at 0.8 m
POINTS = np.random.default_rng(0).uniform(-0.4, 0.4, (500, 3))
UR5 = np.array(robots.UR5)
MILLIMETERS, DEGREES = np.array([1e3, 1e3, 1, 1]), np.array([1, 1, 180 / np.pi, 180 / np.pi])
LIMITS = [(-np.pi, np.pi)] * 6


def urdf(scale=1.0, limit=3.0):
    """Text of a UR5 whose lengths are in another unit, or whose limits are."""
    arm = ulna.Robot.from_dh(UR5, convention="standard", limits=LIMITS)
    text = arm.to_urdf()
    for a in sorted({abs(float(x)) for row in UR5 for x in row[:2] if x}, reverse=True):
        text = text.replace(f"{a!r}", f"{a * scale!r}")
    return text.replace('lower="-3.141592653589793" upper="3.141592653589793"', f'lower="{-limit}" upper="{limit}"')


def seen(depth=DEPTH, T=None, **options):
    return ulna.PointCloud.from_depth(depth, K, np.eye(4) if T is None else T, radius=0.01, **options)


def unseen(depth=DEPTH, T=None, **options):
    box, pose = ulna.Box((0.4, 0.4, 0.4)), ulna.pose((0, 0, 0.8))
    return ulna.VoxelGrid.unseen(depth, K, np.eye(4) if T is None else T, box, 0.05, pose=pose, **options)


def added(shape, T=None, **options):
    world = ulna.World()
    world.add("part", shape, T, **options)
    return world


def moved(T):
    world = added(ulna.Box((0.4, 0.3, 0.2)))
    world.add("other", ulna.Sphere(0.1))
    world.move_many(["other", "part"], T) if T.ndim == 3 else world.move("part", T)
    return world


def reshaped(shape):
    world = added(ulna.Sphere(0.1))
    world.reshape("part", shape)
    return world


BALL = '<robot name="r"><link name="a"><collision><geometry><sphere radius="50"/></geometry></collision></link></robot>'


def mostly_far():
    depth = 1000 * DEPTH
    depth[:10] = 50  # something 5 cm before the camera
    return depth


UNLIKELY = {
    "a depth image of which a part is near": (lambda: seen(mostly_far()), "depth: .*millimeters"),
    "unseen, of which a part is near": (lambda: unseen(mostly_far()), "depth: .*millimeters"),
    "a depth image scaled twice": (lambda: seen(DEPTH, depth_scale=0.001), "depth: .*scaled twice"),
    "a camera": (lambda: seen(T=ulna.pose((400, 0, 1400))), "T_base_camera: 1456 m .*millimeters"),
    "a camera of unseen": (lambda: unseen(T=ulna.pose((400, 0, 1400))), "T_base_camera: 1456 m .*millimeters"),
    "a cloud": (lambda: ulna.PointCloud(1000 * POINTS, 0.01), "points: half of them .*millimeters"),
    "a crop": (lambda: ulna.PointCloud(POINTS, 0.01).cropped(ulna.Box((1, 1, 1)), ulna.pose((500, 0, 0))), "pose: 500 m"),
    "heights": (lambda: ulna.HeightMap(np.linspace(0, 50, 400).reshape(20, 20), 0.02), "heights: up to 50 m"),
    "a table's height": (lambda: ulna.HeightMap(np.full((20, 20), 720), 0.02), "heights: up to 720 m"),
    "cells": (lambda: ulna.HeightMap(np.full((20, 20), 0.7), 20), "cell: 20 m"),
    "voxels": (lambda: ulna.VoxelGrid(np.ones((4, 4, 2)), 50), "cell: 50 m"),
    "a box": (lambda: added(ulna.Box((400, 300, 200))), "shape: 'part' is 400 x 300 x 200 m"),
    "a ball": (lambda: added(ulna.Sphere(60)), "shape: 'part' is 120 x 120 x 120 m"),
    "a hull": (lambda: added(ulna.ConvexMesh(1000 * POINTS)), "shape: 'part' is .*millimeters"),
    "the place of a box": (lambda: added(ulna.Box((0.4, 0.3, 0.2)), ulna.pose((500, 0, 300))), "pose of 'part': 583.1 m"),
    "a box that is moved": (lambda: moved(ulna.pose((500, 0, 300))), "pose: 583.1 m"),
    "boxes that are moved": (lambda: moved(ulna.pose([(0, 0, 1), (500, 0, 300)])), "poses: 583.1 m"),
    "a box of another size": (lambda: reshaped(ulna.Box((400, 300, 200))), "shape: 'part' is 400 x 300 x 200 m"),
    "the radius of points": (lambda: ulna.PointCloud(POINTS, 10), "radius: each point is a ball of 10 m"),
    "the radius of pixels": (lambda: ulna.PointCloud.from_depth(DEPTH, K, np.eye(4), radius=5), "radius: .*millimeters"),
    "voxels of a cloud": (lambda: ulna.PointCloud(POINTS, 0.01).thinned(10), "voxel: 10 m"),
    "a speed": (lambda: added(ulna.Sphere(0.1), speed=250), "speed: 250 m/s: are these millimeters a second"),
    "a tool": (lambda: ulna.load("panda").with_tool(ulna.pose((0, 0, 103))), "T_flange_tool: the robot reaches 104"),
    "roll, pitch and yaw": (lambda: ulna.pose((0, 0, 0), (180, 0, 90)), "rpy: up to 180 rad: are these degrees"),
    "a shape of a URDF": (lambda: ulna.load(BALL), "source: shape 'a_collision' of link 'a' is 100 x 100 x 100 m"),
    "a table of lengths": (lambda: ulna.Robot.from_dh(UR5 * MILLIMETERS, limits=LIMITS), "rows: .*reaches .*millimeters"),
    "a table of angles": (lambda: ulna.Robot.from_dh(UR5 * DEGREES, limits=LIMITS), "rows: .*90 rad: are these degrees"),
    "limits": (lambda: ulna.Robot.from_dh(UR5, limits=np.degrees(LIMITS)), "rows: -180 to 180 rad .*degrees"),
    "a URDF": (lambda: ulna.load(urdf(scale=1000.0)), "source: .*reaches .*millimeters"),
    "limits of a URDF": (lambda: ulna.load(urdf(limit=170)), "source: -170 to 170 rad .*degrees"),
}


@pytest.mark.parametrize("name", UNLIKELY)
def test_what_is_likely_in_another_unit_is_taken_with_one_warning_at_the_callers_line(name):
    act, words = UNLIKELY[name]
    with pytest.warns(UnitWarning, match=words) as caught:
        assert act() is not None
    assert [one.filename for one in caught] == [__file__]


def test_padding_that_takes_away_all_points_is_warned_of(panda):
    for thing in (ulna.PointCloud(POINTS, 0.01), ulna.VoxelGrid(np.ones((2, 2, 2)), 0.1)):
        with pytest.warns(UnitWarning, match="padding: what is within 10 m of the robot is left out"):
            thing.without(panda, panda.home, padding=10)


def test_a_held_object_far_from_its_link_is_warned_of(panda):
    with pytest.warns(UnitWarning, match="pose of 'cup': 103 m"):
        panda.with_attached("cup", ulna.Sphere(0.04), ulna.pose((0, 0, 103)))


def test_depths_of_which_none_is_within_100_m_are_refused_with_the_unit():
    for depth, options in ((1000 * DEPTH, {}), ((1000 * DEPTH).astype(np.uint16), {"depth_scale": 1.0})):
        for ask in (seen, unseen):
            with pytest.raises(InputError, match=r"^depth: the nearest of 19200 depths is 800 m.*depth_scale=0.001"):
                ask(depth, **options)


SIZES = [1e-3, 1e-2, 0.1, 1.0, 10.0, 50.0]


@pytest.mark.parametrize("size", SIZES)
def test_an_arm_and_its_cell_of_any_real_size_give_no_warning(size):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ulna.Robot.from_dh(UR5 * [size, size, 1, 1], convention="standard", limits=LIMITS)
        ulna.Robot.from_dh(UR5 * [size, size, 1, 1], limits=[(-2 * np.pi, 2 * np.pi)] * 6)
        ulna.load(urdf(scale=size))
        ulna.PointCloud(size * POINTS, 0.01 * size)
        ulna.HeightMap(size * np.linspace(0, 0.4, 400).reshape(20, 20), 0.02 * size)
        world = added(ulna.Box((0.4 * size, 0.3 * size, 0.2 * size)), ulna.pose((size, 0, 0.5 * size)))
        world.add("floor", ulna.Box((1000, 1000, 0.1)), ulna.pose((300, 0, -0.05)))
        world.add("ground", ulna.HalfSpace(), ulna.pose((0, 0, -1000)))
        if 0.01 < size < 50:  # of depth cameras
            seen(size * DEPTH)


def test_a_target_in_millimeters_is_out_of_reach_with_a_hint(panda):
    assert "499.7 m (millimeters?) from" in str(panda.inverse_kinematics(ulna.pose((400, 0, 300))))
    assert "millimeters" not in str(panda.inverse_kinematics(ulna.pose((4, 0, 3))))


def test_degrees_that_are_beyond_the_limits_are_refused_with_a_hint(panda):
    q = panda.home + 0.1
    with pytest.raises(InputError, match=r"^goal: .* is outside its limits, .*: are these degrees"):
        panda.plan(q, np.degrees(q))
    assert "degrees" in str(panda.plan(np.degrees(q), q))
    assert "degrees" not in str(panda.plan(q + 4, q))
    servo = panda.servo(ulna.World(), acceleration=1.0)
    with pytest.raises(InputError, match=r"^q: beyond the joint limits: are these degrees"):
        servo.start(np.degrees(q))


TYPED = [0, -45, 0, -135, 0, 90, 45]  # degrees


@pytest.mark.parametrize(
    "ask",
    [
        lambda panda: panda.forward_kinematics(TYPED),
        lambda panda: panda.forward_kinematics([TYPED, panda.home.tolist()]),
        lambda panda: panda.jacobian(tuple(TYPED)),
        lambda panda: panda.check_collision(TYPED),
    ],
)
def test_a_list_of_degrees_gets_a_question(panda, ask):
    with pytest.warns(UnitWarning, match="^q: panda_joint4 is at 135: are these degrees"):
        ask(panda)


def test_no_question_about_turns_slides_and_arrays(panda):
    """An array may be large: it is not looked at."""
    panda.forward_kinematics(np.array(TYPED, dtype=float))
    panda.forward_kinematics([0, -12, 0, 12, 0, 9, 4])
    slide = """<robot name="slide"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="s" type="prismatic"><parent link="a"/><child link="b"/>
        <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
      <joint name="t" type="continuous"><parent link="b"/><child link="c"/></joint></robot>"""
    ulna.load(slide).forward_kinematics([45, 900])
