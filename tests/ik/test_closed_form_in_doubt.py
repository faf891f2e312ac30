"""Where rounding leaves little of an angle the closed form claims no more than it knows: at double roots, and behind them.

Each target is made by a configuration, so it has a solution, and a claim of completeness without it is false.
"""

import copy

import numpy as np
import pytest

import formulas
import robots
import ulna
from closed_form_arms import FAMILIES, arm_of, arm_of_axes, family_axes
from ik_methods import valid_solutions
from matrix import matrix
from ulna import Robot
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link
from ulna.kernels.chain import closed_form_layout as layout

TURN = 2 * np.pi
HALF = np.pi / 2
X, Y, Z = np.eye(3)
PUMA = [
    (0, 0.672, HALF, 0), (0.4318, 0, 0, 0), (0.0203, 0.15005, -HALF, 0),
    (0, 0.4318, HALF, 0), (0, 0, -HALF, 0), (0, 0.05, 0, 0),
]  # fmt: skip
PUMA_ELBOW_AT_ITS_END = -1.5238184104468142


@pytest.fixture(scope="module")
def puma():
    return Robot.from_dh(PUMA, convention="standard", limits=[(-np.pi, np.pi)] * 6)


def arm(kinds, h, c, tool=None):
    """An arm of joints that turn (R) about an axis h through c, or slide (P) along it."""
    links = tuple(Link(f"l{k}") for k in range(len(kinds) + 2))
    steps = np.diff(np.vstack([np.zeros(3), c]), axis=0)
    kind_of = {"R": (JointType.REVOLUTE, Limits(-np.pi, np.pi)), "P": (JointType.PRISMATIC, Limits(-5.0, 5.0))}
    joints = [
        Joint(f"j{k}", kind_of[kind][0], f"l{k}", f"l{k + 1}", formulas.transform(np.eye(3), steps[k]), h[k], kind_of[kind][1])
        for k, kind in enumerate(kinds)
    ]
    tool = np.eye(4) if tool is None else tool
    return Robot(Description("arm", links, (*joints, Joint("tool", JointType.FIXED, f"l{len(kinds)}", links[-1].name, tool, Z))))


def claims_all(found):
    return np.char.startswith(np.asarray(found.proof).astype(str), "complete")


def distance(found, q):
    """The distance of the solution nearest to q of each target, whole turns aside; 9 where there is none."""
    off = np.abs((np.where(found.real[..., None], found.q, 0.0) - q[:, None] + np.pi) % TURN - np.pi).max(axis=-1)
    return np.where(found.real, off, 9.0).min(axis=1)


def wrist_singular(robot):
    """The angle of joint 5 at which the determinant of the Jacobian changes its sign, by bisection."""

    def determinant(angle):
        return np.linalg.det(robot.jacobian(np.concatenate([robot.home[:4], [angle], robot.home[5:]])))

    a, b, sign = -0.3, 0.3, np.sign(determinant(-0.3))
    for _ in range(60):
        middle = (a + b) / 2
        a, b = (middle, b) if determinant(middle) * sign > 0 else (a, middle)
    return a


@pytest.mark.parametrize(("name", "tip"), [("so100", None), ("so101", "moving_jaw_so101_v1_link")])
@pytest.mark.parametrize("off", [0.0, 1e-8, 1e-7, 1e-6, 1e-5])
def test_near_the_singularity_of_an_offset_wrist_nothing_is_missing_from_what_is_called_complete(name, tip, off):
    robot = ulna.load(name, tip=tip)
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, (300, 6))
    q[:, 4] = wrist_singular(robot) + off
    T = robot.forward_kinematics(q)
    found = robot.all_solutions(T)
    sure = claims_all(found)
    assert found.real[sure].any(axis=1).all()
    assert distance(found, q)[sure].max(initial=0.0) < 0.1
    off_by = np.abs(robot.forward_kinematics(found.q[found.real]) - np.repeat(T, found.real.sum(axis=1), axis=0)).max(axis=(1, 2))
    assert off_by.max() < 3e-5  # the tolerance of a search
    assert off_by[np.repeat(sure, found.real.sum(axis=1))].max(initial=0.0) < 1e-8
    result = robot.inverse_kinematics(T[:100], position_tolerance=1e-8, rotation_tolerance=1e-8)
    assert "unreachable" not in set(result.status)


def test_a_straight_wrist_behind_an_elbow_at_its_end_is_a_continuum(puma):
    """The elbow's double root moves the wrist off its singularity by 1e-8: q_4 and q_6 may still be any with the same sum."""
    rng = np.random.default_rng(1)
    q = rng.uniform(-2, 2, (60, 6))
    q[:, 2], q[:, 4] = PUMA_ELBOW_AT_ITS_END, 0.0
    T = puma.forward_kinematics(q)
    assert np.abs(puma.forward_kinematics(q + np.array([0, 0, 0, 0.5, 0, -0.5])) - T).max() < 1e-14
    assert set(puma.all_solutions(T).proof) == {"continuum"}


def test_a_path_that_exists_is_not_proved_to_end(puma):
    """Both along such poses and through one of them."""
    for seed in range(8):
        rng = np.random.default_rng(seed)
        q = rng.uniform(-2, 2, 6)
        q[[2, 4]] = PUMA_ELBOW_AT_ITS_END, 0.0
        along = np.tile(q, (12, 1))
        along[:, 5] += np.linspace(0, 0.8, 12)
        along[:, 1] += np.linspace(0, 0.3, 12)
        through = q + np.arange(-6, 7)[:, None] * rng.uniform(-0.05, 0.05, 6)
        for path in (along, through):
            followed = puma.follow(puma.forward_kinematics(path), q_start=path[0])
            assert followed.success or followed.proof == "searched"


def test_four_joints_at_right_angles_have_the_solution_that_made_the_target():
    robot = arm("PRRR", [-Z, X, -Y, Z], [[0, 0, 0], [0, -0.3, 0], [0, -0.3, 0], [-0.3, -0.3, 0]])
    q = np.array([HALF, -HALF, 0.0, np.pi])
    found = robot.all_solutions(robot.forward_kinematics(q))
    assert distance(ulna.IKSolutions(found.q[None], found.valid[None], found.real[None], found.proof, ""), q[None])[0] < 1e-6


def test_a_slide_of_almost_nothing_before_a_turn_at_its_end_loses_no_solution():
    """The turn is determined by 1e-6 of the arm's length, and its two branches are one: the branches are off by 3e-3."""
    robot = arm("RRP", [Y, -X, Z], [[0, 0.2, 0], [0, 0.2, 0], [0.1, 0.2, 0]])
    q = np.array([[2.838805566, -HALF - 1e-9, -6.977782893e-07]])
    found = robot.all_solutions(robot.forward_kinematics(q))
    assert found.real.any()
    assert np.abs(robot.forward_kinematics(found.q[found.real]) - robot.forward_kinematics(q)).max() < 1e-8


# ---- links whose origin is on the last axis, and what no form can solve


@pytest.mark.parametrize(
    ("name", "link"), [("ur5", "forearm_link"), ("anymal", "LF_SHANK"), ("z1", "link03"), ("talos", "head_2_link")]
)
def test_the_links_of_three_and_four_joints_of_named_robots_have_their_solutions(name, link):
    robot = ulna.load(name)
    q = np.clip(np.random.default_rng(0).uniform(-0.5, 0.5, (10, robot.n_dof)), robot.lower, robot.upper)
    T = robot.forward_kinematics(q, link=link)
    found = robot.all_solutions(T, link=link)
    assert found.real.any(axis=1).all()
    assert set(found.proof) == {"complete"}
    reached = robot.forward_kinematics(found.q[found.real], link=link)
    assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 1e-9


def test_where_the_form_has_nothing_to_say_there_is_a_search():
    gimbal = arm("RRR", [Z, Y, X], np.zeros((3, 3)))
    T = gimbal.forward_kinematics([0.3, 0.4, 0.5])
    found = gimbal.all_solutions(T)
    assert (found.proof, int(found.real.sum())) == ("searched", len(valid_solutions(gimbal, T)))
    rows = [(0, 0.36, -HALF, 0), (0, 0, HALF, 0), (0, 0.42, HALF, 0), (0, 0, -HALF, 0), (0, 0.4, -HALF, 0), (0, 0, HALF, 0)]
    iiwa = Robot.from_dh([*rows, (0, 0.126, 0, 0)], convention="standard", limits=[(-2.9, 2.9)] * 7)
    T = iiwa.forward_kinematics([0.1, 0.5, 0.2, -1, 0.3, 0.7, 0.1])
    found = iiwa.all_solutions(T, redundancy="joint4")
    assert found.valid.any()
    assert np.abs(iiwa.forward_kinematics(found.q[found.valid]) - T).max() < 1e-6


# ---- geometry that is too near to another


@pytest.mark.parametrize(("skewness", "has_form"), [(1.2e-3, False), (4e-3, True), (2.5e-2, True), (0.1, True)])
@pytest.mark.parametrize(("i", "j"), [(0, 1), (4, 3), (5, 4)])
def test_a_quartic_of_nearly_parallel_axes_is_refused_and_misses_nothing_where_it_is_not(skewness, has_form, i, j):
    rng = np.random.default_rng([3, i])
    h, c = family_axes(layout.OFFSET_HAND, rng)
    t = np.cross(h[j], rng.normal(size=3))
    h[i] = robots.unit(*(h[j] + skewness * t / np.linalg.norm(t)))
    robot = arm_of_axes(h, c, rng)
    assert (robot.closed_form is not None) == has_form
    if has_form:
        q = rng.uniform(-np.pi, np.pi, (2000, 6))
        found = robot.all_solutions(robot.forward_kinematics(q))
        assert distance(found, q)[claims_all(found)].max() < 1e-2
        assert claims_all(found).mean() > 0.95


FOUND_FALSE = [
    (layout.OFFSET_HAND, 378578221, True,
     [-2.56378838320586, -3.141592653608277, -2.8812433286044965, -1.485859633667882, 0.22654419201705403, -2.700760052141264]),
    (layout.OFFSET_HAND, 278457868, False,
     [-0.2120810289235769, -2.124906900898335, -0.6794751519522948, -0.3228961504321959, -9.614e-15, 1.9722720966685512]),
    (layout.ANY_THREE_AXES, 88294068, False,
     [1.1765046782147888, 1.568953635879139, -1.015487521607951, 1.1742126304497815, 0.9044845743623449, -1.019357616332248]),
    (layout.ANY_THREE_AXES, 152662153, False,
     [0.6858566192656741, 1.5494351602894043, -2.014798491428718, -2.45240524804042, -0.39450057615815304, -1.842232202755195]),
]  # fmt: skip


@pytest.mark.parametrize(("family", "seed", "from_end", "q"), FOUND_FALSE)
def test_quartics_of_two_and_three_nearly_equal_roots_are_not_called_complete_without_one(family, seed, from_end, q):
    """Double roots at which Newton's step was rounding over rounding, and threefold ones of which a pair was called complex."""
    robot, q = arm_of(family, np.random.default_rng(seed), from_end=from_end, right_angles=True), np.array([q])
    for T in (robot.forward_kinematics(q), robot.forward_kinematics(np.tile(q, (9, 1)))):  # one, and eight at a time
        found = robot.all_solutions(T)
        assert not (claims_all(found) & (distance(found, np.tile(q, (len(T), 1))) > 0.01)).any()


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("far", matrix([1e2, 1e3, 1e4], [1e3]))
def test_a_base_far_from_the_arm_is_no_proof_of_more_than_its_digits_tell(family, far):
    """Elbows nearly at their end: what two large numbers leave of a small one decides whether a pair of branches is real."""
    rng = np.random.default_rng([family, int(far)])
    h, c = family_axes(family, rng)
    robot = arm_of_axes(h, c + far * robots.unit(*rng.normal(size=3)), rng)
    q = near_singular(robot, rng, 2000 if robot.closed_form.is_exact else 50)  # the others are searched
    T = robot.forward_kinematics(q)
    found = robot.all_solutions(T)
    assert not (claims_all(found) & (distance(found, q) > 0.03)).any()
    if far < 1e4:  # beyond, the axes themselves are known too badly
        assert robot.closed_form.is_exact
        assert claims_all(found).mean() > 0.3


def near_singular(robot, rng, n):
    """Configurations (about n, 6), 1e-16 to 0.1 rad from where the determinant of the Jacobian changes its sign."""
    a = rng.uniform(-np.pi, np.pi, (4 * n, 6))
    b = a + rng.uniform(-1.0, 1.0, a.shape)

    def sign(q):
        return np.sign(np.linalg.det(robot.jacobian(q)))

    at_a, crosses = sign(a), sign(a) != sign(b)
    a, b, at_a = a[crosses][:n], b[crosses][:n], at_a[crosses][:n]
    for _ in range(56):
        middle = (a + b) / 2
        same = (sign(middle) == at_a)[:, None]
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    way = rng.normal(size=a.shape)
    return a + 10.0 ** rng.uniform(-16, -1, (len(a), 1)) * way / np.linalg.norm(way, axis=1, keepdims=True)


@pytest.mark.parametrize("offset", [1e-17, 1e-12, 1e-8, 1e-3])
def test_a_gantry_whose_offsets_are_rounding_reaches_its_targets(offset):
    robot = arm("PPP", [X, Y, Z], [[0, 0, 0], [0, 0, offset], [0, 0, 2 * offset]])
    q = np.random.default_rng(1).uniform(-5, 5, (200, 3))
    for task in ("position", "pose"):
        found = robot.all_solutions(robot.forward_kinematics(q), task=task)
        assert set(found.proof) == {"complete"}
        np.testing.assert_allclose(found.q[found.real], q, atol=1e-9)


def test_a_copy_of_solutions_is_read_only(puma):
    found = puma.all_solutions(puma.forward_kinematics(np.full(6, 0.3))[None])
    for other in (copy.copy(found), copy.deepcopy(found)):
        assert not any(array.flags.writeable for array in (other.q, other.valid, other.real, other.proof))
        np.testing.assert_array_equal(other.q, found.q)


@pytest.mark.parametrize("right", [HALF, 1.5707963, 1.57079632, 1.5708])
@pytest.mark.parametrize("make", ["ur5", "puma"])
def test_right_angles_that_a_file_rounds_claim_no_more_than_is_found(make, right):
    """A wrist that is nearly straight then bends by the rounding: its branches are apart by its root."""
    ur5 = [
        (0, 0.0892, right, 0), (-0.425, 0, 0, 0), (-0.3923, 0, 0, 0),
        (0, 0.1092, right, 0), (0, 0.0947, -right, 0), (0, 0.0823, 0, 0),
    ]  # fmt: skip
    puma = [(a, d, np.copysign(right, alpha) if alpha else 0, 0) for a, d, alpha, _ in PUMA]
    robot = Robot.from_dh(ur5 if make == "ur5" else puma, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (4000, 6))
    q[:, 4] = np.where(q[:, 4] > 0.0, np.pi, 0.0) + np.logspace(-12, -3, len(q))
    found = robot.all_solutions(robot.forward_kinematics(q))
    off = distance(found, q)
    assert not (claims_all(found) & (off > 0.01)).any()
    assert (off < 0.01).mean() > 0.2
