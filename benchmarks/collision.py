"""Collision queries beside Pinocchio with Coal, called in a loop: the same robot, the same twelve boxes, one process, medians.

Needs pin and coal (the group ``tests``). Run: python benchmarks/collision.py
"""

import time
from collections.abc import Callable

import coal
import numpy as np
import pinocchio as pin

import ulna

N = 2048  # configurations of a batch
N_LOOP = 200  # of the other library's loop
REPEATS = 15


def seconds(call: Callable[[], object]) -> float:
    """The median time of a call."""
    call()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


class Peer:
    """Pinocchio's kinematics and Coal's shapes: the robot's twelve boxes, the world's, and the pairs that are checked."""

    def __init__(self, robot: ulna.Robot, world: ulna.World, *, itself: bool) -> None:
        self.model = pin.buildModelFromXML(robot.to_urdf())
        self.data, self.geometry = self.model.createData(), pin.GeometryModel()
        bodies, names = [], iter(robot.collision_names)
        for link in robot.description.links:
            frame = self.model.frames[self.model.getFrameId(link.name)]
            for body in link.collisions:
                placement = frame.placement * pin.SE3(body.pose)
                shape = coal.Box(*body.shape.extents)
                bodies.append(
                    self.geometry.addGeometryObject(pin.GeometryObject(next(names), frame.parentJoint, placement, shape))
                )
        for name in world.names:
            shape = coal.Box(*world.shape(name).extents)
            other = self.geometry.addGeometryObject(pin.GeometryObject(f"world {name}", 0, pin.SE3(world.pose(name)), shape))
            for body in bodies:
                self.geometry.addCollisionPair(pin.CollisionPair(body, other))
        if itself:
            for i, j in robot._checker.pairs:  # noqa: SLF001 - the pairs by number, so that both check the same
                self.geometry.addCollisionPair(pin.CollisionPair(bodies[i], bodies[j]))
        self.answers = self.geometry.createData()

    def collides(self, q) -> bool:
        """Whether any pair touches."""
        return pin.computeCollisions(self.model, self.data, self.geometry, self.answers, q, True)  # noqa: FBT003

    def distances(self, q) -> int:
        """The distances of all pairs: the number of the nearest."""
        return pin.computeDistances(self.model, self.data, self.geometry, self.answers, q)


def scattered(n: int, size: float, reach: float) -> ulna.World:
    """Boxes in a cube about the arm, none where it stands."""
    rng, world = np.random.default_rng(n), ulna.World()
    while len(world.names) < n:
        place = rng.uniform(-reach, reach, 3)
        if np.linalg.norm(place) > 0.45:
            world.add(f"{len(world.names)}", ulna.Box(size * rng.uniform(0.3, 1, 3)), ulna.pose(place, rng.uniform(-3, 3, 3)))
    return world


def line(name: str, ours: float, theirs: float, least: float) -> None:
    """Print one line of the table."""
    print(f"{name:42} {ours * 1e6:10.3f} {theirs * 1e6:10.2f} {theirs / ours:9.1f}x {least:6.0f}x")


def against_the_peer(robot: ulna.Robot) -> None:
    """The ratios of queries in a batch and one by one."""
    q = np.random.default_rng(1).uniform(robot.lower, robot.upper, (N, robot.n_dof))
    one = ulna.World()
    one.add("crate", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.5, 0, 0.21)))
    hundred, nothing = scattered(100, 0.06, 1.0), ulna.World()
    print(f"{'microseconds a configuration':42} {'Ulna':>10} {'pin+coal':>10} {'ratio':>10} {'aim':>7}")
    cases = {
        "one box (12 pairs)": (one, False, 15),
        "100 boxes (1200 pairs)": (hundred, False, 50),
        "itself (37 pairs)": (nothing, True, 15),
    }
    for name, (world, itself, least) in cases.items():
        peer = Peer(robot, world, itself=itself)
        wrong = np.count_nonzero(robot.in_collision(q[:N_LOOP], world, itself) != [peer.collides(x) for x in q[:N_LOOP]])
        ours = seconds(lambda world=world, itself=itself: robot.in_collision(q, world, itself)) / N
        theirs = seconds(lambda peer=peer: [peer.collides(x) for x in q[:N_LOOP]]) / N_LOOP
        line(f"batch, {name}" + (f", {wrong} differ" if wrong else ""), ours, theirs, least)
    for name, (world, itself, _) in cases.items():
        peer = Peer(robot, world, itself=itself)
        ours = seconds(lambda world=world, itself=itself: robot.signed_distance(q, world, itself)) / N
        theirs = seconds(lambda peer=peer: [peer.distances(x) for x in q[:N_LOOP]]) / N_LOOP
        line(f"distances in a batch, {name}", ours, theirs, 5)
    rows = [x.copy() for x in q[:N_LOOP]]
    for name, (world, itself, _) in cases.items():
        peer = Peer(robot, world, itself=itself)
        ours = seconds(lambda world=world, itself=itself: [robot.in_collision(x, world, itself) for x in rows]) / N_LOOP
        theirs = seconds(lambda peer=peer: [peer.collides(x) for x in rows]) / N_LOOP
        line(f"one call, {name}", ours, theirs, 1)


def growth(robot: ulna.Robot) -> None:
    """The time of a query in worlds of 1 to 10 000 boxes, as dense at any number from 100 on, and denser and denser."""
    q = np.random.default_rng(1).uniform(robot.lower, robot.upper, (4 * N, robot.n_dof))
    q = q[~robot.in_collision(q)]
    print(
        f"\n{'objects':>8} {'world':>8} {'free':>6} {'build [ms]':>11} {'one [us]':>14} {'batch [us]':>11} {'distance [us]':>14}"
    )
    for kind, size, reach in (("sparse", 0.05, None), ("crowded", 0.008, 2.0)):
        for n in (1, 10, 100, 1000, 10_000):
            world = scattered(n, size, reach or max(1.0, (n / 100) ** (1 / 3)))
            start = time.perf_counter()
            world.objects()
            build = time.perf_counter() - start
            free = q[~robot.in_collision(q, world)][:N_LOOP]
            if not len(free):
                continue
            batch = np.repeat(free, -(-N // len(free)), axis=0)
            one = seconds(lambda free=free, world=world: [robot.in_collision(x, world) for x in free]) / len(free)
            many = seconds(lambda batch=batch, world=world: robot.in_collision(batch, world)) / len(batch)
            apart = seconds(lambda batch=batch, world=world: robot.signed_distance(batch[:512], world)) / 512
            numbers = f"{build * 1e3:11.1f} {one * 1e6:14.2f} {many * 1e6:11.3f} {apart * 1e6:14.2f}"
            print(f"{n:8} {kind:>8} {len(free):6} {numbers}")


def edges(robot: ulna.Robot) -> None:
    """Certified edges in a batch, beside as many samples as one would have to take to be sure to a tenth of a millimetre."""
    world, rng = scattered(10, 0.1, 0.9), np.random.default_rng(2)
    q = rng.uniform(robot.lower, robot.upper, (4 * N, robot.n_dof))
    a = q[~robot.in_collision(q, world)][:500]
    b = np.clip(a + 0.3 * rng.normal(size=a.shape), robot.lower, robot.upper)
    found = robot.edge_in_collision(a, b, world)
    print(f"\n{len(a)} edges, {found!s}: {seconds(lambda: robot.edge_in_collision(a, b, world)) / len(a) * 1e6:.1f} us an edge")


if __name__ == "__main__":
    panda = ulna.load("panda")
    against_the_peer(panda)
    growth(panda)
    edges(panda)
