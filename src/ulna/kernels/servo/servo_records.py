"""Names what a servo is given, what it keeps from tick to tick, and what a tick reports."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record, Records

# Modes of a tick. START sets the state and certifies its stop.
START, REST, VELOCITY, POSITION, HANDS = 0, 1, 2, 3, 4
# Statuses of a tick, in the order of ``servo.command.CommandStatus``; REFUSED: the stop that a START asks for is not certified.
FOLLOWING, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY, LIMITED_BY_ACCELERATION, LIMITED_BY_JERK = 0, 1, 2, 3, 4
LIMITED_BY_CLEARANCE, NEAR_SINGULARITY, BRAKING, AT_REST, NOT_CERTIFIED, IN_COLLISION, OFF_COMMAND = 5, 6, 7, 8, 9, 10, 11
LIMITED_BY_TORQUE, REFUSED = 12, 13
MAX_PAIRS = 24  # that the quadratic program has rows for: the nearest
MAX_TOUCHING = 64  # pairs in contact that may be led out of


class ServoSettings(Record):
    """Settings of a servo, which are only read."""

    period: float
    """Length of a tick [s]."""
    clearance: float
    """Smallest distance from an object that is allowed [m]."""
    damping: float
    """Weight of the damping, lambda."""
    pull: float
    """Rate of the pull towards the posture [1/s]; 0 for none."""
    ramp: float
    """Number of ticks in which an acceleration may rise from 0 to its limit, a whole number; 0 without limits of jerk."""
    lag: float
    """Time after which the desired velocity is reached [s]."""


class JointLimits(Record):
    """Limits of one joint, and what else a servo knows of it [rad or m]."""

    lower: float
    """Its lowest position; ``upper``: its highest."""
    upper: float
    speed: float
    """Its greatest speed [rad/s or m/s]; 0 for a joint that is held."""
    acceleration: float
    """Its greatest acceleration [rad/s^2 or m/s^2]; ``jerk``: its greatest jerk [rad/s^3 or m/s^3], 0 without limits."""
    jerk: float
    tracking_error: float
    """Greatest distance of the arm from its command that is allowed."""
    room: float
    """Distance beside a motion within which all is certified too, so that there is room to leave."""
    posture: float
    """Position towards which it is pulled."""


class HandGoal(Record):
    """Goal of one hand."""

    first: int
    """First row of its chain in the table of all chains; ``end``: the row after its last."""
    end: int
    is_pose: bool
    """Whether a pose is given, not a twist."""
    frame: int
    """Frame of the twist."""
    weight: float
    """Weight of the error."""
    twist: Annotated[NDArray[np.float64], 6]
    """v [m/s] and w [rad/s], in ``frame``."""
    pose: Annotated[NDArray[np.float64], 12]
    """The rows of T_base_hand."""


class JointState(Record):
    """State of one joint: its last command, and its certified stop."""

    q: float
    """Position now [rad or m]; ``qd`` and ``qdd``: velocity and acceleration now."""
    qd: float
    qdd: float
    start_q: float
    """Position where the stop begins; ``start_qd``: velocity there; ``start_qdd``: acceleration there, with limits of jerk."""
    start_qd: float
    start_qdd: float
    rest_q: float
    """Position where the stop ends."""
    behind: float
    """Place on the way by which the arm came, as far behind it as a rope is long that tows it (``pace``)."""


class StopCounters(Record):
    """Counters of a servo."""

    ticks: int
    """Number of ticks of the certified stop; ``done``: number of these that are over."""
    done: int
    certified: bool
    """Whether the stop is certified in the world as it is."""
    touching: int
    """Number of pairs in contact; they are counted only where the stop is not certified."""
    next_share: int
    """Index of the share of a motion that is tried first."""


class MovingObject(Record):
    """An object that may move by itself."""

    number: int
    """Its number among the objects."""
    speed: float
    """Its greatest speed [m/s]."""
    age: float
    """Time since its pose was stated [s]."""
    in_tree: bool
    """Whether it is in the BVH."""


class TickReport(Record):
    """Report of a tick: its status, and the limit that holds it."""

    status: int
    """A status, as above."""
    share: float
    """Share of the velocity found that was certified."""
    bounded: bool
    """Whether so much is near that not all of it was measured (``Near.unseen``)."""
    entry: int
    """Entry of q that limits it; -1 for none."""
    body: int
    """First body of the pair that limits it, -1 for none; ``other``: the second, or an object."""
    other: int
    distance: float
    """Distance of that pair where the arm would rest [m]; infinite without a pair."""


class ServoGoal(NamedTuple):
    """Goal of a tick."""

    mode: int
    """Mode of the tick: START, REST, VELOCITY, POSITION or HANDS."""
    q: NDArray
    """Joint positions for POSITION and START, shape (n_dof,)."""
    qd: NDArray
    """Joint velocities for VELOCITY and START, shape (n_dof,)."""
    hands: Records[HandGoal]
    """Goals of the hands for HANDS, one for each that is not free."""


class ServoTables(NamedTuple):
    """Inputs and outputs of a tick besides the scene. The entry takes it whole: a second tuple takes 0.6 us more.

    The first three are only read and stay the same. Then comes the goal (``ServoGoal``), and then what is written.
    """

    chains: NDArray
    """Chains of all hands, one after the other."""
    limits: Records[JointLimits]
    """Shape (n_dof,)."""
    settings: Records[ServoSettings]
    """Shape (1,)."""
    mode: int
    q: NDArray
    qd: NDArray
    hands: Records[HandGoal]
    joints: Records[JointState]
    """Shape (n_dof,)."""
    counters: Records[StopCounters]
    """Shape (1,)."""
    wider: NDArray
    """Zeros, two more than there are objects: by how much farther away each has to be [m]."""
    moving: Records[MovingObject]
    """The objects that may move by themselves."""
    report: Records[TickReport]
    """Shape (1,)."""
