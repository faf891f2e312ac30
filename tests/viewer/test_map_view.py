"""The page of a reachability map: what it shows, clips and solves; and a click in a browser."""

import re

import numpy as np
import pytest

import ulna
from browser import around, camera_of, pixels, project, wait_to_see
from ulna.viewer.map_view import MapView
from ulna.viewer.session.voxels import AXES


@pytest.fixture(scope="module")
def found(panda, tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "m.zarr"
    box = [(-0.6, -0.6, 0.0), (0.6, 0.6, 0.9)]
    return ulna.reachability_map(panda, path, voxel=0.15, orientations=8, bounds=box)


@pytest.fixture
def view(found):
    with MapView(found) as view:
        yield view


@pytest.mark.slow
@pytest.mark.parametrize("axis", AXES)
def test_the_map_begins_behind_the_robot_and_with_voxels(view, axis):
    """No voxel that is shown is where the robot is: the centers lie beyond its box, as the clouds are drawn."""
    view.axis.value = axis
    view._apply_axis()
    k = AXES.index(axis)
    low, high = view.arm.extent.low, view.arm.extent.high
    centers = view.voxels.centers[view.shown]
    assert len(centers)
    last = np.isclose(centers[:, k], view.voxels.centers[:, k].max())
    assert (last | ~((centers > low) & (centers < high)).all(axis=1)).all()
    assert len(centers) < len(view.voxels.centers)


def test_the_bar_has_the_colors_of_the_voxels_their_unit_and_range(view):
    bar = view.legend.content
    assert "Orientations reached in a voxel [%]" in bar
    assert "<span>0</span><span>100</span>" in bar
    most = view.voxels.colors[view.voxels.shares.argmax()]
    share = view.voxels.shares.max()
    places = [tuple(map(int, stop.split(","))) for stop in re.findall(r"rgb\(([^)]*)\)", bar)]
    expected = [np.interp(share, np.linspace(0, 1, len(places)), channel) for channel in zip(*places, strict=True)]
    assert np.abs(most - np.array(expected)).max() <= 0.5


def test_no_slider_is_shown_that_does_nothing(view):
    assert not view.solution.visible
    view.clip("y", -99.0)
    view.click(np.array([2.0, 0.05, 0.5]), np.array([-1.0, 0.0, 0.0]))
    n = np.count_nonzero(view.result.success)
    assert (view.solution.visible, view.solution.max) == (n > 1, n)


def test_every_voxel_that_is_reached_is_shown_in_its_color(view, found):
    view.clip("y", -99.0)
    cloud = view._cloud
    assert len(cloud.points) == np.count_nonzero(found.share.values > 0)
    np.testing.assert_allclose(cloud.points, view.voxels.centers, atol=1e-2)  # the page takes half precision
    assert (cloud.colors == view.voxels.colors).all()


def test_a_plane_clips_them(view):
    view.clip("x", 0.2)
    assert len(view._cloud.points) == np.count_nonzero(view.voxels.centers[:, 0] >= 0.2)
    view.clip("z", -99.0)
    assert len(view._cloud.points) == len(view.voxels.centers)


def test_a_dragged_arrow_moves_the_plane(view):
    view.clip("y", -0.1)
    view._handle.position = (9.0, 0.25, 9.0)
    view._dragged()
    assert view.plane.value == 0.25
    assert len(view._cloud.points) == np.count_nonzero(view.voxels.centers[:, 1] >= 0.25)


def test_a_click_solves_the_orientations_of_a_voxel_and_the_robot_goes_there(view, found):
    view.clip("y", -99.0)
    view.click(np.array([2.0, 0.05, 0.5]), np.array([-1.0, 0.0, 0.0]))
    center = view.voxels.centers[view.chosen]
    assert np.abs(center - [2.0, 0.05, 0.5])[1:].max() <= 0.075
    assert (view.result.success == found.solutions_at(center).success).all()
    reached = np.flatnonzero(view.result.success)
    assert f"{len(reached)} of 8 orientations reached" in view.status.content
    number = found.robot.link_names.index(found.link)
    np.testing.assert_allclose(view.arm.frames[number].position, center, atol=1e-4)
    before, view.solution.value = view.arm.frames[number].wxyz.copy(), len(reached)
    view._pose_arm()
    np.testing.assert_allclose(view.arm.frames[number].position, center, atol=1e-4)
    assert np.abs(view.arm.frames[number].wxyz - before).max() > 1e-3
    chosen = view.chosen
    view.click(np.array([2.0, 0.05, 0.5]), np.array([1.0, 0.0, 0.0]))
    assert view.chosen == chosen


def test_an_empty_map_has_a_page(panda, tmp_path):
    far = [(5.0, 5.0, 5.0), (5.5, 5.5, 5.5)]
    with MapView(ulna.reachability_map(panda, tmp_path / "m.zarr", voxel=0.5, orientations=2, bounds=far)) as view:
        assert len(view._cloud.points) == 0
        view.click(np.zeros(3), np.ones(3))
        assert view.chosen is None


def test_a_voxel_is_clicked_on_the_page(view, open_page):
    view.clip("y", 0.0)
    page = open_page(view.url)
    assert "poses reached" in page.get_by_role("status").first.inner_text()
    wait_to_see(page, lambda: page.locator("canvas").count(), "the scene")
    camera = camera_of(page, view.page.server)
    eye = np.array(camera.position)
    target = view.shown[np.argmin(np.linalg.norm(view.voxels.centers[view.shown] - eye, axis=1))]
    place = project(camera, view.voxels.centers[target])
    wait_to_see(page, lambda: around(pixels(page), place, 40).min() < 200, "the voxels")
    seen = around(pixels(page), place, 2).reshape(-1, 3)
    assert np.abs(seen - view.voxels.colors[target]).max(axis=1).min() <= 12  # the color that the bar says
    page.mouse.click(*place)
    wait_to_see(page, lambda: view.result is not None, "the solutions of a voxel")
    ray = view.voxels.centers[target] - eye
    assert view.chosen == view.voxels.on_ray(eye, ray, view.shown)
    assert "of 8 orientations reached" in page.get_by_role("status").nth(1).inner_text()
