"""However small the damping, the velocities are the minimum: by exact fractions without limits, by a duality gap within them."""

from fractions import Fraction

import numpy as np
import pytest

from matrix import matrix
from ulna import Robot

DT = 0.01
DAMPINGS = (1.0, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12, 1e-30, 1e-150, 1e-200, 5e-324)


def exact_minimum(J, v, damping):
    """(J' J + damping^2 I)^-1 J' v by Gauss's elimination over fractions, rounded once at the end."""
    J, v, n = [[Fraction(x) for x in row] for row in J.tolist()], [Fraction(x) for x in v.tolist()], J.shape[1]
    rows = [
        [sum(J[k][a] * J[k][b] for k in range(6)) + (Fraction(damping) ** 2 if a == b else 0) for b in range(n)]
        + [sum(J[k][a] * v[k] for k in range(6))]
        for a in range(n)
    ]
    for a in range(n):
        pivot = next(b for b in range(a, n) if rows[b][a] != 0)
        rows[a], rows[pivot] = rows[pivot], rows[a]
        rows[a] = [x / rows[a][a] for x in rows[a]]
        for b in range(n):
            if b != a:
                rows[b] = [x - rows[b][a] * y for x, y in zip(rows[b], rows[a], strict=True)]
    return np.array([float(row[-1]) for row in rows])


def gap(J, v, damping, x, low, high):
    """|J x - v|^2 + damping^2 |x|^2 is at most this above its minimum within the box (Frank and Wolfe 1956)."""
    J, v, x = (np.asarray(part, dtype=np.longdouble) for part in (J, v, x))
    slope = 2 * (J.T @ (J @ x - v) + np.longdouble(damping) ** 2 * x)
    return float(np.maximum(slope * (x - low), slope * (x - high)).sum())


def velocity_box(robot, q):
    fastest = robot.velocity_limits
    return np.clip((robot.lower - q) / DT, -fastest, fastest), np.clip((robot.upper - q) / DT, -fastest, fastest)


@pytest.mark.parametrize("share", [0.5e-4, 0.99e-4, 1.01e-4, 2e-4, 1e-3, 0.99e-2, 1.01e-2, 0.1])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_fewer_joints_than_six_lose_no_digits_at_any_damping(rng, n, share):
    """J J' of six rows is singular then, whatever the pose: a small damping would lose 5e-8 of the velocity."""
    arm = Robot.from_dh(rng.uniform(0.2, 1, (n, 4)))
    for q, v in zip(rng.uniform(0.3, 1.2, (10, n)), rng.normal(size=(10, 6)), strict=True):
        J = arm.jacobian(q)
        damping = share * float(np.linalg.norm(J))
        found, expected = arm.differential_ik(q, v, DT, damping=damping), exact_minimum(J, v, damping)
        values = np.linalg.svd(J, compute_uv=False)
        allowed = 1e-11 + 1e-13 * (values[0] / values[-1]) ** 2
        np.testing.assert_allclose(found, expected, rtol=0, atol=allowed * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("damping", matrix(DAMPINGS, [1.0, 1e-6, 1e-9, 5e-324]))
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("n", [1, 2, 4, 5, 6, 7, 8])
def test_without_limits_the_velocities_are_those_of_exact_fractions(rng, n, damping, scale):
    rows = rng.uniform(0.2, 1, (n, 4)) * (scale, scale, 1, 1)
    arm = Robot.from_dh(rows)
    q, v = rng.uniform(0.3, 1.2, (3, n)), rng.normal(size=(3, 6)) * (scale, scale, scale, 1, 1, 1)
    batch = arm.differential_ik(q, v, DT, damping=damping)
    for k in range(3):
        J = arm.jacobian(q[k])
        values = np.linalg.svd(J, compute_uv=False)
        expected = exact_minimum(J, v[k], damping)
        allowed = 1e-7 + 1e-13 * (values[0] / values[-1]) ** 2
        alone = arm.differential_ik(q[k], v[k], DT, damping=damping)
        np.testing.assert_allclose(alone, expected, rtol=0, atol=allowed * np.abs(expected).max())
        np.testing.assert_allclose(batch[k], alone, rtol=0, atol=allowed * np.abs(expected).max())


@pytest.mark.parametrize("damping", DAMPINGS)
def test_a_planar_arm_moves_as_of_plain_least_squares(damping):
    """Four of the six rows of J are beyond it: J J' is singular whatever its pose."""
    arm = Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (0.6, 0, 0, 0)], joint_types=["revolute", "revolute", "fixed"])
    q, v = np.array([0.3, 0.9]), np.array([0.1, -0.2, 0.5, 0.3, -0.1, 0])
    s1, c1, s12, c12 = np.sin(0.3), np.cos(0.3), np.sin(1.2), np.cos(1.2)
    J = np.array([[-s1 - 0.6 * s12, -0.6 * s12], [c1 + 0.6 * c12, 0.6 * c12], [0, 0], [0, 0], [0, 0], [1, 1]])
    np.testing.assert_allclose(arm.differential_ik(q, v, DT, damping=damping), exact_minimum(J, v, damping), rtol=1e-10)


@pytest.mark.parametrize("damping", DAMPINGS)
def test_within_the_limits_nothing_is_lower(panda, rng, damping):
    """Any pose, poses at limits, and stretched: as near to the minimum as the roundings of J let anyone tell."""
    q = rng.uniform(panda.lower, panda.upper, (60, 7))
    q[::3] = np.where(rng.random((20, 7)) < 0.4, np.where(rng.random((20, 7)) < 0.5, panda.upper, panda.lower), q[::3])
    q[1::3] = np.clip(np.zeros(7), panda.lower, panda.upper)
    twists = rng.normal(size=(60, 6)) * rng.choice([0.1, 1, 10], (60, 1))
    for one, twist, of_batch in zip(q, twists, panda.differential_ik(q, twists, DT, damping=damping), strict=True):
        low, high = velocity_box(panda, one)
        for x in (of_batch, panda.differential_ik(one, twist, DT, damping=damping)):
            assert (x >= low - 1e-12).all()
            assert (x <= high + 1e-12).all()
            assert gap(panda.jacobian(one), twist, damping, x, low, high) <= 1e-11 * (1 + twist @ twist)


@pytest.mark.parametrize("damping", [1e-6, 1e-8, 1e-10])
def test_of_the_motions_that_give_the_twist_it_is_the_shortest_within_the_limits(panda, rng, damping):
    """They lie on a line, x + t n with J n = 0, and only the damping tells them apart."""
    q = panda.home
    J, n_at_limits = panda.jacobian(q), 0
    null = np.linalg.svd(J)[2][-1]
    low, high = velocity_box(panda, q)
    for _ in range(200):
        shortest = np.linalg.pinv(J) @ (J @ rng.uniform(low, high))
        ends = np.sort([(low - shortest) / null, (high - shortest) / null], axis=0)
        t = np.clip(0.0, ends[0].max(), ends[1].min())
        n_at_limits += t != 0.0
        velocities = panda.differential_ik(q, J @ shortest, DT, damping=damping)
        np.testing.assert_allclose(velocities, shortest + t * null, rtol=0, atol=1e-5)
    assert n_at_limits > 10
