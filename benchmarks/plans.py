"""Solves VAMP's 699 Panda problems and judges the paths: ``python -m benchmarks.plans RESOURCES/panda``.

The folder is ``resources/panda`` of the source distribution of ``vamp-planner``: 700 problems, one with a goal that touches.
The robot has VAMP's own 59 spheres, the objects are VAMP's. Times are those of the thread (``time.thread_time``), so that
a busy machine counts less; each is the least of three. A path is judged 64 times finer than VAMP samples its edges (32 a
radian): by the overlap test at all of these samples, and by Coal, an independent library, at those nearest to an object.
"""

import argparse
import time
from collections import defaultdict
from pathlib import Path

import coal
import numpy as np

import ulna
from benchmarks.vamp_problems import PlanningProblem, read_problems, spheres

FINER = 64 * 32  # samples a radian
JUDGED = 32  # samples of a path that Coal judges
COLUMNS = "problems", "solved", "median us", "mean us", "p95 us", "plan us", "length", "mean checks", "touch"


def main() -> None:
    """Solve, judge and print a row for each set of problems."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plans", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="one problem of so many")
    parser.add_argument("--sampled", action="store_true", help="edges checked at samples instead of certified")
    options = parser.parse_args()
    robot = spheres(options.folder)
    problems = read_problems(options.folder, robot.joint_names)[:: options.every]
    rows = defaultdict(list)
    for problem in problems:
        row = solve(robot, problem, certify=not options.sampled)
        if row is not None:
            rows[problem.name].append(row)
            rows["all"].append(row)
    print(f"{'':18}" + "".join(f"{name:>13}" for name in COLUMNS))
    for name, some in rows.items():
        print(f"{name:18}" + "".join(f"{value:13.6g}" for value in summary(some)), flush=True)


def solve(robot: ulna.Robot, problem: PlanningProblem, *, certify: bool) -> tuple | None:
    """Times of the whole and of the search alone [s], length, checks, whether the path touches; None if the goal touches."""
    world = problem.world()
    if robot.in_collision([problem.start, problem.goal], world).any():
        return None
    whole, search = (timed(robot, problem, world, certify=certify, shorten=shorten) for shorten in (True, False))
    plan = robot.plan(problem.start, problem.goal, world, certify=certify)
    if not plan:
        return (*[np.nan] * 4, False)
    return whole, search, plan.length, plan.checks, touches(robot, world, plan)


def timed(robot: ulna.Robot, problem: PlanningProblem, world: ulna.World, *, certify: bool, shorten: bool) -> float:
    """The least of three times of a plan [s]."""
    times = []
    for _ in range(3):
        began = time.thread_time()
        robot.plan(problem.start, problem.goal, world, certify=certify, shorten=shorten)
        times.append(time.thread_time() - began)
    return min(times)


def touches(robot: ulna.Robot, world: ulna.World, plan: ulna.Plan) -> bool:
    """Whether the path touches anything 64 times finer than it would be sampled."""
    q = plan.at(np.linspace(0, 1, 2 + int(plan.length * FINER)))
    if robot.in_collision(q, world).any():
        return True
    nearest = np.argsort(robot.signed_distance(q[::16], world, self_collision=False))[:JUDGED]
    return any(coal_touches(robot, world, q[16 * k]) for k in nearest)


def coal_touches(robot: ulna.Robot, world: ulna.World, q) -> bool:
    """Whether Coal finds a sphere of the robot and an object that overlap."""
    shapes = [one.shape for link in robot.description.links for one in link.collisions]
    request = coal.CollisionRequest()
    for shape, T in zip(shapes, robot.collision_poses(q), strict=True):
        ball = coal.Sphere(shape.radius), coal.Transform3s(T[:3, :3], T[:3, 3])
        for _, other, T_object in world.items():
            place = coal.Transform3s(T_object[:3, :3], T_object[:3, 3])
            if coal.collide(*ball, _of_coal(other), place, request, coal.CollisionResult()):
                return True
    return False


def _of_coal(shape):
    match shape:
        case ulna.Sphere():
            return coal.Sphere(shape.radius)
        case ulna.Capsule():
            return coal.Capsule(shape.radius, shape.length)
        case ulna.Cylinder():
            return coal.Cylinder(shape.radius, shape.length)
    return coal.Box(*shape.extents)


def summary(rows: list[tuple]) -> tuple:
    """The columns of a set of problems."""
    table = np.array(rows, dtype=float)
    good = table[np.isfinite(table[:, 0])]
    whole = 1e6 * good[:, 0]
    return (
        len(table), len(good), np.median(whole), whole.mean(), np.percentile(whole, 95), 1e6 * np.median(good[:, 1]),
        good[:, 2].mean(), good[:, 3].mean(), good[:, 4].sum(),
    )  # fmt: skip


if __name__ == "__main__":
    main()
