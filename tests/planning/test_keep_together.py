"""Constraints of a link as another one sees it, and of an axis that points at a point: bounds against a slow twin, and plans."""

import pickle

import numpy as np
import pytest

import two_arms
import ulna
from ulna.kernels.planning.constraint_records import Entry
from ulna.planning.constrained_goals import relative_goal_poses
from ulna.planning.constraint_table import as_keeps, make_constraint_table
from ulna.planning.entries import keeping

HANDS = "left_hand", "right_hand"
AXIS = np.array([1.0, 0.2, 0.0])
SLIDE = """<robot name="slide"><link name="base"/><link name="cart"/><link name="arm"/><link name="hand"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="cart"/><origin xyz="0.1 0 0.2" rpy="0.3 0.2 0"/>
    <axis xyz="0 1 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="cart"/><child link="arm"/><origin xyz="0 0.2 0.1" rpy="0 0.5 0.4"/>
    <axis xyz="0 1 0.3"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="geared" type="revolute"><parent link="arm"/><child link="hand"/><origin xyz="0.4 0 0.2"/><axis xyz="1 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/><mimic joint="slide" multiplier="-1.5" offset="0.2"/></joint></robot>"""


@pytest.fixture(scope="module", params=["two arms", "one chain"])
def case(request):
    """A robot and two of its links: on two arms of a torso that turns, or one before the other."""
    if request.param == "one chain":
        return ulna.load(SLIDE), ("hand", "cart")
    return ulna.load(two_arms.URDF), HANDS


def constraints(T, point):
    """Each kind, of a link seen from another one at T at first; and those that look at a point of the base."""
    return {
        "together": ulna.Keep.together("a", "b", T=T, within=(0.1, 0.2)),
        "slack": ulna.Keep(ulna.Task((0.1, np.inf, 0.15, 0.4, 0.4, np.inf), axis=(1, 0, 1)), T=T),
        "looking": ulna.Keep.looking_at(point, axis=AXIS, within=0.3),
    }


def shares(keep, T):
    """The share of the tolerance that is used at poses (n, 4, 4): by definition, with angles by arc tangents."""
    slack = np.array(keep.task.slack)
    a = T[:, :3, :3] @ keep.task.axis
    b = np.broadcast_to(keep.T[:3, :3] @ keep.task.axis, a.shape)
    if keep.towards:
        b = (keep.T[:3, 3] - T[:, :3, 3]) / np.linalg.norm(keep.T[:3, 3] - T[:, :3, 3], axis=1)[:, None]
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
    if not keep.keeps_axis:
        turned = np.einsum("ji,njk->nik", keep.T[:3, :3], T[:, :3, :3])
        skew = np.stack([turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0], turned[:, 1, 0] - turned[:, 0, 1]])
        angle = np.arctan2(np.linalg.norm(skew, axis=0), np.trace(turned, axis1=1, axis2=2) - 1)
    away = np.abs((T[:, :3, 3] - keep.T[:3, 3]) @ (keep.T[:3, :3] @ keep.task.frame[:3, :3])) / slack[:3]
    return np.maximum(away.max(axis=1), np.sin(angle / 2) / np.sin(slack[3] / 2))


def seen(robot, q, link, other):
    T = robot.forward_kinematics(q, link=link)
    return T if other is None else np.linalg.inv(robot.forward_kinematics(q, link=other)) @ T


def with_links(keep, link, other):
    return ulna.Keep(keep.task, keep.T, link, relative_to=other, towards=keep.towards)


@pytest.mark.parametrize("name", ["together", "slack", "looking", "looking at what moves"])
@pytest.mark.parametrize("size", [0.03, 0.3, 2.0])
def test_the_bound_of_an_edge_is_above_every_sample_and_hardly_more_than_the_greatest(case, name, size):
    robot, (first, second) = case
    rng = np.random.default_rng(3)
    link, other = (first, None) if name == "looking" else (first, second)
    for _ in range(25):
        start = rng.normal(scale=0.5, size=robot.n_dof)
        T = seen(robot, start, link, other)
        keep = with_links(constraints(T, T[:3, 3] + T[:3, :3] @ (0.3 * AXIS))[name.split()[0]], link, other)
        q_a, q_b = start + rng.normal(scale=size, size=(2, robot.n_dof))
        report = robot.edge_keeps(q_a, q_b, keep)
        way = q_a + np.linspace(0, 1, 2001)[:, None] * (q_b - q_a)
        greatest = shares(keep, seen(robot, way, link, other)).max()
        assert greatest <= report.violation + 1e-12
        assert report.violation <= greatest + 0.0011 * max(1, greatest) + 3e-5  # samples may miss the greatest by so much
        if abs(greatest - 1) > 1e-3:
            assert report.kept == (greatest < 1)


def test_links_seen_from_the_base_are_bounded_as_without_another_link(case):
    robot, (link, _) = case
    rng = np.random.default_rng(5)
    base = robot.link_names[0]
    q_a, q_b = rng.normal(scale=0.5, size=(2, robot.n_dof))
    keep = ulna.Keep(ulna.Task.pose(), T=seen(robot, q_a, link, None), link=link)
    report = robot.edge_keeps(q_a, q_b, keep)
    assert robot.edge_keeps(q_a, q_b, with_links(keep, link, base)).violation == pytest.approx(report.violation, rel=1e-12)
    turned = ulna.Keep(ulna.Task.pose(), T=np.linalg.inv(keep.T), link=base, relative_to=link)  # the base as the link sees it
    assert robot.edge_keeps(q_a, q_a, turned).violation < 0.0011
    assert robot.edge_keeps(q_a, q_b, turned).violation > 1


def test_an_edge_along_which_the_link_passes_through_the_point_is_refused(case):
    robot, (link, _) = case
    q_a, q_b = np.random.default_rng(5).normal(scale=0.5, size=(2, robot.n_dof))
    T = seen(robot, 0.5 * (q_a + q_b), link, None)
    report = robot.edge_keeps(q_a, q_b, ulna.Keep.looking_at(T[:3, 3], axis=AXIS, within=3.0, link=link))
    assert not report.kept
    assert 1 < report.violation <= 1 / np.sin(1.5) + 0.002


@pytest.mark.parametrize("name", ["together", "slack", "looking", "looking at what moves"])
def test_a_projection_keeps_the_constraint_and_the_limits(name):
    robot = ulna.load(two_arms.URDF)
    link, other = (HANDS[1], None) if name == "looking" else HANDS
    start = np.random.default_rng(2).normal(scale=0.5, size=robot.n_dof)
    T = seen(robot, start, link, other)
    keep = with_links(constraints(T, T[:3, 3] + T[:3, :3] @ (0.3 * AXIS))[name.split()[0]], link, other)
    keeps = as_keeps(keep, robot.tree, start)
    space = Entry.records(robot.n_dof)
    space["low"], space["high"] = robot.lower, robot.upper
    space["low"][2] = space["high"][2] = start[2]
    room = keeping.make_keeping(robot.tree.joints, make_constraint_table(keeps, robot.tree), space)
    q = start + np.random.default_rng(1).normal(scale=0.4, size=(8, robot.n_dof))
    q[:, 2], q[0] = start[2], start
    rows = np.ascontiguousarray(q.T)
    keeping.project(robot.tree.joints, room, start, np.zeros(robot.n_dof), rows)
    assert (rows[:, 0] == start).all()
    assert (rows[2] == start[2]).all()
    kept = [robot.edge_keeps(row, row, keeps).kept for row in np.ascontiguousarray(rows.T)]
    assert np.mean(kept) > 0.8
    np.testing.assert_array_equal(rows.T, np.clip(rows.T, robot.lower, robot.upper))


@pytest.fixture(scope="module")
def tray(panda):
    """Two Pandas beside each other, a world with a post, a configuration with both hands at a tray, and a goal."""
    text = panda.to_urdf()
    text = text[text.index("<link") : text.index("</robot>")]
    arms = "".join(
        text.replace('"panda_', f'"{side}_') + f'<joint name="{side}_mount" type="fixed"><parent link="table"/>'
        f'<child link="{side}_link0"/><origin xyz="0 {y} 0"/></joint>'
        for side, y in (("left", 0.3), ("right", -0.3))
    )
    robot = ulna.load(f'<robot name="cell"><link name="table"/>{arms}</robot>')
    world = ulna.World()
    world.add("post", ulna.Box((0.05, 0.05, 0.5)), ulna.pose((0.45, 0, 0)))

    def hands(x, y, z):
        return {f"{side}_ee": ulna.pose((x, y + d, z), rpy=(np.pi, 0, 0)) for side, d in (("left", 0.2), ("right", -0.2))}

    start = robot.plan(np.tile(panda.home, 2), hands(0.4, 0, 0.4), world).path[-1]
    return robot, world, start, hands(0.5, 0.1, 0.45)


def test_two_hands_carry_a_tray_and_the_plan_says_how_well_at_all_times(tray):
    robot, world, start, goal = tray
    keep = ulna.Keep.together("left_ee", "right_ee")
    plan = robot.plan(start, goal, world, keep=(keep, ulna.Keep.upright(0.1, link="left_ee")))
    assert plan, str(plan)
    assert plan.certified
    motion = plan.trajectory(acceleration=5.0)
    assert motion.certified
    T_0 = seen(robot, start, "right_ee", "left_ee")
    keep_there = ulna.Keep.together("left_ee", "right_ee", T=T_0)
    for q in (plan.at(np.linspace(0, 1, 20001)), motion.at(np.linspace(0, motion.duration, 20001)).q, plan.improve(50).path):
        used = shares(keep_there, seen(robot, q, "right_ee", "left_ee")).max()
        assert used <= 1
        assert not robot.in_collision(q[::20], world).any()
    greatest = max(
        shares(keep_there, seen(robot, a + np.linspace(0, 1, 501)[:, None] * (b - a), "right_ee", "left_ee")).max()
        for a, b in zip(plan.path[:-1], plan.path[1:], strict=True)
    )
    assert greatest <= plan.worst_violation <= 1
    free = robot.plan(start, goal, world).path
    assert not robot.edge_keeps(free[:-1], free[1:], keep_there).kept.all()


def test_the_same_call_gives_the_same_bits_and_a_pickled_plan_goes_on(tray):
    robot, world, start, goal = tray
    keep = pickle.loads(pickle.dumps(ulna.Keep.together("left_ee", "right_ee")))  # noqa: S301 - our own
    plan = robot.plan(start, goal, world, keep=keep, seed=3)
    with ulna.threads(2):
        many = robot.plan_many(np.stack([start, start]), [plan.path[-1]] * 2, world, keep=keep, seed=3)
    np.testing.assert_array_equal(many[0].path, many[1].path)
    np.testing.assert_array_equal(plan.path, robot.plan(start, goal, world, keep=keep, seed=3).path)
    again = pickle.loads(pickle.dumps(plan))  # noqa: S301 - our own
    assert again.worst_violation == plan.worst_violation
    np.testing.assert_array_equal(again.improve(30).path, plan.improve(30).path)


@pytest.mark.parametrize(("given", "fixed_to"), [("left_ee", "left_ee"), ("right_ee", "right_ee"), ("left_ee", "left_link8")])
def test_a_pose_of_one_hand_is_a_goal_of_both(tray, given, fixed_to):
    robot, world, start, goal = tray
    T = goal[given] @ seen(robot, start, fixed_to, given)
    plan = robot.plan(start, T, world, link=fixed_to, keep=ulna.Keep.together("left_ee", "right_ee"))
    two_arms.assert_arrives(robot, plan, goal)
    held = seen(robot, start, "right_ee", "left_ee")
    used = shares(
        ulna.Keep.together("left_ee", "right_ee", T=held), seen(robot, plan.at(np.linspace(0, 1, 2001)), "right_ee", "left_ee")
    )
    assert used.max() <= 1
    by_name = robot.plan(start, {fixed_to: T}, world, keep=ulna.Keep.together("left_ee", "right_ee"))
    np.testing.assert_allclose(by_name.path[-1], plan.path[-1], atol=1e-9)


def test_of_several_poses_of_one_hand_one_is_reached_with_both(tray):
    robot, world, start, goal = tray
    far = ulna.pose((0, 0.5, 0)) @ goal["left_ee"]  # where the right arm does not reach its end of the tray
    keep = ulna.Keep.together("left_ee", "right_ee")
    plan = robot.plan(start, np.stack([far, goal["left_ee"]]), world, link="left_ee", keep=keep)
    assert plan.goal == 1
    two_arms.assert_arrives(robot, plan, goal)
    alone = robot.plan(start, far, world, link="left_ee", keep=keep)
    assert alone.status == ulna.PlanStatus.GOAL_UNREACHABLE
    assert str(alone.reason).startswith("right_ee: ")


@pytest.mark.slow
def test_what_the_goal_of_one_hand_leaves_free_is_the_same_for_both(tray):
    robot, world, start, goal = tray
    keeps = ulna.Keep.together("left_ee", "right_ee"), ulna.Keep.upright(0.1, link="left_ee")
    T = goal["left_ee"] @ ulna.pose(rpy=(0.4, 0.3, 0.2))
    plan = robot.plan(start, [T, T], world, link="left_ee", task="position", keep=keeps)
    assert plan, str(plan)
    assert plan.certified
    assert plan.goal in {0, 1}
    end = robot.forward_kinematics(plan.path[-1], link="left_ee")
    np.testing.assert_allclose(end[:3, 3], T[:3, 3], atol=2e-5)
    assert end[2, 2] < -np.cos(0.1)
    held = seen(robot, start, "right_ee", "left_ee")
    np.testing.assert_allclose(seen(robot, plan.path[-1], "right_ee", "left_ee"), held, atol=5e-5)


def test_links_of_one_chain_have_no_goals_of_their_own(panda):
    T = panda.forward_kinematics(panda.home)
    keeps = as_keeps(ulna.Keep.together("panda_link5", "panda_ee"), panda.tree, panda.home)
    assert relative_goal_poses({"panda_ee": T}, keeps, panda.tree) == {}
    assert relative_goal_poses({"panda_link5": T}, keeps, panda.tree) == {}


def test_a_goal_where_the_hands_are_farther_apart_says_so(tray):
    robot, world, start, goal = tray
    apart = {"left_ee": ulna.pose((0, 0.05, 0)) @ goal["left_ee"], "right_ee": goal["right_ee"]}
    plan = robot.plan(start, apart, world, keep=ulna.Keep.together("left_ee", "right_ee"))
    assert plan.status == ulna.PlanStatus.GOAL_OUTSIDE
    violation = plan.reason.data[0]
    assert (violation.link, violation.relative_to, violation.quantity) == ("right_ee", "left_ee", "y")
    assert violation.value == pytest.approx(0.05, abs=1e-4)
    assert "right_ee relative to left_ee is " in str(plan)


def test_a_hand_keeps_looking_at_what_the_other_one_holds(tray):
    robot, world, start, goal = tray
    part = seen(robot, start, "right_ee", "left_ee")[:3, 3] + (0, 0, 0.3)
    keep = ulna.Keep.looking_at(part, axis=(0, 0, 1), within=0.2, link="right_ee", relative_to="left_ee")
    plan = robot.plan(start, goal, world, keep=keep)
    assert plan, str(plan)
    assert plan.certified
    assert shares(keep, seen(robot, plan.at(np.linspace(0, 1, 5001)), "right_ee", "left_ee")).max() <= plan.worst_violation
    aside = ulna.Keep.looking_at(part + np.array([0.3, 0, 0]), axis=(0, 0, 1), within=0.2, link="right_ee", relative_to="left_ee")
    (violation,) = robot.plan(start, goal, world, keep=aside).reason.data
    assert violation.value == pytest.approx(np.pi / 4, abs=1e-3)


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda _: ulna.Keep.together("left_hand", "left_hand"), ulna.InputError, "never moves relative to itself"),
        (lambda _: ulna.Keep.together("left_hand", "right_hand", within=(0, 1e-3)), ulna.InputError, "within"),
        (lambda _: ulna.Keep.together("left_hand", "right_hand", within=1e-3), ulna.InputError, "two tolerances"),
        (lambda _: ulna.Keep.looking_at((0, 0)), ulna.InputError, "point"),
        (lambda _: ulna.Keep.looking_at((0, 0, 0), within=0.0), ulna.InputError, "within"),
        (lambda _: ulna.Keep(ulna.Task.pointing(), towards=True), ulna.InputError, "towards"),
        (lambda _: ulna.Keep(ulna.Task.pose(), T=np.eye(4), towards=True), ulna.InputError, "towards"),
        (
            lambda _: ulna.Keep.together("left_5", "left_hand"),
            ulna.InputError,
            "moves link 'left_hand' relative to 'left_5'",
        ),
        (lambda _: ulna.Keep.together("left_hnd", "right_hand"), ulna.UnknownNameError, "did you mean 'left_hand'"),
        (lambda _: ulna.Keep.together("left_hand", "right_hnd"), ulna.UnknownNameError, "did you mean 'right_hand'"),
    ],
)
def test_what_cannot_be_kept_is_refused_by_name(make, error, match):
    robot = ulna.load(two_arms.URDF)
    with pytest.raises(error, match=match):
        robot.plan(robot.home, robot.home, keep=make(robot))


@pytest.mark.parametrize(
    ("one", "other", "match"),
    [
        (
            ulna.Keep.in_plane(ulna.pose((0, 0, 0.5)), within=0.01),
            ulna.Keep.in_plane(ulna.pose((0, 0, 0.6)), within=0.01),
            "0.08 m apart",
        ),
        (ulna.Keep.inside((0.2, 0.2, 0.2), np.eye(4)), ulna.Keep.on_line((0, 0.2, 0), (1, 0.2, 0)), "0.0993 m apart"),
        (ulna.Keep.orientation(0.1, T=np.eye(4)), ulna.Keep.orientation(0.1, T=ulna.pose(rpy=(0, 0, 1))), "1 rad apart"),
        (ulna.Keep.upright(0.1, axis=(1, 0, 0)), ulna.Keep.upright(0.1, axis=(1, 0, 0), along=(1, 0, 0)), "1.57 rad apart"),
    ],
)
def test_constraints_that_contradict_each_other_are_refused(panda, one, other, match):
    with pytest.raises(ulna.InputError, match=match):
        panda.plan(panda.home, panda.home, keep=(one, other))


def test_constraints_that_some_pose_keeps_are_not_refused(panda):
    T = panda.forward_kinematics(panda.home)
    keeps = (
        ulna.Keep.in_plane(T, within=0.01),
        ulna.Keep.on_line(T[:3, 3], T[:3, 3] + (1, 0, 0), within=0.01),
        ulna.Keep.inside((1, 1, 1), T),
    )
    assert len(as_keeps((*keeps, ulna.Keep.orientation(0.1), ulna.Keep.upright(0.1)), panda.tree, panda.home)) == 5
