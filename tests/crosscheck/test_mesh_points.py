"""The points of meshes of real robots, as Assimp reads them for Coal."""

from functools import cache
from pathlib import Path

import coal
import numpy as np
import pytest

from assertions import assert_close
from robot_files import EXAMPLES, URDFS
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


@cache
def meshes():
    """All of the collection, and of some robots every third that is not large."""
    every = [path for path in sorted(EXAMPLES.rglob("*")) if path.suffix.lower() in CHECKED]
    return every, [path for path in every if folder_of(path) in ROBOTS and path.stat().st_size < 1_000_000][::3]


def folder_of(path):
    return path.relative_to(EXAMPLES).parts[0]


def test_there_are_meshes_of_every_kind():
    some = meshes()[1]
    assert {path.suffix.lower() for path in some} == set(CHECKED)
    assert {folder_of(path) for path in some} == set(ROBOTS)
    assert len(some) > 40


def check_points(path):
    found = used_points(read_scene(path, mesh_bytes(path)))
    expected = coal.MeshLoader().load(str(path)).vertices()
    size = np.ptp(expected, axis=0).max()
    assert_close([found.min(axis=0), found.max(axis=0)], [expected.min(axis=0), expected.max(axis=0)], atol=1e-5 * size)
    counts = [len(np.unique(points.astype(np.float32), axis=0)) for points in (found, expected)]
    assert abs(counts[0] - counts[1]) <= 1, "but for one that rounding divides"


@pytest.mark.parametrize("folder", ROBOTS)
def test_a_mesh_has_the_points_that_assimp_reads(folder):
    for path in meshes()[1]:
        if folder_of(path) == folder:
            check_points(path)


@pytest.mark.slow
@pytest.mark.parametrize("folder", sorted({Path(name).parts[0] for name in URDFS.split()}))
def test_every_mesh_of_the_collection_has_the_points_that_assimp_reads(folder):
    for path in meshes()[0]:
        if folder_of(path) == folder:
            check_points(path)


@pytest.mark.slow
def test_the_meshes_of_a_folder_without_a_urdf_have_the_points_that_assimp_reads():
    for path in meshes()[0]:
        if folder_of(path) not in {Path(name).parts[0] for name in URDFS.split()}:
            check_points(path)
