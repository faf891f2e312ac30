"""The demo's arm plans around the box: it touches nothing as long as there is a way, and says so when there is none."""

import numpy as np
import pytest

from ulna.demo.player import Player
from ulna.demo.scenario import BOX_START, Demo
from ulna.description.pose import pose

FRAME = 1 / 30  # [s]
ASIDE = (0.4, -0.6, 0.1)


class Blank:
    """A screen that keeps the configurations it is asked to draw."""

    def __init__(self):
        self.drawn = []

    def draw_arm(self, q):
        self.drawn.append(q)

    def draw_report(self, report):
        pass


@pytest.fixture
def player():
    return Player(Demo(), Blank())


def play(player, seconds):
    """Play, and say in how many frames the box was touched."""
    return sum(player.advance(FRAME) or player.report.in_collision for _ in range(round(seconds / FRAME)))


def in_the_way(player):
    """A pose of the box in which the assignment's own motion touches it, and the arm at home does not."""
    samples = player.demo.trajectory.samples
    for x, y, z in np.random.default_rng(0).uniform((0.3, -0.1, 0.2), (0.6, 0.2, 0.7), (2000, 3)):
        player.demo.move_box(pose((x, y, z)))
        ends = samples[[0, 30, 60]]
        touched = player.demo.robot.in_collision(samples, player.demo.world)
        if touched.any() and not player.demo.robot.in_collision(ends, player.demo.world).any():
            return pose((x, y, z))
    raise AssertionError("no such place")


def test_a_box_in_the_way_is_touched_without_plans_and_not_with_them(player):
    T = in_the_way(player)
    player.drag(T)
    assert play(player, 9) > 0
    player.avoiding = True
    player.move_to(player.demo.robot.home)
    start = len(player.screen.drawn)
    assert play(player, 20) == 0
    assert player.around.plan
    assert player.around.plan.certified
    q = np.array(player.screen.drawn[start:])
    corners = player.demo.trajectory.samples[[0, 30, 60]]
    assert (np.abs(q[:, None] - corners).max(axis=2).min(axis=0) < 0.05).all()  # it comes to each corner
    assert "certified free" in player.around.sentence


def test_a_box_that_is_dragged_through_the_arms_way_is_avoided_while_it_moves(player):
    touched = {}
    for player.avoiding in (False, True):
        player.drag(pose(ASIDE))
        player.time = 0.0
        player.move_to(player.demo.robot.home)
        touched[player.avoiding] = 0
        for share in np.linspace(0, 1, 240):  # 8 s, slower than the arm
            player.drag(pose((0.5, -0.6 + 1.2 * share, 0.5)))
            touched[player.avoiding] += play(player, FRAME)
    assert touched[False] > 0
    assert touched[True] == 0


def test_without_a_way_the_arm_rests_and_says_why_until_the_box_is_gone(player):
    player.avoiding = True
    player.drag(pose(player.demo.robot.forward_kinematics(player.q, "panda_link4")[:3, 3]))
    q = player.q
    play(player, 1)
    assert player.q is q
    assert player.around.sentence == "no way round the box: start in collision"
    player.drag(pose(BOX_START))
    play(player, 3)
    assert player.around.plan
    assert not np.array_equal(player.q, q)


def test_a_motion_that_stays_free_is_not_planned_again(player):
    player.avoiding = True
    play(player, 0.5)
    plan = player.around.plan
    player.drag(pose(ASIDE))
    play(player, FRAME)
    assert player.around.plan is plan


def test_switched_off_the_arm_plays_the_trajectory_as_ever(player):
    other = Player(Demo(), Blank())
    player.avoiding = True
    play(player, 1)
    player.avoiding = False
    play(player, 2)
    play(other, 2)
    assert np.array_equal(player.q, other.q)
