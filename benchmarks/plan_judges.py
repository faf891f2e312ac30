"""Judges paths: the overlap test at many samples, and Coal where they are nearest to an object."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import ulna

COAL_SAMPLES = 32  # of a path


def samples_of(path: NDArray, finer: float) -> NDArray:
    """Configurations of a path, shape (n, n_dof): ``finer`` per radian on each edge, and its ends."""
    rows = [path[:1]]
    for a, b in pairwise(path):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) * finer)))
        rows.append(a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a))
    return np.concatenate(rows)


def overlaps(robot: ulna.Robot, world: ulna.World, path: NDArray, finer: float) -> bool:
    """Whether the overlap test finds that the path touches the world, or the robot itself."""
    with ulna.threads(1):
        return bool(robot.in_collision(samples_of(path, finer), world).any())


def coal_touches(robot: ulna.Robot, world: ulna.World, path: NDArray, finer: float) -> bool:
    """Whether Coal finds a shape of the robot and an object that overlap, where the path is nearest to one."""
    q = samples_of(path, finer / 16)
    with ulna.threads(1):
        nearest = np.argsort(robot.signed_distance(q, world, self_collision=False))[:COAL_SAMPLES]
    return any(_touches_at(robot, world, q[k]) for k in nearest)


def _touches_at(robot: ulna.Robot, world: ulna.World, q: NDArray) -> bool:
    import coal  # noqa: PLC0415 - for --coal

    from benchmarks.peers.coal import of_coal  # noqa: PLC0415

    shapes = [one.shape for link in robot.description.links for one in link.collisions]
    request = coal.CollisionRequest()
    for shape, T in zip(shapes, robot.collision_poses(q), strict=True):
        ours = of_coal(shape), coal.Transform3s(T[:3, :3], T[:3, 3])
        for _, other, T_object in world.items():
            place = coal.Transform3s(T_object[:3, :3], T_object[:3, 3])
            if coal.collide(*ours, of_coal(other), place, request, coal.CollisionResult()):
                return True
    return False
