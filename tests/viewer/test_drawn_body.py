"""The body that is drawn for a robot without visuals, and the Panda's shells from the small package."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import robots
import ulna
from ulna.description import packages
from ulna.viewer.drawn_body import DARK, SHELL, drawn_body
from ulna.viewer.surface_nets import box, cone, cut, drum, mesh_of, union
from ulna.viewer.visuals import link_visuals

HAND = """
<robot name="hand"><link name="base"/><link name="arm"/><link name="palm"/><link name="left"/><link name="right"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="flange" type="fixed"><parent link="arm"/><child link="palm"/><origin xyz="0 0 0.3"/></joint>
<joint name="a" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0 0 0.06"/><axis xyz="0 1 0"/>
  <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
<joint name="b" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0 0 0.06"/><axis xyz="0 -1 0"/>
  <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint></robot>
"""


@cache
def drawn(name):
    robot = ulna.load(name)
    return robot, drawn_body(robot)


def color_of(mesh):
    return tuple(mesh.visual.material.baseColorFactor)


def shells(scene):
    return [mesh for mesh in scene.geometry.values() if color_of(mesh) == SHELL]


def is_closed(mesh):
    """Whether each edge is passed as often in one direction as in the other."""
    n = len(mesh.vertices)
    there, back = (np.sort(mesh.edges @ weights) for weights in ((n, 1), (1, n)))
    return np.array_equal(there, back)


def contains(mesh, point):
    """Whether a mesh winds round a point: the sum of its solid angles, after van Oosterom and Strackee, 1983."""
    a, b, c = np.moveaxis(mesh.triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    dots = [np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return np.arctan2(np.einsum("ij,ij->i", a, np.cross(b, c)), below).sum() * 2 > 2 * np.pi


def points_of(robot, q, link_scenes):
    places = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
    return np.concatenate(
        [scene.to_mesh().vertices @ places[link][:3, :3].T + places[link][:3, 3] for link, scene in link_scenes.items()]
    )


@pytest.fixture
def nothing_installed(monkeypatch):
    monkeypatch.setattr(packages, "_shares_of_python", lambda: iter(()))
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if not list(Path(entry).glob("dm_robotics"))])


@pytest.mark.parametrize("name", ["panda", "fr3"])
def test_the_drawn_arm_is_closed_smooth_shells_and_dark_joints(name):
    robot, scenes = drawn(name)
    assert {robot.description.joints[k].child for k in range(7)} <= set(scenes), "each link that a joint moves has a body"
    for scene in scenes.values():
        for mesh in scene.geometry.values():
            assert is_closed(mesh)
            assert mesh.volume > 0.0
            assert np.isfinite(mesh.vertices).all()
        for mesh in shells(scene):
            outwards = np.einsum("ij,ij->i", mesh.face_normals, mesh.vertex_normals[mesh.faces[:, 0]])
            assert np.mean(outwards > 0.8) > 0.95
    assert sum(color_of(mesh) == DARK for scene in scenes.values() for mesh in scene.geometry.values()) > 7


@pytest.mark.parametrize("name", ["panda", "fr3"])
def test_the_drawn_arm_is_where_its_collision_boxes_are(name):
    robot, scenes = drawn(name)
    points = points_of(robot, robot.home, scenes)
    places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
    excess = np.min(
        [
            np.maximum(np.abs((points - T[:3, 3]) @ T[:3, :3]) - body.shape.half_extents, 0.0).max(axis=1)
            for link in robot.description.links
            for body in link.collisions
            for T in [places[link.name] @ body.pose]
        ],
        axis=0,
    )
    assert np.mean(excess < 0.03) > 0.9
    assert np.quantile(excess, 0.99) < 0.1  # the foot of the Panda has no box


def test_a_leg_is_no_thicker_than_the_capsule_around_it():
    """The middle half of the capsule of a UR10e's forearm holds the drawn tube, to a twentieth of its radius."""
    robot, scenes = drawn("ur10e")
    [link] = [one for one in robot.description.links if one.name == "forearm_link"]
    [body] = [one for one in link.collisions if isinstance(one.shape, ulna.Capsule)]
    points = (scenes[link.name].to_mesh().vertices - body.pose[:3, 3]) @ body.pose[:3, :3]
    middle = points[np.abs(points[:, 2]) < body.shape.length / 4]
    assert len(middle) > 100
    assert np.linalg.norm(middle[:, :2], axis=1).max() < 1.05 * body.shape.radius


def test_the_hand_is_between_the_flange_and_the_fingertips_whose_point_it_leaves_free():
    scene = drawn("panda")[1]["panda_link8"]
    meshes = list(scene.geometry.values())
    tip = np.array([0.0, 0.0, 0.1034])
    assert not any(contains(mesh, tip) for mesh in meshes)
    wide = np.array([np.cos(np.pi / 4), np.sin(np.pi / 4), 0.0])  # the long side of box 12, which holds the hand
    beside = [tip + 0.03 * side * wide for side in (-1, 1)]
    assert all(any(contains(mesh, point) for mesh in meshes) for point in beside), "a finger on either side"
    assert np.ptp(scene.to_mesh().vertices @ wide) > 0.15
    assert scene.bounds[1, 2] < 1.2 * tip[2]


def test_fingers_of_a_description_are_drawn_as_fingers_on_a_palm():
    scenes = drawn_body(ulna.load(HAND))
    left, right = scenes["left"].bounds, scenes["right"].bounds
    assert left[1, 1] > -left[0, 1]
    assert -right[0, 1] > right[1, 1]
    assert scenes["palm"].extents[1] > scenes["palm"].extents[0]


@pytest.mark.parametrize("kinds", [("prismatic", "prismatic"), ("continuous", "planar"), ("floating", "fixed"), ("fixed",), ()])
def test_a_robot_with_joints_of_every_type_is_drawn(kinds):
    for step in (0.01, 1.0):
        robot = ulna.Robot(robots.of_chain(*kinds, origin=ulna.pose((step, 0.0, step))))
        scenes = drawn_body(robot)
        assert scenes
        assert all(np.isfinite(scene.bounds).all() and scene.extents.max() < 30 * (step + 2) for scene in scenes.values())


def test_without_any_package_the_panda_is_drawn_and_its_meshes_are_named(nothing_installed):
    visuals = link_visuals(ulna.load("panda"))
    assert len(visuals.missing) == 9
    assert len(visuals.scenes) == 9


def test_the_small_package_gives_the_pandas_shells_in_their_colors(nothing_installed, monkeypatch, tmp_path):
    folder = tmp_path / "dm_robotics" / "panda" / "assets" / "panda"
    folder.mkdir(parents=True)
    text = "mtllib {0}.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\n"
    text += "usemtl Gray\nf 1//1 2//1 3//1\nusemtl Other\nf 1//1 2//1 4//1\n"
    for name in (*(f"link{k}" for k in range(8)), "hand", "finger"):
        (folder / f"{name}.obj").write_text(text.format(name))
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])  # syspath_prepend would keep what nothing_installed has set
    visuals = link_visuals(ulna.load("panda"))
    assert visuals.missing == ()
    colors = {tuple(mesh.visual.material.main_color[:3]) for mesh in visuals.scenes["panda_link3"].dump()}
    assert {min(color) for color in colors} == {64, 250}
    (folder / "link0.obj").write_text("v nan\nf 1 2 3\n")
    visuals = link_visuals(ulna.load("panda"))
    assert len(visuals.missing) == 1
    assert "link0.obj" in visuals.missing[0]
    assert "panda_link0" in visuals.scenes


def test_surface_nets_lie_on_the_surface_of_a_body():
    """A ball, a cylinder and a box of known volume; and a union and a cut of two balls."""
    axis = np.array([0.6, 0.0, 0.8])
    ball = cone(np.zeros(3), np.zeros(3), 0.1, 0.1)
    for body, volume in (
        (ball, 4 / 3 * np.pi * 1e-3),
        (drum(np.ones(3), axis, 0.1, 0.15, 1e-3), np.pi * 0.01 * 0.3),
        (box(np.ones(3), np.eye(3), np.array([0.1, 0.2, 0.05]), 1e-3), 0.2 * 0.4 * 0.1),
        (union([ball, cone(np.full(3, 0.5), np.full(3, 0.5), 0.1, 0.1)], 0.05), 8 / 3 * np.pi * 1e-3),
        (cut(ball, [cone(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]), 1.0, 1.0)], 0.0), 2 / 3 * np.pi * 1e-3),
    ):
        mesh = mesh_of(body, 0.01)
        assert is_closed(mesh)
        assert mesh.volume == pytest.approx(volume, rel=0.06)
    mesh = mesh_of(ball, 0.01)
    assert np.linalg.norm(mesh.vertices, axis=1) == pytest.approx(0.1, abs=1e-4)
    assert mesh_of(cut(ball, [cone(np.zeros(3), np.zeros(3), 0.2, 0.2)], 0.0), 0.01) is None


@pytest.mark.parametrize(
    ("name", "link", "beside"),
    [("ur10e", "upper_arm_link", 0.18), ("ur10e", "forearm_link", 0.04), ("crx10ia", "J2_link", -0.19)],
)
def test_a_link_that_runs_beside_its_joints_is_drawn_where_its_shapes_are(name, link, beside):
    """Halfway between its two parallel axes, along which it is shifted by so much [m]; z is the axis of a UR, y of the CRX."""
    robot, scenes = drawn(name)
    joint = next(joint for joint in robot.description.joints if joint.parent == link)
    carrier = next(joint for joint in robot.description.joints if joint.child == link)
    places = scenes[link].to_mesh().vertices
    way = joint.origin[:3, 3] - carrier.axis * (carrier.axis @ joint.origin[:3, 3])
    along = places @ way / (way @ way)
    middle = places[(along > 0.4) & (along < 0.6)] @ carrier.axis
    assert abs((middle.min() + middle.max()) / 2 - beside) < 0.03


def test_the_foot_of_a_link_that_only_turns_the_base_is_not_below_the_floor():
    _, scenes = drawn("ur10e")
    for link in ("base_link", "base_link_inertia"):
        assert scenes[link].bounds[0, 2] > -0.005
