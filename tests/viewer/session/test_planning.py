"""The plan of a page: what it plans anew, where the arm is along it, what it says."""

import numpy as np
import pytest

import ulna
from ulna.viewer.session.planned_motion import Planning
from ulna.viewer.session.session import Session
from ulna.viewer.session.waypoints import ASIDE, TILT

TICK = 0.05  # s


@pytest.fixture
def world():
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 0.9)), ulna.pose((0.45, 0.2, 0.45)))
    return world


@pytest.fixture
def session(panda, world):
    return Session(panda, world)


@pytest.fixture
def planning(session):
    planning = Planning(session)
    planning.turn(on=True)
    return planning


def beyond_the_post(planning):
    T = planning.hand_pose
    T[:3, 3] = [0.307, 0.45, 0.487]
    planning.send(T)
    return T


def test_without_a_goal_there_is_nothing_to_show(planning, session, panda):
    assert not planning.frame(TICK)
    assert planning.shown is None
    assert "no goal yet" in planning.sentence
    assert np.array_equal(planning.hand_pose, session.hand_pose)


def test_a_plan_is_made_once_and_again_when_the_goal_or_an_obstacle_is_moved(planning, session, world):
    beyond_the_post(planning)
    assert planning.frame(TICK)
    first = planning.shown
    assert first.plan.certified
    assert planning.sentence.startswith("solved: ")
    assert not planning.frame(TICK)
    assert planning.shown is first
    world.move("post", ulna.pose((0.45, 0.25, 0.45)))
    assert planning.frame(TICK)
    assert planning.shown is not first
    second = planning.shown
    planning.send_configuration(session.robot.home + 0.1)
    assert planning.frame(TICK)
    assert planning.shown is not second


def test_the_arm_is_played_along_the_plan_without_touching_and_ends_at_the_goal(planning, session, panda, world):
    T = beyond_the_post(planning)
    planning.frame(TICK)
    planning.play()
    passed = [session.q]
    while planning.playing:
        planning.frame(TICK)
        passed.append(session.q)
    assert len(passed) >= planning.shown.motion.duration / TICK
    assert not panda.in_collision(np.array(passed), world).any()
    assert np.allclose(session.hand_pose, T, atol=2e-5)
    assert planning.share == 1.0
    planning.play()  # from the beginning again
    planning.frame(0.0)
    assert np.allclose(session.q, panda.home)


def test_the_line_is_the_way_of_the_hand(planning, session, panda):
    T = beyond_the_post(planning)
    planning.frame(TICK)
    line = planning.shown.line
    assert np.allclose(line[0], panda.forward_kinematics(panda.home, link=session.link)[:3, 3])
    assert np.allclose(line[-1], T[:3, 3], atol=2e-5)
    planning.scrub(0.4)
    planning.frame(TICK)
    assert np.linalg.norm(line - session.hand_pose[:3, 3], axis=1).min() < 0.01


def test_an_arm_that_is_moved_by_other_means_begins_a_plan_from_there(planning, session, panda):
    beyond_the_post(planning)
    planning.frame(TICK)
    session.q = panda.home + 0.05
    planning.frame(TICK)
    assert np.allclose(planning.shown.plan.path[0], panda.home + 0.05)
    planning.scrub(0.5)
    planning.frame(TICK)
    assert np.allclose(planning.shown.plan.path[0], panda.home + 0.05)
    planning.start_here()
    planning.frame(TICK)
    assert np.allclose(planning.shown.plan.path[0], session.q)


def test_while_it_plays_a_moved_obstacle_makes_it_plan_from_where_it_is(planning, session, world):
    beyond_the_post(planning)
    planning.frame(TICK)
    planning.play()
    planning.frame(6 * TICK)
    on_the_way = session.q
    world.move("post", ulna.pose((0.45, 0.22, 0.45)))
    planning.frame(0.0)
    assert np.array_equal(planning.shown.plan.path[0], on_the_way)
    assert planning.playing


def test_another_hand_begins_a_plan_without_shown_remains(planning, session):
    beyond_the_post(planning)
    planning.frame(TICK)
    session.link = "panda_link5"
    planning._goal = None
    planning.frame(TICK)
    assert planning.shown is None


@pytest.mark.parametrize(
    ("xyz", "said"),
    [((0.45, 0.2, 0.487), "goal in collision: panda_link7 (box 12) and post"), ((3.0, 0.0, 0.5), "goal unreachable: ")],
)
def test_without_a_path_it_says_why_and_the_arm_stays(planning, session, panda, xyz, said):
    T = planning.hand_pose
    T[:3, 3] = xyz
    planning.send(T)
    planning.frame(TICK)
    planning.play()
    assert not planning.playing
    assert planning.sentence.startswith(said.partition(":")[0])
    assert said.split(" and ")[-1] in planning.sentence
    assert np.array_equal(session.q, panda.home)


def test_while_its_kernels_are_compiled_it_says_so_and_plans_afterwards(panda, world):
    session = Session(panda, world, ask=lambda *_: None)
    planning = Planning(session)
    planning.turn(on=True)
    beyond_the_post(planning)
    planning.frame(TICK)
    assert "to compile" in planning.sentence
    session.ask = lambda _, question, *arguments: question(*arguments)
    assert planning.frame(TICK)
    assert planning.sentence.startswith("solved")


def test_turned_off_it_plans_nothing(planning, session, panda):
    beyond_the_post(planning)
    planning.turn(on=False)
    assert not planning.frame(TICK)
    assert planning.sentence == ""
    assert np.array_equal(session.q, panda.home)


def test_a_goal_out_of_reach_says_by_how_much_and_shows_the_nearest_configuration(planning, panda):
    T = planning.hand_pose
    T[0, 3] += 0.5
    planning.send(T)
    planning.frame(TICK)
    nearest = panda.inverse_kinematics(T, panda.home)
    apart = f"{nearest.position_error * 1e3:.1f} mm and {np.degrees(nearest.rotation_error):.1f} deg"
    assert planning.sentence == f"goal unreachable: the nearest pose is {apart} away"
    assert np.array_equal(planning.shown.end, nearest.q)


def test_the_end_of_a_plan_is_that_of_its_path(planning, panda):
    T = beyond_the_post(planning)
    planning.frame(TICK)
    assert np.allclose(panda.forward_kinematics(planning.shown.end), T, atol=1e-6)


def test_a_start_that_touches_itself_says_what_to_do_and_is_left_once_the_pairs_are_allowed(panda):
    folded = np.array([0.79, -0.81, -2.66, -3.02, 1.82, 3.42, 0.62])
    session = Session(panda, q=folded)
    planning = Planning(session)
    planning.turn(on=True)
    planning.send_configuration(folded + 0.01)
    planning.frame(TICK)
    assert planning.sentence.startswith("start in collision: ")
    assert planning.sentence.endswith("; if these links touch in every pose, allow these contacts")
    session.use(panda.with_allowed_collisions(at=folded))
    session.frame()
    assert planning.frame(TICK)
    assert planning.sentence.startswith("solved: ")


def test_the_hand_is_kept_upright_and_on_the_line_to_the_goal(planning, session, panda):
    T = planning.hand_pose
    a, b = T[:3, 3].copy(), T[:3, 3] + (0.1, -0.25, 0.05)
    T[:3, 3] = b
    planning.send(T)
    planning.frame(TICK)
    assert planning.shown.kept_line is None
    off = beyond_a_line(panda, planning.shown.motion, a, b)
    planning.on_line = planning.upright = True
    assert planning.frame(TICK)
    kept = planning.shown
    assert "uses at most " in planning.sentence
    np.testing.assert_allclose(kept.kept_line, [a, b], atol=1e-12)
    assert beyond_a_line(panda, kept.motion, a, b) <= ASIDE < off
    q = kept.motion.at(np.linspace(0, kept.motion.duration, 2001)).q
    R = panda.forward_kinematics(q)[:, :3, :3]
    assert (R[:, 2] @ R[0, 2] >= np.cos(TILT)).all()
    T[:3, :3] = T[:3, :3] @ ulna.pose(rpy=(0.5, 0, 0))[:3, :3]
    planning.send(T)
    planning.frame(TICK)
    assert planning.shown.motion is None
    assert planning.sentence.startswith("goal outside")


def beyond_a_line(panda, motion, a, b):
    """How far the hand gets from the line through two points [m]."""
    p = panda.forward_kinematics(motion.at(np.linspace(0, motion.duration, 2001)).q)[:, :3, 3] - a
    along = (b - a) / np.linalg.norm(b - a)
    return np.linalg.norm(p - (p @ along)[:, None] * along, axis=1).max()


def test_held_joints_stay_whatever_the_goal_says_and_another_plan_is_made_for_them(planning, panda):
    goal = panda.home + 0.1
    planning.send_configuration(goal)
    assert planning.frame(TICK)
    assert np.allclose(planning.shown.end, goal)
    planning.held = "panda_joint2", "panda_joint7"
    assert planning.frame(TICK)
    stays = np.isin(panda.joint_names, planning.held)
    assert (planning.shown.plan.path[:, stays] == panda.home[stays]).all()
    assert np.allclose(planning.shown.end[~stays], goal[~stays])
    assert not planning.frame(TICK)


def test_the_sentence_names_a_lift_that_has_to_move_and_no_joint_that_stays():
    bar = '<collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision>'
    joints = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
        f'<limit lower="{low}" upper="{high}" velocity="1" effort="1"/></joint>'
        for name, kind, parent, child, low, high in (
            ("lift", "prismatic", "base", "slide", 0.0, 0.6),
            ("turn", "revolute", "slide", "bar", -2.0, 2.0),
        )
    )
    robot = ulna.load(f'<robot name="r"><link name="base"/><link name="slide"/><link name="bar">{bar}</link>{joints}</robot>')
    world = ulna.World()
    world.add("post", ulna.Box((0.06, 0.06, 0.3)), ulna.pose((0.3, 0, 0.15)))
    session = Session(robot, world)
    session.q = np.array([0.1, -1.0])
    planning = Planning(session)
    planning.turn(on=True)
    planning.send_configuration([0.1, 1.0])
    assert planning.frame(TICK)
    assert planning.sentence.endswith("; no path was found without moving lift too")
    planning.send_configuration([0.1, -0.5])
    assert planning.frame(TICK)
    assert planning.sentence.endswith(" edges checked")
