"""Ranks placements of a robot's base by the reach of given poses.

A map holds poses in the base frame, so it is valid for every placement: T_base_tip = T_world_base^-1 T_world_tip.

1. Candidates are one voxel apart, over all positions from which the farthest target may still be reached, in ``yaw_steps``
   directions.
2. A target's score at a candidate is the share of reached orientations in its voxel, among the ``_N_ORIENTATIONS`` nearest
   orientations. A candidate's score is the minimum over its targets and, for equal minima, their mean. Vahrenkamp, Asfour and
   Dillmann sum over the inverse map instead ("Robot placement based on reachability inversion", ICRA 2013).
3. The best candidates are checked by inverse kinematics, with the world moved into the base frame.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_count, as_floats
from ulna.description.pose import as_one_pose, as_pose, inverse, matrix_from_rpy, quaternion_from_matrix
from ulna.errors import InputError
from ulna.reachability.grid import Grid

Array = NDArray[np.float64]
Reached = NDArray[np.bool_]
"""Whether each pose of a grid is reached, shape (z, y, x, orientation)."""
Solve = Callable[[Array, Array], tuple[Array, Array] | None]
"""From T_base_tip (n, 4, 4) and T_base_world to q (n, n_dof) and manipulability (n,); None if a target is not reached."""
DOFS = ("x", "y", "z", "yaw")
_N_ORIENTATIONS = 4  # orientations of the map around a target's orientation
_MAX_KEPT = 20_000  # candidates with one yaw


@dataclass(frozen=True, eq=False)
class BasePlacement:
    """A placement of a base.

    Attributes:
        T_world_base: Its pose, shape (4, 4).
        yaw: Its rotation about z relative to the given ``T_world_base`` [rad].
        score: The share of the map's orientations reached around the worst target, 0 to 1.
        q: Joint positions that reach the targets [rad or m], shape (n, n_dof).
        manipulability: The manipulability at each q, shape (n,).
    """

    T_world_base: Array
    yaw: float
    score: float
    q: Array
    manipulability: Array


def base_placements(
    grid: Grid, reached: Reached, solve: Solve, targets: ArrayLike, free_dofs: tuple[str, ...], T_world_base: ArrayLike | None,
    bounds: ArrayLike | None, yaw_steps: int, most: int, tries: int,
) -> tuple[BasePlacement, ...]:  # fmt: skip
    """See ``ReachabilityMap.base_placements``."""
    T_world_tip = as_pose(targets, "targets")
    if T_world_tip.ndim != 3 or not len(T_world_tip):
        raise InputError("targets", f"shape {T_world_tip.shape}; at least one pose is expected, shape (n, 4, 4)")
    for name in free_dofs:
        if name not in DOFS:
            raise InputError("free_dofs", f"{name!r}; {', '.join(DOFS)} are expected")
    T_0 = np.eye(4) if T_world_base is None else as_one_pose(T_world_base, "T_world_base")
    yaws = (
        np.arange(max(1, as_count("yaw_steps", yaw_steps))) * 2 * np.pi / max(1, yaw_steps) if "yaw" in free_dofs else np.zeros(1)
    )
    points = _candidates(grid, reached, T_world_tip[:, :3, 3], free_dofs, T_0[:3, 3], bounds)
    ranked = [_rank(grid, reached, T_world_tip, _rotated_about_z(T_0, yaw), yaw, points) for yaw in yaws] if len(points) else []
    rows = np.concatenate(ranked) if ranked else np.empty((0, 6))
    order = np.lexsort((-rows[:, 1], -rows[:, 0]))[: as_count("tries", tries)]
    found: list[BasePlacement] = []
    for row in rows[order]:
        T = _rotated_about_z(T_0, row[5])
        T[:3, 3] = row[2:5]
        solved = solve(inverse(T) @ T_world_tip, inverse(T))
        if solved is not None:
            found.append(BasePlacement(T, float(row[5]), float(row[0]), *solved))
        if len(found) >= as_count("most", most):
            break
    return tuple(sorted(found, key=lambda one: (-one.score, -float(one.manipulability.min()))))


def _candidates(
    grid: Grid, reached: Reached, tips: Array, free_dofs: tuple[str, ...], fixed_position: Array, bounds: ArrayLike | None
) -> Array:
    """Positions of the base, a voxel apart, shape (m, 3).

    Each tip (n, 3) is at most as far from them as the farthest reached voxel is from the map's base.
    """
    z, y, x = np.nonzero(reached.any(axis=-1))
    if not len(z):
        return np.empty((0, 3))
    centers = np.stack([axis[k] for axis, k in zip(grid.axes[::-1], (x, y, z), strict=True)], axis=-1)
    reach = float(np.linalg.norm(centers, axis=-1).max()) + grid.voxel
    low, high = tips.max(axis=0) - reach, tips.min(axis=0) + reach
    if bounds is not None:
        box = as_floats("bounds", bounds)
        if box.shape != (2, 3):
            raise InputError("bounds", "the lowest and the highest corner are expected, shape (2, 3)")
        low, high = np.maximum(low, box[0]), np.minimum(high, box[1])
    axes = [
        np.minimum(np.arange(low[k], high[k] + 1e-9, grid.voxel), high[k]) if name in free_dofs else np.array([fixed_position[k]])
        for k, name in enumerate("xyz")
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points[(np.linalg.norm(points[:, None] - tips, axis=-1) <= reach).all(axis=1)]


def _rotated_about_z(T_0: Array, yaw: float) -> Array:
    T = T_0.copy()
    T[:3, :3] = matrix_from_rpy((0.0, 0.0, yaw)) @ T_0[:3, :3]
    return T


def _rank(grid: Grid, reached: Reached, T_world_tip: Array, T_turned: Array, yaw: float, points: Array) -> Array:
    """Minimum and mean score, position and yaw of the best candidates with one direction of the base: shape (m, 6)."""
    R = T_turned[:3, :3]
    orientations = _nearest_orientations(grid, R.T @ T_world_tip[:, :3, :3])
    scores = np.empty((len(points), len(T_world_tip)))
    for k, T in enumerate(T_world_tip):
        index, inside = grid.voxel_of((T[:3, 3] - points) @ R)
        z, y, x = np.moveaxis(index, -1, 0)
        share = reached[z[:, None], y[:, None], x[:, None], orientations[k]].mean(axis=1)
        scores[:, k] = np.where(inside, share, 0.0)
    rows = np.column_stack([scores.min(axis=1), scores.mean(axis=1), points, np.full(len(points), yaw)])
    rows = rows[rows[:, 0] > 0.0] if (rows[:, 0] > 0.0).any() else rows[rows[:, 1] > 0.0]
    return rows[np.lexsort((-rows[:, 1], -rows[:, 0]))[:_MAX_KEPT]]


def _nearest_orientations(grid: Grid, rotations: Array) -> NDArray[np.int64]:
    """The indices of the map's orientations nearest to each of some rotations (n, 3, 3): shape (n, m)."""
    similarity = np.abs(quaternion_from_matrix(rotations) @ grid.wxyz.T)
    return np.argsort(-similarity, axis=1, kind="stable")[:, :_N_ORIENTATIONS]


def world_around_base(map_world: World | None, world: World | None, T_base_world: Array) -> World | None:
    """The objects that move with the base, and the fixed ones, in one world in the base frame."""
    if map_world is None and world is None:
        return None
    joined = World() if map_world is None else map_world
    if world is None:
        return joined
    for name, shape, T in world.items():
        free_name = name
        while free_name in joined.names:
            free_name += "'"
        joined.add(free_name, shape, T_base_world @ T, touch_links=world.touch_links(name))
    return joined
