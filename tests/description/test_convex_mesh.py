"""Convex meshes and what is refused as one; and the columns of every shape that the kernels read."""

import copy
import pickle

import numpy as np
import pytest

import ulna
from assertions import assert_close
from ulna.collision.rounded_shapes import shape_columns, shape_vertices
from ulna.kernels.layout import BOX, CAPSULE, CYLINDER, HALF_SPACE, HULL, SPHERE

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def test_the_hull_keeps_only_the_corners(rng):
    mesh = ulna.ConvexMesh.from_points(np.vstack([rng.uniform(-0.99, 0.99, (500, 3)), CUBE]))
    assert sorted(map(tuple, mesh.vertices)) == sorted(map(tuple, CUBE))


def test_without_a_hull_duplicate_points_are_removed():
    assert len(ulna.ConvexMesh(np.vstack([CUBE, CUBE, np.zeros((1, 3))])).vertices) == 9


def test_the_vertices_are_a_frozen_copy():
    points = CUBE.copy()
    mesh = ulna.ConvexMesh(points)
    points[:] = 7
    for one in (mesh, pickle.loads(pickle.dumps(mesh)), copy.deepcopy(mesh)):  # noqa: S301
        assert sorted(map(tuple, one.vertices)) == sorted(map(tuple, CUBE))
        with pytest.raises(ValueError, match="read-only"):
            one.vertices[0, 0] = 1


@pytest.mark.parametrize("points", [CUBE[:3], CUBE * (1, 1, 0), CUBE * (1, 0, 0), CUBE[:1]])
def test_flat_points_are_refused_by_from_points_and_accepted_by_the_constructor(points):
    with pytest.raises(ulna.InputError, match="no volume"):
        ulna.ConvexMesh.from_points(points)
    assert len(ulna.ConvexMesh(points).vertices) >= 1


@pytest.mark.parametrize("points", [[], [1, 2, 3], [[1, 2]], [[np.nan, 0, 0]], [[np.inf, 0, 0]], [[2e6, 0, 0]], "cube", None])
def test_an_array_that_is_not_a_set_of_points_is_refused(points):
    for make in (ulna.ConvexMesh, ulna.ConvexMesh.from_points):
        with pytest.raises(ulna.InputError, match="vertices"):
            make(points)


def test_the_columns_of_every_shape():
    expected = {
        ulna.Sphere(0.3): (SPHERE, 0, 0, 0, 0.3, 0, 0, 0.3),
        ulna.Capsule(radius=0.1, length=0.6): (CAPSULE, 0, 0, 0.3, 0.1, 0, 0, 0.4),
        ulna.Box((1, 2, 3)): (BOX, 0.5, 1, 1.5, 0, 0, 0, np.sqrt(3.5)),
        ulna.Cylinder(radius=0.1, length=0.6): (CYLINDER, 0.1, 0.1, 0.3, 0, 0, 0, np.sqrt(0.11)),
        ulna.HalfSpace(): (HALF_SPACE, 0, 0, 0, 0, 0, 0, np.inf),
    }
    for shape, columns in expected.items():
        assert shape_columns(shape) == pytest.approx(columns)
    mesh = ulna.ConvexMesh([(-3, 0, 0), (1, 2, 0), (0, -1, 4)])
    assert shape_columns(mesh, 5) == pytest.approx((HULL, 3, 2, 4, 0, 5, 3, np.sqrt(17)))
    assert_close(shape_vertices(mesh), mesh.vertices)
    assert shape_vertices(ulna.HalfSpace()).shape == (0, 3)


def test_a_mesh_file_is_refused_as_a_collision_shape():
    with pytest.raises(ulna.GeometryError, match="with_convex_hulls"):
        shape_columns(ulna.Mesh("part.stl"))
