"""Motions within limits of jerk: ``python -m benchmarks.motions RESOURCES/panda``, beside ``copp-py`` if it is installed.

The folder is VAMP's (``benchmarks.plans``): its problems are planned with its spheres and its objects. Then curves through thirty
points. For each: the time of the plan and of the motion, the duration beside the motion without a limit of jerk, the greatest
shares of velocity, acceleration and jerk by differences of samples, and whether a shape touches (the overlap test, 64 times finer
than VAMP looks at its edges). The path of the motion itself, with its derivatives, is then timed by copp-py's TOPP2 and TOPP3.
Every time is the thread's own.
"""

import argparse
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import ulna
from benchmarks.markdown import table
from benchmarks.peer import NotForThisArm
from benchmarks.plan_judges import coal_touches, overlaps
from benchmarks.plans import FINER, within_limits
from benchmarks.processors import one_processor
from benchmarks.vamp_problems import read_problems, spheres
from ulna.planning.motion_limits import as_motion_limits

Array = NDArray[np.float64]
KINDS = "velocity", "acceleration", "jerk", "limits"
PERIODS = 1e-3, 1e-4  # [s], of the samples whose differences are taken
POINTS, CURVES = 30, 50
ROUNDING = 2e-14  # [rad], of a sample: the differences of order k have at most 2^k times that over the period's power k


def main() -> None:
    """Print a row for VAMP's problems and one for the curves, and each motion that is beyond a limit or touches."""
    options = _options()
    robot = spheres(options.folder)
    with one_processor():
        vamps = [measured(robot, world, make, name, options) for name, world, make in vamp_motions(robot, options)]
        curves = [measured(robot, None, make, name, options) for name, world, make in curve_motions(robot)]
    print(table([summary("VAMP's problems", vamps), summary(f"{POINTS} points", curves)]))


def vamp_motions(robot: ulna.Robot, options: argparse.Namespace) -> Iterator[tuple]:
    """A name, the world, and a function that plans and makes the motion, with a limit of jerk or without one."""
    for given in read_problems(options.folder, robot.joint_names)[:: options.every]:
        problem, world = within_limits(robot, given), given.world()
        if problem is None or robot.in_collision([problem.start, problem.goal], world).any():
            continue

        def make(problem=problem, world=world):
            plan = robot.plan(problem.start, problem.goal, world)
            return plan.trajectory if plan else None

        yield f"{given.name} {given.index}", world, make


def curve_motions(robot: ulna.Robot) -> Iterator[tuple]:
    """Thirty points each on a smooth curve, without a world."""
    rng = np.random.default_rng(0)
    middle, half = (robot.upper + robot.lower) / 2, 0.3 * (robot.upper - robot.lower)
    for k in range(CURVES):
        spline = CubicSpline(np.linspace(0, 1, 6), middle + half * rng.uniform(-1, 1, (6, robot.n_dof)))
        points = spline(np.linspace(0, 1, POINTS))
        yield f"curve {k}", None, lambda points=points: lambda **limits: robot.trajectory(points, **limits)


def measured(robot: ulna.Robot, world: ulna.World | None, make, name: str, options: argparse.Namespace) -> dict:
    """Everything about one motion."""
    row: dict = {"name": name}
    best = [np.inf, np.inf]
    for _ in range(3):
        began = time.thread_time()
        trajectory = make()
        planned = time.thread_time()
        if trajectory is None:
            return row
        motion = trajectory(**options.limits)
        best = [min(best[0], planned - began), min(best[1], time.thread_time() - planned)]
    row |= {"plan_s": best[0], "motion_s": best[1], "duration": motion.duration, "stops": motion.stops}
    kept, _ = as_motion_limits(robot.tree, *map(options.limits.get, KINDS))
    row["unlimited_jerk"] = trajectory(velocity=kept.velocity, acceleration=kept.acceleration).duration
    for period in PERIODS:
        row[f"shares_{period:g}"] = shares(motion, kept, period)
    if world is not None:
        q = motion.at(np.linspace(0, motion.duration, 2 + int(motion.duration / PERIODS[0]))).q
        row["touches"] = overlaps(robot, world, q, FINER) or (options.coal and coal_touches(robot, world, q, FINER))
    found = [row[f"shares_{period:g}"] for period in PERIODS]
    row["beyond"] = any((each > 1 + rounding(kept, period)).any() for each, period in zip(found, PERIODS, strict=True))
    if row["beyond"] or row.get("touches", False):
        print(f"{name}: shares {found}, touches {row.get('touches')}", file=sys.stderr)
    try:
        from benchmarks.peers.copp import durations  # noqa: PLC0415 -- it may be absent

        row |= durations(motion, kept.velocity, kept.acceleration, kept.jerk)
    except (ImportError, NotForThisArm) as reason:
        print(f"{name}: copp-py: {reason}", file=sys.stderr)
    return row


def shares(motion: ulna.Trajectory, kept, period: float) -> Array:
    """The greatest velocity, acceleration and jerk by differences of samples, as shares of the limits, shape (3,)."""
    t = np.concatenate([np.arange(0, motion.duration, period), np.full(4, motion.duration)])
    q = motion.at(t).q
    found = []
    for limit in (kept.velocity, kept.acceleration, kept.jerk):
        q = np.diff(q, axis=0) / period
        found.append(float((np.abs(q) / limit).max()))
    return np.array(found)


def rounding(kept, period: float) -> Array:
    """How much of a share of the limits may be the rounding of the samples alone, shape (3,)."""
    limits = kept.velocity, kept.acceleration, kept.jerk
    return np.array([ROUNDING * (2 / period) ** k / np.min(limit) for k, limit in enumerate(limits, 1)])


def summary(name: str, rows: list[dict]) -> dict:
    """The medians and the worst over the motions."""
    done = [row for row in rows if "duration" in row]
    ratio = {key: np.array([row["duration"] / row[key][0] for row in done if key in row]) for key in ("TOPP2", "TOPP3")}
    third = [row["TOPP3"][1] for row in done if "TOPP3" in row]
    jerk = np.array([row["duration"] / row["unlimited_jerk"] for row in done])
    found = {
        "paths": name, "motions": f"{len(done)} of {len(rows)}",
        "plan_ms": 1e3 * float(np.median([row["plan_s"] for row in done])),
        "motion_ms": 1e3 * float(np.median([row["motion_s"] for row in done])),
        "both_ms": 1e3 * float(np.median([row["plan_s"] + row["motion_s"] for row in done])),
        "seconds": float(np.median([row["duration"] for row in done])), "stops": sum(row["stops"] for row in done),
        "times_without_jerk": float(np.median(jerk)), "worst": float(jerk.max()),
        "times_TOPP3": float(np.median(ratio["TOPP3"])) if third else np.nan,
        "worst_TOPP3": float(ratio["TOPP3"].max()) if third else np.nan,
        "times_TOPP2": float(np.median(ratio["TOPP2"])) if third else np.nan,
        "TOPP3_ms": 1e3 * float(np.median(third)) if third else np.nan, "compared": len(third),
        "beyond": sum(row["beyond"] for row in done), "touching": sum(bool(row.get("touches")) for row in done),
    }  # fmt: skip
    for period in PERIODS:
        found[f"greatest_share_{1 / period:g}_Hz"] = max(float(row[f"shares_{period:g}"].max()) for row in done)
    return found


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.motions", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="one problem of so many")
    parser.add_argument("--coal", action="store_true", help="let Coal judge the motions too")
    parser.add_argument("--acceleration", type=float, help="[rad/s^2], with --jerk; the Franka's limits unless given")
    parser.add_argument("--jerk", type=float, help="[rad/s^3]")
    options = parser.parse_args()
    given = {"acceleration": options.acceleration, "jerk": options.jerk}
    options.limits = {"limits": "franka"} if options.jerk is None else given
    return options


if __name__ == "__main__":
    warnings.simplefilter("ignore", RuntimeWarning)
    main()
