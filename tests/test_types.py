"""Checks the type information of the installed package with a type checker."""

import json
import subprocess
import sys
from importlib.resources import files

import pytest

PROGRAM = """
import numpy as np
import ulna

robot = ulna.load("panda")
reveal_type(robot)
reveal_type(robot.forward_kinematics(robot.home))
reveal_type(robot.inverse_kinematics(np.eye(4)))
reveal_type(robot.plan(robot.home, robot.home))
ulna.load(3)
robot.plan(robot.home, robot.home, seed="one")
robot.forward(robot.home)
"""
KNOWN = {5: "Robot", 6: "ndarray[", 7: "IKResult", 8: "Plan"}  # by line, from 0 on
WRONG = {9: "reportArgumentType", 10: "reportArgumentType", 11: "reportAttributeAccessIssue"}


def test_the_package_says_that_it_is_typed():
    assert files("ulna").joinpath("py.typed").is_file()


@pytest.mark.process
def test_a_type_checker_knows_what_is_returned_and_finds_an_argument_of_another_type(tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable, "program.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    said = json.loads(done.stdout)["generalDiagnostics"]
    known = {each["range"]["start"]["line"]: each["message"] for each in said if each["severity"] == "information"}
    wrong = {each["range"]["start"]["line"]: each["rule"] for each in said if each["severity"] == "error"}
    assert wrong == WRONG
    assert known.keys() == KNOWN.keys()
    for line, name in KNOWN.items():
        assert f'is "{name}' in known[line]
