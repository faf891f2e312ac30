"""Defines the calls that the guard times; as a program it is a worker that runs passes on request.

``python -m benchmarks.guard_works`` writes the names in JSON. Then it reads a name per line, and writes the time of one call in a
pass [ns]. It times the checkout whose ``ulna`` is first on PYTHONPATH.
"""

import json
import sys

import numpy as np

import ulna
from ulna.bench.report import WORKLOADS
from ulna.bench.timing import Workload, one_pass

ROWS = 1000
_TICKS, _PLANS, _SEED = 64, 4, 3


def works() -> dict[str, Workload]:
    """Calls of a Panda: kinematics, inverse kinematics, collision and dynamics, an edge, a tick and a plan."""
    panda, named = ulna.load("panda"), {}
    for make in WORKLOADS.values():
        named |= make(panda, ROWS)
    return named | force_works(panda) | motion_works(panda)


def force_works(robot: ulna.Robot) -> dict[str, Workload]:
    """Batches of dynamics; empty for an older checkout without them."""
    if not hasattr(robot, "inverse_dynamics"):
        return {}
    motions = robot.random(ROWS, seed=_SEED), *np.random.default_rng(_SEED).normal(size=(2, ROWS, robot.n_dof))
    calls = robot.inverse_dynamics, robot.forward_dynamics, robot.inverse_dynamics_derivatives
    return {f"{call.__name__}, {ROWS}": Workload(lambda x, call=call: call(*x), [motions] * 4, ROWS) for call in calls}


def motion_works(robot: ulna.Robot) -> dict[str, Workload]:
    """Edges among boxes and in a cloud, ticks with a moving box, plans, each from its own seed."""
    boxes, cloud, q = _boxes(), _boxes(), robot.random(400, seed=_SEED)
    points = np.random.default_rng(_SEED).uniform((-0.8, -0.8, 0.9), (0.8, 0.8, 1.3), (10_000, 3))
    cloud.add("cloud", ulna.PointCloud(points, 0.01))
    free = q[(robot.signed_distance(q, boxes) > 0.02) & (robot.signed_distance(q, cloud) > 0.02)]
    edges = list(zip(free[:16], free[:16] + 0.05, strict=True))
    ends = list(zip(free[16 : 16 + _PLANS], free[16 + _PLANS : 16 + 2 * _PLANS], strict=True))
    return {
        "edge_in_collision, boxes": Workload(lambda ab: robot.edge_in_collision(ab[0], ab[1], boxes), edges),
        "edge_in_collision, cloud": Workload(lambda ab: robot.edge_in_collision(ab[0], ab[1], cloud), edges),
        "tick, a box moves": _ticks(robot, _boxes(), free[0]),
        "plan, boxes": Workload(lambda ab: robot.plan(ab[0], ab[1], boxes, seed=_SEED, max_checks=2000), ends),
    }


def _boxes() -> ulna.World:
    """Ten boxes around the arm."""
    world, rng = ulna.World(), np.random.default_rng(_SEED)
    for k in range(10):
        turn = 2 * np.pi * k / 10
        place = 0.7 * np.cos(turn), 0.7 * np.sin(turn), rng.uniform(0.1, 0.8)
        world.add(f"box {k}", ulna.Box((0.1, 0.1, 0.1)), ulna.pose(place))
    return world


def _ticks(robot: ulna.Robot, world: ulna.World, start: np.ndarray) -> Workload:
    """The first ticks from a start, repeated in each pass."""
    servo, target = robot.servo(world, acceleration=5.0), robot.forward_kinematics(robot.home)

    def tick(k: int) -> None:
        if k == 0:
            servo.start(start)
        world.move("box 0", ulna.pose((0.7, 0.0, 0.5 + 1e-4 * k)))
        servo.step(pose=target)

    return Workload(tick, range(_TICKS))


def main() -> None:
    """Serve until the input ends."""
    named = works()
    for work in named.values():
        one_pass(work)  # compiles
    sys.stdout.write(json.dumps(list(named)) + "\n")
    sys.stdout.flush()
    for line in sys.stdin:
        sys.stdout.write(f"{one_pass(named[line.strip()])}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
