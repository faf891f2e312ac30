"""The second process, which compiles the longest entries while a program compiles those that it calls."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from fresh_process import run_fresh
from processes import wait_for

pytestmark = [pytest.mark.compiler, pytest.mark.process, pytest.mark.slow]

PLAN = """
import threading
import ulna
robot, world = ulna.load("panda"), ulna.World()
world.add("crate", ulna.Box(extents=(0.15, 0.09, 0.126)), ulna.pose(xyz=(0.3, 0, 0.5)))
robot.forward_kinematics(robot.home)
print(robot.plan(robot.home + [1, 0, 0, 0, 0, 0, 0], robot.home - [1, 0, 0, 0, 0, 0, 0], world).status)
from ulna.planning.entries import search
print(sum(search.plan_slice.stats.cache_hits.values()), sum(search.plan_slice.stats.cache_misses.values()))
print(any(thread.name == "ulna-second-process" for thread in threading.enumerate()))
"""
FORK = """
import os
import ulna
robot = ulna.load("panda")
robot.forward_kinematics(robot.home)   # the second process begins with plan_slice
child = os.fork()
if not child:
    print(robot.plan(robot.home, robot.home + 0.1).status, flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""
WAIT = """
import sys
import ulna
robot = ulna.load("panda")
robot.forward_kinematics(robot.home)
print("compiled", flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize(
    ("options", "hits_and_misses", "is_there"),
    [({"ULNA_WARMUP": "1"}, "1 0", "True"), ({"ULNA_WARMUP": "0"}, "0 1", "False"), ({"ULNA_THREADS": "1"}, "0 1", "False")],
)
def test_it_compiles_the_planner_while_a_program_compiles_a_pose(tmp_path, options, hits_and_misses, is_there):
    found = run_fresh(PLAN, NUMBA_CACHE_DIR=tmp_path, **{"ULNA_WARMUP": "1", "ULNA_THREADS": "2", **options})
    assert found == ["solved", hits_and_misses, is_there]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
def test_a_fork_compiles_itself(tmp_path):
    assert run_fresh(FORK, NUMBA_CACHE_DIR=tmp_path, ULNA_WARMUP="1", ULNA_THREADS="2") == ["solved"]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="Linux lists the processes of a program")
@pytest.mark.parametrize("end", ["terminate", "kill", "exit"])
def test_it_ends_with_the_program(tmp_path, end):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "ULNA_WARMUP": "1", "ULNA_THREADS": "2"}
    with subprocess.Popen(
        [sys.executable, "-c", WAIT], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as program:
        assert program.stdout.readline() == b"compiled\n"
        second = Path(f"/proc/{program.pid}/task/{program.pid}/children").read_text().split()
        assert len(second) == 1
        {"terminate": program.terminate, "kill": program.kill, "exit": program.stdin.close}[end]()
        program.wait()
    wait_for(lambda: not Path(f"/proc/{second[0]}").exists(), "the end of the second process")
