"""The demo's commands in ``ulna --help``, and their exit statuses."""

import os
import re
import subprocess
import sys

import pytest

from command_fixtures import without_announcements

COMMANDS = [
    *("view", "servo", "demo", "record", "fk", "jacobian", "ik", "torque", "check", "reach", "plan", "follow", "run"),
    *("list", "info", "dh", "compare", "inspect", "urdf", "bench", "warmup", "ros1", "ros2"),
]
WRONG_TABLE = """
import ulna.description.names.panda as panda
rows = [list(row) for row in panda.DH_ROWS]
rows[4][1] += 1e-4
panda.DH_ROWS = rows  # before ulna.demo.checks is imported, whose default it becomes
from ulna.cli.app import app
app(["demo", "--check"], prog_name="ulna")
"""


def test_help_lists_all_commands_in_groups(run):
    assert re.findall(r"^│ (\w+)  ", run("--help").stdout, flags=re.MULTILINE) == COMMANDS


@pytest.mark.parametrize("words", [["demo"], ["ros1"], ["ros2"], ["ros1", "demo"], ["ros2", "demo"]], ids=" ".join)
def test_every_command_has_help(run, words):
    result = run(*words, "--help")
    assert result.exit_code == 0
    assert f"Usage: ulna {' '.join(words)}" in result.stdout


@pytest.mark.process
def test_a_wrong_dh_table_fails_in_a_process_of_its_own():
    result = subprocess.run([sys.executable, "-c", WRONG_TABLE], capture_output=True, text=True, timeout=240, check=False)
    assert (result.returncode, without_announcements(result.stderr)) == (1, "")
    assert "FAILED  forward kinematics, URDF against DH" in result.stdout


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_a_closed_pipe_prints_no_error():
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "ulna", "demo", "--check"]
    result = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=240, check=False)
    os.close(writing)
    assert (result.returncode, without_announcements(result.stderr)) == (141, "")
