"""One step of a control loop: the minimum that SciPy finds, within all limits, in a loop that follows a line."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import ulna
from ulna import InputError, Robot

DT = 0.01


def bounds(robot, q, dt=DT):
    """Velocities that keep the velocity limits and end within the position limits."""
    fastest = robot.velocity_limits
    return np.clip((robot.lower - q) / dt, -fastest, fastest), np.clip((robot.upper - q) / dt, -fastest, fastest)


def cost(robot, q, twist, qd, damping=0.01):
    return np.sum((robot.jacobian(q) @ qd - twist) ** 2) + damping**2 * np.sum(qd**2)


@pytest.fixture(scope="module")
def situations(panda):
    """Configurations, a third of them at some limits, and twists from gentle to far beyond what the arm can do."""
    rng = np.random.default_rng(11)
    q = rng.uniform(panda.lower, panda.upper, (240, 7))
    at_limit = rng.random((80, 7)) < 0.4
    q[::3] = np.where(at_limit, np.where(rng.random((80, 7)) < 0.5, panda.upper, panda.lower), q[::3])
    return q, rng.normal(size=(240, 6)) * (0.3, 0.3, 0.3, 1, 1, 1) * rng.choice([0.1, 1, 10], (240, 1))


def test_the_velocities_are_the_minimum_that_scipy_finds(panda, situations):
    for q, twist in zip(*situations, strict=True):
        low, high = bounds(panda, q)
        qd = panda.differential_ik(q, twist, DT)
        A, b = np.vstack([panda.jacobian(q), 0.01 * np.eye(7)]), np.concatenate([twist, np.zeros(7)])
        best = lsq_linear(A, b, (low - 1e-12, high + 1e-12), method="bvls", tol=1e-14).x
        assert (qd >= low - 1e-12).all()
        assert (qd <= high + 1e-12).all()
        assert cost(panda, q, twist, qd) <= cost(panda, q, twist, best) + 1e-9
        np.testing.assert_allclose(qd, best, atol=1e-6)


def test_a_batch_gives_each_row_what_it_gets_alone(panda, situations):
    q, twist = situations
    batch = panda.differential_ik(q.reshape(2, 120, 7), twist.reshape(2, 120, 6), DT)
    assert batch.shape == (2, 120, 7)
    alone = [panda.differential_ik(*row, DT) for row in zip(q, twist, strict=True)]
    np.testing.assert_allclose(batch.reshape(-1, 7), alone, atol=1e-9)
    assert panda.differential_ik(q[3:7], twist[3:7], DT).tobytes() == batch.reshape(-1, 7)[3:7].tobytes()
    np.testing.assert_allclose(panda.differential_ik(q[0], twist, DT)[5], panda.differential_ik(q[0], twist[5], DT), atol=1e-9)


def test_a_twist_that_the_arm_can_do_is_done(panda):
    twist = np.array([0.05, -0.03, 0.04, 0.1, 0.0, -0.1])
    for frame in ("base", "link", "spatial"):
        qd = panda.differential_ik(panda.home, twist, DT, expressed_in=frame)
        np.testing.assert_allclose(panda.jacobian(panda.home, expressed_in=frame) @ qd, twist, rtol=0.02, atol=1e-3)


def test_at_a_singularity_the_joints_keep_their_speed():
    """A stretched planar arm pulled outwards: no joint can help, and none races."""
    arm = Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
    for bend in (0.0, 1e-12, 1e-6, 1e-3):
        qd = arm.differential_ik([0.0, bend], [1.0, 0, 0, 0, 0, 0], DT)
        assert np.abs(qd).max() <= 1 / (2 * 0.01)
    assert not arm.differential_ik([0.0, 0.0], [1.0, 0, 0, 0, 0, 0], DT).any()


def test_beyond_a_limit_a_joint_is_led_back_no_faster_than_it_may(panda):
    q = panda.home.copy()
    q[0] = panda.upper[0] + 1.0
    qd = panda.differential_ik(q, np.zeros(6), DT)
    assert qd[0] == -panda.velocity_limits[0]


def test_a_line_is_followed_and_stops_at_the_limits(panda):
    q, start = panda.home.copy(), panda.forward_kinematics(panda.home)[:3, 3]
    for _ in range(100):
        q = q + DT * panda.differential_ik(q, [0.0, 0.1, 0, 0, 0, 0], DT)
    np.testing.assert_allclose(panda.forward_kinematics(q)[:3, 3] - start, [0, 0.1, 0], atol=1e-3)
    for _ in range(3000):
        q = q + DT * panda.differential_ik(q, [0.0, 0.1, 0, 0, 0, 0], DT)
    assert (q >= panda.lower - 1e-12).all()
    assert (q <= panda.upper + 1e-12).all()


def test_the_callers_array_is_written_to_and_returned(panda):
    out = np.full(7, np.nan)
    assert panda.differential_ik(panda.home, np.ones(6), DT, out=out) is out
    np.testing.assert_array_equal(out, panda.differential_ik(panda.home, np.ones(6), DT))


@pytest.mark.parametrize(
    ("named", "message"),
    [
        ({"twist": np.zeros(5)}, "twist: shape"),
        ({"twist": [np.nan, 0, 0, 0, 0, 0]}, r"twist\[0\]"),
        ({"q": np.full(7, np.inf)}, r"q\[0\]"),
        ({"dt": 0.0}, "dt"),
        ({"dt": np.nan}, "dt"),
        ({"damping": 0.0}, "damping"),
        ({"expressed_in": "world"}, "expressed_in"),
        ({"out": np.empty(6)}, "out"),
        ({"out": np.empty(7, dtype=np.float32)}, "out"),
        ({"q": np.zeros((3, 7)), "twist": np.zeros((2, 6))}, "twist: shape"),
    ],
)
def test_what_cannot_be_is_refused_by_name(panda, named, message):
    arguments = {"q": panda.home, "twist": np.zeros(6), "dt": DT, **named}
    with pytest.raises(InputError, match=message):
        panda.differential_ik(**arguments)


def test_manipulability_is_the_product_of_the_singular_values(panda):
    q = np.random.default_rng(2).uniform(panda.lower, panda.upper, (4, 5, 7))
    expected = np.linalg.svd(panda.jacobian(q), compute_uv=False).prod(axis=-1)
    np.testing.assert_allclose(panda.manipulability(q), expected, rtol=1e-9, atol=1e-12)
    planar = Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
    assert planar.manipulability([0.4, 0.0]) == pytest.approx(1.0)  # J'J = [[5, 3], [3, 2]]: a stretched arm still turns its end
    assert ulna.load("panda").manipulability(np.zeros(7)) < 1e-12


def test_a_link_that_no_joint_moves_has_no_manipulability(panda):
    assert panda.manipulability(panda.home, link="panda_link0") == 0.0
    np.testing.assert_array_equal(panda.manipulability(np.tile(panda.home, (2, 3, 1)), link="panda_link0"), np.zeros((2, 3)))
