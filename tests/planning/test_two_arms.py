"""Both hands of a robot brought to a pose each, together: no link of one arm touches the other at any sample of the way."""

import numpy as np
import pytest

import two_arms
import ulna
from ulna.errors import InputError, UnknownNameError
from ulna.planning.plan import PlanStatus

N = 5001  # samples of a path


@pytest.fixture(scope="module")
def robot():
    return ulna.load(two_arms.URDF, srdf=two_arms.SRDF)


@pytest.fixture(scope="module")
def crossed(robot):
    """Two configurations: the left arm above the right one across the middle, and the other way round."""
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.6, 1.6, (4000, robot.n_dof))
    q[:, 0] = 0.2
    q = q[~robot.in_collision(q)]
    left, right = (robot.forward_kinematics(q, link=f"{side}_hand")[:, :3, 3] for side in ("left", "right"))
    apart = left[:, 2] - right[:, 2]
    across = (np.abs(left[:, 1]) < 0.2) & (np.abs(right[:, 1]) < 0.2) & (left[:, 0] > 0.3) & (right[:, 0] > 0.3)
    above, below = q[across & (apart > 0.15)], q[across & (apart < -0.15)]
    return above[0], below[0]


def poses_of(robot, q):
    return {link: robot.forward_kinematics(q, link=link) for link in ("left_hand", "right_hand")}


def touching_pairs(robot, q):
    return {(pair.name_a, pair.name_b) for pair in robot.check_collision(q).pairs if pair.signed_distance <= 0}


def test_both_hands_arrive_and_the_arms_do_not_touch_on_the_way(robot, crossed):
    start, end = crossed
    straight = start + np.linspace(0, 1, N)[:, None] * (end - start)
    hits = straight[robot.in_collision(straight)]
    assert len(hits)  # so that there is something to go round
    assert any({a[:4], b[:4]} == {"left", "righ"} for a, b in touching_pairs(robot, hits[0]))
    goal = poses_of(robot, end)
    plan = robot.plan(start, goal)
    two_arms.assert_arrives(robot, plan, goal)
    assert (plan.path[:, 0] == start[0]).all()  # the torso moves both


def test_a_goal_that_the_other_arm_blocks_where_it_is_now_is_reached(robot):
    """The left hand goes to where the right arm is: alone it cannot, together they can."""
    q = np.random.default_rng(5).uniform(-1.6, 1.6, (3000, robot.n_dof))
    q[:, 0] = 0.0
    q = q[~robot.in_collision(q)]
    start, ends = q[0], q[1:]
    only_left = np.where(np.isin(np.arange(robot.n_dof), robot.groups["left_arm"].columns), ends, start)
    end = ends[robot.in_collision(only_left)][0]
    goal = poses_of(robot, end)
    plan = robot.plan(start, goal)
    assert plan, str(plan)
    assert not robot.in_collision(plan.at(np.linspace(0, 1, N))).any()


@pytest.mark.parametrize("gap", [0.06, 0.05])
def test_both_arms_leave_a_slot_in_which_only_short_steps_are_free(robot, gap):
    world = ulna.World()
    for side in (-1, 1):
        world.add(f"board {side}", ulna.Box((0.6, 1.0, 0.02)), ulna.pose((0.8, 0, 0.6 + side * (gap + 0.01))))
    start, goal = np.zeros(robot.n_dof), np.zeros(robot.n_dof)
    goal[[2, 7]], goal[[3, 8]] = -1.2, 0.4
    for seed in range(3):  # with steps of one length one of the six searches ends with a tree of one node
        plan = robot.plan(start, goal, world, max_checks=20_000, seed=seed)
        assert plan, str(plan)
        assert not robot.in_collision(plan.at(np.linspace(0, 1, N)), world).any()


def test_rows_of_plan_many_are_those_of_plan(robot, crossed):
    start, end = crossed
    goals = {link: np.stack([T, robot.forward_kinematics(start, link=link)]) for link, T in poses_of(robot, end).items()}
    with ulna.threads(2):
        plans = robot.plan_many(start, goals)
    for k, plan in enumerate(plans):
        assert np.array_equal(plan.path, robot.plan(start, {link: T[k] for link, T in goals.items()}).path)
    with pytest.raises(InputError, match="as many problems"):
        robot.plan_many(start, {"left_hand": goals["left_hand"], "right_hand": goals["right_hand"][:1]})


def test_the_link_that_is_out_of_reach_is_named(robot, crossed):
    goal = poses_of(robot, crossed[1])
    goal["right_hand"][:3, 3] = (5, 0, 0)
    plan = robot.plan(crossed[0], goal)
    assert plan.status == PlanStatus.GOAL_UNREACHABLE
    assert str(plan.reason).startswith("right_hand: ")


def test_hands_at_one_place_are_a_collision(robot, crossed):
    T = robot.forward_kinematics(crossed[1], link="left_hand")
    plan = robot.plan(crossed[0], {"left_hand": T, "right_hand": T}, task="position")
    assert plan.status == PlanStatus.GOAL_IN_COLLISION
    assert plan.reason.data.in_collision


def test_what_cannot_be_a_goal_of_several_links_is_refused(robot, crossed):
    start, T = crossed[0], np.eye(4)
    with pytest.raises(UnknownNameError, match="no link is called 'left_hnd'"):
        robot.plan(start, {"left_hnd": T})
    for goal, said in (
        ({}, "no link is named"),
        ({"left_hand": np.eye(3)}, "one pose, shape"),
        ({"left_hand": T, "left_5": T}, "no joint moves link 'left_hand' that does not move another"),
    ):
        with pytest.raises(InputError, match=said):
            robot.plan(start, goal)
    with pytest.raises(InputError, match="link: the goal names its links already"):
        robot.plan(start, {"left_hand": T}, link="right_hand")
