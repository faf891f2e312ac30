"""Makes what is timed: one call and a batch of each kind of query."""

import numpy as np
from numpy.typing import NDArray

from ulna.bench.arms import random_positions
from ulna.bench.protocol import PROTOCOLS
from ulna.bench.timing import Timing, Workload, time_interleaved
from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.robot import Robot

Array = NDArray[np.float64]
ONE, BATCH = 64, 8192  # calls of a pass of single calls, and rows of the batch
OBSTACLE, OBSTACLE_POSITION = Box((0.15, 0.09, 0.126)), (0.5, 0.0, 0.21)  # free of most arms at home, touched in some of a batch


def forward_workloads(robot: Robot, n: int) -> dict[str, Workload]:
    """Forward kinematics: of the tip, and of every link."""
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


def timed_rows(name: str, workloads: dict[str, Workload], passes: int = 41) -> list[dict[str, object]]:
    """Rows of the table: the workloads of a robot called ``name``, interleaved."""
    return [{"robot": name, "work": work, **_figures(timing)} for work, timing in time_interleaved(workloads, passes).items()]


def _figures(timing: Timing) -> dict[str, float]:
    return {"median_ns": timing.median, "lower_ns": timing.lower, "upper_ns": timing.upper, "per_second": 1e9 / timing.median}
