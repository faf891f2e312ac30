"""What Windows lacks is asked for where it is used, not when a file is read: tests are collected there, and the library loads."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MODULES = {"pwd", "grp", "resource", "fcntl", "termios", "tty", "pty", "syslog", "crypt", "readline", "posix"}
# fmt: off
NAMES = {
    "signal": {
        "SIGBUS", "SIGKILL", "SIGHUP", "SIGQUIT", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGSTOP", "SIGCONT", "setitimer", "alarm",
    },
    "os": {
        "geteuid", "getuid", "getgid", "fork", "openpty", "killpg", "setsid", "mkfifo", "sched_getaffinity", "O_NONBLOCK",
    },
}
# fmt: on
# The library as Windows would load it, as far as Python code decides that.
LOAD = f"""
import sys, os, signal
import concurrent.futures, multiprocessing, lxml.etree, numpy, rich.progress, subprocess, typer  # others' business
for name in {sorted(MODULES)}:
    sys.modules[name] = None
for module, names in (("signal", {sorted(NAMES["signal"])}), ("os", {sorted(NAMES["os"])})):
    for name in names:
        if hasattr(sys.modules[module], name):
            delattr(sys.modules[module], name)
import ulna, ulna.cli.app
import importlib
for name in ("check", "view", "record", "bench", "warmup", "list", "urdf"):
    importlib.import_module("ulna.cli." + name)
try:
    import ulna.demo.ros.children
except ModuleNotFoundError as error:
    assert error.name.startswith("ulna.demo"), error
print(ulna.load("panda").link_names[0])
"""


def when_read(tree):
    """The statements that run as a file is read, but for those in a ``try`` or under an ``if``, which have seen to it."""
    waiting = list(tree.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ClassDef):
            waiting += [*node.body, *node.decorator_list]
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from node.decorator_list
        elif not isinstance(node, ast.Try | ast.If):
            yield node


def missing_elsewhere(file):
    for statement in when_read(ast.parse(file.read_text(encoding="utf-8"))):
        for node in ast.walk(statement):
            if isinstance(node, ast.Import):
                yield from (name.name for name in node.names if name.name in MODULES)
            elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
                yield node.module
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                yield from ([f"{node.value.id}.{node.attr}"] if node.attr in NAMES.get(node.value.id, ()) else [])


@pytest.mark.slow
def test_a_file_asks_for_nothing_that_windows_lacks_when_it_is_read():
    files = [file for folder in ("src", "tests", "benchmarks", "examples") for file in (ROOT / folder).rglob("*.py")]
    assert len(files) > 500
    assert [f"{file.relative_to(ROOT)}: {name}" for file in sorted(files) for name in missing_elsewhere(file)] == []


def test_the_check_finds_what_it_is_for(tmp_path):
    file = tmp_path / "a.py"
    file.write_text("import pwd\nimport signal\nCRASH = (signal.SIGBUS,)\ndef f():\n    import resource\n    signal.SIGKILL\n")
    assert sorted(missing_elsewhere(file)) == ["pwd", "signal.SIGBUS"]


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="it is the real thing there")
def test_the_library_and_its_commands_load_where_these_are_missing():
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", LOAD]
    loaded = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=240, check=False)
    assert (loaded.returncode, loaded.stdout) == (0, "panda_link0\n"), loaded.stderr
