"""Gathering a batch into rows of lanes, and scattering it."""

import numpy as np
import pytest

from ulna.drivers.batch import gather, scatter_matrix
from ulna.kernels.ik.search_layout import N_INFO, N_SETTINGS


@pytest.mark.parametrize(("n", "start"), [(1, 0), (7, 0), (8, 0), (9, 8), (20, 8), (20, 16)])
def test_a_block_is_filled_up_with_the_last_problem(rng, n, start):
    batch, rows = rng.normal(size=(n, 3)), np.empty((3, 8))
    gather(batch, start, rows)
    assert np.array_equal(rows.T, [batch[min(start + lane, n - 1)] for lane in range(8)])


def test_a_lane_of_poses_is_written_as_a_matrix(rng):
    rows, out = rng.normal(size=(36, 8)), np.full((4, 4), np.nan)
    scatter_matrix(rows, 2, 5, out)
    assert np.array_equal(out, [*rows[24:, 5].reshape(3, 4), [0, 0, 0, 1]])


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
