"""Light: shadows, the floor's grid, panes that are seen through, and how light becomes a color."""

import numpy as np
import pytest

from kernel_modes import compiled
from ulna.kernels.render.illumination import SOFT, cover, ramp, sunlit
from ulna.viewer.film.entries import rendering

encode = rendering.encode
lay_panes = rendering.lay_panes
shade_pixels = rendering.shade_pixels


def covered(x, width, seen):
    return cover(x, 1.0, width, seen)


def slope(x):
    return ramp(x, 1.0, 3.0)


def lit(sun, shadows, x, y, z):
    return sunlit(sun, shadows, (x, y, z))


@pytest.mark.parametrize("seen", [0.004, 0.05, 0.3, 0.9])
def test_a_line_covers_as_much_of_a_stretch_as_of_many_points_in_it(seen):
    for x in np.linspace(-1.3, 1.3, 53):
        points = x + seen * (np.arange(4000) + 0.5) / 4000 - seen / 2
        expected = np.mean(np.abs(points - np.rint(points)) <= 0.05)
        assert compiled(covered)(x, 0.1, seen) == pytest.approx(expected, abs=0.02 if seen < 0.8 else 0.06)


def test_a_ramp_rises_from_its_foot_to_its_top():
    x = np.linspace(0.0, 4.0, 41)
    y = np.array([compiled(slope)(one) for one in x])
    assert (y[x <= 1.0] == 0).all()
    assert (y[x >= 3.0] == 1).all()
    assert (np.diff(y) >= 0).all()
    assert y[20] == pytest.approx(0.5)


def test_a_shadow_is_dark_under_what_throws_it_open_beside_it_and_soft_between():
    """Something 1 m up hides the left half of the sun's raster; the shadow of its edge is as wide as SOFT texels."""
    sun = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0.5]])
    shadows = np.zeros((64, 64), np.float32)
    shadows[:, :32] = 1.5
    for height, dark in ((0.0, True), (0.999, True), (1.001, False)):
        x = np.linspace(10, 54, 400)
        light = np.array([compiled(lit)(sun, shadows, one, 30.3, height) for one in x])
        expected = np.clip((x - 32) / SOFT + 0.5, 0, 1) if dark else np.ones(400)
        np.testing.assert_allclose(light, expected, atol=1e-9)


@pytest.mark.parametrize("place", [(-9.0, 30.0), (80.0, 30.0), (30.0, -9.0), (30.0, 80.0), (np.nan, 30.0)])
def test_beside_the_suns_raster_nothing_throws_a_shadow(place):
    sun = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0]])
    assert compiled(lit)(sun, np.full((64, 64), 9.0, np.float32), *place, 0.0) == 1.0


def test_light_becomes_the_color_whose_square_it_is():
    levels = np.arange(256)
    light = ((levels / 255.0) ** 2).astype(np.float32).reshape(1, 256, 1).repeat(3, axis=2)
    pixels = np.empty((1, 256, 3), np.uint8)
    encode(light, pixels)
    assert np.array_equal(pixels[0], levels[:, None].repeat(3, axis=1))
    encode(np.array([[[-1.0, 2.0, 0.0]]], np.float32), pixels[:, :1])
    assert pixels[0, 0].tolist() == [0, 255, 0]


def pane(opacity, z=1.0, corners=((2, 2), (10, 2), (10, 6), (2, 6))):
    """A pane over the pixels 2 to 10 across and 2 to 6 down, on a black picture of 12 x 8 with 2 x 2 samples a pixel."""
    points = np.array([(2.0 * x, 2.0 * y, z) for x, y in corners])
    light = np.zeros((8, 12, 3), np.float32)
    nearness = np.zeros((16, 24), np.float32)
    nearness[:, 12:] = 0.5  # something stands at the right
    lay_panes(points, np.array([[1.0, 0.5, 0.0, opacity]]), nearness, light)
    return light


def test_a_pane_colors_what_it_covers_by_its_opacity_and_its_edge_more():
    light = pane(0.25)
    assert np.count_nonzero(light[..., 0]) == 8 * 4
    np.testing.assert_allclose(light[4, 5], (0.25, 0.125, 0), atol=1e-6)
    assert light[2, 5, 0] > 0.5  # along its edge


def test_a_pane_behind_what_was_drawn_is_hidden():
    light = pane(0.25, z=0.25)
    assert not light[:, 6:].any()
    assert light[4, 4, 0] == pytest.approx(0.25)


def test_the_two_halves_of_a_pane_meet_without_a_seam():
    light = pane(0.5, corners=((1.2, 1.1), (11.1, 1.7), (10.3, 7.2), (0.4, 6.6)))
    inner = light[3:5, 3:9, 0]
    np.testing.assert_allclose(inner, 0.5, atol=1e-6)


def shaded(numbers, colors):
    """One pixel of 2 x 2 samples before two triangles that glow."""
    points = np.array([[0.0, 0, 1], [9, 0, 1], [0, 9, 1]])
    triangles, light = np.array([[0, 1, 2], [0, 1, 2]]), np.empty((1, 1, 3), np.float32)
    skin = (np.tile([0.0, 0, 1], (6, 1)), np.array(colors, dtype=float), np.ones(2), np.zeros(2, np.int64))
    camera, sun = np.array([[0.0, 0, 5], [0, 0, -1], [0.01, 0, 0], [0, -0.01, 0]]), np.eye(3, 4)
    floor = np.array([0.0, 0.1, 0, 0, -1, -1, -1])
    shade_pixels(
        rendering.Raster(points, triangles, np.array(numbers, np.int32), np.ones((2, 2), np.float32)),
        skin,
        np.eye(3)[None],
        camera,
        rendering.Lighting(sun, np.zeros((8, 8), np.float32), floor),
        light,
    )
    return light[0, 0]


def test_a_pixel_at_an_edge_is_the_mean_of_its_samples():
    red, blue = (1, 0, 0), (0, 0, 1)
    np.testing.assert_allclose(shaded([[0, 0], [0, 0]], (red, blue)), red)
    np.testing.assert_allclose(shaded([[0, 1], [1, 1]], (red, blue)), (0.25, 0, 0.75))
    np.testing.assert_allclose(shaded([[0, 1], [1, 1]], (red, red)), red)
    floor = shaded([[-1, -1], [-1, -1]], (red, blue))
    np.testing.assert_allclose(shaded([[-1, -1], [0, 0]], ((1, 1, 1), blue)), (floor + 1) / 2, rtol=0.02)
