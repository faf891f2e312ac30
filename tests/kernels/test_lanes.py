"""The primitives mean what NumPy means, in every mode."""

import numpy as np
import pytest

import kernel_modes
import kernel_probes as probes
from assertions import assert_close
from ulna.engine.decorators import workspace
from ulna.engine.lanes import empty_rows, zero_rows

SPECIAL = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 3.0, 1e-300, -1e300, np.inf, -np.inf, np.nan])
PAIRS = np.array(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)


def test_operators_are_numpys(run):
    a, b = PAIRS
    with np.errstate(all="ignore"):
        expected = [a + b, a - b, a * b, a / b, -a, abs(a), a + 2.5, a - 2.5, a * 2.5, a / 2.5]
        expected += [2.5 + a, 2.5 - a, 2.5 * a, 2.5 / a, a * 3, 3 - a]
    assert_close(run(probes.arithmetic, PAIRS, 16), expected, rtol=4e-16)


def test_comparisons_are_numpys_and_false_of_nan(run):
    a, b = PAIRS
    expected = [a < b, a <= b, a > b, a >= b, a < 0.5, a <= 0.5, a > 0.5, a >= 0.5]
    expected += [0.5 < a, 0.5 <= a, 0.5 > a, 0.5 >= a]  # noqa: SIM300
    held = run(probes.comparisons, PAIRS, 12)
    assert np.array_equal(held, expected)
    assert not held[:4, np.isnan(a) | np.isnan(b)].any()


def test_masks_combine_as_truth_values(run):
    truth = np.array([[0, 0, 1, 1, np.nan, np.nan], [0, 1, 0, 1, 0, 1]])
    a, b = np.nan_to_num(truth) > 0
    assert np.array_equal(run(probes.logic, truth, 5), [a & b, a | b, ~a, (a | ~b) & b, a ^ b])


def test_where_takes_numbers_and_plain_ones_on_either_side(run):
    a, b = PAIRS
    given = run(probes.choices, PAIRS, 9)
    expected = [
        np.where(a > b, a, b),
        np.where(a > b, a, -7.0),
        np.where(a > b, 3.0, b),
        np.where(a > b, 1.0, 2.0),
        np.full(a.shape, 2.5),
    ]
    assert np.array_equal(given[:5], expected, equal_nan=True)


def test_minimum_and_maximum_choose_by_comparison(run):
    finite = PAIRS[:, ~np.isnan(PAIRS).any(axis=0)]
    given = run(probes.choices, finite, 9)
    assert np.array_equal(given[7], finite.min(axis=0))
    assert np.array_equal(given[8], finite.max(axis=0))


def test_rint_goes_to_even_on_a_tie(run):
    ties = np.array([-3.5, -2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5, 4.5])
    beside = np.concatenate([np.nextafter(ties, -np.inf), ties, np.nextafter(ties, np.inf)])
    large = [2.0**52 - 0.5, 2.0**52 + 1, -(2.0**53), 1e300, np.inf, -np.inf, np.nan]
    x = np.concatenate([beside, large])
    assert np.array_equal(run(probes.choices, [x, x], 9)[5], np.rint(x), equal_nan=True)
    assert list(run(probes.choices, [ties, ties], 9)[5]) == [-4, -2, -2, 0, 0, 2, 2, 4, 4]


def test_sqrt_is_rounded_correctly_and_nan_below_zero(run, rng):
    x = np.concatenate([10.0 ** rng.uniform(-320, 308, 100), [0.0, 1.0, 2.0, np.inf, np.nan, -1.0, -1e-320]])
    with np.errstate(invalid="ignore"):
        expected = np.sqrt(x)
    given = run(probes.choices, [x, x], 9)[6]
    assert np.array_equal(given, expected, equal_nan=True)
    assert np.isnan(given[-2:]).all()


def test_one_true_lane_is_enough_for_any(run):
    lane_alone = np.diag(np.ones(8))
    alone = run.args[0] in ("float64", "scalars")  # there every number is its own lane
    for pattern in [*lane_alone, np.ones(8), np.zeros(8), np.full(8, np.nan), np.where(lane_alone[3] > 0, 1.0, np.nan)]:
        expected = pattern > 0 if alone else np.full(8, (pattern > 0).any())
        assert np.array_equal(run(probes.any_of, pattern, 1)[0], expected)


def test_load_copies_and_store_takes_plain_numbers(run, rng):
    x = rng.normal(size=(2, 16))
    assert np.array_equal(run(probes.load_and_store, x, 4), [x[1], x[0], np.full(16, 4.0), np.full(16, 5.0)])


@pytest.mark.parametrize("n", [1, 7, 8, 9, 16])
def test_lanes_do_not_mix(run, rng, n):
    x = rng.normal(size=(2, n))
    whole = run(probes.arithmetic, x, 16)
    for k in range(n):
        assert np.array_equal(run(probes.arithmetic, x[:, k : k + 1], 16)[:, 0], whole[:, k])


@workspace
def made_rows(n):
    return empty_rows(n), zero_rows(n)


@pytest.mark.parametrize("n", [0, 1, 7])
def test_new_rows_begin_at_multiples_of_their_size(n):
    empty, zero = made_rows(n)
    assert empty.shape == zero.shape == (n, 8)
    assert empty.flags.c_contiguous
    assert zero.flags.c_contiguous
    assert not zero.any()
    if kernel_modes.COMPILED:
        assert empty.ctypes.data % 64 == zero.ctypes.data % 64 == 0


@pytest.mark.compiler
def test_functions_align_their_part_of_the_stack():
    made_rows(1)
    if kernel_modes.COMPILED:
        assert all("alignstack=64" in code for code in made_rows.inspect_llvm().values())
