"""Files that a person uploads as obstacles: meshes, points, and files that cannot be read."""

import io

import numpy as np
import pytest
import trimesh

import ulna
from ulna.collision.scene_file import LONGEST, world_to_json
from ulna.viewer import uploads
from ulna.viewer.uploads import shapes_of_file

POINTS = np.array([(0.5, 0.25, 1.0), (1.5, -0.5, 2.0), (0.125, 0.0, 0.75)])


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def pcd(form, body, fields="x y z", size="4 4 4", kind="F F F", n=3):
    count = " ".join("1" for _ in fields.split())
    head = f"VERSION 0.7\nFIELDS {fields}\nSIZE {size}\nTYPE {kind}\nCOUNT {count}\nWIDTH {n}\nHEIGHT 1\nPOINTS {n}\n"
    return f"# .PCD\n{head}DATA {form}\n".encode() + body


def rows(separator, extra=""):
    return "".join(separator.join(map(str, point)) + extra + "\n" for point in POINTS).encode()


COLORED = np.array([(7, *point) for point in POINTS], np.dtype([("rgb", "<u4"), ("x", "<f8"), ("y", "<f8"), ("z", "<f8")]))
CLOUDS = {
    "a.npy": npy(POINTS),
    "image.npy": npy(POINTS.reshape(1, 3, 3).astype(np.float32)),
    "a.xyz": rows(" ", " 255 0 0"),
    "a.csv": b"x,y,z\n" + rows(","),
    "b.csv": b"# made by hand\n" + rows("; "),
    "a.ply": trimesh.PointCloud(POINTS).export(file_type="ply"),
    "text.ply": trimesh.PointCloud(POINTS).export(file_type="ply", encoding="ascii"),
    "a.pcd": pcd("ascii", rows(" ")),
    "b.PCD": pcd("binary", POINTS.astype("<f4").tobytes()),
    "c.pcd": pcd("binary", COLORED.tobytes(), "rgb x y z", "4 8 8 8", "U F F F"),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_a_file_of_points_is_a_cloud(name):
    (cloud,) = shapes_of_file(name, CLOUDS[name], scale=0.5)
    assert isinstance(cloud, ulna.PointCloud)
    assert np.allclose(cloud.points, POINTS / 2, atol=1e-7)
    assert cloud.radius == uploads.RADIUS


@pytest.mark.parametrize("kind", ["stl", "obj", "dae", "ply"])
def test_a_mesh_is_its_convex_hull(kind):
    horn = trimesh.creation.annulus(0.1, 0.2, 0.3, sections=12)
    (hull,) = shapes_of_file(f"horn.{kind.upper()}", _bytes(horn.export(file_type=kind)), scale=1e-3)
    assert isinstance(hull, ulna.ConvexMesh)
    assert np.allclose(np.ptp(hull.vertices, axis=0), 1e-3 * horn.extents, atol=1e-9)


def test_a_mesh_is_its_convex_pieces(monkeypatch):
    said = []
    halves = [np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (k, k + 1)], float) for k in (0, 1)]

    def pieces_of_file(path, announce):
        assert path.suffix == ".stl"
        announce("...")
        return type("Pieces", (), {"points": halves})

    monkeypatch.setattr(uploads, "pieces_of_file", pieces_of_file)
    shapes = shapes_of_file("a.stl", b"", scale=0.1, pieces=True, announce=said.append)
    assert [shape.vertices.max(axis=0).tolist() for shape in shapes] == [[0.1, 0.1, 0.1], [0.1, 0.1, 0.2]]
    assert said == ["..."]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.exe", b"", "ends in none of .stl, .obj, .dae"),
        ("a", b"", "ends in none of"),
        ("a.stl", b"solid nothing", "a.stl: cannot be read"),
        ("a.obj", b"v 0 0 0\n", "a.obj: cannot be read: it has no triangles"),
        ("a.npy", b"not an array", "a.npy: cannot be read"),
        ("a.npy", npy(np.array([{}], dtype=object)), "cannot be read: it has Python objects, whose reading can run code"),
        ("a.npy", npy(np.zeros((4, 2))), r"shape \(4, 2\)"),
        ("a.npy", npy(np.zeros(6)), r"shape \(6,\)"),
        (
            "a.npy",
            b"\x93NUMPY\x01\x00v\x00" + b"{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999999, 3)}".ljust(118),
            "a.npy",
        ),
        ("a.xyz", b"", "a.xyz: has an array of shape"),
        ("a.xyz", b"1 2 3\n1 two 3\n", "'two' to float64 at row 1"),
        ("a.csv", b"1,2\n", "cannot be read"),
        ("a.csv", b"1,2,inf\n", "finite|infinite"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", "a.ply: cannot be read"),
        ("a.pcd", b"FIELDS x y z\n", "it has no line DATA"),
        ("a.pcd", pcd("binary_compressed", b""), "its points are binary_compressed; ascii and binary are read"),
        ("a.pcd", pcd("binary", b"\0" * 24), "2 of its 3 points"),
        ("a.pcd", pcd("ascii", b"1 2 3\n"), "1 of its 3 points"),
        ("a.csv", b"1e9,0,0\n", "points"),
    ],
)
def test_a_bad_file_has_an_error_with_its_name_or_its_fault(name, content, words):
    with pytest.raises(ulna.UlnaError, match=words) as error:
        shapes_of_file(name, content)
    assert "ulna-" not in str(error.value)  # the temporary folder


def test_a_scene_file_holds_as_many_points_as_a_page_takes(rng):
    world = ulna.World()
    world.add("longest", ulna.PointCloud(-rng.uniform(1e-4, 1e-3, (1000, 3)), 0.01))  # numbers of the most digits
    assert len(world_to_json(world)) * uploads.MAX_POINTS / 1000 < LONGEST


def test_too_long_a_file_and_too_many_points_are_refused(monkeypatch):
    monkeypatch.setattr(uploads, "MAX_POINTS", 2)
    with pytest.raises(ulna.FileError, match="3 points; the page takes at most 2"):
        shapes_of_file("a.npy", npy(POINTS))
    monkeypatch.setattr(uploads, "MAX_BYTES", 10)
    with pytest.raises(ulna.FileError, match="larger than 0 MB"):
        shapes_of_file("a.npy", npy(POINTS))


def _bytes(content):
    return content.encode() if isinstance(content, str) else content
