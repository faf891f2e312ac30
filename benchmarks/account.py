"""Breaks down the time of one call: ``python -m benchmarks.account``.

Each part is the difference of two interleaved calls. The calls are the whole method, the bound function, the same with ``out=``,
its kernel alone, and an empty kernel with the same arguments.
"""

import sys

import numpy as np

import ulna
from benchmarks import idle
from benchmarks.markdown import table
from ulna.bench.arms import random_positions
from ulna.bench.timing import Workload, time_interleaved
from ulna.engine.entries import ready
from ulna.kernels.layout import IN_BASE
from ulna.kinematics.entries import forward, jacobian
from ulna.robot import Robot

CALLS = 64


def account_rows(robot: Robot) -> list[dict]:
    """The time of each part of a call, for one pose and one Jacobian."""
    q, chain = list(random_positions(robot, CALLS, 0)), robot.tree.chain(str(robot.tip)).copy()
    fk, T, jac, J = robot.compile_forward(), np.empty((4, 4)), robot.compile_jacobian(), np.empty((6, robot.n_dof))
    n = robot.n_dof
    forward_one, jacobian_one = ready(forward.forward_one), ready(jacobian.jacobian_one)
    idle_fk, idle_jac = ready(idle.idle_forward), ready(idle.idle_jacobian)
    works = {
        "loop": lambda x: x,
        "fk method": robot.forward_kinematics,
        "fk bound": fk,
        "fk out": lambda x: fk(x, T),
        "fk kernel": lambda x: forward_one(chain, n, x, T),
        "fk idle": lambda x: idle_fk(chain, n, x, T),
        "jac method": robot.jacobian,
        "jac bound": jac,
        "jac out": lambda x: jac(x, J),
        "jac kernel": lambda x: jacobian_one(chain, IN_BASE, n, x, J),
        "jac idle": lambda x: idle_jac(chain, IN_BASE, n, x, J),
    }
    timings = time_interleaved({name: Workload(function, q) for name, function in works.items()}, passes=401)
    return [_row(work, name, {key: timing.median for key, timing in timings.items()}) for work, name in _WORKS.items()]


_WORKS = {"forward_kinematics": "fk", "jacobian": "jac"}


def _row(work: str, name: str, ns: dict[str, float]) -> dict:
    out, kernel, idle = (ns[f"{name} {part}"] - ns["loop"] for part in ("out", "kernel", "idle"))  # called through a lambda
    return {
        "work": work,
        "arithmetic_ns": kernel - idle,
        "into_compiled_code_ns": idle,
        "bound_function_ns": out - kernel,
        "new_array_ns": ns[f"{name} bound"] - out,
        "method_ns": ns[f"{name} method"] - ns[f"{name} bound"],
        "whole_call_ns": ns[f"{name} method"],
    }


def main() -> None:
    """Print the breakdown for the Panda."""
    sys.stdout.write(table(account_rows(ulna.load("panda"))) + "\n")


if __name__ == "__main__":
    main()
