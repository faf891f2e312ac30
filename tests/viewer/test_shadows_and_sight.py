"""The light and the camera of the page: objects cast shadows on what they stand on, and the first view shows them all."""

import numpy as np
import pytest

import ulna
from browser import around, camera_of, pixels, project, wait_to_see
from ulna.viewer.palette import TO_SUN

pytestmark = pytest.mark.slow
TOP, RADIUS = 0.3, 0.08  # [m] the height of the table's surface, and the radius of the ball on it


@pytest.fixture
def view(panda):
    world = ulna.World()
    world.add("table", ulna.Box((0.6, 1.2, 0.05)), ulna.pose((0.7, 0, TOP - 0.025)))
    world.add("ball", ulna.Sphere(RADIUS), ulna.pose((0.7, -0.2, TOP + RADIUS)))
    with ulna.view(panda, world) as view:
        yield view


def brightness(page, camera, point):
    """The mean of the pixels around a point of the scene, 0 to 255."""
    return around(pixels(page), project(camera, point), 2).mean()


def test_a_ball_on_a_table_casts_its_shadow_on_the_table(view, open_page):
    page = open_page(view.url)
    camera = camera_of(page, view.page.server)
    shadow = np.array((0.7, -0.2, TOP + RADIUS)) - np.array(TO_SUN) / TO_SUN[2] * RADIUS  # of the ball's center
    shadow[:2] -= 0.5 * RADIUS * np.array(TO_SUN[:2]) / np.linalg.norm(TO_SUN[:2])  # past the ball, which may hide the point
    lit = np.array((0.7, 0.25, TOP))
    wait_to_see(page, lambda: brightness(page, camera, shadow) < 0.93 * brightness(page, camera, lit), "the ball's shadow")


def test_the_first_view_shows_the_robot_and_the_table(view, open_page):
    page = open_page(view.url)
    camera = camera_of(page, view.page.server)
    corners = [(x, y, TOP) for x in (0.4, 1.0) for y in (-0.6, 0.6)] + [(0.0, 0.0, 0.0)]
    height, width = pixels(page).shape[:2]
    for corner in corners:
        x, y = project(camera, np.array(corner))
        assert 0 < x < width
        assert 0 < y < height
