"""A plan to a pose ends in a configuration near the start if one is reached, although the straight way to a far one is free."""

import numpy as np
import pytest

import ulna
from ulna.planning.fixed_joints_first import Trial, prepend_near_trials


@pytest.mark.parametrize("seed", range(4))
def test_the_way_round_a_board_does_not_turn_the_elbow(seed):
    robot, world = ulna.load("ur10e"), ulna.World()
    world.add("board", ulna.Box((0.3, 0.04, 0.9)), ulna.pose((0.75, -0.15, 0.45)))
    T = ulna.pose((0.6, -0.55, 0.45), (np.pi, 0, -np.pi / 2))
    solutions = robot.all_solutions(T)
    goals = solutions.q[solutions.valid]
    free = goals[~robot.in_collision(goals, world)]
    lengths = np.sort(np.linalg.norm(free - robot.home, axis=1))
    straight = robot.edge_in_collision(np.broadcast_to(robot.home, free.shape), free, world)
    assert lengths[0] < 1.5
    assert 2 * lengths[0] < lengths[1]
    assert not straight.in_collision.all(), "the straight way to a far one is free"
    plan = robot.plan(robot.home, T, world, seed=seed)
    assert plan
    assert np.linalg.norm(plan.path[-1] - robot.home) == pytest.approx(lengths[0], abs=1e-6)


def test_near_goals_come_before_all_and_are_some_of_a_trials_own():
    fixed = np.array([False, True])
    trials = Trial(fixed, np.array([0, 1, 3]), 1000), Trial(fixed, np.array([2]), 50)
    first, second, third = prepend_near_trials(trials, np.array([1.0, 1.9, 0.1, 2.1]))
    assert (first.goals.tolist(), first.checks, first.fixed.tolist()) == ([0, 1], 300, [False, True])
    assert second is trials[0]
    assert third is trials[1]
