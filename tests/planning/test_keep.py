"""Motions that keep a constraint: what is certified holds at all times, judged by dense samples and a slow twin."""

import _thread
import pickle
import threading
from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.kernels.planning.constraint_records import Entry
from ulna.planning.constrained_goals import shortest_rotation
from ulna.planning.constraint_table import as_keeps, make_constraint_table
from ulna.planning.entries import keeping
from ulna.planning.positions import PositionLimits

STACK = """<robot name="stack"><link name="base"/><link name="cart"/><link name="arm"/><link name="wheel"/><link name="hand"/>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><origin xyz="0.1 0 0.2" rpy="0.3 0.2 0"/>
    <axis xyz="1 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="arm"/><origin xyz="0 0.2 0.1" rpy="0 0.5 0.4"/>
    <axis xyz="0 1 0.3"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="geared" type="revolute"><parent link="arm"/><child link="wheel"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/><mimic joint="turn" multiplier="-1.5" offset="0.2"/></joint>
  <joint name="wrist" type="continuous"><parent link="wheel"/><child link="hand"/><origin xyz="0.3 0 0.1" rpy="1 0 0"/>
    <axis xyz="1 0 0"/></joint></robot>"""


def constraints(T):
    """One of each kind, about a pose; and all components with tolerances of their own."""
    return {
        "upright": ulna.Keep.upright(within=0.2),
        "axis": ulna.Keep.upright(within=0.3, axis=T[:3, :3].T @ (0.1, 0, 1), along=(0, 0, 2)),
        "orientation": ulna.Keep.orientation(within=0.3),
        "line": ulna.Keep.on_line(T[:3, 3] - (0, 0.3, 0), T[:3, 3] + (0, 1, 0), within=0.05),
        "plane": ulna.Keep.in_plane(T, within=0.03),
        "inside": ulna.Keep.inside((0.3, np.inf, 0.2), T),
        "all": ulna.Keep(ulna.Task((0.1, 0.2, 0.15, 0.4, 0.4, 0.4)), T=T),
        "pointing": ulna.Keep(ulna.Task((0.1, 0.2, 0.15, 0.4, 0.4, np.inf), axis=(1, 0, 1)), T=T),
    }


def shares(keep, T_start, T):
    """The share of a tolerance that is used at poses (n, 4, 4): the slow twin, by definition, with angles by arc tangents."""
    T_0, axis, slack = (T_start if keep.T is None else keep.T), np.array(keep.task.axis), np.array(keep.task.slack)
    if keep.along is not None:
        axis = T_start[:3, :3].T @ keep.along
    axes = ulna.Task(tuple(slack), tuple(axis.tolist())).frame[:3, :3]
    away = np.abs((T[:, :3, 3] - T_0[:3, 3]) @ (T_0[:3, :3] @ axes)) / slack[:3]
    if np.isinf(slack[3]):
        return away.max(axis=1)
    if np.isinf(slack[5]):
        a, b = T[:, :3, :3] @ axis, T_0[:3, :3] @ axis
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b)
    else:
        turned = np.einsum("ji,njk->nik", T_0[:3, :3], T[:, :3, :3])
        skew = np.stack([turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0], turned[:, 1, 0] - turned[:, 0, 1]])
        angle = np.arctan2(np.linalg.norm(skew, axis=0), np.trace(turned, axis1=1, axis2=2) - 1)
    return np.maximum(away.max(axis=1), np.sin(angle / 2) / np.sin(slack[3] / 2))


def along(q_a, q_b, n=2001):
    return q_a + np.linspace(0, 1, n)[:, None] * (q_b - q_a)


@pytest.fixture(scope="module", params=["panda", "stack"])
def robot(request, panda):
    return panda if request.param == "panda" else ulna.load(STACK)


@pytest.mark.parametrize("name", constraints(np.eye(4)))
@pytest.mark.parametrize("size", [0.03, 0.3, 2.0])
def test_the_bound_of_an_edge_is_above_every_sample_and_hardly_more_than_the_greatest(robot, name, size):
    rng, start = np.random.default_rng(3), robot.home + 0.1
    T_start = robot.forward_kinematics(start)
    keep = constraints(T_start)[name]
    for _ in range(25):
        q_a, q_b = start + rng.normal(scale=size, size=(2, robot.n_dof))
        q_a = start if rng.random() < 0.5 else q_a
        keep_at = keep if keep.T is not None else as_keeps(keep, robot.tree, start)[0]
        report = robot.edge_keeps(q_a, q_b, keep_at)
        greatest = shares(keep, T_start, robot.forward_kinematics(along(q_a, q_b))).max()
        assert greatest <= report.violation + 1e-12
        assert report.violation <= greatest + 0.0011 * max(1, greatest) + 1e-5
        if abs(greatest - 1) > 1e-3:
            assert report.kept == (greatest < 1)
            assert bool(report) == report.kept


def test_edges_of_a_batch_are_judged_as_one_by_one(panda):
    q_b = panda.home + np.random.default_rng(0).normal(scale=0.1, size=(3, 4, 7))
    keep = ulna.Keep.upright(within=0.1)
    together = panda.edge_keeps(panda.home, q_b, keep)
    assert together.kept.shape == together.violation.shape == (3, 4)
    assert 0 < together.kept.sum() < 12
    for k in np.ndindex(3, 4):
        one = panda.edge_keeps(panda.home, q_b[k], keep)
        assert (one.kept, one.violation) == (together.kept[k], together.violation[k])
    with pytest.raises(ulna.TruthError):
        bool(together)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["upright", "orientation", "line", "plane", "pointing"])
def test_a_projection_keeps_the_constraint_and_the_limits(panda, name):
    start = panda.home
    keeps = as_keeps(constraints(panda.forward_kinematics(start))[name], panda.tree, start)
    space = Entry.records(7)
    space["low"], space["high"] = panda.lower, panda.upper
    space["low"][2] = space["high"][2] = start[2]
    room = keeping.make_keeping(panda.tree.joints, make_constraint_table(keeps, panda.tree), space)
    q = np.clip(start + np.random.default_rng(1).normal(scale=0.4, size=(8, 7)), panda.lower, panda.upper)
    q[:, 2], q[0] = start[2], start
    rows = np.ascontiguousarray(q.T)
    keeping.project(panda.tree.joints, room, start, np.zeros(7), rows)
    assert (rows[:, 0] == start).all()
    assert (rows[2] == start[2]).all()
    kept = [panda.edge_keeps(row, row, keeps).kept for row in np.ascontiguousarray(rows.T)]
    assert np.mean(kept) > 0.8
    np.testing.assert_array_equal(rows.T, np.clip(rows.T, panda.lower, panda.upper))


def turned_about_the_base(panda):
    """From one side of the post to the other: what is about the base's axis is the same at both."""
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    return left, right


def plans(panda):
    left, right = turned_about_the_base(panda)
    T = panda.forward_kinematics(left)
    level = ulna.pose(T[:3, 3])
    return left, right, {
        "upright": ulna.Keep.upright(within=np.radians(5)),
        "level": ulna.Keep.in_plane(level, within=1e-3),
        "both": (ulna.Keep.upright(within=0.05), ulna.Keep.inside((2, 2, 0.2), level)),
    }  # fmt: skip


@pytest.mark.parametrize("name", ["upright", "level", "both"])
def test_a_plan_its_motion_and_a_shorter_plan_keep_it_at_all_times(panda, world, name):
    left, right, each = plans(panda)
    keep = each[name]
    plan = panda.plan(left, right, world, keep=keep)
    assert plan
    assert plan.certified
    assert panda.plan(left, right, world).worst_violation == 0
    T_start = panda.forward_kinematics(left)
    shorter = plan.improve(300)
    assert shorter.length <= plan.length
    motion = plan.trajectory(acceleration=5.0)
    dense = motion.at(np.linspace(0, motion.duration, 20001)).q
    for path in (plan.at(np.linspace(0, 1, 20001)), shorter.at(np.linspace(0, 1, 20001)), dense):
        T = panda.forward_kinematics(path)
        used = max(shares(one, T_start, T).max() for one in (keep if isinstance(keep, tuple) else (keep,)))
        assert used <= 1
        assert not panda.in_collision(path[::20], world).any()
    assert motion.certified
    assert motion.is_free(world, keep=keep)
    assert not panda.trajectory([left, left + 0.5, right], acceleration=5.0).is_free(None, keep=keep)
    greatest = max(
        shares(one, T_start, panda.forward_kinematics(along(a, b))).max()
        for one in (keep if isinstance(keep, tuple) else (keep,))
        for a, b in zip(plan.path[:-1], plan.path[1:], strict=True)
    )
    assert greatest <= plan.worst_violation <= min(1, greatest + 0.0011)


@pytest.mark.parametrize("seed", [0, 2, 4])
def test_a_motion_flows_through_the_corners_of_a_tight_constraint(panda, world, seed):
    left, right = turned_about_the_base(panda)
    T = panda.forward_kinematics(left)
    keep = ulna.Keep.in_plane(ulna.pose(T[:3, 3]), within=1e-4)
    motion = panda.plan(left, right, world, keep=keep, seed=seed).trajectory(acceleration=5.0)
    assert motion.stops == 0
    assert motion.certified
    assert motion.is_free(world, keep=keep)
    q = motion.at(np.linspace(0, motion.duration, 20001)).q
    assert shares(keep, T, panda.forward_kinematics(q)).max() <= 1


@pytest.mark.slow
@pytest.mark.parametrize("limits", [{"limits": "franka"}, {"acceleration": 5.0, "jerk": 50.0}])
def test_a_motion_within_limits_of_jerk_flows_through_the_corners_of_a_tight_constraint(panda, world, limits):
    left, right = turned_about_the_base(panda)
    T = panda.forward_kinematics(left)
    keep = ulna.Keep.in_plane(ulna.pose(T[:3, 3]), within=1e-4)
    plan = panda.plan(left, right, world, keep=keep, seed=2)
    motion = plan.trajectory(**limits)
    assert len(plan.path) > 100
    assert motion.stops == 0
    assert motion.certified
    assert motion.check()
    assert motion.is_free(world, keep=keep)
    q = motion.at(np.linspace(0, motion.duration, 50_001)).q
    assert shares(keep, T, panda.forward_kinematics(q)).max() <= 1


def turned_orientation(panda, within):
    """A plan along an orientation that is kept so tightly."""
    T = panda.forward_kinematics(panda.home)
    T[:3, 3] += [-0.1, 0.35, 0.1]
    goal = panda.inverse_kinematics(T, panda.home).q
    keep = ulna.Keep.orientation(within=within)
    return panda.plan(panda.home, goal, ulna.World(), keep=keep), keep


@pytest.mark.slow
@pytest.mark.parametrize("within", [1e-5, 1e-6])
@pytest.mark.parametrize("limits", [{"limits": "franka"}, {"acceleration": 1.0, "jerk": 5.0}])
def test_an_orientation_within_a_microradian_is_kept_without_stops(panda, within, limits):
    """It stopped at each of some hundred points: a search makes edges that use all of the tolerance."""
    plan, keep = turned_orientation(panda, within)
    motion = plan.trajectory(**limits)
    assert motion.stops == 0
    assert motion.certified
    assert motion.check(period=1e-4)
    assert motion.is_free(ulna.World(), keep=keep)
    T = panda.forward_kinematics(motion.sampled(1e-4).q)
    assert shares(keep, panda.forward_kinematics(panda.home), T).max() <= 1


def test_a_finer_path_has_the_same_ends_and_uses_little_of_a_tolerance(panda):
    plan, keep = turned_orientation(panda, 1e-4)
    points = plan._motion.subdivide(plan.path, PositionLimits(panda.lower, panda.upper))
    T_start = panda.forward_kinematics(panda.home)
    edges = [shares(keep, T_start, panda.forward_kinematics(along(a, b, 51))).max() for a, b in pairwise(points)]
    assert len(points) > len(plan.path)
    assert np.array_equal(points[[0, -1]], plan.path[[0, -1]])
    assert max(edges[:-1]) <= 0.26  # the last one ends at a goal that may be anywhere within the tolerance
    assert max(shares(keep, T_start, panda.forward_kinematics(along(a, b))).max() for a, b in pairwise(plan.path)) > 0.9


def test_a_motion_that_takes_longer_to_compute_than_it_may_is_refused(panda):
    plan, _ = turned_orientation(panda, 1e-5)
    with pytest.raises(
        ulna.InputError, match="time_limit: 1e-09 s are over; a tight constraint or a low limit of jerk"
    ) as caught:
        plan.trajectory(acceleration=1.0, jerk=5.0, time_limit=1e-9)
    assert caught.value.argument == "time_limit"


@pytest.mark.parametrize("jerk", [100.0, 500.0])
def test_a_motion_along_a_tight_constraint_is_not_slower_than_its_certificate_asks(panda, jerk):
    """With roundings half as large the mean is certified at full acceleration: that is tried before less acceleration is."""
    T = ulna.pose((0.45, 0.3, 0.5), (np.pi, 0, 0)), ulna.pose((0.45, -0.3, 0.5), (np.pi, 0, 0))
    left, right = (panda.inverse_kinematics(each, panda.home).q for each in T)
    keep = ulna.Keep.in_plane(ulna.pose((0.45, 0.3, 0.5)), within=1e-4)
    plan = panda.plan(left, right, keep=keep, seed=0)
    motion, quick = (plan.trajectory(acceleration=5.0, jerk=most) for most in (jerk, 1e4))
    assert motion.certified
    assert motion.is_free(ulna.World(), keep=keep)
    assert motion.duration <= 1.1 * quick.duration


def test_a_constraint_that_is_always_kept_takes_hardly_more_edges_than_none(panda, world):
    """What touches is refused by one certificate, and not followed in parts."""
    left, right = turned_about_the_base(panda)
    always = ulna.Keep.inside((9, 9, 9), np.eye(4))
    plans = [[panda.plan(left, right, world, seed=seed, shorten=False, keep=keep) for seed in range(10)] for keep in ((), always)]
    free, kept = (sum(plan.checks for plan in each) for each in plans)
    assert all(all(each) for each in plans)
    assert kept <= 1.5 * free


def test_without_the_constraint_the_plan_would_not_keep_it(panda, world):
    left, right, each = plans(panda)
    path = panda.plan(left, right, world).path
    assert not panda.edge_keeps(path[:-1], path[1:], as_keeps(each["upright"], panda.tree, left)).kept.all()


@pytest.mark.slow
def test_the_same_call_gives_the_same_bits_and_a_pickled_plan_goes_on(panda, world):
    left, right, each = plans(panda)
    plan = panda.plan(left, right, world, keep=each["upright"], seed=3)
    np.testing.assert_array_equal(plan.path, panda.plan(left, right, world, keep=each["upright"], seed=3).path)
    with ulna.threads(2):
        many = panda.plan_many(left, np.stack([right, right]), world, keep=each["upright"], seed=3)
    np.testing.assert_array_equal(many[1].path, plan.path)
    again = pickle.loads(pickle.dumps(plan))  # noqa: S301 - our own
    assert again.worst_violation == plan.worst_violation
    np.testing.assert_array_equal(again.improve(50).path, plan.improve(50).path)


def test_a_start_or_a_goal_outside_says_which_and_by_how_much(panda):
    left, right = turned_about_the_base(panda)
    low = ulna.Keep.inside((2, 2, 0.1), ulna.pose((0, 0, 0.1)))
    plan = panda.plan(left, right, keep=low)
    assert plan.status == ulna.PlanStatus.START_OUTSIDE
    (violation,) = plan.reason.data
    away = panda.forward_kinematics(left)[2, 3] - 0.1
    assert violation.quantity == "z"
    assert violation.value == pytest.approx(away)
    assert violation.tolerance == pytest.approx(0.05)
    assert " mm along z; " in str(plan)
    tilted = right.copy()
    tilted[5] += 0.3
    plan = panda.plan(left, tilted, keep=ulna.Keep.upright(within=0.1))
    assert plan.status == ulna.PlanStatus.GOAL_OUTSIDE
    assert plan.reason.data[0].value == pytest.approx(0.3)
    several = panda.plan(left, [tilted, right], keep=ulna.Keep.upright(within=0.1))
    assert several.goal == 1


def test_a_spent_budget_says_how_many_edges_do_not_keep_it(panda, world):
    left, right, each = plans(panda)
    plan = panda.plan(left, right, world, keep=each["level"], max_checks=30)
    assert plan.status == ulna.PlanStatus.BUDGET_SPENT
    assert plan.reason.data.not_kept > 0
    assert "violate the constraints" in str(plan)


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda _: ulna.Keep.upright(within=0.0), "within"),
        (lambda _: ulna.Keep.upright(within=np.pi), "within"),
        (lambda _: ulna.Keep.upright(within=4), "within"),
        (lambda _: ulna.Keep.orientation(within=4), "within"),
        (lambda _: ulna.Keep.looking_at((1, 0, 0), within=4), "within"),
        (lambda _: ulna.Keep.together("panda_link1", "panda_ee", within=(0.1, 4)), "within"),
        (lambda _: ulna.Keep(ulna.Task((0, 0, 0, 4, 4, 4))), "task"),
        (lambda _: ulna.Keep.upright(within=0.1, axis=(0, 0, 0)), "axis"),
        (lambda _: ulna.Keep.on_line((0, 0, 0), (0, 0, 0)), "b"),
        (lambda _: ulna.Keep.on_line((0, 0), (0, 0, 0)), "a"),
        (lambda _: ulna.Keep.in_plane(np.eye(3)), "T"),
        (lambda _: ulna.Keep.inside((1, 1, 0), np.eye(4)), "extents"),
        (lambda _: ulna.Keep.inside((np.inf,) * 3, np.eye(4)), "extents"),
        (lambda _: ulna.Keep(ulna.Task((1, 1, 1, 0.1, 0.2, 0.3))), "task"),
        (lambda _: ulna.Keep(ulna.Task.pose(), along=(0, 0, 1)), "along"),
        (lambda robot: robot.plan(robot.home, robot.home, keep="upright"), "keep"),
        (lambda robot: robot.plan(robot.home, robot.home, keep=[1]), "keep"),
        (lambda robot: robot.plan(robot.home, robot.home, keep=ulna.Keep.upright(link="panda_link0")), "keep"),
        (lambda robot: robot.plan(robot.home, robot.home, keep=ulna.Keep.upright(), escape=True), "escape"),
        (lambda robot: robot.edge_keeps(robot.home, robot.home, ()), "keep"),
    ],
)
def test_what_cannot_be_kept_is_refused_by_name(panda, make, argument):
    with pytest.raises(ulna.InputError) as refused:
        make(panda)
    assert refused.value.argument == argument


def test_an_unknown_link_is_refused_with_what_it_may_have_meant(panda):
    with pytest.raises(ulna.UnknownNameError, match="did you mean 'panda_ee'"):
        panda.plan(panda.home, panda.home, keep=ulna.Keep.upright(link="panda_hnd"))


@pytest.mark.parametrize("name", ["axis", "line", "plane", "inside", "all", "pointing"])
def test_a_configuration_that_keeps_a_constraint_is_found_by_inverse_kinematics(panda, name):
    keep = constraints(panda.forward_kinematics(panda.home + 0.1))[name]
    for q_seed in panda.home + np.random.default_rng(4).normal(scale=0.5, size=(8, 7)):
        found = panda.inverse_kinematics(keep, q_seed)
        assert found.success
        assert panda.edge_keeps(found.q, found.q, keep).kept


@pytest.mark.parametrize(
    ("keep", "options", "argument"),
    [
        (ulna.Keep.upright(), {}, "T"),
        (ulna.Keep.looking_at((0, 0, 1)), {}, "T"),
        (ulna.Keep.together("panda_link1", "panda_ee", T=np.eye(4)), {}, "T"),
        (ulna.Keep.in_plane(np.eye(4)), {"task": "position"}, "task"),
        (ulna.Keep.in_plane(np.eye(4), link="panda_ee"), {"link": "panda_link5"}, "link"),
    ],
)
def test_a_constraint_that_is_no_target_is_refused_by_name(panda, keep, options, argument):
    with pytest.raises(ulna.InputError) as refused:
        panda.inverse_kinematics(keep, **options)
    assert refused.value.argument == argument


def test_a_slack_of_0_becomes_the_default_tolerance():
    assert ulna.Keep(ulna.Task.pose()).task.slack == pytest.approx((1e-4,) * 3 + (np.radians(0.1),) * 3)


def test_the_shortest_turn_brings_one_direction_to_the_other_about_what_is_normal_to_both():
    rng = np.random.default_rng(0)
    pairs = [(a / np.linalg.norm(a), b / np.linalg.norm(b)) for a, b in rng.normal(size=(50, 2, 3))]
    pairs += [(a, s * a) for a, _ in pairs[:10] for s in (1, -1)]
    for a, b in pairs:
        R = shortest_rotation(a, b)
        np.testing.assert_allclose(R @ a, b, atol=1e-12)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1)
        assert np.trace(R) == pytest.approx(1 + 2 * (a @ b))


@pytest.mark.parametrize(
    ("task", "keep"),
    [
        ("position", ulna.Keep.upright(within=0.05)),
        ("position", ulna.Keep.orientation(0.02)),
        ("pointing", ulna.Keep.orientation(0.02)),
    ],
)
def test_what_a_goal_leaves_free_is_turned_onto_the_constraint(panda, task, keep):
    start, T = panda.home, ulna.pose((0.3, 0.4, 0.4), rpy=(np.pi, 0, 1.3) if task == "pointing" else (2.0, 0.5, 0.3))
    plan = panda.plan(start, T, task=task, keep=keep)
    assert plan
    reached = panda.forward_kinematics(plan.path[-1])
    np.testing.assert_allclose(reached[:3, 3], T[:3, 3], atol=1e-6)
    if task == "pointing":
        np.testing.assert_allclose(reached[:3, 2], T[:3, 2], atol=1e-6)
    path = panda.forward_kinematics(plan.at(np.linspace(0, 1, 5001)))
    assert shares(keep, panda.forward_kinematics(start), path).max() <= 1


def test_a_goal_that_another_link_has_to_keep_is_looked_for_among_more_configurations(panda):
    start = panda.home
    T, elbow = panda.forward_kinematics(start), panda.forward_kinematics(start, link="panda_link4")
    turned = start + 0.0
    turned[6] -= 0.5
    goal = panda.forward_kinematics(turned)
    keep = ulna.Keep.inside((0.02, 0.02, 0.02), elbow, link="panda_link4")
    plan = panda.plan(start, goal, keep=keep)
    assert plan
    np.testing.assert_allclose(panda.forward_kinematics(plan.path[-1]), goal, atol=1e-6)
    off = panda.forward_kinematics(plan.at(np.linspace(0, 1, 5001)), link="panda_link4")[:, :3, 3] - elbow[:3, 3]
    assert np.abs(off @ elbow[:3, :3]).max() <= 0.01
    assert not np.allclose(goal, T)


def test_a_plan_is_improved_along_a_tight_constraint(panda, world):
    left, right, _ = plans(panda)
    keep = ulna.Keep.upright(within=np.radians(0.5))
    plan = panda.plan(left, right, world, keep=keep, seed=3)
    shorter = plan.improve(20_000)
    assert shorter.length < 0.9 * plan.length
    assert shorter.certified
    path = panda.forward_kinematics(shorter.at(np.linspace(0, 1, 20001)))
    assert shares(keep, panda.forward_kinematics(left), path).max() <= 1


@pytest.mark.usefixtures("interruptible")
def test_a_long_search_along_a_constraint_is_ended_by_an_interrupt(panda):
    """The hand has to stay in front of the arm, where a wall is in its way at all heights."""
    left, right = turned_about_the_base(panda)
    wall, middle = ulna.World(), ulna.pose((2.15, 0, 0))
    wall.add("in front", ulna.Box((4, 0.02, 4)), middle)
    keep = [ulna.Keep.upright(0.1), ulna.Keep.inside((4, 4, 4), middle)]
    assert panda.plan(left, right, wall, keep=keep, max_checks=300).status == "budget spent"
    timer = threading.Timer(0.5, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        panda.plan(left, right, wall, keep=keep, max_checks=10**15, time_limit=60)
    timer.join()
