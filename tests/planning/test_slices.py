"""A search is cut into slices of about the same time, however long an edge takes."""

import numpy as np
import pytest

import ulna
from ulna.errors import InputError
from ulna.planning import search
from ulna.planning.slices import _FIRST_SLICE, _LONGEST_SLICE, Pace


def test_a_slice_becomes_as_long_as_is_wanted_and_stays_so():
    pace = Pace()
    for _ in range(10):
        pace.adapt(pace.checks * 1e-5, pace.checks)
    assert abs(pace.checks - 0.5 * _LONGEST_SLICE / 1e-5) <= 1


def test_a_slice_of_slow_edges_becomes_one_edge():
    pace = Pace()
    for _ in range(10):
        pace.adapt(pace.checks * 0.1, pace.checks)
    assert pace.checks == 1


def test_a_slice_that_ended_early_counts_by_the_edges_that_were_checked():
    pace = Pace()
    pace.adapt(1e-3, 1)
    assert pace.checks == _FIRST_SLICE // 2


def test_where_slices_end_and_how_much_room_there_was_at_first_for_the_path_changes_no_bit(panda, world, monkeypatch):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    whole = [panda.plan(left, right, world, seed=seed) for seed in range(4)]
    monkeypatch.setattr(search, "_WAYPOINTS", 1)
    monkeypatch.setattr(Pace, "adapt", lambda pace, *_: setattr(pace, "checks", 1))
    for seed, plan in enumerate(whole):
        again = panda.plan(left, right, world.copy(), seed=seed)
        assert np.array_equal(again.path, plan.path)
        assert again.effort == plan.effort
        assert again.certified


def test_a_plan_keeps_the_world_as_it_was_and_the_next_one_sees_what_has_moved(panda):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 5)))
    free, kept = panda.plan(left, right, world), world.snapshot()
    assert world.snapshot() is kept
    world.move("post", ulna.pose((0.35, 0, 0.6)))
    assert world.snapshot() is not kept
    assert kept.pose("post")[2, 3] == 5
    round_it = panda.plan(left, right, world)
    assert free.clearance > 1 > round_it.clearance
    assert len(free.path) == 2 < len(round_it.path)


def test_progress_is_the_number_of_checked_edges_after_each_slice_and_changes_no_bit(panda, world, monkeypatch):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    monkeypatch.setattr(Pace, "adapt", lambda pace, *_: setattr(pace, "checks", 8))
    told = []
    plan = panda.plan(left, right, world, progress=lambda done, of: told.append((done, of)), max_checks=50_000)
    done = [checks for checks, _ in told]
    assert done == sorted(done)
    assert done[-1] == plan.checks
    assert len(set(done)) > 4
    assert {of for _, of in told} == {50_000}
    assert np.array_equal(plan.path, panda.plan(left, right, world).path)


def test_what_progress_raises_ends_the_search_and_only_a_function_is_taken(panda, world):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0

    def give_up(done, of):
        raise TimeoutError

    with pytest.raises(TimeoutError):
        panda.plan(left, right, world, progress=give_up)
    with pytest.raises(InputError, match="progress: True; a function"):
        panda.plan(left, right, world, progress=True)
