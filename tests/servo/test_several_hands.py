"""A servo of several hands: all go where they are sent, share a torso by their weights, and nothing touches."""

import pickle

import numpy as np
import pytest

import ulna
from servo_judge import judge
from two_arms import two_pandas

ACCELERATION = 10.0
HANDS = "left_ee", "right_ee"
GROUPS = '<group name="right arm"><chain base_link="chest" tip_link="right_ee"/></group>'
SRDF = f'<robot name="cell">{GROUPS}</robot>'


def cell(panda, *, waist):
    """Two Pandas on a chest, which turns about a waist or is fixed: 15 joints or 14."""
    robot = ulna.load(two_pandas(panda, waist=waist), srdf=SRDF)
    return robot, np.concatenate([np.zeros(int(waist)), panda.home, panda.home])


@pytest.fixture(scope="module")
def torso(panda):
    return cell(panda, waist=True)


def around(robot, home):
    world = ulna.World()
    for k, (x, y, z) in enumerate([(0.75, 0.0, 0.6), (0.5, 0.6, 0.9), (0.4, -0.65, 0.5), (-0.4, 0.3, 0.9)]):
        world.add(f"box {k}", ulna.Box((0.15, 0.2, 0.25)), ulna.pose((x, y, z), rpy=(0.3 * k, 0.2, 0.1)))
        assert robot.signed_distance(home, world, self_collision=False) > 0.02
    return world


def poses_of(robot, q, links=HANDS):
    return {link: robot.forward_kinematics(q, link=link) for link in links}


def misses(robot, q, goal):
    return [np.abs(robot.forward_kinematics(q, link=link) - T).max() for link, T in goal.items()]


def shifted(robot, home):
    """Both hands elsewhere, each in its own direction."""
    ways = ulna.pose((0.05, 0.1, -0.1), (0.2, 0.1, 0.3)), ulna.pose((-0.05, 0.1, -0.1), (0.2, 0.1, -0.3))
    return {link: T @ way for (link, T), way in zip(poses_of(robot, home).items(), ways, strict=True)}


def run(servo, n, **goal):
    for _ in range(n):
        command = servo.step(**goal)
    return command


@pytest.mark.parametrize("waist", [True, False])
def test_both_hands_reach_their_poses_without_overshoot(panda, waist):
    robot, home = cell(panda, waist=waist)
    servo, goal = robot.servo(acceleration=ACCELERATION, link=HANDS), shifted(robot, home)
    servo.start(home)
    errors = np.array([misses(robot, servo.step(pose=goal).q, goal) for _ in range(1000)])
    assert errors[-1].max() < 1e-6
    assert np.diff(errors, axis=0).max() < 1e-9
    assert servo.step(pose=goal).status == "at rest"


@pytest.mark.parametrize(("name", "links"), [("panda", ("panda_ee", "panda_link4")), ("ur5", ("ee_link", "forearm_link"))])
def test_so_do_two_links_of_one_arm(name, links):
    robot = ulna.load(name, meshes="hulls" if name == "ur5" else None)
    start = robot.home if name == "panda" else np.array([0.0, -1.2, 1.5, -1.8, -1.5, 0.0])
    goal = poses_of(robot, start + 0.2, links)
    servo = robot.servo(acceleration=ACCELERATION, link=links)
    servo.start(start)
    assert max(misses(robot, run(servo, 3000, pose=goal).q, goal)) < 1e-4


@pytest.mark.parametrize("weights", [None, (4.0, 0.25)])
def test_the_velocity_is_the_least_of_the_weighted_squares(torso, weights):
    """The squares of both hands one above the other, by an orthogonal factorisation; what is beside a twist counts 1e4 times.

    The kernel factors H, whose condition is that of the squares squared, so it is right but for that times the rounding unit.
    """
    robot, home = torso
    servo = robot.servo(acceleration=ACCELERATION, link=HANDS, weights=weights)
    servo.start(home)
    twists = dict(zip(HANDS, 0.05 * np.random.default_rng(0).normal(size=(2, 6)), strict=True))
    before = run(servo, 200, twist=twists).q
    command = servo.step(twist=twists)
    rows, right = [1e-2 * np.eye(robot.n_dof)], [np.zeros(robot.n_dof)]
    for link, weight in zip(HANDS, (1.0, 1.0) if weights is None else weights, strict=True):
        J, along = robot.jacobian(before, link=link), twists[link] / np.linalg.norm(twists[link])
        root = np.sqrt(weight) * (1e2 * np.eye(6) - (1e2 - 1) * np.outer(along, along))  # of M
        rows, right = [*rows, root @ J], [*right, root @ twists[link]]
    squares = np.vstack(rows)
    best = np.linalg.lstsq(squares, np.concatenate(right), rcond=None)[0]
    off = np.finfo(float).eps * np.linalg.cond(squares) ** 2 * np.linalg.norm(best)
    assert off < 1e-6
    np.testing.assert_allclose(command.qd, best, atol=off)
    assert command.status == "following"


def test_of_hands_that_cannot_both_be_there_the_heavier_one_is_nearer(torso):
    robot, home = torso
    goal = poses_of(robot, home)
    goal["left_ee"][1, 3] += 1.0
    goal["right_ee"][1, 3] -= 1.0  # the waist turns for one of them
    found = []
    for weights in ((10.0, 1.0), (1.0, 1.0), (1.0, 10.0)):
        servo = robot.servo(acceleration=ACCELERATION, link=HANDS, weights=weights)
        servo.start(home)
        reached = poses_of(robot, run(servo, 3000, pose=goal).q)
        left, right = (np.linalg.norm((reached[link] - goal[link])[:3, 3]) for link in HANDS)
        found.append(left - right)
    assert found[0] < -2e-3
    assert found[2] > 2e-3
    assert abs(found[1]) < 1e-6


def test_a_hand_may_be_given_a_pose_and_the_other_a_twist(torso):
    robot, home = torso
    servo, goal = robot.servo(acceleration=ACCELERATION, link=HANDS), shifted(robot, home)
    servo.start(home)
    command = run(servo, 1000, pose={"left_ee": goal["left_ee"]}, twist={"right_ee": [0, 0, 0.05, 0, 0, 0]})
    assert misses(robot, command.q, {"left_ee": goal["left_ee"]})[0] < 1e-4
    moved = (robot.forward_kinematics(command.q, link="right_ee") - robot.forward_kinematics(home, link="right_ee"))[:3, 3]
    np.testing.assert_allclose(moved, [0, 0, 0.05], atol=2e-3)


def test_a_hand_that_is_not_named_stays_where_it_is_and_one_with_none_is_free(torso):
    robot, home = torso
    servo, left, before = robot.servo(acceleration=ACCELERATION, link=HANDS), [0, 0.1, 0, 0, 0, 0], poses_of(robot, home)
    still = {"right_ee": before["right_ee"]}
    servo.start(home)
    stays = run(servo, 1000, twist={"left_ee": left})
    assert misses(robot, stays.q, still)[0] < 1e-4
    assert abs(stays.q[0]) > 1e-3  # though the waist turns
    servo.start(home)
    free = run(servo, 1000, twist={"left_ee": left, "right_ee": None})
    assert misses(robot, free.q, still)[0] > 5e-3
    np.testing.assert_allclose(free.q[8:], home[8:], atol=1e-9)
    assert not run(servo, 1000, twist=dict.fromkeys(HANDS)).qd.any()


def hostile(robot, servo, n, seed):
    """The commands of n ticks in which either hand is sent to a pose or by a twist, or not at all; goals jump."""
    rng = np.random.default_rng(seed)
    for k in range(n):
        if k % 150 == 0:
            goals = {"pose": {}, "twist": {}}
            far = robot.random(1, seed=int(rng.integers(2**31)))[0]
            poses = poses_of(robot, far)
            for link in HANDS:
                kind = rng.integers(4)
                if kind < 2:
                    goals["pose"][link] = poses[HANDS[kind]]  # perhaps that of the other hand
                elif kind == 2:
                    goals["twist"][link] = rng.normal(size=6) * rng.choice([0.3, 3.0])
        yield servo.step(**goals)


@pytest.mark.parametrize("options", [{}, {"weights": (100.0, 0.01)}, {"held": ["waist"]}])
def test_hostile_hands_touch_nothing_and_keep_the_limits(torso, options):
    robot, home = torso
    world = around(robot, home)
    servo = robot.servo(world, acceleration=ACCELERATION, link=HANDS, **options)
    start = servo.start(home)
    commands = list(hostile(robot, servo, 3000, 1))
    found = judge(robot, world, start, commands, ACCELERATION)
    assert found["contacts"] == 0
    assert max(found["velocity"], found["acceleration"], found["by differences"]) <= 1.0
    assert found["beyond"] <= 1e-12
    assert np.ptp([c.q for c in commands], axis=0)[1:].min() > 0.1  # both arms do move
    assert robot.signed_distance([c.q for c in commands], world, self_collision=False).min() >= 0.009


def test_what_a_hand_holds_touches_nothing_either(torso):
    robot, home = torso
    bar = robot.with_attached("bar", ulna.Box((0.04, 0.3, 0.04)), ulna.pose((0, 0, 0.05)), link="left_ee",
                              touch_links=["left_link6", "left_link7", "left_ee"])  # fmt: skip
    world = around(robot, home)
    servo = bar.servo(world, acceleration=ACCELERATION, link=HANDS, clearance=0.0)
    found = judge(bar, world, servo.start(home), list(hostile(bar, servo, 2000, 2)), ACCELERATION)
    assert found["contacts"] == 0


def test_held_joints_and_those_outside_a_group_stay(torso):
    robot, home = torso
    goal = shifted(robot, home)
    servo = robot.servo(acceleration=ACCELERATION, link=HANDS, held=["waist", "left_joint1"])
    servo.start(home)
    command = run(servo, 2000, pose=goal)
    assert (command.q[:2] == home[:2]).all()
    assert max(misses(robot, command.q, goal)) < 1e-6
    servo = robot.servo(acceleration=ACCELERATION, group="right arm")
    servo.start(home)
    command = run(servo, 2000, pose=goal["right_ee"])
    assert (command.q[:8] == home[:8]).all()
    assert misses(robot, command.q, {"right_ee": goal["right_ee"]})[0] < 1e-6
    far = run(servo, 500, q=robot.upper)
    assert (far.q[:8] == home[:8]).all()


def test_a_copy_goes_on_with_both_hands(torso):
    robot, home = torso
    servo, goal = robot.servo(acceleration=ACCELERATION, link=HANDS, weights=(2.0, 1.0)), shifted(robot, home)
    servo.start(home)
    run(servo, 50, pose=goal)
    copy = pickle.loads(pickle.dumps(servo))  # noqa: S301 - our own
    np.testing.assert_array_equal(run(copy, 50, pose=goal).q, run(servo, 50, pose=goal).q)
    assert not any(
        table.flags.writeable for table in (copy._chains, copy._limits, copy._settings)
    )  # of one type, or the tick is compiled once more


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"link": ()}, "link"),
        ({"link": ("left_ee", "left_ee")}, "link"),
        ({"weights": (1.0, 0.0)}, "weights"),
        ({"weights": (1.0, np.nan)}, "weights"),
        ({"weights": (1.0, 1.0, 1.0)}, "weights"),
        ({"held": 3}, "held"),
    ],
)
def test_what_cannot_be_taken_is_named(torso, options, argument):
    with pytest.raises(ulna.InputError) as error:
        torso[0].servo(**{"acceleration": 1.0, "link": HANDS, **options})
    assert error.value.argument == argument


def test_all_joints_cannot_be_held(panda):
    with pytest.raises(ulna.InputError, match="all joints are held"):
        panda.servo(acceleration=1.0, held=panda.joint_names)


@pytest.mark.parametrize(
    ("goal", "argument"),
    [
        ({"pose": np.eye(4)}, "pose"),
        ({"twist": {"left_ee": [1, 2, 3]}}, "twist['left_ee']"),
        ({"pose": {"right_ee": np.zeros((4, 4))}}, "pose['right_ee']"),
        ({"pose": {"left_ee": np.eye(4)}, "twist": {"left_ee": np.zeros(6)}}, "step"),
        ({"pose": {"left_ee": np.eye(4)}, "velocity": np.zeros(15)}, "step"),
    ],
)
def test_a_goal_that_cannot_be_taken_changes_nothing(torso, goal, argument):
    robot, home = torso
    servo = robot.servo(acceleration=1.0, link=HANDS)
    servo.start(home)
    before = run(servo, 50, velocity=np.full(15, 0.1))
    with pytest.raises(ulna.InputError) as error:
        servo.step(**goal)
    assert error.value.argument == argument
    with pytest.raises(ulna.UnknownNameError, match="left_hand"):
        servo.step(pose={"left_hand": np.eye(4)})
    np.testing.assert_array_equal(servo.q, before.q)
