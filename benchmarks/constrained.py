"""Plans constrained motions, judges them, and compares OMPL: ``python -m benchmarks.constrained RESOURCES/panda``.

The folder is one of ``resources`` of the source distribution of ``vamp-planner``: panda or ur5, in VAMP's spheres and scenes; or
baxter, of its repository, which carries a tray with both hands. The problems are drawn by a published seed
(``constrained_problems``): five kinds of constraint, 100 of each, or 100 trays. Ulna's time is the thread's for the whole call,
the minimum of several. "stops" and "s" describe the motion along the path, which takes s seconds with 4 rad/s^2. With ``--ompl``
OMPL's three constrained spaces solve the problems too, once each.

A path is judged at 64 times 32 samples per radian: the constraint by Pinocchio, contacts by the overlap test, and with ``--coal``
by Coal where the path is nearest to an object. "of any" is the share of those problems that any planner here solved. Ulna's
checks are edges, OMPL's are configurations. "functions" counts OMPL's evaluations of the constraint or its Jacobian. Its limit is
one of wall time.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.constrained_problems import HANDS, KINDS, TRAY, ConstrainedProblem, excess, kinds_of, make_problem
from benchmarks.markdown import table
from benchmarks.plan_judges import coal_touches, overlaps
from benchmarks.vamp_problems import read_problems, spheres

FINER = 64 * 32  # samples per radian
ACCELERATION = 4.0  # [rad/s^2], of the motions
ULNA = "Ulna"


def main() -> None:
    """Solve, judge and print."""
    options = _options()
    robot, link = spheres(options.folder), HANDS[options.folder.name]
    scenes, rows = read_problems(options.folder, robot.joint_names), []
    print(f"{robot.name}, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors, {options.problems} problems a kind")
    _warm(options.folder.name, robot, link, scenes)
    for kind in options.kinds or kinds_of(options.folder.name):
        for index in range(options.problems) if options.only is None else options.only:
            problem = make_problem(robot, link, scenes, kind, index)
            world = problem.scene.world()
            found = [_ulna(robot, problem, world, options)]
            if options.ompl:
                found += _ompl(robot, problem, world, options.limit)
            for row, path in found:
                row |= {"kind": kind, "index": index, "solved": path is not None}
                if path is not None and (row["who"] == ULNA or options.judge_all) and index % options.judge_every == 0:
                    row |= {"used": excess(problem, robot, path, FINER), "touches": _touches(robot, world, path, options)}
                rows.append(row)
        print(f"{kind} done", file=sys.stderr)
    print(table(summary(rows)))
    if options.out is not None:
        options.out.write_text(json.dumps(rows), encoding="utf-8")


def summary(rows: list[dict]) -> list[dict]:
    """A row for each kind and planner."""
    result = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        of_kind = [row for row in rows if row["kind"] == kind]
        solvable = {row["index"] for row in of_kind if row["solved"]}
        for who in dict.fromkeys(row["who"] for row in of_kind):
            own = [row for row in of_kind if row["who"] == who]
            solved = [row for row in own if row["solved"]]
            judged, ms = [row for row in solved if "used" in row], [1e3 * row["seconds"] for row in solved] or [np.nan]
            result.append({
                "constraint": kind, "who": who, "problems": len(own), "solved": len(solved),
                "of_any": f"{100 * len(solved) / max(1, len(solvable)):.1f} %", "median_ms": float(np.median(ms)),
                "95_%_ms": float(np.quantile(ms, 0.95)), "checks": float(np.median([row["checks"] for row in own])),
                "functions": float(np.median([row.get("functions", 0) for row in own])),
                "points": _median_of(solved, "points"), "stops": _median_of(solved, "stops"), "s": _median_of(solved, "duration"),
                "beyond": f"{sum(row['used'] > 1.0 for row in judged)} of {len(judged)}",
                "touching": sum(row["touches"] for row in judged),
                "most_used": max([row["used"] for row in judged], default=np.nan),
            })  # fmt: skip
    return result


def _median_of(rows: list[dict], name: str) -> float:
    return float(np.median([row[name] for row in rows if name in row] or [np.nan]))


def _ulna(
    robot: ulna.Robot, problem: ConstrainedProblem, world: ulna.World, options: argparse.Namespace
) -> tuple[dict, NDArray | None]:
    seconds, plan = np.inf, None
    goal = {"goal": problem.goal, "link": problem.goal_link}
    for _ in range(options.repeats):
        began = time.thread_time()
        plan = robot.plan(problem.start, world=world, keep=problem.keep, max_checks=options.max_checks, **goal)
        seconds = min(seconds, time.thread_time() - began)
        if not plan:
            break  # its time is no figure, and long
    assert plan is not None  # noqa: S101 - there is at least one repeat
    row = {"who": ULNA, "seconds": seconds, "checks": plan.checks, "status": plan.status.value}
    if plan:
        motion = plan.trajectory(acceleration=ACCELERATION)
        row |= {"length": plan.length, "points": len(plan.path), "certified": plan.worst_violation}
        row |= {"stops": motion.stops, "duration": motion.duration}
    return row, plan.path if plan else None


def _ompl(robot: ulna.Robot, problem: ConstrainedProblem, world: ulna.World, limit: float) -> list[tuple[dict, NDArray | None]]:
    from benchmarks.peers import ompl_constrained  # noqa: PLC0415 - it may be absent

    found = []
    for name in ompl_constrained.SPACES:
        path, seconds, checks, functions = ompl_constrained.solve(name, robot, problem, world, limit)
        found.append(({"who": name, "seconds": seconds, "checks": checks, "functions": functions}, path))
    return found


def _touches(robot: ulna.Robot, world: ulna.World, path: NDArray, options: argparse.Namespace) -> bool:
    return overlaps(robot, world, path, FINER) or (options.coal and coal_touches(robot, world, path, FINER))


def _warm(robot_name: str, robot: ulna.Robot, link: str, scenes: list) -> None:
    """Compile the entries."""
    for kind in kinds_of(robot_name):
        problem = make_problem(robot, link, scenes, kind, 10**6)
        goal = {"goal": problem.goal, "link": problem.goal_link}
        plan = robot.plan(problem.start, world=problem.scene.world(), keep=problem.keep, max_checks=2000, **goal)
        if plan:
            plan.trajectory(acceleration=ACCELERATION)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.constrained", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--problems", type=int, default=100, help="of each kind")
    parser.add_argument("--kinds", nargs="+", choices=(*KINDS, TRAY), help="all of the robot's unless given")
    parser.add_argument("--repeats", type=int, default=3, help="how many times Ulna solves each")
    parser.add_argument("--max-checks", type=int, default=100_000, help="edges that Ulna checks of each at most, or 10 s")
    parser.add_argument("--ompl", action="store_true", help="OMPL's three constrained spaces beside, with Ulna's checker")
    parser.add_argument("--limit", type=float, default=60.0, help="of OMPL for one problem [s]")
    parser.add_argument("--coal", action="store_true", help="let Coal judge the paths too")
    parser.add_argument("--only", type=int, nargs="+", help="the numbers of the problems, instead of all")
    parser.add_argument("--judge-every", type=int, default=1, help="let the judges look at every so manyth problem")
    parser.add_argument("--judge-all", action="store_true", help="judge the paths of OMPL too")
    parser.add_argument("--brief", action="store_true", help="eight problems of each kind, once, and 5 s for OMPL")
    parser.add_argument("--out", type=Path, help="write a row for each problem and planner to this .json file")
    options = parser.parse_args()
    if options.brief:
        options.problems, options.repeats, options.limit = 8, 1, min(5.0, options.limit)
    return options


if __name__ == "__main__":
    main()
