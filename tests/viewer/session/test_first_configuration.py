"""Where the arm of a page begins: home, or bent if it is stretched there; judged by singular values and collision checks."""

import numpy as np
import pytest

import robots
import ulna
from ulna.viewer.session.first_configuration import first_configuration
from ulna.viewer.session.session import Session

H = np.pi / 2


def least(robot, q):
    return np.linalg.svd(robot.jacobian(q), compute_uv=False).min()


@pytest.mark.parametrize("rows", ["UR5", "PUMA"])
def test_a_stretched_arm_begins_bent_by_quarter_turns_and_not_singular(rows):
    robot = ulna.Robot.from_dh(getattr(robots, rows), convention="standard", limits=[(-np.pi, np.pi)] * 6)
    assert least(robot, robot.home) < 1e-3
    q = Session(robot).q
    assert least(robot, q) > 0.05
    assert np.isin(q.round(9), np.round([-H, 0, H], 9)).all()
    assert q[0] == q[-1] == 0.0
    one_less = [np.where(np.arange(6) == k, 0.0, q) for k in np.flatnonzero(q)]
    assert all(least(robot, other) < 0.5 * least(robot, q) for other in one_less)  # no bend is for nothing


def test_an_arm_that_is_not_stretched_begins_at_home_and_one_that_is_given_a_place_there(panda):
    assert np.array_equal(Session(panda).q, panda.home)
    robot = ulna.Robot.from_dh(robots.UR5, convention="standard")
    assert np.array_equal(Session(robot, q=np.zeros(6)).q, np.zeros(6))


def test_it_begins_free_of_the_obstacles_and_of_itself():
    robot = ulna.load(robot_of_balls())
    empty = first_configuration(robot, ulna.World())
    assert not robot.in_collision(empty)
    world = ulna.World()
    world.add("in its way", ulna.Sphere(0.1), robot.forward_kinematics(empty))
    assert robot.in_collision(empty, world)
    other = first_configuration(robot, world)
    assert not robot.in_collision(other, world)
    assert np.count_nonzero(other) > 0
    assert np.abs(other).max() == H


def robot_of_balls():
    """Three links in a plane, each with a ball at its end."""
    ball = '<collision><origin xyz="0 0 0.5"/><geometry><sphere radius="0.05"/></geometry></collision>'
    links = "".join(f'<link name="l{k}">{ball if k else ""}</link>' for k in range(5))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><axis xyz="0 1 0"/>'
        f'<origin xyz="0 0 {0.5 if k else 0}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        for k in range(4)
    )
    return f'<robot name="balls">{links}{joints}</robot>'


def test_the_configuration_that_an_srdf_gives_is_taken_before_a_bent_one(tmp_path):
    (tmp_path / "r.srdf").write_text(
        '<robot name="balls"><group name="all"><chain base_link="l0" tip_link="l4"/></group>'
        '<group_state name="ready" group="all">'
        + "".join(f'<joint name="j{k}" value="{value}"/>' for k, value in enumerate((0.1, 0.8, -0.7, 0.5)))
        + "</group_state></robot>"
    )
    robot = ulna.load(robot_of_balls(), srdf=tmp_path / "r.srdf")
    assert Session(robot).q.tolist() == [0.1, 0.8, -0.7, 0.5]


def test_while_it_is_compiled_the_arm_waits_at_home_and_then_begins_unless_it_was_moved():
    robot = ulna.Robot.from_dh(robots.UR5, convention="standard")
    answers = []

    def ask(name, question, *arguments, **options):
        return question(*arguments, **options) if answers else None

    waiting, moved = Session(robot, ask=ask), Session(robot, ask=ask)
    waiting.frame()
    assert np.array_equal(waiting.q, robot.home)
    moved.q = np.full(6, 0.1)
    answers.append(True)
    waiting.frame()
    moved.frame()
    assert np.array_equal(waiting.q, Session(robot).q)
    assert not np.array_equal(waiting.q, robot.home)
    assert np.array_equal(moved.q, np.full(6, 0.1))
