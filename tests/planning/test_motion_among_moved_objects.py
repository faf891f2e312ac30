"""A motion looked at again among other objects: what is certified is the curve that is played, from a time on."""

import pickle
from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

SMALL = ulna.Box((0.01, 0.01, 0.01))


@pytest.fixture(scope="module")
def plan(panda, world):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    return panda.plan(left, right, world)


def beside(q, points, spreads):
    """How far each q, shape (m, n_dof), lies outside what is certified, at best of all edges: the largest of its entries."""
    steps = np.diff(points, axis=0)

    def outside(share):
        return (np.abs(q[:, None] - points[:-1] - share[..., None] * steps) - spreads).max(axis=2)

    low = np.zeros((len(q), len(steps)))
    high = low + 1.0
    for _ in range(90):  # a convex function of the place on the edge: thirds
        a, b = (2 * low + high) / 3, (low + 2 * high) / 3
        left = outside(a) < outside(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return np.minimum(outside(low), np.minimum(outside(low * 0), outside(low * 0 + 1))).min(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"blend": 0.0}, {"blend": 2.0}, {"jerk": 30.0}, {"jerk": 3000.0, "blend": 2.0}])
@pytest.mark.parametrize("share", [0.0, 0.123, 0.5, 0.987, 1.0])
def test_every_moment_lies_within_what_is_looked_at(plan, options, share):
    motion = plan.trajectory(acceleration=3.0, **options)
    since = share * motion.duration
    points, spreads = motion._timed.edges_since(since)
    q = motion.at(np.linspace(since, motion.duration, 501)).q
    assert beside(q, points, spreads).max() < 1e-12
    assert spreads.max() < 2e-3
    assert np.allclose(points[[0, -1]], q[[0, -1]], atol=1e-12)
    if not spreads.any():
        assert len(points) <= len(plan.path)  # a line is one edge


def test_it_is_free_where_it_was_planned_and_not_where_something_is_put_in_its_way(panda, world, plan):
    motion = plan.trajectory(acceleration=3.0)
    assert motion.is_free(world)
    assert motion.is_free(None)
    for share in (0.1, 0.5, 0.9):
        T = panda.forward_kinematics(motion.at(share * motion.duration).q)
        other = world.copy()
        other.add("new", SMALL, T)
        assert not motion.is_free(other)
        assert pickle.loads(pickle.dumps(motion)).is_free(world)  # noqa: S301
        rest = motion.at(np.linspace(min(1.0, share + 0.3) * motion.duration, motion.duration, 2001)).q
        if not panda.in_collision(rest, other).any() and share < 0.7:
            assert motion.is_free(other, since=(share + 0.3) * motion.duration)
    assert not motion.is_free(world, clearance=0.5)


def test_what_lies_between_a_fast_motion_and_its_chords_is_seen(panda, plan, rng):
    """Chords between configurations 20 ms apart pass it by; the arm does not."""
    motion, seen = plan.trajectory(velocity=1e3, acceleration=1e5), 0
    q = motion.at(np.linspace(0, motion.duration, 1001)).q
    looks = motion.at(np.linspace(0, motion.duration, 2 + int(motion.duration / 0.02))).q
    chords = np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(looks)])
    hands = panda.forward_kinematics(q)
    for T, offset in zip(rng.choice(hands, 200), rng.uniform(-0.05, 0.05, (200, 3)), strict=True):
        world = ulna.World()
        world.add("new", SMALL, T @ ulna.pose(offset))
        if panda.in_collision(q, world).any() and not panda.in_collision(chords, world).any():
            assert not motion.is_free(world)
            seen += 1
    assert seen


def test_a_motion_that_rests_is_looked_at_too(panda):
    motion = panda.plan(panda.home, panda.home).trajectory(acceleration=3.0)
    world = ulna.World()
    assert motion.is_free(world)
    world.add("new", SMALL, panda.forward_kinematics(panda.home))
    assert not motion.is_free(world)
    assert not motion.is_free(world, since=7.0)


def test_what_cannot_be_taken_is_refused_by_name(plan, world):
    motion = plan.trajectory(acceleration=3.0)
    for options, argument in (({"since": -1.0}, "since"), ({"since": np.nan}, "since"), ({"clearance": np.inf}, "clearance")):
        with pytest.raises(InputError, match=f"^{argument}: "):
            motion.is_free(world, **options)
    with pytest.raises(InputError, match=r"^world: list"):
        motion.is_free([])
