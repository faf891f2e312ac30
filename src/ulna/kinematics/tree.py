"""Converts a description to the flat arrays that the kernels read.

Every joint of a table rotates about, or slides along, the z axis of its own frame. A joint about another axis gets a frame
rotated so that z lies along that axis, and the link behind it is rotated back. A planar joint becomes three joints of the table
(x, y, theta). A floating joint becomes six (x, y, z, then yaw, pitch, roll). So the kernels have only two kinds of motion.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import pose
from ulna.description.robot_description import Description, Joint, JointType, frozen
from ulna.description.structure import (
    Drive,
    acceleration_limits_of_q,
    bounds_of_q,
    columns_of_q,
    drives_of,
    effort_limits_of_q,
    hard_bounds,
    joints_from_root,
    leaf_links,
    root_link,
    soft_bounds,
    velocity_limits_of_q,
)
from ulna.errors import InputError, UnknownNameError
from ulna.kernels.layout import BASE, COLUMN, FIXED, FRAME_WIDTH, KIND, LARGEST, PARENT, PRISMATIC, RATIO, REVOLUTE, TABLE_WIDTH

X, Y, Z = np.eye(3)
# The motions of each joint type, in order: kind, axis (None: the joint's own), entry of the joint's part of q.
_MOTIONS = {
    JointType.REVOLUTE: [(REVOLUTE, None, 0)],
    JointType.CONTINUOUS: [(REVOLUTE, None, 0)],
    JointType.PRISMATIC: [(PRISMATIC, None, 0)],
    JointType.PLANAR: [(PRISMATIC, X, 0), (PRISMATIC, Y, 1), (REVOLUTE, Z, 2)],
    JointType.FLOATING: [
        (PRISMATIC, X, 0), (PRISMATIC, Y, 1), (PRISMATIC, Z, 2), (REVOLUTE, Z, 5), (REVOLUTE, Y, 4), (REVOLUTE, X, 3),
    ],
}  # fmt: skip


class Narrowed(NamedTuple):
    """Limits that a caller stated in addition to those of a description, shape (n_dof,) each; infinite if not stated."""

    lower: NDArray[np.float64]
    """[rad or m], as ``upper``."""
    upper: NDArray[np.float64]
    velocity: NDArray[np.float64]
    """[rad/s or m/s]."""
    acceleration: NDArray[np.float64]
    """[rad/s^2 or m/s^2]."""
    jerk: NDArray[np.float64]
    """[rad/s^3 or m/s^3]."""


@dataclass(frozen=True, eq=False)
class Tree:
    """A robot as arrays.

    ``joints`` is the table of moving joints. Each link is fixed to a row of it (``link_row``, or BASE) at ``link_offset``,
    T_row_link. ``followers`` has the drive of each mimic joint. ``narrowed`` has the stated limits that narrowed those of the
    description.
    """

    name: str
    root: str
    leaves: tuple[str, ...]
    link_names: tuple[str, ...]
    joint_names: tuple[str, ...]
    joint_slices: tuple[slice, ...]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    soft_lower: NDArray[np.float64]
    soft_upper: NDArray[np.float64]
    velocity_limits: NDArray[np.float64]
    acceleration_limits: NDArray[np.float64]
    jerk_limits: NDArray[np.float64]
    effort_limits: NDArray[np.float64]
    joints: NDArray[np.float64]
    link_row: dict[str, int]
    link_offset: dict[str, NDArray[np.float64]]
    link_frames: NDArray[np.float64]
    followers: dict[str, Drive]
    narrowed: Narrowed | None = None
    _chains: dict[str, NDArray[np.float64]] = field(default_factory=dict, repr=False)
    _moving: dict[str, NDArray[np.int64]] = field(default_factory=dict, repr=False)

    @cached_property
    def n_dof(self) -> int:
        """The number of entries of q."""
        return len(self.lower)

    @cached_property
    def q_shape(self) -> tuple[int]:
        """The shape of one q."""
        return (self.n_dof,)

    @cached_property
    def lower_finite(self) -> NDArray[np.float64]:
        """The lower limits, clipped to the range that can be computed with, shape (n_dof,)."""
        return np.maximum(self.lower, -LARGEST)

    @cached_property
    def upper_finite(self) -> NDArray[np.float64]:
        """The upper limits, clipped to the range that can be computed with, shape (n_dof,)."""
        return np.minimum(self.upper, LARGEST)

    @cached_property
    def limits(self) -> NDArray[np.float64]:
        """Lower and upper limits, shape (2, n_dof)."""
        return frozen([self.lower, self.upper], (2, self.n_dof))

    @cached_property
    def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper limits as a dictionary key."""
        return tuple(self.lower.tolist()), tuple(self.upper.tolist())

    @cached_property
    def tip(self) -> str | None:
        """The only link without child links that a joint moves; None if there are several."""
        return self.leaves[0] if len(self.leaves) == 1 else None

    def link_or_tip(self, link: str | None) -> str:
        """The link itself; the tip for None.

        Raises:
            InputError: There are several tips, so one has to be named.
        """
        if link is not None:
            return link
        if self.tip is None:
            leaves = ", ".join(self.leaves[:12]) + (" ..." if len(self.leaves) > 12 else "")
            raise InputError("link", f"{self.name!r} has several tips; name one of {leaves}, or any other link")
        return self.tip

    def chain(self, link: str) -> NDArray[np.float64]:
        """The table of the joints from the base to a link, followed by the link's own offset; cached.

        Raises:
            UnknownNameError: There is no such link.
        """
        if not isinstance(link, str):
            raise UnknownNameError("link", str(link), self.link_names)
        chain = self._chains.get(link)
        if chain is None:
            chain = self._chains[link] = self._make_chain(link)
        return chain

    def moving_columns(self, link: str) -> NDArray[np.int64]:
        """The entries of q that move a joint between the base and a link, in order."""
        columns = self._moving.get(link)
        if columns is None:
            chain = self.chain(link)
            moves = (chain[:, KIND] != FIXED) & (chain[:, RATIO] != 0.0)
            columns = self._moving[link] = np.unique(chain[moves, COLUMN].astype(np.int64))
            columns.setflags(write=False)
        return columns

    def frame_row(self, link: str, T_link_frame: NDArray[np.float64]) -> NDArray[np.float64]:
        """The row of a table of frames for a frame that is fixed to a link."""
        return _frame_row(self.link_row[link], self.link_offset[link] @ T_link_frame)

    def __setstate__(self, state: dict) -> None:
        """Restore the state. Unpickled arrays are writable, but a robot's must not be."""
        self.__dict__.update(state)
        cached = (*self._chains.values(), *self._moving.values())
        for array in (*state.values(), *self.link_offset.values(), *cached, *(self.narrowed or ())):
            if isinstance(array, np.ndarray):
                array.setflags(write=False)

    def _make_chain(self, link: str) -> NDArray[np.float64]:
        if link not in self.link_row:
            raise UnknownNameError("link", link, self.link_names)
        rows, row = [], self.link_row[link]
        while row != BASE:
            rows.append(self.joints[row])
            row = int(self.joints[row][PARENT])
        chain, offset = np.array(rows[::-1]).reshape(-1, TABLE_WIDTH), self.link_offset[link]
        chain[:, PARENT] = np.arange(len(chain)) - 1
        ends_here = rows and np.array_equal(offset, np.eye(4))
        return frozen(chain, chain.shape) if ends_here else lengthened(chain, offset)


def build_tree(description: Description) -> Tree:
    """Validate a description and convert it to arrays."""
    root, ordered = root_link(description), joints_from_root(description)
    columns = columns_of_q(ordered)
    drives = drives_of(ordered, columns, description.source)
    link_row, link_offset, table = {root: BASE}, {root: np.eye(4)}, []
    for joint in ordered:
        drive = drives[joint.name]
        row, offset = link_row[joint.parent], link_offset[joint.parent] @ joint.origin
        if joint.type != JointType.FIXED and drive.column is None:  # a mimic of a fixed joint
            turn = _turn_z_onto(joint.axis)
            offset = offset @ turn @ motion_along_z(_MOTIONS[joint.type][0][0], drive.offset) @ turn.T
        elif joint.type != JointType.FIXED:
            for joint_row, offset_behind in _motion_rows(joint, drive, row, offset, len(table)):
                table.append(joint_row)
                row, offset = len(table) - 1, offset_behind
        link_row[joint.child], link_offset[joint.child] = row, offset
    names = tuple(link.name for link in description.links)
    lower, upper = (frozen(bound, bound.shape) for bound in bounds_of_q(ordered, drives, hard_bounds)[0])
    soft = np.clip(bounds_of_q(ordered, drives, soft_bounds)[0], lower, upper)
    velocity = velocity_limits_of_q(ordered)
    acceleration, jerk = acceleration_limits_of_q(ordered, drives)
    return Tree(
        name=description.name,
        root=root,
        leaves=leaf_links(description),
        link_names=names,
        joint_names=tuple(columns),
        joint_slices=tuple(columns.values()),
        lower=lower,
        upper=upper,
        soft_lower=frozen(soft[0], lower.shape),
        soft_upper=frozen(soft[1], lower.shape),
        velocity_limits=frozen(velocity, velocity.shape),
        acceleration_limits=frozen(acceleration, velocity.shape),
        jerk_limits=frozen(jerk, velocity.shape),
        effort_limits=frozen(effort_limits_of_q(ordered), velocity.shape),
        joints=frozen(table, (len(table), TABLE_WIDTH)),
        link_row=link_row,
        link_offset={name: frozen(T, (4, 4)) for name, T in link_offset.items()},
        link_frames=frozen([_frame_row(link_row[name], link_offset[name]) for name in names], (len(names), FRAME_WIDTH)),
        followers={
            joint.name: drives[joint.name]
            for joint in ordered
            if joint.mimic is not None and drives[joint.name].column is not None and drives[joint.name].ratio != 0.0
        },
    )


def lengthened(chain: NDArray[np.float64], T_end_frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """A chain with a fixed frame added at its end."""
    return frozen([*chain, _joint_row(T_end_frame, FIXED, Drive(0), len(chain) - 1)], (len(chain) + 1, TABLE_WIDTH))


def row_pose(row: NDArray[np.float64]) -> NDArray[np.float64]:
    """T_parent_joint of a row of a table of joints, shape (4, 4)."""
    return np.vstack([row[:12].reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])


def _motion_rows(joint: Joint, drive: Drive, parent: int, T_parent_joint: NDArray, first_row: int):
    """The table rows of a joint, each with the offset that rotates its frame back to the joint's own axes."""
    to_axis = np.eye(4) if joint.type == JointType.FLOATING else _turn_z_onto(joint.axis)
    for k, (kind, axis, entry) in enumerate(_MOTIONS[joint.type]):
        turn = to_axis if axis is None else to_axis @ _turn_z_onto(axis)
        row = _joint_row(T_parent_joint @ turn, kind, replace(drive, column=drive.column + entry), parent)
        yield row, turn.T
        parent, T_parent_joint = first_row + k, turn.T


def _joint_row(T_parent_joint: NDArray, kind: int, drive: Drive, parent: int) -> NDArray[np.float64]:
    return np.array([*T_parent_joint[:3].ravel(), kind, drive.column, drive.ratio, drive.offset, parent])


def _frame_row(joint_row: int, T_joint_frame: NDArray) -> NDArray[np.float64]:
    return np.array([*T_joint_frame[:3].ravel(), joint_row, np.array_equal(T_joint_frame, np.eye(4))])


def _turn_z_onto(axis: NDArray) -> NDArray[np.float64]:
    """The pose of minimum rotation that takes z to a unit vector; the identity for z itself."""
    T = np.eye(4)
    x, y, z = axis
    square = x * x + y * y
    if square == 0:
        T[:3, :3] = np.diag([1.0, np.sign(z), np.sign(z)])
        return T
    factor = (1 - z) / square if z < 0 else 1 / (1 + z)  # 1 / (1 + z), without the cancellation near z = -1
    T[:3, :3] = [
        [1 - x * x * factor, -x * y * factor, x],
        [-x * y * factor, 1 - y * y * factor, y],
        [-x, -y, z],
    ]
    return T


def motion_along_z(kind: int, position: ArrayLike) -> NDArray[np.float64]:
    """The motion of a joint about or along z, shape (..., 4, 4), at positions (...)."""
    along = np.multiply.outer(position, Z)
    return pose(rpy=along) if kind == REVOLUTE else pose(along)


def entry_names(tree: Tree) -> tuple[str, ...]:
    """A name for every entry of q: the joint's name, with an index if the joint has several entries."""
    parts = [(name, range(tree.n_dof)[cut]) for name, cut in zip(tree.joint_names, tree.joint_slices, strict=True)]
    return tuple(f"{name}[{k}]" if len(cut) > 1 else name for name, cut in parts for k in range(len(cut)))
