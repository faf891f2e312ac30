"""Calls every entry for every signature, and writes hashes of all that they were given and gave: a program, for one CPU level.

python every_entry.py answers.json

With a wheel ``ULNA_CPU`` names the level; where Numba compiles, ``NUMBA_CPU_NAME``. The same hashes are the same bits.
"""

import hashlib
import json
import os
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from types import ModuleType

import numpy as np

import ulna
import ulna.robot
import ulna.viewer.film.painter
import ulna.viewer.film.recording as film
from ulna.collision import world as worlds
from ulna.engine import threads
from ulna.engine.entries import Entries, ready
from ulna.planning import slices

N = 1000
CALLERS = "ulna.collision", "ulna.dynamics", "ulna.ik", "ulna.kinematics", "ulna.planning", "ulna.servo", "ulna.viewer", "ulna.dh"
HASHES, ROWS = defaultdict(hashlib.sha256), defaultdict(int)


class Zeros:
    """NumPy, whose empty arrays are zeros: what an entry leaves as it is has the same bits in every process."""

    empty = staticmethod(np.zeros)

    @staticmethod
    def empty_like(array):
        return np.zeros_like(array)

    def __getattr__(self, name):
        return getattr(np, name)


def parts_of(argument):
    """The arrays and numbers of an argument: a named tuple's parts, one by one."""
    return [argument] if not isinstance(argument, tuple) else [part for each in argument for part in parts_of(each)]


def recording(name, entry):
    """An entry that hashes its arguments, after the call, and its result."""

    def recorded(*given):
        result = entry(*given)
        arguments = [part for argument in given for part in (parts_of(argument) if hasattr(argument, "_fields") else (argument,))]
        key = f"{name}{' (boxes)' if len(arguments) > 5 and arguments[2] is None else ''}"
        key += " (no constraints)" if len(arguments) > 12 and arguments[11] is None else ""
        key += " (no numbers)" if arguments[-1] is None else ""
        key += " (float32)" if getattr(arguments[0], "dtype", None) == np.float32 else ""
        for argument in (*arguments, result):
            for part in parts_of(argument):
                HASHES[key].update(bytes_of(part) if isinstance(part, np.ndarray) else repr(part).encode())
        ROWS[key] += max((len(part) for part in arguments if isinstance(part, np.ndarray)), default=1)
        return result

    return recorded


def bytes_of(array):
    """Its numbers; of records field by field, as a copy leaves anything between the fields."""
    names = array.dtype.names
    return array.tobytes() if names is None else b"".join(array[name].tobytes() for name in names)


def has_entries(thing):
    """Whether something that a caller has imported is a module of entries."""
    return isinstance(thing, ModuleType) and ".entries." in thing.__name__


def ask():
    """A thousand questions of each kind."""
    panda, rng = ulna.load("panda"), np.random.default_rng(1)
    q, mixed, boxes = panda.random(N, seed=1), ulna.World(), ulna.World()
    for k in range(80):
        place = ulna.pose(rng.uniform(-0.8, 0.8, 3), rpy=rng.uniform(-3, 3, 3))
        shapes = ulna.Sphere(0.02), ulna.Cylinder(0.02, 0.1), ulna.Capsule(0.02, 0.1), ulna.Box((0.05, 0.1, 0.02))
        mixed.add(f"any {k}", shapes[k % 4], place)
        boxes.add(f"box {k}", shapes[3], place)
    for kind in ("float32", "float64"):
        cloud = ulna.PointCloud(rng.uniform(0.3, 1.5, (N, 3)).astype(kind), 0.01)
        mixed.add(kind, cloud.thinned(0.05).without(panda, panda.home))
    tool = ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
    held = panda.with_attached("tool", tool, np.eye(4))
    targets, twists = panda.forward_kinematics(q), rng.normal(size=(N, 6))
    for frame in ("base", "link", "spatial"):
        panda.jacobian(q, expressed_in=frame), panda.jacobian(q[0], expressed_in=frame)
    (
        panda.link_poses(q),
        panda.link_poses(q[0]),
        panda.differential_ik(q, twists, 0.01),
        panda.differential_ik(q[0], twists[0], 0.01),
    )
    for one, target in zip(q[:200], targets[:200], strict=True):
        panda.forward_kinematics(one), panda.inverse_kinematics(target), panda.inverse_kinematics(target, one + 0.1)
    for target in targets:
        worlds.placing.copy_exact(target, np.zeros((4, 4)))
    panda.inverse_kinematics(targets)
    for robot, world in ((panda, boxes), (panda, mixed), (held, mixed), (panda, None)):
        robot.in_collision(q, world), robot.signed_distance(q, world), robot.distance_gradient(q, world)
        robot.edge_in_collision(q[:50], q[50:100], world), robot.check_collision(q[:100], world, max_distance=0.05)
        robot.distances(q[:100], world)
        for one in q[:200]:
            robot.in_collision(one, world)
        ask_a_servo(robot, world)
    ask_for_closed_forms()
    ask_for_forces(panda, q)
    str(panda.allowed_collisions), str(held.with_tool(np.eye(4)).allowed_collisions)
    ask_for_plans([(panda, boxes), (held, mixed)])
    with tempfile.TemporaryDirectory() as folder:
        film.record_robot(film.make_form(Path(folder, "film.mp4"), 0.1, (64, 36)), panda, panda.home)


def ask_a_servo(robot, world):
    """For commands of each kind, from the first configuration where it can start."""
    servo, free = robot.servo(world, acceleration=5.0, clearance=0.0), robot.random(1000, seed=3)
    start = free[np.argmax(robot.signed_distance(free, world))]
    servo.start(start)
    for k in range(100):
        servo.step(velocity=np.full(robot.n_dof, 0.2)), servo.step(twist=np.full(6, 0.1)), servo.step(q=free[k % 40])
    for _ in range(100):
        servo.step(pose=robot.forward_kinematics(start)), servo.step()
    servo.step(velocity=np.full(robot.n_dof, 0.2))
    assert len(servo.stop_positions) > 0


def ask_for_closed_forms():
    """Of arms of six joints, made as Universal Robots' are, and of five of them."""
    right = np.pi / 2
    rows = [(0, 0.09, right, 0), (-0.42, 0, 0, 0), (-0.39, 0, 0, 0), (0, 0.11, right, 0), (0, 0.09, -right, 0), (0, 0.08, 0, 0)]
    for n in (6, 5):
        arm = ulna.Robot.from_dh(rows[:n], convention="standard")
        targets = arm.forward_kinematics(arm.random(N, seed=2))
        arm.inverse_kinematics(targets), arm.all_solutions(targets)
        for one in targets[:200]:
            arm.inverse_kinematics(one), arm.all_solutions(one)


def ask_for_forces(robot, q):
    """Of a batch, and of one configuration."""
    rates, one = np.random.default_rng(5).normal(size=(2, *q.shape)), q[0]
    robot.inverse_dynamics(q, *rates), robot.gravity_torque(q), robot.inverse_dynamics_derivatives(q, *rates)
    robot.mass_matrix(q), robot.forward_dynamics(q, *rates), robot.center_of_mass(q)
    (
        robot.inverse_dynamics(one, one, one),
        robot.gravity_torque(one),
        robot.mass_matrix(one),
        robot.forward_dynamics(one, one, one),
    )


def ask_for_plans(robots_and_worlds):
    """Of a robot among boxes, and among any shapes, with a constraint too."""
    for robot, world in robots_and_worlds:
        near = robot.home + np.random.default_rng(4).normal(scale=0.05, size=(N, robot.n_dof))
        robot.edge_keeps(robot.home, near, ulna.Keep.upright())
        there = robot.inverse_kinematics(robot.forward_kinematics(robot.home) @ ulna.pose((0, 0.1, 0)), robot.home).q
        plan = robot.plan(robot.home, there, keep=ulna.Keep.orientation(within=1e-3))
        plan.trajectory(acceleration=1.0, jerk=10.0)
        free = [q for q in robot.random(40, seed=3) if not robot.in_collision(q, world)]
        robot.plan(free[0], free[1], world, keep=ulna.Keep.upright(within=3.0), max_checks=500)
        for goal in free[1:5]:
            plan = robot.plan(free[0], goal, world, max_checks=2000)
            if plan:
                best = plan.improve(200)
                best.trajectory(acceleration=5.0), best.trajectory(acceleration=5.0, jerk=100.0)


def main(file):
    slices._LONGEST_SLICE = threads._SECONDS = float("inf")  # so that neither a plan's slices nor a batch's depend on the clock
    callers = [module for name, module in list(sys.modules.items()) if name.startswith(CALLERS)]
    for module in callers:
        if hasattr(module, "np"):
            module.np = Zeros()
    modules = {id(each): each for caller in callers for each in vars(caller).values() if has_entries(each)}.values()
    for name in Entries("ulna").names():
        for each in modules:
            module, _, function = name.rpartition(".")
            if each.__name__ == f"ulna.{module}":
                setattr(each, function, recording(name, ready(getattr(each, function))))
    ask()
    answers = {key: [digest.hexdigest(), ROWS[key]] for key, digest in sorted(HASHES.items())}
    Path(file).write_text(json.dumps(answers, indent=1))


if __name__ == "__main__":
    os.environ["ULNA_THREADS"] = "1"  # so that the calls come in one order
    main(sys.argv[1])
