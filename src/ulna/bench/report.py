"""Measures the requested subjects: facts of the machine, and rows for each subject, of one call and of a batch."""

from collections.abc import Sequence

import numpy as np

from ulna.bench.arms import load_arm, longest_reach, random_positions
from ulna.bench.protocol import PROTOCOLS, STEP_BOUND, follow_path, run_protocol, ulna_solver
from ulna.bench.timing import Workload, machine_facts, time_interleaved
from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.errors import GeometryError, InputError, did_you_mean
from ulna.robot import Robot

ONE, BATCH = 64, 8192  # number of single calls in a pass, and rows of the batch
OBSTACLE, OBSTACLE_POSITION = Box((0.15, 0.09, 0.126)), (0.5, 0.0, 0.21)  # free of most arms at home, touched in part of a batch


def forward_workloads(robot: Robot, n: int) -> dict[str, Workload]:
    """Forward kinematics of the tip, and of every link."""
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)
    return {
        "forward_kinematics, one": Workload(robot.forward_kinematics, list(q)),
        f"forward_kinematics, {n}": Workload(robot.forward_kinematics, [batch], n),
        "link_poses, one": Workload(robot.link_poses, list(q)),
        f"link_poses, {n}": Workload(robot.link_poses, [batch], n),
    }


def jacobian_workloads(robot: Robot, n: int) -> dict[str, Workload]:
    """The geometric Jacobian of the tip."""
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)
    return {
        "jacobian, one": Workload(robot.jacobian, list(q)),
        f"jacobian, {n}": Workload(robot.jacobian, [batch], n),
    }


def ik_workloads(robot: Robot, n: int) -> dict[str, Workload]:
    """Inverse kinematics of reachable targets."""
    targets = PROTOCOLS["reachable"].targets(robot, n)
    return {
        "inverse_kinematics, one": Workload(robot.inverse_kinematics, list(targets[:ONE])),
        f"inverse_kinematics, {n}": Workload(robot.inverse_kinematics, [targets], n),
    }


def collision_workloads(robot: Robot, n: int) -> dict[str, Workload]:
    """The robot against itself and a box, with ``in_collision`` and ``check_collision``."""
    world = World()
    world.add("box", OBSTACLE, pose(OBSTACLE_POSITION))
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)
    return {
        "in_collision, one": Workload(lambda q: robot.in_collision(q, world), list(q)),
        f"in_collision, {n}": Workload(lambda q: robot.in_collision(q, world), [batch], n),
        "check_collision, one": Workload(lambda q: robot.check_collision(q, world), list(q)),
    }


WORKLOADS = {"fk": forward_workloads, "jacobian": jacobian_workloads, "ik": ik_workloads, "collision": collision_workloads}


Rows = list[dict[str, object]]
SUBJECTS = tuple(WORKLOADS)
_UNREACHABLE_SHARE = 10  # each uses the whole budget of steps, so a tenth of the targets is enough


def measure(subjects: Sequence[str], robots: Sequence[str], n: int) -> dict[str, object]:
    """Facts of the ``machine``, and lists of rows for each subject, by default all subjects."""
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
    return {**data, "left_out": left_out}


def work_rows(subject: str, name: str, robot: Robot, n: int, left_out: Rows) -> Rows:
    """Time the workloads of a subject, interleaved; a failure becomes a row in ``left_out``, with its reason."""
    try:
        workloads = WORKLOADS[subject](robot, n if subject == "ik" else BATCH)
        for workload in workloads.values():
            workload.function(workload.inputs[0])
    except GeometryError as error:
        left_out.append({"robot": name, "subject": subject, "why": str(error)})
        return []
    return [
        {
            "robot": name,
            "work": work,
            "median_ns": timing.median,
            "lower_ns": timing.lower,
            "upper_ns": timing.upper,
            "per_second": 1e9 / timing.median,
        }
        for work, timing in time_interleaved(workloads, passes=41).items()
    ]


def protocol_rows(name: str, robot: Robot, n: int, left_out: Rows) -> Rows:
    """Run Ulna under every protocol, judged by its own forward kinematics."""
    rows = []
    for protocol, asked in PROTOCOLS.items():
        if not asked.reachable and not np.isfinite(longest_reach(robot)):
            left_out.append({"robot": name, "subject": f"protocol {protocol}", "why": "it reaches everywhere"})
            continue
        count = n if asked.reachable else max(1, n // _UNREACHABLE_SHARE)
        rows.append(run_protocol(ulna_solver(robot, asked), robot, protocol, count, robot.forward_kinematics))
    return [{**row, "robot": name} for row in rows]


def tracking_rows(name: str, robot: Robot, n: int) -> Rows:
    """Run Ulna along a path with ten times as many poses as a protocol has targets."""
    solver = ulna_solver(robot, PROTOCOLS["reachable"])
    return [{**follow_path(solver, robot, 10 * n, robot.forward_kinematics), "robot": name, "step_bound": STEP_BOUND}]
