"""The points of meshes of real robots, as Assimp reads them for Coal; every file of the collections: benchmarks.meshes."""

import coal
import numpy as np
import pytest

from assertions import assert_close
from robot_files import EXAMPLES
from ulna.description.meshes.mesh_files import CHECKED
from ulna.description.meshes.reader import mesh_bytes, read_scene, used_points

ROBOTS = (
    "panda_description",
    "ur_description",
    "kinova_description",
    "tiago_description",
    "quadruped_description",
    "pr2_description",
)
ALL = [path for path in sorted(EXAMPLES.rglob("*")) if path.suffix.lower() in CHECKED]
MESHES = [path for path in ALL if path.relative_to(EXAMPLES).parts[0] in ROBOTS and path.stat().st_size < 1_000_000][::3]


def test_there_are_meshes_of_every_kind():
    assert {path.suffix.lower() for path in MESHES} == set(CHECKED)
    assert len(MESHES) > 40


def check_points(path):
    found = used_points(read_scene(path, mesh_bytes(path)))
    expected = coal.MeshLoader().load(str(path)).vertices()
    size = np.ptp(expected, axis=0).max()
    assert_close([found.min(axis=0), found.max(axis=0)], [expected.min(axis=0), expected.max(axis=0)], atol=1e-5 * size)
    counts = [len(np.unique(points.astype(np.float32), axis=0)) for points in (found, expected)]
    assert abs(counts[0] - counts[1]) <= 1, "but for one that rounding divides"


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.name)
def test_a_mesh_has_the_points_that_assimp_reads(path):
    check_points(path)


@pytest.mark.slow
@pytest.mark.parametrize("folder", sorted({path.relative_to(EXAMPLES).parts[0] for path in ALL}))
def test_every_mesh_of_the_collection_has_the_points_that_assimp_reads(folder):
    for path in ALL:
        if path.relative_to(EXAMPLES).parts[0] == folder:
            check_points(path)
