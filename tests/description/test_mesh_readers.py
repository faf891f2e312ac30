"""A mesh file is read completely or refused; collision checking and drawing use the same triangles."""

import tracemalloc

import numpy as np
import pytest
import trimesh

import ulna
from assertions import assert_close
from mesh_texts import ACCESSOR, CORNERS, FACES, INSTANCE, TRIANGLES, collada, doubled, stl
from ulna.description.meshes.mesh_files import MeshFiles
from ulna.description.meshes.obj import rewritten_obj
from ulna.description.meshes.reader import MAX_BYTES, NeighborFiles, mesh_bytes, read_scene, used_points
from ulna.errors import FileError
from ulna.viewer.visuals import link_visuals

ROBOT = """<robot name="x"><link name="l">
  <visual><geometry><mesh filename="{0}"/></geometry></visual>
  <collision><geometry><mesh filename="{0}"/></geometry></collision></link></robot>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
TETRAHEDRON = [(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0)]


@pytest.fixture
def points(tmp_path):
    """The distinct points of a file's triangles, sorted, shape (n, 3)."""

    def read(name, content):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return np.unique(used_points(read_scene(path, mesh_bytes(path))).round(6) + 0.0, axis=0)

    return read


@pytest.mark.parametrize(
    "text",
    [
        OBJ,
        OBJ.replace("\n", "\r"),
        OBJ.replace("\n", "\r\n"),
        "\ufeff" + OBJ,
        OBJ.replace("v 0 0 1", "v 0 \\\n 0 1"),
        OBJ.replace("\n", "\n  \t"),
        OBJ.replace("v", "v \t"),
        OBJ.replace("f 2 3 4", "f -3 -2 -1\nv 9 9 9"),  # counted back from where it stands, not from the end of the file
        OBJ.replace("v 0 0 1", "v 0 0 2 2"),  # homogeneous, as Assimp reads it
        OBJ.replace("v 0 0 1", "v 0 0 1 0.1 0.2 0.3"),  # one of them with a color
        OBJ.replace("v 0 0 1", "v 0 0 10e-1"),
        OBJ.replace("f 2 3 4", "f 2/1/1 3/1/1 4//1\nvt 0 0\nvn 0 0 1"),
        OBJ.replace("f 1 3 2\n", "f 1 3 2 2\nl 1 2\n# v 5 5 5\nusemtl f\ng v 5 5 5\n"),
        OBJ + "v 7 7 7\n",  # used by no face
        "mtllib /etc/passwd\n" + OBJ,
        OBJ.encode() + b"o caf\xe9\n",
    ],
)
def test_an_obj_file_is_read_in_every_notation(points, text):
    assert_close(points("part.obj", text), TETRAHEDRON, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (OBJ.replace("v 0 0 1", "v 0 1"), "line 4: '0 1' is not a vertex"),
        (OBJ.replace("v 0 0 1", "v 0 0 nan"), "not a vertex of finite numbers"),
        (OBJ.replace("v 0 0 1", "v 0 0 x"), "not a vertex"),
        (OBJ.replace("f 2 3 4", "f 2 3 5"), "refers to vertex 5; there are 4"),
        (OBJ.replace("f 2 3 4", "f 0 3 4"), "line 8: '0' is not a corner"),
        (OBJ.replace("f 2 3 4", "f -5 3 4"), "'-5' is not a corner"),
        (OBJ.replace("f 2 3 4", "surf 0 1 0 1 2 3 4"), "curved surfaces"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", "no triangles"),
        ("", "no triangles"),
    ],
)
def test_a_damaged_obj_file_is_refused(points, text, words):
    with pytest.raises(FileError, match=words):
        points("part.obj", text)


def binary(text):
    """The STL file in binary, by trimesh."""
    return trimesh.load_mesh(trimesh.util.wrap_as_stream(text), file_type="stl").export(file_type="stl")


@pytest.mark.parametrize(
    "content",
    [
        stl(),
        stl().upper(),
        stl().replace("\n", "\r"),
        stl(name="vertex solid facet"),
        stl().replace("vertex", "\tvertex  "),
        stl() + stl(name="again"),
        binary(stl()),
        b"solid" + binary(stl())[5:],
    ],
)
def test_an_stl_file_is_read_in_every_notation(points, content):
    assert_close(points("part.stl", content), TETRAHEDRON, atol=1e-6)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (binary(stl()) + b"\0", "not an STL file"),
        (binary(stl())[:-1], "not an STL file"),
        (stl()[:200], "cut off"),
        (stl().replace("vertex 1 0 0\n", "", 1), "cut off"),
        (stl().replace("vertex 1 0 0", "vertex 1 0 o"), "could not convert"),
        (stl().replace("vertex 1 0 0", "vertex 1 0 nan"), "not finite"),
        (stl().replace("vertex 1 0 0", "vertex 1 0 1e99"), "not finite"),
        ("solid s\nendsolid s", "no triangles"),
        (b"", "not an STL file"),
    ],
)
def test_a_damaged_stl_file_is_refused(points, content, words):
    with pytest.raises(FileError, match=words):
        points("part.stl", content)


STRIDED = ACCESSOR.replace('stride="3"', 'stride="5" offset="1"')
NAMELESS = ACCESSOR.replace('<param name="Y"', '<param type="float"/><param name="Y"').replace('stride="3"', 'stride="4"')
POLYLIST = (
    '<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 4</vcount><p>0 1 2 0 1 3 2</p></polylist>'
)


@pytest.mark.parametrize(
    "text",
    [
        collada(),
        collada(array=f"{CORNERS} 9 9 9", accessor=ACCESSOR.replace('"4"', '"5"')),  # a point that no triangle uses
        collada(array="7 0 0 0 7 7 1 0 0 7 7 0 1 0 7 7 0 0 1 7", accessor=STRIDED),
        collada(array="0 7 0 0 1 7 0 0 0 7 1 0 0 7 0 1", accessor=NAMELESS),
        collada(primitives=POLYLIST),
        collada(asset="<up_axis>Y_UP</up_axis>"),  # passed over, as RViz does
        collada(f"<node><camera/><lookat>1 2 3 0 0 0 0 0 1</lookat></node><node>{INSTANCE}</node>"),
        collada(f"<node><node><rotate>0 0 0 5</rotate>{INSTANCE}</node></node>"),
    ],
)
def test_a_collada_file_is_read_in_every_notation(points, text):
    assert_close(points("part.dae", text), TETRAHEDRON, atol=1e-6)


def test_nested_nodes_and_units_of_a_collada_scene_are_applied(points):
    part = f'<library_nodes><node id="part"><scale>1 1 3</scale><rotate>0 1 0 90</rotate>{INSTANCE}</node></library_nodes>'
    nodes = '<node><translate>0 0 5</translate><node><instance_node url="#part"/></node></node>'
    nodes += f"<node><matrix>2 0 0 0  0 2 0 0  0 0 2 0  0 0 0 1</matrix>{INSTANCE}</node>"
    found = points("part.dae", collada(nodes, asset='<unit name="centimeter" meter="0.01"/>', libraries=part))
    # The part: x turns to -z, three times as long: z from 5 - 3 to 5; the other: x, y and z to 2.
    assert_close(np.ptp(found, axis=0), [0.02, 0.02, 0.05], atol=1e-6)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (doubled(40), "1099511627776 instances of geometries"),
        (collada(f"<node><rotate>1 0 0</rotate>{INSTANCE}</node>"), "<rotate> has 3 numbers; 4"),
        (collada(f"<node><lookat>0 0 0 1 0 0 0 0 1</lookat>{INSTANCE}</node>"), "placed by <lookat>"),
        (collada(f"<node><skew>0 0 0 1 0 0 0</skew>{INSTANCE}</node>"), "placed by <skew>"),
        (collada('<node><instance_controller url="#c"/></node>'), "instance_controller"),
        (collada('<node><instance_geometry url="#lost"/></node>'), "'lost', which is not in the file"),
        (collada('<node><instance_geometry url="other.dae#g"/></node>'), "'other.dae#g', which is not in the file"),
        (collada('<node><instance_node url="#lost"/></node>'), "'lost', which is not in the file"),
        (collada('<node id="a"><instance_node url="#a"/></node>' + f"<node>{INSTANCE}</node>"), "refers to itself"),
        (collada("<node>" * 80 + INSTANCE + "</node>" * 80), "nested too deep"),
        (collada(primitives=TRIANGLES.replace("triangles", "tristrips")), "tristrips, which are not read"),
        (collada(primitives=TRIANGLES.replace(FACES, FACES.replace("3", "4"))), "no triangles"),
        (collada(array=CORNERS.replace("1", "nan", 1)), "not finite"),
        (collada(array=CORNERS.replace("1", "x", 1)), "not numbers"),
        (collada(array=CORNERS[:-2]), "beyond its array"),
        (collada(accessor=ACCESSOR.replace('"4"', '"4000000000000"')), "beyond its array"),
        (collada(shown=""), "has no scene"),
        (collada("<node/>"), "shows no geometry"),
        (collada(asset='<unit meter="0"/>'), "its unit is 0 m"),
        (collada().replace("<asset>", "<!-- --><asset>", 1)[:-9], "cannot be read"),
        ('<!DOCTYPE a [<!ENTITY b "c">]>' + collada(), "document type"),
    ],
)
def test_a_damaged_or_unsupported_collada_file_is_refused(tmp_path, text, words):
    (tmp_path / "part.dae").write_text(text)
    (tmp_path / "r.urdf").write_text(ROBOT.format("part.dae"))
    robot = ulna.load(tmp_path / "r.urdf")
    with pytest.raises(FileError, match=words) as refusal:
        robot.with_convex_hulls()
    assert "part.dae" in str(refusal.value)
    assert words in link_visuals(robot).missing[0]
    assert words in " ".join(finding.message for finding in ulna.inspect(tmp_path / "r.urdf").findings)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("part.dae", collada(asset='<unit meter="0.01"/><up_axis>Y_UP</up_axis>')),
        ("part.dae", collada(array=f"{CORNERS} 9 9 9", accessor=ACCESSOR.replace('"4"', '"5"'))),
        ("part.obj", OBJ.replace("\n", "\r") + "v 7 7 7\r"),
        ("part.stl", stl(name="vertex")),
    ],
)
def test_the_hull_and_the_visual_of_a_mesh_have_the_same_bounds(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    (tmp_path / "r.urdf").write_text(ROBOT.format(name))
    robot = ulna.load(tmp_path / "r.urdf")
    hull = robot.with_convex_hulls().description.links[0].collisions[0].shape.vertices
    assert_close(np.array([hull.min(axis=0), hull.max(axis=0)]), link_visuals(robot).scenes["l"].bounds, atol=1e-7)


def test_a_mesh_with_a_missing_material_is_read(tmp_path):
    bound = INSTANCE.replace("/>", "><bind_material><technique_common>") + (
        '<instance_material symbol="m" target="#lost"/></technique_common></bind_material></instance_geometry>'
    )
    path = tmp_path / "part.dae"
    path.write_text(collada(f"<node>{bound}</node>"))
    files = MeshFiles(ulna.load(ROBOT.format("part.dae")).description)
    assert len(read_scene(path, mesh_bytes(path), NeighborFiles(files, path)).to_mesh().faces) == 4


def test_a_mesh_file_that_is_too_large_or_missing_is_refused(tmp_path):
    with (tmp_path / "sparse.stl").open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(FileError, match=r"more than 100 MB"):
        mesh_bytes(tmp_path / "sparse.stl")
    with pytest.raises(FileError, match="part"):
        mesh_bytes(tmp_path / "part.stl")


def test_too_many_triangles_are_refused_before_they_are_built(tmp_path, monkeypatch):
    monkeypatch.setattr("ulna.description.meshes.collada_scene.MAX_TRIANGLES", 15)
    path = tmp_path / "part.dae"
    path.write_text(doubled(2))
    with pytest.raises(FileError, match="16 triangles; up to 15"):
        read_scene(path, mesh_bytes(path))


def test_a_wavefront_file_takes_time_by_its_materials_and_not_by_how_often_they_change(tmp_path):
    """Each change was a part of its own, and the time grew by the square of their number. Of too many there is no color."""
    corners, path = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", tmp_path / "part.obj"
    changes = b"".join(b"usemtl m%d\nf 1 2 %d\n" % (k % 3, 3 + k % 2) for k in range(3000))
    text = rewritten_obj(corners + changes, materials=True).data
    assert (text.count(b"usemtl"), text.count(b"\nf ")) == (3, 3000)
    assert b"usemtl" not in rewritten_obj(corners + changes, materials=False).data
    many = corners + b"".join(b"usemtl m%d\nf 1 2 3\n" % k for k in range(50_000))
    with pytest.raises(ValueError, match="more than 1000 materials"):
        rewritten_obj(many, materials=True)
    path.write_bytes(many)
    files = MeshFiles(ulna.load("panda").description)
    assert len(read_scene(path, mesh_bytes(path), NeighborFiles(files, path)).to_mesh().faces) == 50_000


def test_a_wavefront_face_of_too_many_corners_is_refused_before_it_is_cut_into_triangles():
    """Of 10 MB, five million triangles were written out, in almost 1 GB."""
    data = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + b"1 " * 5_000_000 + b"\n"
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"^line 4: it has more than 4000000 triangles, the most that are read$"):
            rewritten_obj(data, materials=True)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 10 * len(data)
