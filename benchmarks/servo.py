"""Measures the servo: ``python -m benchmarks.servo``; ticks, safety, free space, reaching, and mink and Pink.

Times are the thread's own, on one processor. Seeds determine scenes and goals (``servo_scenes``). The judges are Coal, whose
shapes Pinocchio places, and differences of the commands (``servo_judges``). A peer that is not installed is named.
"""

import argparse
import importlib
import sys
import time
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import ulna
from benchmarks.cell import seen
from benchmarks.collision import scattered
from benchmarks.markdown import table
from benchmarks.peer import NotForThisArm
from benchmarks.processors import one_processor
from benchmarks.servo_judges import chatter, contacts, curve, off_path, overlaps, shares_of_limits
from benchmarks.servo_scenes import (
    ACCELERATION,
    CLEARANCE,
    KINDS_OF_SCENES,
    POSES,
    RATE,
    SPARE,
    Chaser,
    arm,
    hand_of,
    hostile,
    paced,
    scene,
    start_of,
    two_arms,
)

Array = NDArray[np.float64]
ARMS = ("panda", "ur5", "xarm7", "iiwa14")
PEERS = ("mink", "pink")
OBJECTS = 10
GAIN = RATE / 4  # [1/s], of the loop around ``differential_ik``, equal to the servo's gain near a pose
FASTEST = 1.0  # [m/s and rad/s], on the direct path
PATIENCE = 5_000  # ticks allowed for reaching a target
NEAR_ENOUGH = 1e-3, 1e-2  # [m], [rad]
STRAIGHT = 5e-3, 2e-2  # [m], [rad]: maximum distance of a straight motion from the straight line
REST = 2_000  # ticks allowed until the arm rests
RUNS = 5  # repetitions of the same ticks: a slow median belongs to the tick, a single slow run to the machine
LIMITS = {"acceleration": ACCELERATION}  # and jerk, if one is given
ESCAPE, MOVED = 100, 1e-3  # ticks away from a rest, and minimum change of an entry of q by then [rad]


def main() -> None:
    """Print each table as soon as it is measured."""
    options = _options()
    if options.jerk is not None:
        LIMITS["jerk"] = options.jerk
    arms = options.arm or ARMS
    tables: dict[str, Callable[[], list[dict]]] = {
        "ticks": lambda: tick_rows(options.ticks),
        "safety": lambda: [
            safety_row(name, kind, options.scenes, options.ticks) for name in arms for kind in options.kind or KINDS_OF_SCENES[:1]
        ],
        "free": lambda: [row for name in options.arm or ARMS for row in free_rows(name, options.ticks)],
        "reaching": lambda: [reaching_row(name, options.targets, options.seed) for name in arms],
        "peers": lambda: [
            row for name in options.arm or ARMS for row in peer_rows(name, options.peer_scenes, options.peer_ticks)
        ],
    }
    with one_processor():
        for name in options.only or tables:
            sys.stdout.write(f"## {name}\n\n{table(tables[name]())}\n\n")
            sys.stdout.flush()


# ---- the time of a tick -------------------------------------------------------------------------------------------------


def tick_rows(ticks: int) -> list[dict]:
    """Ticks towards poses that jump once per second: percentiles of the time, and of each tick's median over RUNS."""
    panda, ur5 = ulna.load("panda"), arm("ur5")
    cloud, moving = ulna.World(), scattered(OBJECTS, 0.1, 0.9)
    cloud.add("cloud", seen(10_000))
    moving.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0.5, 0.5)))
    cases = {
        "ten boxes": (panda, scattered(OBJECTS, 0.1, 0.9)),
        "100 boxes": (panda, scattered(100, 0.1, 0.9)),
        "ten boxes, one more moves": (panda, moving),
        "a cloud of 10^4 points": (panda, cloud),
        "a UR5 of hulls, ten boxes": (ur5, scattered(OBJECTS, 0.1, 0.9)),
        "two arms, ten boxes": (two_arms(), scattered(OBJECTS, 0.1, 0.9)),
    }
    return [{"scene": name, "joints": robot.n_dof, **tick_times(robot, world, ticks)} for name, (robot, world) in cases.items()]


def tick_times(robot: ulna.Robot, world: ulna.World, ticks: int) -> dict[str, float]:
    """The time of a tick, including the crate's motion, if any; and every 20th command's minimum distance."""
    link = hand_of(robot)
    q = robot.random(1000, seed=4)
    start, *there = q[robot.signed_distance(q, world) > SPARE][:21]
    servo = robot.servo(world, **LIMITS, link=link)
    servo.warm_up()
    targets = robot.forward_kinematics(np.array(there), link=link)
    times, least = np.empty((RUNS, ticks)), np.inf
    for run in range(RUNS):
        move_crate(world, 0)
        servo.start(start)
        for k in range(ticks):
            target = targets[k // RATE % len(targets)]
            began = time.thread_time()
            move_crate(world, k)
            command = servo.step(pose=target)
            times[run, k] = time.thread_time() - began
            if run == 0 and k % 20 == 0:
                least = min(least, float(robot.signed_distance(command.q, world, self_collision=False)))
    own = 1e6 * float(np.percentile(np.median(times, axis=0), 99.9))
    return {"ticks": ticks, **percentiles(times), "p99.9_of_medians_us": own, "least_distance_mm": 1e3 * least}


def move_crate(world: ulna.World, k: int) -> None:
    """Move the crate, if there is one, to its pose in tick k."""
    if "crate" in world.names:
        world.move("crate", ulna.pose((0.5, 0.5, 0.5 + 0.3 * np.sin(k / RATE))))


def percentiles(times: Array) -> dict[str, float]:
    """p50, p99 and p99.9 [us]."""
    return {f"p{share:g}_us": 1e6 * float(np.percentile(times, share)) for share in (50, 99, 99.9)}


# ---- safety -------------------------------------------------------------------------------------------------------------


class Run:
    """A servo in a scene, its commands, their times [s], and the moving object."""

    def __init__(self, robot: ulna.Robot, kind: str, seed: int) -> None:
        self.robot, self.world = robot, scene(robot, OBJECTS, seed, kind)
        self.servo = robot.servo(self.world, **LIMITS, clearance=CLEARANCE, link=hand_of(robot))
        self.commands, self.times = [self.servo.start(start_of(robot, self.world))], []
        self.ball = Chaser(robot, self.world, seed) if kind == "moving" else None

    def step(self, **goal: Any) -> ulna.Command:
        """The next command, and the motion of the moving object in its tick."""
        before, began = self.commands[-1], time.thread_time()
        self.commands.append(self.servo.step(**goal))
        self.times.append(time.thread_time() - began)
        if self.ball is not None:
            self.ball.move(self.commands[-1].q, rests=not (before.qd.any() or self.commands[-1].qd.any()))
        return self.commands[-1]

    def judged(self) -> dict:
        """The results of the judges."""
        states = (np.array([getattr(c, name) for c in self.commands]) for name in ("q", "qd", "qdd"))
        return judged(self.robot, self.world, *states, ball=None if self.ball is None else np.array(self.ball.places))


def safety_row(name: str, kind: str, scenes: int, ticks: int) -> dict:
    """Hostile goals in random scenes, with a rest and an escape after each second; contacts and limits of everything."""
    robot, found, times = arm(name), [], []
    for seed in range(scenes):
        run, rests, goals = Run(robot, kind, seed), {"rests": 0, "dead_ends": 0}, hostile(robot, ticks, seed)
        while batch := list(islice(goals, RATE)):
            for goal in batch:
                run.step(**goal)
                times.append(run.times[-1])
            leave(run, rests)
        found.append(rests | run.judged())
    totals = {
        key: sum(row[key] for row in found)
        for key in ("ticks", "contacts_Coal", "contacts_Ulna", "violations", "rests", "dead_ends")
    }
    keys = ("velocity", "acceleration", *(["jerk"] if "jerk" in LIMITS else []), "beyond_rad")
    worst = {key: max(row[key] for row in found) for key in keys}
    return {"arm": name, "kind": kind, "scenes": scenes} | totals | worst | percentiles(np.array(times))


def leave(run: Run, rests: dict) -> None:
    """Come to rest, and move away from near objects; a dead end is a place that no tried direction leaves."""
    robot = run.robot
    for _ in range(REST):
        if run.step().status == "at rest":
            break
    q = run.servo.q
    away = robot.distance_gradient(q, run.world)
    directions = [away / max(np.abs(away).max(), 1e-9), *np.random.default_rng(0).choice([-1.0, 1.0], (10, robot.n_dof))]
    rests["rests"] += 1
    for direction in directions:
        for _ in range(ESCAPE):
            run.step(velocity=0.5 * direction)
        if np.abs(run.servo.q - q).max() > MOVED:
            return
    rests["dead_ends"] += 1


def judged(
    robot: ulna.Robot,
    world: ulna.World,
    q: Array,
    qd: Array | None = None,
    qdd: Array | None = None,
    *,
    ball: Array | None = None,
) -> dict:
    """The results of the judges: ticks with contacts, the maximum depth, shares of limits; Coal alone judges moving objects."""
    jerk = LIMITS.get("jerk")
    fine = curve(q, qd, None if jerk is None else qdd)
    touched, depth = contacts(robot, world, fine, ball)
    still = world.copy()
    if ball is not None:
        still.remove("ball")
    return {
        "ticks": len(q) - 1,
        "contacts_Coal": touched,
        "contacts_Ulna": overlaps(robot, still, fine),
        "depth_mm": 1e3 * depth,
        **shares_of_limits(robot, q, ACCELERATION, None if qd is None else jerk),
    }


# ---- free space ---------------------------------------------------------------------------------------------------------


def free_rows(name: str, ticks: int) -> list[dict]:
    """The hand's distance from a smooth path without a world, next to a loop around ``differential_ik``."""
    robot = arm(name)
    q = paced(robot, ticks, 0)
    targets = robot.forward_kinematics(q)
    ways = {"differential_ik": in_a_loop, "servo, twist": by_twists, "servo, pose": by_poses}
    rows, plain = [], np.nan
    for way, follow in ways.items():
        went = follow(robot, q[0], targets)
        off = off_path(robot.forward_kinematics(went)[:, :3, 3], targets[:, :3, 3])
        mean = 1e6 * float(off.mean())
        plain = mean if way == "differential_ik" else plain
        rows.append({
            "arm": name, "way": way, "off_path_mean_um": mean, "times_differential_ik": mean / plain,
            "off_path_most_um": 1e6 * float(off.max()), "above_50_Hz_percent": 100 * chatter(went),
            "velocity": float((np.abs(np.diff(went, axis=0)) * RATE / robot.velocity_limits).max()),
        })  # fmt: skip
    return rows


def towards(T: Array, target: Array, gain: float, fastest: float = np.inf) -> Array:
    """The twist towards a pose, limited to the maximum speed, shape (..., 6)."""
    turn = Rotation.from_matrix(target[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2)).as_rotvec()
    twist = gain * np.concatenate([target[..., :3, 3] - T[..., :3, 3], turn], axis=-1)
    size = np.maximum(np.linalg.norm(twist[..., :3], axis=-1), np.linalg.norm(twist[..., 3:], axis=-1))
    return twist * np.minimum(1.0, fastest / np.maximum(size, 1e-300))[..., None]


def in_a_loop(robot: ulna.Robot, q: Array, targets: Array) -> Array:
    """The configurations of a loop around ``differential_ik``, shape (n, n_dof)."""
    went = []
    for target in targets:
        twist = towards(robot.forward_kinematics(q), target, GAIN)
        q = q + robot.differential_ik(q, twist, 1 / RATE) / RATE
        went.append(q)
    return np.array(went)


def by_twists(robot: ulna.Robot, q: Array, targets: Array) -> Array:
    """The configurations of a servo that receives the twists of the same loop."""
    servo = robot.servo(**LIMITS)
    servo.start(q)
    return np.array([servo.step(twist=towards(robot.forward_kinematics(servo.q), target, GAIN)).q for target in targets])


def by_poses(robot: ulna.Robot, q: Array, targets: Array) -> Array:
    """The configurations of a servo that receives the poses."""
    servo = robot.servo(**LIMITS)
    servo.start(q)
    return np.array([servo.step(pose=target).q for target in targets])


# ---- reaching -----------------------------------------------------------------------------------------------------------


def reaching_row(name: str, targets: int, first: int) -> dict:
    """The share of targets that a servo reaches among objects; a direct path has 20 mm clearance.

    The same for targets to which the hand moved straight: at joint limits it does not.
    """
    robot, ticks, tried, straight, straight_reached, seed = arm(name), [], 0, 0, 0, first
    while tried < targets:
        world = scene(robot, OBJECTS, seed)
        for start, goal, is_straight in islice(direct(robot, world, max(20, targets // 5), seed), targets - tried):
            servo, T = robot.servo(world, **LIMITS, clearance=CLEARANCE), robot.forward_kinematics(goal)
            servo.start(start)
            tried, straight = tried + 1, straight + is_straight
            for k in range(PATIENCE):
                if is_reached(robot.forward_kinematics(servo.step(pose=T).q), T):
                    straight_reached += is_straight
                    ticks.append(k + 1)
                    break
        seed += 1
    shares = {
        "reached_percent": 100 * len(ticks) / tried,
        "straight": straight,
        "of_straight_percent": 100 * straight_reached / straight,
    }
    return {"arm": name, "scenes": seed - first, "targets": tried} | shares | {"seconds_median": float(np.median(ticks)) / RATE}


def direct(robot: ulna.Robot, world: ulna.World, n: int, seed: int) -> Iterator[tuple[Array, Array, bool]]:
    """Starts and goals, n of them, with a free direct path of the hand by ``differential_ik``, with 20 mm clearance.

    Each comes with a flag: whether the hand moves straight on that path.
    """
    q = robot.random(20 * n, seed=seed)
    q = q[robot.signed_distance(q, world) > SPARE][: 2 * n]
    starts, goals = np.split(q[: len(q) // 2 * 2], 2)
    targets, q, path = robot.forward_kinematics(goals), starts, [starts]
    first, off = towards(robot.forward_kinematics(q), targets, 1.0), np.zeros((len(starts), 2))
    for k in range(PATIENCE):
        T = robot.forward_kinematics(q)
        off = np.maximum(off, beside(towards(T, targets, 1.0), first))
        twist = towards(T, targets, GAIN, FASTEST)
        q = q + robot.differential_ik(q, twist, 1 / RATE) / RATE
        if k % 2 == 0:
            path.append(q)
    there = np.array([is_reached(T, target) for T, target in zip(robot.forward_kinematics(q), targets, strict=True)])
    ways = np.moveaxis(np.array(path), 0, 1)
    straight = np.all(off < np.array(STRAIGHT), axis=1)
    for start, goal, way, is_straight in zip(starts[there], goals[there], ways[there], straight[there], strict=True):
        moves = np.flatnonzero(np.abs(np.diff(way, axis=0)).max(axis=1) > 1e-9)
        if robot.signed_distance(way[: moves.max(initial=0) + 2], world).min() > SPARE:
            yield start, goal, bool(is_straight)


def beside(twist: Array, first: Array) -> Array:
    """The deviation of the remaining path from the initial one: displacement [m] and rotation [rad], shape (n, 2)."""
    parts, wholes = twist.reshape(-1, 2, 3), first.reshape(-1, 2, 3)
    along = wholes / np.maximum(np.linalg.norm(wholes, axis=-1, keepdims=True), 1e-300)
    return np.linalg.norm(np.cross(parts, along), axis=-1)


def is_reached(T: Array, target: Array) -> bool:
    """Whether a pose is within 1 mm and 10 mrad of its target."""
    twist = towards(T, target, 1.0)
    return bool(np.linalg.norm(twist[:3]) < NEAR_ENOUGH[0] and np.linalg.norm(twist[3:]) < NEAR_ENOUGH[1])


# ---- peers --------------------------------------------------------------------------------------------------------------


class OwnFollower:
    """Ulna's servo with the interface of the peers' followers; no tick is infeasible."""

    infeasible = 0

    def __init__(self, robot: ulna.Robot, world: ulna.World | None, q: Array, acceleration: float) -> None:
        self._servo = robot.servo(world, **(LIMITS | {"acceleration": acceleration}), clearance=CLEARANCE)
        self._servo.start(q)

    def step(self, T: Array) -> Array:
        return self._servo.step(pose=T).q


def peer_rows(name: str, scenes: int, ticks: int) -> list[dict]:
    """The same poses in the same scenes for each library: hostile ones, and a smooth path through the objects."""
    robot, followers, rows = arm(name), {"ulna": OwnFollower}, []
    for peer in PEERS:
        try:
            module = importlib.import_module(f"benchmarks.peers.{peer}")
            followers[f"{peer} {module.VERSION}"] = module.Follower
        except ImportError as error:
            sys.stderr.write(f"{peer}: absent: {error}\n")
    for kind in ("hostile", "smooth"):
        for library, follower in followers.items():
            try:
                found = [followed(robot, follower, kind, seed, ticks) for seed in range(scenes)]
            except NotForThisArm as reason:
                sys.stderr.write(f"{name}, {library}: {reason}\n")
                continue
            rows.append({"arm": name, "targets": kind, "library": library, **side_by_side(found)})
    return rows


def followed(robot: ulna.Robot, follower: Callable, kind: str, seed: int, ticks: int) -> dict:
    """The result of one library for the poses in one scene."""
    world = scene(robot, OBJECTS, seed)
    start = start_of(robot, world)
    poses = [goal["pose"] for goal in hostile(robot, ticks, seed, POSES)]
    if kind == "smooth":
        poses = list(robot.forward_kinematics(paced(robot, ticks, seed)))
    one, q, times = follower(robot, world, start, ACCELERATION), [start], []
    for T in poses:
        began = time.thread_time()
        q.append(one.step(T))
        times.append(time.thread_time() - began)
    moved = float(np.abs(np.diff(q, axis=0)).sum())
    late = {"above_50_Hz_percent": 100 * chatter(np.array(q[RATE:]))}  # without the motion to the first pose
    return judged(robot, world, np.array(q)) | late | {"infeasible": one.infeasible, "times": times, "moved_rad": moved}


def side_by_side(found: list[dict]) -> dict:
    """The sums, the maxima and the medians over the scenes."""
    totals = {key: sum(row[key] for row in found) for key in ("ticks", "contacts_Coal", "infeasible", "moved_rad")}
    worst = {key: max(row[key] for row in found) for key in ("depth_mm", "velocity", "acceleration")}
    times = percentiles(np.concatenate([row["times"] for row in found]))
    return totals | worst | {"above_50_Hz_percent": float(np.median([row["above_50_Hz_percent"] for row in found]))} | times


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo", description=__doc__)
    names = ("ticks", "safety", "free", "reaching", "peers")
    parser.add_argument("--only", action="append", choices=names, help="a table; repeatable; all of them unless given")
    parser.add_argument("--jerk", type=float, help="a limit of every joint [rad/s^3]; without one the jerk is not limited")
    parser.add_argument("--arm", action="append", help=f"repeatable; {', '.join(ARMS)} unless given")
    parser.add_argument("--kind", action="append", choices=KINDS_OF_SCENES, help="of scenes, for safety; shapes unless given")
    parser.add_argument("--ticks", type=int, default=10_000, help="of each scene and path")
    parser.add_argument("--scenes", type=int, default=4, help="of each arm, for safety; 25 are a hundred")
    parser.add_argument("--targets", type=int, default=25, help="of each arm, to be reached; 250 are a thousand")
    parser.add_argument("--seed", type=int, default=0, help="of the first scene with targets to be reached")
    parser.add_argument("--peer-scenes", type=int, default=3)
    parser.add_argument("--peer-ticks", type=int, default=2000)
    return parser.parse_args()


if __name__ == "__main__":
    main()
