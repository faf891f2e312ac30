"""The clock, judged by work whose time is known in proportion."""

import time

import numpy as np
from benchmarks.ratio import ratio

from ulna.bench.timing import Timing, Workload, one_pass, time_each, time_interleaved


def wait(nanoseconds):
    """Busy until the time is over: sleeping would end when the system likes."""
    end = time.perf_counter_ns() + nanoseconds
    while time.perf_counter_ns() < end:
        pass


def test_a_pass_takes_at_least_what_its_calls_take():
    assert one_pass(Workload(wait, [200_000] * 5)) >= 195_000


def test_the_time_is_that_of_one_problem_of_a_batch():
    assert one_pass(Workload(wait, [200_000] * 5, problems=100)) >= 1_950


def test_works_take_turns_after_a_warm_up_that_does_not_count():
    seen = []
    works = {name: Workload(lambda x, name=name: seen.append((name, x)), [1, 2]) for name in "ab"}
    timings = time_interleaved(works, passes=3)
    assert seen == [("a", 1), ("a", 2), ("b", 1), ("b", 2)] * 4
    assert timings["a"].passes.shape == (3,)
    assert timings["a"].lower <= timings["a"].median <= timings["a"].upper


def test_a_ratio_is_taken_pass_by_pass():
    slow = Timing(0, 0, 0, np.array([2.0, 40.0, 6.0]))
    quick = Timing(0, 0, 0, np.array([1.0, 10.0, 2.0]))
    assert ratio(slow, quick) == (2.5, 3.0, 3.5)


def test_each_input_has_its_own_time():
    times = time_each(lambda duration, _: wait(duration), [(50_000, 0), (500_000, 0)], passes=3)
    assert times[0] >= 45_000
    assert times[1] >= 450_000
    assert times[0] < times[1]


def test_what_the_loop_costs_is_taken_off_but_no_time_is_negative():
    assert 0 <= one_pass(Workload(lambda _: None, [0])) < 1e6
