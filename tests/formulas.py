"""Slow and obvious formulas for the quantities that Ulna computes, in NumPy and from the definitions.

From Ulna they read only the plain data of a ``Description``. Nothing here is fast, and nothing branches for accuracy.
"""

import itertools
from math import cos, sin

import numpy as np

N_POSITIONS = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rotation(axis, angle):
    """Rodrigues' formula, with 1 - cos written so that nothing cancels."""
    K = skew(np.asarray(axis, dtype=float) / np.linalg.norm(axis))
    return np.eye(3) + np.sin(angle) * K + 2 * np.sin(angle / 2) ** 2 * K @ K


def transform(R=None, p=(0, 0, 0)):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.eye(3) if R is None else R, p
    return T


def from_rpy(xyz, rpy):
    X, Y, Z = np.eye(3)
    return transform(rotation(Z, rpy[2]) @ rotation(Y, rpy[1]) @ rotation(X, rpy[0]), xyz)


def logarithm(R):
    """The rotation vector through the eigen-decomposition: log R = V log(D) V^-1. Good for angles well below pi."""
    values, vectors = np.linalg.eig(R)
    log = (vectors @ np.diag(np.log(values)) @ np.linalg.inv(vectors)).real
    return np.array([log[2, 1] - log[1, 2], log[0, 2] - log[2, 0], log[1, 0] - log[0, 1]]) / 2


# ---- kinematics -------------------------------------------------------------------------------------------------------


def joint_motion(joint, x):
    """The motion of one joint at its own positions x, in the joint's frame."""
    if joint.type in ("revolute", "continuous"):
        return transform(rotation(joint.axis, x[0]))
    if joint.type == "prismatic":
        return transform(p=joint.axis * x[0])
    if joint.type == "planar":  # x and y of the plane are the joint's own, turned with z onto the axis by the shortest way
        z = np.array([0.0, 0.0, 1.0])
        turn_axis, angle = np.cross(z, joint.axis), np.arccos(np.clip(joint.axis @ z, -1, 1))
        turn = rotation(turn_axis if np.linalg.norm(turn_axis) > 0 else (1, 0, 0), angle)
        return transform(rotation(joint.axis, x[2]), turn @ (x[0], x[1], 0))
    if joint.type == "floating":
        return from_rpy(x[:3], x[3:])
    return np.eye(4)


def joints_from_root(description):
    """The joints depth first from the root, those of one link in the order of the file."""
    children = {joint.child for joint in description.joints}

    def behind(link):
        for joint in description.joints:
            if joint.parent == link:
                yield joint
                yield from behind(joint.child)

    return list(behind(next(link.name for link in description.links if link.name not in children)))


def joint_positions(description, q):
    """The positions of every joint by its name, mimics applied."""
    joints, rest, positions = joints_from_root(description), list(q), {}
    for joint in joints:
        if joint.mimic is None:
            n = N_POSITIONS[joint.type]
            positions[joint.name], rest = np.array(rest[:n]), rest[n:]
    assert not rest
    by_name = {joint.name: joint for joint in joints}

    def position(joint):
        if joint.mimic is None:
            return positions[joint.name] if N_POSITIONS[joint.type] else np.zeros(1)
        return joint.mimic.multiplier * position(by_name[joint.mimic.joint]) + joint.mimic.offset

    return {joint.name: position(joint) for joint in joints}


def link_poses(description, q):
    """T_base_link of every link, in the order of the description: 4x4 products along the joints."""
    joints = joints_from_root(description)
    positions = joint_positions(description, q)
    poses = {joints[0].parent if joints else description.links[0].name: np.eye(4)}
    for joint in joints:
        poses[joint.child] = poses[joint.parent] @ joint.origin @ joint_motion(joint, positions[joint.name])
    return np.array([poses[link.name] for link in description.links])


def link_pose(description, q, link):
    return link_poses(description, q)[[one.name for one in description.links].index(link)]


def craig(a, d, alpha, theta):
    """A row of a modified table. Craig, Introduction to Robotics (3rd ed., 2005), equation 3.6."""
    return np.array(
        [
            [cos(theta), -sin(theta), 0, a],
            [sin(theta) * cos(alpha), cos(theta) * cos(alpha), -sin(alpha), -sin(alpha) * d],
            [sin(theta) * sin(alpha), cos(theta) * sin(alpha), cos(alpha), cos(alpha) * d],
            [0, 0, 0, 1],
        ]
    )


def classic(a, d, alpha, theta):
    """A row of a standard table. Spong, Hutchinson and Vidyasagar, Robot Modeling and Control (2006), equation 3.10."""
    return np.array(
        [
            [cos(theta), -sin(theta) * cos(alpha), sin(theta) * sin(alpha), a * cos(theta)],
            [sin(theta), cos(theta) * cos(alpha), -cos(theta) * sin(alpha), a * sin(theta)],
            [0, sin(alpha), cos(alpha), d],
            [0, 0, 0, 1],
        ]
    )


DH_FORMULAS = {"modified": craig, "standard": classic}


def dh_poses(rows, types, q, convention):
    """T_0_k of every row of a DH table: the running product, q entering as theta or as d."""
    poses, T, entries = [], np.eye(4), iter(q)
    for (a, d, alpha, theta), kind in zip(rows, types, strict=True):
        value = 0.0 if kind == "fixed" else next(entries)
        T = T @ DH_FORMULAS[convention](a, d + value * (kind == "prismatic"), alpha, theta + value * (kind != "prismatic"))
        poses.append(T)
    return poses


def derivative(f, x, h=1e-3):
    """Central differences over five points: right to about 1e-12 for a function whose derivatives are of the order of 1."""
    return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * h)


def jacobian(description, q, link, expressed_in="base"):
    """v and w of a link for a unit rate of each entry of q, from differences of its pose."""
    q, T = np.array(q, dtype=float), link_pose(description, q, link)
    J = np.empty((6, len(q)))
    for j, unit in enumerate(np.eye(len(q))):
        dT = derivative(lambda s, unit=unit: link_pose(description, q + s * unit, link), 0.0)
        W = dT[:3, :3] @ T[:3, :3].T
        v, w = dT[:3, 3], np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2
        if expressed_in == "link":
            v, w = T[:3, :3].T @ v, T[:3, :3].T @ w
        elif expressed_in == "spatial":
            v = v - np.cross(w, T[:3, 3])
        J[:, j] = [*v, *w]
    return J


def pose_error(description, q, link, target):
    """Displacement and rotation vector from the link to a target, in the base's axes; for rotations well below pi."""
    T = link_pose(description, q, link)
    return np.concatenate([target[:3, 3] - T[:3, 3], logarithm(target[:3, :3] @ T[:3, :3].T)])


def damped_solution(J, e, damping):
    """y of (J J' + damping I) y = e."""
    return np.linalg.solve(J @ J.T + damping * np.eye(6), e)


# ---- boxes ------------------------------------------------------------------------------------------------------------


def corners(T, half_extents):
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    return (signs * half_extents) @ T[:3, :3].T + T[:3, 3]


def gaps_of_boxes(T_a, h, T_b, g, parallel=1e-7):
    """The gap between the shadows of two boxes on each of the 15 axes; -inf where two edges are parallel and give none."""
    A, B = T_a[:3, :3].T, T_b[:3, :3].T
    axes = [*A, *B, *(np.cross(a, b) for a in A for b in B)]
    corners_a, corners_b = corners(T_a, h), corners(T_b, g)
    gaps = np.full(15, -np.inf)
    for k, axis in enumerate(axes):
        if np.linalg.norm(axis) > parallel:
            n = axis / np.linalg.norm(axis)
            a, b = (corners_a - T_a[:3, 3]) @ n, (corners_b - T_a[:3, 3]) @ n
            gaps[k] = max(b.min() - a.max(), a.min() - b.max())
    return gaps
