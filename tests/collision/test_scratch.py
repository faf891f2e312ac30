"""One distance takes no memory from the system, and a polytope has the room that its cores need."""

import resource

import numpy as np
import pytest

import ulna
from ulna.kernels.distance.epa import MAX_POINTS, points_needed


def faults_of(call, n=300):
    call()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(n):
        call()
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


@pytest.mark.parametrize("shape", [ulna.Box((0.2, 0.2, 0.2)), ulna.Sphere(0.1), ulna.Cylinder(0.1, 0.3)], ids=type)
def test_one_distance_takes_no_pages_from_the_system(panda, shape):
    world = ulna.World()
    world.add("part", shape, ulna.pose((0.5, 0, 0.3)))
    for call in (panda.signed_distance, panda.check_collision):
        assert faults_of(lambda call=call: call(panda.home, world)) < 100  # three in each call, with room for any polytope


@pytest.mark.parametrize(("n", "m", "needed"), [(0, 0, 160), (20, 0, 400), (0, 30, 240), (20, 30, 600), (100, 0, MAX_POINTS)])
def test_a_polytope_has_room_for_the_corners_of_a_difference(n, m, needed):
    assert points_needed(n, m) == needed


def test_depths_of_hulls_are_those_of_the_difference(panda):
    """Of two boxes as hulls of eight vertices, one beside many others: as of boxes, by another algorithm."""
    corners = np.array(np.meshgrid(*[(-0.1, 0.1)] * 3)).reshape(3, -1).T
    boxes, hulls = ulna.World(), ulna.World()
    T = ulna.pose((0.45, 0.1, 0.5), (0.3, 0.2, 0.1))
    boxes.add("part", ulna.Box((0.2, 0.2, 0.2)), T)
    hulls.add("part", ulna.ConvexMesh(corners), T)
    q = panda.random(300, seed=4)
    np.testing.assert_allclose(
        panda.signed_distance(q, hulls, self_collision=False), panda.signed_distance(q, boxes, self_collision=False), atol=1e-9
    )
