"""The state behind the page: its update in each frame, the collision result, the nearest pair, the ellipsoid."""

import numpy as np
import pytest

import robots
import ulna
from ulna.errors import InputError, UnknownNameError
from ulna.viewer.session.clearance import ShapeNames, clearance
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.session import Session


@pytest.fixture
def world():
    world = ulna.World()
    world.add("crate", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.5, 0, 0.21)))
    return world


def test_a_frame_returns_whether_anything_has_changed(panda, world):
    session = Session(panda, world)
    assert session.frame()
    assert not session.frame()
    world.move("crate", ulna.pose((0.3, 0, 0.5)))  # by anyone
    assert session.frame()
    assert session.clearance.state == "collision"
    session.q = panda.home + 0.1
    assert session.frame()
    assert not session.frame()


def test_a_pulled_hand_arrives_over_several_frames_and_stays_after_release(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (0.3, 0.3, 0)
    session.pull(T)
    frames = 0
    while session.frame() and frames < 100:
        frames += 1
    assert frames > 2
    assert np.allclose(session.hand_pose, T, atol=2e-5)
    session.release()
    session.frame()
    assert session.target is None
    assert not session.moving


def test_a_hand_released_on_the_way_still_reaches_its_target(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (0.3, 0.3, 0)
    session.pull(T)
    session.release()
    session.frame()
    assert session.moving
    while session.moving:
        session.frame()
    assert np.allclose(session.hand_pose, T, atol=2e-5)


def test_the_reason_is_cleared_when_the_hand_is_released(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (2.0, 0, 0)
    session.pull(T)
    while session.frame() and session.moving:
        pass
    assert session.trouble.startswith("unreachable")
    session.release()
    session.frame()
    assert (session.target, session.trouble) == (None, "")


def test_shapes_are_named_by_their_links_so_that_no_obstacle_shares_a_name(panda):
    names = ShapeNames(panda)
    assert [names.shape_name(name) for name in ("box 1", "box 6")] == ["panda_link1 (box 1)", "panda_link3"]
    world = ulna.World()
    world.add("box 1", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.3, 0, 0.5)))
    assert str(clearance(panda, panda.home, world)) == "collision: panda_link7 (box 12) and obstacle box 1"
    slider = ulna.load("panda").with_attached("bar", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0, 0, 0.1)))
    assert "bar" in ShapeNames(slider).reserved


def test_the_only_shape_of_a_link_has_the_name_of_the_link():
    names = ShapeNames(ulna.load("ur5").with_convex_hulls())
    assert names.shape_name("forearm_link_collision") == "forearm_link"


def test_a_bad_argument_is_refused_by_name(panda):
    session = Session(panda)
    with pytest.raises(InputError, match="q: shape"):
        session.q = np.zeros((2, 7))
    with pytest.raises(InputError, match="not a finite number"):
        session.q = np.full(7, np.nan)
    with pytest.raises(UnknownNameError, match="did you mean 'panda_link8'"):
        session.link = "panda_link88"
    with pytest.raises(InputError, match="world: "):
        Session(panda, "crate")
    with pytest.raises(InputError, match=r"robot: str; an ulna.Robot is expected: ulna.load"):
        Session("panda")
    with pytest.raises(InputError, match="beyond"):
        Session(panda, q=np.full(7, 2e6))


def test_a_session_starts_at_home_or_at_the_given_q(panda):
    assert np.array_equal(Session(panda).q, panda.home)
    assert np.array_equal(Session(panda, q=panda.home + 0.1).q, panda.home + 0.1)


def test_the_nearest_pair_has_the_signed_distance_of_the_robot(panda, world, rng):
    for q in rng.uniform(panda.lower, panda.upper, (50, 7)):
        found = clearance(panda, q, world)
        assert found.nearest.signed_distance == pytest.approx(panda.signed_distance(q, world, self_collision=False), abs=1e-9)
        assert found.nearest.name_b == "crate"
        assert found.report.in_collision == panda.in_collision(q, world)
        assert str(found).startswith(found.state)


def test_the_distance_is_shown_in_millimeters(panda):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((2.0, 0, 0.5)))
    found = clearance(panda, panda.home, world)
    assert found.distance == f"{1000 * panda.signed_distance(panda.home, world, self_collision=False):.1f} mm"
    assert found.state == "free"


def test_a_robot_with_meshes_is_not_checked_rather_than_free():
    session = Session(ulna.load("ur5"))
    session.frame()
    assert session.clearance.state == "not checked"
    assert "Mesh" in session.unchecked


def test_the_ellipsoid_is_the_smallest_that_contains_all_velocities_of_unit_joint_rates(panda, rng):
    q = rng.uniform(panda.lower, panda.upper)
    found = mobility(panda, q, panda.tip)
    rates = rng.normal(size=(4000, 7))
    rates /= np.linalg.norm(rates, axis=1, keepdims=True)
    speeds = rates @ panda.jacobian(q)[:3].T @ found.T[:3, :3] / found.radii
    lengths = np.linalg.norm(speeds, axis=1)
    assert lengths.max() <= 1 + 1e-9
    assert lengths.max() > 0.95
    assert np.linalg.det(found.T[:3, :3]) == pytest.approx(1.0)
    assert np.allclose(found.T[:3, 3], panda.forward_kinematics(q)[:3, 3])
    assert (np.diff(found.radii) <= 0).all()


def test_the_product_of_the_singular_values_is_the_manipulability(panda, rng):
    for q in rng.uniform(panda.lower, panda.upper, (10, 7)):
        found = mobility(panda, q, panda.tip)
        assert np.prod(found.singular_values) == pytest.approx(panda.manipulability(q))


def test_a_link_moved_only_by_a_floating_base_has_an_empty_ellipsoid():
    robot = ulna.Robot(robots.of_chain("floating", "fixed"))
    found = mobility(robot, robot.home, robot.tip)
    assert np.array_equal(found.radii, np.zeros(3))
    assert found.singular_values.size == 0


def test_a_hand_sent_to_a_pose_arrives_on_any_ik_branch_or_the_reason_is_kept(panda, rng):
    session = Session(panda)
    for q in rng.uniform(panda.lower, panda.upper, (5, 7)):
        session.q = panda.home
        T = panda.forward_kinematics(q)
        session.send(T)
        while session.target is not None:
            session.frame()
        assert np.allclose(session.hand_pose, T, atol=2e-5)
        assert session.send_failure == ""
    T[:3, 3] = (5.0, 0, 0)
    session.send(T)
    while session.target is not None:
        session.frame()
    assert session.send_failure.startswith("unreachable")
    session.q = panda.home
    assert session.send_failure == ""


def test_a_robot_with_other_allowed_collisions_is_used_from_the_next_frame_on(panda):
    folded = np.array([0.79, -0.81, -2.66, -3.02, 1.82, 3.42, 0.62])
    session = Session(panda, q=folded)
    session.frame()
    assert sorted(session.own_contacts) == [("panda_link1", "panda_link5"), ("panda_link1", "panda_link7")]
    other = panda.with_allowed_collisions(at=folded)
    session.use(other)
    assert session.robot is panda
    assert session.frame()
    assert session.robot is other
    assert (session.clearance.state, session.own_contacts) == ("free", ())
    session.avoiding = True
    session.pull(session.hand_pose)
    session.frame()
    assert session._hand.robot is other
    assert session.trouble == ""


def test_the_contacts_of_what_is_attached_or_of_an_obstacle_are_not_its_own(panda):
    held = panda.with_attached("bar", ulna.Box((0.05, 0.05, 1.5)), np.eye(4))
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), panda.forward_kinematics(panda.home))
    session = Session(held, world)
    session.frame()
    assert session.clearance.state == "collision"
    assert {"bar", "ball"} <= {name for pair in session.clearance.report.pairs for name in (pair.name_a, pair.name_b)}
    assert session.own_contacts == ()
