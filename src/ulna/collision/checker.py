"""Collision queries: the robot's boxes at q against the boxes of a world."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.cores import shape_columns
from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.errors import GeometryError, InputError
from ulna.kernels.layout import BODY_WIDTH
from ulna.kernels.robot_boxes import OUT_OF_RANGE, OVERLAPS, gaps_one, overlap_batch, overlap_one
from ulna.kinematics.positions import as_positions, flat, for_kernel, refuse_out_of_range
from ulna.model.description import Body, Description, frozen
from ulna.model.shapes import Box
from ulna.model.tree import Tree


@dataclass(frozen=True, eq=False)
class BoxBodies:
    """The collision boxes of a robot: names, the links that carry them, and the table that the kernels read."""

    names: tuple[str, ...]
    links: tuple[str, ...]
    table: NDArray[np.float64]


def box_bodies(description: Description, tree: Tree) -> BoxBodies:
    """The collision boxes of a robot.

    Raises:
        GeometryError: It has no collision shapes, or has some that are not boxes: a query would be wrong without a word.
    """
    bodies = [(link.name, body) for link in description.links for body in link.collisions]
    if not bodies:
        raise GeometryError(f"robot {description.name!r} has no collision shapes, so nothing can be said of its collisions")
    rows = []
    for link, body in bodies:
        if not isinstance(body.shape, Box):
            kind = type(body.shape).__name__.lower()
            raise GeometryError(f"link {link!r}: collision shape {body.name!r} is a {kind}; this version checks boxes only")
        rows.append([*tree.frame_row(link, body.pose), *shape_columns(body.shape)])
    table = frozen(rows, (len(rows), BODY_WIDTH))
    return BoxBodies(_distinct_names(bodies), tuple(link for link, _ in bodies), table)


def _distinct_names(bodies: list[tuple[str, Body]]) -> tuple[str, ...]:
    """The shapes' names; one that stands twice gets its link before it, and a number behind it if need be."""
    plain = [body.name for _, body in bodies]
    long = [f"{link}/{body.name}" if plain.count(body.name) > 1 else body.name for link, body in bodies]
    return tuple(f"{name} ({long[: k + 1].count(name)})" if long.count(name) > 1 else name for k, name in enumerate(long))


def in_collision(tree: Tree, bodies: BoxBodies, q: ArrayLike, world: World) -> bool | NDArray[np.bool_]:
    """Whether any box overlaps any object: a bool for one q, else shape (...,)."""
    q, (_, objects) = as_positions(q, tree), _objects(world)
    if q.ndim == 1:
        answer = overlap_one(tree.joints, bodies.table, objects, for_kernel(q))
        if answer == OUT_OF_RANGE:
            refuse_out_of_range(q)
        return answer == OVERLAPS
    hits = np.empty(q.shape[:-1], dtype=np.bool_)
    if not overlap_batch(tree.joints, bodies.table, objects, flat(q), hits.reshape(-1)):
        refuse_out_of_range(q)
    return hits


def check_collision(tree: Tree, bodies: BoxBodies, q: ArrayLike, world: World) -> Report:
    """Every pair of a robot's box and an object that overlap, for one q."""
    q, (names, objects) = as_positions(q, tree), _objects(world)
    if q.ndim != 1:
        raise InputError("q", f"shape {q.shape}: a report is of one configuration; in_collision() takes a batch")
    gaps, normals = np.empty((len(bodies.names), len(names))), np.empty((len(bodies.names), len(names), 3))
    if not gaps_one(tree.joints, bodies.table, objects, for_kernel(q), gaps, normals):
        refuse_out_of_range(q)
    pairs = [
        Pair(bodies.names[k], names[w], bodies.links[k], float(gaps[k, w]), normals[k, w].copy())
        for k, w in np.argwhere(gaps <= 0.0)
    ]
    return Report(tuple(sorted(pairs, key=lambda pair: pair.signed_distance)))


def _objects(world: World) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    if not isinstance(world, World):
        raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
    return world.boxes()
