"""Voxel grids: the boxes that fill them, and the space that a depth camera does not see."""

import pickle

import numpy as np
import pytest
from benchmarks.depth_camera import Camera, bin_on_a_table

import ulna


@pytest.fixture(scope="module")
def panda():
    return ulna.load("panda")


FLOOR = np.array((4.0, 4.0, 0.05)), ulna.pose((0, 0, -0.75))


def blobs(rng, shape=(12, 10, 8)):
    return rng.random(shape) < 0.1


def test_a_grid_is_the_boxes_of_its_cells(panda):
    rng = np.random.default_rng(0)
    occupied, cell, T = blobs(rng), 0.04, ulna.pose((0.6, 0.1, 0.4), (0.3, -0.2, 0.5))
    grid, cells = ulna.World(), ulna.World()
    grid.add("grid", ulna.VoxelGrid(occupied, cell), T)
    for k, index in enumerate(np.argwhere(occupied)):
        center = np.eye(4)
        center[:3, 3] = (index + 0.5 - np.array(occupied.shape) / 2) * cell
        cells.add(f"{k}", ulna.Box((cell,) * 3), T @ center)
    q = panda.random(500, seed=1)
    assert np.array_equal(panda.in_collision(q, grid, self_collision=False), panda.in_collision(q, cells, self_collision=False))
    expected = panda.signed_distance(q, cells, self_collision=False)
    apart = expected > 0
    found = panda.signed_distance(q, grid, self_collision=False)
    assert 50 < apart.sum() < 490
    np.testing.assert_allclose(found[apart], expected[apart], atol=1e-9)
    assert (found[~apart] <= 1e-12).all()


def test_runs_along_z_are_one_box_each():
    occupied = np.zeros((2, 1, 6))
    occupied[0, 0, [0, 1, 3, 4, 5]] = 1
    centers, half = ulna.VoxelGrid(occupied, 0.1, corner=(1, 2, 3)).boxes
    np.testing.assert_allclose(centers, [(1.05, 2.05, 3.1), (1.05, 2.05, 3.45)])
    np.testing.assert_allclose(half, [(0.05, 0.05, 0.1), (0.05, 0.05, 0.15)])


def test_centers_of_leaves_make_the_grid():
    rng = np.random.default_rng(2)
    occupied, corner = blobs(rng), np.array([0.3, -0.2, 0.1])
    centers = corner + (np.argwhere(occupied) + 0.5) * 0.05
    grid = ulna.VoxelGrid.of_centers(rng.permutation(centers.astype(np.float32)), 0.05)
    found = grid.corner + (np.argwhere(grid.occupied) + 0.5) * grid.cell
    np.testing.assert_allclose(sorted(map(tuple, found.round(6))), sorted(map(tuple, centers.round(6))), atol=1e-5)


def test_a_grid_without_cells_touches_nothing_and_can_be_moved(panda):
    world = ulna.World()
    world.add("none", ulna.VoxelGrid(np.zeros((3, 3, 3)), 0.1), touch_links=["panda_link0"])
    assert not panda.in_collision(panda.home, world, self_collision=False)
    world.move("none", ulna.pose((0.1, 0, 0)))
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0, 0, 0.2)))
    assert panda.in_collision(panda.home, world)


def test_a_grid_is_kept_by_pickle_and_by_a_scene(tmp_path):
    grid = ulna.VoxelGrid(blobs(np.random.default_rng(3), (4, 3, 2)), 0.05, corner=(0, 0.1, 0.2))
    world = ulna.World()
    world.add("grid", grid, ulna.pose((0.1, 0, 0)))
    ulna.save_world(world, tmp_path / "scene.json")
    loaded = {name: shape for name, shape, _ in ulna.load_world(tmp_path / "scene.json").items()}["grid"]
    for again in (pickle.loads(pickle.dumps(grid)), loaded):  # noqa: S301 - our own bytes
        assert np.array_equal(again.occupied, grid.occupied)
        assert (again.cell, *again.corner) == (grid.cell, *grid.corner)


@pytest.mark.parametrize("seed", range(3))
def test_what_is_not_in_an_unseen_cell_is_seen_to_be_empty(seed):
    rng = np.random.default_rng(seed)
    camera = Camera.of_pixels(40_000)
    image = camera.image([*bin_on_a_table(seed), FLOOR], rng)
    image[rng.random(image.shape) < 0.001] = 0  # not measured
    box, T = ulna.Box((0.9, 1.0, 0.7)), ulna.pose((0.5, 0.1, 0.3), (0, 0, 0.2))
    grid = ulna.VoxelGrid.unseen(image, camera.intrinsics, camera.pose, box, 0.03, pose=T)
    fx, fy, cx, cy = camera.intrinsics
    points = rng.uniform(-1, 1, (20_000, 3)) * np.array([0.45, 0.5, 0.35])
    index = np.floor((points - grid.corner) / grid.cell).astype(int)
    unseen = grid.occupied[tuple(index.T)]
    x, y, z = (np.linalg.inv(camera.pose) @ T @ np.column_stack([points, np.ones(len(points))]).T)[:3]
    column, row = np.rint(x / z * fx + cx).astype(int), np.rint(y / z * fy + cy).astype(int)
    inside = (z > 0) & (row >= 0) & (row < camera.height) & (column >= 0) & (column < camera.width)
    depth = np.where(inside, image[np.clip(row, 0, camera.height - 1), np.clip(column, 0, camera.width - 1)], 0)
    assert (depth[~unseen] > z[~unseen]).all()  # no point of an empty cell is hidden
    clear = depth > z + 0.1
    assert (~unseen).sum() > 0.5 * clear.sum() > 1000  # and not everything is called unseen


def test_the_robot_is_taken_out_and_plans_among_what_is_not_seen(panda):
    camera = Camera.of_pixels(40_000)
    image = camera.image([*bin_on_a_table(1), FLOOR], np.random.default_rng(1))
    T = ulna.pose((0.6, 0, 0.18))
    grid = ulna.VoxelGrid.unseen(image, camera.intrinsics, camera.pose, ulna.Box((0.6, 0.6, 0.36)), 0.03, pose=T)
    world = ulna.World()
    world.add("unseen", grid, T)
    above = ulna.pose((0.55, 0, 0.3), (np.pi, 0, 0))
    own = grid.without(panda, panda.home, padding=0.02, pose=T)
    assert not np.any(own.occupied & ~grid.occupied)
    world.reshape("unseen", own)
    assert panda.signed_distance(panda.home, world, self_collision=False) >= 0.02 - 1e-9
    plan = panda.plan(panda.home, above, world)
    assert plan.certified
    assert not panda.edge_in_collision(plan.path[:-1], plan.path[1:], world).in_collision.any()


IMAGE, K = np.full((12, 16), 0.8), (15, 15, 8, 6)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: ulna.VoxelGrid(np.ones((2, 2)), 0.1), "occupied"),
        (lambda: ulna.VoxelGrid(np.full((2, 2, 2), 0.5), 0.1), "occupied"),
        (lambda: ulna.VoxelGrid(np.full((2, 2, 2), np.nan), 0.1), "occupied"),
        (lambda: ulna.VoxelGrid([["a"]], 0.1), "occupied"),
        (lambda: ulna.VoxelGrid(np.ones((2, 2, 2)), 0), "cell"),
        (lambda: ulna.VoxelGrid(np.ones((2, 2, 2)), np.nan), "cell"),
        (lambda: ulna.VoxelGrid(np.ones((2, 2, 2)), 0.1, corner=(0, 0)), "corner"),
        (lambda: ulna.VoxelGrid(np.zeros((1, 1, 1 + (1 << 24)), dtype=bool), 0.1), "occupied"),
        (lambda: ulna.VoxelGrid.of_centers(np.zeros((0, 3)), 0.1), "centers"),
        (lambda: ulna.VoxelGrid.of_centers([(0, 0, 0), (0.13, 0, 0)], 0.1), "centers"),
        (lambda: ulna.VoxelGrid.of_centers([(0, 0, 0), (1e5, 1e5, 1e5)], 0.1), "centers"),
        (lambda: ulna.VoxelGrid.unseen(IMAGE, K, np.eye(4), ulna.Sphere(1), 0.1), "box"),
        (lambda: ulna.VoxelGrid.unseen(IMAGE, K, np.eye(4), ulna.Box((1, 1, 1)), 1e-4), "cell"),
        (lambda: ulna.VoxelGrid.unseen(IMAGE[0], K, np.eye(4), ulna.Box((1, 1, 1)), 0.1), "depth"),
        (lambda: ulna.VoxelGrid.unseen(IMAGE, (0, 15, 8, 6), np.eye(4), ulna.Box((1, 1, 1)), 0.1), "intrinsics"),
    ],
)
def test_what_is_no_grid_is_refused(make, name):
    with pytest.raises(ulna.InputError, match=name):
        make()


def test_masked_cells_are_not_free():
    known = np.ma.masked_array(np.zeros((2, 2, 2)), mask=np.eye(2)[..., None] * [1, 0] > 0)
    assert np.array_equal(ulna.VoxelGrid(known, 0.1).occupied, known.mask)
