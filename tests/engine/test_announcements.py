"""Compilation is announced wherever its seconds are waited for, and once for a chain."""

import io
import logging
from types import SimpleNamespace

import pytest

from ulna.engine import announcements
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
    compilation_ended()


def test_in_a_pipe_a_chain_is_one_line_and_the_next_chain_another(clock, pipe):
    for name in ("first", "second", "third"):
        compile_for(clock, name, 8.0)
        clock[0] += 0.5
    assert pipe.getvalue().count("\n") == 1
    assert pipe.getvalue().startswith("ulna: compiling first and what is called with it for this machine (once")
    clock[0] += 60.0
    compile_for(clock, "fourth", 1.0)
    assert pipe.getvalue().splitlines()[1].startswith("ulna: compiling fourth ")


def test_on_a_terminal_every_entry_has_its_line(clock, pipe, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(announcements, "sys", SimpleNamespace(stderr=terminal))
    compile_for(clock, "first", 1.0)
    compile_for(clock, "second", 1.0)
    lines = [f"ulna: compiling {name} for this machine (once)\n" for name in ("first", "second")]
    assert terminal.getvalue() == "".join(lines)


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
