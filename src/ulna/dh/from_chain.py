"""Computes the Denavit-Hartenberg table of any serial chain, and proves that both are the same robot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_number
from ulna.description.pose import angle_between, inverse
from ulna.description.robot_description import Description, Joint, JointType, Mimic
from ulna.description.structure import moving_joints
from ulna.description.subtree import chain_joints
from ulna.dh.common_normals import NEARLY_PARALLEL, Axes, Normals, common_normals
from ulna.dh.table import DHTable, checked_convention, constant_poses
from ulna.errors import InputError
from ulna.kernels.layout import COLUMN, FIXED, KIND, LARGEST, OFFSET, PRISMATIC, RATIO
from ulna.kinematics.forward import forward_kinematics
from ulna.kinematics.sample import random_positions
from ulna.kinematics.tree import Tree, motion_along_z, row_pose

Array = NDArray[np.float64]
_ROUNDING = 1e-14  # of a number that passed through the products of a chain
_WORTH_A_NOTE = 1e-12  # rad: smaller tilts are rounding; those below NEARLY_PARALLEL may be a mistake
_N_CONFIGURATIONS = 1000


def dh_table(description: Description, tree: Tree, link: str, convention: str, tolerance: float) -> DHTable:
    """The table from the base to a link; see ``Robot.dh``."""
    checked_convention(convention)
    tolerance = max(as_number("tolerance", tolerance, 0.0, "a number from 0 to 0.1", most=0.1), _WORTH_A_NOTE)
    chain = dh_chain(description, tree, link)
    axes = _axes(chain, tolerance)
    normals = common_normals(axes, ends_at_tip=convention == "standard", tolerance=tolerance)
    rows = _rows(normals, convention)
    _refuse_far_normals(chain, axes, rows, tolerance)
    tables = [
        _table(description, tree, link, convention, chain, some, tuple(_notes(chain, axes, tolerance)))
        for some in _exact_and_rounded(rows, _frame_0(axes, normals, convention))
    ]
    return tables[1] if _is_as_exact(tables[1], tables[0]) else tables[0]


def _axes(chain: DHChain, tolerance: float) -> Axes:
    frames = np.concatenate([np.eye(4)[None], chain.frames, chain.T_base_tip[None]])
    z = frames[:, :3, 2].copy()
    axes = Axes(frames[:, :3, 3], z, (False, *(chain.table[:, KIND] == PRISMATIC), False), chain.T_base_tip[:3, 0])
    if axes.parallel(tolerance)[0]:
        z[0] = np.copysign(1.0, z[0] @ z[1]) * z[1]  # T_base_0 includes the tilt
    return axes


def _rows(normals: Normals, convention: str) -> Array:
    along_x = slice(0, -1) if convention == "modified" else slice(1, None)
    return np.column_stack([normals.a[along_x], normals.d, normals.alpha[along_x], normals.theta])


def _frame_0(axes: Axes, normals: Normals, convention: str) -> Array:
    """T_base_0: the frame of the first row, on the base's z axis (modified) or on the first joint's axis (standard)."""
    modified = convention == "modified" or len(axes.directions) == 2
    z, origin = (axes.directions[0], normals.starts[0]) if modified else (axes.directions[1], normals.ends[0])
    T, x = np.eye(4), normals.x[0]
    T[:3, :3], T[:3, 3] = np.column_stack([x, np.cross(z, x), z]), origin
    return T


def _exact_and_rounded(rows: Array, T_base_0: Array) -> Iterator[tuple[Array, Array]]:
    yield rows, T_base_0
    angles = rows[:, 2:]
    quarters = np.round(angles / (np.pi / 2)) * (np.pi / 2)
    angles = np.where(np.abs(angles - quarters) < _ROUNDING, quarters, _decimal(angles))
    yield np.column_stack([_decimal(rows[:, :2]), angles]), _decimal(T_base_0)


def _decimal(values: Array) -> Array:
    """Replace values within rounding of a number with at most twelve decimals by that number."""
    short = np.round(values, 12) + 0.0
    return np.where(np.abs(values - short) < _ROUNDING, short, values)


def _table(
    description: Description,
    tree: Tree,
    link: str,
    convention: str,
    chain: DHChain,
    rows_and_base: tuple[Array, Array],
    notes: tuple[str, ...],
) -> DHTable:
    """The table of these rows after ``T_base_0``; the remaining pose of the tip at zero is ``T_n_tip``."""
    rows, T_base_0 = rows_and_base
    zero_positions = np.zeros((1, len(rows)))
    T_n_tip = _decimal(inverse(_frame_n(rows, convention, T_base_0, chain, zero_positions)[0]) @ chain.T_base_tip)
    q = random_positions(tree, _N_CONFIGURATIONS)
    positions = q[:, chain.table[:, COLUMN].astype(int)] * chain.table[:, RATIO] + chain.table[:, OFFSET]
    T_table = _frame_n(rows, convention, T_base_0, chain, positions) @ T_n_tip
    T_robot = forward_kinematics(tree, q, link)
    return DHTable(
        name=description.name,
        convention=convention,
        base=tree.root,
        tip=link,
        rows=rows,
        joint_names=tuple(joint.name for joint in chain.joints),
        joint_types=tuple(joint.type.value for joint in chain.joints),
        limits=tuple(joint.limits for joint in chain.joints),
        mimics=tuple(mimics_within(chain)),
        T_base_0=T_base_0,
        T_n_tip=T_n_tip,
        max_position_difference=float(np.linalg.norm((T_table - T_robot)[:, :3, 3], axis=1).max()),
        max_rotation_difference=float(angle_between(T_table, T_robot).max()),
        n_configurations=len(q),
        notes=notes,
    )


def _frame_n(rows: Array, convention: str, T_base_0: Array, chain: DHChain, positions: Array) -> Array:
    """T_base_n at joint positions (m, n), shape (m, 4, 4): the table's product of transforms, written out."""
    pose = np.broadcast_to(T_base_0, (len(positions), 4, 4))
    for row, kind, position in zip(rows, chain.table[:, KIND], positions.T, strict=True):
        pose_before, pose_after = constant_poses(row, convention)
        pose = pose @ pose_before @ motion_along_z(int(kind), position) @ pose_after
    return pose


def _is_as_exact(table: DHTable, exact: DHTable) -> bool:
    return (
        table.max_position_difference <= exact.max_position_difference + 10 * _ROUNDING
        and table.max_rotation_difference <= exact.max_rotation_difference + 10 * _ROUNDING
    )


def _refuse_far_normals(chain: DHChain, axes: Axes, rows: Array, tolerance: float) -> None:
    if np.abs(rows).max(initial=0.0) <= LARGEST:
        return
    tilts = np.where(axes.tilts > tolerance, axes.tilts, np.inf)[1:-1]
    i = int(np.argmin([*tilts, NEARLY_PARALLEL])) + 1
    if i > len(tilts):
        raise InputError("link", f"its chain reaches further than {LARGEST:g} m")
    message = f"{_pair(chain, i)} are {tilts[i - 1]:.2g} rad from parallel, and their common normal lies beyond {LARGEST:g} m"
    raise InputError("tolerance", f"{message}; tolerance={_above(tilts[i - 1]):g} treats them as parallel")


def _notes(chain: DHChain, axes: Axes, tolerance: float) -> Iterator[str]:
    for i, tilt in enumerate(axes.tilts[1:-1], start=1):
        if tolerance < tilt < NEARLY_PARALLEL:
            hint = f"and not treated as parallel, as with tolerance={_above(tilt):g}"
            yield f"{_pair(chain, i)} are {tilt:.2g} rad from parallel, {hint}"
        elif _WORTH_A_NOTE < tilt <= tolerance:
            yield f"{_pair(chain, i)} are {tilt:.2g} rad from parallel, and treated as parallel (tolerance {tolerance:g})"


def _pair(chain: DHChain, i: int) -> str:
    """Words for line i and the next one; the lines of the joints are 1 to n."""
    return f"the axes of {chain.joints[i - 1].name!r} and {chain.joints[i].name!r}"


def _above(tilt: float) -> float:
    return 10.0 ** (floor(log10(tilt)) + 1)


@dataclass(frozen=True, eq=False)
class DHChain:
    """The moving joints of a chain, their rows of the tree's table, and the frames at zero.

    z of a joint's frame is along its axis.
    """

    joints: tuple[Joint, ...]
    table: Array
    frames: Array
    T_base_tip: Array


def dh_chain(description: Description, tree: Tree, link: str) -> DHChain:
    """The chain from the base to a link."""
    table = tree.chain(link)
    joints = chain_joints(description, tree.root, link)
    for joint in joints:
        if joint.type in (JointType.PLANAR, JointType.FLOATING):
            message = f"the chain from {tree.root!r} to {link!r} has the {joint.type} joint {joint.name!r}"
            raise InputError("link", f"{message}, which no row of a DH table can describe")
    names = iter(moving_joints(description, joints))
    pose, moving, rows, frames = np.eye(4), [], [], []
    for row in table:
        pose = pose @ row_pose(row)
        if row[KIND] == FIXED:
            continue
        joint = next(names)
        if row[RATIO] == 0:  # it does not move, and belongs to the constant part
            pose = pose @ motion_along_z(int(row[KIND]), row[OFFSET])
        else:
            moving.append(joint)
            rows.append(row)
            frames.append(pose)
    return DHChain(tuple(moving), np.array(rows).reshape(-1, table.shape[1]), np.array(frames).reshape(-1, 4, 4), pose)


def mimics_within(chain: DHChain) -> Iterator[Mimic | None]:
    """The mimic relation of each row.

    A row follows its own leader if the chain contains it, else the first row with the same leader.
    """
    leaders: dict[float, int] = {}
    for k in sorted(range(len(chain.joints)), key=lambda k: chain.joints[k].mimic is not None):
        leaders.setdefault(chain.table[k, COLUMN], k)
    for k, row in enumerate(chain.table):
        first = leaders[row[COLUMN]]
        leader = chain.table[first]
        ratio = float(row[RATIO] / leader[RATIO])
        yield None if first == k else Mimic(chain.joints[first].name, ratio, float(row[OFFSET] - ratio * leader[OFFSET]))
