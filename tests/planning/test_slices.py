"""A search is cut into slices of about the same time, however long an edge takes."""

from ulna.planning.slices import _FIRST_SLICE, _LONGEST_SLICE, Pace


def test_a_slice_becomes_as_long_as_is_wanted_and_stays_so():
    pace = Pace()
    for _ in range(10):
        pace.adapt(pace.checks * 1e-5, pace.checks)
    assert abs(pace.checks - 0.5 * _LONGEST_SLICE / 1e-5) <= 1


def test_a_slice_of_slow_edges_becomes_one_edge():
    pace = Pace()
    for _ in range(10):
        pace.adapt(pace.checks * 0.1, pace.checks)
    assert pace.checks == 1


def test_a_slice_that_ended_early_counts_by_the_edges_that_were_checked():
    pace = Pace()
    pace.adapt(1e-3, 1)
    assert pace.checks == _FIRST_SLICE // 2
