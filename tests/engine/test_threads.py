"""Batches in parts: their rows are those of small batches, and all have ended when the call ends, whatever made it end."""

import ast
import contextvars
import os
import subprocess
import sys
import threading
from pathlib import Path
from threading import Event

import numpy as np
import pytest

import ulna
from ulna.engine import threads as batches
from ulna.engine.threads import MIN_POSES, default_threads, in_parts, in_rows, in_slices, n_threads
from ulna.errors import InputError, UnknownArgumentError

ROWS, PARTS = 8000, 8  # two threads make four parts each


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
    with ulna.threads(None):
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
        with ulna.threads(2):
            said = in_parts(run, ROWS, least=ROWS // PARTS)
    except (ZeroDivisionError, KeyboardInterrupt) as error:
        said = type(error)
    left = set(running)
    over.set()
    assert said is how
    assert not left


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("threads", [1, 2, 3, 4, 50, np.int64(2)])
def test_every_row_is_in_one_part_and_no_more_threads_work_than_were_asked_for(threads):
    rows, at_work = np.zeros(10_001, dtype=int), set()

    def run(part):
        rows[part] += 1
        at_work.add(threading.get_ident())
        return True

    with ulna.threads(threads):
        assert in_parts(run, len(rows), least=8)
    assert (rows == 1).all()
    assert len(at_work) <= threads


@pytest.mark.usefixtures("three_processors")
def test_after_a_part_that_fails_none_is_begun():
    seen = []
    with ulna.threads(3):
        assert not in_parts(lambda part: seen.append(part.start) or part.start > 0, 8000, least=8)
    assert len(seen) <= 3


@pytest.mark.usefixtures("three_processors")
def test_calls_from_within_parts_end_too():
    assert in_parts(lambda _: in_parts(lambda _: in_parts(lambda _: True, 800, 8), 800, 8), 800, 8)


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("share", ["parts", "rows"])
def test_work_within_several_threads_starts_no_more(share):
    numbers, at_work, all_begun = [], set(), threading.Barrier(3)

    def run(_):
        if threading.get_ident() not in at_work:
            at_work.add(threading.get_ident())
            all_begun.wait(10)  # so that each of the three has a part
        numbers.append(n_threads())
        return True

    assert in_parts(run, ROWS, least=8) if share == "parts" else in_rows(run, 30)
    assert (len(at_work), set(numbers)) == (3, {1})
    assert n_threads() == 3, "the caller has its own setting again"


@pytest.mark.usefixtures("three_processors")
def test_parts_of_all_threads_run_in_the_context_of_the_caller():
    name, seen = contextvars.ContextVar("name"), set()
    name.set("of the caller")
    assert in_parts(lambda _: seen.add(name.get("none")) is None, ROWS, least=8)
    assert seen == {"of the caller"}


# ---- the setting


@pytest.mark.usefixtures("three_processors")
def test_the_setting_holds_from_now_on_and_none_is_the_default():
    assert n_threads() == 3
    for n in (1, 2, np.int64(7), 50):
        ulna.threads(n)
        assert (n_threads(), type(n_threads())) == (n, int)
    ulna.threads(None)
    assert n_threads() == 3


@pytest.mark.usefixtures("three_processors")
def test_the_end_of_a_block_restores_what_was_set_before():
    ulna.threads(2)
    with ulna.threads(1):
        assert n_threads() == 1
        with ulna.threads(None):
            assert n_threads() == 3
            ulna.threads(5)
            assert n_threads() == 5
        assert n_threads() == 1
    assert n_threads() == 2


@pytest.mark.usefixtures("three_processors")
def test_a_block_that_ends_by_an_error_restores_the_setting_too():
    ulna.threads(2)
    with pytest.raises(KeyboardInterrupt), ulna.threads(1):
        raise KeyboardInterrupt
    assert n_threads() == 2


@pytest.mark.usefixtures("three_processors")
def test_a_setting_may_be_kept_and_entered_later_and_again():
    one = ulna.threads(1)
    ulna.threads(2)
    for _ in range(2):
        with one:
            assert n_threads() == 1
        assert n_threads() == 3, "as before it was made"


@pytest.mark.usefixtures("three_processors")
def test_a_number_that_is_refused_leaves_the_setting_as_it_was():
    ulna.threads(2)
    with pytest.raises(InputError):
        ulna.threads(0)
    assert n_threads() == 2


@pytest.mark.usefixtures("three_processors")
def test_another_thread_and_another_context_have_settings_of_their_own():
    ulna.threads(2)
    seen = []

    def other():
        seen.append(n_threads())
        ulna.threads(1)
        seen.append(n_threads())

    thread = threading.Thread(target=other, daemon=True)
    contextvars.Context().run(thread.start)  # from Python 3.14 on a thread may begin with the context of its starter
    thread.join(10)
    assert (seen, n_threads()) == ([3, 1], 2)
    contextvars.copy_context().run(other)
    assert (seen, n_threads()) == ([3, 1, 2, 1], 2)


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("n", [1, 2, 3])
def test_many_plans_run_in_as_many_threads_as_are_set(panda, monkeypatch, n):
    at_work, waiting = set(), batches._run_waiting
    monkeypatch.setattr(batches, "_run_waiting", lambda *a: at_work.add(threading.get_ident()) or waiting(*a))
    goal, seen = panda.home + 0.1, []
    with ulna.threads(n):
        panda.plan_many(panda.home, [goal] * 6, progress=lambda *_: seen.append(n_threads()))
    assert len(at_work) <= n
    assert set(seen) == {1}


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
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (3 * MIN_POSES + 5, panda.n_dof))
    whole = LONG[name](panda, q)
    assert len(parts) > 1, "no threads"
    for start in (0, MIN_POSES - 40, 2 * MIN_POSES, len(q) - 77):
        assert np.array_equal(whole[start : start + 77], LONG[name](panda, q[start : start + 77]))


@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("name", LONG)
def test_a_row_out_of_range_is_reported_whichever_thread_finds_it(panda, name):
    q = np.tile(panda.home, (3 * MIN_POSES, 1))
    q[-1, 2] = np.nan
    with pytest.raises(InputError, match=rf"q\[{len(q) - 1}, 2\]"):
        LONG[name](panda, q)


WORLD = ulna.World()
WORLD.add("crate", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.4, 0, 0.4)))
# Every method that takes a batch, with rows enough for two parts at least.
BATCHES = {
    "forward_kinematics": (40_000, lambda arm, q: arm.forward_kinematics(q)),
    "compile_forward": (40_000, lambda arm, q: arm.compile_forward()(q)),
    "link_poses": (40_000, lambda arm, q: arm.link_poses(q)),
    "collision_poses": (40_000, lambda arm, q: arm.collision_poses(q)),
    "jacobian": (40_000, lambda arm, q: arm.jacobian(q)),
    "compile_jacobian": (40_000, lambda arm, q: arm.compile_jacobian()(q)),
    "analytical_jacobian": (40_000, lambda arm, q: arm.analytical_jacobian(q)),
    "manipulability": (40_000, lambda arm, q: arm.manipulability(q)),
    "differential_ik": (3000, lambda arm, q: arm.differential_ik(q, np.ones(6), dt=0.01)),
    "in_collision": (3000, lambda arm, q: arm.in_collision(q, WORLD)),
    "signed_distance": (3000, lambda arm, q: arm.signed_distance(q, WORLD)),
    "distance_gradient": (3000, lambda arm, q: arm.distance_gradient(q, WORLD)),
    "edge_in_collision": (200, lambda arm, q: arm.edge_in_collision(q, arm.home, WORLD).free_until),
    "distances": (600, lambda arm, q: arm.distances(q, WORLD, within=0.2).gradient),
    "check_collision": (600, lambda arm, q: np.array([str(r) for r in arm.check_collision(q, WORLD)])),
    "inverse_kinematics": (3000, lambda arm, q: arm.inverse_kinematics(arm.forward_kinematics(q)).q),
    "inverse_kinematics, world": (
        300,
        lambda arm, q: arm.inverse_kinematics(arm.forward_kinematics(q), world=WORLD, rank="clearance").q,
    ),
    "all_solutions": (200, lambda arm, q: arm.all_solutions(arm.forward_kinematics(q)).q),
    "follow": (40, lambda arm, q: arm.follow(arm.forward_kinematics(arm.home + np.linspace(0, 0.4, len(q))[:, None])).q),
}


@pytest.mark.slow
@pytest.mark.usefixtures("three_processors")
@pytest.mark.parametrize("name", BATCHES)
def test_any_number_of_threads_gives_the_same_bits(panda, name):
    n, call = BATCHES[name]
    q = np.random.default_rng(1).uniform(panda.lower, panda.upper, (n, panda.n_dof))
    with ulna.threads(1):
        one = call(panda, q)
    for threads in (None, 2, 3, 5):
        with ulna.threads(threads):
            assert call(panda, q).tobytes() == one.tobytes()


@pytest.mark.parametrize("name", [name for name in BATCHES if name not in {"all_solutions", "follow"}])
def test_every_batch_ends_at_ctrl_c_between_two_slices(panda, name, monkeypatch):
    n, call = BATCHES[name]
    q = np.random.default_rng(1).uniform(panda.lower, panda.upper, (n, panda.n_dof))
    slices, in_slices = [], batches.in_slices

    def interrupted(run, part, least, ended=()):
        def one(rows):
            slices.append(rows)
            if len(slices) == 2:
                raise KeyboardInterrupt
            return run(rows)

        return in_slices(one, part, least, ended)

    monkeypatch.setattr(batches, "in_slices", interrupted)
    with pytest.raises(KeyboardInterrupt), ulna.threads(1):
        call(panda, q)
    assert len(slices) == 2, "rows are run after it"


@pytest.mark.parametrize(
    "threads", [0, -1, 1.5, 2.0, "all", "2", True, False, np.True_, 2**31, 10**400, [1], np.ones(2, int), b"1"]
)
def test_what_is_no_number_of_threads_is_refused(threads):
    with pytest.raises(InputError, match=r"^threads: .*whole number from 1 .*None for the default") as caught:
        ulna.threads(threads)
    assert caught.value.argument == "threads"
    assert len(str(caught.value)) < 400


T = ulna.pose((0.5, 0, 0.4), (np.pi, 0, 0))
# Every function that took ``threads=`` once, with its name.
FORMER = {
    "forward_kinematics": lambda arm, **how: arm.forward_kinematics(arm.home, **how),
    "forward_kinematics, frame": lambda arm, **how: arm.forward_kinematics(arm.home, frame="panda_link1", **how),
    "link_poses": lambda arm, **how: arm.link_poses(arm.home, **how),
    "collision_poses": lambda arm, **how: arm.collision_poses(arm.home, **how),
    "jacobian": lambda arm, **how: arm.jacobian(arm.home, **how),
    "analytical_jacobian": lambda arm, **how: arm.analytical_jacobian(arm.home, **how),
    "manipulability": lambda arm, **how: arm.manipulability(arm.home, **how),
    "CompiledForward": lambda arm, **how: arm.compile_forward()(arm.home, **how),
    "CompiledJacobian": lambda arm, **how: arm.compile_jacobian()(arm.home, **how),
    "differential_ik": lambda arm, **how: arm.differential_ik(arm.home, np.ones(6), dt=0.01, **how),
    "inverse_kinematics": lambda arm, **how: arm.inverse_kinematics(T, **how),
    "all_solutions": lambda arm, **how: arm.all_solutions(T, **how),
    "follow": lambda arm, **how: arm.follow(T[None], **how),
    "in_collision": lambda arm, **how: arm.in_collision(arm.home, WORLD, **how),
    "check_collision": lambda arm, **how: arm.check_collision(arm.home, WORLD, **how),
    "distances": lambda arm, **how: arm.distances(arm.home, WORLD, **how),
    "signed_distance": lambda arm, **how: arm.signed_distance(arm.home, WORLD, **how),
    "distance_gradient": lambda arm, **how: arm.distance_gradient(arm.home, WORLD, **how),
    "edge_in_collision": lambda arm, **how: arm.edge_in_collision(arm.home, arm.home, WORLD, **how),
    "plan_many": lambda arm, **how: arm.plan_many(arm.home, [arm.home], seed=1, **how),
    "reachability_map": lambda arm, **how: ulna.reachability_map(arm, "nowhere.zarr", voxel=0.5, orientations=1, **how),
}


@pytest.mark.parametrize("name", FORMER)
@pytest.mark.parametrize("threads", [1, None])
def test_threads_as_an_argument_is_refused_with_the_setting_that_took_its_place(panda, name, threads):
    with pytest.raises(UnknownArgumentError) as caught:
        FORMER[name](panda, threads=threads)
    function = name.partition(",")[0]
    assert str(caught.value).startswith(f"{function}() got an unexpected keyword argument 'threads'; ulna.threads(n) ")
    assert (caught.value.function, caught.value.argument) == (function, "threads")
    assert isinstance(caught.value, TypeError)


@pytest.mark.parametrize("name", sorted(FORMER.keys() - {"plan_many", "check_collision"}))
def test_another_argument_that_there_is_not_is_refused_in_the_words_of_python(panda, name):
    with pytest.raises(UnknownArgumentError) as caught:
        FORMER[name](panda, thread=1)
    assert str(caught.value) == f"{name.partition(',')[0]}() got an unexpected keyword argument 'thread'"


def test_no_signature_has_the_number_of_threads():
    """But for the setting itself, and the option of the command line that sets it."""
    source, found = Path(ulna.__file__).parent, set()
    for file in source.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.Lambda) and "threads" in {
                one.arg for one in ast.walk(node.args) if isinstance(one, ast.arg)
            }:
                found.add(file.relative_to(source).as_posix())
    assert found == {"cli/reach.py"}


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", "1e3", "²", "99999999999"])
def test_an_environment_variable_that_is_no_number_of_threads_is_refused(panda, monkeypatch, text):
    monkeypatch.setenv("ULNA_THREADS", text)
    default_threads.cache_clear()
    try:
        for _ in range(2):
            with pytest.raises(InputError, match=r"^ULNA_THREADS: .*whole number of threads"):
                panda.forward_kinematics([panda.home] * 2)
        assert panda.forward_kinematics(panda.home).shape == (4, 4), "one configuration needs no number of threads"
        with ulna.threads(1):
            assert panda.forward_kinematics([panda.home] * 2).shape == (2, 4, 4)
    finally:
        default_threads.cache_clear()


COUNT = """
import threading, numpy as np, ulna
panda = ulna.load("panda")
q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (4000, 7))
for threads in (None, *range(1, 40)):
    with ulna.threads(threads):
        panda.in_collision(q)
print(sum(thread.name.startswith("ulna") for thread in threading.enumerate()))
"""


def count_threads(**variables):
    environment = {**os.environ, **variables}
    return int(subprocess.run([sys.executable, "-c", COUNT], env=environment, capture_output=True, text=True, check=True).stdout)


def test_one_pool_serves_all_numbers_of_threads():
    assert count_threads() <= os.cpu_count()


def test_the_environment_variable_is_the_default(monkeypatch):
    monkeypatch.setenv("ULNA_THREADS", " 7 ")
    default_threads.cache_clear()
    assert default_threads() == n_threads() == 7
    with ulna.threads(2):
        assert n_threads() == 2
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
with t.threads(2):
    t.in_parts(lambda _: True, 10_000, 8)
os.environ["ULNA_THREADS"] = str(first + 5)
if os.fork() == 0:
    with t.threads(2):
        assert t.in_parts(lambda _: True, 10_000, 8)
    os._exit(t.n_threads() - first)
print(os.waitstatus_to_exitcode(os.wait()[1]), t.n_threads() - first)
"""
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "5 0\n"


@pytest.mark.process
@pytest.mark.parametrize(("text", "said"), [("2", "2 1 2"), ("none", "ULNA_THREADS")])
def test_the_environment_variable_of_a_process_is_its_default_and_is_read_when_it_is_first_needed(text, said):
    code = """
import ulna
from ulna.engine.threads import n_threads
ulna.threads(1)
assert n_threads() == 1
ulna.threads(None)
try:
    before = n_threads()
    with ulna.threads(1):
        within = n_threads()
    print(before, within, n_threads())
except ulna.InputError as error:
    print(error.argument)
"""
    run = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "ULNA_THREADS": text}, capture_output=True, text=True, check=True
    )
    assert run.stdout == f"{said}\n"


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

    with pytest.raises(KeyboardInterrupt), ulna.threads(threads):
        in_parts(run, n, least=8)
    assert sum(done) < n // 2
    assert all(size % 8 == 0 for size in done)


def test_slices_are_as_many_rows_as_take_a_while_and_small_batches_are_one_call():
    sizes = []

    def run(rows):
        sizes.append(rows.stop - rows.start)
        return True

    assert in_slices(run, slice(0, 1000), least=1024)
    assert sizes == [1000]
    sizes.clear()
    assert in_slices(run, slice(0, 100_001), least=64)
    assert sum(sizes) == 100_001
    assert sizes[:3] == [64, 1024, 16_384], "a slice that takes no time is followed by one sixteen times as long"
