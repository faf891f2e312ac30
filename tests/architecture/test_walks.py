"""How many files of ``src/ulna`` a reader opens to follow a call from the public method to the arithmetic: all whose code runs.

The kernels run as plain Python, so that they count; the engine counts too. The first call makes what the second finds, so it is
the longer walk. What only loads modules is no part of either. ``python tests/architecture/test_walks.py`` prints the table.
"""

import json
import os
import subprocess
import sys

import pytest

MAX = {  # files, at the first call and at the second: what is reached now; lower them as files are joined
    "forward_kinematics": (14, 9),
    "in_collision": (29, 14),
    "inverse_kinematics": (29, 16),
    "all_solutions": (37, 29),
    "plan": (60, 44),
    "follow": (56, 50),
    "ulna fk": (44, 43),
}
PROGRAM = """
import contextlib, io, json, sys
from pathlib import Path
import numpy as np
import ulna

root = str(Path(ulna.__file__).parent) + "/"
robot, world = ulna.load("panda"), ulna.World()
q = np.array(robot.home)
world.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.2)))
near = q + 0.01
T = ulna.pose((0.307, 0, 0.487), (np.pi, 0, 0))
path = np.tile(T, (3, 1, 1))
path[:, 1, 3] += 0, 0.01, 0.02


def shell():
    from ulna.cli.app import app

    with contextlib.redirect_stdout(io.StringIO()):
        app(["fk", "panda", "--q", "0,0,0,-1,0,1,0", "--json"], standalone_mode=False)


calls = {
    "forward_kinematics": lambda: robot.forward_kinematics(q),
    "in_collision": lambda: robot.in_collision(q, world),
    "inverse_kinematics": lambda: robot.inverse_kinematics(T),
    "all_solutions": lambda: robot.all_solutions(T, n_samples=2),
    "plan": lambda: robot.plan(q, near, world),
    "follow": lambda: robot.follow(path),
    "ulna fk": shell,
}
passed, loading = set(), 0


def note(frame, event, argument):
    global loading
    is_module = frame.f_code.co_name == "<module>"
    if event == "call":
        loading += is_module
        if not loading and frame.f_code.co_filename.startswith(root):
            passed.add(frame.f_code.co_filename.removeprefix(root))
    elif event == "return":
        loading -= is_module


walks = []
for _ in range(2):
    passed.clear()
    sys.setprofile(note)
    calls[sys.argv[1]]()
    sys.setprofile(None)
    walks.append(sorted(passed))
print(json.dumps(walks))
"""


def walks_of(call):
    """The files passed at the first call and at the second."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "ULNA_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", PROGRAM, call], capture_output=True, text=True, check=True, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.process
@pytest.mark.compiler  # in a wheel the methods are in C, and pass other files where Python runs the kernels
@pytest.mark.parametrize("call", MAX)
def test_few_files_lie_between_a_method_and_its_arithmetic(call):
    for files, most in zip(walks_of(call), MAX[call], strict=True):
        assert any(file.startswith("kernels/") for file in files)
        assert len(files) <= most, files


if __name__ == "__main__":
    print(f"{'call':20s} {'first':>6s} {'second':>6s}")  # noqa: T201
    for name in MAX:
        print(f"{name:20s} {' '.join(f'{len(files):6d}' for files in walks_of(name))}")  # noqa: T201
