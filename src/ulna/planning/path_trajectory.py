"""Computes a trajectory along given configurations: an array, a followed path or another trajectory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World, refuse_no_world
from ulna.description.arrays import as_number
from ulna.dynamics.dynamics import Dynamics
from ulna.errors import InputError
from ulna.ik.followed_path import FollowedPath
from ulna.kinematics.positions import as_positions, refuse_out_of_range
from ulna.kinematics.tree import entry_names
from ulna.planning.blend import Certificate
from ulna.planning.boundary_velocities import as_ends, connect_ends, refuse_path_beyond
from ulna.planning.hand import HandLimits
from ulna.planning.motion import Motion
from ulna.planning.motion_limits import GivenLimits, as_motion_limits
from ulna.planning.motors import as_caps
from ulna.planning.path_limits import refuse_ends
from ulna.planning.space import make_space
from ulna.planning.trajectory import Trajectory, trajectory_at_rest

Array = NDArray[np.float64]
_MIN_DISTANCE = 1e-9  # [rad or m]: nearer points count as one
_STRAIGHT = 1e-12  # a smaller change of direction is no corner
Velocities = tuple[ArrayLike | None, ArrayLike | None]


class GivenMotion(NamedTuple):
    """The limits that a caller gives; see ``Plan.trajectory``."""

    velocity: ArrayLike | None
    acceleration: ArrayLike | None
    jerk: ArrayLike | None
    limits: GivenLimits | None
    hand: HandLimits | Iterable[HandLimits] | None = None
    torque: ArrayLike | None = None


def path_trajectory(
    q_path: ArrayLike | FollowedPath | Trajectory,
    checker: Checker,
    dynamics: Dynamics,
    world: World | None,
    within: float,
    given: GivenMotion,
    velocities: Velocities,
) -> Trajectory:
    """Compute a trajectory; see ``Robot.trajectory``. velocities: at the start and at the end."""
    within = as_number("within", within, 0.0, "a distance [rad or m] above 0", above=True)
    refuse_no_world(world)
    tree, points = checker.tree, _corner_points(q_path, checker)
    names = tuple(entry_names(tree))
    (limits, positions), caps = as_motion_limits(tree, *given[:4]), as_caps(given.hand, given.torque, tree, dynamics)
    inside = np.clip(points, positions.lower, positions.upper)
    points = np.where(np.abs(inside - points) <= _MIN_DISTANCE, inside, points)  # IK may exceed a limit by rounding
    refuse_path_beyond("q_path", points, positions, names)
    space = make_space(tree, points, np.zeros(tree.n_dof, dtype=bool))
    motion = Motion(space, checker, None if world is None else world.snapshot(), 0.0, dynamics=dynamics)
    certificate = (Certificate(_accept_all) if world is None else motion.certificate)._replace(positions=positions, caps=caps)
    ends = as_ends(*velocities, points, limits, positions, names)
    refuse_ends(caps, points, ends)
    if len(points) == 1 and not np.any(ends):
        free = world is not None and motion.is_free(np.repeat(points, 2, axis=0), np.zeros_like(points))
        still = trajectory_at_rest(points[0], names, certified=free, motion=motion, limits=limits, positions=positions)
        return replace(still, _caps=caps)
    timed = connect_ends(points, ends, np.inf, limits, certificate, partial(np.linalg.norm, axis=-1), names, within)
    free = world is not None and motion.is_free(*timed.edges_since(0.0))
    return Trajectory(free, names, timed, motion, limits, ends, positions, caps)


def _accept_all(paths: Array, _spreads: Array) -> int:
    return len(paths)


def _corner_points(q_path: ArrayLike | FollowedPath | Trajectory, checker: Checker) -> Array:
    """The corners of a path, with its ends, shape (n, n_dof)."""
    if isinstance(q_path, FollowedPath):
        if not q_path:
            raise InputError("q_path", f"not followed to its end: {q_path}")
        q_path = q_path.q if q_path.q_start is None else np.vstack([q_path.q_start, q_path.q])
    elif isinstance(q_path, Trajectory):
        q_path = q_path._timed.edges_since(0.0)[0]  # noqa: SLF001 - same package
    points = as_positions(q_path, checker.tree, "q_path")
    if points.ndim != 2 or not points.size:
        raise InputError("q_path", f"shape {points.shape}; configurations, shape (n, {checker.tree.n_dof}), are expected")
    refuse_out_of_range(points, "q_path")
    points = _distinct_points(points)
    while len(points) > 2:
        directions = np.diff(points, axis=0)
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        corner = np.abs(np.diff(directions, axis=0)).max(axis=1) > _STRAIGHT
        if corner.all():
            break
        points = points[np.concatenate([[True], corner, [True]])]
    return points


def _distinct_points(points: Array) -> Array:
    """The points without those near the previous remaining point; the last point always stays."""
    kept = [0]
    for k in range(1, len(points)):
        if np.abs(points[k] - points[kept[-1]]).max() > _MIN_DISTANCE:
            kept.append(k)
    if kept[-1] != len(points) - 1 and len(kept) > 1:
        kept[-1] = len(points) - 1
    return points[kept].copy()
