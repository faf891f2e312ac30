"""Solves VAMP's planning problems, compares with VAMP and judges the paths: ``python -m benchmarks.plans RESOURCES/panda``.

The folder is one of ``resources`` of the source distribution of ``vamp-planner``: panda, ur5 or fetch, with 700 problems each, or
baxter, with 1,800. The robot has VAMP's own spheres, and the objects are VAMP's. With ``--boxes`` it is Ulna's Panda of twelve
boxes, among exact cylinders, without the objects that start or goal touch, since those are grasped. ``vamp`` is timed if it is
installed, and named if not; ``ompl`` and ``roboplan`` too with ``--others``. RoboPlan has no capsules; its cylinders are exact.

All planners solve each problem in turn, several times, in one thread; the minimum time of each counts. Ulna's time is the
thread's for the whole call, which a busy machine affects less. VAMP's time is by its own clock, and also the thread's for the
calls of its two functions. A path is judged 64 times finer than VAMP samples its edges (32 per radian), by Ulna's overlap test
and by VAMP's checker. With ``--coal`` Coal, an independent library, judges it where it is nearest to an object.
"""

import argparse
import importlib
import json
import os
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.peer import NotForThisArm
from benchmarks.plan_judges import coal_touches, overlaps
from benchmarks.plan_tables import print_ratios, print_table
from benchmarks.vamp_problems import PlanningProblem, read_problems, spheres

FINER = 64 * 32  # samples per radian
ROUNDED = 1e-4  # [rad or m]
JUDGED = (
    "Ulna, sampled",
    "Ulna, certified",
    "VAMP",
    "OMPL",
)  # the others' paths are the same, or not intended for motion


class Solved(NamedTuple):
    """The result of one planner for a problem: names, the path or None, the minimum time [s]."""

    who: str
    problem: str
    path: NDArray | None
    seconds: float
    checks: float = np.nan


def main() -> None:
    """Solve, judge and print."""
    options = _options()
    robot = ulna.load("panda") if options.boxes else spheres(options.folder)
    vamp, why = _vamp(options.folder.name, robot.joint_names)
    print(f"{robot.name}, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors" + (f"; vamp {why}" if why else ""))
    others = _others(robot, options.folder) if options.others else {}
    rows: list[dict] = []
    for given in read_problems(options.folder, robot.joint_names)[options.first :: options.every]:
        problem = within_limits(robot, given)
        world, environment = given.world(exact=options.boxes), vamp and vamp.environment(given)
        if problem is not None and options.boxes:
            leave_out_touched(robot, world, problem)
        if problem is None or robot.in_collision([problem.start, problem.goal], world).any():
            print(f"{given.name} {given.index}: start or goal touches, or is outside the limits", file=sys.stderr)
            continue
        solutions = solve(robot, vamp, problem, world, environment, options.repeats)
        solutions += [each for who, other in others.items() for each in _of_other(who, problem, other.solve(problem, world))]
        for solved in solutions:
            row = {"who": solved.who, "set": problem.name, "index": problem.index, "us": 1e6 * solved.seconds}
            row |= {"solved": solved.path is not None, "checks": solved.checks}
            if solved.path is not None:
                row["length"] = float(np.linalg.norm(np.diff(solved.path, axis=0), axis=1).sum())
            if solved.path is not None and solved.who in JUDGED:
                row["touches"] = judged(
                    robot, None if options.boxes else vamp, world, environment, solved.path, with_coal=options.coal
                )
            rows.append(row)
    print_table(rows)
    print_ratios(rows)
    if options.out is not None:
        options.out.write_text(json.dumps(rows), encoding="utf-8")


def within_limits(robot: ulna.Robot, problem: PlanningProblem) -> PlanningProblem | None:
    """The problem with start and goal moved into the limits by their rounding; None if they are farther outside."""
    start, goal = (np.clip(q, robot.lower, robot.upper) for q in (problem.start, problem.goal))
    if max(np.abs(start - problem.start).max(), np.abs(goal - problem.goal).max()) > ROUNDED:
        return None
    return replace(problem, start=start, goal=goal)


def leave_out_touched(robot: ulna.Robot, world: ulna.World, problem: PlanningProblem) -> None:
    """Remove the objects that start or goal touch: the goals are grasps, and a box fills the fingers' gap."""
    touched = {pair.name_b for q in (problem.start, problem.goal) for pair in robot.check_collision(q, world).pairs}
    for name in touched & set(world.names):
        world.remove(name)


def solve(robot: ulna.Robot, vamp, problem: PlanningProblem, world: ulna.World, environment, repeats: int) -> list[Solved]:
    """Solve a problem by all planners in turn: Ulna in four ways, VAMP with and without simplification."""
    plan = partial(robot.plan, problem.start, problem.goal, world)
    ways = {
        f"Ulna, {how}{'' if shorten else ', not shortened'}": partial(plan, certify=certify, shorten=shorten)
        for how, certify in (("sampled", False), ("certified", True))
        for shorten in (False, True)
    }
    best: dict[str, Solved] = {}
    for _ in range(repeats):
        found = [_timed(who, problem, way) for who, way in ways.items()]
        if vamp is not None:
            theirs = vamp.solve(problem, environment)
            found += [
                Solved("VAMP, not simplified", problem.name, theirs.first, theirs.plan_s),
                Solved("VAMP", problem.name, theirs.path, theirs.whole_s),
                Solved("VAMP, as called", problem.name, theirs.path, theirs.call_s),
            ]
        for each in found:
            before = best.get(each.who)
            best[each.who] = each if before is None or each.seconds < before.seconds else before
    return list(best.values())


def _timed(who: str, problem: PlanningProblem, way) -> Solved:
    began = time.thread_time()
    plan = way()
    seconds = time.thread_time() - began
    return Solved(who, problem.name, plan.path if plan else None, seconds, plan.checks)


def judged(robot, judge, world, environment, path: NDArray, *, with_coal: bool) -> dict[str, bool]:
    """Whether the path touches anything, according to each judge."""
    says = {"overlaps": overlaps(robot, world, path, FINER)}
    if judge is not None:
        says["VAMP"] = judge.touches(path, environment, FINER)
    if with_coal:
        says["Coal"] = coal_touches(robot, world, path, FINER)
    return says


def _vamp(name: str, joints: tuple[str, ...]):
    """VAMP's planner for a robot; or None, after printing the reason."""
    try:
        from benchmarks.peers.vamp import Vamp  # noqa: PLC0415 - it may be absent

        return Vamp(name, joints), ""
    except ImportError as error:
        return None, f"absent: {error}"
    except NotForThisArm as reason:
        return None, str(reason)


def _others(robot: ulna.Robot, folder: Path) -> dict:
    """OMPL and RoboPlan, by name; prints the unavailable ones."""
    found = {}
    texts = [(folder / f"{folder.name}{ending}").read_text(encoding="utf-8") for ending in ("_spherized.urdf", ".srdf")]
    for who, module, arguments in (("OMPL", "ompl", (robot,)), ("RoboPlan", "roboplan", (robot, *texts))):
        try:
            found[who] = importlib.import_module(f"benchmarks.peers.{module}").Planner(*arguments)
        except (ImportError, NotForThisArm) as reason:
            print(f"{who}: {reason}", file=sys.stderr)
    return found


def _of_other(who: str, problem: PlanningProblem, ways: tuple) -> list[Solved]:
    """The result of OMPL or RoboPlan: the path of the search, and the shortened one."""
    return [Solved(name, problem.name, *way) for name, way in zip((f"{who}, not shortened", who), ways, strict=True)]


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plans", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="one problem of so many")
    parser.add_argument("--first", type=int, default=0, help="from which problem on")
    parser.add_argument("--repeats", type=int, default=3, help="how many times each solves each problem")
    parser.add_argument("--boxes", action="store_true", help="Ulna's Panda of twelve boxes, among exact cylinders")
    parser.add_argument("--others", action="store_true", help="OMPL, with Ulna's checker, and RoboPlan beside")
    parser.add_argument("--coal", action="store_true", help="let Coal judge the paths too")
    parser.add_argument("--out", type=Path, help="write a row for each problem and way to this .json file")
    return parser.parse_args()


if __name__ == "__main__":
    main()
