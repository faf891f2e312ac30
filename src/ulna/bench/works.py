"""What of Ulna is timed: one call and a batch of each kind of question."""

import numpy as np
from numpy.typing import NDArray

from ulna.bench.clock import Timing, Work, time_interleaved
from ulna.bench.protocol import PROTOCOLS
from ulna.bench.targets import random_positions
from ulna.collision.world import World
from ulna.demo import BOX, BOX_NAME, BOX_START
from ulna.model.pose import pose
from ulna.robot import Robot

Array = NDArray[np.float64]

ONE, BATCH = 64, 8192  # calls of a pass that asks for one, and rows of the batch


def forward_works(robot: Robot, n: int) -> dict[str, Work]:
    """Forward kinematics: of the tip, and of every link."""
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)
    return {
        "forward_kinematics, one": Work(robot.forward_kinematics, list(q)),
        f"forward_kinematics, {n}": Work(robot.forward_kinematics, [batch], n),
        "link_poses, one": Work(robot.link_poses, list(q)),
        f"link_poses, {n}": Work(robot.link_poses, [batch], n),
    }


def jacobian_works(robot: Robot, n: int) -> dict[str, Work]:
    """The geometric Jacobian of the tip."""
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)
    return {
        "jacobian, one": Work(robot.jacobian, list(q)),
        f"jacobian, {n}": Work(robot.jacobian, [batch], n),
    }


def ik_works(robot: Robot, n: int) -> dict[str, Work]:
    """Inverse kinematics of reachable targets."""
    targets = PROTOCOLS["reachable"].targets(robot, n)
    return {
        "inverse_kinematics, one": Work(robot.inverse_kinematics, list(targets[:ONE])),
        f"inverse_kinematics, {n}": Work(robot.inverse_kinematics, [targets], n),
    }


def collision_works(robot: Robot, n: int) -> dict[str, Work]:
    """The robot's boxes against the demo's box."""
    world = World()
    world.add(BOX_NAME, BOX, pose(BOX_START))
    q, batch = random_positions(robot, ONE, 0), random_positions(robot, n, 1)

    def asked(q):
        return robot.in_collision(q, world)

    return {
        "in_collision, one": Work(asked, list(q)),
        f"in_collision, {n}": Work(asked, [batch], n),
        "check_collision, one": Work(lambda q: robot.check_collision(q, world), list(q)),
    }


WORKS = {"fk": forward_works, "jacobian": jacobian_works, "ik": ik_works, "collision": collision_works}


def timed_rows(name: str, works: dict[str, Work], passes: int = 41) -> list[dict[str, object]]:
    """Rows of the table: the works of a robot called ``name``, interleaved."""
    return [{"robot": name, "work": work, **_figures(timing)} for work, timing in time_interleaved(works, passes).items()]


def _figures(timing: Timing) -> dict[str, float]:
    return {"median_ns": timing.median, "lower_ns": timing.lower, "upper_ns": timing.upper, "per_second": 1e9 / timing.median}
