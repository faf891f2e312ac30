"""Finds the pairs of a report: those that overlap at q, or are near, with depth and witness points."""

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.report import Pair, Report
from ulna.drivers import contacts
from ulna.kernels.collision.collision_layout import CONTACT_WIDTH, DISTANCE, NORMAL, WITNESS_A, WITNESS_B
from ulna.kernels.collision.scene import Scene
from ulna.kernels.layout import TOUCH_SET
from ulna.kinematics.positions import for_kernel, refuse_out_of_range

Array = NDArray[np.float64]
FIRST_ROOM = 1024  # pairs; if there are more, the search is repeated with a larger array


def report_at(q: Array, scene: Scene, bodies: Bodies, object_names: tuple[str, ...], max_distance: float) -> Report:
    """The pairs that are at most ``max_distance`` [m] apart at q, shape (n_dof,), the nearest first."""
    candidates = _candidates(q, scene, max_distance)
    found = np.empty((len(candidates), CONTACT_WIDTH))
    rows, no_gradients = np.zeros(len(candidates), dtype=np.int64), np.empty((0, len(q)))
    if not contacts.contacts_each(*scene, for_kernel(q)[None], rows, candidates, found, no_gradients):
        refuse_out_of_range(q)
    near = np.flatnonzero(found[:, DISTANCE] <= max_distance)
    order = near[np.argsort(found[near, DISTANCE], kind="stable")]
    n, reported = len(bodies.names), {}
    for k, (a, b) in zip(order, candidates[order].tolist(), strict=True):  # of an object of many solids the nearest
        reported.setdefault((a, b if b < n else object_names[b - n]), k)
    return Report(tuple(_pair(bodies, object_names, candidates[k], found[k]) for k in reported.values()))


def _candidates(q: Array, scene: Scene, max_distance: float) -> NDArray[np.int64]:
    """The pairs that may be near enough, by their bounds."""
    n, n_unindexed, n_indexed = len(scene.bodies), scene.n_unindexed, len(scene.objects) - scene.n_unindexed
    robot = scene.joints, scene.bodies, scene.nodes
    unindexed = np.stack(np.meshgrid(np.arange(n), n + np.arange(n_unindexed), indexing="ij"), axis=-1).reshape(-1, 2)
    indexed, count = np.empty((0, 2), dtype=np.int64), FIRST_ROOM if n_indexed else 0
    while len(indexed) < count:
        indexed = np.empty((count, 2), dtype=np.int64)
        count = contacts.indexed_candidates(*robot, n_indexed, max_distance, for_kernel(q), indexed)
    of_world = np.concatenate([unindexed, indexed[:count] + np.array((0, n + n_unindexed))])
    touch_set = scene.objects[of_world[:, 1] - n, TOUCH_SET].astype(np.int64)
    return np.concatenate([of_world[~scene.may_touch[of_world[:, 0], touch_set]], scene.pairs])


def _pair(bodies: Bodies, object_names: tuple[str, ...], candidate: NDArray[np.int64], found: Array) -> Pair:
    (a, b), names, owners = candidate.tolist(), bodies.names, bodies.owners
    name_b, link_b = (names[b], owners[b]) if b < len(names) else (object_names[b - len(names)], None)
    points = (found[first : first + 3].copy() for first in (WITNESS_A, WITNESS_B, NORMAL))
    return Pair(names[a], name_b, owners[a], link_b, float(found[DISTANCE]), *points)
