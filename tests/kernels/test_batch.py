"""Gathering a batch into rows of lanes, and scattering it."""

import numpy as np
import pytest

import kernel_modes
from ulna.engine.lanes import load_columns, store, store_columns
from ulna.kernels.spatial.se3 import load_pose
from ulna.kinematics.entries.batch import gather, gather_poses, scatter_matrices, scatter_matrix, scatter_rows

PLACES = [(0, 0), (1, 0), (0, 5), (1, 5)]
BLOCKS = [(1, 0), (7, 0), (8, 0), (9, 0), (9, 8), (16, 8), (17, 8), (20, 8), (20, 16)]


@pytest.mark.parametrize(("n", "start"), BLOCKS)
@pytest.mark.parametrize("columns", [1, 3, 6, 7, 8, 9, 16, 23])
def test_a_block_is_filled_up_with_the_last_problem(rng, n, start, columns):
    batch, rows = rng.normal(size=(n, columns)), np.full((columns + 1, 8), np.nan)
    gather(batch, start, rows)
    assert np.array_equal(rows[:-1].T, [batch[min(start + lane, n - 1)] for lane in range(8)])
    assert np.isnan(rows[-1]).all()


def poses_gathered(matrices, start, rows):
    gather_poses(matrices, start, rows)


@pytest.mark.parametrize(("n", "start"), BLOCKS)
def test_lanes_past_the_last_matrix_get_the_last_one(rng, n, start):
    matrices, rows = rng.normal(size=(n, 4, 4)), np.full((13, 8), np.nan)
    kernel_modes.compiled(poses_gathered)(matrices, start, rows)
    assert np.array_equal(rows[:12].T, [matrices[min(start + lane, n - 1), :3].ravel() for lane in range(8)])
    assert np.isnan(rows[12]).all()


def scattered(rows, pose_rows, out, start):
    scatter_matrices(load_pose(rows, 0), pose_rows, out, start)


@pytest.mark.parametrize(("n", "start"), BLOCKS)
def test_poses_are_written_as_the_matrices_of_their_block_and_nowhere_else(rng, n, start):
    rows, around = rng.normal(size=(12, 8)), np.full((n + 2, 4, 4), np.nan)
    out = around[1:-1]
    kernel_modes.compiled(scattered)(rows, np.empty((12, 8)), out, start)
    written = range(start, min(start + 8, n))
    for k in written:
        assert np.array_equal(out[k], [*rows[:, k - start].reshape(3, 4), [0, 0, 0, 1]])
    assert np.isnan(np.delete(around, [k + 1 for k in written], axis=0)).all()


def rows_scattered(rows, n, out, start):
    scatter_rows(rows, n, out, start)


@pytest.mark.parametrize(("n", "start"), BLOCKS)
@pytest.mark.parametrize("shape", [(1,), (6,), (7,), (8,), (9,), (2, 3), (6, 7)])
def test_rows_are_written_to_their_block_and_nowhere_else(rng, n, start, shape):
    width = int(np.prod(shape))
    rows, around = rng.normal(size=(width, 8)), np.full((n + 2, *shape), np.nan)
    kernel_modes.compiled(rows_scattered)(rows, width, around[1:-1], start)
    end = min(start + 8, n)
    assert np.array_equal(around[1 + start : 1 + end].reshape(-1, width), rows.T[: end - start])
    assert np.isnan(around[: 1 + start]).all()
    assert np.isnan(around[1 + end :]).all()


def test_a_lane_of_poses_is_written_as_a_matrix(rng):
    rows, out = rng.normal(size=(36, 8)), np.full((4, 4), np.nan)
    scatter_matrix(rows, 2, 5, out)
    assert np.array_equal(out, [*rows[24:, 5].reshape(3, 4), [0, 0, 0, 1]])


def exchanged(batch, i, k, out):
    store_columns(out, i, k, load_columns(batch, i, k))


def loaded(batch, i, k, rows):
    numbers = load_columns(batch, i, k)
    for j in range(8):
        store(rows, j, numbers[j])


@pytest.mark.parametrize(("i", "k"), PLACES)
@pytest.mark.parametrize("shape", [(9, 13), (9, 3, 5)])
def test_eight_columns_are_loaded_and_stored_where_they_were(rng, shape, i, k):
    batch, out = rng.normal(size=shape), np.full(shape, np.nan)
    kernel_modes.compiled(exchanged)(batch, i, k, out)
    expected = np.full((9, batch[0].size), np.nan)
    expected[i : i + 8, k : k + 8] = batch.reshape(9, -1)[i : i + 8, k : k + 8]
    assert np.array_equal(out.reshape(9, -1), expected, equal_nan=True)


@pytest.mark.parametrize("i", [0, 3, 7, 8])
def test_a_lane_past_the_last_row_has_the_last_row(rng, i):
    batch, rows = rng.normal(size=(9, 13)), np.empty((8, 8))
    kernel_modes.compiled(loaded)(batch, i, 4, rows)
    assert np.array_equal(rows.T, [batch[min(i + lane, 8), 4:12] for lane in range(8)])


def test_columns_past_the_end_of_a_row_are_those_of_the_next(rng):
    batch, rows = rng.normal(size=(9, 7)), np.empty((8, 8))
    kernel_modes.compiled(loaded)(batch, 0, 0, rows)
    assert np.array_equal(rows.T, [batch.reshape(-1)[7 * lane : 7 * lane + 8] for lane in range(8)])
