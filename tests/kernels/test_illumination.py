"""The light of surfaces and of the floor, where rays that are followed one by one say that it falls."""

import numpy as np
import pytest

from kernel_modes import compiled
from ulna.kernels.render.illumination import surface_light
from ulna.kernels.render.render_layout import NOTHING
from ulna.viewer.film.entries import rendering

draw_triangles = rendering.draw_triangles
place_points = rendering.place_points
shade_pixels = rendering.shade_pixels
WIDTH, HEIGHT = 48, 36
EYE = np.array([1.2, -0.9, 1.5])
NO_LAMP = (0.0, 0.0, -1.0, -1.0, -1.0)
SUN = np.array([[100.0, 0, 0, 200], [0, 100.0, 0, 200], [0, 0, 1.0, 5]])  # straight above, a texel a centimeter


def lit(sun, shadows, normal, color):
    return surface_light(sun, shadows, (0.0, 0.0, -1.0), (0.0, 0.0, 0.0), normal, color)


def surface(normal, shadows=0.0):
    """The light of a white surface seen from above, under a sun above."""
    return np.array(compiled(lit)(SUN, np.full((400, 400), shadows, np.float32), tuple(map(float, normal)), (1.0, 1.0, 1.0)))


def test_a_surface_is_brighter_the_more_it_is_turned_to_the_sun():
    lights = [surface((np.sin(a), 0, np.cos(a)))[0] for a in np.linspace(0, 1.5, 8)]
    assert (np.diff(lights) < 0).all()
    assert lights[0] > 2 * lights[-1]


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, -0.4, 0.8), (5, 0, 1)])
def test_the_two_sides_of_a_surface_and_the_length_of_its_normal_make_no_difference(normal):
    assert np.allclose(surface(normal), surface(-np.array(normal)))
    assert np.allclose(surface(normal), surface(3 * np.array(normal)))


def test_in_the_shadow_only_the_sky_is_left():
    assert 0.2 < surface((0, 0, 1), shadows=9.0)[0] < surface((0, 0, 1))[0] - 0.5


def camera_rows():
    """A camera that looks at the origin: the rows of its rays, and the map of points to the raster."""
    forward = -EYE / np.linalg.norm(EYE)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    corner = forward - 0.01 * (right * WIDTH / 2 + down * HEIGHT / 2)
    view = np.array([100 * right + WIDTH / 2 * forward, 100 * down + HEIGHT / 2 * forward, forward])
    return np.array([EYE, corner, 0.01 * right, 0.01 * down]), np.column_stack([view, -view @ EYE])


def looked_at(shadows, floor, triangle=None):
    """The light of every pixel, one sample each, and the point of the plane z = 0 behind it."""
    camera, view = camera_rows()
    world = np.zeros((3, 3)) if triangle is None else np.array(triangle, dtype=float)
    points, triangles = np.empty((3, 3)), np.array([[0, 1, 2]])
    place_points(world, np.zeros(3, np.int64), np.eye(4)[:3].reshape(1, 12), np.append(view, 1.0)[None], points)
    nearness, numbers = np.zeros((HEIGHT, WIDTH), np.float32), np.full((HEIGHT, WIDTH), NOTHING, np.int32)
    if triangle is not None:
        draw_triangles(points, triangles, nearness, numbers)
    skin = (np.tile([0.0, 0, 1], (3, 1)), np.ones((1, 3)), np.zeros(1), np.zeros(1, np.int64))
    light = np.empty((HEIGHT, WIDTH, 3), np.float32)
    raster, lighting = rendering.Raster(points, triangles, numbers, nearness), rendering.Lighting(SUN, shadows, np.array(floor))
    shade_pixels(raster, skin, np.eye(3)[None], camera, lighting, light)
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    rays = camera[1] + x[..., None] * camera[2] + y[..., None] * camera[3]
    return light, EYE - rays * (EYE[2] / rays[..., 2:])


@pytest.mark.parametrize("triangle", [None, [(-9, -9, 0), (9, -9, 0), (0, 30, 0)]], ids=["the floor", "a triangle"])
def test_a_shadow_lies_where_its_rays_meet_the_surface_in_perspective(triangle):
    shadows = np.zeros((400, 400), np.float32)
    shadows[:, :200] = 7.0  # something high above all that has x < 0
    light, points = looked_at(shadows, (0.0, 1e6, *NO_LAMP), triangle)
    x, blue = points[..., 0], light[..., 2]
    away = (np.abs(points[..., :2]) < 1.9).all(axis=-1)
    assert blue[away & (x < -0.03)].max() < blue[away & (x > 0.03)].min() - 0.2
    assert np.count_nonzero(away & (x < -0.03)) > 300
    assert np.count_nonzero(away & (x > 0.03)) > 300


def test_the_lines_of_the_floor_are_where_its_cells_meet():
    light, points = looked_at(np.zeros((400, 400), np.float32), (0.0, 0.5, *NO_LAMP))
    off = np.abs(points[..., :2] / 0.5 - np.rint(points[..., :2] / 0.5)).min(axis=-1) * 0.5  # [m] from the nearest line
    assert light[off < 0.003].mean() < light[off > 0.05].min() - 0.01
    assert np.ptp(light[(off > 0.05) & (np.abs(points[..., :2]) < 1.9).all(axis=-1)], axis=0).max() < 1e-6


def test_the_lamp_colors_the_floor_about_it():
    dark, points = looked_at(np.zeros((400, 400), np.float32), (0.0, 1e6, *NO_LAMP))
    light, _ = looked_at(np.zeros((400, 400), np.float32), (0.0, 1e6, 0.2, 0.1, 1.0, 0.0, 0.0))
    distance = np.linalg.norm(points[..., :2] - (0.2, 0.1), axis=-1)
    assert (light[distance < 0.1] @ (0.5, -0.25, -0.25)).min() > 0.2
    assert np.abs((light - dark)[distance > 0.6]).max() < 0.02


def test_below_the_floor_there_is_air():
    light, _ = looked_at(np.zeros((400, 400), np.float32), (EYE[2] + 0.1, 0.1, *NO_LAMP))
    floor, _ = looked_at(np.zeros((400, 400), np.float32), (EYE[2] - 0.1, 0.1, *NO_LAMP))
    assert np.ptp(light, axis=1).max() < 0.2
    assert not np.allclose(light, floor, atol=0.05)
