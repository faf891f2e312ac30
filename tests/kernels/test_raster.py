"""Triangles on a raster, against a look at every sample by itself."""

import numpy as np
import pytest

from ulna.kernels.render.render_layout import NOTHING
from ulna.viewer.film.entries import rendering

draw_triangles = rendering.draw_triangles
place_points = rendering.place_points
HEIGHT, WIDTH = 12, 17


def drawn(points, triangles, height=HEIGHT, width=WIDTH):
    nearness, numbers = np.zeros((height, width), np.float32), np.full((height, width), NOTHING, np.int32)
    draw_triangles(np.asarray(points, dtype=float), np.ascontiguousarray(triangles), nearness, numbers)
    return nearness, numbers


def naive_draw(points, triangles, height=HEIGHT, width=WIDTH):
    """Each sample's weights by solving for them; the nearest of the triangles in which none is negative."""
    nearness, numbers = np.zeros((height, width)), np.full((height, width), NOTHING)
    for i, j in np.ndindex(height, width):
        for k, triangle in enumerate(triangles):
            corners = points[triangle]
            weights = np.linalg.solve(np.vstack([corners[:, :2].T, np.ones(3)]), (j + 0.5, i + 0.5, 1.0))
            near = weights @ corners[:, 2]
            if (weights >= 0).all() and (corners[:, 2] > 0).all() and near > nearness[i, j]:
                nearness[i, j], numbers[i, j] = near, k
    return nearness, numbers


def test_each_sample_shows_the_nearest_triangle_that_covers_it(rng):
    points = rng.uniform((-5, -5, -0.1), (WIDTH + 5, HEIGHT + 5, 1), (30, 3))
    triangles = rng.permuted(np.tile(np.arange(30), (12, 1)), axis=1)[:, :3]
    nearness, numbers = drawn(points, triangles)
    expected, owners = naive_draw(points, triangles)
    assert np.array_equal(numbers, owners)
    np.testing.assert_allclose(nearness, expected, atol=1e-6)
    assert len(set(numbers.ravel())) > 4


def test_two_triangles_with_a_common_side_leave_no_gap(rng):
    for _ in range(20):
        a, b = rng.uniform(-5, -0.1, 2)
        corners = np.array([[-1, -1, 1.0], [WIDTH + 1, a, 1], [WIDTH + 1, HEIGHT + 1, 1], [b, HEIGHT + 1, 1]])
        _, numbers = drawn(corners, [[0, 1, 2], [2, 3, 0]])
        assert (numbers != NOTHING).all()
        assert set(numbers.ravel()) == {0, 1}


@pytest.mark.parametrize("corner", [0, 1, 2])
def test_a_triangle_that_reaches_behind_the_eye_is_left_out(corner):
    points = np.array([[0, 0, 1.0], [WIDTH, 0, 1], [0, HEIGHT, 1]])
    assert (drawn(points, [[0, 1, 2]])[1] == 0).any()
    points[corner, 2] = 0.0
    assert (drawn(points, [[0, 1, 2]])[1] == NOTHING).all()


@pytest.mark.parametrize(
    "points",
    [
        [[1, 1, 1], [9, 9, 1], [5, 5, 1]],
        [[2, 2, 1]] * 3,
        [[1, 1, 1], [np.nan, 9, 1], [9, 1, 1]],
        [[1e300, 1, 1], [2e300, 9, 1], [3e300, 1, 1]],
    ],
    ids=["on a line", "a point", "not a number", "far outside"],
)
def test_what_is_no_triangle_on_the_raster_is_left_out(points):
    with np.errstate(all="ignore"):
        assert (drawn(points, [[0, 1, 2]])[1] == NOTHING).all()


def test_a_long_thin_triangle_covers_only_what_it_covers():
    points, triangles = np.array([[0.0, 0.2, 1], [17, 11.4, 1], [17, 11.9, 1]]), np.array([[0, 1, 2]])
    assert np.array_equal(drawn(points, triangles)[1], naive_draw(points, triangles)[1])


def test_points_stand_where_the_product_of_their_matrices_puts_them(rng):
    points, poses, view = rng.normal(size=(9, 3)), rng.normal(size=(3, 3, 4)), rng.normal(size=(3, 4))
    view[2, 3] += 20.0
    frames, placed = np.arange(9) % 3, np.empty((9, 3))
    homogeneous = np.column_stack([points, np.ones(9)])
    in_base = np.einsum("nij,nj->ni", poses[frames], homogeneous)
    x, y, z = view @ np.column_stack([in_base, np.ones(9)]).T
    place_points(points, frames, poses.reshape(3, 12), np.append(view, 0.0)[None], placed)
    np.testing.assert_allclose(placed.T, [x, y, z], atol=1e-12)
    place_points(points, frames, poses.reshape(3, 12), np.append(view, 1.0)[None], placed)
    np.testing.assert_allclose(placed.T, [x / z, y / z, 1 / z], atol=1e-12)


def test_points_behind_a_camera_have_no_nearness():
    view = np.append(np.eye(4)[:3], 1.0)[None]
    placed = np.empty((3, 3))
    place_points(
        np.array([[1.0, 2, -1], [1, 2, 0], [1, 2, 4]]), np.zeros(3, np.int64), np.eye(4)[:3].reshape(1, 12), view, placed
    )
    assert placed[:, 2].tolist() == [0.0, 0.0, 0.25]
