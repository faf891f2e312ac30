import numpy as np
import pytest

from ulna.errors import InputError
from ulna.reachability.grid import Grid

GRIDS = [
    Grid((-1.0, -0.5, 0.0), 0.1, (3, 4, 5), 7, 16),
    Grid((0.0, 0.0, 0.0), 1.0, (1, 1, 1), 1, 4096),
    Grid((0.0, 0.0, 0.0), 0.5, (2, 3, 1), 50, 8),
    Grid((-1.0, -1.0, -1.0), 0.2, (9, 10, 11), 6, 4096),
]


@pytest.mark.parametrize("grid", GRIDS, ids=str)
def test_the_chunks_cover_every_pose_once(grid):
    counts = np.zeros((*grid.shape, grid.orientations), dtype=int)
    for chunk in range(grid.n_chunks):
        counts[grid.region(chunk)] += 1
        assert counts[grid.region(chunk)].size <= grid.chunk_poses
    assert (counts == 1).all()
    assert counts.size == grid.n_poses


@pytest.mark.parametrize("grid", GRIDS, ids=str)
def test_the_targets_of_a_region_are_the_centers_with_every_orientation(grid):
    region = grid.region(grid.n_chunks - 1)
    shape = tuple(cut.stop - cut.start for cut in region)
    T = grid.targets(region).reshape(*shape, 4, 4)
    for k in np.ndindex(shape):
        z, y, x, o = (int(i) + cut.start for i, cut in zip(k, region, strict=True))
        center = np.array(grid.low) + (np.array([x, y, z]) + 0.5) * grid.voxel
        np.testing.assert_allclose(T[k][:3, 3], center, rtol=0, atol=1e-12)
        assert (T[k][:3, :3] == grid.rotations[o]).all()
        assert T[k][3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("grid", GRIDS, ids=str)
def test_a_center_lies_in_its_voxel(grid):
    z, y, x = np.meshgrid(*grid.axes, indexing="ij")
    index, inside = grid.voxel_of(np.stack([x, y, z], axis=-1))
    assert inside.all()
    assert (index == np.moveaxis(np.indices(grid.shape), 0, -1)).all()


def test_a_point_outside_is_outside_and_has_the_nearest_voxel():
    grid = GRIDS[0]
    index, inside = grid.voxel_of(np.array([[-1.01, -0.45, 0.05], [-0.51, -0.11, 0.29], [9.0, 9.0, 9.0]]))
    assert inside.tolist() == [False, True, False]
    assert index.tolist() == [[0, 0, 0], [2, 3, 4], [2, 3, 4]]


def test_a_box_is_covered_from_its_lowest_corner():
    grid = Grid.within([(-0.2, 0.0, 0.1), (0.4, 0.25, 0.2)], 0.1, 3)
    assert grid.shape == (1, 3, 6)
    assert grid.low == (-0.2, 0.0, 0.1)


@pytest.mark.parametrize(
    ("bounds", "voxel", "orientations", "argument"),
    [
        ([(0, 0, 0), (1, 1, 0)], 0.1, 1, "bounds"),
        ([(0, 0, 0), (1, 1, np.inf)], 0.1, 1, "bounds"),
        ([0, 1], 0.1, 1, "bounds"),
        ([(0, 0, 0), (1, 1, 1)], 0.0, 1, "voxel"),
        ([(0, 0, 0), (1, 1, 1)], "small", 1, "voxel"),
        ([(0, 0, 0), (1, 1, 1)], 1e-6, 1, "voxel"),
        ([(0, 0, 0), (1, 1, 1)], 0.1, 0, "orientations"),
        ([(0, 0, 0), (1, 1, 1)], 0.1, 2.5, "orientations"),
    ],
)
def test_what_is_no_grid_is_refused(bounds, voxel, orientations, argument):
    with pytest.raises(InputError) as refused:
        Grid.within(bounds, voxel, orientations)
    assert refused.value.argument == argument
