"""Computes one tick of a servo: a command, and a full stop after it, that are certified free.

The state is a position q, a velocity, and a certified stop: a straight line from q to a place where the arm rests. A tick

1. measures the pairs that are near where the certified stop ends;
2. finds the velocity x at the end of the tick that is nearest to what is desired, by a quadratic program (``kernels.servo``).
   Its rows are the box of ``braking`` and one row a near pair: the place where the arm would rest after this tick comes no
   nearer than the clearance and RESERVE, nor much nearer in one tick. No row excludes a velocity that is known to be in the
   box, so that there is always a solution. Of the way from the certified stop's velocity to x it keeps the share after which
   the arm would not rest farther from the poses it is sent to than after the certified stop;
3. certifies the curve of the tick and the stop after it, both with ROOM beside them, for x, and then for smaller shares of the
   way from the certified stop's velocity to x: TRIES of them, and the others in the next tick, so that no tick takes long;
4. tries, if none of them is free, without that room and with half the clearance, and takes what leads by a short way, HOP, to a
   place that is farther from everything;
5. goes on with the certified stop otherwise.

An object that may move by itself has to be farther away by all that it can move from when it was said where it is until the end
of what is certified: of the tick, or of the stop.

Where an object was put into the arm, the pairs in contact are left out of step 4: no other one may come into contact. A motion is
taken that ends with the deepest of all pairs less deep than where the certified stop ends.

With a limit of jerk (``kernels.servo.ramped_stop``) x is the velocity that is left if the acceleration ends, and the stop is a
line after a bend, which is certified with the tick. If only the certified stop keeps the limits, it goes on, and so it does near
rest, since it comes to rest after some ticks and x does not.

So at every moment a stop is certified in which nothing is hit that does not move. There is a way out of every place where the arm
comes to rest by itself: all within ROOM of it is free, or it is farther from everything than such a place. A certificate knows
distances by lower bounds alone, which for two boxes may be 1 / sqrt(3) of them; with half the clearance, and ROOM as it is, a
small motion away passes step 4 nevertheless. So nothing is nearer than the clearance where the arm comes to rest, and on the way
there it is nearer by HOP at most, and never by more than half.
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
from ulna.kernels.collision.scene import BOXES, SHAPES, Apart, Edge, EdgeCheck, Near, Scene
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.layout import LARGEST
from ulna.kernels.servo.braking import (
    STILL,
    beyond_rest_of_zero,
    curve_moment,
    go_on_stopping,
    limit_reached,
    stop_keeps,
    stop_velocity,
    travel,
    way_to_rest,
    write_stop,
    write_tick,
    write_velocity_box,
)
from ulna.kernels.servo.desired_motion import (
    SMALL,
    across_of,
    missed,
    pose_squares,
    write_objective,
    write_pulls,
    write_squares,
)
from ulna.kernels.servo.objective import Objective, Program, Steady
from ulna.kernels.servo.pace import (
    BLURRED,
    NOT_SLOWED,
    SINGULAR,
    add_pull,
    are_apart,
    keep_on_line,
    pull_of_way_back,
    set_apart,
    share_paces,
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

RESOLUTION = 1e-3  # [m]: a motion is refused if something in it is not decided by intervals in which all moves by less
HOP = 1e-3  # [m]: the longest way of any point in step 4
RESERVE = 2e-3  # [m]: how much farther than the clearance the quadratic program stays, so that few intervals certify a motion
WITHIN = 0.05  # [m]: beyond the clearance; pairs farther away have no row
EASE = 0.05  # [s]: the time constant of the approach to the reserve
SHARES = (1.0, 0.5, 0.25, 0.125)
NEARBY = 1e-8  # [m2, rad2]: where the squares of the pose errors are below it, they may grow
TRIES = 2  # of these in a tick
NARROW_SHARES = (1.0, 0.125)
BESIDE = 1e-4  # [rad or m]: a bend with a limit of jerk is certified along chords from which no joint is farther
# Tried too where nothing is certified, since very near an object only short ways are free, and with a limit of jerk.
SMALLEST_SHARES = (1.0 / 64, 1.0 / 512)
GRAZE = 1e-6  # [m]: what is no farther apart is in contact
MOVED = 1e-9  # [m]: what rounding may add to how far an object has moved
_LEAVING = 0.5  # of the clearance: certified in step 4. The lower bounds of distances are at least 1 / sqrt(3) of them
_OUTWARD = 10.0  # the weight of leaving the reserve, beside that of the command
_SAME = 0.02  # of what is desired: it is reached. The damping alone takes so much of a twist where J has a singular value of 0.07


class Chord(NamedTuple):
    """A chord of a curve, or a line, and how far beside it all is certified, shape (n_dof,) each."""

    q_a: NDArray
    """Where it begins; ``q_b``: where it ends."""
    q_b: NDArray
    spread: NDArray
    """Distance beside the chord within which all is certified; ``line_spread``: beside a line."""
    line_spread: NDArray


class Work(NamedTuple):
    """Room for the quadratic program of a tick."""

    objective: Objective
    program: Program
    steady: Steady


class Tick(NamedTuple):
    """All that a tick reads and writes."""

    scene: Scene
    carried: NamedTuple
    work: tuple
    of_world: float
    near: Near
    gradients: NDArray
    """Gradients of the distances of the near pairs, shape (MAX_PAIRS + 1, n_dof) [m/rad or 1]. The last row is room."""
    excess: NDArray
    """How much farther each is apart than it has to be, and last the least of all (``find_near_pairs``)."""
    wider: NDArray
    """By how much more than the clearance each object has to be away (``scene.Apart``) [m]."""
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
    """The velocities that the quadratic program finds, shape (n_dof,)."""
    tried: NDArray
    """Those that are tried."""
    chord: Chord
    after: Records[JointState]
    """The state after the tick that is tried."""
    q: NDArray
    """Position now, shape (n_dof,)."""
    rest: NDArray
    """Where the certified stop ends, shape (n_dof,)."""
    place: NDArray
    """Room for a position, shape (n_dof,)."""


_SETTINGS, _STATE, _COUNTERS = Array(ServoSettings, 1, constant=True), Array(JointState, 1), Array(StopCounters, 1)
_GOAL = WHOLE, NUMBERS, NUMBERS, Array(HandGoal, 1)
_WRITTEN = _STATE, _COUNTERS, NUMBERS, Array(MovingObject, 1), Array(TickReport, 1)
_TABLES = Group((TABLE, Array(JointLimits, 1, constant=True), _SETTINGS, *_GOAL, *_WRITTEN), ServoTables)


@entry(*((scene, _TABLES) for scene in (BOXES, SHAPES)))
def servo_tick(scene, tables):
    """Write the state after a tick, and its report. False if the goal is out of range: then nothing is written.

    For START the state becomes the goal's: if its stop is not certified the status is REFUSED. tables: ``ServoTables``.
    """
    goal, state = ServoGoal(tables.mode, tables.q, tables.qd, tables.hands), tables.joints
    if not is_goal_in_range(goal):
        return False
    limits, settings, n = tables.limits, tables.settings[0], tables.limits.shape[0]
    room = np.empty((9, n))
    tick = Tick(
        scene, carried_by(scene), interval_work(n), world_rounding(scene), bounded_near_of(scene),
        np.empty((MAX_PAIRS + 1, n)), np.empty(MAX_PAIRS + 1), tables.wider, tables.moving,
        np.empty((MAX_TOUCHING, PAIR_WIDTH), np.int64), tables.chains, limits, settings, goal, state,
        tables.counters[0], tables.report[0], room[0], room[1], Chord(room[2], room[3], room[4], room[5]), state.copy(),
        room[6], room[7], room[8],
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
        tick.report.status = go_on(tick)
        return True
    work = work_of(n, len(goal.hands) if goal.mode == HANDS else 0)
    ticks = write_velocity_box(state, tick.counters, limits, settings, work.program.box_rows)
    tick.report.status = go_on(tick) if ticks < 0 else advance(tick, work, ticks)
    return True


@entry((_STATE, _COUNTERS, _SETTINGS, MATRIX))
def write_stop_positions(state, counters, settings, q_out):
    """Write q after each tick that is left of the certified stop, whose state and counters become those of its end.

    q_out: as many rows as ticks are left.
    """
    for k in range(q_out.shape[0]):
        go_on_stopping(state, counters[0], settings[0])
        for j in range(q_out.shape[1]):
            q_out[k, j] = state[j].q


@workspace
def bounded_near_of(scene):
    """Room for the near pairs of a tick, which measures so many and bounds the others."""
    of = near_of(scene, MAX_PAIRS, 0)
    return Near(
        of.joint_rows, of.body_rows, of.contact_rows, of.pair_rows, of.last_rows, of.stack, of.heights, np.empty(1), of.planes,
        of.scratch,
    )  # fmt: skip


@workspace
def work_of(n, n_hands):
    """Room for the quadratic program."""
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
    """Whether all numbers of a goal are finite, and none is too large."""
    good = all_in_range(goal.q) and all_in_range(goal.qd)
    for i in range(goal.hands.shape[0]):
        hand = goal.hands[i]
        good = good and abs(hand.weight) <= LARGEST and all_in_range(hand.twist) and all_in_range(hand.pose)
    return good


@kernel
def clear(report):
    """Write that nothing limits a tick."""
    report.entry, report.body, report.other = -1, -1, -1
    report.share, report.distance, report.bounded = 0.0, np.inf, False


@routine
def find_contacts(tick, own):
    """Find the pairs in contact where the arm is; the deepest goes to the report. own: room for them."""
    scene, report, deepest = tick.scene, tick.report, GRAZE
    near = sharing(own, tick, own.contact_rows, own.pair_rows)
    near.unseen[0] = np.inf
    write_q(tick.state, tick.place)
    place_bodies(scene.joints, scene.bodies, tick.place, near.joint_rows, near.body_rows)
    n = min(find_near_pairs(scene, 0.0, None, GRAZE, near, None), MAX_TOUCHING)
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
    """Set the state to the position and the velocity of the goal; the status."""
    state = tick.state
    for j in range(tick.limits.shape[0]):
        state[j].q, state[j].qd, state[j].qdd, state[j].behind = tick.goal.q[j], tick.goal.qd[j], 0.0, tick.goal.q[j]
    ticks = write_stop(state, tick.limits, tick.settings)
    tick.counters.ticks, tick.counters.done = ticks, 0
    if not stop_keeps(state, tick.limits, tick.settings, ticks):
        return LIMITED_BY_POSITION
    tick.counters.certified = stop_is_free(tick)
    if not tick.counters.certified:
        return REFUSED
    return status_of_stop(tick.counters)


@kernel
def go_on(tick):
    """Step 5; the status."""
    go_on_stopping(tick.state, tick.counters, tick.settings)
    return status_of_stop(tick.counters)


@kernel
def status_of_stop(counters):
    """The status while the certified stop goes on."""
    if not counters.certified:
        return status_uncertified(counters)
    return AT_REST if counters.done >= counters.ticks else BRAKING


@kernel
def status_uncertified(counters):
    """The status where the stop is not certified."""
    return IN_COLLISION if counters.touching > 0 else NOT_CERTIFIED


@kernel
def time_left(tick):
    """How long the certified stop takes from now on [s]."""
    return max(tick.counters.ticks - tick.counters.done, 0) * tick.settings.period


@kernel
def widen(tick, time):
    """Write how much farther away than the clearance objects have to be, which may move by themselves for so long [s]."""
    wider, of_tree, of_all = tick.wider, 0.0, 0.0
    for i in range(tick.moving.shape[0]):
        way = tick.moving[i].speed * (tick.moving[i].age + time) + MOVED
        wider[tick.moving[i].number] = way
        of_all = max(of_all, way)
        if tick.moving[i].in_tree:
            of_tree = max(of_tree, way)
    wider[wider.shape[0] - 2], wider[wider.shape[0] - 1] = of_tree, of_all


@routine
def stop_is_free(tick):
    """Whether what is left of the certified stop is free in this world."""
    ticks, done = tick.counters.ticks, tick.counters.done
    return rest_is_free(tick, tick.state, ticks, done, 0.0, tick.settings.clearance)


@routine
def is_free(tick, q_a, q_b, spread, margin, time):
    """Whether all within ``spread`` of a line is certainly free, until a time from now [s]; pairs in contact aside."""
    widen(tick, time)
    apart = Apart(tick.wider, tick.touching[: tick.counters.touching], tick.near.planes)
    check = EdgeCheck(tick.scene, tick.carried, tick.work, tick.of_world)
    return edge_is_free(check, Edge(q_a, q_b, spread), RESOLUTION, margin, apart, 0)


@kernel
def advance(tick, work, ticks):
    """Steps 1 to 5, with a stop of so many ticks after this one; the status."""
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
    way = way_to_rest(settings, ticks)
    m = write_rows(tick, count, way, program)
    write_objective(tick.chains, tick.goal, limits, settings, tick.q, objective)
    found = set_paces(tick, count, work)
    keep_reserve(tick, count, way, objective.h_rows, objective.f_rows)
    k = minimize(objective.h_rows, objective.f_rows, program, m, tick.x)
    for j in range(n):
        tick.x[j] = min(max(tick.x[j], box_rows[j]), box_rows[n + j])
    nearer = come_nearer(tick, least)
    miss = missed(tick.goal, objective.jacobian_rows, objective.desired_rows, tick.x)
    status = IN_COLLISION
    if counters.touching == 0:
        status = status_of_rows(tick, found, nearer, miss, program, k, ticks)
    share = certified_share(tick, certified, least, time)
    tick.report.share = share
    if share == 0.0:
        go_on_stopping(state, counters, settings)
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
    """Set the pace of each hand in the objective; the row that holds the steady motion, or -1, and what slows the slowest hand.

    There are no paces but of hands. A hand that an object stops goes along it: then what it does beside its twist has the weight
    of what it does along it.
    """
    if tick.goal.mode != HANDS:
        return -1, NOT_SLOWED
    objective, steady, hands, limits, settings = work.objective, work.steady, tick.goal.hands, tick.limits, tick.settings
    program, q, across, m = work.program, tick.q, across_of(hands, limits), 2 * limits.shape[0] + count
    write_steady_bounds(limits, q, tick.excess, RESERVE, steady.bound_rows[:m])
    k = write_steady(objective, program, m, steady)
    if across > 1.0 and is_at_object(tick, k, steady):
        across = 1.0
        write_squares(hands, settings, objective, across)
        k = write_steady(objective, program, m, steady)
    held = -1
    if missed(tick.goal, objective.jacobian_rows, objective.desired_rows, steady.x_rows) > _SAME:
        held = strongest_row(steady.active_rows, steady.multiplier_rows, k)
    n_hands, slowest, slowed = objective.pace_rows.shape[0], 1.0, NOT_SLOWED
    time = write_changes(tick.chains, hands, limits, q, objective, steady)
    least = BLURRED if write_turns(tick, k, time, steady) else 0.0
    write_growth(hands, objective, steady, program, k, across)
    for hand in range(n_hands):
        write_pace(hands, limits, settings, objective, steady, across, least, hand)
        if are_apart(hands, objective):
            write_part(hands, objective, steady, program, k, across, hand)
            set_apart(limits, settings, tick.state, objective, steady, hand)
        if across > 1.0:
            keep_on_line(hands, objective, steady, hand)
    share_paces(hands, objective)
    for hand in range(n_hands):
        if objective.slowing_rows[hand] > NOT_SLOWED and objective.pace_rows[hand] < slowest:
            slowest, slowed = objective.pace_rows[hand], objective.slowing_rows[hand]
    pull = pull_of_way_back(tick.chains, hands, limits, tick.state, objective, steady)
    write_pulls(limits, settings, q, objective)
    add_pull(tick.state, objective, pull)
    return held, slowed


@routine
def write_turns(tick, k, time, steady):
    """Write how the gradients of active rows change along the steady motion in a time [s]; whether a near pair is among them."""
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
    """Whether an object of the world holds the steady motion, of which so many rows are active."""
    n, found = tick.limits.shape[0], False
    for a in range(k):
        row = steady.active_rows[a] - 2 * n
        found = found or (row >= 0 and tick.near.pair_rows[row, PAIR_OTHER] >= tick.scene.bodies.shape[0])
    return found


@routine
def measure_near(tick, q, near, excess, time):
    """Step 1: find the pairs that are near at q, a time from now [s]; how many are kept in ``near``, of the nearest."""
    excess[-1] = WITHIN
    widen(tick, time)
    place_bodies(tick.scene.joints, tick.scene.bodies, q, near.joint_rows, near.body_rows)
    apart = Apart(tick.wider, tick.touching[:0], tick.near.planes)
    near.unseen[0] = WITHIN
    count = find_near_pairs(tick.scene, tick.settings.clearance, apart, WITHIN, near, excess)
    tick.report.bounded = tick.report.bounded or near.unseen[0] < WITHIN
    return count


@routine
def least_excess(tick, q, time):
    """How much farther the pairs at q, a time from now [s], are apart than they have to be: the least, at most WITHIN.

    By their distance; of pairs that were not measured, since there are many, by a lower bound of it.
    """
    near, excess = tick.near, tick.excess[-1:]
    none = sharing(near, tick, near.contact_rows[-1:], near.pair_rows[:0])
    measure_near(tick, q, none, excess, time)
    return min(excess[-1] - SAME, none.unseen[0])


@kernel
def sharing(near, tick, contact_rows, pair_rows):
    """Room for near pairs with these rows, and with the planes and the bound of the tick."""
    return Near(
        near.joint_rows, near.body_rows, contact_rows, pair_rows, near.last_rows, near.stack,
        near.heights, tick.near.unseen, tick.near.planes, near.scratch,
    )  # fmt: skip


@kernel
def is_moved(tick):
    """Whether the velocity found is not that of rest."""
    moved = False
    for j in range(tick.x.shape[0]):
        moved = moved or abs(tick.x[j]) > STILL * tick.limits[j].acceleration * tick.settings.period
    return moved


@kernel
def write_rows(tick, count, way, program):
    """Write the rows of the quadratic program, the box first; how many they are.

    After a tick that ends with x the arm rests at c + way x. Row i says how much nearer pair i may be there than at the end of
    the certified stop; a pair in contact may become as deep as the deepest is. No row excludes the velocity at which the
    quadratic program starts.
    """
    n, h, deepest = tick.x.shape[0], tick.settings.period, tick.excess[nearest_of(tick, count)]
    box_rows, normal_rows, bound_rows = program.box_rows, program.normal_rows, program.bound_rows
    for j in range(n):
        tick.tried[j] = beyond_rest_of_zero(tick.state, tick.settings, j)  # tried is written anew before it is read
        normal_rows[n * j + j], bound_rows[j] = 1.0, box_rows[j]
        normal_rows[n * (n + j) + j], bound_rows[n + j] = -1.0, -box_rows[n + j]
    for i in range(count):
        least = deepest if tick.counters.touching > 0 and tick.near.contact_rows[i, DISTANCE] <= GRAZE else RESERVE
        r, at, by = 2 * n + i, -h / (h + EASE) * max(tick.excess[i] - least, 0.0), 0.0
        for j in range(n):
            g = tick.gradients[i, j]
            normal_rows[n * r + j] = g
            at += g * tick.tried[j]
            by += g * tick.x[j]
        bound_rows[r] = min(at / way, by)
    return 2 * n + count


@kernel
def keep_reserve(tick, count, way, h_rows, f_rows):
    """Add to the objective, where a motion is desired, that pairs within the reserve come out of it.

    Rows are linear, so that along a curved way pairs get into it. Of pairs in contact only the deepest is led out.
    """
    n, h, sought = tick.x.shape[0], tick.settings.period, 0.0
    for j in range(n):
        sought = max(sought, abs(f_rows[j]))
    if sought < SMALL:
        return
    deepest = nearest_of(tick, count)
    for i in range(count):
        if tick.counters.touching > 0 and i != deepest:
            continue
        inside = RESERVE - tick.excess[i]
        if inside > 0.0:
            out, square = inside * h / (h + EASE) / way, 1e-300
            for j in range(n):
                square += tick.gradients[i, j] * tick.gradients[i, j]
            for j in range(n):
                g = _OUTWARD * tick.gradients[i, j] / square
                f_rows[j] += g * out
                for k in range(n):
                    h_rows[n * j + k] += g * tick.gradients[i, k]


@kernel
def come_nearer(tick, least):
    """Keep the share of the way from the certified stop's velocity to x that leads to rest no farther from poses; return it."""
    if tick.goal.mode != HANDS or tick.counters.touching > 0 or least < RESERVE:
        return 1.0
    most, kept = max(pose_squares(tick.chains, tick.goal.hands, tick.rest), NEARBY), 0.0
    for share in SHARES:
        if kept == 0.0:
            try_share(tick, share)
            write_tick(tick.tried, tick.state, tick.limits, tick.settings, tick.after)
            write_rest(tick.after, tick.place)
            if pose_squares(tick.chains, tick.goal.hands, tick.place) <= most:
                kept = share
    try_share(tick, kept)
    for j in range(tick.x.shape[0]):
        tick.x[j] = tick.tried[j]
    return kept


@kernel
def try_share(tick, share):
    """Write the velocity to try: a share of the way from the certified stop's to x."""
    for j in range(tick.x.shape[0]):
        stop = stop_velocity(tick.state, tick.counters, tick.settings, j)
        tick.tried[j] = tick.x[j] if share == 1.0 else stop + share * (tick.x[j] - stop)


@kernel
def certified_share(tick, certified, least, time):
    """Steps 3 and 4: accept the largest share that is certified, and return it; 0 if no share is."""
    clearance, first = tick.settings.clearance, tick.counters.next_share
    if tick.settings.ramp > 0.0 and certified and is_nearly_at_rest(tick):
        return 0.0
    if certified:
        for i in range(first, first + TRIES):
            if is_candidate(tick, SHARES[i], 1.0, clearance):
                tick.counters.next_share = next_share(first, i)
                accept(tick)
                return SHARES[i]
        tick.counters.next_share = next_share(first, -1)
    for share in NARROW_SHARES:
        if is_outward(tick, share, _LEAVING * clearance if certified else 0.0, least, time):
            accept(tick)
            return share
    if not certified or tick.settings.ramp > 0.0:
        for share in SMALLEST_SHARES:
            if is_outward(tick, share, _LEAVING * clearance if certified else 0.0, least, time):
                accept(tick)
                return share
    return 0.0


@kernel
def next_share(first, found):
    """Which of SHARES the next tick tries first: the one above that which was found; after none the others, then all again."""
    if found < 0:
        return TRIES if first == 0 else 0
    return min(max(found - 1, 0), len(SHARES) - TRIES)


@routine
def is_outward(tick, share, margin, least, time):
    """Step 4: whether a share is certified with a margin, and leads to where the least of all pairs is greater than that."""
    if not is_short(tick, share):
        return False
    write_rest(tick.after, tick.place)
    return least_excess(tick, tick.place, time) > least and is_candidate(tick, share, 0.0, margin)


@kernel
def is_short(tick, share):
    """Whether a share of the way from the certified stop's velocity to x leads to rest by a short way, HOP."""
    state, limits, settings, chord = tick.state, tick.limits, tick.settings, tick.chord
    try_share(tick, share)
    ticks = write_tick(tick.tried, state, limits, settings, tick.after)
    for j in range(tick.x.shape[0]):
        chord.q_a[j], chord.line_spread[j] = state[j].q, limits[j].tracking_error
        chord.q_b[j] = chord.q_a[j] + travel(state, tick.after, settings, ticks, j)
    return longest_way(tick, chord) <= HOP


@routine
def is_candidate(tick, share, room, margin):
    """Whether a share of the way from the certified stop's velocity to x is within all limits and certified."""
    state, limits, settings = tick.state, tick.limits, tick.settings
    try_share(tick, share)
    ticks = write_tick(tick.tried, state, limits, settings, tick.after)
    return stop_keeps(tick.after, limits, settings, ticks) and rest_is_free(tick, tick.after, ticks, -1, room, margin)


@routine
def rest_is_free(tick, state, ticks, done, room, margin):
    """Whether what is left of a stop of so many ticks, of which some are done, is certainly free; -1: with the tick before it.

    A stop is a line, with a limit of jerk after a bend. Of that and of the tick, chords of equal times t are certified: with
    accelerations of at most a, q is no farther than a t^2 / 8 from its chord. Objects may move until the end of the curve and of
    the stop.
    """
    chord, h, bend = tick.chord, tick.settings.period, 2 * int(tick.settings.ramp)
    n, most, left = tick.x.shape[0], 0.0, (bend if ticks > 0 else 0) - done
    for j in range(n):
        chord.line_spread[j] = tick.limits[j].tracking_error + room * tick.limits[j].room
        chord.q_b[j] = tick.state[j].q if done < 0 else state[j].q
        if left > 0:
            before = tick.state[j].qdd
            most = max(most, abs(curve_moment(state, tick.settings, ticks, before, (done + left) * h, j)[1]))
            most = max(most, abs(curve_moment(state, tick.settings, ticks, before, done * h, j)[1]))
            if done < 0:
                most = max(most, abs(state[j].qdd))
    if left > 0:
        chords = int(left * h * sqrt(most / (8.0 * BESIDE))) + 1
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
    """Write where the stop of a state ends."""
    for j in range(state.shape[0]):
        q_out[j] = state[j].rest_q


@kernel
def write_chord(tick, state, ticks, begin, length):
    """Write the next chord of a curve, from where the last one ended, and how far all beside it is certified."""
    chord, end = tick.chord, begin + length
    for j in range(tick.x.shape[0]):
        before, chord.q_a[j] = tick.state[j].qdd, chord.q_b[j]
        _, first = curve_moment(state, tick.settings, ticks, before, begin, j)
        chord.q_b[j], last = curve_moment(state, tick.settings, ticks, before, end, j)
        most = max(abs(first), abs(last))
        if begin < 0.0 < end:
            most = max(most, abs(state[j].qdd))
        chord.spread[j] = chord.line_spread[j] + 0.125 * length * length * most * (1.0 + 1e-9)


@kernel
def longest_way(tick, line):
    """A bound on the way of any point of the robot along a line [m]."""
    write_motion(tick.scene.joints, line.q_a, line.q_b, line.line_spread, tick.carried)
    return fastest_ball(tick.scene.joints, tick.carried)


@kernel
def accept(tick):
    """Write the state after the tick that was tried."""
    state, after = tick.state, tick.after
    tick.counters.ticks, tick.counters.done = write_tick(tick.tried, state, tick.limits, tick.settings, after), 0
    for j in range(tick.x.shape[0]):
        state[j] = after[j]
    tow(state)


@kernel
def status_of_rows(tick, found, nearer, miss, program, k, ticks):
    """Report what limits the velocity found: the steady motion, or the active constraint of the greatest multiplier.

    found: what ``set_paces`` returned.
    """
    held, slowed = found
    if miss <= _SAME:
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
    """The active constraint of the greatest multiplier, of k; -1 if no multiplier is above 0."""
    most, row = 0.0, -1
    for a in range(k):
        if multiplier_rows[a] > most:
            most, row = multiplier_rows[a], active_rows[a]
    return row


@kernel
def write_row(tick, row):
    """Report a constraint: its pair or its entry of q; whether it is that of a pair."""
    n = tick.x.shape[0]
    if row >= 2 * n:
        write_pair(tick, row - 2 * n)
        return True
    tick.report.entry = row % n
    return False


@kernel
def is_nearly_at_rest(tick):
    """Whether no velocity is to be left, and little is now: then the certified stop goes on, which ends at rest."""
    state, limits, h, nearly = tick.state, tick.limits, tick.settings.period, not is_moved(tick)
    for j in range(tick.x.shape[0]):
        nearly = nearly and abs(state[j].qd) <= limits[j].acceleration * h
        nearly = nearly and abs(state[j].qdd) <= limits[j].jerk * h
    return nearly


@kernel
def report_nearest(tick, count):
    """Write the pair that was nearest where the certified stop ends to the report."""
    if count > 0:
        write_pair(tick, nearest_of(tick, count))


@kernel
def nearest_of(tick, count):
    """The near pair that is least farther apart than it has to be; 0 without one."""
    nearest = 0
    for i in range(1, count):
        if tick.excess[i] < tick.excess[nearest]:
            nearest = i
    return nearest


@kernel
def write_pair(tick, i):
    """Write near pair i to the report."""
    report, near = tick.report, tick.near
    report.entry, report.body, report.other = -1, near.pair_rows[i, PAIR_BODY], near.pair_rows[i, PAIR_OTHER]
    report.distance = near.contact_rows[i, DISTANCE]
