"""The benchmark's depth camera shows surfaces of the boxes, and a cell's verdicts are those of a k-d tree."""

import numpy as np
import pytest
from benchmarks.cell import judge_rows
from benchmarks.depth_camera import NOISE, Camera, bin_on_a_table


def test_the_points_of_an_image_are_on_the_boxes():
    boxes, camera = bin_on_a_table(3), Camera.of_pixels(20_000)
    points = camera.cloud(camera.image(boxes, np.random.default_rng(3)), 0.001).points
    beyond = [np.abs(points - T[:3, 3]) - half for half, T in boxes]  # of each pair of faces, negative between them
    outside = np.array([np.linalg.norm(np.maximum(one, 0), axis=1) for one in beyond])
    inside = np.array([-one.max(axis=1) for one in beyond])
    assert len(points) > 5000
    assert outside.min(axis=0).max() < 8 * NOISE
    assert np.percentile(inside.max(axis=0), 99) < 4 * NOISE  # no ray goes through a box to its far side


@pytest.mark.slow
def test_balls_touch_a_cloud_where_a_tree_says_so():
    rows = judge_rows(2000)
    assert sum(row["touching"] for row in rows) > 10
    assert all(row["verdicts_differ"] == 0 and row["distances_differ_m"] < 1e-12 for row in rows)
