"""What the tab of plans draws: the arm a second time where the plan ends, and the way of the hand in a color of its own."""

import numpy as np
import pytest

import ulna
from processes import wait_for
from ulna.viewer.palette import GREEN, RED, SLATE, TRAIL


@pytest.fixture
def plans(view):
    """The tab, which plans to a goal and shows it."""

    def planned(act):
        with view.session.lock:
            if not view.plans.planning.on:
                view.plans.planning.turn(on=True)
            act(view.plans.planning)
        view._on_event()
        wait_for(lambda: view.plans.planning.shown is not None, "a plan", looks=None)
        with view.session.lock:
            view.plans.show()
            return view.plans

    return planned


def assert_drawn_at(plans, robot, q):
    poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
    nodes = plans.ghost._nodes
    assert set(nodes) == {link for link in plans.ghost._arm.visuals if robot.tree.link_row[link] >= 0}
    for link, node in nodes.items():
        assert np.allclose(node.position, poses[link][:3, 3], atol=1e-6)
        assert np.allclose(ulna.pose(node.position, wxyz=node.wxyz), poses[link], atol=1e-5)


def test_the_ghost_is_the_arm_at_the_goal_and_the_arm_stays(view, plans, panda):
    goal = panda.home + np.array([0.6, 0.2, 0, 0, 0, 0, 0])
    shown = plans(lambda planning: planning.send_configuration(goal))
    assert_drawn_at(shown, panda, goal)
    assert all(node.visible and node.color == GREEN and 0 < node.opacity < 1 for node in shown.ghost._nodes.values())
    assert np.allclose([frame.position for frame in view.arm.frames], panda.link_poses(panda.home)[:, :3, 3], atol=1e-5)
    with view.session.lock:
        shown.planning.turn(on=False)
        shown.show()
    assert not any(node.visible for node in shown.ghost._nodes.values())


def test_of_a_goal_out_of_reach_the_ghost_is_red_and_as_near_as_the_arm_comes(view, plans, panda):
    T = panda.forward_kinematics(panda.home).copy()
    T[:3, 3] = [1.5, 0.0, 0.4]
    shown = plans(lambda planning: planning.send(T))
    end = shown.planning.shown.end
    assert_drawn_at(shown, panda, end)
    assert all(node.visible and node.color == RED for node in shown.ghost._nodes.values())
    missed = np.linalg.norm(panda.forward_kinematics(end, link=view.session.link)[:3, 3] - T[:3, 3])
    assert missed < np.linalg.norm(panda.forward_kinematics(panda.home)[:3, 3] - T[:3, 3]) - 0.1
    assert f"{1e3 * missed:.1f} mm" in shown.planning.sentence
    assert not shown.line.visible


def test_the_trail_is_the_way_of_the_hand_in_a_color_that_no_other_line_has(view, plans, panda):
    shown = plans(lambda planning: planning.send_configuration(panda.home + np.array([0.6, 0.2, 0, 0, 0, 0, 0])))
    assert shown.line.visible
    assert np.allclose(np.unique(shown.line.colors.reshape(-1, 3), axis=0), [TRAIL])
    assert np.allclose(shown.line.points[1:, 0], shown.line.points[:-1, 1])
    ends = panda.forward_kinematics(np.array([panda.home, shown.planning.shown.end]), link=view.session.link)[:, :3, 3]
    assert np.allclose(shown.line.points[[0, -1], [0, 1]], ends, atol=1e-3)
    assert all(np.abs(np.subtract(TRAIL, other)).max() > 60 for other in (SLATE, view.clearance.line.color, GREEN, RED))
