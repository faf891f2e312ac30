"""Finds the pairs of a report: those that overlap at q, or are near, with depth and witness points."""

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.report import Pair, Report
from ulna.collision.solid_numbers import rows_of
from ulna.drivers import contacts
from ulna.kernels.collision.collision_layout import CONTACT_WIDTH, DISTANCE, NO_NODE, NORMAL, WITNESS_A, WITNESS_B
from ulna.kernels.collision.scene import Scene
from ulna.kernels.layout import OBJECT, TOUCH_SET
from ulna.kinematics.positions import for_kernel, refuse_out_of_range

Array = NDArray[np.float64]
FIRST_ROOM = 1024  # pairs; if there are more, the search is repeated with a larger array


def report_at(q: Array, scene: Scene, bodies: Bodies, object_names: list[str], max_distance: float) -> Report:
    """The pairs that are at most ``max_distance`` [m] apart at q, shape (n_dof,), the nearest first.

    object_names: by the numbers in the rows of the scene's objects.
    """
    candidates = pairs_in_bounds(q, scene, max_distance)
    found = contacts_of_pairs(q, scene, candidates)
    near = np.flatnonzero(found[:, DISTANCE] <= max_distance)
    order = near[np.argsort(found[near, DISTANCE], kind="stable")]
    n, reported = len(bodies.names), {}
    for k, (a, b) in zip(order, candidates[order].tolist(), strict=True):  # of an object of many solids the nearest
        other = (bodies.names[b], bodies.owners[b]) if b < n else (object_names[_object_of(scene, b - n)], None)
        reported.setdefault((a, *other), k)
    return Report(tuple(_pair(bodies, a, name_b, link_b, found[k]) for (a, name_b, link_b), k in reported.items()))


def contacts_of_pairs(q: Array, scene: Scene, pairs: NDArray[np.int64]) -> Array:
    """The contact of each pair at q, shape (n, CONTACT_WIDTH)."""
    found = np.empty((len(pairs), CONTACT_WIDTH))
    rows, no_gradients = np.zeros(len(pairs), dtype=np.int64), np.empty((0, len(q)))
    if not contacts.contacts_each(*scene, for_kernel(q)[None], rows, pairs, found, no_gradients):
        refuse_out_of_range(q)
    return found


def pairs_in_bounds(q: Array, scene: Scene, max_distance: float) -> NDArray[np.int64]:
    """The pairs that may be at most so far apart at q [m], by their bounds, shape (n, 2)."""
    n = len(scene.bodies)
    robot = scene.joints, scene.bodies, scene.nodes
    unindexed = np.stack(np.meshgrid(np.arange(n), n + np.arange(scene.first, scene.end), indexing="ij"), axis=-1).reshape(-1, 2)
    indexed, count = np.empty((0, 2), dtype=np.int64), 0 if scene.root == NO_NODE else FIRST_ROOM
    while len(indexed) < count:
        indexed = np.empty((count, 2), dtype=np.int64)
        count = contacts.indexed_candidates(*robot, scene.root, max_distance, for_kernel(q), indexed)
    of_world = np.concatenate([unindexed, indexed[:count] + np.array((0, n))])
    touch_set = scene.objects[rows_of(scene.nodes, of_world[:, 1] - n), TOUCH_SET].astype(np.int64)
    return np.concatenate([of_world[~scene.may_touch[of_world[:, 0], touch_set]], scene.pairs])


def _object_of(scene: Scene, number: int) -> int:
    return int(scene.objects[rows_of(scene.nodes, np.array([number]))[0], OBJECT])


def _pair(bodies: Bodies, a: int, name_b: str, link_b: str | None, found: Array) -> Pair:
    points = (found[first : first + 3].copy() for first in (WITNESS_A, WITNESS_B, NORMAL))
    return Pair(bodies.names[a], name_b, bodies.owners[a], link_b, float(found[DISTANCE]), *points)
