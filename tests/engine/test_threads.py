"""Batches in parts: their rows are those of small batches, and all have ended when the call ends, whatever made it end."""

import os
import subprocess
import sys
import threading
from threading import Event

import numpy as np
import pytest

import ulna
from ulna.engine import threads as batches
from ulna.engine.threads import LEAST_POSES, default_threads, in_parts
from ulna.errors import InputError

ROWS, PARTS = 8000, 8  # threads=2 makes four parts for each


def answer(how):
    if isinstance(how, bool):
        return how
    raise how


@pytest.fixture
def three_processors(monkeypatch):
    """A pool of three, whatever this machine has."""
    monkeypatch.setattr(batches, "n_processors", lambda: 3)
    monkeypatch.setattr(batches, "_pool_size", lambda: 3)
    monkeypatch.delenv("ULNA_THREADS", raising=False)
    batches._forget()
    yield
    batches._pool().shutdown()
    batches._forget()


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("place", ["of the caller", "of a helper"])
@pytest.mark.parametrize("how", [False, True, ZeroDivisionError, KeyboardInterrupt])
def test_no_part_runs_on_behind_the_call(how, place):
    begun, over, running, caller = Event(), Event(), set(), threading.get_ident()

    def run(rows):
        if (threading.get_ident() == caller) == (place == "of the caller"):
            assert begun.wait(10)
            return answer(how)
        running.add(rows.start)
        begun.set()
        over.wait(0.02)  # while the call lasts nobody ends this wait
        running.discard(rows.start)
        return True

    try:
        said = in_parts(run, ROWS, least=ROWS // PARTS, threads=2)
    except (ZeroDivisionError, KeyboardInterrupt) as error:
        said = type(error)
    left = set(running)
    over.set()
    assert said is how
    assert not left


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("threads", [1, 2, 3, 4, 50, np.int64(2), 0])
def test_every_row_is_in_one_part_and_no_more_threads_work_than_were_asked_for(threads):
    rows, at_work = np.zeros(10_001, dtype=int), set()

    def run(part):
        rows[part] += 1
        at_work.add(threading.get_ident())
        return True

    assert in_parts(run, len(rows), least=8, threads=threads)
    assert (rows == 1).all()
    assert len(at_work) <= max(1, threads)


@pytest.mark.usefixtures("three_processors")
def test_after_a_part_that_fails_none_is_begun():
    seen = []
    assert not in_parts(lambda part: seen.append(part.start) or part.start > 0, 8000, least=8, threads=3)
    assert len(seen) <= 3


@pytest.mark.usefixtures("three_processors")
def test_calls_from_within_parts_end_too():
    """Each waits for helpers that may never be free: it does the work itself."""
    assert in_parts(lambda _: in_parts(lambda _: in_parts(lambda _: True, 800, 8), 800, 8), 800, 8)


LONG = {
    "forward_kinematics": lambda arm, q: arm.forward_kinematics(q),
    "link_poses": lambda arm, q: arm.link_poses(q),
    "jacobian": lambda arm, q: arm.jacobian(q, expressed_in="link"),
    "differential_ik": lambda arm, q: arm.differential_ik(q, q[..., :6], dt=0.01),
}


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("name", LONG)
def test_a_batch_that_threads_share_has_the_rows_of_small_ones(panda, name, monkeypatch):
    parts, work = [], batches._run_waiting
    monkeypatch.setattr(batches, "_run_waiting", lambda run, waiting: parts.append(1) or work(run, waiting))
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (3 * LEAST_POSES + 5, panda.n_dof))
    whole = LONG[name](panda, q)
    assert len(parts) > 1, "no threads"
    for start in (0, LEAST_POSES - 40, 2 * LEAST_POSES, len(q) - 77):
        assert np.array_equal(whole[start : start + 77], LONG[name](panda, q[start : start + 77]))


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("name", LONG)
def test_a_row_out_of_range_is_reported_whichever_thread_finds_it(panda, name):
    q = np.tile(panda.home, (3 * LEAST_POSES, 1))
    q[-1, 2] = np.nan
    with pytest.raises(InputError, match=rf"q\[{len(q) - 1}, 2\]"):
        LONG[name](panda, q)


WORLD = ulna.World()
WORLD.add("crate", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.4, 0, 0.4)))
# Every method that takes a batch, with rows enough for two parts at least.
BATCHES = {
    "forward_kinematics": (40_000, lambda arm, q, **how: arm.forward_kinematics(q, **how)),
    "compile_forward": (40_000, lambda arm, q, **how: arm.compile_forward()(q, **how)),
    "link_poses": (40_000, lambda arm, q, **how: arm.link_poses(q, **how)),
    "collision_poses": (40_000, lambda arm, q, **how: arm.collision_poses(q, **how)),
    "jacobian": (40_000, lambda arm, q, **how: arm.jacobian(q, **how)),
    "compile_jacobian": (40_000, lambda arm, q, **how: arm.compile_jacobian()(q, **how)),
    "analytical_jacobian": (40_000, lambda arm, q, **how: arm.analytical_jacobian(q, **how)),
    "manipulability": (40_000, lambda arm, q, **how: arm.manipulability(q, **how)),
    "differential_ik": (3000, lambda arm, q, **how: arm.differential_ik(q, np.ones(6), dt=0.01, **how)),
    "in_collision": (3000, lambda arm, q, **how: arm.in_collision(q, WORLD, **how)),
    "signed_distance": (3000, lambda arm, q, **how: arm.signed_distance(q, WORLD, **how)),
    "distance_gradient": (3000, lambda arm, q, **how: arm.distance_gradient(q, WORLD, **how)),
    "edge_in_collision": (200, lambda arm, q, **how: arm.edge_in_collision(q, arm.home, WORLD, **how).free_until),
    "distances": (600, lambda arm, q, **how: arm.distances(q, WORLD, within=0.2, **how).gradient),
    "check_collision": (600, lambda arm, q, **how: np.array([str(r) for r in arm.check_collision(q, WORLD, **how)])),
    "inverse_kinematics": (3000, lambda arm, q, **how: arm.inverse_kinematics(arm.forward_kinematics(q), **how).q),
    "inverse_kinematics, world": (
        300,
        lambda arm, q, **how: arm.inverse_kinematics(arm.forward_kinematics(q), world=WORLD, rank="clearance", **how).q,
    ),
}


@pytest.mark.slow
@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("name", BATCHES)
def test_any_number_of_threads_gives_the_same_bits(panda, name):
    n, call = BATCHES[name]
    q = np.random.default_rng(1).uniform(panda.lower, panda.upper, (n, panda.n_dof))
    one = call(panda, q, threads=1)
    for threads in (None, 2, 3, 5):
        assert np.array_equal(one, call(panda, q, threads=threads))


@pytest.mark.parametrize("name", BATCHES)
def test_every_batch_ends_at_ctrl_c_between_two_slices(panda, name, monkeypatch):
    n, call = BATCHES[name]
    q = np.random.default_rng(1).uniform(panda.lower, panda.upper, (n, panda.n_dof))
    slices, in_slices = [], batches._in_slices

    def interrupted(run, part, least, ended):
        def one(rows):
            slices.append(rows)
            if len(slices) == 2:
                raise KeyboardInterrupt
            return run(rows)

        return in_slices(one, part, least, ended)

    monkeypatch.setattr(batches, "_in_slices", interrupted)
    with pytest.raises(KeyboardInterrupt):
        call(panda, q, threads=1)
    assert len(slices) == 2, "rows are run after it"


@pytest.mark.parametrize("name", BATCHES)
@pytest.mark.parametrize("threads", [-1, 1.5, "all", True, 2**31])
def test_what_is_no_number_of_threads_is_refused(panda, name, threads):
    with pytest.raises(InputError, match=r"^threads: "):
        BATCHES[name][1](panda, np.tile(panda.home, (3, 1)), threads=threads)


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", "1e3", "²", "99999999999"])
def test_an_environment_variable_that_is_no_number_of_threads_is_refused(panda, monkeypatch, text):
    monkeypatch.setenv("ULNA_THREADS", text)
    default_threads.cache_clear()
    try:
        for _ in range(2):
            with pytest.raises(InputError, match=r"^ULNA_THREADS: .*whole number of threads"):
                panda.forward_kinematics([panda.home] * 2)
        assert panda.forward_kinematics([panda.home] * 2, threads=1).shape == (2, 4, 4)
    finally:
        default_threads.cache_clear()


COUNT = """
import threading, numpy as np, ulna
panda = ulna.load("panda")
q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (4000, 7))
for threads in (None, *range(1, 40)):
    panda.in_collision(q, threads=threads)
print(sum(thread.name.startswith("ulna") for thread in threading.enumerate()))
"""


def count_threads(**variables):
    environment = {**os.environ, **variables}
    return int(subprocess.run([sys.executable, "-c", COUNT], env=environment, capture_output=True, text=True, check=True).stdout)


def test_one_pool_serves_all_values_of_threads():
    assert count_threads() <= os.cpu_count()


def test_the_environment_variable_is_what_is_used_unless_a_call_says_otherwise(monkeypatch):
    monkeypatch.setenv("ULNA_THREADS", " 7 ")
    default_threads.cache_clear()
    assert default_threads() == 7
    monkeypatch.setenv("ULNA_THREADS", "")
    assert default_threads() == 7  # found once
    default_threads.cache_clear()
    assert default_threads() == batches.n_processors()


@pytest.mark.process
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks")
def test_a_fork_asks_again():
    code = """
import os, ulna.engine.threads as t
first = t.default_threads()
t.in_parts(lambda _: True, 10_000, 8, threads=2)
os.environ["ULNA_THREADS"] = str(first + 5)
if os.fork() == 0:
    assert t.in_parts(lambda _: True, 10_000, 8, threads=2)
    os._exit(t.default_threads() - first)
print(os.waitstatus_to_exitcode(os.wait()[1]), t.default_threads() - first)
"""
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "5 0\n"


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_a_batch_of_slow_rows_after_a_slice_in_every_thread(threads):
    """Rows of about a millisecond: without slices a part of them is the whole batch, or an eighth of it."""
    done, n = [], 40_000

    def run(rows):
        Event().wait(1e-6 * (rows.stop - rows.start))
        done.append(rows.stop - rows.start)
        if threading.current_thread() is threading.main_thread() and len(done) > 2:
            raise KeyboardInterrupt
        return True

    with pytest.raises(KeyboardInterrupt):
        in_parts(run, n, least=8, threads=threads)
    assert sum(done) < n // 2
    assert all(size % 8 == 0 for size in done)


def test_slices_are_as_many_rows_as_take_a_while_and_small_batches_are_one_call():
    sizes = []

    def run(rows):
        sizes.append(rows.stop - rows.start)
        return True

    assert in_parts(run, 1000, least=1024, threads=1)
    assert sizes == [1000]
    sizes.clear()
    assert in_parts(run, 100_001, least=64, threads=1)
    assert sum(sizes) == 100_001
    assert sizes[:3] == [64, 1024, 16_384], "a slice that takes no time is followed by one sixteen times as long"
