"""A solution within the limits is the result, also where only the search for a reason finds it."""

import numpy as np
import pytest

import formulas
import ulna
from robot_files import EXAMPLES
from ulna import Robot

UR5E = [(0, 0.1625, np.pi / 2), (-0.425, 0, 0), (-0.3922, 0, 0), (0, 0.1333, np.pi / 2), (0, 0.0997, -np.pi / 2), (0, 0.0996, 0)]
UR5E_LIMITS = np.radians([(-170, 170), (-120, 120), (-150, 150), (-185, 185), (-119, 119), (-350, 350)])
MISSED = [  # four of the eleven of two million targets
    (1.9751170004746132, -1.6472339785337158, -2.607397182336583, -2.9221579364414003, 0.7249770445643517, -4.567918912212436),
    (2.6537875882986546, -1.8541687391675885, -2.5717055278714676, -2.851223453248401, 1.3554504838030264, -4.550288464343119),
    (2.670150555712656, -1.767662474666182, -2.4559828976017366, -2.884414206605374, 0.8427099414067092, 1.4207120792461065),
    (2.9632528905184614, -1.4069090599240028, -2.518018346588673, -2.949169359568367, 0.547835307534386, 0.839278710143426),
]
SIX = [
    (0.3, 0, 0, 0), (0.5, 0.4, -np.pi / 2, np.pi / 2), (0.1, 0.4, 1, 0), (0.1, 0.1, 1, 0), (0.5, 0.1, 1, np.pi / 2),
    (0, 0.1, 1, 0),
]  # fmt: skip
SIX_LIMITS = [
    (-2.2400787030032365, 2.605299945179908), (-1.9100181543339871, 2.7931708483104343),
    (-1.3291844515883566, 3.1323681555707674),
    (-2.051789337967083, 2.5515119947853595), (-2.9517458482357646, 2.7726422310132866), (-3.231371293079191, 2.2490384767182),
]  # fmt: skip
AT_THE_LIMITS = (-1.6970487312313791, -1.9100181543339871, -1.3291844515883566, -2.051789337967083, -2.9517458482357646)


def ur5e():
    return Robot.from_dh([(*row, 0) for row in UR5E], convention="standard", limits=UR5E_LIMITS)


def assert_solves(robot, result, T, link):
    assert result.status == "solved", str(result)
    assert ((robot.lower <= result.q) & (result.q <= robot.upper)).all()
    error = formulas.pose_error(robot.description, result.q, link, T)
    assert np.linalg.norm(error[:3]) <= 1e-5
    assert np.linalg.norm(error[3:]) <= 1e-4
    assert not result.limit_excess.any()


@pytest.mark.parametrize("q", MISSED)
def test_what_is_found_a_whole_turn_beyond_a_limit_is_turned_back_and_is_the_result(q):
    robot = ur5e()
    T = robot.forward_kinematics(q)
    result = robot.inverse_kinematics(T, trace=True)
    assert_solves(robot, result, T, "link6")
    assert robot.inverse_kinematics(T[None]).q[0].tobytes() == result.q.tobytes()
    assert len(result.trace) == result.iterations + 1
    assert result.trace[-1, 0] == pytest.approx(result.position_error, abs=1e-12)


def test_what_is_found_at_the_limits_without_heed_of_them_is_the_result():
    robot = Robot.from_dh(SIX, limits=SIX_LIMITS)
    T = robot.forward_kinematics((*AT_THE_LIMITS, -2.417922039885789))
    assert_solves(robot, robot.inverse_kinematics(T), T, "link6")


def test_rounding_at_a_held_joint_is_not_reported_as_an_excess(panda):
    seed = [
        0.9056304838558811, 0.9090911450239343, -0.4769003531886038, -0.2292939060427841, 0.639610138609704, 3.3670977727539424,
        -0.9930382770767194,
    ]  # fmt: skip
    q = np.array([-2.8973, seed[1], -2.8973, -0.0698, -2.8973, seed[5], -2.8973])
    T = panda.forward_kinematics(q)
    result = panda.inverse_kinematics(T, seed, held=("panda_joint6", "panda_joint2"))
    assert_solves(panda, result, T, panda.tip)
    assert result.q[[1, 5]].tolist() == [seed[1], seed[5]]


def test_what_is_found_within_the_limits_but_collides_is_called_in_collision():
    q = MISSED[0]
    ball = '<link name="link6"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    text = ur5e().to_urdf()
    assert text.count('<link name="link6"/>') == 1
    robot = ulna.load(text.replace('<link name="link6"/>', ball))
    world = ulna.World()
    world.add("wall", ulna.Box((0.05, 0.05, 0.05)), robot.forward_kinematics(q))
    result = robot.inverse_kinematics(robot.forward_kinematics(q), world=world)
    assert result.status == "in collision", str(result)
    assert result.collisions == (("link6_collision", "wall"),)
    assert not result.limit_excess.any()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_limits_are_blamed_only_with_a_joint_that_passes_them(rng, scale):
    """Arms of narrow limits, and targets within and beyond them."""
    blamed = 0
    for _ in range(8):
        rows = rng.uniform(-1, 1, (6, 4)) * (scale, scale, np.pi, np.pi)
        low = rng.uniform(-2, -0.2, 6)
        robot = Robot.from_dh(rows, limits=np.column_stack([low, low + rng.uniform(0.5, 3, 6)]))
        q = rng.uniform(robot.lower - 0.3, robot.upper + 0.3, (8, 6))
        T = robot.forward_kinematics(q)
        result = robot.inverse_kinematics(T, position_tolerance=1e-5 * scale)
        within = ((robot.lower <= q) & (q <= robot.upper)).all(axis=1)
        assert not (result.status[within] == "unreachable").any()
        blamed += np.count_nonzero(result.status == "joint limits")
        assert (result.limit_excess[result.status == "joint limits"].max(axis=1, initial=0.0) > 0.0).all()
    assert blamed


def test_the_solver_of_a_query_does_not_depend_on_how_many_queries_are_kept(panda):
    """More than a robot keeps, asked for again and again: bits and all."""
    T = panda.forward_kinematics(panda.home + 0.3)
    first = panda.inverse_kinematics(T)
    for seed in range(70):
        panda.inverse_kinematics(T, seed=seed)
    again = panda.inverse_kinematics(T)
    assert again.q.tobytes() == first.q.tobytes()
    assert again.info.tobytes() == first.info.tobytes()


@pytest.mark.parametrize("link", ["leftNub", "rightNub"])
def test_targets_made_with_joints_at_their_limits_are_seldom_missed(link):
    """Two thirds of the joints of a humanoid at a limit: without starts there, 8 of 30,000 were called out of the limits.

    Of the right hand 3.1 were missed on average, with twelve other seeds of the draw 0 to 5, the same at each level of CPU; with
    this seed one more at x86-64-v2 and v3 than at v4, since one target is on the verge of being found.
    """
    robot = ulna.load(EXAMPLES / "alex_description" / "urdf" / "alex_nub_hands.urdf")
    rng = np.random.default_rng(7)
    q, at = rng.uniform(robot.lower, robot.upper, (30_000, robot.n_dof)), rng.integers(0, 3, (30_000, robot.n_dof))
    q = np.where(at == 1, robot.lower, np.where(at == 2, robot.upper, q))
    result = robot.inverse_kinematics(robot.forward_kinematics(q, link=link), link=link)
    assert np.count_nonzero(~result.success) < 8
    assert set(result.status) <= {"solved", "joint limits"}
