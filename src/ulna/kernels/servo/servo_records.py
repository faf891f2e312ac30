"""Defines the records of a servo: settings, goals, the state kept between ticks, and the report of a tick."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record, Records

# Modes of a tick. START sets the state and certifies its stop.
START, REST, VELOCITY, POSITION, HANDS = 0, 1, 2, 3, 4
# Statuses of a tick, in the order of ``servo.command.CommandStatus``; REFUSED: the stop of a START is not certified.
FOLLOWING, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY, LIMITED_BY_ACCELERATION, LIMITED_BY_JERK = 0, 1, 2, 3, 4
LIMITED_BY_CLEARANCE, NEAR_SINGULARITY, BRAKING, AT_REST, NOT_CERTIFIED, IN_COLLISION, OFF_COMMAND = 5, 6, 7, 8, 9, 10, 11
LIMITED_BY_TORQUE, REFUSED = 12, 13
MAX_PAIRS = 24  # near pairs with a constraint in the quadratic program: the nearest
MAX_TOUCHING = 64  # pairs in contact that the arm can be led out of


class ServoSettings(Record):
    """Settings of a servo; constant."""

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
    """Limits of one joint, and its other constants [rad or m]."""

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
    escape_margin: float
    """Distance beside a motion that is certified too, so that the arm can leave every stop."""
    posture: float
    """Position of the posture that pulls the joint."""


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
    """State of one joint: its last command, and its certified braking trajectory."""

    q: float
    """Position now [rad or m]; ``qd`` and ``qdd``: velocity and acceleration now."""
    qd: float
    qdd: float
    start_q: float
    """Position where the braking trajectory begins; ``start_qd``: velocity; ``start_qdd``: acceleration, with limits of jerk."""
    start_qd: float
    start_qdd: float
    rest_q: float
    """Position where the braking trajectory ends."""
    behind: float
    """Position on the path by which the arm came, towed behind it as by a rope (``pace``)."""


class StopCounters(Record):
    """Counters of a servo."""

    ticks: int
    """Number of ticks of the braking trajectory; ``done``: number of these that are over."""
    done: int
    certified: bool
    """Whether the braking trajectory is certified in the current world."""
    touching: int
    """Number of pairs in contact; counted only while the braking trajectory is not certified."""
    next_share: int
    """Index of the share of a motion that is tried first."""


class MovingObject(Record):
    """Object that may move by itself."""

    number: int
    """Its number among the objects."""
    speed: float
    """Its greatest speed [m/s]."""
    age: float
    """Time since its last reported pose [s]."""
    in_tree: bool
    """Whether it is in the BVH."""


class TickReport(Record):
    """Report of a tick: its status, and the limit that holds the arm."""

    status: int
    """A status, as above."""
    share: float
    """Share of the velocity change that was certified."""
    bounded: bool
    """Whether some near solids were bounded instead of measured (``Near.unseen``)."""
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
    """Inputs and outputs of a tick besides the scene, as one tuple: a second tuple would take 0.6 us more.

    The first three are constant. Then comes the goal (``ServoGoal``), and then the arrays that a tick writes to.
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
    """Distance beyond the clearance that each object needs [m]; two more entries than objects. Zeros at first."""
    moving: Records[MovingObject]
    """The objects that may move by themselves."""
    report: Records[TickReport]
    """Shape (1,)."""
