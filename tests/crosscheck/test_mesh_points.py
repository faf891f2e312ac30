"""The points of a mesh, by the box around them, against trimesh: every mesh of a few robots, in the three kinds of files."""

import re

import numpy as np
import pytest

from assertions import assert_close
from robot_files import EXAMPLES
from ulna.description.meshes.points import mesh_points

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("collada")

MESHES = [
    path
    for robot in (
        "panda_description",
        "ur_description",
        "kinova_description",
        "quadruped_description",
        "double_pendulum_description",
    )
    for path in sorted((EXAMPLES / robot).rglob("*"))
    if path.suffix.lower() in (".stl", ".obj", ".dae") and path.stat().st_size < 1_000_000
]
# Two nodes, one turned and moved within the other, in centimetres: the scene decides where the square is.
SQUARE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="s"><float_array id="f" count="9">0 0 0 10 0 0 0 20 0</float_array></source>
    <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
  </mesh></geometry></library_geometries>
  <library_nodes><node id="part"><scale>1 1 3</scale><rotate>0 1 0 90</rotate><instance_geometry url="#g"/></node></library_nodes>
  <library_visual_scenes><visual_scene id="w">
    <node><translate>0 0 5</translate><node><instance_node url="#part"/></node></node>
    <node><matrix>2 0 0 0  0 2 0 0  0 0 2 0  0 0 0 1</matrix><instance_geometry url="#g"/></node>
  </visual_scene></library_visual_scenes>
</COLLADA>"""


def test_there_are_meshes_of_every_kind():
    assert {path.suffix.lower() for path in MESHES} >= {".stl", ".dae"}
    assert len(MESHES) > 20


def mesh_extents(path):
    return np.ptp(mesh_points(path), axis=0)


@pytest.mark.filterwarnings("ignore")  # of trimesh
@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.name)
def test_a_mesh_is_as_large_as_trimesh_says(path):
    scene = trimesh.load_scene(path)
    expected = np.ptp(scene.to_geometry().vertices, axis=0)
    metres = 1.0
    if path.suffix.lower() == ".dae":
        metres = float(re.search(rb'unit[^>]*meter="([^"]+)"', path.read_bytes())[1])
    measured = mesh_extents(path) / metres  # trimesh leaves a Collada file in its own unit
    assert_close(measured, expected, atol=1e-6 * expected.max())


def test_a_collada_scene_is_put_together_from_its_nodes(tmp_path):
    path = tmp_path / "square.dae"
    path.write_text(SQUARE)
    # The part: x turns to -z, three times as long: z from 5 - 30 to 5; the other: x to 20, y to 40.
    assert_close(mesh_extents(path), [0.2, 0.4, 0.3], atol=1e-12)


def test_an_obj_file_is_read_by_its_vertices(tmp_path):
    path = tmp_path / "wedge.obj"
    path.write_text("# wedge\nv 1 2 3\nvn 9 9 9\nv -1 2.5 3e-1 1.0\nvt 7 7\nf 1 2 1\n")
    assert_close(mesh_extents(path), [2.0, 0.5, 2.7], atol=1e-15)


@pytest.mark.parametrize("loop", ['<node id="a"><instance_node url="#a"/></node>', "<node>" * 80 + "</node>" * 80])
def test_a_scene_without_end_is_refused(tmp_path, loop):
    path = tmp_path / "loop.dae"
    path.write_text(f"<COLLADA><library_visual_scenes><visual_scene>{loop}</visual_scene></library_visual_scenes></COLLADA>")
    with pytest.raises(ValueError, match=r"nested too deep"):
        mesh_extents(path)
