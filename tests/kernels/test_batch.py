"""Gathering a batch into rows of lanes, and scattering it."""

import numpy as np
import pytest

import kernel_modes
from ulna.drivers.batch import gather, scatter_matrices, scatter_matrix, scatter_rows
from ulna.engine.lanes import load_run, store_run, transposed
from ulna.kernels.ik.search_layout import N_INFO, N_SETTINGS
from ulna.kernels.spatial.se3 import load_pose

BLOCKS = [(1, 0), (7, 0), (8, 0), (9, 0), (9, 8), (16, 8), (17, 8), (20, 8), (20, 16)]


@pytest.mark.parametrize(("n", "start"), BLOCKS)
@pytest.mark.parametrize("columns", [1, 3, 6, 7, 8, 9, 16, 23])
def test_a_block_is_filled_up_with_the_last_problem(rng, n, start, columns):
    batch, rows = rng.normal(size=(n, columns)), np.full((columns + 1, 8), np.nan)
    gather(batch, start, rows)
    assert np.array_equal(rows[:-1].T, [batch[min(start + lane, n - 1)] for lane in range(8)])
    assert np.isnan(rows[-1]).all()


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


def exchanged(batch, k, out):
    numbers = transposed(
        load_run(batch, 0, k), load_run(batch, 1, k), load_run(batch, 2, k), load_run(batch, 3, k),
        load_run(batch, 4, k), load_run(batch, 5, k), load_run(batch, 6, k), load_run(batch, 7, k),
    )  # fmt: skip
    for lane in range(8):
        store_run(out, lane, k, numbers[lane])


@pytest.mark.parametrize("shape", [(8, 8), (9, 13), (8, 3, 5)])
def test_lanes_and_numbers_are_exchanged_in_place(rng, shape):
    batch, out = rng.normal(size=shape), np.full(shape, np.nan)
    kernel_modes.compiled(exchanged)(batch, 0, out)
    assert np.array_equal(out.reshape(shape[0], -1)[:8, :8].T, batch.reshape(shape[0], -1)[:8, :8])
    assert np.isnan(out).sum() == out.size - 64


def test_the_settings_and_the_information_have_a_place_for_each_name():
    from ulna.kernels.ik import search_layout as layout

    settings = (
        layout.POSITION_TOLERANCE,
        layout.ROTATION_TOLERANCE,
        layout.STEPS,
        layout.CALM,
        layout.FIRST_WINS,
        layout.WITH_POSTURE,
        layout.TASK,
        layout.FAR,
        layout.SEEDED_STEPS,
        *range(layout.SLACK, layout.SLACK + 6),
    )
    information = (
        layout.STATUS,
        layout.POSITION_ERROR,
        layout.ROTATION_ERROR,
        layout.ITERATIONS,
        layout.START,
        layout.DAMPING,
        layout.MISSED,
        *range(layout.RESIDUAL, layout.RESIDUAL + 6),
    )
    assert sorted(settings) == list(range(N_SETTINGS))
    assert sorted(information) == list(range(N_INFO))
