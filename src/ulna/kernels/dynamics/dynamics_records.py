"""Names the arguments of the kernels of dynamics, and the rows that they work in."""

from typing import NamedTuple

from numpy.typing import NDArray

MOTION_WIDTH = 9  # rows of a frame: its angular velocity and acceleration, and the acceleration of its origin


class Mechanism(NamedTuple):
    """A robot's joints and what they carry."""

    joints: NDArray
    """The table of joints, shape (n, TABLE_WIDTH); parents come before their children."""
    bodies: NDArray
    """The table of inertias, shape (n, INERTIA_WIDTH): the body that each joint carries, in the frame of the joint."""


class State(NamedTuple):
    """The motion of all joints, in rows."""

    turns: NDArray
    """Two for each joint, which ``joint_turns`` wrote for q."""
    rates: NDArray
    """The velocity of each entry of q [rad/s or m/s]."""
    accelerations: NDArray
    """The acceleration of each entry of q [rad/s^2 or m/s^2]."""


class ForceRows(NamedTuple):
    """Where ``newton_euler`` works, in rows."""

    motions: NDArray
    """Nine for the base and for each joint."""
    poses: NDArray
    """Twelve for each joint: its pose in the frame of its parent."""
    wrenches: NDArray
    """Six for each joint: what it carries, in its own frame."""


class FallRows(NamedTuple):
    """Where ``holding_torques`` works, in rows."""

    poses: NDArray
    """Twelve for each joint: its pose in the frame of its parent."""
    falls: NDArray
    """Three for the base and for each joint: the acceleration of free fall in its frame."""
    moments: NDArray
    """Three for each joint: the moment of what it carries, in its frame."""
    masses: NDArray
    """One for each joint: the mass of what it carries."""


class BodyRows(NamedTuple):
    """The bodies of a robot in the frame of its base, in rows."""

    poses: NDArray
    """Twelve for each joint."""
    twists: NDArray
    """Six for each joint: the motion of what it carries for a unit rate of its entry of q."""
    inertias: NDArray
    """Ten for each joint: the inertia of what it carries."""


class RateRows(NamedTuple):
    """Where the derivatives of torques are computed, in rows: six for each joint, in the frame of the base, unless it is said."""

    motions: NDArray
    """The motion of its body."""
    accelerations: NDArray
    """The acceleration of its body, less that of free fall."""
    twist_rates: NDArray
    """The rate of its twist."""
    twist_accelerations: NDArray
    """The second rate of its twist, as its parent moves."""
    momenta: NDArray
    """The momentum of what it carries."""
    wrenches: NDArray
    """The wrench on what it carries."""
    coriolis: NDArray
    """The symmetric part of the Coriolis matrix of what it carries: xx, xy, xz, yy, yz, zz."""
