"""Computes a lower bound of a batched kernel's time: its operations at peak speed, or its bytes at copy speed.

The operations are counted, not estimated: the same kernels run as plain NumPy (``NUMBA_DISABLE_JIT=1``) on arrays that count. An
operation handles eight numbers at once. The peak is the rate of independent multiply-adds in lanes, two operations each. The copy
speed is that of ``np.copyto`` over 256 MB. Both are measured in the same run. No kernel reaches such a bound. It ignores
dependencies between operations, multiplications without additions, loads and stores from caches, and the clearing of new pages.
"""

import json
import os
import subprocess
import sys

import numpy as np

from ulna.bench.arms import random_positions
from ulna.bench.timing import Workload, time_interleaved
from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, load, store
from ulna.engine.signatures import MATRIX, WHOLE
from ulna.robot import Robot

IN_CACHE, IN_MEMORY = 4096, 500_000  # rows of a batch
_ROUNDS = 100_000
_COUNTING = """
import json, sys
import numpy as np
import ulna
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.distance.box_sat import boxes_overlap
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.layout import IN_BASE
from ulna.kernels.collision.posed_pair import balls_overlap, half_extents, place_bodies
from ulna.kernels.collision.scene import Posed
from ulna.kernels.spatial.se3 import load_pose

class Counting(np.ndarray):
    operations = 0
    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        Counting.operations += 1
        plain = [np.asarray(x) if isinstance(x, Counting) else x for x in inputs]
        return np.asarray(getattr(ufunc, method)(*plain)).view(Counting)
    def __array_function__(self, function, types, inputs, options):
        Counting.operations += function is np.where
        plain = [np.asarray(x) if isinstance(x, Counting) else x for x in inputs]
        return np.asarray(function(*plain)).view(Counting)

def rows(n):
    return np.zeros((n, 8)).view(Counting)

robot = ulna.load(sys.stdin.read())
chain, q, counts = robot.tree.chain(robot.tip), rows(robot.n_dof), {}
chain_pose(chain, q)
counts["forward_kinematics"], Counting.operations = Counting.operations, 0
chain_jacobian(chain, q, IN_BASE, rows(6 * robot.n_dof), 6, 1)
counts["jacobian"], Counting.operations = Counting.operations, 0
if len(sys.argv) > 1:
    bodies, joints = robot._checker.bodies.table, robot.tree.joints
    body_rows = rows(12 * len(bodies))
    place_bodies(joints, bodies, q, rows(12 * len(joints)), body_rows)
    counts["place_bodies"], Counting.operations = Counting.operations, 0
    a, b = load_pose(body_rows, 0), load_pose(body_rows, 1)
    balls_overlap(Posed(bodies, None, 0, a), Posed(bodies, None, 1, b))
    counts["balls_overlap"], Counting.operations = Counting.operations, 0
    boxes_overlap(a, half_extents(bodies, 0, a[0]), b, half_extents(bodies, 1, a[0]))
    counts["boxes_overlap"] = Counting.operations
print(json.dumps(counts))
"""


def count_operations(robot: Robot, *, with_boxes: bool = False) -> dict[str, int]:
    """Operations on eight numbers in the kernels of a chain, for eight configurations; with boxes, also for a pair."""
    command, environment = [sys.executable, "-c", _COUNTING, *["boxes"] * with_boxes], os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, input=robot.to_urdf(), env=environment, capture_output=True, text=True, check=True)  # noqa: S603
    return json.loads(done.stdout)


@entry((MATRIX, WHOLE))
def multiply_add(rows, rounds):
    """Rounds of sixteen independent multiply-adds in lanes."""
    a0, a1, a2, a3 = load(rows, 0), load(rows, 1), load(rows, 2), load(rows, 3)
    a4, a5, a6, a7 = load(rows, 4), load(rows, 5), load(rows, 6), load(rows, 7)
    x, y = load(rows, 8), load(rows, 9)
    for _ in range(rounds):
        a0, a1, a2, a3 = a0 * x + y, a1 * x + y, a2 * x + y, a3 * x + y
        a4, a5, a6, a7 = a4 * x + y, a5 * x + y, a6 * x + y, a7 * x + y
        a0, a1, a2, a3 = a0 * y + x, a1 * y + x, a2 * y + x, a3 * y + x
        a4, a5, a6, a7 = a4 * y + x, a5 * y + x, a6 * y + x, a7 * y + x
    store(rows, 0, a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7)


def peak_ns() -> float:
    """The time of one operation on eight numbers at the peak [ns]."""
    rows = np.full((10, WIDTH), 0.5)
    work = Workload(lambda _: multiply_add(rows, _ROUNDS), [0] * 3, _ROUNDS * 32)
    return float(time_interleaved({"peak": work}, passes=15)["peak"].passes.min())


def copy_ns() -> float:
    """The time to read a byte and to write one, of an array larger than all caches [ns]."""
    source, target = np.ones(2**25), np.empty(2**25)
    work = Workload(lambda _: np.copyto(target, source), [0], source.nbytes)
    return float(time_interleaved({"copy": work}, passes=9)["copy"].passes.min()) / 2


def bound_rows(name: str, robot: Robot, peak: float, copy: float) -> list[dict]:
    """The bound and the measured time of each batched kernel, for a batch within the caches and a larger one."""
    counts = count_operations(robot)
    rows = []
    for kind, operations in counts.items():
        ask = getattr(robot, kind)
        for n in (IN_CACHE, IN_MEMORY):  # in sequence: the large batch would evict the small one from the caches
            q = random_positions(robot, n, 0)
            moved = q[0].nbytes + ask(q[:1]).nbytes
            arithmetic, memory = operations / WIDTH * peak, moved * copy if n == IN_MEMORY else 0.0
            median = time_interleaved({kind: Workload(ask, [q], n)})[kind].median
            rows.append({
                "robot": name,
                "work": kind,
                "rows": n,
                "operations_on_eight": operations,
                "bytes_a_row": moved,
                "arithmetic_ns": arithmetic,
                "memory_ns": memory,
                "median_ns": median,
                "times_bound": median / max(arithmetic, memory),
            })  # fmt: skip
    return rows
