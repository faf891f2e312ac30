"""``robot.with_convex_hulls()``: the convex hulls of a robot's mesh files; files that cannot be read are refused."""

import os
import pickle
import sys

import numpy as np
import pytest

import ulna
from assertions import assert_close
from ulna.description.meshes.hulls import mesh_reader

# A pyramid of 2 x 2 x 1, and a point within it.
PYRAMID = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nv 0 0 0.1\nf 1 2 5\nf 3 4 6\n"
ARM = """<robot name="r"><link name="base"/>
  <link name="part">
    <visual><geometry><mesh filename="part.obj"/></geometry></visual>
    <collision name="pyramid"><origin xyz="0 0 5"/><geometry><mesh filename="{name}" scale="{scale}"/></geometry></collision>
    <collision name="ball"><origin xyz="0 9 0"/><geometry><sphere radius="0.5"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="part"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" velocity="1" effort="1"/></joint></robot>"""


@pytest.fixture
def make(tmp_path):
    """Writes ``ARM`` and a mesh file beside it, and loads the robot."""

    def robot(text=PYRAMID, name="part.obj", scale="1 1 1"):
        if text is not None:
            (tmp_path / name).write_text(text)
        (tmp_path / "arm.urdf").write_text(ARM.format(name=name, scale=scale))
        return ulna.load(tmp_path / "arm.urdf")

    return robot


def gap(robot, z):
    """The distance to a small ball on the axis of the pyramid at a height."""
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0, 0, z)))
    return robot.signed_distance([0.0], world)


def test_an_unconverted_mesh_is_refused_and_the_error_names_what_takes_its_hull(make):
    with pytest.raises(ulna.GeometryError, match=r"pyramid.*; ulna\.load\(\.\.\., meshes='hulls'\).*with_convex_hulls"):
        make().in_collision([0.0])


def test_the_hull_has_the_pose_of_the_mesh(make):
    robot = make().with_convex_hulls()
    assert gap(robot, 6.5) == pytest.approx(0.4, abs=1e-6)  # above the tip, at 6
    assert gap(robot, 4.7) == pytest.approx(0.2, abs=1e-6)  # below the base, at 5
    assert robot.collision_names == ("pyramid", "ball")


def test_the_hull_has_only_corners_and_other_shapes_are_unchanged(make):
    before = make()
    after = before.with_convex_hulls()
    hull, ball = (body.shape for body in after.description.links[1].collisions)
    assert len(hull.vertices) == 5
    assert ball == ulna.Sphere(0.5)
    assert after.description.links[1].visuals == before.description.links[1].visuals
    assert after.to_urdf() == before.to_urdf()


def test_the_hull_is_scaled_and_a_negative_scale_mirrors(make):
    robot = make(scale="0.1 0.1 -2").with_convex_hulls()
    assert gap(robot, 2.5) == pytest.approx(0.4, abs=1e-6)  # below the tip, at 5 - 2
    assert gap(robot, 5.4) == pytest.approx(0.3, abs=1e-6)


def test_a_flat_mesh_has_a_flat_hull(make):
    robot = make("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n").with_convex_hulls()
    assert gap(robot, 5.4) == pytest.approx(0.3, abs=1e-6)


def test_a_changed_file_is_read_again_even_with_the_same_time(make, tmp_path):
    before = make()
    os.utime(tmp_path / "part.obj", (1, 1))
    assert gap(before.with_convex_hulls(), 6.5) == pytest.approx(0.4, abs=1e-6)
    changed = make(PYRAMID.replace("0 0 1", "0 0 1.2"))
    os.utime(tmp_path / "part.obj", (1, 1))
    assert gap(changed.with_convex_hulls(), 6.5) == pytest.approx(0.2, abs=1e-6)


def test_the_same_relative_name_in_two_folders_gives_two_hulls(tmp_path, monkeypatch):
    widths = []
    for width in ("1", "10"):
        folder = tmp_path / width
        folder.mkdir()
        (folder / "part.obj").write_text(PYRAMID.replace("v 1", f"v {width}"))
        (folder / "arm.urdf").write_text(ARM.format(name="part.obj", scale="1 1 1"))
        os.utime(folder / "part.obj", (1, 1))
        monkeypatch.chdir(folder)
        hull = ulna.load("arm.urdf").with_convex_hulls().description.links[1].collisions[0].shape
        widths.append(hull.vertices[:, 0].max())
    assert widths == [1, 10]


def test_files_of_the_same_content_and_scale_share_a_hull(make):
    hulls = [
        make(name=name, scale=scale).with_convex_hulls()
        for name, scale in (("a.obj", "1 1 1"), ("b.obj", "1 1 1"), ("a.obj", "1 1 2"))
    ]
    first, copy, stretched = (robot.description.links[1].collisions[0].shape for robot in hulls)
    assert copy is first
    assert stretched.vertices[:, 2].max() == 2 * first.vertices[:, 2].max()


def test_attached_objects_are_kept(make):
    robot = make().with_attached("cup", ulna.Sphere(0.1), np.eye(4)).with_convex_hulls()
    assert [held.name for held in robot.attached] == ["cup"]


def test_a_robot_with_hulls_can_be_pickled(make):
    robot = make().with_convex_hulls()
    assert_close(gap(pickle.loads(pickle.dumps(robot)), 6.5), gap(robot, 6.5))  # noqa: S301


@pytest.mark.parametrize(
    ("text", "name", "words"),
    [
        (None, "lost.obj", r"lost\.obj: no such file; tried .*lost\.obj"),
        ("v 0 0 0", "part.obj", r"part\.obj: the collision mesh 'pyramid' of link 'part' cannot be read: it has no triangles"),
        ("v 0 0 nan\nv 1 0 0", "part.obj", r"not .*finite"),
        ("<COLLADA", "part.dae", r"cannot be read: "),
        ("x", "part.glb", r"'\.glb', which is not read for collision checking, only \.stl, \.obj, \.dae"),
        ("v 0 0 1e9\nv 1 0 0\nv 0 1 0\nf 1 2 3", "part.obj", r"at most 1e\+06 m"),
    ],
)
def test_a_mesh_that_cannot_be_read_is_refused_with_its_file(make, text, name, words):
    with pytest.raises(ulna.FileError, match=words):
        make(text, name).with_convex_hulls()


def test_a_mesh_outside_the_description_folder_is_not_read(make, tmp_path):
    (tmp_path.parent / "elsewhere.obj").write_text(PYRAMID)
    for name in ("../elsewhere.obj", f"file://{tmp_path.parent}/elsewhere.obj"):
        with pytest.raises(ulna.FileError, match=r"lies outside the description's folder"):
            make(None, name).with_convex_hulls()


@pytest.mark.parametrize("missing", ["scipy.spatial", "trimesh", "collada"])
def test_a_missing_package_is_an_error_that_names_the_extra(make, monkeypatch, missing):
    mesh_reader.cache_clear()
    monkeypatch.delitem(sys.modules, "ulna.description.meshes.reader", raising=False)
    monkeypatch.delattr("ulna.description.meshes.reader", raising=False)
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(ulna.MissingExtraError, match=r"needs the hulls extra: pip install "):
        make(scale="3 1 1").with_convex_hulls()


def test_a_robot_without_meshes_is_unchanged(panda):
    assert panda.with_convex_hulls().collision_names == panda.collision_names
