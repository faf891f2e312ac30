"""``robot.with_convex_pieces()``: convex pieces that contain the whole mesh and leave its hollows free."""

import os
import sys
import tracemalloc

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import ulna
from ell_mesh import CORNERS, FACES, cache, robot_of_the_ell
from ulna.description.meshes import decompose, piece_cache
from ulna.description.meshes.piece_cache import Pieces
from ulna.description.meshes.pieces import pieces_of, sampled_excess

pytest.importorskip("coacd")
URDF = """<robot name="l"><link name="base"/><link name="part"><collision name="ell"><geometry>
  <mesh filename="ell.obj" scale="{}"/></geometry></collision></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="part"/></joint></robot>"""


__all__ = ["cache"]


@pytest.fixture
def make(tmp_path, cache):
    """The robot of an L-shaped mesh."""

    def robot(scale="1 1 1"):
        return robot_of_the_ell(tmp_path, URDF.format(scale))

    return robot


def touches(robot, place, radius=0.1):
    world = ulna.World()
    world.add("ball", ulna.Sphere(radius), ulna.pose(place))
    return robot.in_collision([], world)


@pytest.mark.slow
def test_a_hollow_is_free_with_pieces_and_filled_with_the_hull(make):
    robot = make()
    assert touches(robot.with_convex_hulls(), (1.4, 1.4, 0.5))
    pieces = robot.with_convex_pieces()
    assert not touches(pieces, (1.4, 1.4, 0.5))
    assert touches(pieces, (2.9, 0.5, 0.5))
    assert touches(pieces, (0.5, 2.9, 1.05))


def test_a_mirrored_and_stretched_mesh_has_mirrored_and_stretched_pieces(make):
    pieces = make("2 -1 1").with_convex_pieces()
    assert not touches(pieces, (2.8, -1.4, 0.5))
    assert touches(pieces, (5.8, -0.5, 0.5))


def test_each_piece_has_a_name_and_its_excess(make):
    bodies = make().with_convex_pieces().description.links[1].collisions
    assert [body.name for body in bodies] == [f"ell piece {k}" for k in range(1, len(bodies) + 1)]
    assert all(0 <= body.excess < 0.1 for body in bodies)


def test_load_accepts_the_known_values_of_meshes_only(make, tmp_path):
    make()
    hulls, pieces, none = (ulna.load(tmp_path / "ell.urdf", meshes=word) for word in ("hulls", "decompose", None))
    assert hulls.collision_names == ("ell",)
    assert len(pieces.collision_names) > 1
    assert isinstance(none.description.links[1].collisions[0].shape, ulna.Mesh)
    with pytest.raises(ulna.InputError, match=r"^meshes: 'hull' is not known; did you mean 'hulls'"):
        ulna.load(tmp_path / "ell.urdf", meshes="hull")


@pytest.mark.slow
def test_pieces_are_cached_by_content_and_a_damaged_file_is_replaced(make, cache, monkeypatch):
    first = make().with_convex_pieces()
    [kept] = cache.iterdir()
    with monkeypatch.context() as patch:
        patch.setattr(decompose, "_decomposed", None)  # not called
        again = make("1 1 2").with_convex_pieces()
    assert len(again.collision_names) == len(first.collision_names)
    kept.write_bytes(b"PK damaged")
    anew = make().with_convex_pieces()
    for one, other in zip(first.description.links[1].collisions, anew.description.links[1].collisions, strict=True):
        assert np.array_equal(one.shape.vertices, other.shape.vertices), "the seed is fixed"


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="folders of Windows have no modes")
def test_a_cache_folder_that_others_can_write_is_not_used(make, cache):
    piece_cache.write("name.npz", piece_cache.to_bytes(Pieces((np.zeros((1, 3)),), 0.0)))
    assert piece_cache.read("name.npz", piece_cache.from_bytes) is not None
    cache.parent.parent.chmod(0o777)
    assert piece_cache.read("name.npz", piece_cache.from_bytes) is None


def test_a_decomposition_beyond_the_time_limit_is_an_error(make, monkeypatch):
    monkeypatch.setattr(decompose, "TIME_LIMIT_S", 0.01)
    with pytest.raises(ulna.FileError, match=r"ell\.obj.*cannot be decomposed.*no end.*limits are 0\.01 s"):
        make().with_convex_pieces()


def test_without_coacd_the_extra_is_named(make, monkeypatch):
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setattr(decompose, "find_spec", lambda _: None)
    with pytest.raises(ulna.MissingExtraError, match=r"needs the decompose extra: pip install "):
        make().with_convex_pieces()


def test_the_pieces_contain_every_triangle_even_if_the_given_hulls_do_not():
    """The hulls are two boxes smaller than the L's arms, as CoACD may give them, since it remeshes the surface."""
    hulls = [CORNERS[CORNERS[:, 1] <= 1] * 0.98, CORNERS[CORNERS[:, 0] <= 1] * 0.98]
    pieces = [ConvexHull(points).equations for points in pieces_of(CORNERS, FACES, hulls)]
    shares = np.random.default_rng(0).dirichlet((1, 1, 1), (500, len(FACES)))
    points = np.einsum("nfk,fkd->nfd", shares, CORNERS[FACES]).reshape(-1, 3)
    outside = np.min([(points @ planes[:, :3].T + planes[:, 3]).max(axis=1) for planes in pieces], axis=0)
    assert outside.max() < 1e-9


def test_the_excess_of_the_hull_of_an_l_is_the_depth_of_its_hollow():
    """The point of the hull farthest from the L is (2, 2), the middle of its side from (3, 1) to (1, 3): 1 m from the L."""
    assert sampled_excess(CORNERS, FACES, [CORNERS]) == pytest.approx(1.0, abs=0.03)
    assert sampled_excess(CORNERS, FACES, [CORNERS[CORNERS[:, 1] <= 1], CORNERS[CORNERS[:, 0] <= 1]]) < 1e-9


def test_a_mesh_of_many_triangles_and_a_hull_of_many_planes_need_little_memory(rng):
    ball = rng.normal(size=(1000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    faces = np.tile(ConvexHull(ball).simplices, (10, 1))  # 20,000 triangles, 2,000 planes: 0.96 GB as one array
    tracemalloc.start()
    pieces = pieces_of(ball, faces, [ball, 0.5 * ball])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200e6
    assert [len(piece) for piece in pieces] == [1000]
