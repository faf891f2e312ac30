"""The dragged hand: it follows without a leap, keeps off what it must not touch, and says why it stops."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import robots
import ulna
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.contacts import _rate
from ulna.viewer.session.hand import MOST_A_FRAME, Hand, rotation_vector

FRAMES = 200


def pulled(hand, q, T, world=None):
    """Every configuration on the way, and the last frame."""
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
def test_the_hand_arrives_and_no_joint_leaps(panda, hand, xyz):
    T = shifted(panda, panda.home, xyz, rpy=(0.1, 0.2, 0.3))
    way, last = pulled(hand, panda.home, T)
    assert last.reached
    assert last.reason == ""
    assert np.allclose(panda.forward_kinematics(way[-1]), T, atol=2e-5)
    assert np.abs(np.diff(way, axis=0)).max() <= MOST_A_FRAME + 1e-12


@pytest.mark.parametrize(
    ("xyz", "rpy", "said"),
    [((1.0, 0, 0), (0, 0, 0), "unreachable: "), ((-0.5, 0, 0), (0, 0, 0), "beyond max_step: "), ((0, 0, -0.9), (0, 0, 0), "")],
)
def test_out_of_reach_it_rests_as_near_as_it_can_within_the_limits_and_says_why(panda, hand, xyz, rpy, said):
    T = shifted(panda, panda.home, xyz, rpy)
    way, last = pulled(hand, panda.home, T)
    misses = [hand._miss(q, T) for q in way]
    assert not last.reached
    assert not last.moving
    assert last.reason.startswith(said)
    assert last.reason
    assert ((way >= panda.lower) & (way <= panda.upper)).all()
    assert misses[-1] < 0.7 * misses[0]
    assert all(after <= before + 1e-12 for before, after in pairwise(misses))
    assert np.abs(np.diff(way, axis=0)).max() <= MOST_A_FRAME + 1e-12


def test_a_reason_that_is_the_limits_names_the_joint(panda, hand):
    _, last = pulled(hand, panda.home, shifted(panda, panda.home, (0, 0, -0.9)))
    assert last.reason.startswith(("joint limits: ", "beyond max_step: "))
    assert "panda_joint" in last.reason


def test_avoiding_collisions_it_never_touches_and_names_what_is_in_the_way(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.2)))
    T = shifted(panda, panda.home, (0, 0, -0.3))
    way, last = pulled(hand, panda.home, T, world)
    assert not panda.in_collision(way, world).any()
    assert not last.reached
    assert last.stopped
    assert last.reason.startswith("stopped before panda_link7 (box 12) and table")
    through, free = pulled(hand, panda.home, T)
    assert free.reached
    assert panda.in_collision(through[-1], world)


def test_avoiding_collisions_it_slides_along_what_is_in_its_way(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.2)))
    for along in ((0.1, 0.2), (-0.1, -0.3)):
        T = shifted(panda, panda.home, (*along, -0.3))
        way, _ = pulled(hand, panda.home, T, world)
        off = panda.forward_kinematics(way[-1])[:3, 3] - T[:3, 3]
        assert np.abs(off[:2]).max() < 0.01, "as far along the table as it is pulled"
        assert off[2] < 0.09, "and as deep as the table lets it"
        assert panda.signed_distance(way, world).min() > 0


def test_among_any_obstacles_it_never_touches(panda, hand, rng):
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
        way, _ = pulled(hand, q, panda.forward_kinematics(rng.uniform(panda.lower, panda.upper)), world)
        assert not panda.in_collision(way, world).any()


def test_the_rate_of_a_distance_is_its_gradient(panda, rng):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.3, 0.2, 0.4)))
    for q in rng.uniform(panda.lower, panda.upper, (30, 7)):
        pair = panda.check_collision(q, world, max_distance=np.inf).pairs[0]
        assert np.allclose(_rate(panda, q, pair), panda.distance_gradient(q, world), atol=1e-6)


def test_it_finds_its_way_out_of_a_collision(panda, hand):
    world = ulna.World()
    world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0, 0.47)))
    assert panda.in_collision(panda.home, world)
    way, last = pulled(hand, panda.home, shifted(panda, panda.home, (-0.05, 0, 0.25)), world)
    assert last.reached
    assert not panda.in_collision(way[-1], world)


def test_a_moving_base_stands_while_the_hand_is_pulled():
    robot = ulna.Robot(
        robots.of_chain("floating", "revolute", "revolute", "prismatic", origin=ulna.pose((0.3, 0, 0.1), (0.4, 0.3, 0)))
    )
    q = np.full(robot.n_dof, 0.2)
    way, _ = pulled(Hand(robot, robot.tip), q, shifted(robot, q, (0.05, 0.02, 0.0)))
    assert (way[:, :6] == q[:6]).all()
    assert np.abs(way[-1, 6:] - q[6:]).max() > 1e-3


def test_a_limit_of_speed_that_a_file_gives_as_zero_holds_nothing():
    text = ulna.load("panda").to_urdf().replace('velocity="2.1750"', 'velocity="0"').replace('velocity="2.175"', 'velocity="0"')
    robot = ulna.load(text)
    assert (robot.velocity_limits == 0).any()
    home = ulna.load("panda").home
    way, _ = pulled(Hand(robot, robot.tip), home, shifted(robot, home, (1.0, 0, 0)))
    assert np.abs(way[-1] - home).max() > 0.3


def test_the_rotation_vector_is_scipys(rng):
    for R in Rotation.random(50, random_state=rng):
        assert np.allclose(rotation_vector(R.as_matrix()), R.as_rotvec(), atol=1e-9)
    assert np.array_equal(rotation_vector(np.eye(3)), np.zeros(3))
    tiny = Rotation.from_rotvec((1e-9, 0, 0)).as_matrix()
    assert np.allclose(rotation_vector(tiny), (1e-9, 0, 0), rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "link"), [("panda", "panda_ee"), ("ur5", "ee_link"), ("pr2", "r_gripper_palm_link"), ("tiago", "hand_palm_link")]
)
def test_the_palm_is_what_a_person_takes_for_the_hand(name, link):
    assert hand_link(ulna.load(name)) == link
