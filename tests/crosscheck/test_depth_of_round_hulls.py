"""How deep round hulls overlap, against Qhull's hull of all differences of their points: its nearest face is the depth."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import grazing
import ulna
from assertions import assert_close


def ball(n, radius):
    """Points spread over a sphere (a Fibonacci lattice)."""
    i = np.arange(n) + 0.5
    polar, around = np.arccos(1 - 2 * i / n), np.pi * (1 + 5**0.5) * i
    return radius * np.stack([np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)], -1)


def depth_of(a, b, q):
    robot, world = grazing.mover(a, np.eye(4)), ulna.World()
    world.add("b", b)
    return -robot.signed_distance([*q, 0, 0, 0], world, self_collision=False)


@pytest.mark.parametrize(("n_a", "n_b"), [(60, 200), (200, 200), (200, 500)])
@pytest.mark.parametrize("q", [(0, 0, 0), (0.02, 0.01, 0)], ids=["concentric", "beside"])
def test_the_depth_of_round_hulls_is_that_of_the_nearest_face_of_their_differences(n_a, n_b, q):
    a, b = ball(n_a, 0.1), ball(n_b, 0.2)
    differences = (a[:, None] + q - b[None]).reshape(-1, 3)
    depth = depth_of(ulna.ConvexMesh(a), ulna.ConvexMesh(b), q)
    assert_close(depth, -ConvexHull(differences).equations[:, 3].max(), atol=1e-9)


@pytest.mark.parametrize("n", [200, 500])
def test_the_depth_of_a_ball_in_a_round_hull_is_that_of_the_nearest_face(n):
    center, planes = np.array([0.001, 0.002, 0]), ConvexHull(ball(n, 0.2)).equations
    expected = (-planes[:, :3] @ center - planes[:, 3]).min() + 0.01
    assert_close(depth_of(ulna.Sphere(0.01), ulna.ConvexMesh(ball(n, 0.2)), center), expected, atol=1e-9)
