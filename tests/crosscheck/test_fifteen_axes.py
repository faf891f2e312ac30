"""Boxes a hundredth apart or overlapping on each of the fifteen axes: the cases of Drake's geometry/proximity/test/
boxes_overlap_test.cc (RobotLocomotion/drake, commit 21b970c), of which these are the numbers.

A corner of B is laid 0.01 over, or under, a face of A (then the same with A and B swapped); an edge of B is laid 0.01 in both
directions across an edge of A. Half extents 2, 4, 3 and 3.5, 2, 1.5; turns of a fifth of pi.
"""

from functools import partial

import numpy as np
import pytest

import formulas
import kernel_modes
import solids
import ulna
from assertions import assert_close

A, B, TURN = np.array([2.0, 4.0, 3.0]), np.array([3.5, 2.0, 1.5]), np.pi / 5
MODES = kernel_modes.MODES


def turn(axis, angle):
    return formulas.rotation(np.eye(3)[axis], angle)


def corner_over_face(a, b, axis, offset):
    """T_a_b: the corner of b that lies deepest along the axis of a stands off the middle of a's face by the offset."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    R = turn(first, TURN) @ turn(second, -TURN)
    on_face = a.copy()
    on_face[[first, second]] /= 2
    on_face[axis] += offset
    return formulas.transform(R, on_face + R @ b)


def edge_over_edge(a, b, i, j, offset):
    """T_a_b: the edge of b along its axis j crosses the edge of a along its axis i, off it by the offset in both directions."""
    first, second = (j + 1) % 3, (j + 2) % 3
    if i == j:
        R = turn(first, TURN) @ turn(second, TURN)
    elif (i + 1) % 3 == j:
        R = turn(first, TURN) @ turn(second, -TURN)
    else:
        R = turn(second, -TURN) @ turn(first, TURN)
    on_edge, to_center = a.copy(), b.copy()
    on_edge[i], to_center[j] = a[i] / 2, b[j] / 2
    on_edge[[(i + 1) % 3, (i + 2) % 3]] += offset
    return formulas.transform(R, on_edge + R @ to_center)


def check(mode, a, b, T, offset):
    run = partial(kernel_modes.run, mode)
    for half_a, half_b, T_a_b in ((a, b, T), (b, a, np.linalg.inv(T))):
        pair = ulna.Box(tuple(2 * half_a)), np.eye(4), ulna.Box(tuple(2 * half_b)), T_a_b
        answer = solids.ask(run, [pair])
        solids.assert_proved([pair], answer)
        assert answer[4][0] == (offset < 0)
    return answer[0][0]


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("offset", [0.01, -0.01])
@pytest.mark.parametrize("axis", range(3))
def test_a_corner_over_a_face(mode, axis, offset):
    for a, b in ((A, B), (B, A)):
        assert_close(check(mode, a, b, corner_over_face(a, b, axis, offset), offset), offset, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("offset", [0.01, -0.01])
@pytest.mark.parametrize("j", range(3))
@pytest.mark.parametrize("i", range(3))
def test_an_edge_over_an_edge(mode, i, j, offset):
    d = check(mode, A, B, edge_over_edge(A, B, i, j, offset), offset)
    assert 0.01 - 1e-12 < d / np.sign(offset) < 0.01 * np.sqrt(2) + 1e-12


@pytest.mark.parametrize("mode", MODES)
def test_a_box_within_a_parallel_one(mode):
    d = check(mode, np.array([1.0, 2.0, 1.0]), np.array([0.5, 1.0, 0.5]), ulna.pose((0.2, 0.4, 0.2)), -1)
    assert_close(d, -1.3, atol=1e-15)  # out along x or z: 1 + 0.5 - 0.2
