"""Ctrl-C while the compiler works: it waits, and is not lost."""

import os
import signal
import threading

import numpy as np
import pytest

pytestmark = [pytest.mark.compiler, pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to send to oneself")]


def interrupts_deferred():
    from ulna.engine.compiler import interrupts_deferred as deferred  # the module needs Numba, which these tests are marked for

    return deferred()


@pytest.fixture
def python_handler():
    """The handler that Python installs, also where the tests run as a background job."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt_oneself(done):
    with interrupts_deferred():
        signal.raise_signal(signal.SIGINT)
        done.append(signal.getsignal(signal.SIGINT))


def interrupt_oneself_within(done):
    with interrupts_deferred():
        interrupt_oneself(done)
        done.append("after it")


@pytest.mark.usefixtures("python_handler")
def test_ctrl_c_waits_for_the_end_and_a_second_one_would_end_the_program():
    done = []
    with pytest.raises(KeyboardInterrupt):
        interrupt_oneself(done)
    assert done == [signal.SIG_DFL]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("python_handler")
def test_within_another_it_waits_for_the_outer_end():
    done = []
    with pytest.raises(KeyboardInterrupt):
        interrupt_oneself_within(done)
    assert done == [signal.SIG_DFL, "after it"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("python_handler")
def test_another_thread_leaves_the_handler_alone():
    found = []

    def look():
        with interrupts_deferred():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert found == [signal.default_int_handler]


def test_an_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_deferred():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("python_handler")
def test_an_entry_that_is_interrupted_while_it_is_compiled_is_compiled_to_the_end(monkeypatch):
    from ulna.engine.cache import KernelCache
    from ulna.engine.compiler import compiled_entry

    def half(values):
        return values[0] / 2

    def interrupt(*_):
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(KernelCache, "load_overload", interrupt)  # nothing is on disk
    monkeypatch.setattr(KernelCache, "save_overload", lambda *_: None)
    entry = compiled_entry(half, {}, lambda _: None)
    with pytest.raises(KeyboardInterrupt):
        entry(np.array([3.0]))
    assert len(entry.signatures) == 1
    assert entry(np.array([3.0])) == 1.5
