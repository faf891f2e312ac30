"""``python -m benchmarks.decomposition``: how often robots touch themselves, by hulls, convex pieces, and meshes.

For each robot, configurations are drawn uniformly within its limits (one turn where there are none). Of each, it is asked whether
the robot touches itself, over the same pairs of links: those that Ulna checks on the robot of pieces. Coal has the meshes as
triangles, read with Assimp, and the robot's other shapes as they are; a pair of Coal's is a collision where triangles intersect.

The times of ``in_collision`` are medians of one call with one configuration, and per row of a batch of 2048.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
import pinocchio as pin

import ulna
from ulna.collision.allowed import AllowedCollisions, as_link_pairs
from ulna.description.meshes import kept_pieces
from ulna.description.shapes import Mesh
from ulna.robot import Robot

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from pinocchio_peer import Peer

ROBOTS = ("ur5", "ur10", "kinova", "xarm7", "so101")
SEED = 2026


def main() -> None:
    """Print a table, and the same as JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.decomposition")
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--n", type=int, default=2000, help="configurations of each robot")
    parser.add_argument("--anew", action="store_true", help="decompose again what is kept on disk")
    options = parser.parse_args()
    if options.anew:
        kept_pieces.read = lambda *_: None
    rows = []
    for name in options.robots:  # a robot takes minutes, once
        rows.append(measured(name, options.n))
        print(json.dumps(rows[-1]), flush=True)
    keys = list(rows[0])
    print(f"| {' | '.join(keys)} |\n|{'---|' * len(keys)}")
    for row in rows:
        print(f"| {' | '.join(f'{value:.3g}' if isinstance(value, float) else str(value) for value in row.values())} |")
    print(json.dumps(rows))


def measured(name: str, n: int) -> dict[str, float | int | str]:
    """One robot's row."""
    robot = ulna.load(name, srdf=False)
    start = time.perf_counter()
    pieces = robot.with_convex_pieces()
    seconds = time.perf_counter() - start
    hulls = robot.with_convex_hulls()
    pairs = link_pairs(pieces)
    q = configurations(robot, n)
    of_meshes = touching_by_coal(robot, pairs, q)
    of_pieces = pieces.in_collision(q)
    of_hulls = with_pairs(hulls, pairs).in_collision(q)
    bodies = [body for link in pieces.description.links for body in link.collisions]
    meshes = sum(isinstance(body.shape, Mesh) for link in robot.description.links for body in link.collisions)
    return {
        "robot": name,
        "meshes": meshes,
        "pieces": sum(body.excess is not None for body in bodies),
        "decomposed in s": seconds,
        "excess mm": 1000 * max(body.excess or 0.0 for body in bodies),
        "link pairs": len(pairs),
        "meshes touch %": 100 * float(of_meshes.mean()),
        "pieces touch %": 100 * float(of_pieces.mean()),
        "hulls touch %": 100 * float(of_hulls.mean()),
        "pieces free, meshes touch": int((of_meshes & ~of_pieces).sum()),
        "hulls us": 1e6 * call_time(hulls, q),
        "pieces us": 1e6 * call_time(pieces, q),
        "hulls us a row": 1e6 * row_time(hulls, q),
        "pieces us a row": 1e6 * row_time(pieces, q),
    }


def link_pairs(robot: Robot) -> set[frozenset[str]]:
    """The pairs of links that are checked against each other."""
    links = robot._checker.bodies.links  # noqa: SLF001
    return {frozenset((links[i], links[j])) for i, j in robot._checker.pairs}  # noqa: SLF001


def with_pairs(robot: Robot, pairs: set[frozenset[str]]) -> Robot:
    """The robot that checks these pairs of links, and no others."""
    names = robot.link_names
    allowed = [(a, b) for i, a in enumerate(names) for b in names[:i] if frozenset((a, b)) not in pairs]
    return robot.with_allowed_collisions(AllowedCollisions(as_link_pairs(allowed)))


def configurations(robot: Robot, n: int) -> np.ndarray:
    """Uniform within the limits, shape (n, n_dof)."""
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(SEED).uniform(lower, upper, (n, robot.n_dof))


def touching_by_coal(robot: Robot, pairs: set[frozenset[str]], q: np.ndarray) -> np.ndarray:
    """Whether meshes, as triangles, intersect at each q; shape (n,)."""
    text = robot.to_urdf(mesh_paths="file")
    model = pin.buildModelFromXML(text, mimic=True)
    geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    objects = geometry.geometryObjects
    links = [model.frames[one.parentFrame].name for one in objects]
    for i in range(len(objects)):
        for j in range(i):
            if frozenset((links[i], links[j])) in pairs:
                geometry.addCollisionPair(pin.CollisionPair(j, i))
    peer, data = Peer(robot, model), geometry.createData()
    for request in data.collisionRequests:
        request.security_margin = 0.0
    return np.array(
        [pin.computeCollisions(model, peer.data, geometry, data, peer.configuration(one), True) for one in q]  # noqa: FBT003
    )


def call_time(robot: Robot, q: np.ndarray) -> float:
    """The median time of one ``in_collision`` of one configuration [s]."""
    times = []
    for one in (*q[:20], *q[:300]):
        start = time.perf_counter()
        robot.in_collision(one)
        times.append(time.perf_counter() - start)
    return float(np.median(times[20:]))


def row_time(robot: Robot, q: np.ndarray) -> float:
    """The median time of a row of a batch [s]."""
    q = np.resize(q, (2048, q.shape[1]))
    times = []
    for _ in range(6):
        start = time.perf_counter()
        robot.in_collision(q, threads=1)
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:])) / len(q)


if __name__ == "__main__":
    main()
