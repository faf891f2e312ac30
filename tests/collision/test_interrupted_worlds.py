"""A change of a world that a signal interrupts, and one that another thread makes: each answer is that of one of its states."""

import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ulna
from interrupts import interrupted_at_every_place

SMALL, LARGE = ulna.Sphere(0.02), ulna.Box((0.2, 0.1, 0.3))
CLOUD = ulna.PointCloud(np.random.default_rng(0).normal(size=(40, 3)) * 0.05, 0.01)
OTHER = ulna.PointCloud(CLOUD.points + 0.03, 0.01)
NEAR, FAR = ulna.pose((0.4, 0.1, 0.6), (0.1, 0.2, 0.3)), ulna.pose((0.9, -0.2, 0.3))
CHANGES = {
    "add": lambda world: world.add("new", LARGE, NEAR, touch_links=["panda_link7"], speed=0.2),
    "add_many": lambda world: world.add_many([("new", LARGE, NEAR), ("newer", CLOUD, FAR)], touch_links=["panda_link7"]),
    "move": lambda world: world.move("ball", NEAR),
    "move_many": lambda world: world.move_many(["ball", "trolley", "seen"], np.stack([NEAR, FAR, NEAR])),
    "reshape": lambda world: world.reshape("ball", LARGE),
    "reshape to a cloud": lambda world: world.reshape("trolley", CLOUD),
    "update": lambda world: world.update("seen", OTHER),
    "remove": lambda world: world.remove("trolley"),
    "objects": lambda world: world.objects(),
    "copy": lambda world: world.copy(),
    "snapshot": lambda world: world.snapshot(),
    "pickle": pickle.dumps,
}


def some_world():
    world = ulna.World()
    world.add("ball", SMALL, FAR)
    world.add("trolley", LARGE, ulna.pose((0.9, 0.3, 0.5)), touch_links=["panda_link8"], speed=0.1)
    world.add("seen", CLOUD, ulna.pose((0.6, 0.3, 0.2)))
    world.objects()
    world.move("seen", ulna.pose((0.6, 0.3, 0.3)))
    return world


def told(world):
    """All that a world says of itself, as values that can be compared."""
    return [
        (name, pickle.dumps(shape), T.tobytes(), world.touch_links(name), world.speed(name), world.shape(name) is shape)
        for name, shape, T in world.items()
    ], world.names


def fresh(world):
    other = ulna.World()
    for name, shape, T in world.items():
        other.add(name, shape, T, touch_links=world.touch_links(name), speed=world.speed(name))
    return other


def assert_tells_one_story(robot, q, world):
    """What is asked of a world, of its copies and of its pickle is what a world made anew has."""
    anew = fresh(world)
    expected = robot.signed_distance(q, anew, self_collision=False)
    for each in (world, world.copy(), world.snapshot(), pickle.loads(pickle.dumps(world)), world):  # noqa: S301 - our own
        assert told(each) == told(anew)
        assert robot.signed_distance(q, each, self_collision=False) == pytest.approx(expected, abs=1e-12)
        moving = [(one.name, one.speed, one.pose.tobytes(), one.radius) for one in each.objects().moving]
        assert moving == [(one.name, one.speed, one.pose.tobytes(), one.radius) for one in anew.objects().moving]


def assert_interrupted_in_whole_or_not_at_all(robot, change, asks, *, each):
    def act(world):
        change(world)
        if asks:
            world.objects()

    before, after, found = told(some_world()), some_world(), set()
    change(after)
    after = told(after)

    def judge(world):
        found.add(told(world) == after)
        assert told(world) in (before, after)
        assert_tells_one_story(robot, robot.home, world)
        if told(world) == before != after:
            change(world)
        world.move("ball", ulna.pose((0.5, 0.5, 0.5)))
        assert_tells_one_story(robot, robot.home, world)

    assert interrupted_at_every_place(some_world, act, judge, each=each) > 10
    assert before == after or found == {False, True}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_a_change_that_is_interrupted_is_made_in_whole_or_not_at_all(panda, name):
    assert_interrupted_in_whole_or_not_at_all(panda, CHANGES[name], asks=False, each=False)


@pytest.mark.slow
@pytest.mark.parametrize("asks", [False, True])
@pytest.mark.parametrize("name", CHANGES)
def test_so_it_is_at_each_time_that_a_place_is_passed(panda, name, asks):
    assert_interrupted_in_whole_or_not_at_all(panda, CHANGES[name], asks=asks, each=True)


def test_while_one_thread_changes_a_world_others_find_one_of_its_states(panda):
    """Two boxes trade places in one call, a third is there or not, and a fourth is small or large: eight worlds."""
    world, q = ulna.World(), panda.random(1, seed=3)[0]
    world.add_many([("a", SMALL, PLACES[0]), ("b", LARGE, PLACES[1]), ("d", SMALL, ulna.pose((0.2, -0.5, 0.7)))])
    states, ended = set(), threading.Event()
    for k in range(64):
        change_for(k, world)
        states.add(panda.signed_distance(q, fresh(world), self_collision=False))

    def ask():
        found = set()
        while not ended.is_set():
            found |= {panda.signed_distance(q, of, self_collision=False) for of in (world, world.snapshot())}
        return found

    with ThreadPoolExecutor(2) as threads:
        asked = [threads.submit(ask) for _ in range(2)]
        for k in range(3000):
            change_for(k, world)
        ended.set()
        found = set.union(*(each.result() for each in asked))
    known = np.array(sorted(states))
    assert len(known) >= 3
    for answer in found:
        assert np.abs(known - answer).min() < 1e-12


PLACES = [ulna.pose((0.6, y, 0.5)) for y in (0.0, 0.3)]


def change_for(k, world):
    """One of the changes of the test above."""
    if k % 3 == 0:
        world.move_many(["a", "b"], np.stack(PLACES[:: 1 if k % 2 else -1]))
    elif k % 3 == 1:
        world.remove("c") if "c" in world else world.add("c", SMALL, ulna.pose((0.45, 0.1, 0.6)))
    else:
        world.reshape("d", LARGE if world.shape("d") is SMALL else SMALL)
