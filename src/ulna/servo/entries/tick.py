"""Computes one tick of a servo: a command that is certified together with a full stop after it.

The state is a position q, a velocity, and a certified braking trajectory: a straight line from q to a position at rest. A tick

1. measures the pairs that are near each other at the end of the braking trajectory;
2. finds the velocity x at the end of the tick that is nearest to the desired one, by a quadratic program (``kernels.servo``);
3. certifies the curve of the tick and the stop after it, both with the escape margin beside them. If x fails, it tries smaller
   shares of the change from the braking trajectory's velocity to x: MAX_TRIES of them, and the others in the next tick;
4. tries an escape if no share is free: a motion that moves no point by more than MAX_ESCAPE and ends farther from everything. It
   is certified with half the clearance and without the escape margin;
5. follows the braking trajectory otherwise.

The *escape margin* is a small distance of each joint [rad or m] on both sides of a motion (``ESCAPE_MARGIN`` in ``servo.servo``).
It is certified with the motion, so that the arm can leave every position in which it stops.

The constraints of step 2 are the box of ``braking`` and one constraint per near pair. The arm must come to rest no nearer than
the clearance and RESERVE, and not much nearer in one tick. The velocity of the braking trajectory satisfies every constraint, so
the quadratic program is always feasible. x is then shortened towards the velocity of the braking trajectory. The arm must not
rest farther from its goal poses than if it stopped now.

An object that may move by itself needs additional distance: its greatest travel since its last reported pose, until the end of
the certified motion.

If an object was put into the arm, step 4 leaves out the pairs in contact: no other pair may come into contact. A motion is
accepted if the deepest pair at its end is less deep than at the end of the braking trajectory.

With a limit of jerk (``kernels.servo.ramped_stop``) x is the velocity that remains if the acceleration ramps down to 0. The stop
is then a line after a bend, and the bend is certified with the tick. If only the braking trajectory keeps the limits, the arm
follows it. The same holds near rest, since it ends at rest after some ticks, and x does not.

So at every moment a braking trajectory is certified. Along it the arm touches nothing that stands still. The arm can leave every
position in which it comes to rest by itself. Either everything within the escape margin is free, or an escape ended there,
farther from everything than before. Certificates use lower bounds of distances. For two boxes a lower bound may be 1 / sqrt(3) of
the distance, which is more than half. So at a distance of the clearance, a small motion away from the object still passes step 4
with half the clearance. At rest nothing is nearer than the clearance. During an escape an object is nearer by MAX_ESCAPE at most,
and never by more than half the clearance.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.entries.carried import carried_by
from ulna.collision.entries.contacts import near_of
from ulna.collision.entries.continuous import edge_is_free, interval_work
from ulna.engine.decorators import entry, kernel, routine, workspace
from ulna.engine.lanes import sqrt
from ulna.engine.records import Records
from ulna.engine.signatures import MATRIX, NUMBERS, TABLE, WHOLE, Array, Group
from ulna.kernels.collision.ball_motion import fastest_ball, world_rounding, write_motion
from ulna.kernels.collision.collision_layout import DISTANCE, PAIR_BODY, PAIR_OTHER, PAIR_WIDTH
from ulna.kernels.collision.contacts import SAME, copy_row, find_near_pairs, write_contact, write_gradient
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import BOXES, SHAPES, Edge, EdgeCheck, Margins, Near, Scene
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.layout import LARGEST
from ulna.kernels.servo.braking import (
    REST_TOLERANCE,
    continue_stop,
    curve_state,
    limit_reached,
    rest_offset,
    stop_is_within_limits,
    stop_velocity,
    travel,
    travel_per_velocity,
    write_stop,
    write_tick,
    write_velocity_box,
)
from ulna.kernels.servo.desired_motion import (
    MIN_TWIST,
    pose_squares,
    relative_error,
    weight_across,
    write_objective,
    write_pulls,
    write_squares,
)
from ulna.kernels.servo.objective import Objective, Program, Steady
from ulna.kernels.servo.pace import (
    MIN_DISTANCE,
    NOT_SLOWED,
    SINGULAR,
    add_return_pull,
    keep_on_line,
    return_weight,
    set_own_pace,
    share_paces,
    some_have_twists,
    tow,
    write_changes,
    write_growth,
    write_pace,
    write_part,
    write_steady,
    write_steady_bounds,
)
from ulna.kernels.servo.quadratic_program import minimize
from ulna.kernels.servo.servo_records import (
    AT_REST,
    BRAKING,
    FOLLOWING,
    HANDS,
    IN_COLLISION,
    LIMITED_BY_ACCELERATION,
    LIMITED_BY_CLEARANCE,
    LIMITED_BY_POSITION,
    MAX_PAIRS,
    MAX_TOUCHING,
    NEAR_SINGULARITY,
    NOT_CERTIFIED,
    REFUSED,
    REST,
    START,
    HandGoal,
    JointLimits,
    JointState,
    MovingObject,
    ServoGoal,
    ServoSettings,
    ServoTables,
    StopCounters,
    TickReport,
)
from ulna.kernels.spatial.elementary import all_in_range

RESOLUTION = 1e-3  # [m]: a motion is refused if intervals in which all points move by less do not decide it
MAX_ESCAPE = 1e-3  # [m]: largest travel of any point in step 4
RESERVE = 2e-3  # [m]: distance beyond the clearance in the quadratic program, so that few intervals certify a motion
NEAR = 0.05  # [m]: beyond the clearance; pairs farther away have no constraint
APPROACH_TIME = 0.05  # [s]: time constant of the approach to the reserve
SHARES = (1.0, 0.5, 0.25, 0.125)
POSE_TOLERANCE = 1e-8  # [m2, rad2]: smaller sums of squared pose errors may grow
MAX_TRIES = 2  # of these shares in a tick
ESCAPE_SHARES = (1.0, 0.125)
MAX_CHORD_ERROR = 1e-4  # [rad or m]: of a bend with a limit of jerk from the chords that certify it
# Also tried if nothing is certified, since very near an object only short motions are free, and with a limit of jerk.
TINY_SHARES = (1.0 / 64, 1.0 / 512)
CONTACT_GAP = 1e-6  # [m]: smaller distances count as contact
MOTION_ROUNDING = 1e-9  # [m]: rounding of the travel of an object
_ESCAPE_CLEARANCE = 0.5  # share of the clearance in step 4; lower bounds of distances are at least 1 / sqrt(3) of them
_RESERVE_WEIGHT = 10.0  # weight of leaving the reserve, relative to that of the command
_FOLLOWING_TOLERANCE = 0.02  # relative error that counts as reached: the damping alone causes it at a singular value of J of 0.07


class Chord(NamedTuple):
    """Chord of a curve, or a line, and the certified distance beside it; shape (n_dof,) each."""

    q_a: NDArray
    """Position where it begins; ``q_b``: where it ends."""
    q_b: NDArray
    spread: NDArray
    """Certified distance beside the chord; ``line_spread``: beside a line."""
    line_spread: NDArray


class Work(NamedTuple):
    """Scratch for the quadratic program of a tick."""

    objective: Objective
    program: Program
    steady: Steady


class Tick(NamedTuple):
    """Inputs, outputs and scratch of a tick."""

    scene: Scene
    carried: NamedTuple
    work: tuple
    object_rounding: float
    near: Near
    gradients: NDArray
    """Gradients of the distances of the near pairs, shape (MAX_PAIRS + 1, n_dof) [m/rad or 1]. The last row is scratch."""
    excess: NDArray
    """Distance of each pair beyond its required distance, and last the smallest of all (``find_near_pairs``)."""
    wider: NDArray
    """Distance beyond the clearance that each object needs (``scene.Margins``) [m]."""
    moving: Records[MovingObject]
    """The objects that may move by themselves, shape (n,)."""
    touching: NDArray
    """The pairs in contact, shape (MAX_TOUCHING, PAIR_WIDTH)."""
    chains: NDArray
    limits: Records[JointLimits]
    settings: ServoSettings
    goal: ServoGoal
    state: Records[JointState]
    counters: StopCounters
    report: TickReport
    x: NDArray
    """Velocities that the quadratic program finds, shape (n_dof,)."""
    tried: NDArray
    """Velocities that are tried, shape (n_dof,)."""
    chord: Chord
    after: Records[JointState]
    """State after the tick that is tried."""
    q: NDArray
    """Position now, shape (n_dof,)."""
    rest: NDArray
    """Position where the braking trajectory ends, shape (n_dof,)."""
    place: NDArray
    """Scratch for a position, shape (n_dof,)."""


_SETTINGS, _STATE, _COUNTERS = Array(ServoSettings, 1, constant=True), Array(JointState, 1), Array(StopCounters, 1)
_GOAL = WHOLE, NUMBERS, NUMBERS, Array(HandGoal, 1)
_WRITTEN = _STATE, _COUNTERS, NUMBERS, Array(MovingObject, 1), Array(TickReport, 1)
_TABLES = Group((TABLE, Array(JointLimits, 1, constant=True), _SETTINGS, *_GOAL, *_WRITTEN), ServoTables)


@entry(*((scene, _TABLES) for scene in (BOXES, SHAPES)))
def servo_tick(scene, tables):
    """Write the state after a tick, and its report; return whether the goal is in range.

    If it is not, nothing is written. For START the state becomes that of the goal. If its stop is not certified, the status is
    REFUSED. tables: ``ServoTables``.
    """
    goal, state = ServoGoal(tables.mode, tables.q, tables.qd, tables.hands), tables.joints
    if not is_goal_in_range(goal):
        return False
    limits, settings, n = tables.limits, tables.settings[0], tables.limits.shape[0]
    scratch = np.empty((9, n))
    tick = Tick(
        scene, carried_by(scene), interval_work(n), world_rounding(scene), bounded_near_of(scene),
        np.empty((MAX_PAIRS + 1, n)), np.empty(MAX_PAIRS + 1), tables.wider, tables.moving,
        np.empty((MAX_TOUCHING, PAIR_WIDTH), np.int64), tables.chains, limits, settings, goal, state,
        tables.counters[0], tables.report[0], scratch[0], scratch[1],
        Chord(scratch[2], scratch[3], scratch[4], scratch[5]), state.copy(), scratch[6], scratch[7], scratch[8],
    )  # fmt: skip
    clear(tick.report)
    if goal.mode == START:
        tick.report.status = start(tick)
        return True
    tick.counters.touching = 0
    if not tick.counters.certified:
        if stop_is_free(tick):
            tick.counters.certified = True
        else:
            find_contacts(tick, near_of(scene, MAX_TOUCHING, tables.wider.shape[0]))
    if goal.mode == REST:
        tick.report.status = brake(tick)
        return True
    work = work_of(n, len(goal.hands) if goal.mode == HANDS else 0)
    ticks = write_velocity_box(state, tick.counters, limits, settings, work.program.box_rows)
    tick.report.status = brake(tick) if ticks < 0 else advance(tick, work, ticks)
    return True


@entry((_STATE, _COUNTERS, _SETTINGS, MATRIX))
def write_stop_positions(state, counters, settings, q_out):
    """Write q after each tick that is left of the braking trajectory.

    Its state and counters become those of its end. q_out: One row per tick that is left.
    """
    for k in range(q_out.shape[0]):
        continue_stop(state, counters[0], settings[0])
        for j in range(q_out.shape[1]):
            q_out[k, j] = state[j].q


@workspace
def bounded_near_of(scene):
    """Allocate the near pairs of a tick, which measures a limited number and bounds the others."""
    of = near_of(scene, MAX_PAIRS, 0)
    return Near(
        of.joint_rows, of.body_rows, of.contact_rows, of.pair_rows, of.last_rows, of.stack, of.heights, np.empty(1), of.planes,
        of.scratch,
    )  # fmt: skip


@workspace
def work_of(n, n_hands):
    """Allocate the scratch for the quadratic program."""
    m, rows = 2 * n + MAX_PAIRS, np.empty((10, n))
    return Work(
        Objective(
            np.empty(n * n), rows[0], np.empty(6 * n * n_hands), np.empty(max(6 * n_hands, n)), np.empty(N_SYSTEM),
            np.empty(6 * n), np.empty(n_hands), np.empty(n_hands), np.empty(n_hands, np.int64),
        ),
        Program(np.empty(2 * n), np.zeros(m * n), np.empty(m), np.empty(n, np.int64), rows[1], np.empty(2 * n * (n + 1))),
        Steady(
            np.empty(n * n), rows[2], np.empty(6 * n * n_hands), rows[3], rows[4], rows[5], rows[6], rows[7],
            np.empty(n * n), rows[8], np.empty(m), np.empty(n, np.int64), rows[9],
        ),
    )  # fmt: skip


@kernel
def is_goal_in_range(goal):
    """Whether all numbers of a goal are finite and not too large."""
    good = all_in_range(goal.q) and all_in_range(goal.qd)
    for i in range(goal.hands.shape[0]):
        hand = goal.hands[i]
        good = good and abs(hand.weight) <= LARGEST and all_in_range(hand.twist) and all_in_range(hand.pose)
    return good


@kernel
def clear(report):
    """Write a report without limits."""
    report.entry, report.body, report.other = -1, -1, -1
    report.share, report.distance, report.bounded = 0.0, np.inf, False


@routine
def find_contacts(tick, own):
    """Find the pairs in contact at the current position, and report the deepest. own: Scratch for them."""
    scene, report, deepest = tick.scene, tick.report, CONTACT_GAP
    near = with_tick_planes(own, tick, own.contact_rows, own.pair_rows)
    near.unseen[0] = np.inf
    write_q(tick.state, tick.place)
    place_bodies(scene.joints, scene.bodies, tick.place, near.joint_rows, near.body_rows)
    n = min(find_near_pairs(scene, 0.0, None, CONTACT_GAP, near, None), MAX_TOUCHING)
    for c in range(n):
        copy_row(near.pair_rows, c, tick.touching, c)
        if near.contact_rows[c, DISTANCE] <= deepest:
            deepest = near.contact_rows[c, DISTANCE]
            report.body, report.other = near.pair_rows[c, PAIR_BODY], near.pair_rows[c, PAIR_OTHER]
            report.distance = deepest
    tick.counters.touching = n
    report.bounded = report.bounded or near.unseen[0] < np.inf


@kernel
def start(tick):
    """Set the state to the position and velocity of the goal; return the status."""
    state = tick.state
    for j in range(tick.limits.shape[0]):
        state[j].q, state[j].qd, state[j].qdd, state[j].behind = tick.goal.q[j], tick.goal.qd[j], 0.0, tick.goal.q[j]
    ticks = write_stop(state, tick.limits, tick.settings)
    tick.counters.ticks, tick.counters.done = ticks, 0
    if not stop_is_within_limits(state, tick.limits, tick.settings, ticks):
        return LIMITED_BY_POSITION
    tick.counters.certified = stop_is_free(tick)
    if not tick.counters.certified:
        return REFUSED
    return status_of_stop(tick.counters)


@kernel
def brake(tick):
    """Step 5: follow the braking trajectory; return the status."""
    continue_stop(tick.state, tick.counters, tick.settings)
    return status_of_stop(tick.counters)


@kernel
def status_of_stop(counters):
    """Status while the arm follows its braking trajectory."""
    if not counters.certified:
        return status_uncertified(counters)
    return AT_REST if counters.done >= counters.ticks else BRAKING


@kernel
def status_uncertified(counters):
    """Status while the braking trajectory is not certified."""
    return IN_COLLISION if counters.touching > 0 else NOT_CERTIFIED


@kernel
def time_left(tick):
    """Time until the braking trajectory ends [s]."""
    return max(tick.counters.ticks - tick.counters.done, 0) * tick.settings.period


@kernel
def widen(tick, time):
    """Write the distance beyond the clearance that objects need, which may move by themselves for some time [s]."""
    wider, of_tree, of_all = tick.wider, 0.0, 0.0
    for i in range(tick.moving.shape[0]):
        way = tick.moving[i].speed * (tick.moving[i].age + time) + MOTION_ROUNDING
        wider[tick.moving[i].number] = way
        of_all = max(of_all, way)
        if tick.moving[i].in_tree:
            of_tree = max(of_tree, way)
    wider[wider.shape[0] - 2], wider[wider.shape[0] - 1] = of_tree, of_all


@routine
def stop_is_free(tick):
    """Whether the rest of the braking trajectory is free in this world."""
    ticks, done = tick.counters.ticks, tick.counters.done
    return rest_is_free(tick, tick.state, ticks, done, 0.0, tick.settings.clearance)


@routine
def is_free(tick, q_a, q_b, spread, margin, time):
    """Whether everything within ``spread`` of a line is certainly free, except for pairs in contact.

    time: Time from now until objects may move [s].
    """
    widen(tick, time)
    margins = Margins(tick.wider, tick.touching[: tick.counters.touching], tick.near.planes)
    check = EdgeCheck(tick.scene, tick.carried, tick.work, tick.object_rounding)
    return edge_is_free(check, Edge(q_a, q_b, spread), RESOLUTION, margin, margins, 0)


@kernel
def advance(tick, work, ticks):
    """Steps 1 to 5, with a stop of so many ticks after this one; return the status."""
    state, counters, settings, limits = tick.state, tick.counters, tick.settings, tick.limits
    objective, program, box_rows = work.objective, work.program, work.program.box_rows
    n, certified = limits.shape[0], counters.certified
    time = max((1 + ticks) * settings.period, time_left(tick))
    write_q(state, tick.q)
    write_rest(state, tick.rest)
    count = measure_near(tick, tick.rest, tick.near, tick.excess, time)
    for c in range(count):
        body, other = tick.near.pair_rows[c, PAIR_BODY], tick.near.pair_rows[c, PAIR_OTHER]
        write_gradient(tick.scene, tick.near.joint_rows, body, other, tick.near.contact_rows, tick.gradients, c)
    least = tick.excess[-1]
    for j in range(n):
        tick.x[j] = min(max(stop_velocity(state, counters, settings, j), box_rows[j]), box_rows[n + j])
    way = travel_per_velocity(settings, ticks)
    m = write_rows(tick, count, way, program)
    write_objective(tick.chains, tick.goal, limits, settings, tick.q, objective)
    found = set_paces(tick, count, work)
    keep_reserve(tick, count, way, objective.h_rows, objective.f_rows)
    k = minimize(objective.h_rows, objective.f_rows, program, m, tick.x)
    for j in range(n):
        tick.x[j] = min(max(tick.x[j], box_rows[j]), box_rows[n + j])
    nearer = limit_pose_error(tick, least)
    miss = relative_error(tick.goal, objective.jacobian_rows, objective.desired_rows, tick.x)
    status = IN_COLLISION
    if counters.touching == 0:
        status = status_of_rows(tick, found, nearer, miss, program, k, ticks)
    share = certified_share(tick, certified, least, time)
    tick.report.share = share
    if share == 0.0:
        continue_stop(state, counters, settings)
    if status == IN_COLLISION:
        return status
    if share < 1.0 and is_moved(tick):
        report_nearest(tick, count)
        return LIMITED_BY_CLEARANCE if certified else NOT_CERTIFIED
    if not certified:
        return NOT_CERTIFIED
    if status == FOLLOWING and counters.done >= counters.ticks:
        return AT_REST
    return status


@routine
def set_paces(tick, count, work):
    """Set the pace of each hand in the objective.

    Return the constraint that holds the steady motion, or -1, and the cause that slows the slowest hand. Goals in joint space
    have no paces. If an object stops a hand, the hand slides along it: then errors across its twist have the same weight as
    errors along it.
    """
    if tick.goal.mode != HANDS:
        return -1, NOT_SLOWED
    objective, steady, hands, limits, settings = work.objective, work.steady, tick.goal.hands, tick.limits, tick.settings
    program, q, across, m = work.program, tick.q, weight_across(hands, limits), 2 * limits.shape[0] + count
    write_steady_bounds(limits, q, tick.excess, RESERVE, steady.bound_rows[:m])
    k = write_steady(objective, program, m, steady)
    if across > 1.0 and is_at_object(tick, k, steady):
        across = 1.0
        write_squares(hands, settings, objective, across)
        k = write_steady(objective, program, m, steady)
    held = -1
    if relative_error(tick.goal, objective.jacobian_rows, objective.desired_rows, steady.x_rows) > _FOLLOWING_TOLERANCE:
        held = strongest_row(steady.active_rows, steady.multiplier_rows, k)
    n_hands, slowest, slowed = objective.pace_rows.shape[0], 1.0, NOT_SLOWED
    time = write_changes(tick.chains, hands, limits, q, objective, steady)
    least = MIN_DISTANCE if write_turns(tick, k, time, steady) else 0.0
    write_growth(hands, objective, steady, program, k, across)
    for hand in range(n_hands):
        write_pace(hands, limits, settings, objective, steady, across, least, hand)
        if some_have_twists(hands, objective):
            write_part(hands, objective, steady, program, k, across, hand)
            set_own_pace(limits, settings, tick.state, objective, steady, hand)
        if across > 1.0:
            keep_on_line(hands, objective, steady, hand)
    share_paces(hands, objective)
    for hand in range(n_hands):
        if objective.slowing_rows[hand] > NOT_SLOWED and objective.pace_rows[hand] < slowest:
            slowest, slowed = objective.pace_rows[hand], objective.slowing_rows[hand]
    pull = return_weight(tick.chains, hands, limits, tick.state, objective, steady)
    write_pulls(limits, settings, q, objective)
    add_return_pull(tick.state, objective, pull)
    return held, slowed


@routine
def write_turns(tick, k, time, steady):
    """Write the derivatives of the gradients of active constraints along the steady motion.

    Return whether a near pair is among them. time: Time of the finite difference [s].
    """
    n, scene, near, found = tick.x.shape[0], tick.scene, tick.near, False
    for a in range(k):
        row = steady.active_rows[a] - 2 * n
        if row >= 0 and not found:
            found = True
            for j in range(n):
                steady.ahead_rows[j] = tick.state[j].rest_q + time * steady.x_rows[j]
            place_bodies(scene.joints, scene.bodies, steady.ahead_rows, near.joint_rows, near.body_rows)
        for j in range(n):
            steady.turn_rows[n * a + j] = 0.0
        if row >= 0:
            body, other, spare = near.pair_rows[row, PAIR_BODY], near.pair_rows[row, PAIR_OTHER], MAX_PAIRS
            write_contact(scene, near.body_rows, body, other, near.scratch, near.contact_rows, spare)
            write_gradient(scene, near.joint_rows, body, other, near.contact_rows, tick.gradients, spare)
            for j in range(n):
                steady.turn_rows[n * a + j] = (tick.gradients[spare, j] - tick.gradients[row, j]) / time
    return found


@kernel
def is_at_object(tick, k, steady):
    """Whether an object of the world holds the steady motion, which has k active constraints."""
    n, found = tick.limits.shape[0], False
    for a in range(k):
        row = steady.active_rows[a] - 2 * n
        found = found or (row >= 0 and tick.near.pair_rows[row, PAIR_OTHER] >= tick.scene.bodies.shape[0])
    return found


@routine
def measure_near(tick, q, near, excess, time):
    """Step 1: find the nearest pairs at q, a time from now [s]; return the number of pairs in ``near``."""
    excess[-1] = NEAR
    widen(tick, time)
    place_bodies(tick.scene.joints, tick.scene.bodies, q, near.joint_rows, near.body_rows)
    margins = Margins(tick.wider, tick.touching[:0], tick.near.planes)
    near.unseen[0] = NEAR
    count = find_near_pairs(tick.scene, tick.settings.clearance, margins, NEAR, near, excess)
    tick.report.bounded = tick.report.bounded or near.unseen[0] < NEAR
    return count


@routine
def smallest_excess(tick, q, time):
    """Smallest distance of a pair beyond its required distance at q, a time from now [s]; at most NEAR.

    Pairs that were not measured, because there are too many, count with a lower bound of their distance.
    """
    near, excess = tick.near, tick.excess[-1:]
    none = with_tick_planes(near, tick, near.contact_rows[-1:], near.pair_rows[:0])
    measure_near(tick, q, none, excess, time)
    return min(excess[-1] - SAME, none.unseen[0])


@kernel
def with_tick_planes(near, tick, contact_rows, pair_rows):
    """Near pairs with these rows, and with the planes and the bound of the tick."""
    return Near(
        near.joint_rows, near.body_rows, contact_rows, pair_rows, near.last_rows, near.stack,
        near.heights, tick.near.unseen, tick.near.planes, near.scratch,
    )  # fmt: skip


@kernel
def is_moved(tick):
    """Whether the velocity x is not that of rest."""
    moved = False
    for j in range(tick.x.shape[0]):
        moved = moved or abs(tick.x[j]) > REST_TOLERANCE * tick.limits[j].acceleration * tick.settings.period
    return moved


@kernel
def write_rows(tick, count, way, program):
    """Write the constraints of the quadratic program, first the box; return their number.

    After a tick that ends with x the arm rests at c + way x. Constraint i limits how much nearer pair i may be there than at the
    end of the braking trajectory. A pair in contact may become as deep as the deepest pair is. The velocity at which the
    quadratic program starts satisfies all constraints.
    """
    n, h, deepest = tick.x.shape[0], tick.settings.period, tick.excess[nearest_of(tick, count)]
    box_rows, normal_rows, bound_rows = program.box_rows, program.normal_rows, program.bound_rows
    for j in range(n):
        tick.tried[j] = rest_offset(tick.state, tick.settings, j)  # tried is overwritten before it is read
        normal_rows[n * j + j], bound_rows[j] = 1.0, box_rows[j]
        normal_rows[n * (n + j) + j], bound_rows[n + j] = -1.0, -box_rows[n + j]
    for i in range(count):
        least = deepest if tick.counters.touching > 0 and tick.near.contact_rows[i, DISTANCE] <= CONTACT_GAP else RESERVE
        r, at, by = 2 * n + i, -h / (h + APPROACH_TIME) * max(tick.excess[i] - least, 0.0), 0.0
        for j in range(n):
            g = tick.gradients[i, j]
            normal_rows[n * r + j] = g
            at += g * tick.tried[j]
            by += g * tick.x[j]
        bound_rows[r] = min(at / way, by)
    return 2 * n + count


@kernel
def keep_reserve(tick, count, way, h_rows, f_rows):
    """Add a term to the objective that moves pairs out of the reserve, if a motion is desired.

    Constraints are linear, so along a curved path pairs get into the reserve. Of pairs in contact only the deepest is moved out.
    """
    n, h, sought = tick.x.shape[0], tick.settings.period, 0.0
    for j in range(n):
        sought = max(sought, abs(f_rows[j]))
    if sought < MIN_TWIST:
        return
    deepest = nearest_of(tick, count)
    for i in range(count):
        if tick.counters.touching > 0 and i != deepest:
            continue
        inside = RESERVE - tick.excess[i]
        if inside > 0.0:
            out, square = inside * h / (h + APPROACH_TIME) / way, 1e-300
            for j in range(n):
                square += tick.gradients[i, j] * tick.gradients[i, j]
            for j in range(n):
                g = _RESERVE_WEIGHT * tick.gradients[i, j] / square
                f_rows[j] += g * out
                for k in range(n):
                    h_rows[n * j + k] += g * tick.gradients[i, k]


@kernel
def limit_pose_error(tick, least):
    """Shorten x until the arm would rest no farther from its goal poses than if it stopped now.

    Return the share that is left of the change from the braking trajectory's velocity to x.
    """
    if tick.goal.mode != HANDS or tick.counters.touching > 0 or least < RESERVE:
        return 1.0
    most, kept = max(pose_squares(tick.chains, tick.goal.hands, tick.rest), POSE_TOLERANCE), 0.0
    for share in SHARES:
        if kept == 0.0:
            write_share(tick, share)
            write_tick(tick.tried, tick.state, tick.limits, tick.settings, tick.after)
            write_rest(tick.after, tick.place)
            if pose_squares(tick.chains, tick.goal.hands, tick.place) <= most:
                kept = share
    write_share(tick, kept)
    for j in range(tick.x.shape[0]):
        tick.x[j] = tick.tried[j]
    return kept


@kernel
def write_share(tick, share):
    """Write the velocity to try: a share of the change from the braking trajectory's velocity to x."""
    for j in range(tick.x.shape[0]):
        stop = stop_velocity(tick.state, tick.counters, tick.settings, j)
        tick.tried[j] = tick.x[j] if share == 1.0 else stop + share * (tick.x[j] - stop)


@kernel
def certified_share(tick, certified, least, time):
    """Steps 3 and 4: accept the largest certified share and return it; 0 if no share is certified."""
    clearance, first = tick.settings.clearance, tick.counters.next_share
    if tick.settings.ramp > 0.0 and certified and is_nearly_at_rest(tick):
        return 0.0
    if certified:
        for i in range(first, first + MAX_TRIES):
            if is_candidate(tick, SHARES[i], 1.0, clearance):
                tick.counters.next_share = next_share(first, i)
                accept(tick)
                return SHARES[i]
        tick.counters.next_share = next_share(first, -1)
    for share in ESCAPE_SHARES:
        if is_escape(tick, share, _ESCAPE_CLEARANCE * clearance if certified else 0.0, least, time):
            accept(tick)
            return share
    if not certified or tick.settings.ramp > 0.0:
        for share in TINY_SHARES:
            if is_escape(tick, share, _ESCAPE_CLEARANCE * clearance if certified else 0.0, least, time):
                accept(tick)
                return share
    return 0.0


@kernel
def next_share(first, found):
    """Index of the share that the next tick tries first: the one above the share that was found.

    found: -1 for none; then the other shares follow, and then all again.
    """
    if found < 0:
        return MAX_TRIES if first == 0 else 0
    return min(max(found - 1, 0), len(SHARES) - MAX_TRIES)


@routine
def is_escape(tick, share, margin, least, time):
    """Step 4: whether a share of the change to x is certified with a margin and ends farther away.

    ``least``: The smallest excess of all pairs at its end must be greater than this.
    """
    if not is_short(tick, share):
        return False
    write_rest(tick.after, tick.place)
    return smallest_excess(tick, tick.place, time) > least and is_candidate(tick, share, 0.0, margin)


@kernel
def is_short(tick, share):
    """Whether a share of the change to x moves no point by more than MAX_ESCAPE until rest."""
    state, limits, settings, chord = tick.state, tick.limits, tick.settings, tick.chord
    write_share(tick, share)
    ticks = write_tick(tick.tried, state, limits, settings, tick.after)
    for j in range(tick.x.shape[0]):
        chord.q_a[j], chord.line_spread[j] = state[j].q, limits[j].tracking_error
        chord.q_b[j] = chord.q_a[j] + travel(state, tick.after, settings, ticks, j)
    return longest_travel(tick, chord) <= MAX_ESCAPE


@routine
def is_candidate(tick, share, escape_factor, margin):
    """Whether a share of the change to x is within all limits and certified."""
    state, limits, settings = tick.state, tick.limits, tick.settings
    write_share(tick, share)
    ticks = write_tick(tick.tried, state, limits, settings, tick.after)
    return stop_is_within_limits(tick.after, limits, settings, ticks) and rest_is_free(
        tick, tick.after, ticks, -1, escape_factor, margin
    )


@routine
def rest_is_free(tick, state, ticks, done, escape_factor, margin):
    """Whether the rest of a stop of so many ticks is certainly free.

    done: The number of its ticks that are over; -1 includes the tick before it. A stop is a line, with a limit of jerk after a
    bend. The bend and the tick are certified along chords of equal durations t. With accelerations of at most a, q is no farther
    than a t^2 / 8 from its chord. Objects may move until the end of the curve, and of the stop.
    """
    chord, h, bend = tick.chord, tick.settings.period, 2 * int(tick.settings.ramp)
    n, most, left = tick.x.shape[0], 0.0, (bend if ticks > 0 else 0) - done
    for j in range(n):
        chord.line_spread[j] = tick.limits[j].tracking_error + escape_factor * tick.limits[j].escape_margin
        chord.q_b[j] = tick.state[j].q if done < 0 else state[j].q
        if left > 0:
            before = tick.state[j].qdd
            most = max(most, abs(curve_state(state, tick.settings, ticks, before, (done + left) * h, j)[1]))
            most = max(most, abs(curve_state(state, tick.settings, ticks, before, done * h, j)[1]))
            if done < 0:
                most = max(most, abs(state[j].qdd))
    if left > 0:
        chords = int(left * h * sqrt(most / (8.0 * MAX_CHORD_ERROR))) + 1
        length = left * h / chords
        for i in range(chords):
            write_chord(tick, state, ticks, done * h + i * length, length)
            if not is_free(tick, chord.q_a, chord.q_b, chord.spread, margin, left * h):
                return False
        if ticks == 0:  # the tick ends at rest
            return True
    write_rest(state, tick.place)
    return is_free(tick, chord.q_b, tick.place, chord.line_spread, margin, max(ticks - done, 0) * h)


@kernel
def write_q(state, q_out):
    """Write the position of a state."""
    for j in range(state.shape[0]):
        q_out[j] = state[j].q


@kernel
def write_rest(state, q_out):
    """Write the position where the stop of a state ends."""
    for j in range(state.shape[0]):
        q_out[j] = state[j].rest_q


@kernel
def write_chord(tick, state, ticks, begin, length):
    """Write the next chord of a curve, from the end of the last one, and the certified distance beside it."""
    chord, end = tick.chord, begin + length
    for j in range(tick.x.shape[0]):
        before, chord.q_a[j] = tick.state[j].qdd, chord.q_b[j]
        _, first = curve_state(state, tick.settings, ticks, before, begin, j)
        chord.q_b[j], last = curve_state(state, tick.settings, ticks, before, end, j)
        most = max(abs(first), abs(last))
        if begin < 0.0 < end:
            most = max(most, abs(state[j].qdd))
        chord.spread[j] = chord.line_spread[j] + 0.125 * length * length * most * (1.0 + 1e-9)


@kernel
def longest_travel(tick, line):
    """Upper bound of the travel of any point of the robot along a line [m]."""
    write_motion(tick.scene.joints, line.q_a, line.q_b, line.line_spread, tick.carried)
    return fastest_ball(tick.scene.joints, tick.carried)


@kernel
def accept(tick):
    """Make the state after the tried tick the current state."""
    state, after = tick.state, tick.after
    tick.counters.ticks, tick.counters.done = write_tick(tick.tried, state, tick.limits, tick.settings, after), 0
    for j in range(tick.x.shape[0]):
        state[j] = after[j]
    tow(state)


@kernel
def status_of_rows(tick, found, nearer, miss, program, k, ticks):
    """Report the limit of the velocity that was found: the steady motion, or the active constraint with the largest multiplier.

    found: The result of ``set_paces``.
    """
    held, slowed = found
    if miss <= _FOLLOWING_TOLERANCE:
        return FOLLOWING
    if held >= 0:
        return LIMITED_BY_CLEARANCE if write_row(tick, held) else LIMITED_BY_POSITION
    if slowed > NOT_SLOWED:
        tick.report.entry = slowed  # -1 near a singularity
        return NEAR_SINGULARITY if slowed == SINGULAR else LIMITED_BY_ACCELERATION
    row = strongest_row(program.active_rows, program.multiplier_rows, k)
    if row < 0 or nearer < 1.0:
        return NEAR_SINGULARITY
    if write_row(tick, row):
        return LIMITED_BY_CLEARANCE
    return limit_reached(program.box_rows[row], tick.state, tick.limits, tick.settings, ticks, row % tick.x.shape[0])


@kernel
def strongest_row(active_rows, multiplier_rows, k):
    """Active constraint with the largest multiplier, of k; -1 if no multiplier is positive."""
    most, row = 0.0, -1
    for a in range(k):
        if multiplier_rows[a] > most:
            most, row = multiplier_rows[a], active_rows[a]
    return row


@kernel
def write_row(tick, row):
    """Report a constraint: its pair or its entry of q. Return whether it is that of a pair."""
    n = tick.x.shape[0]
    if row >= 2 * n:
        write_pair(tick, row - 2 * n)
        return True
    tick.report.entry = row % n
    return False


@kernel
def is_nearly_at_rest(tick):
    """Whether the arm is to stop and is nearly at rest.

    Then it follows the braking trajectory, which ends at rest.
    """
    state, limits, h, nearly = tick.state, tick.limits, tick.settings.period, not is_moved(tick)
    for j in range(tick.x.shape[0]):
        nearly = nearly and abs(state[j].qd) <= limits[j].acceleration * h
        nearly = nearly and abs(state[j].qdd) <= limits[j].jerk * h
    return nearly


@kernel
def report_nearest(tick, count):
    """Report the pair that is nearest at the end of the braking trajectory."""
    if count > 0:
        write_pair(tick, nearest_of(tick, count))


@kernel
def nearest_of(tick, count):
    """Near pair with the smallest excess; 0 without any."""
    nearest = 0
    for i in range(1, count):
        if tick.excess[i] < tick.excess[nearest]:
            nearest = i
    return nearest


@kernel
def write_pair(tick, i):
    """Report near pair i."""
    report, near = tick.report, tick.near
    report.entry, report.body, report.other = -1, near.pair_rows[i, PAIR_BODY], near.pair_rows[i, PAIR_OTHER]
    report.distance = near.contact_rows[i, DISTANCE]
