"""Judges a servo's commands: Coal's contacts with shapes placed by Pinocchio, limits by differences, chatter."""

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.peers.coal import Scene
from benchmarks.servo_scenes import RATE, hand_of
from ulna.bench.arms import longest_reach

Array = NDArray[np.float64]
FINER = 16  # configurations checked per tick
SLOW_HZ = 50.0
ROUNDING = 1e-12  # [rad]
_BODY = 0.3  # [m]: maximum distance of a link's points from the chain of its joints


def curve(q: Array, qd: Array | None = None, qdd: Array | None = None) -> Array:
    """Configurations between ticks, shape (n - 1, FINER, n_dof): parabolas from q and qd, shape (n, n_dof), or lines.

    With accelerations: cubics.
    """
    t = np.arange(FINER)[:, None] / FINER / RATE
    first = np.diff(q, axis=0) * RATE if qd is None else qd[:-1]
    second = np.zeros_like(first) if qd is None else np.diff(qd, axis=0) * RATE if qdd is None else qdd[:-1]
    third = np.zeros_like(first) if qdd is None else np.diff(qdd, axis=0) * RATE
    return q[:-1, None] + t * first[:, None] + 0.5 * t * t * second[:, None] + t**3 / 6 * third[:, None]


def contacts(robot: ulna.Robot, world: ulna.World, fine: Array, ball: Array | None = None) -> tuple[int, float]:
    """The number of ticks in which Coal finds a contact, and the maximum depth [m].

    ball: the positions, shape (n, 3), of a moving ball. A tick counts as free if at its start all pairs are farther apart than
    arm and ball move in it, by differences.
    """
    judge, wide = Scene(robot, world, itself=True), Scene(robot, world, itself=True)
    arm, touched, deepest = longest_reach(robot, hand_of(robot)) + _BODY, 0, 0.0
    ways = 2 * arm * np.abs(np.diff(fine, axis=1)).sum(axis=(1, 2)) * FINER / (FINER - 1)
    if ball is not None:
        ways += np.linalg.norm(np.diff(ball, axis=0), axis=1)
    for k, (tick, way) in enumerate(zip(fine, ways, strict=True)):
        for request in wide.answers.collisionRequests:
            request.security_margin = float(way)
        if ball is not None:
            wide.move("ball", ulna.pose(ball[k]))
        if not wide.collides(tick[0]):
            continue
        hit = False
        for i, q in enumerate(tick):
            if ball is not None:
                judge.move("ball", ulna.pose(ball[k] + i / FINER * (ball[k + 1] - ball[k])))
            if judge.collides(q):
                hit, deepest = True, max(deepest, -judge.least_distance(q))
        touched += hit
    return touched, deepest


def overlaps(robot: ulna.Robot, world: ulna.World, fine: Array) -> int:
    """The number of ticks in which Ulna's overlap test finds a contact."""
    with ulna.threads(1):
        touching = robot.in_collision(fine.reshape(-1, robot.n_dof), world)
    return int(np.count_nonzero(touching.reshape(len(fine), -1).any(axis=1)))


def shares_of_limits(robot: ulna.Robot, q: Array, acceleration: float, jerk: float | None = None) -> dict[str, float]:
    """The maximum velocity, acceleration and jerk by differences, as shares of limits; q's excess over limits [rad]."""
    v = np.diff(q, axis=0) * RATE
    speeds, accelerations = np.abs(v) / robot.velocity_limits, np.abs(np.diff(v, axis=0)) * RATE / acceleration
    jerks = np.zeros(1) if jerk is None else np.abs(np.diff(v, 2, axis=0)) * RATE**2 / jerk
    beyond = np.maximum(robot.lower - q, q - robot.upper)
    return {
        "violations": int(sum(np.sum(shares > 1) for shares in (speeds, accelerations, jerks)) + np.sum(beyond > ROUNDING)),
        "velocity": float(speeds.max()),
        "acceleration": float(accelerations.max()),
        **({} if jerk is None else {"jerk": float(jerks.max())}),
        "beyond_rad": max(0.0, float(beyond.max())),
    }


def chatter(q: Array) -> float:
    """The share of the power of the accelerations above 50 Hz; q at the servo's rate, shape (n, n_dof)."""
    qdd = np.diff(q, 2, axis=0) * RATE**2
    window = np.hanning(len(qdd))[:, None]
    power = (np.abs(np.fft.rfft(qdd * window, axis=0)) ** 2).sum(axis=1)
    return float(power[np.fft.rfftfreq(len(qdd), 1 / RATE) > SLOW_HZ].sum() / max(power.sum(), 1e-300))


def off_path(hand: Array, path: Array, ahead: int = 100) -> Array:
    """The distance of the hand's positions [m], shape (n, 3), from the path, a polyline, near the same time."""
    off = np.full(len(hand), np.inf)
    for shift in range(-ahead, ahead):
        rows = np.arange(len(hand)) + shift
        good = (rows >= 0) & (rows + 1 < len(path))
        a, b = path[rows[good]], path[rows[good] + 1]
        way = b - a
        share = ((hand[good] - a) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
        nearest = a + np.clip(share, 0, 1)[:, None] * way
        off[good] = np.minimum(off[good], np.linalg.norm(hand[good] - nearest, axis=1))
    return off
