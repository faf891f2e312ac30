"""How many files a call passes from the public method to the arithmetic, run as plain Python; the engine is left out."""

import json
import os
import subprocess
import sys

import pytest

WALK = """
import json, sys
from pathlib import Path
import numpy as np
import ulna

root = Path(ulna.__file__).parent
robot, world = ulna.load("panda"), ulna.World()
q = np.array(robot.home)
world.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.2)))
calls = {
    "forward_kinematics": lambda: robot.forward_kinematics(q),
    "in_collision": lambda: robot.in_collision(q, world),
}
passed = set()

def note(frame, event, arg):
    path = Path(frame.f_code.co_filename)
    if path.is_relative_to(root):
        passed.add(path.relative_to(root).as_posix())

if sys.argv[1] == "ulna fk":
    from ulna.cli.app import app

    calls["ulna fk"] = lambda: app(["fk", "panda", "--q", "0,0,0,-1,0,1,0", "--json"], standalone_mode=False)
calls[sys.argv[1]]()  # what is made once, at the first call, is no part of the walk
sys.setprofile(note)
calls[sys.argv[1]]()
sys.setprofile(None)
print()
print(json.dumps(sorted(file for file in passed if not file.startswith("engine/"))))
"""
# What q does not pass: the objects of the world, and the reading of the robot from its file.
OFF_THE_WAY = "collision/world.py", "description/", "robot/load.py", "kinematics/tree.py", "kinematics/bound.py"


@pytest.mark.compiler  # in a wheel the methods are in C, and pass one file more where Python runs the kernels
@pytest.mark.parametrize(("call", "most"), [("forward_kinematics", 8), ("in_collision", 11), ("ulna fk", 20)])
def test_few_files_lie_between_a_method_and_its_arithmetic(call, most):
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    result = subprocess.run([sys.executable, "-c", WALK, call], capture_output=True, text=True, check=True, env=environment)
    files = {file for file in json.loads(result.stdout.splitlines()[-1]) if not file.startswith(OFF_THE_WAY)}
    assert "robot/robot.py" in files
    assert "kernels/spatial/se3.py" in files
    assert len(files) <= most, sorted(files)
