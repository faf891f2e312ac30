"""Measures a first use: importing, loading and first calls in a new process, memory, and size on disk."""

import json
import os
import re
import subprocess
import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.resources import files
from pathlib import Path
from statistics import median

from ulna.errors import UlnaError

# The steps of one process, each timed after those before it.
_STEPS = """
import json, time
seconds, start = {}, time.perf_counter()
def done(step):
    global start
    seconds[step] = time.perf_counter() - start
    start = time.perf_counter()
import ulna
done("import ulna")
robot = ulna.load("panda")
done("load the Panda")
T = robot.forward_kinematics(robot.home)
done("first forward_kinematics")
robot.jacobian(robot.home)
done("first jacobian")
robot.inverse_kinematics(T)
done("first inverse_kinematics")
print(json.dumps(seconds))
"""
# Peak memory during the call, minus memory before it, minus the result.
_MEMORY = """
import json, re, sys
import ulna
from ulna.bench.arms import random_positions
robot, n = ulna.load("panda"), {n}
def kilobytes(name):
    return int(re.search(name + r":\\s+(\\d+)", open("/proc/self/status").read())[1])
q = {argument}
{call}(q[:64])
before = kilobytes("VmRSS")
result = {call}(q)
print(json.dumps((kilobytes("VmHWM") - before) / 1024 - {result}.nbytes / 2**20))
"""
_CALLS = {
    "forward_kinematics": (1_000_000, "random_positions(robot, n, 0)", "robot.forward_kinematics", "result"),
    "jacobian": (200_000, "random_positions(robot, n, 0)", "robot.jacobian", "result"),
    "inverse_kinematics": (
        50_000, "robot.forward_kinematics(random_positions(robot, n, 0))", "robot.inverse_kinematics", "result.q",
    ),
}  # fmt: skip


def first_use_rows(processes: int = 3) -> list[dict[str, object]]:
    """Seconds of each step of a first use, machine code cached: the median over new processes."""
    time_steps()  # fills the cache
    runs = [time_steps() for _ in range(processes)]
    return [{"step": step, "seconds": median(run[step] for run in runs)} for step in runs[0]]


def time_steps(**environment: str) -> dict[str, float]:
    """Seconds of each step of a first use in a new process, with further environment variables."""
    return _child(_STEPS, **environment)


def memory_rows() -> list[dict[str, object]]:
    """Memory of a large batch beyond its input and its result [MB]; no rows on systems without /proc."""
    if not Path("/proc/self/status").exists():
        return []
    rows = []
    for name, (n, argument, call, result) in _CALLS.items():
        extra = _child(_MEMORY.format(n=n, argument=argument, call=call, result=result))
        rows.append({"call": name, "rows": n, "extra_megabytes": extra})
    return rows


def size_rows() -> list[dict[str, object]]:
    """The size on disk of the core and its packages [MB], largest first; no rows without an installed Ulna."""
    if not _installed("ulna"):
        return []
    here = sum(path.stat().st_size for path in Path(str(files("ulna"))).rglob("*.py"))
    sizes = {"ulna": here / 1e6, **{d.name: _megabytes(d) for d in needed_distributions("ulna")}}
    rows = [{"package": name, "megabytes": size} for name, size in sorted(sizes.items(), key=lambda item: -item[1])]
    return [*rows, {"package": "all", "megabytes": sum(sizes.values())}]


def needed_distributions(name: str) -> list[Distribution]:
    """The installed distributions that one requires, directly or indirectly, without extras."""
    found, waiting = {}, [name]
    while waiting:
        try:
            needed = distribution(waiting.pop())
        except PackageNotFoundError:
            continue  # needed on other systems only
        for requirement in needed.requires or ():
            child = re.match(r"[\w.-]+", requirement)
            if child and "extra ==" not in requirement and child[0].lower() not in found:
                found[child[0].lower()] = None
                waiting.append(child[0])
    return [distribution(child) for child in found if _installed(child)]


def _installed(name: str) -> bool:
    try:
        distribution(name)
    except PackageNotFoundError:
        return False
    return True


def _megabytes(package: Distribution) -> float:
    paths = [Path(str(package.locate_file(file))) for file in package.files or ()]
    return sum(path.stat().st_size for path in paths if path.is_file()) / 1e6


def _child(code: str, **environment: str):
    """Run a new Python process and parse its output as JSON."""
    command, variables = [sys.executable, "-P", "-c", code], os.environ | environment
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)  # noqa: S603 -- our own code
    if done.returncode:
        raise UlnaError(f"a measuring process failed: {done.stderr.strip().splitlines()[-1:]}")
    return json.loads(done.stdout)
