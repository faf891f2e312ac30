"""Compilation is announced wherever its seconds are waited for, and once for a chain."""

import io
import logging
from types import SimpleNamespace

import pytest

from processes import wait_for
from ulna.engine import announcements, progress
from ulna.engine.announcements import compilation_begins, compilation_ended, quietly

pytestmark = pytest.mark.compiler


class Terminal(io.StringIO):
    """Standard error that is a terminal."""

    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands still until it is moved, and no chain before."""
    now = [1000.0]
    monkeypatch.setattr(announcements.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(announcements, "_chain_until", 0.0)
    return now


@pytest.fixture
def pipe(monkeypatch):
    """Standard error that is a pipe, in a program that has not configured logging."""
    monkeypatch.setattr(announcements, "_shows_records", lambda: False)
    stream = io.StringIO()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=stream))
    return stream


def compile_for(clock, name, seconds):
    compilation_begins(name)
    clock[0] += seconds
    compilation_ended(name)


def test_in_a_pipe_a_chain_is_one_line_and_the_next_chain_another(clock, pipe):
    for name in ("first", "second", "third"):
        compile_for(clock, name, 8.0)
        clock[0] += 0.5
    assert pipe.getvalue().count("\n") == 1
    assert pipe.getvalue().startswith("ulna: compiling first and its callees for this machine (once")
    clock[0] += 60.0
    compile_for(clock, "fourth", 1.0)
    assert pipe.getvalue().splitlines()[1].startswith("ulna: compiling fourth ")


def test_on_a_terminal_a_line_turns_while_an_entry_is_compiled_and_then_says_how_long_it_took(clock, pipe, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=terminal))
    monkeypatch.setenv("TERM", "xterm")
    compilation_begins("first")
    wait_for(lambda: "compiling first for this machine (once), 0 s" in terminal.getvalue(), "the line")
    clock[0] += 3.0
    wait_for(lambda: "compiling first for this machine (once), 3 s" in terminal.getvalue(), "the seconds")
    compilation_ended("first")
    compile_for(clock, "second", 1.25)
    wait_for(lambda: announcements._spinner._thread is None, "the end of it")
    left = [line.rpartition("\x1b[K")[2] for line in terminal.getvalue().split("\n") if line]
    assert left == ["ulna: compiled first for this machine (once): 3.0 s", "ulna: compiled second for this machine (once): 1.2 s"]


def test_beside_a_bar_and_on_a_terminal_without_control_codes_every_entry_has_a_line(clock, pipe, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=terminal))
    monkeypatch.setattr(announcements, "is_bar_shown", lambda: True)
    compile_for(clock, "first", 1.0)
    monkeypatch.setattr(announcements, "is_bar_shown", lambda: False)
    monkeypatch.setenv("TERM", "dumb")
    compile_for(clock, "second", 1.0)
    lines = [f"ulna: compiling {name} for this machine (once)\n" for name in ("first", "second")]
    assert terminal.getvalue() == "".join(lines)


def test_the_line_of_what_failed_ends_and_a_bar_that_is_drawn_is_known(clock, pipe, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=terminal))
    monkeypatch.setenv("TERM", "xterm")
    compilation_begins("failing")
    clock[0] += 500.0
    wait_for(lambda: announcements._spinner._thread is None, "the end of it")
    bar = progress.progress_bar()
    assert not progress.is_bar_shown()
    bar.live.start()
    assert progress.is_bar_shown()
    bar.live.stop()
    assert not progress.is_bar_shown()


def test_a_program_that_has_configured_logging_gets_a_record_and_no_line(clock, monkeypatch, caplog):
    stream = io.StringIO()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=stream))
    with caplog.at_level(logging.INFO, logger="ulna"):
        compile_for(clock, "first", 1.0)
        compile_for(clock, "second", 1.0)
    assert [(record.name, record.levelname) for record in caplog.records] == [("ulna", "INFO")]
    assert "first" in caplog.text
    assert stream.getvalue() == ""


def test_a_program_that_logs_only_into_a_file_gets_the_line_too(clock, monkeypatch, tmp_path):
    """rospy's nodes do: nothing else would say why the program waits."""
    stream = io.StringIO()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=stream))
    monkeypatch.setattr(logging.getLogger(), "handlers", [file := logging.FileHandler(tmp_path / "log")])
    compile_for(clock, "first", 1.0)
    assert stream.getvalue().startswith("ulna: compiling first ")
    file.close()


def test_who_compiles_ahead_is_not_disturbed(clock, pipe):
    with quietly():
        compile_for(clock, "first", 1.0)
    assert pipe.getvalue() == ""
    clock[0] += 60.0
    compile_for(clock, "second", 1.0)
    assert pipe.getvalue().startswith("ulna: compiling second ")


@pytest.mark.parametrize("kind", ["none", "closed"])
def test_no_standard_error_is_no_error(clock, pipe, monkeypatch, kind):
    pipe.close()
    if kind == "none":
        monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=None))
    compile_for(clock, "first", 1.0)
