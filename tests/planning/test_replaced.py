"""A motion that is left while it runs: the old one up to then, smooth, within its limits, and free."""

import pickle
from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

FRANKA = {"limits": "franka"}
SLOW = {"acceleration": 5.0, "jerk": 50.0}
SUDDEN = {"acceleration": 5.0}


def ends(panda):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    return left, right


def judge(old, new, t):
    """That it is the old motion up to t, smooth, and within its limits at 50,001 moments and by differences of them."""
    before = np.linspace(0, t, 500)
    assert np.allclose(new.at(before).q, old.at(before).q, atol=1e-13)
    moments = np.linspace(0, new.duration, 50_001)
    moment, h = new.at(moments), moments[1]
    kept = [limit for limit in old._limits if limit is not None]
    for (values, rates), most in zip(pairwise(moment), kept, strict=False):
        assert (np.abs(rates) <= most * (1 + 1e-9)).all()
        assert (np.abs(np.diff(values, axis=0)) <= most * h * (1 + 1e-6) + 1e-12).all()
    for period in (1e-3, 1e-4):
        assert new.check(period=period)


@pytest.mark.slow
@pytest.mark.parametrize("options", [FRANKA, SLOW, SUDDEN])
@pytest.mark.parametrize("corners", [False, True])
def test_it_is_the_old_motion_until_then_and_keeps_its_limits(panda, world, options, corners):
    left, right = ends(panda)
    old = panda.plan(left, right, world if corners else None).trajectory(**options)
    assert old.stops == 0
    for share in np.linspace(0, 1, 9):
        t = float(share * old.duration)
        goal = left if share > 0.3 else panda.home
        goal = goal + np.array([0, -0.3, 0, 0, 0.4, 0, 0])
        plan = panda.plan(old.at(t).q, goal)
        new = old.replace(plan, at=t)
        judge(old, new, t)
        assert np.allclose(new.q[-1], goal, atol=1e-9)
        assert new.certified
        if 0.2 < share < 0.8:  # it does not stop there
            assert np.abs(new.at(t).qd).max() > 0.1
            assert np.abs(new.at(t + 1e-6).qd - new.at(t).qd).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("options", [FRANKA, SLOW])
def test_a_motion_that_stops_at_its_corners_is_replaced_on_each_of_its_lines(panda, world, options):
    left, right = ends(panda)
    old = panda.plan(left, right, world).trajectory(blend=0.0, **options)
    assert old.stops > 1
    middles = (old.rests[1:] + old.rests[:-1]) / 2
    for t in np.concatenate([old.rests, middles, old.rests[:-1] + 0.02]).tolist():
        plan = panda.plan(old.at(t).q, panda.home + np.array([0, -0.3, 0, 0, 0.4, 0, 0]))
        new = old.replace(plan, at=t)
        judge(old, new, t)
        assert np.allclose(new.q[-1], plan.path[-1], atol=1e-9)
        assert new.is_free(None, since=t)
        assert np.array_equal(new.rests[new.rests < t - 1e-9], old.rests[old.rests < t - 1e-9])
        later = t + 0.4 * (new.duration - t)
        again = new.replace(panda.plan(new.at(later).q, left), at=later)
        judge(new, again, later)
        earlier = new.replace(panda.plan(new.at(0.5 * t).q, panda.home), at=0.5 * t)
        judge(new, earlier, 0.5 * t)
        assert again.slowed(0.5).check()
        assert pickle.loads(pickle.dumps(again)).duration == again.duration  # noqa: S301


@pytest.mark.parametrize("options", [FRANKA, SLOW, SUDDEN])
def test_an_arm_at_rest_is_moved_within_the_limits_and_one_that_moves_comes_back(panda, options):
    left, right = ends(panda)
    resting = panda.plan(left, left).trajectory(**options)
    judge(resting, resting.replace(panda.plan(left, right), at=0.0), 0.0)
    old = panda.plan(left, right).trajectory(**options)
    t = 0.4 * old.duration
    here = old.at(t).q
    plan = panda.plan(here, here)
    assert len(plan.path) == 1
    new = old.replace(plan, at=t)
    judge(old, new, t)
    assert np.allclose(new.q[-1], here, atol=1e-9)


def test_a_replaced_motion_can_be_replaced_and_slowed(panda):
    left, right = ends(panda)
    first = panda.plan(left, right).trajectory(**FRANKA)
    t = 0.4 * first.duration
    second = first.replace(panda.plan(first.at(t).q, panda.home + 0.2), at=t)
    later = t + 0.5 * (second.duration - t)
    third = second.replace(panda.plan(second.at(later).q, right), at=later)
    judge(second, third, later)
    assert third.slowed(0.5).check()


@pytest.mark.slow
@pytest.mark.parametrize("options", [FRANKA, SLOW, SUDDEN])
def test_beside_obstacles_it_touches_nothing_and_brakes_along_its_own_path_where_straight_on_is_not_free(panda, world, options):
    left, right = ends(panda)
    old = panda.plan(left, right, world).trajectory(**options)
    stops = 0
    for share in np.linspace(0.02, 0.98, 21):
        t = float(share * old.duration)
        plan = panda.plan(old.at(t).q, left if share > 0.3 else right, world)
        new = old.replace(plan, at=t)
        judge(old, new, t)
        assert np.allclose(new.q[-1], plan.path[-1], atol=1e-9)
        assert not panda.in_collision(new.at(np.linspace(t, new.duration, 5001)).q, world).any()
        assert new.is_free(world, since=t)
        stops += new.stops
    assert stops > 0


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6])
def test_along_a_tight_constraint_it_flows_through_the_corners_of_the_plan_and_keeps_it(panda, world, share):
    left, right = ends(panda)
    T = panda.forward_kinematics(left)
    keep = ulna.Keep.in_plane(ulna.pose(T[:3, 3]), within=1e-4)
    old = panda.plan(left, right, world, keep=keep, seed=2).trajectory(**SUDDEN)
    t = share * old.duration
    plan = panda.plan(old.at(t).q, left if share else right, world, keep=keep, seed=9)
    new = old.replace(plan, at=t)
    judge(old, new, t)
    assert len(plan.path) > 50  # it may stop where it leaves its own path, and where it is back there
    assert new.stops <= (2 if share else 0)
    assert new.is_free(world, since=t, keep=keep)
    away = panda.forward_kinematics(new.at(np.linspace(t, new.duration, 20_001)).q)[:, 2, 3] - T[2, 3]
    assert np.abs(away).max() <= 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.5])
def test_along_a_tight_constraint_a_motion_within_limits_of_jerk_is_left_while_it_moves(panda, world, share):
    left, right = ends(panda)
    keep = ulna.Keep.in_plane(ulna.pose(panda.forward_kinematics(left)[:3, 3]), within=1e-4)
    old = panda.plan(left, right, world, keep=keep, seed=2).trajectory(**FRANKA)
    t = share * old.duration
    new = old.replace(panda.plan(old.at(t).q, left if share > 0.3 else right, world, keep=keep, seed=9), at=t)
    judge(old, new, t)
    assert new.check()
    assert new.is_free(world, since=t, keep=keep)


def test_along_a_tight_constraint_a_motion_within_limits_of_jerk_is_left_at_rest(panda, world):
    left, right = ends(panda)
    keep = ulna.Keep.in_plane(ulna.pose(panda.forward_kinematics(left)[:3, 3]), within=1e-4)
    old, plan = (panda.plan(left, right, world, keep=keep, seed=seed) for seed in (2, 9))
    old = old.trajectory(**FRANKA)
    new = old.replace(plan, at=0.0)
    assert new.check()
    assert new.is_free(world, keep=keep)
    assert np.allclose(new.q[-1], right, atol=1e-9)


def test_where_its_own_path_is_not_free_either_it_is_refused(panda):
    left, right = ends(panda)
    old = panda.plan(left, right).trajectory(**FRANKA)
    t = 0.5 * old.duration
    world = ulna.World()
    world.add("new", ulna.Sphere(0.05), panda.forward_kinematics(old.at(t + 0.25).q))
    plan = panda.plan(old.at(t).q, left, world)
    assert plan
    with pytest.raises(InputError, match=r"plan: no transition to it .*, neither straight on nor along the motion's own path"):
        old.replace(plan, at=t)


def test_what_cannot_be_replaced_is_refused_by_name(panda, world):
    left, right = ends(panda)
    plan = panda.plan(left, right, world)
    old = plan.trajectory(**FRANKA)
    for at, argument in ((-1.0, "at"), (old.duration + 1, "at"), (True, "at"), (0.5, "plan: its path does not begin")):
        with pytest.raises(InputError, match=argument):
            old.replace(plan, at=at)
    for other in ("x", None, old, plan.path):
        with pytest.raises(InputError, match=r"plan: .* an ulna\.Plan is expected"):
            old.replace(other, at=0.1)
    inside = ulna.World()
    inside.add("goal", ulna.Box((0.2, 0.2, 0.2)), panda.forward_kinematics(right))
    with pytest.raises(InputError, match="plan: there is no path: goal in collision"):
        old.replace(panda.plan(left, right, inside), at=0.0)
    nowhere = old.replace(panda.plan(old.at(old.duration).q, left), at=old.duration)
    assert np.allclose(nowhere.q[-1], left, atol=1e-9)


def test_it_is_certified_only_where_the_motion_that_it_replaces_is(panda):
    left, right = ends(panda)
    old = panda.plan(left, right, certify=False).trajectory(**FRANKA)
    assert not old.certified
    assert not old.replace(panda.plan(old.at(0.3).q, left), at=0.3).certified


def near_an_end(panda, room=0.01):
    """A tour that turns round 10 mrad before the upper end of the first joint, rounded by as much as 0.3 rad."""
    goal, back = panda.home.copy(), panda.home.copy()
    goal[0], back[:2] = panda.upper[0] - room, 0.5
    return np.stack([panda.home, goal, back])


@pytest.mark.parametrize("options", [FRANKA, SLOW, {"acceleration": 2.0}])
def test_it_never_leaves_the_limits_of_position_on_its_way_over(panda, options):
    tour, replaced = panda.trajectory(near_an_end(panda), within=0.3, world=ulna.World(), **options), 0
    for t in np.linspace(0.3, 0.95, 14) * tour.duration:
        try:
            new = tour.replace(panda.plan(tour.at(t).q, panda.home), at=t)
        except InputError:
            continue
        q, replaced = new.at(np.linspace(0, new.duration, 20_001)).q, replaced + 1
        assert (q <= panda.upper).all()
        assert (q >= panda.lower).all()
        assert new.check()
        assert new.certified
    assert replaced > 5


def test_a_plan_beyond_the_limits_of_the_motion_that_it_replaces_is_refused(panda):
    left, right = ends(panda)
    narrow = panda.with_limits(lower={"panda_joint1": -1.0}, upper={"panda_joint1": 1.0})
    old = narrow.plan(left, right).trajectory(**FRANKA)
    wide = right.copy()
    wide[0] = -1.2
    with pytest.raises(InputError, match=r"plan: the plan has panda_joint1 at -1.2, 0.2 beyond its lower limit of -1"):
        old.replace(panda.plan(old.at(0.1).q, wide), at=0.1)
