"""The world of most of these plans: a post and a shelf before a Panda, which goes from one side of the post to the other."""

import signal

import pytest

import ulna


@pytest.fixture(scope="module")
def world():
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    world.add("shelf", ulna.Box((0.5, 2, 0.05)), ulna.pose((0.6, 0, 0.95)))
    return world


@pytest.fixture(scope="module")
def plan(panda, world):
    """From one side of the post to the other, with at least one corner."""
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    plan = panda.plan(left, right, world)
    assert len(plan.path) > 2
    return plan


@pytest.fixture
def interruptible():
    """Ctrl-C raises KeyboardInterrupt, though a shell that runs the tests in the background lets them ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
