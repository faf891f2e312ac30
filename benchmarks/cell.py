"""Measures a realistic cell: a depth camera, arms with meshes, moving objects. ``python -m benchmarks.cell --largest 1000000``.

It measures Ulna alone, on one processor, in the thread's own time, which a busy machine affects less; each time is a median. The
camera looks at a bin on a table (``depth_camera``). Verdicts and distances are compared with a k-d tree of SciPy. Unavailable
arms are listed.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

import ulna
from benchmarks.collision import moving_rows, scattered
from benchmarks.depth_camera import Camera, bin_on_a_table
from benchmarks.markdown import table
from benchmarks.peer import NotForThisArm
from benchmarks.processors import one_processor
from ulna.bench.arms import load_arm
from ulna.description.meshes.mesh_files import with_mesh_paths
from ulna.description.urdf_writer import write_urdf

Array = NDArray[np.float64]
RADIUS = 0.005  # [m], of the balls around the points
CONFIGURATIONS, EDGES, PLANS = 1000, 30, 30
SEARCHED = 30_000  # maximum number of points in the search for an edge
SAMPLES = 32  # along an edge whose clearance is searched
ARMS = ("ur5", "jaco2", "xarm7", "iiwa14", "talos_left_arm")
GRASP = ulna.pose((0.55, 0.0, 0.2), (np.pi, 0, 0))  # into the bin, from above


def main() -> None:
    """Print each table as soon as it is measured."""
    options = _options()
    panda = ulna.load("panda")
    tables: dict[str, Callable[[], list[dict]]] = {
        "clouds": lambda: cloud_rows(panda, [10**k for k in range(2, 8) if 10**k <= options.largest]),
        "moving": lambda: moving_rows(panda),
        "calls": lambda: call_rows(panda),
        "camera": lambda: camera_rows(panda, options.images),
        "arms": lambda: arm_rows(options.arm or ARMS),
        "judge": lambda: judge_rows(options.balls),
    }
    with one_processor():
        for name in options.only or tables:
            sys.stdout.write(f"## {name}\n\n{table(tables[name]())}\n\n")
            sys.stdout.flush()


def seconds(function: Callable, inputs: Iterable) -> Array:
    """The thread's time of ``function(one)`` for each input [s]."""
    times = []
    for one in inputs:
        began = time.thread_time()
        function(one)
        times.append(time.thread_time() - began)
    return np.array(times)


def seen(n: int, radius: float = RADIUS) -> ulna.PointCloud:
    """About n points of the bin on the table."""
    camera = Camera.of_pixels(round(1.9 * n))  # the other pixels see nothing
    return camera.cloud(camera.image(bin_on_a_table(0), np.random.default_rng(n)), radius)


def cloud_rows(robot: ulna.Robot, sizes: Sequence[int]) -> list[dict]:
    """An update, a row of a batch, edges by their clearance and certified plans, with 10^2 to 10^7 points."""
    rows = []
    for n in sizes:
        cloud, world = seen(n), ulna.World()
        world.add("cloud", cloud)
        q = free(robot, world, CONFIGURATIONS, 1)
        robot.edge_in_collision(q[0], q[1], world)
        robot.plan(q[0], q[1], world)
        points = cloud.points

        def update(_, points=points, world=world):
            world.update("cloud", ulna.PointCloud(points, RADIUS))
            world.objects()

        row = {"points": len(points), "update_ms": 1e3 * float(np.median(seconds(update, range(7))))}
        batch = seconds(lambda q, world=world: robot.in_collision(q, world), [q] * 7)
        row["in_collision_us"] = 1e6 * float(np.median(batch)) / len(q)
        for clearance, edges in edges_at(robot, world, points, (0.05, 0.005)).items():
            call = seconds(lambda edge, world=world: robot.edge_in_collision(*edge, world), edges + edges)[len(edges) :]
            row[f"edge_{1e3 * clearance:g}_mm_us"] = 1e6 * float(np.median(call)) if len(call) else np.nan
        rows.append(row | planned(robot, world, zip(q[:PLANS], q[PLANS : 2 * PLANS], strict=True)))
    return rows


def free(robot: ulna.Robot, world: ulna.World, n: int, seed: int) -> Array:
    """Random collision-free configurations, shape (n, n_dof)."""
    q = robot.random(20 * n, seed=seed)
    return q[~robot.in_collision(q, world)][:n]


def edges_at(
    robot: ulna.Robot, world: ulna.World, points: Array, clearances: Sequence[float]
) -> dict[float, list[tuple[Array, Array]]]:
    """Free edges of about half a radian with these minimum distances to the world, to a fifth [m].

    The search uses fewer points: the distance of an arm among millions of points takes milliseconds.
    """
    found: dict[float, list] = {clearance: [] for clearance in clearances}
    few = ulna.World()
    few.add("cloud", ulna.PointCloud(points[:: -(-len(points) // SEARCHED)], RADIUS))
    rng, shares = np.random.default_rng(0), np.linspace(0, 1, SAMPLES)[:, None]
    for seed in range(10):
        a = free(robot, few, CONFIGURATIONS, seed)
        b = np.clip(a + 0.2 * rng.normal(size=a.shape), robot.lower, robot.upper)
        clear = ~robot.edge_in_collision(a, b, world).in_collision
        a, b = a[clear], b[clear]
        along = a[:, None] + shares * (b - a)[:, None]
        about = robot.signed_distance(along, few, self_collision=False).min(axis=1)
        for clearance, edges in found.items():
            for k in np.flatnonzero(np.abs(about - clearance) < clearance / 5 + RADIUS):
                if len(edges) == EDGES:
                    break
                least = robot.signed_distance(along[k], world, self_collision=False).min()
                if abs(least - clearance) < clearance / 5:
                    edges.append((a[k], b[k]))
        if all(len(edges) == EDGES for edges in found.values()):
            break
    return found


def planned(robot: ulna.Robot, world: ulna.World, problems: Iterable[tuple[Array, Array]]) -> dict[str, float]:
    """Certified plans to a q or a pose: the number of successes, the median time and its 95th percentile."""
    plans: list[ulna.Plan] = []
    times = 1e3 * seconds(lambda problem: plans.append(robot.plan(*problem, world, max_checks=10_000)), problems)
    return {
        "plans": len(plans),
        "solved": sum(map(bool, plans)),
        "plan_ms": float(np.median(times)),
        "plan_95_ms": float(np.percentile(times, 95)),
    }


def call_rows(robot: ulna.Robot) -> list[dict]:
    """One call of each query with ten boxes, with 10^4 points of a cloud, and with both."""
    rows, worlds = [], {"ten boxes": scattered(10, 0.1, 0.9), "a cloud": ulna.World(), "both": scattered(10, 0.1, 0.9)}
    for name in ("a cloud", "both"):
        worlds[name].add("cloud", seen(10_000))
    for name, world in worlds.items():
        q = free(robot, world, EDGES, 2)
        calls = {
            "in_collision": lambda q, world=world: robot.in_collision(q, world),
            "edge_in_collision": lambda q, world=world: robot.edge_in_collision(q, q + 0.02, world),
            "signed_distance": lambda q, world=world: robot.signed_distance(q, world),
            "distance_gradient": lambda q, world=world: robot.distance_gradient(q, world),
            "distances": lambda q, world=world: robot.distances(q, world, within=0.1),
            "check_collision": lambda q, world=world: robot.check_collision(q, world, max_distance=0.1),
        }
        row: dict = {"world": name}
        for query, call in calls.items():
            call(q[0])
            row[f"{query}_us"] = 1e6 * float(np.median(seconds(lambda q, call=call: [call(q) for _ in range(20)], q))) / 20
        rows.append(row)
    return rows


def camera_rows(robot: ulna.Robot, images: int) -> list[dict]:
    """The time from a depth image of 640 x 480 to a certified plan into a changing bin."""
    camera, world = Camera.of_pixels(640 * 480), ulna.World()
    world.add("cloud", ulna.PointCloud(np.empty((0, 3)), 0.002))

    def update(cloud: ulna.PointCloud) -> None:
        world.update("cloud", cloud)
        world.objects()

    steps: dict[str, Callable] = {
        "from_depth": lambda image: camera.cloud(image, 0.002),
        "cropped": lambda cloud: cloud.cropped(ulna.Box((2, 2, 2))),
        "without": lambda cloud: cloud.without(robot, robot.home, padding=0.01),
        "thinned": lambda cloud: cloud.thinned(0.01),
        "update": update,
        "plan": lambda _: robot.plan(robot.home, GRASP, world),
    }
    parts: dict[str, list[float]] = {name: [] for name in (*steps, "all")}
    solved = 0
    for k in range(1 + images):  # the first one compiles
        value = camera.image(bin_on_a_table(k), np.random.default_rng(k))
        clock = [time.thread_time()]
        for step in steps.values():
            value = step(value)
            clock.append(time.thread_time())
        if k:
            solved += bool(value)
            for times, took in zip(parts.values(), [*np.diff(clock), clock[-1] - clock[0]], strict=True):
                times.append(took)
    medians = {f"{name}_ms": 1e3 * float(np.median(times)) for name, times in parts.items()}
    return [{"images": images, "solved": solved, **medians}]


SHAPED = {
    "hulls": ulna.Robot.with_convex_hulls,
    "pieces": ulna.Robot.with_convex_pieces,
    "balls, 20 mm": partial(ulna.Robot.with_spheres, within=0.02),
    "balls, 10 mm": partial(ulna.Robot.with_spheres, within=0.01),
}


def arm_rows(names: Iterable[str]) -> list[dict]:
    """Arms with meshes, by cached hulls, pieces and balls, with the bin's cloud and a crate: row, edge, plan.

    RoboPlan uses the meshes' triangles, and the same number of plans, between the ends of the hulls' plans that are free there.
    """
    rows, world = [], ulna.World()
    world.add("cloud", seen(10_000))
    world.add("crate", ulna.Box((0.2, 0.2, 0.2)), ulna.pose((0.1, 0.7, 0.3)))
    for name in names:
        for kind, shaped in SHAPED.items():
            row: dict = {"arm": name, "shapes": kind}
            try:
                arm = load_arm(name)
                robot = shaped(arm)
            except ulna.UlnaError as error:
                sys.stderr.write(f"{name}, {kind}: {error}\n")
                continue
            q = free(robot, world, CONFIGURATIONS, 3)
            if len(q) < 2 * PLANS:
                sys.stderr.write(f"{name}, {kind}: of {20 * CONFIGURATIONS} configurations {len(q)} are free\n")
                continue
            robot.plan(q[0], q[1], world)
            batch = np.median(seconds(lambda q, world=world, robot=robot: robot.in_collision(q, world), [q] * 7))
            row |= {"bodies": len(robot.collision_names), "in_collision_us": 1e6 * float(batch) / len(q)}
            edges = [(a, np.clip(a + 0.1, robot.lower, robot.upper)) for a in q[:200]]
            edges = [edge for edge in edges if not robot.edge_in_collision(*edge, world)]
            row["edge_us"] = 1e6 * float(np.median(seconds(lambda e, w=world, r=robot: r.edge_in_collision(*e, w), edges)))
            row |= planned(robot, world, zip(q[:PLANS], q[PLANS : 2 * PLANS], strict=True))
            with suppress(ulna.InputError):  # a hand of several fingers has several tips, and no single pose
                to_poses = planned(robot, world, zip(q[:PLANS], robot.forward_kinematics(q[PLANS : 2 * PLANS]), strict=True))
                row |= {f"{key}_to_a_pose": to_poses[key] for key in ("solved", "plan_ms", "plan_95_ms")}
            rows.append(row)
            if kind == "hulls":
                rows += by_roboplan(name, arm, robot, world, q)
    return rows


def by_roboplan(name: str, arm: ulna.Robot, hulls: ulna.Robot, world: ulna.World, q: Array) -> list[dict]:
    """RoboPlan's row with the triangles of an arm; none, with the reason, if it is unavailable."""
    parts = arm.description
    try:
        from benchmarks.peers.roboplan import Planner  # noqa: PLC0415 -- it may be absent

        urdf = with_mesh_paths("file", write_urdf(parts), parts.folder, parts.package_dirs)
        peer = Planner(arm, urdf, may_touch=[(pair.link_a, pair.link_b) for pair in hulls.allowed_collisions])
    except (ImportError, NotForThisArm, ValueError) as reason:
        sys.stderr.write(f"{name}, RoboPlan: {reason}\n")
        return []
    peer.lay_out(world)
    batch = np.median([seconds(peer.touches, q).sum() for _ in range(3)])
    ends = [pair for pair in zip(q[:PLANS], q[PLANS : 2 * PLANS], strict=True) if not any(map(peer.touches, pair))]
    found = [peer.search(*pair)[1] for pair in ends]
    times = 1e3 * np.array([took for path, took in found if path is not None] or [np.nan])
    median, slow = np.percentile(times, (50, 95)).tolist()
    row = {"arm": name, "shapes": "meshes, RoboPlan", "in_collision_us": 1e6 * float(batch) / len(q), "plans": len(ends)}
    return [row | {"solved": sum(path is not None for path, _ in found), "plan_ms": median, "plan_95_ms": slow}]


def judge_rows(balls: int) -> list[dict]:
    """Distances and contacts of random balls of every radius with a cloud, compared with SciPy's k-d tree."""
    cloud, world, rng = seen(100_000), ulna.World(), np.random.default_rng(6)
    world.add("cloud", cloud)
    tree, rows = KDTree(cloud.points), []
    for radius in (1e-6, 1e-3, 1e-2, 0.1, 1.0):
        robot = sliding_ball(radius)
        q = rng.uniform((-1, -1.5, -1), (2, 1.5, 1.5), (max(1, balls // 5), 3))
        expected = tree.query(q)[0] - radius - RADIUS
        found = robot.signed_distance(q, world)
        touches = robot.in_collision(q, world)
        rows.append({
            "ball_m": radius, "balls": len(q), "touching": int(np.sum(touches)),
            "verdicts_differ": int(np.sum(touches != (expected <= 0))),
            "distances_differ_m": float(np.abs(found - expected).max()),
        })  # fmt: skip
    return rows


def sliding_ball(radius: float) -> ulna.Robot:
    """A ball whose joint positions are its center [m]."""
    text, parent = '<robot name="ball"><link name="base"/>', "base"
    for axis, xyz in zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True):
        shape = f'<collision><geometry><sphere radius="{radius!r}"/></geometry></collision>' if axis == "z" else ""
        text += f'<link name="{axis}">{shape}</link><joint name="j{axis}" type="prismatic"><parent link="{parent}"/>'
        text += f'<child link="{axis}"/><axis xyz="{xyz}"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        parent = axis
    return ulna.load(text + "</robot>")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cell", description=__doc__)
    names = ("clouds", "moving", "calls", "camera", "arms", "judge")
    parser.add_argument("--only", action="append", choices=names, help="a table; repeatable; all of them unless given")
    parser.add_argument("--largest", type=int, default=1_000_000, help="points of the largest cloud")
    parser.add_argument("--images", type=int, default=30)
    parser.add_argument("--arm", action="append", help=f"repeatable; {', '.join(ARMS)} unless given")
    parser.add_argument("--balls", type=int, default=1_000_000)
    return parser.parse_args()


if __name__ == "__main__":
    main()
