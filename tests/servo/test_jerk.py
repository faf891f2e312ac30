"""A servo with a limit of jerk: ticks and full stops keep all limits at all times and touch nothing, and it still arrives."""

import pickle

import numpy as np
import pytest

import ulna
from matrix import matrix
from servo_judge import boxes, hostile, judge_jerk, mixed
from ulna.planning.arm_limits import ARMS

PANDA, FR3 = ARMS["panda"], ARMS["fr3"]
LIMITS = {
    "Panda": (PANDA.velocity, PANDA.acceleration, PANDA.jerk),
    "little jerk": (PANDA.velocity, np.full(7, 10.0), np.full(7, 150.0)),
    "least jerk": (PANDA.velocity, np.full(7, 10.0), np.full(7, 10.0)),
}


def limits_of(robot, limits):
    """Those asked for, of velocity no more than the description's."""
    return np.minimum(limits[0], robot.velocity_limits), limits[1], limits[2]


def started(robot, world=None, limits=LIMITS["Panda"], **options):
    velocity, acceleration, jerk = limits_of(robot, limits)
    servo = robot.servo(world, **{"velocity": velocity, "acceleration": acceleration, "jerk": jerk, **options})
    return servo, servo.start(robot.home)


def run(servo, n, **goal):
    for _ in range(n):
        command = servo.step(**goal)
    return command


def stop_of(servo):
    """The commands of the certified stop from where a servo is, which goes on from there afterwards."""
    saved, commands = servo.saved(), []
    while not commands or commands[-1].status == "braking":
        commands.append(servo.step())
    servo.restore(saved)
    return commands


def keeps(found, beyond=1e-12):
    assert found["contacts"] == 0
    assert max(found["shares"]) <= 1.0
    assert found["beyond"] <= beyond


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("make", [lambda: boxes(10, 1), mixed, lambda: None], ids=["boxes", "mixed", "none"])
def test_hostile_commands_touch_nothing_and_keep_the_limits(panda, name, make):
    world = make()
    servo, start = started(panda, world, LIMITS[name])
    commands = list(hostile(panda, servo, 6000, 2))
    keeps(judge_jerk(panda, world, start, commands, limits_of(panda, LIMITS[name])))
    assert np.abs(np.diff([c.q for c in commands], axis=0)).max(axis=1).sum() > (2.0 if name != "least jerk" else 0.2)


@pytest.mark.parametrize("name", ["Panda", "little jerk"])
def test_so_does_the_full_stop_after_any_tick(panda, name):
    world = boxes(10, 2)
    servo, _ = started(panda, world, LIMITS[name])
    stops = 0
    for k, command in enumerate(hostile(panda, servo, 4000, 4)):
        if k % 61 == 0:
            stop, (rest, speeds) = stop_of(servo), servo.certified_stop
            if len(stop) > 2:
                keeps(judge_jerk(panda, world, command, stop, limits_of(panda, LIMITS[name])))
            np.testing.assert_array_equal(stop[-1].q, rest)
            commands, positions = np.array([c.q for c in stop]), servo.stop_positions
            np.testing.assert_allclose(positions, commands[: len(positions)], rtol=0, atol=1e-14)
            assert len(positions) == len(stop) or (len(positions), len(stop)) == (0, 1)
            assert (np.abs([c.qd for c in stop]) <= speeds + 1e-12).all()
            assert not stop[-1].qd.any()
            assert not stop[-1].qdd.any()
            stops += len(stop) > 20
    assert stops > 10


def test_slow_ticks_do_too(panda):
    for rate in (100, 10):
        servo, start = started(panda, mixed(), rate=rate, clearance=0.005)
        commands = list(hostile(panda, servo, 1000, 5))
        keeps(judge_jerk(panda, mixed(), start, commands, limits_of(panda, LIMITS["Panda"]), rate))


@pytest.mark.parametrize("name", ["ur5", "slide"])
def test_so_do_other_arms(name):
    robot = ulna.load("ur5", tip="tool0", meshes="hulls") if name == "ur5" else on_a_slide()
    world = ulna.World()
    world.add("post", ulna.Cylinder(0.05, 1.2), ulna.pose((0.55, -0.3, 0.6)))
    world.add("ball", ulna.Sphere(0.15), ulna.pose((0.3, 0.5, 0.4)))
    limits = (robot.velocity_limits, np.linspace(4, 12, robot.n_dof), np.linspace(3000, 500, robot.n_dof))
    velocity, acceleration, jerk = limits
    servo = robot.servo(world, velocity=velocity, acceleration=acceleration, jerk=jerk)
    q = robot.random(500, seed=2)
    start = servo.start(q[np.argmax(robot.signed_distance(q, world))])
    commands = list(hostile(robot, servo, 4000, 3))
    keeps(judge_jerk(robot, world, start, commands, limits))
    assert np.abs(np.diff([c.q for c in commands], axis=0)).max(axis=1).sum() > 2.0


def on_a_slide():
    """The Panda on a carriage."""
    text = ulna.load("panda").to_urdf()
    text = text[text.index("<link") : text.index("</robot>")]
    carriage = """<joint name="slide" type="prismatic"><parent link="floor"/><child link="panda_link0"/><axis xyz="0 1 0"/>
        <limit lower="-0.5" upper="0.5" velocity="0.6" effort="1"/></joint>"""
    return ulna.load(f'<robot name="on a slide"><link name="floor"/>{carriage}{text}</robot>')


@pytest.mark.slow
@pytest.mark.parametrize("name", matrix(["Panda", "little jerk"], ["Panda"]))
def test_there_is_a_way_out_of_every_rest(panda, name):
    for world in (boxes(10, 1), mixed()):
        for seed in range(6):
            servo, _ = started(panda, world, LIMITS[name])
            run(servo, 1500, velocity=np.random.default_rng(seed).choice([-1.0, 1.0], 7))
            rest = run(servo, 1000)
            assert rest.status == "at rest"
            before, away = panda.signed_distance(rest.q, world), panda.distance_gradient(rest.q, world)
            command = run(servo, 300 if name == "Panda" else 4000, velocity=0.5 * away / np.abs(away).max())
            assert np.abs(command.q - rest.q).max() > 1e-3 or before > 0.05
            assert panda.signed_distance(command.q, world) > min(before, 0.011)


@pytest.mark.parametrize("name", ["Panda", "little jerk"])
def test_it_reaches_a_configuration_and_a_pose_without_overshoot(panda, name):
    servo, start = started(panda, limits=LIMITS[name])
    goal = start.q + np.array([0.3, 0.2, -0.2, 0.4, 0.1, 0.3, -0.5])
    command = run(servo, 6000, q=goal)
    np.testing.assert_allclose(command.q, goal, atol=1e-7)
    target = panda.forward_kinematics(command.q) @ ulna.pose((0.1, 0.05, -0.1), (0.2, -0.3, 0.5))
    errors = [np.abs(panda.forward_kinematics(servo.step(pose=target).q) - target).max() for _ in range(6000)]
    assert errors[-1] < 1e-6
    assert max(np.diff(errors)) < 1e-5
    command = run(servo, 3000, velocity=np.zeros(7))
    assert command.status == "at rest"
    assert not command.qd.any()


@pytest.mark.slow
def test_it_reaches_what_it_reaches_without_a_limit_of_jerk(panda):
    """Poses among boxes, from home: as many within a millimeter as a servo that knows no jerk, give or take one."""
    world, q, reached = boxes(6, 3), panda.random(400, seed=6), [0, 0]
    q = q[panda.signed_distance(q, world) > 0.03][:16]
    for i, jerk in enumerate((None, PANDA.jerk)):
        for one in q:
            servo, T = panda.servo(world, acceleration=PANDA.acceleration, jerk=jerk), panda.forward_kinematics(one)
            servo.start(panda.home)
            command = run(servo, 5000, pose=T)
            reached[i] += bool(np.abs(panda.forward_kinematics(command.q) - T)[:3, 3].max() < 1e-3)
    assert reached[1] >= reached[0] - 1
    assert reached[0] > 8


def test_limits_are_named(panda):
    servo, _ = started(panda)
    assert servo.step(velocity=[9.0, 0, 0, 0, 0, 0, 0]).status == "limited by jerk"
    command = run(servo, 10, velocity=[9.0, 0, 0, 0, 0, 0, 0])
    assert (command.status, command.limiting.joint) == ("limited by acceleration", "panda_joint1")
    command = run(servo, 3000, velocity=[9.0, 0, 0, 0, 0, 0, 0])
    assert (command.status, command.limiting.joint) == ("limited by position", "panda_joint1")
    assert panda.upper[0] - 1e-5 < command.q[0] <= panda.upper[0] + 1e-12
    np.testing.assert_allclose(servo.limits.jerk, PANDA.jerk, rtol=1e-5)
    assert panda.servo(acceleration=1.0).limits.jerk is None


def test_it_starts_without_acceleration_and_is_refused_where_it_cannot_stop(panda):
    servo, _ = started(panda)
    command = servo.start(panda.home, np.full(7, 0.5))
    assert command.status == "braking"
    assert not command.qdd.any()
    start, stop = command, stop_of(servo)
    keeps(judge_jerk(panda, None, start, stop, limits_of(panda, LIMITS["Panda"])))
    assert len(stop) > 30
    with pytest.raises(ulna.InputError, match="cannot stop"):
        servo.start([panda.upper[0] - 0.05, *panda.home[1:]], [2.0, 0, 0, 0, 0, 0, 0])
    short = panda.servo(acceleration=PANDA.acceleration)  # it can stop in 0.14 rad, with a limit of jerk not quite
    near = [panda.upper[0] - 0.1345, *panda.home[1:]]
    assert short.start(near, [2.0, 0, 0, 0, 0, 0, 0]).status == "braking"
    with pytest.raises(ulna.InputError, match="cannot stop"):
        servo.start(near, [2.0, 0, 0, 0, 0, 0, 0])


@pytest.mark.parametrize("jerk", [0.0, -1.0, np.nan, [1.0, 2.0], 1e10, "fast"])
def test_a_jerk_that_cannot_be_taken_is_named(panda, jerk):
    with pytest.raises(ulna.InputError) as error:
        panda.servo(acceleration=1.0, jerk=jerk)
    assert error.value.argument == "jerk"


def test_a_copy_and_a_restored_state_go_on_alike(panda):
    servo, _ = started(panda, boxes(3, 1), LIMITS["little jerk"])
    run(servo, 100, velocity=np.full(7, 0.3))
    copy, saved = pickle.loads(pickle.dumps(servo)), servo.saved()  # noqa: S301 - our own
    first = [servo.step(twist=np.ones(6)) for _ in range(50)]
    again = [copy.step(twist=np.ones(6)) for _ in range(50)]
    servo.restore(saved)
    for one, two, three in zip(first, again, [servo.step(twist=np.ones(6)) for _ in range(50)], strict=True):
        np.testing.assert_array_equal(one[:3], two[:3])
        np.testing.assert_array_equal(one[:3], three[:3])


def test_a_state_that_is_restored_in_another_world_is_certified_anew(panda):
    world = ulna.World()
    servo, _ = started(panda, world)
    run(servo, 300, velocity=[0.5, 0, 0, 0, 0, 0, 0])
    saved = servo.saved()
    world.add("crate", ulna.Box((0.08, 0.08, 0.08)), panda.forward_kinematics(servo.certified_stop[0]))
    assert servo.step(velocity=[0.5, 0, 0, 0, 0, 0, 0]).status == "in collision"
    servo.restore(saved)
    assert servo.step().status == "in collision"


def test_a_state_that_is_restored_reckons_with_the_objects_of_now(panda):
    world, far = ulna.World(), ulna.pose((0, 0, 3))
    world.add("slow", ulna.Sphere(0.1), far, speed=0.0)
    servo, _ = started(panda, world)
    run(servo, 10)
    saved = servo.saved()
    world.remove("slow")
    world.add("quick", ulna.Sphere(0.1), far, speed=1e4)
    run(servo, 1)
    servo.restore(saved)
    assert not (run(servo, 100, velocity=[0.5, 0, 0, 0, 0, 0, 0]).q - panda.home).any()  # it may be here at once


def test_held_joints_stay_and_several_hands_are_led(panda):
    servo, start = started(panda, held=["panda_joint2"], link=("panda_ee", "panda_link4"))
    T = panda.forward_kinematics(start.q) @ ulna.pose((0.05, 0, -0.05))
    commands = [servo.step(pose={"panda_ee": T}, twist={"panda_link4": np.zeros(6)}) for _ in range(1500)]
    keeps(judge_jerk(panda, None, start, commands, limits_of(panda, LIMITS["Panda"])))
    assert {c.q[1] for c in commands} == {start.q[1]}
    assert np.abs(commands[-1].q - start.q).max() > 0.02


def test_a_measured_arm_off_its_command_is_brought_to_rest_within_the_limits(panda):
    servo, start = started(panda, tracking_error=1e-3)
    commands = [servo.step(velocity=np.full(7, 0.4), measured=servo.q) for _ in range(300)]
    commands += [servo.step(velocity=np.full(7, 0.4), measured=servo.q + 0.01) for _ in range(200)]
    assert commands[-1].status == "off the command"
    assert not commands[-1].qd.any()
    keeps(judge_jerk(panda, None, start, commands, limits_of(panda, LIMITS["Panda"])))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Panda", "little jerk"])
def test_nothing_touches_an_object_of_a_stated_speed_while_the_arm_moves(panda, name):
    """A ball that comes at its speed, said where it is thirty times a second: no contact at any time of a tick in motion."""
    speed, near = 0.3, 0
    for seed in (1, 3):
        world, rng = ulna.World(), np.random.default_rng(seed)
        world.add("ball", ulna.Sphere(0.1), ulna.pose((0.8, 0.3, 0.5)), speed=speed)
        servo, command = started(panda, world, LIMITS[name])
        place = known = np.array([0.8, 0.3, 0.5])
        truth, direction = ulna.World(), rng.normal(size=3)
        truth.add("ball", ulna.Sphere(0.1), ulna.pose(place))
        before = command
        for k, command in enumerate(hostile(panda, servo, 3000, seed)):
            if k % 200 == 0:
                direction = panda.forward_kinematics(command.q)[:3, 3] - place + 0.1 * rng.normal(size=3)
            step = speed / 1000 * direction / np.linalg.norm(direction)
            if before.qd.any() and command.qd.any():
                jerk = (command.qdd - before.qdd) * 1000
                for share in (0.0, 0.5, 1.0):
                    t = share / 1000
                    truth.move("ball", ulna.pose(place + share * step))
                    q = before.q + t * (before.qd + t * (before.qdd / 2 + t * jerk / 6))
                    distance = panda.signed_distance(q, truth, self_collision=False)
                    near += distance < 0.03
                    assert distance > 0.0 or panda.signed_distance(before.q, truth, self_collision=False) <= 0.0
            place, before = place + step, command
            if k % 33 == 32:
                known = place
                world.move("ball", ulna.pose(known))
    assert near > 0


@pytest.mark.parametrize("name", ["Panda", "little jerk"])
def test_it_is_led_out_of_an_object_that_is_put_into_it(panda, name):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.42, 0.0, 0.6)))
    while panda.signed_distance(panda.home, world, self_collision=False) > -0.004:
        world.move("crate", world.pose("crate") @ ulna.pose((-1e-3, 0, 0)))
    velocity, acceleration, jerk = LIMITS[name]
    servo = panda.servo(world, velocity=velocity, acceleration=acceleration, jerk=jerk)
    start = servo.start(panda.home, lead_out=True)
    assert servo.step().status == "in collision"
    away = panda.distance_gradient(panda.home, world, self_collision=False)
    commands = [servo.step(velocity=away) for _ in range(2000 if name == "Panda" else 6000)]
    least = 0.01 if name == "Panda" else 0.003 + panda.signed_distance(panda.home, world, self_collision=False)  # 0.7 mm/s
    assert panda.signed_distance(commands[-1].q, world, self_collision=False) > least
    assert max(judge_jerk(panda, None, start, commands, limits_of(panda, LIMITS[name]))["shares"]) <= 1.0
