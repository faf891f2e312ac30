"""Joints whose position is the same at both ends of a plan stay, bit for bit, as long as there is a path without moving them."""

import numpy as np
import pytest

import two_arms
import ulna
from ulna.errors import InputError
from ulna.planning.fixed_joints_first import chain_joints, distal_joints

pytestmark = pytest.mark.filterwarnings("ignore:.*lower and upper of a continuous joint are not used")
SHAPE = '<collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision>'
AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
PLACES = ("0 0 0.3", "0.1 0 0.1", "0 0 0.26", "0.1 0 0", "0.3 0 0", "0.07 0 0")
N_SAMPLES = 1001  # samples of a path that are tested for contacts


def joint(name, kind, parent, place="0 0 0", axis="0 0 1", low=-3.0, high=3.0, more=""):
    """A joint, and the link behind it, which has the name of the joint."""
    return (
        f'<link name="{name}">{SHAPE}</link><joint name="j_{name}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
        f'<origin xyz="{place}"/><axis xyz="{axis}"/><limit lower="{low}" upper="{high}" velocity="2" effort="1"/>{more}</joint>'
    )


def arm(parent):
    links = [parent, *(f"arm{k}" for k in range(1, 7))]
    return "".join(joint(links[k + 1], "revolute", links[k], PLACES[k], AXES[k]) for k in range(6))


FINGERS = joint("left", "prismatic", "arm6", "0.08 0.03 0", "0 1 0", 0, 0.04)
FINGERS += joint("right", "prismatic", "arm6", "0.08 -0.03 0", "0 -1 0", 0, 0.04, '<mimic joint="j_left"/>')
WHEELS = "".join(
    joint(f"wheel{k}", "continuous", "base", f"{x} {y} -0.1", "0 1 0") for k, (x, y) in enumerate([(0.3, 0.3), (-0.3, 0.3)])
)
LIFT = joint("lift", "prismatic", "base", "0 0 0.2", low=0, high=0.4)
HEAD = joint("neck", "revolute", "lift", "-0.2 0 0.5") + joint("head", "revolute", "neck", "0 0 0.1", "0 1 0", -1, 1)
FOLDED = {"j_arm2": 0.2, "j_arm3": 0.3, "j_arm5": 0.4, "j_left": 0.01}


def robot_of(body):
    robot = ulna.load(f'<robot name="r"><link name="base">{SHAPE}</link>{body}</robot>')
    return robot.with_allowed_collisions(at=np.array([FOLDED.get(name, 0.0) for name in robot.joint_names]))


@pytest.fixture(scope="module")
def gripper():
    """An arm with two fingers."""
    return robot_of(arm("base") + FINGERS)


@pytest.fixture(scope="module")
def mobile():
    """An arm with fingers on the lift of a base with wheels, beside a head."""
    return robot_of(WHEELS + LIFT + HEAD + arm("lift") + FINGERS)


@pytest.fixture(scope="module")
def reacher():
    """A bar of 0.5 m that turns on a lift, with a finger at its end, on a base with a wheel."""
    bar = '<collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision>'
    body = joint("wheel", "continuous", "base", "-0.3 0 0", "0 1 0") + joint("lift", "prismatic", "base", low=0, high=0.6)
    body += joint("bar", "revolute", "lift", low=-1.5, high=1.5).replace(SHAPE, bar)
    jaws = (joint(name, "prismatic", "bar", f"0.55 0 {z}", "0 1 0", 0, 0.04) for name, z in (("jaw", 0), ("thumb", 0.1)))
    return robot_of(body + "".join(jaws))


@pytest.fixture(scope="module")
def fence():
    """A post that the bar passes only where it is lifted above it."""
    world = ulna.World()
    world.add("post", ulna.Box((0.06, 0.06, 0.3)), ulna.pose((0.3, 0, 0.15)))
    return world


def columns(robot, names):
    return [robot.joint_names.index(name) for name in names]


def problems(robot, moving, n, seed=0):
    """Starts and goals that differ in these joints, and worlds of boxes, in which the straight way is not free."""
    rng, found = np.random.default_rng(seed), []
    low, high = np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0)
    while len(found) < n:
        world = ulna.World()
        for k in range(int(rng.integers(2, 8))):
            size, place = rng.uniform(0.05, 0.3, 3), rng.uniform((-0.7, -0.7, 0.1), (0.7, 0.7, 1.0))
            world.add(f"box{k}", ulna.Box(tuple(size)), ulna.pose(place))
        start = rng.uniform(low, high)
        goal = start.copy()
        some = moving if len(found) % 2 else rng.choice(moving, size=rng.integers(1, len(moving)), replace=False)
        goal[some] = rng.uniform(low, high)[some]
        free = not robot.in_collision(np.array([start, goal]), world).any()
        if free and robot.edge_in_collision(start, goal, world).in_collision:
            found.append((start, goal, world))
    return found


def stays(rows, q, still):
    return bool((rows[:, still] == q[still]).all())


def assert_free(robot, plan, world):
    assert plan.certified
    assert not robot.in_collision(plan.at(np.linspace(0, 1, N_SAMPLES)), world).any()


def assert_all_stays(robot, start, goal, world, still):
    """In the plan, in shorter and quicker ones, and at all times of their motions; the paths are free."""
    plan = robot.plan(start, goal, world, max_checks=20_000)
    assert plan, str(plan)
    for each in (plan, plan.improve(200), plan.quicker(5, acceleration=5.0, velocity=2.0)):
        assert_free(robot, each, world)
        assert np.array_equal(each.path[0], start)
        assert np.array_equal(each.path[-1], goal)
        assert stays(each.path, start, still)
        assert not each.moved_beside
        assert not {robot.joint_names[k] for k in still} & set(each.moved)
        for jerk in (None, 50.0):
            motion = each.trajectory(acceleration=5.0, velocity=2.0, jerk=jerk)
            assert stays(motion.at(np.linspace(0, motion.duration, 201)).q, start, still)
            assert stays(motion.sampled(0.01)[1], start, still)


def test_fingers_that_hold_a_part_stay(gripper):
    moving = columns(gripper, [f"j_arm{k}" for k in range(1, 7)])
    for start, goal, world in problems(gripper, moving, 8):
        assert_all_stays(gripper, start, goal, world, [6])


def test_wheels_a_lift_a_head_and_fingers_stay(mobile):
    moving = columns(mobile, [f"j_arm{k}" for k in range(1, 7)])
    for start, goal, world in problems(mobile, moving, 6):
        assert_all_stays(mobile, start, goal, world, np.setdiff1d(np.arange(mobile.n_dof), moving))


def test_the_other_arm_and_the_torso_stay():
    robot = ulna.load(two_arms.URDF, srdf=two_arms.SRDF)
    moving = list(robot.groups["left_arm"].columns)
    for start, goal, world in problems(robot, moving, 6, seed=2):
        assert_all_stays(robot, start, goal, world, np.setdiff1d(np.arange(robot.n_dof), moving))


def test_all_joints_that_can_stay_do(gripper):
    """Of an arm too: where joints 1 and 2 alone find a way, the others keep their positions."""
    world, start = ulna.World(), np.array([-0.8, 0.9, 0.3, 0.0, 0.4, 0.0, 0.02])
    world.add("post", ulna.Box((0.06, 0.06, 0.5)), ulna.pose((0.5, 0, 0.25)))
    goal = start.copy()
    goal[:2] = 0.8, 0.85
    plan = gripper.plan(start, goal, world)
    assert_free(gripper, plan, world)
    assert stays(plan.path, start, [2, 3, 4, 5, 6])
    assert len(plan.path) > 2
    assert plan.moved == ()


def test_a_joint_that_has_to_move_does_and_the_plan_says_so(reacher, fence):
    start, goal = np.array([0.3, 0.1, -1.0, 0.02, 0.02]), np.array([0.3, 0.1, 1.0, 0.02, 0.02])
    for turns in (0, 2):
        start[0] = 0.3 + turns * 2 * np.pi
        plan = reacher.plan(start, goal, fence)
        assert_free(reacher, plan, fence)
        assert plan.path[:, 1].max() > 0.29
        assert plan.moved == plan.moved_beside == ("j_lift",)
        assert str(plan).endswith("; no path was found without moving j_lift too")
        assert stays(plan.path[:, 1:], start[1:], [2, 3])
    assert stays(plan.improve(300).path, plan.path[0], [3, 4])
    assert not reacher.plan(start, goal, fence, held=["j_lift"], max_checks=500)


def test_no_more_edges_are_checked_than_are_allowed(reacher):
    world = ulna.World()
    world.add("wall", ulna.Box((0.06, 0.06, 4)), ulna.pose((0.3, 0, 0)))
    start, goal = np.array([0.3, 0.1, -1.0, 0.02, 0.02]), np.array([0.3, 0.1, 1.0, 0.02, 0.02])
    told = []
    plan = reacher.plan(start, goal, world, max_checks=500, progress=lambda done, most: told.append((done, most)))
    assert plan.status == "budget spent"
    assert 500 <= plan.checks <= 510
    assert f"after {plan.checks} checked edges (max_checks=500)" in str(plan)
    counts = [done for done, _ in told]
    assert counts == sorted(counts)
    assert {most for _, most in told} == {500}


@pytest.mark.parametrize("turns", [0.0, 2 * np.pi, -6 * np.pi])
def test_what_differs_by_rounding_or_by_whole_turns_of_a_wheel_is_the_same(mobile, turns):
    moving = columns(mobile, [f"j_arm{k}" for k in range(1, 7)])
    start, goal, world = problems(mobile, moving, 1, seed=4)[0]
    near = goal + 1e-13
    near[[0, 1]] += turns
    still = np.setdiff1d(np.arange(mobile.n_dof), moving)
    for options in ({}, {"held": ["j_wheel0", "j_lift"]}):
        plan = mobile.plan(start, near, world, **options)
        assert stays(plan.path, start, still)
        assert np.abs(plan.path[-1] - goal).max() <= 2e-13
        assert_free(mobile, plan, world)
    moved = near + 1e-3 * (np.arange(mobile.n_dof) == mobile.joint_names.index("j_lift"))
    with pytest.raises(InputError, match="'j_lift' would move"):
        mobile.plan(start, moved, world, held=["j_lift"])


def test_of_several_goals_each_agrees_with_the_start_in_joints_of_its_own(gripper):
    moving = columns(gripper, [f"j_arm{k}" for k in range(1, 7)])
    for start, goal, world in problems(gripper, moving, 4, seed=6):
        other, closed = goal.copy(), goal.copy()
        other[0] *= 0.9
        closed[6] = 0.5 * start[6]
        plan = gripper.plan(start, np.array([closed, other, goal]), world)
        assert plan
        assert stays(plan.path, start, [6]) or plan.goal == 0
        assert stays(plan.improve(300).path, start, [6]) or plan.improve(300).goal == 0
        assert stays(gripper.plan(start, np.array([other, goal]), world).path, start, [6])


def test_many_plans_hold_the_same_joints_as_one(gripper):
    moving = columns(gripper, [f"j_arm{k}" for k in range(1, 7)])
    starts, goals, worlds = zip(*problems(gripper, moving, 4, seed=7), strict=True)
    with ulna.threads(2):
        many = gripper.plan_many(np.array(starts), np.array(goals), worlds)
    for start, goal, world, plan in zip(starts, goals, worlds, many, strict=True):
        assert np.array_equal(plan.path, gripper.plan(start, goal, world).path)
        assert stays(plan.path, start, [6])


def test_a_motion_that_keeps_a_constraint_keeps_the_fingers_too(gripper):
    world, start = ulna.World(), np.array([-0.8, 0.2, 0.3, 0.0, 0.4, 0.0, 0.02])
    world.add("post", ulna.Box((0.06, 0.06, 2)), ulna.pose((0.5, 0, 0.5)))
    goal = start.copy()
    goal[0] = 0.8
    plan = gripper.plan(start, goal, world, keep=ulna.Keep.upright(within=0.3, link="arm6"))
    assert_free(gripper, plan, world)
    assert plan.worst_violation <= 1.0
    assert stays(plan.path, start, [6])
    assert stays(plan.improve(500).path, start, [6])


def test_a_motion_that_goes_over_into_another_plan_keeps_the_fingers_still(gripper):
    moving = columns(gripper, [f"j_arm{k}" for k in range(1, 7)])
    for start, goal, world in problems(gripper, moving, 3, seed=8):
        motion = gripper.plan(start, goal, world).trajectory(acceleration=5.0, velocity=2.0, jerk=200.0)
        at = 0.4 * motion.duration
        try:
            changed = motion.replace(gripper.plan(motion.at(at).q, start, world), at=at)
        except InputError:
            continue
        assert changed.certified
        assert stays(changed.at(np.linspace(0, changed.duration, 301)).q, start, [6])


def test_the_way_out_of_a_contact_is_that_of_joints_that_move_anyway(mobile):
    moving = columns(mobile, [f"j_arm{k}" for k in range(1, 7)])
    start, goal, world = problems(mobile, moving, 1, seed=9)[0]
    still, T = np.setdiff1d(np.arange(mobile.n_dof), moving), mobile.forward_kinematics(start, link="left")
    world.add("stop", ulna.Box((0.05, 0.05, 0.05)), T @ ulna.pose((0, 0, 0.046)))
    assert mobile.in_collision(start, world)
    plan = mobile.plan(start, goal, world, escape=True)
    assert plan.escaped
    assert stays(plan.path, start, still)


def test_joints_at_their_limits_and_a_goal_that_is_the_start_stay(gripper):
    moving = columns(gripper, [f"j_arm{k}" for k in range(1, 7)])
    for end in (0.0, 0.04):
        for start, goal, world in problems(gripper, moving, 2, seed=11):
            begin, target = start.copy(), goal.copy()
            begin[6] = target[6] = end
            if gripper.in_collision(np.array([begin, target]), world).any():
                continue
            assert stays(gripper.plan(begin, target, world).path, begin, [6])
            assert (gripper.plan(begin, begin, world).path == begin).all()


def test_a_group_that_holds_the_rest_holds_its_own_joints_first_too():
    robot = ulna.load(two_arms.URDF, srdf=two_arms.SRDF)
    left, both = (list(robot.groups[name].columns) for name in ("left_arm", "both_arms"))
    for start, goal, world in problems(robot, left, 3, seed=12):
        plan = robot.plan(start, goal[both] + 1e-15, world, group="both_arms")
        assert stays(plan.path, start, np.setdiff1d(np.arange(robot.n_dof), left))
        other = goal.copy()
        other[0] += 1e-13  # the torso, which is outside the group
        assert robot.plan(start, other, world, group="left_arm")


def test_the_arm_goes_on_from_a_joint_that_moves_to_where_the_robot_branches(mobile, reacher):
    names = np.array(mobile.joint_names)
    moved = names == "j_arm3"
    assert set(names[distal_joints(mobile.tree, moved)]) == {"j_arm4", "j_arm5", "j_arm6"}
    assert set(names[chain_joints(mobile.tree, moved)]) == {"j_arm1", "j_arm2", "j_arm4", "j_arm5", "j_arm6"}
    assert not chain_joints(reacher.tree, np.array(reacher.joint_names) == "j_bar").any()


def test_one_jaw_beside_the_frame_of_a_hand_stays():
    tip = '<link name="tip"/><joint name="to_tip" type="fixed"><parent link="arm6"/><child link="tip"/></joint>'
    robot = robot_of(arm("base") + tip + joint("jaw", "revolute", "arm6", "0.08 0.03 0"))
    moving = columns(robot, [f"j_arm{k}" for k in range(1, 7)])
    for start, goal, world in problems(robot, moving, 6, seed=13):
        assert_all_stays(robot, start, goal, world, [6])


@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")
@pytest.mark.parametrize("size", [0.01, 1.0, 300.0])
def test_a_meter_of_a_slide_counts_the_radians_that_move_the_robot_as_far(size):
    """Of a straight arm: the distances of the tip from its joints are measured, and each counts by itself in their mean."""
    body, parent = joint("lift", "prismatic", "base", low=0, high=0.4 * size), "lift"
    for k, length in enumerate([0.1, 0.4, 0.3, 0.02]):
        body += joint(f"link{k}", "revolute", parent, f"{length * size} 0 0", "0 0 1").replace(SHAPE, "")
        parent = f"link{k}"
    body += f'<link name="tip"/><joint name="to_tip" type="fixed"><parent link="{parent}"/><child link="tip"/>'
    robot = ulna.load(f'<robot name="r"><link name="base">{SHAPE}</link>{body}<origin xyz="{0.2 * size} 0 0"/></joint></robot>')
    tip = robot.forward_kinematics(robot.home, link="tip")[:3, 3]
    far = np.array([np.linalg.norm(robot.forward_kinematics(robot.home, link=f"link{k}")[:3, 3] - tip) for k in range(4)])
    lifted = robot.home + np.array([0.3 * size, 0, 0, 0, 0])
    plan = robot.plan(robot.home, lifted)
    assert np.isclose(plan.length, 0.3 * size * far.sum() / (far**2).sum())
    turned = robot.home + np.array([0, 0.5, 0, 0, 0])
    assert np.isclose(robot.plan(robot.home, turned).length, 0.5)
    both = robot.plan(robot.home, lifted + turned - robot.home).length
    assert np.isclose(both, np.hypot(plan.length, 0.5))
