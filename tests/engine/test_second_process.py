"""The second process, which compiles the longest entries while a program compiles those that it calls."""

import os
import subprocess
import sys
import time

import pytest

from fresh_process import run_fresh
from processes import wait_for
from ulna.engine.private_folder import private_folder
from ulna.engine.second_process import FILLING, lock_of

pytestmark = [pytest.mark.compiler, pytest.mark.process]

BEGIN = """
import time
import ulna
from ulna.engine.cache import cache_folder
robot, folder = ulna.load("panda"), cache_folder()
robot.forward_kinematics(robot.home)
def planner_is_locked():
    names = [path.name for path in folder.path.glob("*plan_slice*.lock")]
    return any(map(folder.is_locked, names))
"""
PLAN = """
from ulna.planning.entries import search
print(robot.plan(robot.home, robot.home + 0.1).status)
print(sum(search.plan_slice.stats.cache_hits.values()), sum(search.plan_slice.stats.cache_misses.values()))
"""
WAIT = """
end = time.monotonic() + 300
while not planner_is_locked():
    assert time.monotonic() < end
    time.sleep(0.02)
"""
ON = {"ULNA_WARMUP": "1", "ULNA_THREADS": "2"}


@pytest.mark.slow
def test_a_program_waits_for_what_the_second_process_compiles_and_loads_it(tmp_path):
    assert run_fresh(BEGIN + WAIT + PLAN, NUMBA_CACHE_DIR=tmp_path, **ON) == ["solved", "1 0"]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
def test_a_fork_waits_too(tmp_path):
    fork = "import os\nchild = os.fork()\nif child:\n    os.waitpid(child, 0)\n    os._exit(0)\n"
    flush = "import sys\nsys.stdout.flush()\nos._exit(0)\n"
    assert run_fresh(BEGIN + WAIT + fork + PLAN + flush, NUMBA_CACHE_DIR=tmp_path, **ON) == ["solved", "1 0"]


@pytest.mark.parametrize("off", [{"ULNA_WARMUP": "0"}, {"ULNA_WARMUP": "off"}, {"ULNA_THREADS": "1"}, {"ULNA_THREADS": "none"}])
def test_none_begins_where_it_is_turned_off(tmp_path, off):
    run_fresh(f"{BEGIN}time.sleep(1)\nassert not folder.has('{FILLING}')", NUMBA_CACHE_DIR=tmp_path, **{**ON, **off})


@pytest.mark.parametrize(
    "before",
    [
        "import pathlib, sys\nsys.path += [pathlib.Path('/nowhere'), 7, 'relative', '']",
        "import sys\nsys.executable = ''",
        "import sys\nsys.executable = '/nowhere/python'",
        "import sys\nsys.frozen = True",
        "import subprocess\ndef run(*_, **__): raise RuntimeError('no more processes')\nsubprocess.run = run",
        "import sys\nsys.stdin.close()",
    ],
)
def test_a_pose_is_computed_whatever_prevents_it(tmp_path, before):
    assert run_fresh(f"{before}\n{BEGIN}print('computed')", NUMBA_CACHE_DIR=tmp_path, **ON) == ["computed"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no such wait")
def test_it_is_no_child_of_the_program(tmp_path):
    wait = "import os\ntry:\n    os.wait()\nexcept ChildProcessError:\n    print('no child')"
    assert run_fresh(BEGIN + wait, NUMBA_CACHE_DIR=tmp_path, **ON) == ["no child"]


@pytest.mark.parametrize("end", ["terminate", "kill", "exit"])
def test_it_ends_with_the_program(tmp_path, end):
    program = f"{BEGIN}import sys\nprint('compiled', flush=True)\nsys.stdin.read()"
    environment = {**os.environ, **ON, "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen(
        [sys.executable, "-c", program], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as running:
        assert running.stdout.readline() == b"compiled\n"
        [path] = (tmp_path / "ulna").glob("kernels-*")
        folder = private_folder(tmp_path / "ulna").folder(path.name)
        wait_for(lambda: folder.is_locked(FILLING), "the second process")
        {"terminate": running.terminate, "kill": running.kill, "exit": running.stdin.close}[end]()
        running.wait()
    wait_for(lambda: not folder.is_locked(FILLING), "the end of the second process")


HOLD = """
import sys, time
from pathlib import Path
from ulna.engine.private_folder import private_folder
lock = private_folder(Path(sys.argv[1])).lock(sys.argv[2])
print(lock is not None, flush=True)
time.sleep(600)
"""


def test_a_wait_ends_when_the_other_process_dies_and_where_it_takes_too_long(tmp_path):
    folder, name = private_folder(tmp_path / "cache"), lock_of("entry.nbc")
    assert not folder.wait_for(name, 600.0)
    with subprocess.Popen([sys.executable, "-c", HOLD, folder.path, name], stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"True\n"
        assert folder.is_locked(name)
        assert folder.lock(name) is None
        start = time.monotonic()
        assert folder.wait_for(name, 0.2)
        assert time.monotonic() - start >= 0.2
        holder.kill()
        assert folder.wait_for(name, 600.0) in {True, False}  # it may be dead already
    assert not folder.is_locked(name)
