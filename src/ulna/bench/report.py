"""Measures the requested subjects: facts of the machine, and a list of rows for each subject."""

from collections.abc import Sequence

import numpy as np

from ulna.bench.arms import load_arm, longest_reach
from ulna.bench.first_use import first_use_rows, memory_rows, size_rows
from ulna.bench.protocol import PROTOCOLS
from ulna.bench.solver import STEP_BOUND, follow_path, run_protocol, ulna_solver
from ulna.bench.timing import machine_facts
from ulna.bench.workloads import BATCH, WORKLOADS, timed_rows
from ulna.errors import GeometryError, InputError, did_you_mean
from ulna.robot import Robot

Rows = list[dict[str, object]]
SUBJECTS = (*WORKLOADS, "load")
_UNREACHABLE_SHARE = 10  # each uses the whole budget of steps, so a tenth of the targets is enough


def measure(subjects: Sequence[str], robots: Sequence[str], n: int) -> dict[str, object]:
    """Facts of the ``machine``, and for each subject its lists of rows.

    Args:
        subjects: Some of SUBJECTS; all if there are none.
        robots: Short names of ``arms``, or what ``ulna.load`` takes.
        n: Targets of each protocol of inverse kinematics.

    Raises:
        InputError: A subject is unknown.
        UlnaError: A robot cannot be loaded.
    """
    for subject in subjects:
        if subject not in SUBJECTS:
            raise InputError("subject", f"{subject!r} is not a subject of the benchmark{did_you_mean(subject, SUBJECTS)}")
    arms = {name: load_arm(name) for name in robots}
    data: dict[str, object] = {"machine": machine_facts()}
    left_out: Rows = []
    for subject in subjects or SUBJECTS:
        if subject in WORKLOADS:
            data[subject] = [row for name, arm in arms.items() for row in work_rows(subject, name, arm, n, left_out)]
        if subject == "ik":
            data["protocols"] = [row for name, arm in arms.items() for row in protocol_rows(name, arm, n, left_out)]
            data["tracking"] = [row for name, arm in arms.items() for row in tracking_rows(name, arm, n)]
        if subject == "load":
            data.update(first_use=first_use_rows(), memory=memory_rows(), size=size_rows())
    return {**data, "left_out": left_out}


def work_rows(subject: str, name: str, robot: Robot, n: int, left_out: Rows) -> Rows:
    """The workloads of a subject, interleaved. What cannot be measured is a row in ``left_out``, with the reason."""
    try:
        workloads = WORKLOADS[subject](robot, n if subject == "ik" else BATCH)
        for workload in workloads.values():
            workload.function(workload.inputs[0])
    except GeometryError as error:
        left_out.append({"robot": name, "subject": subject, "why": str(error)})
        return []
    return timed_rows(name, workloads)


def protocol_rows(name: str, robot: Robot, n: int, left_out: Rows) -> Rows:
    """Ulna under every protocol, judged by its own forward kinematics."""
    rows = []
    for protocol, asked in PROTOCOLS.items():
        if not asked.reachable and not np.isfinite(longest_reach(robot)):
            left_out.append({"robot": name, "subject": f"protocol {protocol}", "why": "it reaches everywhere"})
            continue
        count = n if asked.reachable else max(1, n // _UNREACHABLE_SHARE)
        rows.append(run_protocol(ulna_solver(robot, asked), robot, protocol, count, robot.forward_kinematics))
    return [{**row, "robot": name} for row in rows]


def tracking_rows(name: str, robot: Robot, n: int) -> Rows:
    """Ulna along a path, of ten times as many poses as a protocol has targets."""
    solver = ulna_solver(robot, PROTOCOLS["reachable"])
    return [{**follow_path(solver, robot, 10 * n, robot.forward_kinematics), "robot": name, "step_bound": STEP_BOUND}]
