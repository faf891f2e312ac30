"""Plans VAMP's problems in point clouds, and compares with VAMP: ``python -m benchmarks.plan_clouds RESOURCES/panda``.

The protocol is that of VAMP's ``scripts/evaluate_mbm.py --pointcloud``: 10,000 points on the surface of each object, balls of 2.5
mm. VAMP filters them (2 cm, and unreachable points), builds its tree and plans; its time is the sum, by its own clock. Ulna omits
unreachable points, indexes all others and plans with certified edges; its time is the thread's own, for everything. A problem
whose start or goal touches a ball is omitted, and counted.

Paths are judged 64 times finer than VAMP samples its edges, by Ulna's overlap test with the planner's balls. With ``--tree``
SciPy's k-d tree judges too: the robot consists of spheres, so contact depends on the distance of center and point.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

import ulna
from benchmarks.markdown import table
from benchmarks.plan_judges import overlaps, samples_of
from benchmarks.plans import FINER, within_limits
from benchmarks.processors import one_processor
from benchmarks.vamp_problems import PlanningProblem, read_problems, spheres

Array = NDArray[np.float64]
POINTS, RADIUS = 10_000, 0.0025  # of each object; [m], of a ball
REACH = 1.19  # [m], of the Panda: VAMP's


def main() -> None:
    """Plan, judge and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plan_clouds", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="one problem of so many")
    parser.add_argument("--tree", action="store_true", help="judge by SciPy's k-d tree too, which takes some seconds a path")
    options = parser.parse_args()
    try:
        from benchmarks.peers.vamp import Vamp  # noqa: PLC0415 -- it may be absent
    except ImportError as error:
        Vamp = None
        print(f"vamp: {error}", file=sys.stderr)
    robot = spheres(options.folder)
    peer = Vamp(options.folder.name, robot.joint_names) if Vamp else None
    rows: dict[str, list[dict]] = {"Ulna, certified": [], "VAMP": []}
    left_out = 0
    with one_processor():
        for k, given in enumerate(read_problems(options.folder, robot.joint_names)[:: options.every]):
            problem = within_limits(robot, given)
            points = None if problem is None else surface(problem, np.random.default_rng(k))
            ours = None if problem is None else of_ulna(robot, problem, points, by_tree=options.tree)
            if ours is None:
                left_out += 1
                continue
            rows["Ulna, certified"].append(ours)
            if peer:
                rows["VAMP"].append(of_vamp(robot, peer, problem, points, by_tree=options.tree))
    print(f"load {os.getloadavg()[0]:.1f}; {left_out} problems left out, start or goal touches a ball or is beyond the limits")
    print(table([summary(name, found) for name, found in rows.items() if found]))
    if peer:
        ratio = [a["all_ms"] / b["all_ms"] for a, b in zip(*rows.values(), strict=True) if a["solved"] and b["solved"]]
        print(f"Ulna's time over VAMP's, problem by problem: median {np.median(ratio):.2f}, 95 %: {np.percentile(ratio, 95):.2f}")


def surface(problem: PlanningProblem, rng: np.random.Generator) -> Array:
    """Points spread evenly over the surface of each object, boxes and cylinders, shape (n, 3)."""
    clouds = []
    for _, kind, sizes, T in problem.objects:
        if kind == "box":
            half = np.array(sizes) / 2
            local = rng.uniform(-1, 1, (POINTS, 3)) * half
            areas = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
            axis = rng.choice(3, POINTS, p=areas / areas.sum())
            local[np.arange(POINTS), axis] = rng.choice((-1, 1), POINTS) * half[axis]
        elif kind == "sphere":
            local = rng.normal(size=(POINTS, 3))
            local *= sizes[0] / np.linalg.norm(local, axis=1)[:, None]
        else:
            length, radius = sizes
            side = rng.random(POINTS) < length / (length + radius)
            angle = rng.uniform(0, 2 * np.pi, POINTS)
            r = np.where(side, radius, radius * np.sqrt(rng.random(POINTS)))
            z = np.where(side, rng.uniform(-0.5, 0.5, POINTS), rng.choice((-0.5, 0.5), POINTS)) * length
            local = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
        clouds.append(local @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(clouds)


def of_ulna(robot: ulna.Robot, problem: PlanningProblem, points: Array, *, by_tree: bool) -> dict | None:
    """A row; None if start or goal touches."""
    began = time.thread_time()
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(points, RADIUS).cropped(ulna.Box((2 * REACH,) * 3)))
    world.objects()
    built = time.thread_time()
    plan = robot.plan(problem.start, problem.goal, world)
    done = time.thread_time()
    if not plan and robot.in_collision([problem.start, problem.goal], world).any():
        return None
    touches = judged(robot, world, points, plan.path if plan else None, by_tree=by_tree)
    return _row(bool(plan), len(points), built - began, done - built, touches)


def of_vamp(robot: ulna.Robot, peer, problem: PlanningProblem, points: Array, *, by_tree: bool) -> dict:
    """A row, by VAMP's own clock."""
    environment, kept, seconds = peer.cloud(points)
    found = peer.solve(problem, environment)
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(kept, RADIUS))
    touches = judged(robot, world, kept, found.path, by_tree=by_tree)
    return _row(found.path is not None, len(kept), seconds, found.whole_s, touches)


def judged(robot: ulna.Robot, world: ulna.World, points: Array, path: Array | None, *, by_tree: bool) -> dict[str, bool]:
    """Whether a path touches a ball, or the robot itself; with ``by_tree`` also by the k-d tree."""
    if path is None:
        return {}
    found = {"touches": overlaps(robot, world, path, FINER)}
    if by_tree:
        shapes = [one.shape for link in robot.description.links for one in link.collisions]
        reach = np.array([shape.radius for shape in shapes]) + RADIUS
        centers = robot.collision_poses(samples_of(path, FINER))[..., :3, 3]
        distances, _ = KDTree(points).query(centers, distance_upper_bound=reach.max() + RADIUS)
        found["touches_by_tree"] = bool((distances < reach).any())
    return found


def _row(solved: bool, points: int, built: float, planned: float, touches: dict[str, bool]) -> dict:  # noqa: FBT001
    return {
        "solved": solved, "points": points, "built_ms": 1e3 * built, "plan_ms": 1e3 * planned,
        "all_ms": 1e3 * (built + planned), **touches,
    }  # fmt: skip


def summary(name: str, rows: list[dict]) -> dict:
    """The counts and the medians."""
    done = [row for row in rows if row["solved"]]
    medians = {key: float(np.median([row[key] for row in done])) for key in ("points", "built_ms", "plan_ms", "all_ms")}
    return {
        "planner": name, "problems": len(rows), "solved": len(done), **medians,
        "all_95_ms": float(np.percentile([row["all_ms"] for row in done], 95)),
        **{key: sum(row[key] for row in done) for key in done[0] if key.startswith("touches")},
    }  # fmt: skip


if __name__ == "__main__":
    main()
