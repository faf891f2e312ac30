"""Closed forms of arms of six joints: every family with random geometry, from either end, judged by forward kinematics.

That no branch is missing: the configuration that made a target is one of them, and a search from many starts finds no other.
"""

from dataclasses import replace

import numpy as np
import pytest

import formulas
import robots
import ulna
from closed_form_arms import FAMILIES, NAMES, QUARTIC, arm_of, arm_of_axes, direction, family_axes
from ik_methods import valid_solutions
from ulna import Robot
from ulna.description.robot_description import Joint, JointType, Limits, Link
from ulna.ik.options import Options
from ulna.ik.problem import Query, make_problem
from ulna.ik.search.branch_search import _branches

TURN = 2 * np.pi


def of_dh(rows):
    return Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 6)


def apart(a, b):
    """The largest difference of two configurations, whole turns aside."""
    return np.abs((a - b + np.pi) % TURN - np.pi).max(axis=-1)


def assert_reached(robot, found, T, most=1e-12):
    """Every solution reaches its target, by the product of matrices of the description."""
    for row, target in zip(found.q, T, strict=True):
        for q in row[~np.isnan(row[:, 0])]:
            assert np.abs(formulas.link_pose(robot.description, q, robot.tip) - target).max() < most


@pytest.mark.slow
@pytest.mark.parametrize("right_angles", [False, True])
@pytest.mark.parametrize("from_end", [False, True])
@pytest.mark.parametrize("family", FAMILIES, ids=NAMES.get)
def test_the_configuration_that_made_a_target_is_among_its_branches(family, from_end, right_angles):
    for seed in range(4):
        rng = np.random.default_rng([family, seed])
        robot = arm_of(family, rng, from_end=from_end, right_angles=right_angles)
        form = robot.closed_form
        assert (form.family, form.held, form.is_exact) == (NAMES[family], None, True)
        q = rng.uniform(-np.pi, np.pi, (400, 6))
        T = robot.forward_kinematics(q)
        found = robot.all_solutions(T)
        least = np.linalg.svd(robot.jacobian(np.where(found.real[..., None], found.q, q[:, None])), compute_uv=False)[..., -1]
        if family not in QUARTIC:  # of which a complex pair near a real root is in doubt where nothing is singular
            assert set(found.proof[least.min(axis=1) > 1e-4]) <= {"complete", "complete but for coinciding branches"}
        assert (found.proof == "complete").mean() > 0.99
        assert apart(np.where(found.real[..., None], found.q, 9.0), q[:, None]).min(axis=1).max() < 1e-6
        assert (found.real.sum(axis=1) % 2 == 0).all(), "real branches come in pairs"
        every = np.where(found.real[..., None], found.q, np.arange(8)[:, None] / 3.0)[found.proof == "complete"]
        between = apart(every[:, :, None], every[:, None]) + 9.0 * np.eye(8)
        assert between[found.real[found.proof == "complete"]].min() > 1e-7, "each is listed once"
        solutions = found.q[found.real]
        reached = robot.forward_kinematics(solutions)
        assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 1e-9
        assert_reached(robot, robot.all_solutions(T[:3]), T[:3])


@pytest.mark.parametrize("family", FAMILIES, ids=NAMES.get)
def test_a_search_from_many_starts_finds_the_same_branches(family):
    """The search of ``all_solutions`` for arms that have no closed form."""
    rng = np.random.default_rng(40 + family)
    robot = arm_of_axes(*family_axes(family, rng), np.random.default_rng(1))
    options = Options(position_tolerance=1e-9, rotation_tolerance=1e-9)
    query = Query(robot.tree, robot.home, robot._checker, robot.tip, options)
    for target in robot.forward_kinematics(rng.uniform(-np.pi, np.pi, (12, 6))):
        found, known = valid_solutions(robot, target), _branches(make_problem(query, target, None), 16)
        assert len(found) == len(known)
        assert all(apart(found, q).min() < 1e-4 for q in known)


# ---- singularities


SPOTS = {
    "ur5, wrist": (robots.UR5, 4, 0.0), "ur5, wrist turned": (robots.UR5, 4, np.pi), "ur5, elbow": (robots.UR5, 2, 0.0),
    "ur5, folded": (robots.UR5, 2, np.pi), "puma, wrist": (robots.PUMA, 4, 0.0),
    "puma, elbow": (robots.PUMA, 2, np.arctan2(0.0203, 0.4318) + np.pi / 2),
}  # fmt: skip


@pytest.mark.parametrize("off", [1e-1, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 0.0])
@pytest.mark.parametrize("spot", SPOTS)
def test_at_and_near_a_singularity_the_pose_is_reached_by_the_branch_of_its_configuration(spot, off):
    """Judged by the joints that stay determined: the first, and the one that makes it singular."""
    rows, joint, at = SPOTS[spot]
    robot = of_dh(rows)
    q = np.random.default_rng(7).uniform(-np.pi, np.pi, (300, 6))
    q[:, joint] = at + off
    T = robot.forward_kinematics(q)
    found = robot.all_solutions(T)
    assert found.real.any(axis=1).all()
    of_all = np.repeat(T, found.real.sum(axis=1), axis=0)
    assert np.abs(robot.forward_kinematics(found.q[found.real]) - of_all).max() < 1e-9
    near = np.where(found.real, apart(found.q[..., [0, joint]], q[:, None, [0, joint]]), 9.0).min(axis=1)
    assert near.max() < 1e-5
    arm_is_well = np.linalg.svd(robot.jacobian(q, link="link4")[:, :3, :3], compute_uv=False)[:, 2] > 0.02
    if joint == 4 and off in {0.0, 1e-12}:
        assert (found.proof[arm_is_well] == "continuum").all()
    if off == 0.1:
        assert (found.proof == "complete").all()
    seeded = robot.inverse_kinematics(T, q)
    assert seeded.success.all()
    if off in {0.1, 1e-7} and (joint, at) == (4, 0.0):
        assert apart(seeded.q, q)[arm_is_well].max() < 1e-6


def test_a_seed_chooses_the_angle_that_may_be_any():
    robot, puma = of_dh(robots.UR5), of_dh(robots.PUMA)
    q = np.array([0.3, -1.2, 1.1, 0.4, 0.0, 0.7])
    np.testing.assert_allclose(robot.inverse_kinematics(robot.forward_kinematics(q), q).q, q, atol=1e-9)
    np.testing.assert_allclose(puma.inverse_kinematics(puma.forward_kinematics(q), q).q, q, atol=1e-9)


def test_the_stretched_arm_with_a_singular_wrist_has_its_one_solution():
    """Both links stretched, and axes 4 and 6 parallel: only one value of the free angle reaches."""
    robot = of_dh(robots.UR5)
    for x in np.linspace(-3, 3, 40):
        q = np.array([0.3, -0.8, 0.0, 0.5, 0.0, x])
        result = robot.inverse_kinematics(robot.forward_kinematics(q))
        assert result.success
        assert result.position_error < 1e-9


# ---- detection


def test_arms_of_makers_have_their_families(panda):
    assert of_dh(robots.UR5E).closed_form.family == "axes 2, 3 and 4 parallel, 5 and 6 intersecting"
    assert of_dh(robots.PUMA).closed_form.family == "spherical wrist, axes 2 and 3 parallel"
    form = panda.closed_form
    assert (form.family, form.held, form.from_end, form.is_exact) == (
        "spherical wrist, axes 1 and 2 intersecting", "panda_joint7", True, True
    )  # fmt: skip
    assert "panda_joint7 held" in str(form)


def test_an_arm_without_a_family_has_none():
    rng = np.random.default_rng(3)
    robot = arm_of_axes(np.array([direction(rng) for _ in range(6)]), rng.normal(size=(6, 3)), rng)
    assert robot.closed_form is None
    T = robot.forward_kinematics([0.3, 0.2, 0.1, -0.4, 0.9, 0.5])
    found = robot.all_solutions(T)
    assert (found.proof, found.family) == ("searched", "")
    assert len(found.q[found.valid]) == len(valid_solutions(robot, T)) > 0


@pytest.mark.parametrize("size", [2.0**-12, 1.0, 2.0**9])
@pytest.mark.parametrize(("miss", "tier"), [(1e-14, "exact"), (1e-8, "near"), (1e-4, "near"), (1e-2, "another")])
def test_by_how_much_the_axes_miss_is_a_share_of_the_reach(size, miss, tier):
    rows = [(a * size, d * size, alpha, theta) for a, d, alpha, theta in robots.UR5]
    rows[4] = (miss * size, *rows[4][1:])  # axes 5 and 6 pass each other
    form = of_dh(rows).closed_form
    if tier == "another":  # axes 5 and 6 need not intersect where the other family has its offset
        assert (form.family, form.is_exact) == ("axes 2, 3 and 4 parallel", True)
        return
    assert ("exact" if form.is_exact else "near") == tier
    if tier == "near":
        assert 0.1 * miss < form.miss < 2 * miss


def test_a_form_that_is_nearly_right_seeds_and_proves_nothing():
    rows = [(a + 1e-8 * (k == 4), d, alpha, theta) for k, (a, d, alpha, theta) in enumerate(robots.UR5)]
    robot = of_dh(rows)
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (6, 6))
    found = robot.all_solutions(robot.forward_kinematics(q))
    assert (found.proof == "searched").all()
    assert apart(np.where(found.valid[..., None], found.q, 9.0), q[:, None]).min(axis=1).max() < 1e-6


# ---- what the solver makes of it


@pytest.fixture(scope="module")
def ur5():
    return Robot.from_dh(robots.UR5, convention="standard", limits=[(-TURN, TURN)] * 6)


def test_with_a_seed_the_nearest_branch_is_taken_whole_turns_and_all(ur5):
    rng = np.random.default_rng(6)
    q, seeds = rng.uniform(-np.pi, np.pi, (50, 6)), rng.uniform(-TURN, TURN, (50, 6))
    T = ur5.forward_kinematics(q)
    every = ur5.all_solutions(T, whole_turns=True)
    nearest = np.where(every.valid, np.abs(every.q - seeds[:, None]).max(axis=-1), np.inf).min(axis=1)
    result = ur5.inverse_kinematics(T, seeds)
    assert result.success.all()
    np.testing.assert_allclose(np.abs(result.q - seeds).max(axis=1), nearest, atol=1e-9)


@pytest.mark.parametrize("n", [1, 3, 4, 9])
def test_a_row_is_the_same_bit_for_bit_whatever_the_batch(ur5, n):
    q = np.random.default_rng(6).uniform(-np.pi, np.pi, (n, 6))
    T = ur5.forward_kinematics(q)
    whole = ur5.inverse_kinematics(T, q + 0.1)
    for i in range(n):
        alone = ur5.inverse_kinematics(T[i], q[i] + 0.1)
        assert alone.q.tobytes() == whole.q[i].tobytes()
        assert alone.residual.tobytes() == whole.residual[i].tobytes()


def test_limits_choose_among_the_branches_and_say_by_how_much_they_are_passed():
    T = of_dh(robots.UR5).forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])
    every = of_dh(robots.UR5).all_solutions(T)
    for q in every.q[every.valid]:
        limits = np.column_stack([q - 1e-3, q + 1e-3])
        only = Robot.from_dh(robots.UR5, convention="standard", limits=limits)
        np.testing.assert_allclose(only.inverse_kinematics(T).q, q, atol=1e-9)
        limits[0] = q[0] + 0.05, q[0] + 0.06
        beyond = Robot.from_dh(robots.UR5, convention="standard", limits=limits).inverse_kinematics(T)
        assert beyond.status == "joint limits"
        assert beyond.limit_excess.max() == pytest.approx(0.05, abs=1e-3)


def test_a_configuration_at_its_limits_is_within_them(ur5):
    rng = np.random.default_rng(8)
    for _ in range(30):
        q = rng.uniform(-2, 2, 6)
        limits = np.column_stack([q, q + 0.2])
        robot = Robot.from_dh(robots.UR5, convention="standard", limits=limits)
        result = robot.inverse_kinematics(ur5.forward_kinematics(q))
        assert result.success
        assert ((robot.lower <= result.q) & (result.q <= robot.upper)).all()


def test_targets_in_a_batch_are_solved_or_explained_each_by_itself(ur5):
    q = np.random.default_rng(6).uniform(-np.pi, np.pi, (6, 6))
    T = ur5.forward_kinematics(q)
    T[2, :3, 3] = 9.0, 0.0, 0.0
    result = ur5.inverse_kinematics(T.reshape(2, 3, 4, 4))
    assert result.status.tolist() == [["solved", "solved", "unreachable"], ["solved"] * 3]
    alone = ur5.inverse_kinematics(T[2])
    assert result.reach_excess[0, 2] == alone.reach_excess > 7.0
    np.testing.assert_array_equal(result.q[0, 2], alone.q)


def test_a_rotation_that_is_rounded_to_seven_digits_is_reached_within_the_tolerance(ur5):
    T = np.round(ur5.forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4]), 7)
    result = ur5.inverse_kinematics(T)
    assert result.success
    assert result.iterations == 0


def test_joints_that_do_not_move_the_link_stay_at_the_seed():
    """A UR5 behind a wheel of its own and with a finger: six of eight joints move the hand."""
    description = of_dh(robots.UR5).description
    wheel = Joint("wheel", JointType.REVOLUTE, "link3", "tyre", np.eye(4), robots.Z, Limits(-1.0, 1.0))
    finger = Joint("finger", JointType.PRISMATIC, "link6", "tip", np.eye(4), robots.Z, Limits(0.0, 0.1))
    links, joints = (*description.links, Link("tyre"), Link("tip")), (*description.joints, wheel, finger)
    robot = Robot(replace(description, links=links, joints=joints))
    seed = np.zeros(8)
    seed[[robot.joint_names.index("wheel"), robot.joint_names.index("finger")]] = 0.7, 0.06
    q = np.random.default_rng(6).uniform(-np.pi, np.pi, (5, 6))
    T = of_dh(robots.UR5).forward_kinematics(q)
    several, found = robot.inverse_kinematics(T, seed, link="link6"), robot.all_solutions(T, link="link6")
    assert several.success.all()
    assert (found.proof == "complete").all()
    for row, target in zip(several.q, T, strict=True):
        one = robot.inverse_kinematics(target, seed, link="link6")
        assert one.q.tobytes() == row.tobytes()
        assert (one.iterations, one.q[seed != 0.0].tolist()) == (0, seed[seed != 0.0].tolist())
        np.testing.assert_allclose(robot.forward_kinematics(one.q, link="link6"), target, atol=1e-12)
    with pytest.raises(ulna.InputError, match="q_seed"):
        robot.inverse_kinematics(T[0], np.where(seed == 0.7, np.nan, seed), link="link6")


def test_every_target_that_is_not_solved_has_its_reason_and_is_no_farther_off_than_by_search(ur5):
    """Targets drawn out by a quarter: those that the search alone leaves unexplained are proved to be out of reach."""
    narrow = Robot.from_dh(robots.UR5, convention="standard", limits=[(-2.0, 2.0)] * 6)
    T = narrow.forward_kinematics(np.random.default_rng(9).uniform(-2, 2, (60, 6)))
    T[:, :3, 3] *= 1.25
    for robot in (ur5, narrow):
        result = robot.inverse_kinematics(T)
        searched = robot.inverse_kinematics(T, robot.home, max_step=100.0)  # with a largest step there is a search
        assert set(result.status) <= {"solved", "unreachable", "joint limits"}
        np.testing.assert_array_equal(result.success, searched.success)
        off, by_search = ((x.residual[~x.success] ** 2).sum(axis=1) for x in (result, searched))
        assert (off <= 1.05 * by_search + 1e-12).mean() > 0.95
        beyond = result.status == "joint limits"
        assert (result.limit_excess[beyond].max(axis=-1) > 0).all()
        assert (result.limit_excess[~beyond] == 0).all()
        every = robot.all_solutions(T)
        np.testing.assert_array_equal(result.status == "unreachable", ~every.real.any(axis=1) & ~result.success)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0.3, -0.5, 0.2)])
def test_a_whole_pose_about_another_axis_is_the_same_pose(ur5, axis):
    T = ur5.forward_kinematics(np.random.default_rng(6).uniform(-np.pi, np.pi, (3, 6)))
    for target in (T, T[0]):
        result = ur5.inverse_kinematics(target, task=ulna.Task(axis=axis))
        assert np.all(result.success)
        np.testing.assert_allclose(ur5.forward_kinematics(result.q), target, atol=3e-5)
    assert len(valid_solutions(ur5, T[0], task=ulna.Task(axis=axis))) == len(valid_solutions(ur5, T[0]))


def test_what_is_no_pose_is_refused(ur5):
    bad = np.stack([np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])])
    for call in (ur5.inverse_kinematics, ur5.all_solutions):
        with pytest.raises(ulna.InputError, match=r"T\[1\].*reflection"):
            call(bad)
