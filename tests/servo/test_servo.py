"""A servo: its commands keep all limits, touch nothing, go where they are sent, and lead out of every place."""

import gc
import pickle
import tracemalloc
from itertools import product

import numpy as np
import pytest

import ulna
from servo_judge import boxes, hostile, judge, mixed
from ulna.servo.entries import tick as driver

ACCELERATION = 10.0
WORLDS = {"boxes": lambda: boxes(10, 1), "other boxes": lambda: boxes(10, 2), "mixed": mixed, "none": lambda: None}


@pytest.fixture(scope="module")
def worlds():
    return {name: make() for name, make in WORLDS.items()}


def started(robot, world=None, **options):
    servo = robot.servo(world, **{"acceleration": ACCELERATION, **options})
    return servo, servo.start(robot.home)


def run(servo, n, **goal):
    for _ in range(n):
        command = servo.step(**goal)
    return command


@pytest.mark.slow
@pytest.mark.parametrize("name", WORLDS)
@pytest.mark.parametrize("seed", range(2))
def test_hostile_commands_touch_nothing_and_keep_the_limits(panda, worlds, name, seed):
    world = worlds[name]
    servo, start = started(panda, world)
    commands = list(hostile(panda, servo, 10_000, seed))
    found = judge(panda, world, start, commands, ACCELERATION)
    assert found["contacts"] == 0
    assert max(found["velocity"], found["acceleration"], found["by differences"]) <= 1.0
    assert found["beyond"] <= 1e-12
    assert sum(np.abs(np.diff([c.q for c in commands], axis=0)).max(axis=1)) > 5.0  # it does move
    if world is not None:
        assert panda.signed_distance([c.q for c in commands], world, self_collision=False).min() >= 0.009


@pytest.mark.parametrize("name", ["boxes", "mixed"])
@pytest.mark.parametrize("rate", [100, 10])
def test_so_do_slow_ticks(panda, worlds, name, rate):
    servo, start = started(panda, worlds[name], rate=rate, clearance=0.005)
    commands = list(hostile(panda, servo, 2_000, 5))
    found = judge(panda, worlds[name], start, commands, ACCELERATION, rate)
    assert found["contacts"] == 0
    assert max(found["velocity"], found["acceleration"], found["by differences"]) <= 1.0
    assert found["beyond"] <= 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", ["boxes", "other boxes", "mixed"])
def test_there_is_a_way_out_of_every_rest(panda, worlds, name):
    """Pressed against something from many sides, it moves away again as soon as it is sent away."""
    world, stuck = worlds[name], 0
    for seed in range(12):
        servo, _ = started(panda, world)
        run(servo, 1500, velocity=np.random.default_rng(seed).choice([-1.0, 1.0], 7))
        rest = run(servo, 600)
        assert rest.status == "at rest"
        before = panda.signed_distance(rest.q, world)
        away = panda.distance_gradient(rest.q, world)
        command = run(servo, 60, velocity=0.5 * away / np.abs(away).max())
        stuck += np.abs(command.q - rest.q).max() < 1e-3 and before < 0.05
        assert panda.signed_distance(command.q, world) > min(before, 0.011)
    assert stuck == 0


def test_it_reaches_a_configuration(panda):
    (servo, _), reached = started(panda), 0
    for seed in range(8):
        goal = panda.random(1, seed=seed)[0]
        if panda.edge_in_collision(servo.q, goal):
            continue
        reached += 1
        command = run(servo, 4000, q=goal)
        np.testing.assert_allclose(command.q, goal, atol=1e-8)
        assert command.status == "at rest"
        assert not command.qd.any()
    assert reached >= 3


def test_what_was_certified_in_one_world_is_not_in_another(panda):
    for between in ("warm_up", "a refused start"):
        world = ulna.World()
        servo, start = started(panda, world)
        assert run(servo, 50, velocity=[0.5, 0, 0, 0, 0, 0, 0]).status != "not certified"
        world.add("crate", ulna.Box((0.3, 0.3, 0.3)), panda.forward_kinematics(start.q))
        if between == "warm_up":
            servo.warm_up()
        else:
            with pytest.raises(ulna.InputError, match="not certainly free"):
                servo.start(start.q)
        assert servo.step().status == "in collision", between


def test_it_reaches_a_pose_without_overshoot(panda):
    servo, start = started(panda, posture=panda.home)
    target = panda.forward_kinematics(start.q) @ ulna.pose((0.1, 0.05, -0.1), (0.2, -0.3, 0.5))
    errors = [np.abs(panda.forward_kinematics(servo.step(pose=target).q) - target).max() for _ in range(3000)]
    assert errors[-1] < 1e-6
    assert max(np.diff(errors)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_it_comes_to_rest_as_near_as_it_can_to_a_pose_out_of_reach(panda, seed):
    """Near the singularity of a stretched arm a step of the pseudoinverse leads to and fro. At rest no joint leads nearer."""
    rng, servo = np.random.default_rng(seed), panda.servo(acceleration=10.0)
    direction = np.abs(rng.normal(size=3))
    T = ulna.pose(1.5 * direction / np.linalg.norm(direction), rpy=rng.uniform(-3, 3, 3))
    servo.start(panda.home)
    run(servo, 30_000, pose=T)
    command = run(servo, 500, pose=T)
    assert np.abs(command.qd).max() < 1e-3

    def squares(q):
        end = panda.forward_kinematics(q)
        angle = np.arccos((np.trace(end[:3, :3].T @ T[:3, :3]) - 1) / 2)
        return ((end[:3, 3] - T[:3, 3]) ** 2).sum() + angle**2

    at = squares(command.q)
    for j, step in product(range(7), (1e-3, -1e-3)):
        q = command.q + step * np.eye(7)[j]
        assert squares(q) > at - 1e-5 or not panda.lower[j] < q[j] < panda.upper[j]


def test_a_twist_moves_the_hand_along_it(panda):
    servo, _ = started(panda)
    before = panda.forward_kinematics(run(servo, 300, twist=[0.1, 0, 0, 0, 0, 0]).q)
    command = run(servo, 1000, twist=[0.1, 0, 0, 0, 0, 0])
    after = panda.forward_kinematics(command.q)
    np.testing.assert_allclose((after - before)[:3, 3], [0.1, 0, 0], atol=1e-3)
    assert command.status == "following"
    assert str(command) == "following"


def test_it_slides_along_a_wall(panda):
    """The hand is sent into a wall, and along it: it does not come nearer than the clearance, and it does go along."""
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2.0, 2.0)), ulna.pose((0.55, 0, 0.5)))
    servo, _ = started(panda, world)
    command = run(servo, 3000, twist=[0.1, 0.05, 0, 0, 0, 0])
    moved = (panda.forward_kinematics(command.q) - panda.forward_kinematics(panda.home))[:3, 3]
    assert moved[1] > 0.1
    assert 0.01 <= panda.signed_distance(command.q, world, self_collision=False) < 0.016
    assert command.status == "limited by clearance"
    assert command.limiting.pair[1] == "wall"
    assert "mm from wall" in str(command)


def test_a_limit_is_named(panda):
    servo, _ = started(panda)
    assert servo.step(velocity=[9.0, 0, 0, 0, 0, 0, 0]).status == "limited by acceleration"
    assert servo.step(velocity=[9.0, 0, 0, 0, 0, 0, 0]).limiting.joint == "panda_joint1"
    command = run(servo, 8000, velocity=[0.5, 0, 0, 0, 0, 0, 0])
    assert (command.status, command.limiting.joint) == ("limited by position", "panda_joint1")
    assert command.q[0] == pytest.approx(panda.upper[0], abs=1e-6)


def test_an_object_that_appears_is_seen_in_the_next_tick(panda):
    world = ulna.World()
    servo, _ = started(panda, world)
    run(servo, 500, velocity=[0.5, 0, 0, 0, 0, 0, 0])
    hand = panda.forward_kinematics(servo.q)
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), hand)
    command = servo.step(velocity=[0.5, 0, 0, 0, 0, 0, 0])
    assert command.status == "in collision"
    assert run(servo, 300).qd.any() == 0
    world.remove("crate")
    assert run(servo, 300, velocity=[-0.5, 0, 0, 0, 0, 0, 0]).qd[0] == pytest.approx(-0.5)


def test_out_of_the_clearance_of_an_object_that_appears_it_moves_away(panda):
    world, x = ulna.World(), 0.7
    servo, _ = started(panda, world)
    world.add("ball", ulna.Sphere(0.05), ulna.pose((x, 0, 0.5)))
    while panda.signed_distance(panda.home, world, self_collision=False) > 0.006:
        x -= 0.001
        world.move("ball", ulna.pose((x, 0, 0.5)))
    assert panda.signed_distance(panda.home, world, self_collision=False) > 0.0
    away = panda.distance_gradient(panda.home, world, self_collision=False)
    assert servo.step(velocity=away).status == "not certified"
    command = run(servo, 1000, velocity=away)
    assert panda.signed_distance(command.q, world, self_collision=False) > 0.01
    assert command.status != "not certified"


def test_it_starts_within_the_clearance_or_in_a_contact_if_it_is_to_lead_out(panda):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.42, 0.0, 0.6)))
    while panda.signed_distance(panda.home, world, self_collision=False) > -0.004:
        world.move("crate", world.pose("crate") @ ulna.pose((-1e-3, 0, 0)))
    servo = panda.servo(world, acceleration=ACCELERATION)
    with pytest.raises(ulna.InputError, match="not certainly free"):
        servo.start(panda.home)
    assert servo.start(panda.home, lead_out=True).status == "not certified"
    assert servo.step().status == "in collision"
    away = panda.distance_gradient(panda.home, world, self_collision=False)
    command = run(servo, 2000, velocity=away)
    assert panda.signed_distance(command.q, world, self_collision=False) > 0.01


@pytest.mark.parametrize(("error", "beside", "touches"), [(0.0, 5e-3, True), (2.5e-3, 5e-3, False), (2.5e-3, 2.5e-3, False)])
def test_the_certificate_holds_beside_the_command(panda, error, beside, touches):
    """All configurations within the tracking error of a command are free, and without one some are not."""
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2.0, 2.0)), ulna.pose((0.65, 0, 0.5)))
    servo, _ = started(panda, world, tracking_error=error, clearance=0.0)
    command = run(servo, 4000, twist=[0.1, 0, 0, 0, 0, 0])
    corners = np.stack(np.meshgrid(*[[-beside, beside]] * 7), axis=-1).reshape(-1, 7)
    assert panda.in_collision(command.q + corners, world).any() == touches


def test_an_arm_within_its_tracking_error_touches_nothing_and_goes_on(panda, worlds):
    """Lag and noise of a real arm, as it is measured: it is off the command, but by no more than stated."""
    error, rng, goal = 0.001, np.random.default_rng(0), np.zeros(7)
    servo, start = started(panda, worlds["boxes"], tracking_error=error, clearance=0.0)
    real, count = start.q, 0
    for k in range(4000):
        goal = rng.uniform(-1, 1, 7) if k % 300 == 0 else goal
        command = servo.step(velocity=goal, measured=real)
        assert command.status != "off the command"
        real = np.clip(real + 0.05 * (command.q - real) + 1e-4 * rng.normal(size=7), command.q - error, command.q + error)
        assert not panda.in_collision(real, worlds["boxes"])
        count += np.abs(real - command.q).max() > 0.9 * error
    assert count > 100


def test_an_arm_off_its_command_comes_to_rest_until_it_is_on_it(panda):
    servo, _ = started(panda, tracking_error=[0.001] * 3 + [0.002] * 4)
    goal = {"velocity": np.full(7, 0.2)}
    before = run(servo, 200, **goal)
    assert servo.step(**goal, measured=before.q + 0.00099).status == "following"
    off = servo.q + np.array([0, 0.0011, 0, 0.00199, 0, 0, 0])
    command = servo.step(**goal, measured=off)
    assert (command.status, command.limiting.joint) == ("off the command", "panda_joint2")
    assert str(command) == "off the command: panda_joint2"
    for _ in range(100):
        command = servo.step(**goal, measured=off)
    assert not command.qd.any()
    assert command.status == "off the command"
    assert servo.step(**goal, measured=servo.q).qd.any()
    servo.start(off)
    assert run(servo, 200, **goal, measured=off).status == "off the command"
    assert run(servo, 200, **goal).status == "following"
    with pytest.raises(ulna.InputError, match="measured"):
        servo.step(measured=[1, 2])


def test_ticks_and_the_longest_are_counted(panda):
    servo, _ = started(panda)
    assert (servo.ticks, servo.worst) == (0, 0.0)
    run(servo, 20, velocity=np.zeros(7))
    assert servo.ticks == 20
    assert 0.0 < servo.worst < 60.0
    servo.start(panda.home)
    assert (servo.ticks, servo.worst) == (0, 0.0)


@pytest.mark.compiler
def test_after_warm_up_nothing_is_compiled_and_no_memory_is_kept(panda):
    """In ticks of each kind, near objects, in collision and off the command too."""
    from numba.core import event
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()
    world = mixed()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((2, 0, 0)), speed=0.1)
    servo = panda.servo(world, acceleration=ACCELERATION, tracking_error=1e-3)
    servo.warm_up()
    far = ulna.pose((2, 0, 0))

    def ticks(n):
        servo.start(panda.home)
        for _ in hostile(panda, servo, n, 3):
            pass
        world.move("crate", panda.forward_kinematics(servo.q))
        run(servo, 50, velocity=np.ones(7))
        world.move("crate", far)
        run(servo, 50, twist=np.ones(6), measured=servo.q + 1)

    def in_use():
        stats = rtsys.get_allocation_stats()
        return stats.alloc - stats.free, tracemalloc.get_traced_memory()[0]

    with event.install_recorder("numba:compile") as recorder:
        tracemalloc.start()
        ticks(300)
        found = []
        for _ in range(3):
            gc.collect()
            found.append(in_use())
            ticks(300)
        tracemalloc.stop()
    assert not recorder.buffer
    assert found[1][0] == found[2][0]
    assert abs(found[2][1] - found[1][1]) < 2000  # bytes, of 400 ticks


def test_it_starts_in_motion_where_it_can_stop(panda):
    servo = panda.servo(acceleration=ACCELERATION)
    command = servo.start(panda.home, np.full(7, 0.5))
    assert command.status == "braking"
    rest = run(servo, 51)
    np.testing.assert_allclose(rest.q, panda.home + 0.5 * 0.051 / 2, atol=1e-3)
    assert rest.status == "at rest"
    with pytest.raises(ulna.InputError, match="cannot stop"):
        servo.start([panda.upper[0] - 1e-3, *panda.home[1:]], [2.0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(servo.q, rest.q)


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"acceleration": 0}, "acceleration"),
        ({"acceleration": np.nan}, "acceleration"),
        ({"rate": 0}, "rate"),
        ({"acceleration": [1, 1, 1, 0, 1, 1, 1]}, "acceleration"),
        ({"rate": np.nan}, "rate"),
        ({"rate": -1}, "rate"),
        ({"rate": 1e9}, "rate"),
        ({"rate": 5e-324}, "rate"),
        ({"link": 5}, "link"),
        ({"velocity": 0}, "velocity"),
        ({"velocity": np.nan}, "velocity"),
        ({"clearance": -1}, "clearance"),
        ({"clearance": np.nan}, "clearance"),
        ({"clearance": True}, "clearance"),
        ({"tracking_error": -1}, "tracking_error"),
        ({"tracking_error": np.nan}, "tracking_error"),
        ({"posture": np.full(7, np.nan)}, "posture[0]"),
        ({"weights": 0}, "weights"),
        ({"posture": [1, 2]}, "posture"),
    ],
)
def test_what_cannot_be_taken_is_named(panda, options, argument):
    with pytest.raises(ulna.InputError) as error:
        panda.servo(**{"acceleration": 1.0, **options})
    assert error.value.argument == argument


@pytest.mark.parametrize(
    ("goal", "argument"),
    [
        ({"q": np.full(7, np.nan)}, "q[0]"),
        ({"velocity": [1, 2]}, "velocity"),
        ({"twist": [1, 2, 3]}, "twist"),
        ({"twist": [np.inf, 0, 0, 0, 0, 0]}, "twist[0]"),
        ({"velocity": np.full(7, np.inf)}, "velocity[0]"),
        ({"pose": np.zeros((4, 4))}, "pose"),
        ({"pose": np.full((4, 4), np.nan)}, "pose"),
        ({"measured": np.full(7, np.nan)}, "measured[0]"),
        ({"q": np.zeros(7), "velocity": np.zeros(7)}, "step"),
        ({"twist": np.zeros(6), "expressed_in": "tool"}, "expressed_in"),
    ],
)
def test_a_goal_that_cannot_be_taken_changes_nothing(panda, goal, argument):
    servo, _ = started(panda)
    before = run(servo, 50, velocity=np.full(7, 0.1))
    with pytest.raises(ulna.InputError) as error:
        servo.step(**goal)
    assert error.value.argument == argument
    np.testing.assert_array_equal(servo.q, before.q)
    assert servo.step().status == "braking"


def test_it_has_to_be_started_where_it_is_free(panda):
    world = ulna.World()
    servo = panda.servo(world, acceleration=1.0)
    with pytest.raises(ulna.InputError, match="start"):
        servo.step()
    with pytest.raises(
        ulna.InputError, match=r"q: beyond the joint limits: panda_joint1 by 0\.1, .*panda_joint7 by 0\.1; .*escape=True"
    ):
        servo.start(panda.upper + 0.1)
    beyond = panda.home.copy()
    beyond[3] = panda.lower[3] - 0.02
    with pytest.raises(ulna.InputError, match=r"q: beyond the joint limits: panda_joint4 by 0\.02; robot\.plan"):
        servo.start(beyond)
    with pytest.raises(ulna.InputError, match=r"q\[0\]"):
        servo.start(np.full(7, np.nan))
    with pytest.raises(ulna.InputError, match="faster than the limits"):
        servo.start(panda.home, 1.1 * panda.velocity_limits)
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), panda.forward_kinematics(panda.home))
    with pytest.raises(ulna.InputError, match="free"):
        servo.start(panda.home)


def test_a_copy_goes_on_from_the_same_state(panda):
    servo, _ = started(panda, boxes(3, 1))
    run(servo, 100, velocity=np.full(7, 0.3))
    copy = pickle.loads(pickle.dumps(servo))  # noqa: S301 - our own
    np.testing.assert_array_equal(copy.step(twist=np.ones(6)).q, servo.step(twist=np.ones(6)).q)
    scenes = (each._checker.scene_of(each._world, self_collision=True) for each in (servo, copy))
    for ours, its in zip(*scenes, strict=True):  # of one type, or the tick is compiled once more
        if isinstance(ours, np.ndarray):
            assert (ours.dtype, ours.ndim, ours.flags.writeable) == (its.dtype, its.ndim, its.flags.writeable)


@pytest.mark.parametrize("tool", [ulna.Cylinder(0.03, 0.2), ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.2)])])
def test_what_is_attached_touches_nothing_either(panda, worlds, tool):
    robot = panda.with_attached("tool", tool, np.eye(4), touch_links=panda.link_names[-3:])
    servo, start = started(robot, worlds["boxes"], clearance=0.0)
    found = judge(robot, worlds["boxes"], start, list(hostile(robot, servo, 3000, 4)), ACCELERATION)
    assert found["contacts"] == 0


def test_the_positions_of_the_stop_are_the_commands_of_it(panda):
    servo = panda.servo(acceleration=ACCELERATION)
    servo.start(panda.home, np.full(7, 0.1))
    assert len(servo.stop_positions) > 5
    for _ in range(3):
        servo.step()
    positions = servo.stop_positions
    np.testing.assert_array_equal(positions, [servo.step().q for _ in positions])
    assert servo.stop_positions.shape == (0, 7)


def test_the_rate_is_that_of_the_differences(panda):
    servo, _ = started(panda, rate=250)
    command = run(servo, 250, velocity=[0.2, 0, 0, 0, 0, 0, 0])
    assert servo.step(velocity=[0.2, 0, 0, 0, 0, 0, 0]).q[0] - command.q[0] == pytest.approx(0.2 / 250)


def test_a_joint_whose_description_allows_no_velocity_is_named():
    solid = '<link name="base"/><link name="cube"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
    limit = '<limit lower="-1" upper="1" velocity="0" effort="1"/>'
    slide = f'<joint name="lift" type="prismatic"><parent link="base"/><child link="cube"/><axis xyz="0 0 1"/>{limit}</joint>'
    with pytest.raises(ulna.InputError, match="robot: its description allows lift a velocity of 0"):
        ulna.load(f'<robot name="lift">{solid}{slide}</robot>').servo(acceleration=1.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_hull_comes_as_near_as_any_shape(seed):
    """A search for a lower bound that ends early may find a bound far below the distance: the arm would rest far away."""
    rng, least = np.random.default_rng(seed), 0.012
    limit = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    slide = f'<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>{limit}</joint>'
    ball = '<link name="base"/><link name="cart"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    robot = ulna.load(f'<robot name="slider">{ball}{slide}</robot>')
    robot = robot.with_attached("hull", ulna.ConvexMesh(0.2 * rng.normal(size=(12, 3))), np.eye(4), link="cart")
    world = ulna.World()
    world.add("wall", ulna.Box((0.3, 1.0, 1.0)), ulna.pose((1.2, 0.1, 0.0), rng.uniform(-3, 3, 3)))
    servo = robot.servo(world, acceleration=ACCELERATION)
    servo.start([-1.0])
    command = run(servo, 4000, velocity=[0.6])
    assert least - 1e-6 <= robot.signed_distance(command.q, world) < least + 1e-3


def test_a_tick_tries_few_shares_and_the_next_one_the_others():
    """Whichever share is the only free one, it is found within three ticks; and a greater one is tried after each success."""
    for only in range(len(driver.SHARES)):
        for begin in range(len(driver.SHARES) - driver.MAX_TRIES + 1):
            first, ticks = begin, 1
            while only not in range(first, first + driver.MAX_TRIES):
                first, ticks = driver.next_share(first, -1), ticks + 1
            assert ticks <= 3
            first = driver.next_share(first, only)
            assert max(only - 1, 0) in range(first, first + driver.MAX_TRIES)
            assert only in range(first, first + driver.MAX_TRIES)


def test_a_velocity_of_0_in_a_file_means_not_known_where_one_is_given():
    """Exporters write velocity="0"; a motion takes velocity= then, and so does a servo."""
    joint = (
        '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="0"/></joint>'
    )
    links = "".join(
        f'<link name="{name}"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>' for name in "abc"
    )
    robot = ulna.load(f'<robot name="r">{links}{joint.format("j", "a", "b")}{joint.format("k", "b", "c")}</robot>')
    with pytest.raises(ulna.InputError, match=r"a velocity of 0, so a servo would never move; velocity= gives one"):
        robot.servo(acceleration=1.0)
    servo = robot.servo(acceleration=1.0, velocity=0.5, rate=1000)
    servo.start(np.zeros(2))
    speeds = [np.abs(servo.step(velocity=[0.4, 0.4]).qd).max() for _ in range(600)]
    assert 0.39 < max(speeds) <= 0.5


def test_goals_in_a_frame_are_those_in_the_base_that_they_mean(panda):
    """The same commands, to a bit of rounding, as with the goal turned into the base by hand."""
    T_base_table, at = ulna.pose((0.2, -0.1, 0.3), (0.1, 0.2, 1.5)), panda.forward_kinematics(panda.home)
    R = T_base_table[:3, :3]
    goal, twist = at @ ulna.pose((0.05, 0.02, -0.04)), np.array([0.05, 0.02, -0.03, 0.1, 0, 0.2])
    in_table = {"pose": np.linalg.inv(T_base_table) @ goal}, {"twist": np.r_[R.T @ twist[:3], R.T @ twist[3:]]}
    for stated, meant in zip(in_table, ({"pose": goal}, {"twist": twist}), strict=True):
        ours, theirs = panda.servo(acceleration=5.0), panda.servo(acceleration=5.0)
        ours.start(panda.home)
        theirs.start(panda.home)
        for _ in range(50):
            command, expected = ours.step(**stated, frame=T_base_table), theirs.step(**meant)
        np.testing.assert_allclose(command.q, expected.q, atol=1e-9)
        assert np.abs(command.q - panda.home).max() > 1e-4
    with pytest.raises(ulna.InputError, match="moves in the base"):
        ours.step(pose=goal, frame="panda_link3")
    for wrong in ({"twist": twist, "expressed_in": "link"}, {"q": panda.home}):
        with pytest.raises(ulna.InputError, match="frame: goes with poses"):
            ours.step(**wrong, frame=T_base_table)
