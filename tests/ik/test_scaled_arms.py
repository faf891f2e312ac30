"""An arm scaled by any factor, with its targets, has the same solutions: angles equal, slides scaled, and as much is proved."""

import numpy as np
import pytest

import robots
import ulna
from ulna import Robot

HALF = np.pi / 2
SCALES = [1e-4, 1e-3, 5e-3, 1e-2, 0.1, 10.0, 1e3, 5e3]
SLIDE_AND_WRIST = [
    (0, 0.3, -HALF, 0), (0.2, 0.1, HALF, 0), (0, 0.2, 0, 0), (0, 0.25, -HALF, 0), (0, 0, HALF, 0), (0, 0.1, 0, 0),
]  # fmt: skip
SCARA = [(0.325, 0.4, 0, 0), (0.275, 0, np.pi, 0), (0, 0.1, 0, 0), (0, 0, 0, 0)]
GANTRY = [
    (0, 0, -HALF, -HALF), (0, 0, -HALF, -HALF), (0, 0, 0, 0), (0, 0.1, -HALF, 0), (0, 0, HALF, 0), (0, 0.08, 0, 0),
]  # fmt: skip
TURN, SLIDE = "revolute", "prismatic"
ARMS = {
    "UR5": (robots.UR5, [TURN] * 6, [(-np.pi, np.pi)] * 6),
    "a slide and a wrist": (
        SLIDE_AND_WRIST,
        [TURN, TURN, SLIDE, TURN, TURN, TURN],
        [(-2.9, 2.9), (-2.5, 2.5), (-0.1, 0.4), (-3, 3), (-2, 2), (-3, 3)],
    ),
    "SCARA": (SCARA, [TURN, TURN, SLIDE, TURN], [(-2.9, 2.9), (-2.6, 2.6), (0, 0.25), (-3.1, 3.1)]),
    "gantry": (GANTRY, [SLIDE] * 3 + [TURN] * 3, [(-0.8, 0.8)] * 3 + [(-3, 3), (-2, 2), (-3, 3)]),
}  # fmt: skip


def scaled(name, scale):
    """The arm, and the units of its entries of q."""
    rows, kinds, limits = ARMS[name]
    units = np.where(np.array(kinds) == SLIDE, scale, 1.0)
    given = {"joint_types": kinds, "limits": np.array(limits) * units[:, None]}
    return Robot.from_dh(np.array(rows) * (scale, scale, 1, 1), convention="standard", **given), units


def configurations(name):
    """Some within the limits, some with a joint at a limit, and one with a slide beyond its limit by a fifth of the range."""
    _, kinds, limits = ARMS[name]
    low, high = np.array(limits).T
    q = np.random.default_rng(4).uniform(low, high, (8, len(kinds)))
    slides = np.flatnonzero(np.array(kinds) == SLIDE)
    q[1, 0], q[2, -1] = low[0], high[-1]
    q[3, slides], q[4, slides], q[5, slides] = high[slides], low[slides], (high + 0.2 * (high - low))[slides]
    return q


def solutions(name, scale):
    robot, units = scaled(name, scale)
    found = [robot.all_solutions(robot.forward_kinematics(q * units)) for q in configurations(name)]
    return [(one.q[one.valid] / units, one.q[one.real] / units, str(one.proof), str(one.reason or "")) for one in found]


def apart(a, b):
    """How far each of the configurations a is from each of b, whole turns aside."""
    difference = a[:, None] - b[None]
    return np.minimum(np.abs(difference), np.abs(difference - 2 * np.pi * np.rint(difference / 2 / np.pi))).max(axis=2)


def are_the_same(a, b):
    """Whether two sets of configurations are one."""
    return a.shape == b.shape and (not len(a) or max(apart(a, b).min(axis=0).max(), apart(a, b).min(axis=1).max()) < 1e-6)


@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")
@pytest.mark.parametrize("name", ARMS)
def test_a_scaled_arm_has_the_same_solutions(name):
    judge, within = solutions(name, 1.0), configurations(name)
    assert any(len(valid) for valid, *_ in judge)
    for k, (valid, *_) in enumerate(judge):
        if k != 5:
            assert apart(valid, within[k : k + 1]).min() < 1e-8, "what the target is made of is a solution"
    for scale in SCALES:
        for one, other in zip(solutions(name, scale), judge, strict=True):
            assert one[2:] == other[2:]
            assert are_the_same(one[0], other[0])
            assert are_the_same(one[1], other[1])


def test_an_arm_of_millimeters_with_a_slide_beyond_its_limit_keeps_all_its_branches():
    """Of eight branches two have the slide 0.8 mm beyond its limit, which is a fifth of its range, not hardly."""
    x, y, z = np.eye(3)
    first, second, last = (-1.694, 0.283, 1.615), (-3.005, 0.252, 0.331), (-0.369, -1.706, 0.296)
    q = np.array([-1.494, 0.368, 1.078, 0.467, 2.049, -3.551])
    known = None
    for scale in (1.0, 1e-4, 1e-3, 2e-3, 5e-3):
        points, units = np.array([first] * 3 + [second] * 2 + [last]) * scale, np.array([1, 1, 1, 1, 1, scale])
        text, before = "<robot name='r'><link name='l0'/>", np.zeros(3)
        for k, (axis, p) in enumerate(zip((-z, y, -x, x, y, z), points, strict=True)):
            kind, most = ("prismatic", 4 * scale) if k == 5 else ("revolute", 6.2)
            text += (
                f"<joint name='j{k}' type='{kind}'><parent link='l{k}'/><child link='l{k + 1}'/>"
                f"<origin xyz='{' '.join(map(repr, (p - before).tolist()))}'/><axis xyz='{' '.join(map(str, axis))}'/>"
                f"<limit lower='{-most}' upper='{most}' velocity='1' effort='1'/></joint><link name='l{k + 1}'/>"
            )
            before = p
        robot = ulna.load(text + "</robot>")
        T = robot.forward_kinematics(q * units)
        found = robot.all_solutions(T)
        real = found.q[found.real] / units
        assert str(found.proof) == "complete"
        np.testing.assert_allclose(robot.forward_kinematics(real * units), np.broadcast_to(T, (len(real), 4, 4)), atol=1e-9)
        assert (apart(real, real) + np.eye(len(real))).min() > 1e-3, "none is listed twice"
        known = len(real) if known is None else known
        assert len(real) == known
