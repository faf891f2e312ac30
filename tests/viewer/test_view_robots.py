"""The view of any robot: humanoids, robots with missing meshes, and hostile descriptions."""

import importlib
import threading

import numpy as np
import pytest

import robots
import ulna
from processes import wait_for
from ulna.viewer.arm import Arm
from ulna.viewer.page import Page
from ulna.viewer.palette import FREE, TOUCHING
from ulna.viewer.visuals import link_visuals

LINK = '<link name="{}">{}</link>'
JOINT = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'


def one_link(*uris):
    meshes = "".join(f'<visual><geometry><mesh filename="{uri}"/></geometry></visual>' for uri in uris)
    box = '<visual><geometry><box size="1 2 3"/></geometry></visual>'
    return f'<robot name="a">{LINK.format("a", meshes)}{LINK.format("b", box)}{JOINT}</robot>'


@pytest.mark.parametrize(("name", "links"), [("talos", 60), ("ur5", 11)])
def test_all_meshes_of_a_robot_are_shown(name, links):
    robot = ulna.load(name)
    with ulna.view(robot) as view:
        assert view.arm.missing == ()
        assert len(view.arm.frames) == links
        assert len(view.arm.looks) == sum(bool(link.visuals) for link in robot.description.links)
        assert len(view.arm.solids) == sum(len(link.collisions) for link in robot.description.links)
        wait_for(lambda: "checking" not in view.clearance.state.content, "the state")
        assert ("not checked" in view.clearance.state.content) == bool(view.session.unchecked)
        assert view.arm.extent.low[2] <= min(T[2, 3] for T in robot.link_poses(robot.home))


def test_the_camera_distance_follows_the_size_of_the_robot():
    large, small = (ulna.Robot(robots.of_chain("revolute", "revolute", origin=ulna.pose((step, 0, 0)))) for step in (10.0, 0.01))
    for robot, size in ((large, 20.0), (small, 0.02)):
        with ulna.view(robot) as view:
            away = np.linalg.norm(np.subtract(view.page.server.initial_camera.position, view.arm.extent.center))
            assert 0.5 * size < away < 10 * max(size, 0.1)


def test_only_a_link_with_a_missing_mesh_gets_the_plain_body():
    visuals = link_visuals(ulna.load(one_link("package://nowhere/x.stl")))
    assert len(visuals.missing) == 1
    assert "package://nowhere/x.stl" in visuals.missing[0]
    assert np.allclose(visuals.scenes["b"].extents, (1, 2, 3))
    assert "a" in visuals.scenes


@pytest.mark.parametrize("uri", ["file:///etc/passwd", "../../../../../../etc/passwd", "/etc/passwd"])
def test_a_mesh_path_outside_the_description_is_not_read(uri, tmp_path):
    (tmp_path / "a.urdf").write_text(one_link(uri))
    visuals = link_visuals(ulna.load(tmp_path / "a.urdf"))
    assert len(visuals.missing) == 1
    assert "not read" in visuals.missing[0]


def test_an_invalid_mesh_is_reported_and_the_other_links_are_shown(tmp_path):
    (tmp_path / "bad.stl").write_bytes(b"\x00" * 90)
    (tmp_path / "worse.dae").write_text("<COLLADA/>")
    (tmp_path / "a.urdf").write_text(one_link("bad.stl", "worse.dae"))
    visuals = link_visuals(ulna.load(tmp_path / "a.urdf"))
    assert len(visuals.missing) == 1
    assert "b" in visuals.scenes


def test_the_color_of_the_urdf_is_used_for_meshes_without_one(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    text = one_link("a.obj").replace(
        "</geometry></visual>", '</geometry><material name="m"><color rgba="1 0 0 1"/></material></visual>', 1
    )
    (tmp_path / "a.urdf").write_text(text)
    scene = link_visuals(ulna.load(tmp_path / "a.urdf")).scenes["a"]
    (mesh,) = scene.geometry.values()
    assert tuple(mesh.visual.material.baseColorFactor) == (255, 0, 0, 255)


@pytest.mark.slow
def test_every_collision_shape_can_be_drawn():
    page = Page(port=0)
    try:
        arm = Arm(page.server, ulna.load("panda"))
        assert sorted(arm.solids) == sorted(ulna.load("panda").collision_names)
    finally:
        page.stop()
    world = ulna.World()
    points = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    shapes = (
        ulna.Box((1, 1, 1)),
        ulna.Sphere(1),
        ulna.Cylinder(1, 1),
        ulna.Capsule(1, 1),
        ulna.HalfSpace(),
        ulna.ConvexMesh(points),
        ulna.ConvexMesh(points[:3]),
    )
    for k, shape in enumerate(shapes):
        world.add(f"{k}", shape, ulna.pose((5.0 * k, 0, -3)))
    with ulna.view(ulna.load("panda"), world) as view:
        view.obstacles.show(set())
        assert set(view.obstacles.nodes) == set(world.names)


def test_an_attached_object_is_drawn_on_its_link_and_is_red_when_it_touches(panda):
    above = ulna.pose((0, 0, 0.08), (0, 0, 0.5))
    holding = panda.with_attached("cup", ulna.Box((0.06, 0.06, 0.12)), above, touch_links=["panda_link7"])
    page = Page(port=0)
    try:
        arm = Arm(page.server, holding)
        cup = arm.attached["cup"]
        assert cup.name.startswith(arm.frames[holding.link_names.index(holding.attached[0].link)].name + "/")
        np.testing.assert_allclose(ulna.pose(cup.position, wxyz=cup.wxyz), above, atol=1e-12)
        assert set(arm.solids) | set(arm.attached) == set(holding.collision_names)
        arm.show_solids(visible=False)  # as the page of `ulna view` has it at first
        assert cup.visible
        arm.mark_touching(["cup"])
        assert cup.color == TOUCHING
        arm.mark_touching([])
        assert cup.color == FREE
    finally:
        page.stop()


@pytest.mark.parametrize("kinds", [("planar", "floating", "continuous"), ("fixed",)])
def test_joints_of_every_type_can_be_viewed(kinds):
    robot = ulna.Robot(robots.of_chain(*kinds))
    with ulna.view(robot) as view:
        assert len(view.joints.sliders) == robot.n_dof
        view.q = np.full(robot.n_dof, 0.2)
        assert np.array_equal(view.q, np.full(robot.n_dof, 0.2))


def test_a_view_that_cannot_be_built_leaves_no_thread(panda, monkeypatch):
    before = threading.active_count()
    monkeypatch.setattr(importlib.import_module("ulna.viewer.view"), "Arm", lambda *_: 1 / 0)  # another test forgets modules
    with pytest.raises(ZeroDivisionError):
        ulna.view(panda)
    assert threading.active_count() <= before


@pytest.mark.parametrize(("robot", "q"), [("panda", None), (ulna.load("panda"), np.full(7, 2e6)), (ulna.load("panda"), [0.0])])
def test_bad_arguments_are_refused_before_a_page_is_opened(robot, q, monkeypatch):
    monkeypatch.setattr(importlib.import_module("ulna.viewer.view"), "Page", lambda *_, **__: pytest.fail("a page was opened"))
    with pytest.raises(ulna.InputError):
        ulna.view(robot, q=q)
