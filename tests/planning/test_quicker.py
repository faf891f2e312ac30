"""``plan.quicker``: motions that take less time, as certified as the plan's, with the same bits at each call."""

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

LIMITS = {"limits": "franka"}


def test_the_motion_takes_less_time_and_is_free(panda, world, plan):
    quick = plan.quicker(80, **LIMITS)
    before, motion = plan.trajectory(**LIMITS), quick.trajectory(**LIMITS)
    assert motion.duration < 0.99 * before.duration
    assert quick.certified
    assert motion.certified
    assert motion.check()
    assert np.array_equal(quick.path[[0, -1]], plan.path[[0, -1]])
    assert ((quick.path >= panda.lower) & (quick.path <= panda.upper)).all()
    assert not panda.in_collision(motion.at(np.linspace(0, motion.duration, 4001)).q, world).any()
    assert np.array_equal(quick.path, plan.quicker(80, **LIMITS).path)


def test_it_is_never_slower_and_looks_at_the_limits_that_are_given(plan):
    slow_base = {"acceleration": 10.0, "velocity": np.array([0.2, 2, 2, 2, 2, 2, 2])}
    durations = [plan.trajectory(**slow_base).duration]
    durations += [plan.quicker(tries, **slow_base).trajectory(**slow_base).duration for tries in (1, 20, 60)]
    assert durations == sorted(durations, reverse=True)


def test_joints_that_are_held_stay(panda, world):
    start, goal = panda.home.copy(), panda.home.copy()
    start[0], goal[0] = 1, -1
    plan = panda.plan(start, goal, world, held=["panda_joint7"])
    assert (plan.quicker(40, **LIMITS).path[:, 6] == panda.home[6]).all()


def test_where_nothing_is_in_the_way_or_nothing_moves_the_path_stays_one_that_is_free(panda):
    still = panda.plan(panda.home, panda.home)
    assert np.array_equal(still.quicker(5, **LIMITS).path, still.path)
    line = panda.plan(panda.home, panda.home + 0.1)
    quick = line.quicker(20, **LIMITS)
    assert quick.trajectory(**LIMITS).duration <= line.trajectory(**LIMITS).duration


def test_what_cannot_be_taken_is_refused_by_name(panda, plan):
    for tries in (0, -1, 1.5, True, "many"):
        with pytest.raises(InputError, match="tries"):
            plan.quicker(tries, **LIMITS)
    with pytest.raises(InputError, match="acceleration: none is given"):
        plan.quicker(5)
    blocked = ulna.World()
    blocked.add("there", ulna.Box((0.2, 0.2, 0.2)), panda.forward_kinematics(panda.home))
    with pytest.raises(InputError, match="plan: there is no path: start in collision"):
        panda.plan(panda.home, panda.home + 0.1, blocked).quicker(5, **LIMITS)
