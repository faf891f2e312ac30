"""A tick, a start or a change of the world that a signal interrupts: the servo goes on as it was before it, or after it."""

import copy
import pickle

import numpy as np
import pytest

import ulna
from interrupts import interrupted_at_every_place

WAY = np.array([0.6, -0.2, 0.1, 0.3, 0.0, 0.2, 0.1])
CERTIFIED = {"following", "limited by velocity", "limited by acceleration", "limited by clearance", "braking", "at rest"}


@pytest.fixture(scope="module")
def kept(panda):
    """A servo in motion among an object that may move and two that do not, and its world, as a pickle: each is used once."""
    world = ulna.World()
    world.add("trolley", ulna.Sphere(0.1), ulna.pose((0.9, 0.4, 0.5)), speed=0.1)
    world.add_many([("post", ulna.Box((0.1, 0.1, 0.8)), ulna.pose((0.6, -0.5, 0.4))), ("ball", ulna.Sphere(0.1), FAR)])
    servo = panda.servo(world, acceleration=4.0, tracking_error=1e-3)
    servo.start(panda.home)
    for _ in range(20):
        servo.step(velocity=WAY)
    return pickle.dumps((servo, world))


FAR = ulna.pose((2.0, 2.0, 2.0))


def in_motion(kept):
    servo, world = pickle.loads(kept)  # noqa: S301 - our own
    servo.step(velocity=WAY)  # the stop is certified
    return servo, world


def told(servo):
    """All that a servo says of itself, as values that can be compared."""
    ends, speeds = servo.certified_stop
    numbers = servo.q, servo.qd, ends, speeds
    return *(each.tobytes() for each in numbers), servo.ticks, servo.saved().moving.tobytes()


def outlook(servo):
    """The commands that come next."""
    commands = [servo.step(velocity=WAY), servo.step(twist=np.full(6, 0.05)), servo.step()]
    return [(command.q.tobytes(), str(command), command.limiting) for command in commands]


ACTS = {
    "step": lambda servo, _: servo.step(),
    "step by q": lambda servo, _: servo.step(q=servo.q + 0.01),
    "step by a velocity": lambda servo, _: servo.step(velocity=-WAY),
    "step by a twist": lambda servo, _: servo.step(twist=np.full(6, 0.1)),
    "step by a pose": lambda servo, _: servo.step(pose=ulna.pose((0.5, 0.1, 0.5), (3.0, 0.1, 0.0))),
    "step off the command": lambda servo, _: servo.step(velocity=WAY, measured=servo.q + 0.1),
    "start": lambda servo, _: servo.start(servo.q, 0.5 * servo.qd),
    "a start that is refused": lambda servo, _: refused(servo.start, servo.q, np.full(7, 100.0)),
    "saved": lambda servo, _: servo.saved(),
    "restore": lambda servo, _: servo.restore(servo.saved()._replace(ticks=3)),
    "warm_up": lambda servo, _: servo.warm_up(),
    "pickle": lambda servo, _: pickle.dumps(servo),
    "copy": lambda servo, _: copy.copy(servo).step(velocity=-WAY),
}
CHANGES = {
    "add": lambda world: world.add("new", ulna.Sphere(0.1), ulna.pose((0.9, 0.0, 0.9)), speed=0.1),
    "move": lambda world: world.move("post", ulna.pose((0.6, -0.6, 0.4))),
    "move what may move": lambda world: world.move("trolley", ulna.pose((0.9, 0.4, 0.5))),
    "remove": lambda world: world.remove("trolley"),
}


def refused(call, *arguments):
    with pytest.raises(ulna.InputError):
        call(*arguments)


def assert_in_whole_or_not_at_all(make, act, *, each=False):
    """It goes on as before the act, or as after it."""
    servo, world = make()
    before = told(servo), outlook(servo)
    servo, world = make()
    act(servo, world)
    after = told(servo), outlook(servo)

    def judge(pair):
        found = told(pair[0]), outlook(pair[0])
        assert found in (before, after)

    assert interrupted_at_every_place(make, lambda pair: act(*pair), judge, each=each) >= 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ACTS)
def test_what_is_interrupted_is_done_in_whole_or_not_at_all(kept, name):
    assert_in_whole_or_not_at_all(lambda: in_motion(kept), ACTS[name])


@pytest.mark.parametrize("change", CHANGES)
def test_a_tick_in_a_world_that_has_changed_is_interrupted_likewise(kept, change):
    def make():
        servo, world = in_motion(kept)
        CHANGES[change](world)
        return servo, world

    assert_in_whole_or_not_at_all(make, ACTS["step by a velocity"])


def stop_is_free(servo, world, robot):
    ends, _ = servo.certified_stop
    return not robot.in_collision(np.linspace(servo.q, ends, 60), world).any()


@pytest.mark.parametrize("how", ["move", "move_many", "add", "reshape"])
def test_a_change_into_the_stop_that_is_interrupted_leaves_no_stop_certified_that_touches(panda, kept, how):
    servo, _ = in_motion(kept)
    inside = panda.forward_kinematics(servo.certified_stop[0])
    changes = {
        "move": lambda world: world.move("ball", inside),
        "move_many": lambda world: world.move_many(["post", "ball"], [FAR, inside]),
        "add": lambda world: world.add("new", ulna.Sphere(0.1), inside),
        "reshape": lambda world: world.reshape("ball", ulna.Box((4.5, 4.5, 4.5))),
    }
    statuses = set()

    def judge(pair):
        command = pair[0].step(velocity=WAY)
        statuses.add(command.status in CERTIFIED)
        assert command.status not in CERTIFIED or stop_is_free(*pair, panda)

    interrupted_at_every_place(lambda: in_motion(kept), lambda pair: changes[how](pair[1]), judge)
    assert statuses == {False, True}


def test_a_copy_does_not_share_its_state(panda, kept):
    servo, _ = in_motion(kept)
    twin, other = in_motion(kept)[0], copy.copy(servo)
    for _ in range(5):
        other.step(velocity=-WAY)
    other.start(panda.home)
    assert told(servo) == told(twin)
    assert outlook(servo) == outlook(twin)


def test_a_start_that_is_refused_changes_nothing(panda, kept):
    (servo, _), (twin, _) = in_motion(kept), in_motion(kept)
    for q, qd in ((servo.q, np.full(7, 100.0)), (panda.upper + 1.0, None), (panda.upper - 1e-3, 0.9 * panda.velocity_limits)):
        refused(servo.start, q, qd)
    assert outlook(servo) == outlook(twin)


@pytest.mark.parametrize("saved", [None, (), "state"])
def test_what_was_not_saved_is_not_restored(kept, saved):
    servo, _ = in_motion(kept)
    with pytest.raises(ulna.InputError, match=r"saved: .*servo.saved\(\)"):
        servo.restore(saved)


@pytest.mark.parametrize("rate", [5e-324, 1e-300, 1e-6, 1e6, np.inf, np.nan])
def test_a_rate_without_sense_is_named(panda, rate):
    with pytest.raises(ulna.InputError, match="rate"):
        panda.servo(rate=rate, acceleration=1.0)
