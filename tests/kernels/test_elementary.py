"""Sine, cosine and angle against NumPy's, on both sides of every border between their branches."""

import numpy as np
import pytest

import kernel_probes as probes
from assertions import assert_close
from ulna.kernels.layout import LARGEST
from ulna.kernels.spatial.elementary import all_in_range

BESIDE = (-1e-3, -1e-9, -1e-15, 0.0, 1e-15, 1e-9, 1e-3)


def beside(x):
    """The numbers, their neighbors in floating point, and numbers a little off on both sides."""
    x = np.asarray(x)
    near = [x * (1 + d) for d in BESIDE] + [np.nextafter(x, -np.inf), np.nextafter(x, np.inf)]
    return np.concatenate(near)


def assert_sine_and_cosine(run, x, tolerance=3e-16):
    s, c = run(probes.sine_and_cosine, x, 2)
    assert abs(s - np.sin(x)).max() <= tolerance
    assert abs(c - np.cos(x)).max() <= tolerance


@pytest.mark.parametrize("largest", [1.0, 10.0, 1e3, 1e6])
def test_sine_and_cosine_are_right_to_two_units_in_the_last_place(run, rng, largest):
    assert_sine_and_cosine(run, rng.uniform(-largest, largest, 4000))


def test_sine_and_cosine_beside_every_border_of_a_quadrant(run):
    eighths = np.concatenate([np.arange(-40, 41), [10_001, 123_457, 1_000_003, 1_273_238, -1_273_239]])
    x = beside(eighths * np.pi / 4)
    assert_sine_and_cosine(run, x[abs(x) <= 1e6])


def test_small_results_keep_their_relative_accuracy(run):
    k = np.concatenate([np.arange(1, 50), [1000, 20_000, 318_309]])
    s, _ = run(probes.sine_and_cosine, k * np.pi, 2)
    assert_close(s, np.sin(k * np.pi), rtol=4e-16)  # about 1e-16 to 1e-10, from the rounding of k pi
    tiny = 10.0 ** np.arange(-300.0, -3.0)
    assert_close(run(probes.sine_and_cosine, tiny, 2)[0], np.sin(tiny), rtol=4e-16)


def test_sine_and_cosine_of_exact_arguments(run):
    s, c = run(probes.sine_and_cosine, [0.0, np.pi / 6, np.pi / 3, np.pi / 2, np.pi], 2)
    assert_close(s, [0, 0.5, np.sqrt(3) / 2, 1, 0], atol=3e-16)
    assert_close(c, [1, np.sqrt(3) / 2, 0.5, 0, -1], atol=3e-16)
    assert s[0] == 0.0
    assert c[0] == 1.0


def test_sine_is_odd_and_cosine_even(run, rng):
    x = rng.uniform(0, 1e4, 500)
    (s, c), (minus_s, minus_c) = run(probes.sine_and_cosine, x, 2), run(probes.sine_and_cosine, -x, 2)
    assert np.array_equal(s, -minus_s)
    assert np.array_equal(c, minus_c)


def test_what_is_no_number_has_no_sine(run):
    assert np.isnan(run(probes.sine_and_cosine, [np.nan, np.inf, -np.inf], 2)).all()


def test_the_angle_of_a_point_is_arctan2s(run, rng):
    angle = np.concatenate([rng.uniform(0, np.pi / 2, 3000), beside([np.pi / 8, np.pi / 4, 3 * np.pi / 8]), [0, np.pi / 2]])
    radius = 10.0 ** rng.uniform(-100, 100, angle.size)
    x, y = abs(radius * np.cos(angle)), radius * np.sin(angle)
    assert_close(run(probes.angle_in_first_quadrant, [y, x], 1)[0], np.arctan2(y, x), rtol=5e-16)


def test_the_angle_near_the_axes_keeps_its_digits(run):
    tiny = 10.0 ** np.arange(-300.0, 0.0)
    one = np.ones_like(tiny)
    assert_close(run(probes.angle_in_first_quadrant, [tiny, one], 1)[0], np.arctan2(tiny, one), rtol=5e-16)
    assert_close(run(probes.angle_in_first_quadrant, [one, tiny], 1)[0], np.arctan2(one, tiny), rtol=5e-16)
    assert list(run(probes.angle_in_first_quadrant, [[0.0, 2.0], [2.0, 0.0]], 1)[0]) == [0.0, np.pi / 2]


@pytest.mark.parametrize("shape", [(4,), (4, 8)])
def test_numbers_up_to_the_largest_are_in_range(shape):
    assert all_in_range(np.zeros(shape))
    assert all_in_range(np.full(shape, LARGEST))
    assert all_in_range(np.full(shape, -LARGEST))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, np.nextafter(LARGEST, np.inf), -1.1 * LARGEST, 1e300])
def test_one_bad_number_anywhere_is_out_of_range(bad):
    for place in np.ndindex(4, 8):
        rows = np.zeros((4, 8))
        rows[place] = bad
        assert not all_in_range(rows)
    for place in range(4):
        rows = np.zeros(4)
        rows[place] = bad
        assert not all_in_range(rows)
