"""Times motions within limits of jerk: ``python -m benchmarks.jerk``, with ``pip install ruckig``.

Plans with corners: how long the motion takes that flows through them, and one that stops at each, beside the motion without a
limit of jerk; whether the limits hold and whether anything touches, at 20,001 moments. Lines: beside ruckig.

Ruckig (Berscheid and Kroeger, RSS 2021) computes time-optimal motions from state to state, here from rest to rest; its waypoints,
which a service on the internet computes, are not called. One joint: the durations are to agree to 1e-9. Several joints on a line:
ruckig synchronises them in phase, where that costs no time. With the same limits for all joints it does, and the durations are to
agree. With other limits the line may take longer than the slowest joint alone, and then what ruckig returns leaves the line.
"""

import argparse
import time

import numpy as np
import ruckig

import ulna
from ulna.planning.timing import double_s

N_JOINTS = 7
TOLERANCE = 1e-9
N_PLANS = 30
FRANKA = np.array([15, 7.5, 10, 12.5, 15, 20, 20]), np.array([7500, 3750, 5000, 6250, 7500, 10000, 10000])  # of its controller
LIMITS = {"Franka's": FRANKA, "15 rad/s2, 500 rad/s3": (15.0, 500.0), "5 rad/s2, 50 rad/s3": (5.0, 50.0)}


def main() -> None:
    """Print how far the durations differ, over random lines; and the time of a call of each."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.jerk", description=__doc__)
    parser.add_argument("--n", type=int, default=10_000, help="lines")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    one, several, times = [], [], np.zeros(2)
    for _ in range(options.n):
        limits = 10 ** rng.uniform(-2, 3, 3)
        length = 10 ** rng.uniform(-4, 2)
        began = time.thread_time()
        ours = double_s(length, *limits)[0].sum()
        between = time.thread_time()
        theirs = optimal(np.array([length]), *(np.array([limit]) for limit in limits))
        times += between - began, time.thread_time() - between
        one.append(abs(ours - theirs) / max(theirs, 1.0))
        way = rng.normal(size=N_JOINTS)
        shared = np.min(1 / np.abs(way)) * limits  # equal limits of all joints: the longest way decides
        theirs = optimal(way, *(np.full(N_JOINTS, limit) for limit in limits))
        several.append(abs(double_s(1.0, *shared)[0].sum() - theirs) / max(theirs, 1.0))
    for name, differences in (("one joint", one), (f"{N_JOINTS} joints in phase", several)):
        verdict = "agree" if max(differences) <= TOLERANCE else "DIFFER"
        print(f"{name}: durations {verdict} to {max(differences):.1e} of the duration, or of 1 s if that is more")
    print(f"a call: {times[0] / options.n * 1e6:.1f} us; ruckig {times[1] / options.n * 1e6:.1f} us, each from Python")


def corners() -> None:
    """Print what limits of jerk cost along plans of the Panda with corners, among random boxes."""
    robot, rng, plans = ulna.load("panda"), np.random.default_rng(5), []
    while len(plans) < N_PLANS:
        world = ulna.World()
        for k in range(rng.integers(5, 14)):
            place = rng.uniform((0.25, -0.6, 0.05), (0.8, 0.6, 0.8))
            world.add(f"box {k}", ulna.Box(rng.uniform(0.02, 0.3, 3)), ulna.pose(place, rpy=rng.uniform(-3, 3, 3)))
        free = [q for q in robot.random(100, seed=len(plans)) if not robot.in_collision(q, world)]
        plan = robot.plan(free[0], free[1], world) if len(free) > 1 else None
        if plan and len(plan.path) > 2:
            plans.append((world, plan))
    for name, (acceleration, jerk) in LIMITS.items():
        rows = []
        for world, plan in plans:
            usual, stopping = (
                plan.trajectory(acceleration=acceleration),
                plan.trajectory(acceleration=acceleration, blend=0.0, jerk=jerk),
            )
            began = time.process_time()
            motion = plan.trajectory(acceleration=acceleration, jerk=jerk)
            seconds = time.process_time() - began
            t = np.linspace(0, motion.duration, 20_001)
            q, *rates = motion.at(t)
            limits = robot.velocity_limits, acceleration, jerk
            beyond = max((np.abs(values) / limit).max() for values, limit in zip(rates, limits, strict=True)) > 1 + 1e-9
            touching = robot.in_collision(q, world).any()
            rows.append(
                (motion.duration / usual.duration, stopping.duration / usual.duration, motion.stops, seconds, beyond, touching)
            )
        flowing, halting, stops, seconds, beyond, touching = np.array(rows, dtype=float).T
        print(
            f"{N_PLANS} plans, {name}: {np.median(flowing):.3f} of the time without a limit of jerk (most {flowing.max():.3f}), "
            f"with a stop at each corner {np.median(halting):.2f} ({halting.max():.2f}); {stops.sum():.0f} stops; "
            f"{beyond.sum():.0f} beyond a limit, {touching.sum():.0f} touch; {np.median(seconds) * 1e3:.1f} ms"
        )


def optimal(way: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray) -> float:
    """The duration of ruckig's motion over a way from rest to rest [s]."""
    n = len(way)
    asked = ruckig.InputParameter(n)
    asked.synchronization = ruckig.Synchronization.Phase
    asked.current_position, asked.target_position = [0.0] * n, list(way)
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = list(velocity), list(acceleration), list(jerk)
    motion = ruckig.Trajectory(n)
    if ruckig.Ruckig(n).calculate(asked, motion) not in {ruckig.Result.Working, ruckig.Result.Finished}:
        raise AssertionError("ruckig finds no motion")
    return motion.duration


if __name__ == "__main__":
    main()
    corners()
