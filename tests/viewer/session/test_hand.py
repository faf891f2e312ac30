"""The dragged hand: it follows in small steps, stays out of collisions, and reports why it stops."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import robots
import ulna
from ulna.description.pose import rotation_vector_from_matrix
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.hand import MAX_A_FRAME, Hand

FRAMES = 200


def drag_to(hand, q, T, world=None):
    """Follow a target pose: every configuration on the way, shape (n, n_dof), and the last result of ``follow``."""
    way, last = [q], None
    for _ in range(FRAMES):
        last = hand.follow(way[-1], T, world)
        way.append(last.q)
        if not last.moving:
            break
    return np.array(way), last


def shifted(robot, q, xyz, rpy=(0, 0, 0)):
    T = robot.forward_kinematics(q) @ ulna.pose(rpy=rpy)
    T[:3, 3] += xyz
    return T


@pytest.fixture
def hand(panda):
    return Hand(panda, panda.tip)


@pytest.mark.parametrize("xyz", [(0.01, 0, 0), (0.2, 0.3, 0), (-0.1, -0.3, 0.2), (0.1, 0, -0.4)])
def test_the_hand_arrives_in_small_joint_steps(panda, hand, xyz):
    T = shifted(panda, panda.home, xyz, rpy=(0.1, 0.2, 0.3))
    way, last = drag_to(hand, panda.home, T)
    assert last.reached
    assert last.reason == ""
    assert np.allclose(panda.forward_kinematics(way[-1]), T, atol=2e-5)
    assert np.abs(np.diff(way, axis=0)).max() <= MAX_A_FRAME + 1e-12


@pytest.mark.parametrize(
    ("xyz", "rpy", "said"),
    [((1.0, 0, 0), (0, 0, 0), "unreachable: "), ((-0.5, 0, 0), (0, 0, 0), "beyond max_step: "), ((0, 0, -0.9), (0, 0, 0), "")],
)
def test_an_unreachable_target_is_approached_within_the_limits_and_the_reason_is_given(panda, hand, xyz, rpy, said):
    T = shifted(panda, panda.home, xyz, rpy)
    way, last = drag_to(hand, panda.home, T)
    misses = [hand._miss(q, T) for q in way]
    assert not last.reached
    assert not last.moving
    assert last.reason.startswith(said)
    assert last.reason
    assert ((way >= panda.lower) & (way <= panda.upper)).all()
    assert misses[-1] < 0.7 * misses[0]
    assert all(after <= before + 1e-12 for before, after in pairwise(misses))
    assert np.abs(np.diff(way, axis=0)).max() <= MAX_A_FRAME + 1e-12


def test_the_reason_names_the_joint_at_its_limit(panda, hand):
    _, last = drag_to(hand, panda.home, shifted(panda, panda.home, (0, 0, -0.9)))
    assert last.reason.startswith(("joint limits: ", "beyond max_step: "))
    assert "panda_joint" in last.reason


def test_the_hand_stops_before_a_collision_and_the_reason_names_the_obstacle(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.2)))
    T = shifted(panda, panda.home, (0, 0, -0.3))
    way, last = drag_to(hand, panda.home, T, world)
    assert not panda.in_collision(way, world).any()
    assert not last.reached
    assert last.stopped
    assert last.reason.startswith("stopped before panda_link7 (box 12) and table")
    through, free = drag_to(hand, panda.home, T)
    assert free.reached
    assert panda.in_collision(through[-1], world)


def test_the_hand_slides_along_an_obstacle(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.2)))
    for along in ((0.1, 0.2), (-0.1, -0.3)):
        T = shifted(panda, panda.home, (*along, -0.3))
        way, _ = drag_to(hand, panda.home, T, world)
        off = panda.forward_kinematics(way[-1])[:3, 3] - T[:3, 3]
        assert np.abs(off[:2]).max() < 0.01, "as far along the table as the target"
        assert off[2] < 0.09, "and down to the table"
        assert panda.signed_distance(way, world).min() > 0


def test_the_hand_does_not_jump_through_a_thin_wall():
    """The pose behind it is free, and near enough for one frame."""
    cube = '<collision><origin xyz="1 0 0"/><geometry><box size="0.02 0.02 0.02"/></geometry></collision>'
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
    joint = f'<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>{limit}</joint>'
    arm = ulna.load(f'<robot name="arm"><link name="base"/><link name="arm">{cube}</link>{joint}</robot>')
    world, hand, T = ulna.World(), Hand(arm, "arm"), arm.forward_kinematics([0.2])
    world.add("wall", ulna.Box((0.2, 0.002, 0.2)), ulna.pose((np.cos(0.1), np.sin(0.1), 0), (0, 0, 0.1)))
    assert hand.follow(np.zeros(1), T).reached
    way, last = drag_to(hand, np.zeros(1), T, world)
    assert not last.reached
    assert 0.03 < way.max() < 0.1
    assert "wall" in last.reason


@pytest.mark.slow
def test_the_hand_never_collides_among_random_obstacles(panda, hand, rng):
    for _ in range(20):
        world = ulna.World()
        for k in range(4):
            world.add(
                f"{k}",
                ulna.Box(rng.uniform(0.05, 0.4, 3)),
                ulna.pose(rng.uniform((-0.8, -0.8, 0), (0.8, 0.8, 1)), rng.uniform(-3, 3, 3)),
            )
        q = rng.uniform(panda.lower, panda.upper)
        if panda.in_collision(q, world):
            continue
        way, _ = drag_to(hand, q, panda.forward_kinematics(rng.uniform(panda.lower, panda.upper)), world)
        assert not panda.in_collision(way, world).any()


def test_the_hand_moves_out_of_a_collision(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.47)))
    assert panda.in_collision(panda.home, world)
    way, last = drag_to(hand, panda.home, shifted(panda, panda.home, (-0.05, 0, 0.25)), world)
    assert last.reached
    assert not panda.in_collision(way[-1], world)


def test_a_floating_base_stays_fixed_while_the_hand_is_dragged():
    robot = ulna.Robot(
        robots.of_chain("floating", "revolute", "revolute", "prismatic", origin=ulna.pose((0.3, 0, 0.1), (0.4, 0.3, 0)))
    )
    q = np.full(robot.n_dof, 0.2)
    way, _ = drag_to(Hand(robot, robot.tip), q, shifted(robot, q, (0.05, 0.02, 0.0)))
    assert (way[:, :6] == q[:6]).all()
    assert np.abs(way[-1, 6:] - q[6:]).max() > 1e-3


def test_a_velocity_limit_of_zero_in_the_file_does_not_stop_the_hand():
    text = ulna.load("panda").to_urdf().replace('velocity="2.1750"', 'velocity="0"').replace('velocity="2.175"', 'velocity="0"')
    robot = ulna.load(text)
    assert (robot.velocity_limits == 0).any()
    home = ulna.load("panda").home
    way, _ = drag_to(Hand(robot, robot.tip), home, shifted(robot, home, (1.0, 0, 0)))
    assert np.abs(way[-1] - home).max() > 0.3


def test_the_rotation_vector_equals_scipys(rng):
    for R in Rotation.random(50, random_state=rng):
        assert np.allclose(rotation_vector_from_matrix(R.as_matrix()), R.as_rotvec(), atol=1e-9)
    assert np.array_equal(rotation_vector_from_matrix(np.eye(3)), np.zeros(3))
    tiny = Rotation.from_rotvec((1e-9, 0, 0)).as_matrix()
    assert np.allclose(rotation_vector_from_matrix(tiny), (1e-9, 0, 0), rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "link"), [("panda", "panda_ee"), ("ur5", "tool0"), ("pr2", "r_gripper_palm_link"), ("tiago", "hand_palm_link")]
)
def test_the_hand_link_of_known_robots(name, link):
    assert hand_link(ulna.load(name)) == link
