"""Plans the motion of a view's arm through waypoints, with straight approaches and retreats, and gripper openings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.structure import joints_below
from ulna.kinematics.positions import columns_of_joints
from ulna.planning.keep import Keep
from ulna.planning.plan import Plan
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot

LONGEST_SEARCH = 0.5  # [s] the time limit of a plan: the page plans again during a drag
ACCELERATION = 3.0  # [rad/s^2 or m/s^2] of every joint
VELOCITY = 1.0  # [rad/s or m/s] of joints without a limit in the description
TILT = float(np.radians(5.0))  # [rad] tolerance of "keep upright"
ASIDE = 0.005  # [m] tolerance of "keep on the line": the distance of the hand from it
Array = NDArray[np.float64]


class Waypoint(NamedTuple):
    """A goal that the motion passes through.

    Attributes:
        goal: A pose of the hand, T_base_hand, shape (4, 4), or a configuration, shape (n_dof,).
        approach, retract: The lengths of the straight approach and retreat along the z axis of the hand [m]; 0 for none.
        opening: The opening of the gripper there, from 0 (closed) to 1 (open); None to leave it as it is.
        moves_gripper: Whether a configuration also sets the joints of the gripper.
    """

    goal: Array
    approach: float = 0.0
    retract: float = 0.0
    opening: float | None = None
    moves_gripper: bool = False


class MotionSettings(NamedTuple):
    """The options with which a motion is planned.

    Attributes:
        link: The hand.
        held: Joints that keep their positions, even if a goal configuration has other values for them.
        jerk: The jerk limit of each joint [rad/s^3 or m/s^3]; None for no limit.
        upright: Whether the direction of the hand that points up at the start is kept upright.
        on_line: Whether the hand is kept on the line to the goal.
    """

    link: str
    held: tuple[str, ...] = ()
    jerk: float | None = None
    upright: bool = False
    on_line: bool = False


class Leg(NamedTuple):
    """One motion between waypoints.

    Attributes:
        start: The first configuration, shape (n_dof,).
        goal: The goal; see ``Waypoint.goal``.
        line: The ends of the line on which the hand is kept [m], shape (2, 3); None if there is none.
        plan: The plan.
        motion: Its timed trajectory; None if there is no path.
    """

    start: Array
    goal: Array
    line: Array | None
    plan: Plan
    motion: Trajectory | None


def gripper_of(robot: Robot, link: str) -> NDArray[np.int64]:
    """The entries of q that move the fingers of a hand: links below it, but not the hand itself."""
    columns = robot.tree.moving_columns
    below = {column for joint in joints_below(robot.description, link) for column in columns(joint.child).tolist()}
    fingers = sorted(below - set(columns(link).tolist()))
    return np.array([k for k in fingers if np.isfinite(robot.upper[k] - robot.lower[k])], dtype=np.int64)


def rates_of(robot: Robot) -> tuple[Array, Array]:
    """The velocity and acceleration limits of a motion on the page, shape (n_dof,) each."""
    most = robot.velocity_limits
    return np.where((most > 0) & (most < np.inf), most, VELOCITY), np.minimum(robot.acceleration_limits, ACCELERATION)


def plan_leg(robot: Robot, start: Array, goal: Array, world: World, settings: MotionSettings) -> Leg:
    """Plan a motion from a configuration to a goal."""
    if goal.ndim == 1 and settings.held:
        goal = np.where(columns_of_joints(robot.tree, settings.held), start, goal)
    link = settings.link
    end = goal if goal.ndim == 2 else robot.forward_kinematics(goal, link=link)
    line = np.stack([robot.forward_kinematics(start, link=link)[:3, 3], end[:3, 3]])
    keeps = [Keep.upright(TILT, link=link)] if settings.upright else []
    if not settings.on_line or np.linalg.norm(line[1] - line[0]) < ASIDE:
        line = None
    else:
        keeps.append(Keep.on_line(*line, within=ASIDE, link=link))
    of_goal = link if goal.ndim == 2 else None
    plan = robot.plan(start, goal, world, link=of_goal, held=settings.held, keep=keeps, time_limit=LONGEST_SEARCH)
    if not plan:
        return Leg(start, goal, line, plan, None)
    velocity, acceleration = rates_of(robot)
    return Leg(start, goal, line, plan, plan.trajectory(velocity=velocity, acceleration=acceleration, jerk=settings.jerk))


def plan_through(
    robot: Robot, start: Array, stops: tuple[Waypoint, ...], world: World, settings: MotionSettings
) -> tuple[list[Leg], int]:
    """Plan the legs through waypoints. Returns the legs and the number of waypoints reached.

    If planning fails, the last leg has no motion.
    """
    legs: list[Leg] = []
    for k, stop in enumerate(stops):
        found = _plan_legs_to(robot, legs[-1].motion.q[-1] if legs and legs[-1].motion else start, stop, world, settings)
        legs += found
        if found[-1].motion is None:
            return legs, k
    return legs, len(stops)


def _plan_legs_to(robot: Robot, start: Array, stop: Waypoint, world: World, settings: MotionSettings) -> list[Leg]:
    """Plan the legs to one waypoint. If planning fails, the last leg has no motion.

    A straight approach is planned backwards from a configuration at the goal, where fewer configurations are possible.
    """
    straight, columns, goal = settings._replace(on_line=True), gripper_of(robot, settings.link), stop.goal.copy()
    if goal.ndim == 1 and not stop.moves_gripper:
        goal[columns] = start[columns]
    legs = [plan_leg(robot, start, goal, world, settings)]
    if legs[0].motion is None:
        return legs
    at = legs[0].motion.q[-1]
    T = robot.forward_kinematics(at, link=settings.link)
    if stop.approach > 0.0:
        back = plan_leg(robot, at, T @ pose((0.0, 0.0, -stop.approach)), world, straight)
        if back.motion is None:
            return [back]
        legs = [plan_leg(robot, start, back.motion.q[-1], world, settings)]
        if legs[0].motion is not None:
            legs.append(plan_leg(robot, back.motion.q[-1], at, world, straight))
        if legs[-1].motion is None:
            return legs
    if stop.opening is not None and len(columns):
        at = at.copy()
        at[columns] = robot.lower[columns] + stop.opening * (robot.upper[columns] - robot.lower[columns])
        legs.append(plan_leg(robot, legs[-1].motion.q[-1], at, world, settings._replace(on_line=False)))  # type: ignore[union-attr]
        if legs[-1].motion is None:
            return legs
    if stop.retract > 0.0:
        legs.append(plan_leg(robot, legs[-1].motion.q[-1], T @ pose((0.0, 0.0, -stop.retract)), world, straight))  # type: ignore[union-attr]
    return legs


def join_legs(legs: list[Leg]) -> Trajectory | None:
    """The motions of all legs as one; None if a leg has none."""
    whole = None
    for leg in legs:
        if leg.motion is None:
            return None
        whole = leg.motion if whole is None else whole.then(leg.motion)
    return whole
