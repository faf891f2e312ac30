"""Objects that move towards the arm: what their stated speed promises, and the way out of one that is put into the arm."""

import pickle

import numpy as np
import pytest

import ulna
from servo_judge import FINER, RATE, hostile

ACCELERATION, SPEED, RADIUS = 10.0, 0.3, 0.08


def placed(xyz):
    return ulna.pose(tuple(xyz))


BALL = ulna.Sphere(RADIUS)
CLOUD = ulna.PointCloud(np.random.default_rng(0).uniform(-0.05, 0.05, (300, 3)), 0.02)


def with_ball(xyz, speed=SPEED, shape=BALL, robot=None, **options):
    """A servo at rest, with a ball that may move, and its world."""
    robot, world = robot or ulna.load("panda"), ulna.World()
    world.add("ball", shape, placed(xyz), speed=speed)
    servo = robot.servo(world, **{"acceleration": ACCELERATION, **options})
    servo.start(robot.home)
    return servo, world


def chase(robot, servo, world, goals, stated_every, rng):
    """Commands while the ball runs after a link at its speed, and now and then is said to be where it is.

    Yields the ball's place at the beginning of each tick, the velocity with which it moves in it, and the command.
    """
    at, towards, shape = world.pose("ball")[:3, 3], np.zeros(3), world.shape("ball")
    for k, command in enumerate(goals):
        yield at, towards, command
        at = at + towards / RATE
        if k % 50 == 0:
            link = robot.link_names[rng.integers(3, len(robot.link_names))]
            aim = robot.forward_kinematics(servo.q, link=link)[:3, 3] - at + 0.05 * rng.normal(size=3)
            towards = SPEED * aim / max(np.linalg.norm(aim), 1e-9)
        if k % stated_every == stated_every - 1:
            if isinstance(shape, ulna.PointCloud):
                world.update("ball", shape.points + (at - world.pose("ball")[:3, 3]))
            else:
                world.move("ball", placed(at))


def touched_while_moving(robot, servo, run, shape):
    """How often the ball and the moving arm come into contact, at finer times; how often it moves near the ball, and is touched.

    What moves into the arm where it rests touches it: that, and the way out of it, is not counted.
    """
    world, counts, before, led_out = ulna.World(), np.zeros(3, dtype=int), (servo.q, servo.qd), False
    world.add("ball", shape)
    for place, towards, command in run:
        world.move("ball", placed(place))
        distance = robot.signed_distance(before[0], world, self_collision=False)
        led_out = distance <= 0.0 or (led_out and distance <= 0.005)
        moves = before[1].any() or command.qd.any()
        if moves and not led_out and distance < 0.03:
            counts[1] += 1
            for t in np.arange(1, FINER + 1) / FINER / RATE:
                world.move("ball", placed(place + t * towards))
                q = before[0] + t * before[1] + 0.5 * t * t * command.qdd
                counts[0] += robot.in_collision(q, world, self_collision=False)
        counts[2] += distance <= 0.0
        before = command.q, command.qd
    return counts


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "stated_every"), [(BALL, 1), (BALL, 33), (CLOUD, 33)])
def test_nothing_touches_an_object_of_a_stated_speed_while_the_arm_moves(panda, shape, stated_every):
    counts = np.zeros(3, dtype=int)
    for seed in (1, 3, 4):
        servo, world = with_ball((0.8, 0.3, 0.5), shape=shape, robot=panda)
        run = chase(panda, servo, world, hostile(panda, servo, 4000, seed), stated_every, np.random.default_rng(seed))
        counts += touched_while_moving(panda, servo, run, shape)
    contacts, near, touched = counts
    assert contacts == 0
    assert near > 50
    assert touched > 0  # where the arm rests


@pytest.mark.slow
def test_without_the_speed_the_moving_arm_is_touched(panda):
    """So the test above can fail."""
    contacts = 0
    for seed in (1, 2):
        servo, world = with_ball((0.8, 0.3, 0.5), speed=None, robot=panda)
        run = chase(panda, servo, world, hostile(panda, servo, 5000, seed), 33, np.random.default_rng(seed))
        contacts += touched_while_moving(panda, servo, run, BALL)[0]
    assert contacts > 0


def test_what_it_may_do_grows_with_time_until_it_is_said_where_it_is(panda):
    """Objects of which nothing is heard may be anywhere at last, so that the arm comes to rest; it goes on when they are."""
    servo, world = with_ball((0.9, 0.0, 0.5), robot=panda)
    goal = {"velocity": [0.3, 0, 0, 0, 0, 0, 0]}
    for _ in range(4000):
        command = servo.step(**goal)
    assert command.status == "limited by clearance"
    assert command.limiting.pair[1] == "ball"
    assert not command.qd.any()
    for _ in range(200):
        world.move("ball", placed((0.9, 0.0, 0.5)))
        command = servo.step(**goal)
    assert command.qd[0] > 0.2


def test_an_object_that_moves_faster_than_stated_is_named(panda):
    servo, world = with_ball((0.9, 0.0, 0.5), robot=panda)
    goal = {"velocity": [0.3, 0, 0, 0, 0, 0, 0]}
    for _ in range(100):
        servo.step(**goal)
    world.move("ball", placed((0.9 - 0.99 * 0.1 * SPEED, 0.0, 0.5)))
    assert servo.step(**goal).limiting.too_fast is None
    for _ in range(9):
        servo.step(**goal)
    world.move("ball", placed((0.9 - 0.99 * 0.1 * SPEED - 1.01 * 0.01 * SPEED, 0.0, 0.5)))
    command = servo.step(**goal)
    assert command.limiting.too_fast == "ball"
    assert "ball moved faster than stated" in str(command)
    assert servo.step(**goal).limiting.too_fast is None


def test_a_turn_counts_as_motion(panda):
    world = ulna.World()
    world.add("bar", ulna.Box((0.6, 0.02, 0.02)), placed((0.9, 0.0, 0.5)), speed=SPEED)
    servo = panda.servo(world, acceleration=ACCELERATION)
    servo.start(panda.home)
    servo.step(velocity=np.full(7, 0.1))
    world.move("bar", ulna.pose((0.9, 0.0, 0.5), (0, 0, 0.9 * SPEED / RATE / 0.302)))
    assert servo.step(velocity=np.full(7, 0.1)).limiting.too_fast is None
    world.move("bar", ulna.pose((0.9, 0.0, 0.5), (0, 0, 2.1 * SPEED / RATE / 0.3)))
    assert servo.step(velocity=np.full(7, 0.1)).limiting.too_fast == "bar"


def test_a_stop_stays_certified_while_objects_keep_to_their_speed_and_not_else(panda):
    """An object comes as fast as stated until the arm rests: braking goes on as certified. A jump of it is seen at once."""
    certified = {"braking", "at rest"}
    for speed, statuses in ((SPEED, certified), (10 * SPEED, {*certified, "not certified", "in collision"})):
        servo, world = with_ball((0.75, 0.0, 0.5), robot=panda)
        x = 0.75
        while (command := servo.step(twist=[0.3, 0, 0, 0, 0, 0])).status != "limited by clearance":
            x -= SPEED / RATE
            world.move("ball", placed((x, 0, 0.5)))
        found = set()
        while command.qd.any():
            x -= speed / RATE
            world.move("ball", placed((x, 0, 0.5)))
            command = servo.step()
            found.add(str(command.status))
        assert found <= statuses
        assert found


def put_into(robot, q, shape, depth, rng):
    """A world with a thing that the arm is so deep in [m]."""
    thing, towards = ulna.World(), rng.normal(size=3)
    at = robot.forward_kinematics(q, link=robot.link_names[rng.integers(3, len(robot.link_names) - 1)])
    thing.add("thing", shape, at)
    while robot.signed_distance(q, thing, self_collision=False) < -depth:
        at = placed(1e-3 * towards / np.linalg.norm(towards)) @ at
        thing.move("thing", at)
    return thing


@pytest.mark.slow
@pytest.mark.parametrize("shape", [ulna.Box((0.1, 0.12, 0.14)), ulna.Sphere(0.06), ulna.Cylinder(0.05, 0.2)])
@pytest.mark.parametrize("seed", range(4))
def test_out_of_an_object_put_into_the_arm_it_is_led(panda, shape, seed):
    """And into nothing else: what did not touch does not."""
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2.0, 2.0)), ulna.pose((0.75, 0, 0.5)))
    servo = panda.servo(world, acceleration=ACCELERATION)
    servo.start(panda.home)
    thing = put_into(panda, panda.home, shape, 0.02, np.random.default_rng(seed))
    world.add("thing", shape, thing.pose("thing"))
    assert servo.step().status == "in collision"
    assert "mm in thing" in str(servo.step())
    assert not servo.qd.any()  # nothing is desired
    depths, touching = [-np.inf], None
    while depths[-1] < 0.011 and len(depths) < 6000:
        away = panda.distance_gradient(servo.q, thing, self_collision=False)
        command = servo.step(velocity=0.3 * away / max(np.abs(away).max(), 1e-9))
        report = panda.check_collision(command.q, world)
        now = {(pair.name_a, pair.name_b) for pair in report.pairs if pair.signed_distance <= 0}
        assert touching is None or now <= touching
        touching = now
        depths.append(panda.signed_distance(command.q, thing, self_collision=False))
    assert depths[-1] >= 0.011
    assert np.min(np.diff(depths)) > -1e-4
    for _ in range(100):
        command = servo.step()
    assert command.status == "at rest"


def test_a_speed_is_kept_by_copies_and_files(tmp_path):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), speed=0.3)
    world.add("box", ulna.Box((1, 1, 1)))
    ulna.save_world(world, tmp_path / "scene.json")
    for other in (world.copy(), pickle.loads(pickle.dumps(world)), ulna.load_world(tmp_path / "scene.json")):  # noqa: S301
        assert (other.speed("ball"), other.speed("box")) == (0.3, None)
    for wrong in (-1, np.nan, "fast"):
        with pytest.raises(ulna.InputError, match="speed"):
            world.add("other", ulna.Sphere(0.1), speed=wrong)


def test_a_copy_of_a_servo_knows_how_old_its_world_is(panda):
    servo, _ = with_ball((0.9, 0.0, 0.5), robot=panda)
    for _ in range(300):
        servo.step(velocity=[0.3, 0, 0, 0, 0, 0, 0])
    copy = pickle.loads(pickle.dumps(servo))  # noqa: S301 - our own
    for _ in range(1000):
        ours, its = servo.step(velocity=[0.3, 0, 0, 0, 0, 0, 0]), copy.step(velocity=[0.3, 0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(ours.q, its.q, atol=1e-6)


NOT_CERTIFIED = {"not certified", "in collision"}


def into_the_stop(robot, servo):
    """Where a ball touches the arm at the end of its stop."""
    return placed(robot.forward_kinematics(servo.certified_stop[0])[:3, 3])


@pytest.mark.parametrize("ticks", [0, 1])
@pytest.mark.parametrize("again", [False, True])
def test_a_jump_between_a_start_and_the_first_tick_is_too_fast_too(panda, ticks, again):
    """No time has passed, so that any way is too far; said twice, what was said last counts."""
    qd = np.array([1.0, 0, 0, 0, 0, 0, 0])
    servo, world = with_ball((2, 2, 2), robot=panda, acceleration=1.0)
    servo.start(panda.home, qd)
    for _ in range(ticks):
        servo.step(velocity=qd)
    if again:
        world.move("ball", placed((2, 2, 2.0001)))
    world.move("ball", into_the_stop(panda, servo))
    command = servo.step(velocity=qd)
    assert (command.status in NOT_CERTIFIED, command.limiting.too_fast) == (True, "ball")


def test_what_is_said_to_be_where_it_is_after_a_start_is_not_too_fast(panda):
    servo, world = with_ball((0.9, 0.0, 0.5), robot=panda)
    world.move("ball", world.pose("ball"))
    assert servo.step(velocity=np.full(7, 0.1)).limiting.too_fast is None


@pytest.mark.parametrize("way", ["removed and added", "with another speed", "reshaped and moved", "restored"])
def test_a_jump_by_any_way_leaves_no_stop_certified_that_touches(panda, way):
    qd = np.array([1.0, 0, 0, 0, 0, 0, 0])
    servo, world = with_ball((2, 2, 2), robot=panda, acceleration=1.0)
    servo.start(panda.home, qd)
    servo.step(velocity=qd)
    saved, T = servo.saved(), into_the_stop(panda, servo)
    if way in {"removed and added", "with another speed"}:
        world.remove("ball")
        world.add("ball", BALL, T, speed=SPEED if way == "removed and added" else 1e6)
    elif way == "reshaped and moved":
        world.reshape("ball", ulna.Sphere(1.01 * RADIUS))
        world.move("ball", T)
    else:
        servo.step(velocity=qd)
        world.move("ball", T)
        servo.step(velocity=qd)
        servo.restore(saved)
    command = servo.step(velocity=qd)
    assert command.status in NOT_CERTIFIED
    assert command.limiting.too_fast == (None if way == "restored" else "ball")


def test_another_shape_does_not_say_where_an_object_is_and_an_image_does(panda):
    ages = []
    for shape, other in ((BALL, ulna.Sphere(0.07)), (CLOUD, ulna.PointCloud(CLOUD.points, 0.015))):
        servo, world = with_ball((2, 2, 2), shape=shape, robot=panda)
        for _ in range(10):
            servo.step(velocity=np.full(7, 0.1))
        world.reshape("ball", other)
        servo.step()
        ages.append(round(servo.saved().moving[0].age * RATE))
    assert ages == [11, 1]
