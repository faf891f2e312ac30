"""Clouds of points on the page of ``ulna view``, in headless Chromium."""

import numpy as np
import viser

import ulna
from browser import around, camera_of, pixels, project, wait_to_see
from processes import wait_for

SIDE = 0.16  # [m]


def plate(middle, n):
    """n x n points on a square that faces x, about a point [m], shape (n * n, 3)."""
    y, z = np.meshgrid(*2 * [np.linspace(-SIDE / 2, SIDE / 2, n)])
    return middle + np.stack([np.zeros(n * n), y.ravel(), z.ravel()], axis=1)


def test_an_update_of_a_cloud_reaches_the_browser(view, open_page):
    here, there = np.array([0.6, -0.4, 0.3]), np.array([0.5, 0.5, 0.8])
    view.world.add("seen", ulna.PointCloud(plate(here, 150), 0.002))
    page = open_page(view.url)
    camera = camera_of(page, view.page.server)

    def drawn(place):
        red, _, blue = np.moveaxis(around(pixels(page), project(camera, place), 8), -1, 0)
        return np.count_nonzero(red - blue > 100) > 200  # orange

    wait_to_see(page, lambda: drawn(here) and not drawn(there), "the cloud")
    view.world.update("seen", ulna.PointCloud(plate(there, 170), 0.002))
    wait_to_see(page, lambda: drawn(there) and not drawn(here), "the points of the update, and no others")


def test_a_cloud_is_one_node_of_discs_that_an_update_keeps(view, rng):
    points = rng.uniform(0.4, 0.8, (300_000, 3))
    view.world.add("seen", ulna.PointCloud(points, 0.003))
    node = wait_for(lambda: view.obstacles.nodes.get("seen"), "the cloud")
    assert isinstance(node, viser.PointCloudHandle)
    assert node.points.nbytes == 12 * len(points)
    assert np.array_equal(node.points, points.astype(np.float32))
    assert node.point_size == 0.003
    view.world.update("seen", ulna.PointCloud(points[:1000] + 1.0, 0.005))
    wait_for(lambda: len(node.points) == 1000 and node.point_size == 0.005, "its update")
    assert view.obstacles.nodes["seen"] is node
    view.world.update("seen", ulna.PointCloud(np.empty((0, 3)), 0.005))
    wait_for(lambda: len(node.points) == 0, "an update without points")
    view.world.reshape("seen", ulna.Sphere(0.1))
    wait_for(lambda: isinstance(view.obstacles.nodes.get("seen"), viser.IcosphereHandle), "a ball in its place")


def test_a_cloud_that_touches_the_robot_is_red(view, panda):
    hand = panda.forward_kinematics(panda.home)[:3, 3]
    view.world.add("seen", ulna.PointCloud(hand[None] + [1.0, 0.0, 0.0], 0.01))
    node = wait_for(lambda: view.obstacles.nodes.get("seen"), "the cloud")
    free = tuple(node.colors)
    view.world.update("seen", ulna.PointCloud(hand[None], 0.01))
    wait_for(lambda: tuple(node.colors) != free, "another color")
