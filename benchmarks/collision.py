"""Measures collision queries next to Pinocchio with Coal, and in growing worlds of boxes: ``python -m benchmarks.collision``.

Everything runs on one processor: the peer uses one, and so does Ulna here, whose batches would otherwise use threads.
"""

import sys
from time import perf_counter

import numpy as np

import ulna
from benchmarks.bounds import count_operations, peak_ns
from benchmarks.markdown import table
from benchmarks.peer import NotForThisArm
from benchmarks.processors import one_processor
from benchmarks.ratio import ratio
from ulna.bench.arms import random_positions
from ulna.bench.timing import Workload, time_interleaved
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.engine.lanes import WIDTH
from ulna.robot import Robot

N, CALLS, LOOP = 2048, 64, 16  # configurations of a batch, of a pass of single calls, and of a pass of the peer's loop
BOXES = (1, 4, 16, 64, 100, 256, 1000, 10_000)
QUERIES = ("in_collision", "signed_distance")


def scattered(n: int, size: float, reach: float) -> ulna.World:
    """Boxes in a cube around the arm, none at its place."""
    rng, world = np.random.default_rng(n), ulna.World()
    while len(world.names) < n:
        place = rng.uniform(-reach, reach, 3)
        if np.linalg.norm(place) > 0.45:
            world.add(f"{len(world.names)}", ulna.Box(size * rng.uniform(0.3, 1, 3)), ulna.pose(place, rng.uniform(-3, 3, 3)))
    return world


def query_rows(robot: Robot) -> list[dict]:
    """One call and a batch row of each query, in three scenes: Ulna's and the peer's time.

    The peer's ``computeDistances`` computes the distances of all pairs: it has no call for the minimum.

    Raises:
        NotForThisArm: The peer is absent, or disagrees with Ulna.
    """
    try:
        from benchmarks.peers.coal import Scene, disagreement  # noqa: PLC0415 -- it may be absent
    except ImportError as error:
        raise NotForThisArm(f"absent: {error}") from None
    rows, q = [], random_positions(robot, N, 1)
    one = ulna.World()
    one.add("crate", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.5, 0, 0.21)))
    scenes = {"one box": (one, False), "100 boxes": (scattered(100, 0.06, 1.0), False), "itself": (ulna.World(), True)}
    for name, (world, itself) in scenes.items():
        peer = Scene(robot, world, itself=itself)
        if wrong := disagreement(peer, robot, world, q[:200], itself=itself):
            raise NotForThisArm(f"{name}: {wrong}")
        for query, theirs in zip(QUERIES, (peer.collides, peer.distances), strict=True):
            rows += _query_rows(robot, world, itself, q, query, theirs, {"scene": name, "pairs": peer.n_pairs})
    return rows


def _query_rows(robot: Robot, world: ulna.World, itself: bool, q, query: str, theirs, scene: dict) -> list[dict]:  # noqa: FBT001
    def ask(q):
        return getattr(robot, query)(q, world, self_collision=itself)

    calls = list(q[:CALLS])
    works = {
        "batch": Workload(ask, [q], N),
        "one": Workload(ask, calls),
        "peer": Workload(theirs, calls[:LOOP]),
    }
    timings = time_interleaved(works, passes=41)
    rows = []
    for kind, how in (("batch", f"a row of {N}"), ("one", "one call")):
        lower, median, upper = ratio(timings["peer"], timings[kind])
        rows.append({
            **scene, "query": query, "asked": how, "ulna_ns": timings[kind].median, "pin_and_coal_ns": timings["peer"].median,
            "times_ulna": median, "times_ulna_lower": lower, "times_ulna_upper": upper,
        })  # fmt: skip
    return rows


def growth_rows(robot: Robot, peak: float) -> list[dict]:
    """Queries of free configurations in worlds of 1 to 10 000 boxes: equally dense from 100 on, or ever denser.

    The bound covers placing the robot's boxes and testing the balls around each pair. A world of more than ALONE boxes is in a
    tree, which skips most pairs, and has no such bound.
    """
    rows, counts, n_bodies = [], count_operations(robot, with_boxes=True), len(robot.collision_names)
    q = random_positions(robot, 4 * N, 1)
    for density, size, reach in (("as dense", 0.05, None), ("denser", 0.008, 2.0)):
        for n in BOXES:
            world = scattered(n, size, reach or max(1.0, (n / 100) ** (1 / 3)))
            start = perf_counter()
            world.objects()
            build_ms = 1e3 * (perf_counter() - start)
            free = q[~robot.in_collision(q, world, self_collision=False)][:N]
            if not len(free):
                continue  # too crowded for the arm
            bound = (
                (counts["place_bodies"] + n * n_bodies * counts["balls_overlap"]) / WIDTH * peak if n <= MAX_UNINDEXED else None
            )
            rows.append({
                "boxes": n, "world": density, "pairs": n * n_bodies, "built_ms": build_ms, **_growth(robot, world, free),
                "bound_ns": bound,
            })  # fmt: skip
    return rows


def _growth(robot: Robot, world: ulna.World, free) -> dict[str, float]:
    batch = np.resize(free, (N, robot.n_dof))  # all free: a robot in early collision would skip the rest
    works = {
        "one_ns": Workload(lambda x: robot.in_collision(x, world, self_collision=False), list(batch[:CALLS])),
        "batch_ns": Workload(lambda q: robot.in_collision(q, world, self_collision=False), [batch], N),
        "distance_ns": Workload(lambda q: robot.signed_distance(q, world, self_collision=False), [batch[:256]], 256),
    }
    return {name: timing.median for name, timing in time_interleaved(works, passes=15).items()}


def edge_rows(robot: Robot) -> list[dict]:
    """Certified edges of about a third of a radian per joint among ten boxes, in a batch."""
    world, rng = scattered(10, 0.1, 0.9), np.random.default_rng(2)
    q = random_positions(robot, 4 * N, 1)
    a = q[~robot.in_collision(q, world)][:500]
    b = np.clip(a + 0.3 * rng.normal(size=a.shape), robot.lower, robot.upper)
    found = robot.edge_in_collision(a, b, world)
    work = Workload(lambda q: robot.edge_in_collision(q, b, world), [a], len(a))
    median = time_interleaved({"edges": work}, passes=15)["edges"].median
    return [{"edges": len(a), "in_collision": int(np.count_nonzero(found.in_collision)), "edge_ns": median}]


def moving_rows(robot: Robot) -> list[dict]:
    """A box moves, and one configuration is checked: among boxes, with a cloud, and for an arm of hulls."""
    rng, rows, arms = np.random.default_rng(3), [], {"panda": robot}
    try:
        arms["ur5, hulls"] = ulna.load("ur5").with_convex_hulls()
    except ulna.UlnaError as error:
        rows.append({"arm": f"ur5, hulls: {error}", "boxes": 0, "points": 0, "moved_ns": np.nan, "asked_ns": np.nan})
    poses = ulna.pose(rng.uniform((1.5, -0.5, 0), (2, 0.5, 0.5), (CALLS, 3)))
    for arm, one in arms.items():
        for n, points in ((20, 0), (1000, 0), (20, 10_000), (20, 100_000)):
            world = scattered(n, 0.05, max(1.0, (n / 100) ** (1 / 3)))
            if points:
                way = rng.normal(size=(points, 3))
                world.add("cloud", ulna.PointCloud(way / np.linalg.norm(way, axis=1)[:, None], 0.003), ulna.pose((2.5, 0, 0)))
            works = {
                "moved": Workload(lambda T, one=one, world=world: (world.move("3", T), one.in_collision(one.home, world)), poses),
                "asked": Workload(lambda q, one=one, world=world: one.in_collision(q, world), [one.home] * CALLS),
            }
            times = {f"{name}_ns": timing.median for name, timing in time_interleaved(works, passes=15).items()}
            rows.append({"arm": arm, "boxes": n, "points": points, **times})
    return rows


def collision_data(robot: Robot, peak: float) -> tuple[dict[str, list[dict]], str]:
    """All tables, and the reason for the peer's absence, or ""."""
    with one_processor():
        data = {"scaling_with_pairs": growth_rows(robot, peak), "edges": edge_rows(robot), "moving": moving_rows(robot)}
        try:
            return {"collision": query_rows(robot), **data}, ""
        except NotForThisArm as reason:
            return {"collision": [], **data}, str(reason)


if __name__ == "__main__":
    tables, why = collision_data(ulna.load("panda"), peak_ns())
    sys.stdout.write("\n\n".join(table(rows) for rows in tables.values() if rows) + f"\n{why and 'pin and coal: ' + why}\n")
