"""Compares the poses of links at the same random configurations of the shared joints. Used by ``compare``."""

import numpy as np
from numpy.typing import NDArray

from ulna.comparison.matching import Matching
from ulna.comparison.result import PoseDifference
from ulna.description.pose import angle_between, inverse
from ulna.kinematics.sample import usual_range
from ulna.robot import Robot

N_CONFIGURATIONS = 1000
Array = NDArray[np.float64]


def pose_differences(a: Robot, b: Robot, matching: Matching) -> tuple[PoseDifference, ...]:
    """The largest differences of each pair of links. Joints without a partner stay at home."""
    q_a, q_b = _configurations(a, b, matching)
    names_a, names_b = ([pair[side] for pair in matching.links] for side in (0, 1))
    T_a, T_b = _poses(a, q_a, matching.frames[0], names_a), _poses(b, q_b, matching.frames[1], names_b)
    positions = np.linalg.norm((T_a - T_b)[..., :3, 3], axis=-1).max(axis=0)
    rotations = angle_between(T_a, T_b).max(axis=0)
    rows = zip(names_a, names_b, positions.tolist(), rotations.tolist(), strict=True)
    return tuple(PoseDifference(*row) for row in rows)


def _poses(robot: Robot, q: Array, frame: str, links: list[str]) -> Array:
    """T_frame_link, shape (n, n_links, 4, 4)."""
    T = robot.link_poses(q)
    at = {name: k for k, name in enumerate(robot.link_names)}
    return inverse(T[:, at[frame]])[:, None] @ T[:, [at[name] for name in links]]


def _configurations(a: Robot, b: Robot, matching: Matching) -> tuple[Array, Array]:
    q_a, q_b = (np.tile(robot.home, (N_CONFIGURATIONS, 1)) for robot in (a, b))
    slices_a, slices_b = (dict(zip(robot.joint_names, robot.joint_slices, strict=True)) for robot in (a, b))
    rng = np.random.default_rng(0)
    for one, other in matching.joints:
        columns_a, columns_b = slices_a.get(one.name), slices_b.get(other.name)
        if columns_a is None or columns_b is None or one.type != other.type:
            continue
        lower = np.maximum(a.lower[columns_a], b.lower[columns_b])
        upper = np.minimum(a.upper[columns_a], b.upper[columns_b])
        apart = lower > upper
        low, high = usual_range(np.where(apart, a.lower[columns_a], lower), np.where(apart, a.upper[columns_a], upper))
        q_a[:, columns_a] = q_b[:, columns_b] = rng.uniform(low, high, (N_CONFIGURATIONS, len(low)))
    return q_a, q_b
