"""Many plans: each is that of a single call, whatever the number of threads."""

import numpy as np
import pytest

import ulna
from ulna.errors import InputError


@pytest.fixture(scope="module")
def worlds():
    made = []
    for x in (0.35, 0.4, 0.45):
        world = ulna.World()
        world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((x, 0, 0.6)))
        made.append(world)
    return made


def sides(panda):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    return left, right


@pytest.mark.parametrize("threads", [1, 4])
def test_each_row_is_bit_for_bit_that_of_a_single_call(panda, worlds, threads):
    left, right = sides(panda)
    starts, goals = np.stack([left, right, left]), np.stack([right, left, right])
    with ulna.threads(threads):
        plans = panda.plan_many(starts, goals, worlds, seed=2)
    for k, plan in enumerate(plans):
        one = panda.plan(starts[k], goals[k], worlds[k], seed=2)
        assert np.array_equal(plan.path, one.path)
        assert plan.effort == one.effort


def test_one_start_and_one_world_serve_all_goals_and_progress_is_told(panda, worlds):
    left, right = sides(panda)
    told = []
    plans = panda.plan_many(left, [right, left + 0.1], worlds[0], progress=lambda done, of: told.append((done, of)))
    assert [bool(plan) for plan in plans] == [True, True]
    assert sorted(told) == [(1, 2), (2, 2)]
    poses = panda.forward_kinematics(np.stack([right, left + 0.1]))
    assert all(panda.plan_many(left, poses, worlds[0]))


def test_constraints_and_held_joints_that_can_be_read_but_once_hold_in_every_row(panda):
    sixth, one = np.eye(7)[5], ulna.Keep.upright(within=0.1)
    plans = panda.plan_many(panda.home, [panda.home + 0.3 * sixth] * 3, keep=iter([one]))
    assert [str(plan.status) for plan in plans] == ["goal outside"] * 3
    plans = panda.plan_many(panda.home, [panda.home + 0.05 * sixth] * 3, keep=iter([one]))
    assert all(0 < plan.worst_violation <= 1 for plan in plans)


def test_numbers_that_do_not_go_together_are_refused_and_a_bad_row_is_named(panda, worlds):
    left, right = sides(panda)
    with pytest.raises(InputError, match="do not go together"):
        panda.plan_many([left, left, left], [right, right], worlds[0])
    with pytest.raises(InputError, match="do not go together"):
        panda.plan_many(left, [right, right], worlds)
    with pytest.raises(InputError, match="row 1: goal"):
        panda.plan_many(left, [right, right + 10], worlds[0])
    assert panda.plan_many(left, np.empty((0, 7)), None) == ()


def test_a_bar_is_shown_on_a_terminal_and_nothing_elsewhere(panda, monkeypatch, capsys):
    left, right = sides(panda)
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    quiet = panda.plan_many(left, [right, left], progress=True)
    assert capsys.readouterr().err == ""
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes standard error for a terminal then
    shown = panda.plan_many(left, [right, left], progress=True)
    assert "planning" in capsys.readouterr().err
    assert all(np.array_equal(a.path, b.path) for a, b in zip(quiet, shown, strict=True))


def test_a_function_for_the_progress_is_called_by_one_thread_at_a_time_in_order(panda, worlds):
    left, right = sides(panda)
    told = []
    with ulna.threads(4):
        panda.plan_many(left, [right] * 40, worlds[0], progress=lambda done, of: told.append((done, of)))
    assert told == [(k, 40) for k in range(1, 41)]
