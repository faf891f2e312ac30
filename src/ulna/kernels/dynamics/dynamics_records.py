"""Defines the arguments and workspaces of the kernels of dynamics."""

from typing import NamedTuple

from numpy.typing import NDArray

MOTION_WIDTH = 9  # rows per frame: its angular velocity and acceleration, and the acceleration of its origin


class Mechanism(NamedTuple):
    """A robot's joints and the inertias that they carry."""

    joints: NDArray
    """The table of joints, shape (n, TABLE_WIDTH); parents come before their children."""
    bodies: NDArray
    """The table of inertias, shape (n, INERTIA_WIDTH): the body that each joint carries, in the frame of the joint."""


class State(NamedTuple):
    """The motion of all joints, in rows."""

    turns: NDArray
    """Two rows for each joint, the output of ``joint_turns`` for q."""
    rates: NDArray
    """The velocity of each entry of q [rad/s or m/s]."""
    accelerations: NDArray
    """The acceleration of each entry of q [rad/s^2 or m/s^2]."""


class ForceRows(NamedTuple):
    """The workspaces of ``newton_euler``, in rows."""

    motions: NDArray
    """The motion of the base and of each joint's frame, nine rows each."""
    poses: NDArray
    """The pose of each joint in the frame of its parent, twelve rows each."""
    wrenches: NDArray
    """The wrench that each joint carries, in its own frame, six rows each."""


class FallRows(NamedTuple):
    """The workspaces of ``holding_torques``, in rows."""

    poses: NDArray
    """The pose of each joint in the frame of its parent, twelve rows each."""
    falls: NDArray
    """The gravitational acceleration in the frame of the base and of each joint, three rows each."""
    moments: NDArray
    """The first moment that each joint carries, in its frame, three rows each."""
    masses: NDArray
    """The mass that each joint carries, one row each."""


class BodyRows(NamedTuple):
    """The bodies of a robot in the frame of its base, in rows."""

    poses: NDArray
    """The pose of each joint, twelve rows each."""
    twists: NDArray
    """The twist of each joint for a unit rate of its entry of q, six rows each."""
    inertias: NDArray
    """The inertia that each joint carries, ten rows each."""


class RateRows(NamedTuple):
    """The workspaces of the derivatives of torques: six rows for each joint, in the frame of the base."""

    motions: NDArray
    """The motion of the joint's body."""
    accelerations: NDArray
    """The acceleration of the joint's body minus the gravitational acceleration."""
    twist_rates: NDArray
    """The rate S' of the joint's twist."""
    twist_accelerations: NDArray
    """The second rate S'' of the joint's twist."""
    momenta: NDArray
    """The momentum of the joint's subtree."""
    wrenches: NDArray
    """The wrench on the joint's subtree."""
    coriolis: NDArray
    """The symmetric part of the Coriolis matrix of the joint's subtree: xx, xy, xz, yy, yz, zz."""
