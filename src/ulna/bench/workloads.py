"""What of Ulna is timed: one call and a batch of each kind of question."""

import numpy as np
from numpy.typing import NDArray

from ulna.bench.protocol import PROTOCOLS
from ulna.bench.targets import random_positions
from ulna.bench.timing import Timing, Workload, time_interleaved
from ulna.collision.world import World
from ulna.demo.scenario import BOX, BOX_NAME, BOX_START
from ulna.description.pose import pose
from ulna.robot import Robot

Array = NDArray[np.float64]
ONE, BATCH = 64, 8192  # calls of a pass that asks for one, and rows of the batch


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
    """The robot's boxes against the demo's box."""
    world = World()
    world.add(BOX_NAME, BOX, pose(BOX_START))
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)

    def asked(q):
        return robot.in_collision(q, world)

    return {
        "in_collision, one": Workload(asked, list(q)),
        f"in_collision, {n}": Workload(asked, [batch], n),
        "check_collision, one": Workload(lambda q: robot.check_collision(q, world), list(q)),
    }


WORKLOADS = {"fk": forward_workloads, "jacobian": jacobian_workloads, "ik": ik_workloads, "collision": collision_workloads}


def timed_rows(name: str, works: dict[str, Workload], passes: int = 41) -> list[dict[str, object]]:
    """Rows of the table: the works of a robot called ``name``, interleaved."""
    return [{"robot": name, "work": work, **_figures(timing)} for work, timing in time_interleaved(works, passes).items()]


def _figures(timing: Timing) -> dict[str, float]:
    return {"median_ns": timing.median, "lower_ns": timing.lower, "upper_ns": timing.upper, "per_second": 1e9 / timing.median}
