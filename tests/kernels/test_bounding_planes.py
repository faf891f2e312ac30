"""Planes beside a body bound its distance from below, in every lane, and as well as the distance that gave their normal."""

import numpy as np
import pytest

import ulna
from kernel_modes import compiled
from ulna.collision.entries.contacts import near_of
from ulna.engine.lanes import WIDTH, empty_rows, load, store
from ulna.kernels.collision.bounding_planes import beyond_planes, write_plane
from ulna.kernels.collision.posed_pair import body_at
from ulna.kernels.layout import FIRST_VERTEX, N_VERTICES
from ulna.kernels.spatial.se3 import load_pose

IDENTITY = np.array([1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])


def scene_of_a_hull(rng):
    points = 0.1 * rng.normal(size=(20, 3))
    limit = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    slide = f'<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>{limit}</joint>'
    robot = ulna.load(f'<robot name="slider"><link name="base"/><link name="cart"/>{slide}</robot>')
    robot = robot.with_attached("hull", ulna.ConvexMesh(points), np.eye(4), link="cart")
    scene = robot._checker.scene_of(None, True)
    first, n = (int(scene.bodies[0, column]) for column in (FIRST_VERTEX, N_VERTICES))
    return scene.vertices[first : first + n], scene  # in the body's frame, which is not the link's


def bounds(scene, poses, planes, normals, rows, out):
    ours = body_at(scene, 0, load_pose(poses, 0))
    for i in range(normals.shape[0]):
        write_plane(ours, planes, (normals[i, 0], normals[i, 1], normals[i, 2]))
    x, half = (load(rows, 0), load(rows, 1), load(rows, 2)), (load(rows, 3), load(rows, 4), load(rows, 5))
    store(out, 0, beyond_planes(planes, 0, ours.pose, x, half))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("n", [1, 7, 100])
def test_no_point_of_a_hull_is_nearer_to_a_box_than_its_planes_say(seed, n):
    """The judge is the body's points themselves: no two points, of the hull and of the box, are nearer than the bound."""
    rng = np.random.default_rng(seed)
    points, scene = scene_of_a_hull(rng)
    planes, rows, out = near_of(scene, 0, 0).planes, empty_rows(6), empty_rows(1)
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    centers, halves = rng.uniform(-0.6, 0.6, (3, WIDTH)), rng.uniform(0, 0.05, (3, WIDTH))
    rows[:3], rows[3:] = centers, halves
    compiled(bounds)(scene, IDENTITY.copy(), planes, normals, rows, out)
    weights = rng.dirichlet(np.full(len(points), 0.2), 5000)
    inside = np.vstack([points, weights @ points])
    for lane in range(WIDTH):
        box = centers[:, lane] + rng.uniform(-1, 1, (200, 3)).round() * halves[:, lane]
        nearest = np.linalg.norm(inside[:, None] - box, axis=2).min()
        assert out[0, lane] <= nearest + 1e-9
        if n == 1:  # then the bound is a sum that is written out here
            exact = normals[0] @ centers[:, lane] - np.abs(normals[0]) @ halves[:, lane] - (points @ normals[0]).max()
            assert out[0, lane] == pytest.approx(exact, abs=1e-9)
