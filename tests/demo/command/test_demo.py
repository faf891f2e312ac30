"""``ulna demo``: the checks, the page, and the exit status."""

import re
import sys
from types import SimpleNamespace

import pytest

from ulna.demo import command as demo
from ulna.demo.checks import Check, run_checks
from ulna.demo.scenario import Demo
from ulna.description.names import panda
from ulna.errors import InputError, install_command

GOOD, BAD = Check("a check", "1e-15", "1e-12", passed=True), Check("a long check", "2.0", "1e-12", passed=False)


@pytest.fixture
def served(monkeypatch):
    """The arguments of each call of ``serve``, which is replaced: it starts no server and calls ``meanwhile`` at once."""
    calls = []

    def serve(demo, host, port, *, open_browser, meanwhile):
        calls.append({"demo": demo, "host": host, "port": port, "open_browser": open_browser})
        return meanwhile()

    monkeypatch.setitem(sys.modules, "ulna.demo.page", SimpleNamespace(serve=serve))
    return calls


@pytest.fixture
def wrong_table(monkeypatch):
    """A DH table in which one d is 0.1 mm larger than the robot's."""
    rows = [list(row) for row in panda.DH_ROWS]
    rows[4][1] += 1e-4
    monkeypatch.setattr(demo, "run_checks", lambda: run_checks(rows))


def test_each_check_passes_and_prints_one_line(run, served):
    result = run("demo", "--check")
    lines = result.stdout.splitlines()
    assert result.exit_code == 0
    assert len(lines) == 7
    assert all(re.fullmatch(r"passed  .+: .+; bound: .+", line) for line in lines)
    assert served == []


def test_a_wrong_dh_table_fails_while_the_page_is_open(run, wrong_table, served):
    result = run("demo")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[0].startswith("FAILED  forward kinematics, URDF against DH: 1.0e-04")
    assert len(served) == 1


def test_a_wrong_dh_table_is_reported_in_json(ask, wrong_table):
    answer = ask("demo", "--check")
    assert (answer.exit_code, answer.passed) == (1, False)
    assert answer.checks[0]["name"] == "forward kinematics, URDF against DH"
    assert answer.checks[0]["passed"] is False
    assert [check["passed"] for check in answer.checks].count(True) >= 4


def test_one_failed_check_gives_exit_status_1(run, monkeypatch):
    monkeypatch.setattr(demo, "run_checks", lambda: iter([BAD, GOOD]))
    result = run("demo", "--check")
    assert result.exit_code == 1
    assert result.stdout == "FAILED  a long check: 2.0; bound: 1e-12\npassed  a check: 1e-15; bound: 1e-12\n"


@pytest.mark.parametrize("width", [80, 100])
def test_a_terminal_gets_a_table_of_fixed_columns(run, monkeypatch, width):
    monkeypatch.setattr(demo, "run_checks", lambda: iter([GOOD, BAD]))
    result = run("demo", "--check", FORCE_COLOR="1", COLUMNS=str(width))
    lines = re.sub(r"\x1b\[[\d;]*m", "", result.stdout).splitlines()
    assert [line.split()[0] for line in lines] == ["verdict", "passed", "FAILED"]
    assert len({line.index(word) for line, word in zip(lines, ("figure", "1e-15", "2.0"), strict=True)}) == 1
    assert {len(line) for line in lines} == {width}


def test_each_check_is_shown_before_the_next_one_runs(run, monkeypatch):
    seen = []

    def checks():
        yield GOOD
        seen.append(sys.stdout.buffer.getvalue())
        yield BAD

    monkeypatch.setattr(demo, "run_checks", checks)
    for environment in ({}, {"FORCE_COLOR": "1"}):
        run("demo", "--check", **environment)
        assert b"a check" in seen.pop()


def test_the_demo_is_served_and_the_checks_run_meanwhile(run, monkeypatch, served):
    monkeypatch.setattr(demo, "run_checks", lambda: iter([GOOD]))
    assert run("demo", "--host", "0.0.0.0", "--port", "1234", "--no-open").exit_code == 0  # noqa: S104
    assert run("demo").exit_code == 0
    assert [(call["host"], call["port"], call["open_browser"]) for call in served] == [
        ("0.0.0.0", 1234, False),  # noqa: S104
        ("127.0.0.1", 8080, True),
    ]
    assert isinstance(served[0]["demo"], Demo)


def test_a_busy_port_is_a_one_line_error(run, monkeypatch):
    def serve(*_, **options):
        raise InputError("port", "cannot listen")

    monkeypatch.setattr(demo, "run_checks", lambda: iter([GOOD]))
    monkeypatch.setitem(sys.modules, "ulna.demo.page", SimpleNamespace(serve=serve))
    result = run("demo")
    assert (result.exit_code, result.stderr) == (2, "ulna: --port: cannot listen\n")


@pytest.mark.parametrize("package", ["viser", "trimesh"])
def test_a_missing_viewer_extra_is_named(run, monkeypatch, package):
    monkeypatch.setattr(demo, "run_checks", lambda: iter([GOOD]))
    for name in [name for name in sys.modules if name.startswith(("ulna.viewer", "ulna.demo.page", "ulna.demo.film"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    result = run("demo")
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr == f"ulna: the view needs the viewer extra: {install_command('viewer')}\n"


def test_json_without_check_is_refused(refusal):
    assert refusal("demo", "--json").startswith("--json: requires --check")


@pytest.mark.parametrize("options", [["--host", "::1"], ["--port", "0"], ["--no-open"]])
def test_options_of_the_page_with_check_are_refused(refusal, options):
    assert refusal("demo", "--check", *options).startswith("--host, --port, --no-open: apply to the page")


def test_a_port_above_65535_is_a_usage_error(run):
    assert run("demo", "--port", "99999").exit_code == 2
