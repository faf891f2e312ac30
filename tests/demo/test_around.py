"""The demo's arm plans around the box: it touches nothing as long as there is a way, and says so when there is none."""

from dataclasses import replace

import numpy as np
import pytest

import ulna
from ulna.demo.around import _last_free, is_free
from ulna.demo.player import Player
from ulna.demo.scenario import BOX_START, Demo
from ulna.description.pose import pose

FRAME = 1 / 30  # [s]
ASIDE = (0.4, -0.6, 0.1)
SWING = np.linspace(0.0, 2.4, 241)  # of the first joint [rad], past a box where the hand is at 0.9 rad


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
    player.drag(pose(player.demo.robot.forward_kinematics(player.q, link="panda_link4")[:3, 3]))
    q = player.q
    play(player, 1)
    assert player.q is q
    assert player.around.sentence == "the arm is in the box: move the box away"
    player.drag(pose(BOX_START))
    play(player, 3)
    assert player.around.plan
    assert not np.array_equal(player.q, q)


def swing_past_a_box(player):
    """Put the box there. Returns the configurations of the swing, shape (241, 7), and how deep the box is in each [m]."""
    robot, world = player.demo.robot, player.demo.world
    q = np.repeat(robot.home[None], len(SWING), axis=0)
    q[:, 0] = SWING
    player.drag(robot.forward_kinematics(q[90]))
    return q, -robot.signed_distance(q, world, self_collision=False)


def test_from_deep_in_the_box_the_arm_leads_out_the_way_it_came_and_then_round(player):
    robot, world = player.demo.robot, player.demo.world
    swing, depths = swing_past_a_box(player)
    for q in swing[: int(np.argmax(depths > 0.02)) + 1]:  # as by a slider
        player.move_to(q)
    depth, came = -robot.signed_distance(player.q, world, self_collision=False), len(player.screen.drawn)
    assert depth > 0.02
    assert robot.plan(player.q, robot.home, world, escape=True).status == "start in collision"
    way = np.array(player.screen.drawn)
    player.avoiding = True
    play(player, FRAME)
    assert player.around.sentence == "the arm is in the box, and leaves it the way it came"
    frames = 0
    while player.report.in_collision:
        assert np.abs(way - player.q).max(axis=1).min() < 0.02  # where it has been
        now = -robot.signed_distance(player.q, world, self_collision=False)
        assert now <= depth + 1e-3
        depth, frames = now, frames + 1
        player.advance(FRAME)
    assert 2 < frames < 100
    play(player, 3)
    assert player.around.plan
    assert play(player, 12) == 0
    q, corners = np.array(player.screen.drawn[came:]), player.demo.trajectory.samples[[0, 30, 60]]
    assert (np.abs(q[:, None] - corners).max(axis=2).min(axis=0) < 0.05).all()


def test_the_way_back_is_not_taken_where_it_leads_deeper_or_nowhere(player):
    """The hand swings through the box: before its middle the way back leads out, behind it deeper in."""
    robot, world = player.demo.robot, player.demo.world
    trail, depths = swing_past_a_box(player)
    hit = robot.in_collision(trail, world)
    before, behind = int(np.argmax(depths > 0.02)), int(len(trail) - 1 - np.argmax(depths[::-1] > 0.02))
    assert not hit[0]
    assert 0 < before < 90 < behind < len(trail) - 1
    last = _last_free(robot, trail[before], trail[:before], world)
    assert last == np.flatnonzero(~hit[:before])[-1]
    assert _last_free(robot, trail[behind], trail[:behind], world) is None
    assert _last_free(robot, trail[before], trail[last + 1 : before], world) is None
    assert _last_free(robot, trail[before], trail[:0], world) is None


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


def test_a_way_that_is_not_certified_is_not_said_to_be(player):
    player.avoiding = True
    play(player, 0.5)
    assert "certified free" in player.around.sentence
    player.around.plan = replace(player.around.plan, certified=False)
    assert "certified" not in player.around.sentence
    assert "free at samples" in player.around.sentence


def test_the_motion_that_is_played_is_looked_at_not_chords_of_it(player):
    """So fast that its corners lie far from lines between configurations 20 ms apart, where the box is."""
    robot, world = player.demo.robot, player.demo.world
    left, right = robot.home.copy(), robot.home.copy()
    left[0], right[0] = 1.0, -1.0
    post = ulna.World()
    post.add("post", ulna.Box((0.1, 0.1, 1.6)), pose((0.35, 0, 0.6)))
    post.add("shelf", ulna.Box((0.5, 2, 0.05)), pose((0.6, 0, 0.95)))
    motion = robot.plan(left, right, post).trajectory(velocity=1e4, acceleration=1e6, blend=2.0)
    assert motion.duration < 0.02
    q = motion.at(np.linspace(0, motion.duration, 501)).q
    chords = np.concatenate([np.linspace(q[0], q[250], 501), np.linspace(q[250], q[-1], 501)])
    seen = 0
    for T in robot.forward_kinematics(q)[::10]:
        for offset in np.random.default_rng(0).uniform(-0.3, 0.3, (20, 3)):
            player.demo.move_box(T @ pose(offset))
            if robot.in_collision(q, world).any() and not robot.in_collision(chords, world).any():
                assert not is_free(robot, motion, 0.0, world)
                seen += robot.signed_distance(q[[0, 250, -1]], world, self_collision=False).min() > 0.01
    assert seen
