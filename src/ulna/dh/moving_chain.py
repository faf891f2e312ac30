"""Finds the part of a chain that moves, which the rows of its DH table describe."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.robot_description import Description, Joint, JointType, Mimic
from ulna.description.structure import moving_joints
from ulna.description.subtree import chain_joints
from ulna.errors import InputError
from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, RATIO
from ulna.kinematics.tree import Tree, motion_along_z, row_pose

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DHChain:
    """The moving joints of a chain, their rows of the tree's table, their frames at zero (z along the axis), and the tip's."""

    joints: tuple[Joint, ...]
    table: Array
    frames: Array
    T_base_tip: Array


def dh_chain(description: Description, tree: Tree, link: str) -> DHChain:
    """The chain from the base to a link.

    Raises:
        UnknownNameError: There is no such link.
        InputError: A joint of the chain is planar or floating.
    """
    table = tree.chain(link)
    joints = chain_joints(description, tree.root, link)
    for joint in joints:
        if joint.type in (JointType.PLANAR, JointType.FLOATING):
            message = f"the chain from {tree.root!r} to {link!r} has the {joint.type} joint {joint.name!r}"
            raise InputError("link", f"{message}, which no row of a DH table can describe")
    names = iter(moving_joints(description, joints))
    T, kept, rows, frames = np.eye(4), [], [], []
    for row in table:
        T = T @ row_pose(row)
        if row[KIND] == FIXED:
            continue
        joint = next(names)
        if row[RATIO] == 0:  # it does not move, and belongs to the constant part
            T = T @ motion_along_z(int(row[KIND]), row[OFFSET])
        else:
            kept.append(joint)
            rows.append(row)
            frames.append(T)
    return DHChain(tuple(kept), np.array(rows).reshape(-1, table.shape[1]), np.array(frames).reshape(-1, 4, 4), T)


def mimics_within(chain: DHChain) -> Iterator[Mimic | None]:
    """For each row the row that it follows: its own leader where that is in the chain, else the first with the same one."""
    leaders: dict[float, int] = {}
    for k in sorted(range(len(chain.joints)), key=lambda k: chain.joints[k].mimic is not None):
        leaders.setdefault(chain.table[k, COLUMN], k)
    for k, row in enumerate(chain.table):
        first = leaders[row[COLUMN]]
        leader = chain.table[first]
        ratio = float(row[RATIO] / leader[RATIO])
        yield None if first == k else Mimic(chain.joints[first].name, ratio, float(row[OFFSET] - ratio * leader[OFFSET]))
