"""Measures code compiled ahead, next to the peers and the goals: ``python -m benchmarks.ahead``, in the wheel's environment.

    make test-wheel                              # or only its first steps: the environment .venv-wheel
    .venv-wheel/bin/python -m benchmarks.ahead   # compiled ahead
    .venv/bin/python -m benchmarks.ahead         # the same, compiled now

It interleaves one call of each kind with Pinocchio and with Coal. Then it starts new processes, next to one that imports NumPy
alone. Times of processes are wall times, and processor times, which other work on the machine affects less.
"""

import json
import os
import subprocess
import sys
from time import perf_counter

import numpy as np

from benchmarks.collision import query_rows
from benchmarks.markdown import table
from benchmarks.processors import one_processor
from benchmarks.ratio import ratio
from ulna.bench.arms import load_arm, random_positions
from ulna.bench.timing import Workload, time_interleaved
from ulna.engine.ahead import is_ahead, level
from ulna.ik.entries import multi_start
from ulna.ik.options import Options
from ulna.kernels.ik.search_records import SearchResult

PASSES, ONE = 201, 64
LOAD = "import ulna; robot = ulna.load('panda'); q = robot.home; T = robot.forward_kinematics(q)"
MESH = "ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])"
PROCESSES = {
    "import numpy": "import numpy",
    "import ulna": "import numpy, ulna",
    "load the Panda": "import ulna; ulna.load('panda')",
    "first pose": LOAD,
    "first inverse kinematics": f"{LOAD}; robot.inverse_kinematics(T)",
    "first collision of a convex mesh": f"{LOAD}; world = ulna.World(); world.add('mesh', {MESH}); robot.in_collision(q, world)",
    "ulna fk panda --q ...": "from ulna.cli.app import app; app(['fk', 'panda', '--q', '0,0,0,-1,0,1,0'])",
}
# Runs a line in a process of its own: seconds of the clock and of the processor, and the peak of the resident memory [MB].
RUN = """
import json, resource, subprocess, sys, time
start = time.perf_counter()
subprocess.run([sys.executable, "-c", sys.argv[1]], check=True, stdout=subprocess.DEVNULL)
wall, used = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps((wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)))
"""


def single_rows(robot) -> list[dict]:
    """One pose and one Jacobian by the plain methods, next to Pinocchio's fastest way."""
    from benchmarks.peers.pinocchio import Model  # noqa: PLC0415 -- it may be absent

    peer, q, rows = Model(robot), list(random_positions(robot, ONE, seed=0)), []
    own = [peer.own_q(x) for x in q]
    for kind, theirs, shape in (("forward_kinematics", peer.forward_kept, (4, 4)), ("jacobian", peer.jacobian, (6, 7))):
        method, out = getattr(robot, kind), np.empty(shape)
        works = {
            "pin": Workload(theirs, own),
            f"{kind}(q)": Workload(method, q),
            f"{kind}(q, out=)": Workload(lambda x, method=method, out=out: method(x, out=out), q),  # includes the lambda's 25 ns
        }
        rows += _rows(works, "pin")
    return rows


def inverse_rows(robot) -> list[dict]:
    """One inverse kinematics, and its machine code alone, with existing arrays."""
    targets = [robot.forward_kinematics(x) for x in random_positions(robot, ONE, seed=0)]
    robot.inverse_kinematics(targets[0])
    solver = robot._inverse_kinematics._solver(None, *Options())  # noqa: SLF001
    tables, home, search = solver.tables, solver.home, multi_start.search_one
    q, info = np.empty((1, robot.n_dof)), SearchResult.records()
    works = {
        "machine code": Workload(lambda T: search(*tables, T, home, q, info), targets),
        "inverse_kinematics(T)": Workload(robot.inverse_kinematics, targets),
    }
    return _rows(works, "machine code")


def process_rows(runs: int = 5) -> list[dict]:
    """Whole processes, interleaved: the medians."""
    times = {name: [] for name in PROCESSES}
    for _ in range(runs):
        for name, code in PROCESSES.items():
            times[name].append(_process(code))
    return [
        dict(zip(("process", "seconds", "processor_s", "megabytes"), (name, *np.median(each, axis=0)), strict=True))
        for name, each in times.items()
    ]


def _process(code: str) -> tuple[float, float, float]:
    done = subprocess.run([sys.executable, "-c", RUN, code], capture_output=True, text=True, check=True)  # noqa: S603
    return tuple(json.loads(done.stdout))


def _rows(works: dict[str, Workload], yardstick: str) -> list[dict]:
    timings, rows = time_interleaved(works, passes=PASSES), []
    for name, timing in timings.items():
        lower, median, upper = ratio(timing, timings[yardstick])
        rows.append({
            "work": name, "ns": timing.median, f"times {yardstick}": median, "lower": lower, "upper": upper,
        })  # fmt: skip
    return rows


def main() -> None:
    """Measure, and print the tables."""
    start, panda = perf_counter(), load_arm("panda")
    print(f"compiled ahead for {level()}" if is_ahead() else "compiled now", f"- load {os.getloadavg()[0]:.1f}\n")
    print(table(single_rows(panda)), table(inverse_rows(panda)), sep="\n\n", flush=True)
    with one_processor():
        print("", table([row for row in query_rows(panda) if row["asked"] == "one call"]), sep="\n", flush=True)
    print("", table(process_rows()), f"in {perf_counter() - start:.0f} s", sep="\n\n")


if __name__ == "__main__":
    main()
