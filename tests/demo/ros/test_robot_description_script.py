"""hw2/robot_description.sh finds the program ulna where the docs say. roslaunch runs it outside any virtual environment."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[3] / "hw2" / "robot_description.sh"
SH = shutil.which("sh")
pytestmark = pytest.mark.skipif(SH is None, reason="no sh: ROS 1 runs on Linux")


@pytest.fixture
def hw2(tmp_path):
    """A folder ``hw2`` that holds only the script."""
    (tmp_path / "hw2").mkdir()
    return Path(shutil.copy(SCRIPT, tmp_path / "hw2")).parent


def put_ulna(path):
    """Write a program that prints its own path and its arguments."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text('#!/bin/sh\necho "$0 $*"\n')
    path.chmod(0o755)


def run(hw2, **variables):
    environment = {"PATH": os.defpath} | variables
    return subprocess.run([SH, hw2 / SCRIPT.name], env=environment, cwd=hw2, capture_output=True, text=True, check=False)


@pytest.mark.process
@pytest.mark.parametrize("folder", [".venv-ros1", ".venv", "venv", "../.venv-ros1", "../.venv"])
def test_an_environment_beside_the_script_or_above_it_is_found(hw2, folder):
    ulna = hw2 / folder / "bin" / "ulna"
    put_ulna(ulna)
    assert run(hw2).stdout == f"{ulna} ros1 description\n"


@pytest.mark.process
def test_the_variable_ULNA_comes_first(hw2, tmp_path):  # noqa: N802 - a variable's name
    put_ulna(hw2 / ".venv-ros1" / "bin" / "ulna")
    put_ulna(tmp_path / "named")
    assert run(hw2, ULNA=str(tmp_path / "named")).stdout.startswith(str(tmp_path / "named"))


@pytest.mark.process
def test_without_a_program_the_error_says_what_to_do(hw2):
    ended = run(hw2)
    assert ended.returncode == 1
    assert "ULNA=/path/to/venv/bin/ulna roslaunch hw2.launch" in ended.stderr


@pytest.mark.process
def test_after_a_program_that_fails_the_next_is_tried(hw2, tmp_path):
    broken = tmp_path / "bin" / "ulna"
    put_ulna(broken)
    broken.write_text('#!/bin/sh\necho "half a description"\necho "no module ulna" >&2\nexit 1\n')
    put_ulna(hw2 / ".venv" / "bin" / "ulna")
    ended = run(hw2, PATH=f"{broken.parent}{os.pathsep}{os.defpath}")
    assert ended.stdout == f"{hw2 / '.venv' / 'bin' / 'ulna'} ros1 description\n"
    assert ended.stderr == "no module ulna\n"
