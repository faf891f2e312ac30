"""One distance takes no memory from the system, and a polytope has the room that its cores need."""

import os
import subprocess
import sys

import numpy as np
import pytest

import ulna
from ulna.kernels.distance.epa import MAX_POINTS, points_needed

PROGRAM = """
import resource, ulna

panda, world = ulna.load("panda"), ulna.World()
world.add("part", ulna.Box((0.2, 0.2, 0.2)), ulna.pose((0.5, 0, 0.3)))
for call in (panda.signed_distance, panda.check_collision):
    call(panda.home, world)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(300):
        call(panda.home, world)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.process
def test_one_distance_takes_no_pages_from_the_system():
    """With an allocator that keeps little, as glibc's does in a process that has freed no large array yet."""
    environment = os.environ | {"MALLOC_MMAP_THRESHOLD_": "131072", "MALLOC_TRIM_THRESHOLD_": "131072"}
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, env=environment)
    faults = [int(line) for line in done.stdout.split()]
    assert len(faults) == 2
    assert max(faults) < 100  # 900 with room for any polytope


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
