"""Normals of surfaces, projections of the camera and the sun, and the order of translucent sides."""

import numpy as np
import pytest
import trimesh

import ulna
from ulna.description.shapes import Box
from ulna.viewer.film.camera import Camera, direction_to, sun_view
from ulna.viewer.film.painter import facets_of, make_panes
from ulna.viewer.film.skin import corner_normals, linear
from ulna.viewer.palette import Solid


def test_the_corner_normals_of_a_cube_are_those_of_its_sides():
    cube = trimesh.creation.box((1, 2, 3))
    normals = corner_normals(cube.vertices, cube.faces).reshape(-1, 3, 3)
    assert np.allclose(normals, cube.face_normals[:, None])


def test_a_sphere_is_smooth_even_if_its_triangles_share_no_vertices():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    points = ball.vertices[ball.faces].reshape(-1, 3)
    normals = corner_normals(points, np.arange(len(points)).reshape(-1, 3))
    assert np.einsum("ij,ij->i", normals, points / 2.0).min() > 0.999


def test_a_triangle_without_area_has_unit_normals():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    normals = corner_normals(points, np.array([[0, 1, 2], [0, 1, 3]]))
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert np.allclose(normals[3:], (0, 0, 1))


@pytest.mark.parametrize("position", [(2.0, -1.5, 1.0), (0.0, 0.0, 3.0), (0.0, 0.0, -3.0)], ids=["beside", "above", "below"])
def test_the_rays_of_a_camera_invert_its_projection(rng, position):
    camera, size = Camera(position, (0.1, 0.0, 0.2), 0.7), (64, 48)
    eye, corner, right, down = camera.rays(*size)
    for point in rng.uniform(-0.5, 0.5, (20, 3)):
        x, y = camera.place(point, *size)
        ray = corner + x * right + y * down
        assert np.allclose(np.cross(ray, point - eye), 0.0, atol=1e-12)
        assert ray @ (point - eye) > 0
    assert np.allclose(camera.place(camera.look_at, *size), (32, 24))
    assert down[2] <= 1e-12, "its pictures stand upright"


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_a_camera_that_frames_points_has_them_all_in_the_middle_of_the_picture(rng, aspect):
    size = (round(200 * aspect), 200)
    points = (1.0, 2.0, 3.0) + rng.uniform(-1, 1, size=(300, 3)) * (0.8, 0.1, 0.4)
    camera = Camera.framing(points, direction_to((1.1, 0.4)), aspect)
    x, y = np.transpose([camera.place(point, *size) for point in points])
    assert x.min() > 0
    assert y.min() > 0
    assert x.max() < size[0]
    assert y.max() < size[1]
    assert max(np.ptp(x) / size[0], np.ptp(y) / size[1]) > 0.9
    assert np.allclose([x.min() + x.max(), y.min() + y.max()], size, rtol=0.02)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_a_camera_around_a_ball_has_all_of_it_in_the_picture(rng, aspect):
    size = (round(200 * aspect), 200)
    camera = Camera.around((1.0, 2.0, 3.0), 0.7, direction_to((1.1, 0.4)), aspect)
    directions = rng.normal(size=(300, 3))
    points = (1.0, 2.0, 3.0) + 0.7 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    x, y = np.transpose([camera.place(point, *size) for point in points])
    assert x.min() > 0
    assert y.min() > 0
    assert x.max() < size[0]
    assert y.max() < size[1]
    assert max(np.ptp(x) / size[0], np.ptp(y) / size[1]) > 0.85


def test_the_shadow_map_covers_all_within_its_radius(rng):
    view = sun_view((0.9, 0.25, 1.5), (1, 0, 0.5), 1.3, 256)
    directions = rng.normal(size=(300, 3))
    points = (1, 0, 0.5) + 1.3 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    x, y, height = view @ np.column_stack([points, np.ones(300)]).T
    assert min(x.min(), y.min(), height.min()) > 0
    assert max(x.max(), y.max()) < 256
    assert np.allclose(view[2, :3], np.array([0.9, 0.25, 1.5]) / np.linalg.norm((0.9, 0.25, 1.5)))


def test_translucent_boxes_show_the_three_front_sides_the_far_box_first():
    near, far = (Solid(name, "base", np.eye(4), Box((1, 1, 1)), (255, 0, 0), 0.5) for name in ("near", "far"))
    T_near, T_far = np.eye(4), np.eye(4)
    T_far[0, 3] = -3.0
    points, paints = make_panes([(near, T_near), (far, T_far)], np.array([5.0, 4.0, 3.0]))
    corners = points.reshape(-1, 4, 3)
    assert len(corners) == 6
    assert corners[:3, :, 0].max() < -2
    assert corners[3:, :, 0].min() > -1
    outwards = corners[3:].mean(axis=1)
    assert sorted(map(tuple, outwards.round(9))) == [(0.0, 0.0, 0.5), (0.0, 0.5, 0.0), (0.5, 0.0, 0.0)]
    top = outwards[:, 2].argmax()
    assert np.allclose(paints[3 + top], (*linear((255, 0, 0)), 0.5))


def test_without_translucent_boxes_there_are_no_panes():
    assert len(make_panes([], np.zeros(3))[0]) == 0


@pytest.mark.parametrize("shape", [ulna.Cylinder(0.2, 0.6), ulna.Capsule(0.2, 0.6), ulna.Sphere(0.2), ulna.Box((0.2, 0.4, 0.6))])
def test_facets_close_a_shape_and_lie_on_it(shape):
    """By the divergence theorem the areas of a closed surface, as vectors, add up to zero, and give its volume."""
    facets = facets_of(shape)
    middles, areas = facets.mean(axis=1), np.cross(facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1]) / 2
    areas *= np.sign(np.einsum("ij,ij->i", areas, middles))[:, None]
    assert np.allclose(areas.sum(axis=0), 0.0, atol=1e-12)
    volume = np.einsum("ij,ij->", areas, middles) / 3
    exact = {
        ulna.Cylinder: np.pi * 0.04 * 0.6,
        ulna.Capsule: np.pi * 0.04 * 0.6 + 4 / 3 * np.pi * 0.008,
        ulna.Sphere: 4 / 3 * np.pi * 0.008,
        ulna.Box: 0.048,
    }[type(shape)]
    assert 0.8 * exact < volume <= exact + 1e-12
    if isinstance(shape, ulna.Capsule | ulna.Sphere):
        height = np.maximum(np.abs(facets[..., 2]) - getattr(shape, "length", 0.0) / 2, 0.0)
        assert np.allclose(np.linalg.norm([facets[..., 0], facets[..., 1], height], axis=0), 0.2)
