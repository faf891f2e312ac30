"""How the time of a plan grows with objects, joints and trees, and the memory: ``python -m benchmarks.plan_growth``.

Each time is that of one thread, the median over the problems, of which each counts with the least of three turns. The first plan
among other objects lays these out; that is timed apart, once.
"""

import time
import tracemalloc
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import ulna
from ulna.description.robot_description import Body, Description, Joint, JointType, Limits, Link

PROBLEMS = 30
SHELL = 0.7, 1.2  # [m] from the base to the objects; the Panda reaches 0.85 m


def main() -> None:
    """Print three tables."""
    print("objects     solved  median [ms]  laid out [ms]")
    for n in (1, 10, 100, 1000, 10_000):
        print("{:7d}  {:9d}  {:11.2f}  {:13.1f}".format(n, *of_objects(n)))
    print("\njoints      solved  median [ms]  median checks")
    for n in (2, 4, 7, 10, 14, 20):
        print("{:6d}  {:10d}  {:11.2f}  {:13.0f}".format(n, *of_joints(n)))
    print("\nchecks       nodes  time [ms]  us a check  peak of arrays [MB]")
    for n in (1000, 10_000, 100_000, 1_000_000):
        print("{:7d}  {:9d}  {:9.1f}  {:10.2f}  {:19.1f}".format(n, *of_trees(n)))


def of_objects(n: int) -> tuple[int, float, float]:
    """Plans of the Panda among so many boxes, of one volume together: solved, median time, and the layout [ms]."""
    robot, rng = ulna.load("panda"), np.random.default_rng(n)
    world, side = ulna.World(), (0.01 / n) ** (1 / 3)
    for k in range(n):
        way = rng.normal(size=3)
        world.add(f"{k}", ulna.Box((side,) * 3), ulna.pose(tuple(rng.uniform(*SHELL) * way / np.linalg.norm(way))))
    q = free(robot, world, rng)
    robot.plan(q[0], q[1])  # compiled then
    times = []
    for _ in range(2):  # the second among the same objects
        began = time.thread_time()
        robot.plan(q[0], q[1], world)
        times.append(time.thread_time() - began)
    laid_out = times[0] - times[1]
    solved, ms, _ = timed(robot, q, world)
    return solved, ms, 1e3 * laid_out


def of_joints(n: int) -> tuple[int, float, float]:
    """Plans of an arm of so many joints, 1 m long in all, among thirty balls: solved, median time [ms] and checks."""
    robot, rng = arm(n), np.random.default_rng(n)
    world = ulna.World()
    for k in range(30):
        way = rng.normal(size=3)
        world.add(f"{k}", ulna.Sphere(0.15), ulna.pose(tuple(rng.uniform(0.4, 0.9) * way / np.linalg.norm(way))))
    return timed(robot, free(robot, world, rng), world)


def of_trees(checks: int) -> tuple[int, float, float, float]:
    """A search without a path: nodes of both trees, time [ms], time of a check [us], peak memory of its arrays [MB]."""
    robot, world = arm(3), ulna.World()
    for sign in (-1, 1):  # the first link is too long to turn between two walls
        world.add(f"{sign}", ulna.Box((4, 0.1, 4)), ulna.pose((0, 0.33 * sign, 0)))
    start, goal = np.zeros(3), np.array([2.5, -1.5, 0.0])
    robot.plan(start, goal, world, max_checks=10)
    tracemalloc.start()
    began = time.thread_time()
    plan = robot.plan(start, goal, world, max_checks=checks, shorten=False)
    seconds, peak = time.thread_time() - began, tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    nodes = plan.effort.start_nodes + plan.effort.goal_nodes
    return nodes, 1e3 * seconds, 1e6 * seconds / max(plan.checks, 1), peak / 1e6


def timed(robot: ulna.Robot, q: NDArray, world: ulna.World) -> tuple[int, float, float]:
    """Plans between neighbouring rows of q: how many are solved, the median time [ms] and the median of the checks."""
    times, checks = [], []
    for start, goal in pairwise(q):
        least = np.inf
        for _ in range(3):
            began = time.thread_time()
            plan = robot.plan(start, goal, world)
            least = min(least, time.thread_time() - began)
        if plan:
            times.append(1e3 * least)
            checks.append(plan.checks)
    return len(times), float(np.median(times)), float(np.median(checks))


def free(robot: ulna.Robot, world: ulna.World, rng: np.random.Generator) -> NDArray:
    """Random configurations that touch nothing, one more than there are problems."""
    q = rng.uniform(robot.lower, robot.upper, (4000, robot.n_dof))
    return q[~robot.in_collision(q, world)][: PROBLEMS + 1]


def arm(n: int) -> ulna.Robot:
    """A chain of capsules, 1 m long in all, whose joints turn about z and y in turn."""
    length = 1.0 / n
    place = np.eye(4)
    place[:3, :3], place[0, 3] = ulna.pose((0, 0, 0), (0, np.pi / 2, 0))[:3, :3], length / 2
    shape = Body("capsule", ulna.Capsule(radius=0.02, length=0.6 * length), place)
    links = (Link("base"), *(Link(f"link{k}", collisions=(shape,)) for k in range(n)))
    joints, at = [], np.eye(4)
    for k in range(n):
        axis = np.array([0.0, 0.0, 1.0] if k % 2 == 0 else [0.0, 1.0, 0.0])
        limits = Limits(-2.5, 2.5)
        joints.append(Joint(f"joint{k}", JointType.REVOLUTE, links[k].name, links[k + 1].name, at, axis, limits))
        at = ulna.pose((length, 0, 0))
    return ulna.Robot(Description("chain", links, tuple(joints)))


if __name__ == "__main__":
    main()
