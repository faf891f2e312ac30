"""Kernels over float32, run by the CPU: every operation is rounded to float32, as on a GPU."""

import numpy as np
import pytest

import robots
import ulna
from ulna.engine.lanes import sqrt, with_lane
from ulna.gpu.single import THRESHOLDS, in_single
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.collision.posed_pair import may_touch
from ulna.kernels.distance.box_sat import boxes_overlap, widest_gap
from ulna.kernels.layout import IN_BASE
from ulna.kernels.spatial.elementary import sincos

pytestmark = pytest.mark.compiler

UNIT = np.finfo(np.float32).eps
SURE = 1e-3  # of the sizes of two boxes


def single(numbers):
    return tuple(np.float32(x) for x in numbers)


def of_32_bits(values):
    return np.asarray(values).astype(np.float32).astype(np.float64)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_poses_and_jacobians_are_right_to_a_millionth(name):
    robot = ulna.load("panda") if name == "panda" else ulna.Robot.from_dh(robots.UR5, convention="standard")
    chain, n = robot.tree.chain(robot.tip).astype(np.float32), robot.n_dof
    pose, jacobian = in_single(chain_pose), in_single(chain_jacobian)
    J = np.zeros(6 * n, np.float32)
    for q in of_32_bits(robot.random(2000, seed=1)):
        T = pose(chain, q.astype(np.float32))
        assert type(T[0]) in {float, np.float32}
        assert {np.float32(x) for x in T} == set(T), "each is a float32"
        np.testing.assert_allclose(np.reshape(T, (3, 4)), robot.forward_kinematics(q)[:3], rtol=0, atol=1e-6)
        jacobian(chain, q.astype(np.float32), IN_BASE, J, 1, n)
        np.testing.assert_allclose(J.reshape(6, n), robot.jacobian(q), rtol=0, atol=1e-6)


def test_sine_and_cosine_are_those_of_a_float32_at_any_angle():
    of_single = in_single(sincos)
    for x in of_32_bits(np.random.default_rng(0).uniform(-1, 1, 2000) * np.geomspace(1e-6, 1e6, 2000)):
        np.testing.assert_allclose(of_single(np.float32(x)), (np.sin(x), np.cos(x)), rtol=0, atol=UNIT)


def touching_pair(rng, turn):
    """Two boxes that touch, the second turned by about so much beyond quarter turns: poses, half extents, and the way apart."""
    h, g = (of_32_bits(np.exp(rng.uniform(np.log(0.01), np.log(0.5), 3))) for _ in range(2))
    size = h.sum() + g.sum()
    A = ulna.pose(rng.uniform(-1, 1, 3), rng.uniform(-3, 3, 3))
    quarters = ulna.pose((0, 0, 0), np.pi / 2 * np.eye(3)[rng.integers(3)] * rng.integers(4))
    B = A @ quarters @ ulna.pose((0, 0, 0), turn * rng.uniform(-1, 1, 3))
    way = A[:3, rng.integers(3)] if rng.random() < 0.4 else rng.normal(size=3)
    way = way / np.linalg.norm(way)
    start = A[:3, 3] + rng.uniform(-0.2, 0.2, 3) * h.min()

    def at(s):
        return (*B[0, :3], (start + s * way)[0], *B[1, :3], (start + s * way)[1], *B[2, :3], (start + s * way)[2])

    low, high = 0.0, 4.0 * size
    for _ in range(45):
        middle = (low + high) / 2
        apart = widest_gap(tuple(A[:3].ravel()), tuple(h), at(middle), tuple(g))[0] > 0.0
        low, high = (low, middle) if apart else (middle, high)
    return tuple(A[:3].ravel()), tuple(h), at, tuple(g), low, size


@pytest.mark.slow
@pytest.mark.parametrize("turn", [3.0, 1e-2, 1e-3, 1e-4, 1e-6, 0.0])
def test_boxes_touch_where_they_do_by_float64_but_for_a_thousandth_of_their_sizes(turn):
    rng, overlap, verdicts = np.random.default_rng(7), in_single(boxes_overlap), set()
    for _ in range(400):
        a, h, at, g, touching, size = touching_pair(rng, turn)
        for share in (*rng.choice([-1, 1], 4) * np.geomspace(1e-7, 1e-1, 4), *rng.choice([-1, 1], 2) * SURE):
            b = at(touching + share * size)
            gap = widest_gap(a, h, b, g)[0]
            verdict = overlap(single(a), single(h), single(b), single(g))
            verdicts.add(verdict)
            assert verdict == (gap <= 0.0) or abs(gap) <= SURE * size
            assert verdict or gap > -1e-6 * size, "boxes in each other are never said to be apart"
    assert verdicts == {True, False}


def test_every_threshold_that_is_exchanged_is_there():
    for module, name in THRESHOLDS:
        home = __import__(module, fromlist=[name])
        assert 0.0 < getattr(home, name) < THRESHOLDS[module, name]


def test_what_has_no_form_over_float32_is_refused():
    def formula(x):
        return with_lane(x, 0, 1.0)

    with pytest.raises(LookupError, match="with_lane"):
        in_single(formula)


def test_an_attribute_with_the_name_of_a_function_is_not_taken_for_it():
    copy = in_single(may_touch)  # it reads ``scene.may_touch``
    assert "may_touch" not in copy.py_func.__globals__


def test_a_copy_leaves_the_function_as_it_is():
    def formula(x):
        return sqrt(x) * 0.1

    copy = in_single(formula)
    assert {type(constant) for constant in copy.__code__.co_consts} == {type(None), np.float32}
    assert {type(constant) for constant in formula.__code__.co_consts} == {type(None), float}
    assert in_single(formula) is copy
