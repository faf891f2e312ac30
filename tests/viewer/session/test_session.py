"""The state behind the page: what a frame makes of it, the verdict, the nearest pair, the ellipsoid."""

import numpy as np
import pytest

import robots
import ulna
from ulna.errors import InputError, UnknownNameError
from ulna.viewer.session.clearance import clearance
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.session import Session
from ulna.viewer.session.shape_names import ShapeNames


@pytest.fixture
def world():
    world = ulna.World()
    world.add("crate", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.5, 0, 0.21)))
    return world


def test_a_frame_tells_whether_anything_has_changed(panda, world):
    session = Session(panda, world)
    assert session.frame()
    assert not session.frame()
    world.move("crate", ulna.pose((0.3, 0, 0.5)))  # by anyone
    assert session.frame()
    assert session.clearance.verdict == "collision"
    session.q = panda.home + 0.1
    assert session.frame()
    assert not session.frame()


def test_a_pulled_hand_arrives_frame_by_frame_and_rests_when_let_go(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (0.3, 0.3, 0)
    session.pull(T)
    frames = 0
    while session.frame() and frames < 100:
        frames += 1
    assert frames > 2
    assert np.allclose(session.hand_pose, T, atol=2e-5)
    session.let_go()
    session.frame()
    assert session.target is None
    assert not session.moving


def test_letting_go_on_the_way_ends_the_way_first(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (0.3, 0.3, 0)
    session.pull(T)
    session.let_go()
    session.frame()
    assert session.moving
    while session.moving:
        session.frame()
    assert np.allclose(session.hand_pose, T, atol=2e-5)


def test_the_reason_goes_when_the_hand_is_let_go(panda):
    session = Session(panda)
    T = session.hand_pose
    T[:3, 3] += (2.0, 0, 0)
    session.pull(T)
    while session.frame() and session.moving:
        pass
    assert session.trouble.startswith("unreachable")
    session.let_go()
    session.frame()
    assert (session.target, session.trouble) == (None, "")


def test_shapes_are_named_by_their_links_and_never_like_an_obstacle(panda):
    names = ShapeNames(panda)
    assert [names.of_shape(name) for name in ("box 1", "box 6")] == ["panda_link1 (box 1)", "panda_link3"]
    world = ulna.World()
    world.add("box 1", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.3, 0, 0.5)))
    assert str(clearance(panda, panda.home, world)) == "collision: panda_link7 (box 12) and obstacle box 1"
    slider = ulna.load("panda").with_attached("bar", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0, 0, 0.1)))
    assert "bar" in ShapeNames(slider).taken


def test_a_link_of_one_shape_gives_it_its_name():
    names = ShapeNames(ulna.load("ur5").with_convex_hulls())
    assert names.of_shape("forearm_link_collision") == "forearm_link"


def test_what_cannot_be_is_refused_by_name(panda):
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


def test_a_robot_begins_where_it_is_told_to(panda):
    assert np.array_equal(Session(panda).q, panda.home)
    assert np.array_equal(Session(panda, q=panda.home + 0.1).q, panda.home + 0.1)


def test_the_nearest_pair_is_the_signed_distance(panda, world, rng):
    for q in rng.uniform(panda.lower, panda.upper, (50, 7)):
        found = clearance(panda, q, world)
        assert found.nearest.signed_distance == pytest.approx(panda.signed_distance(q, world, self_collision=False), abs=1e-9)
        assert found.nearest.name_b == "crate"
        assert found.report.in_collision == panda.in_collision(q, world)
        assert str(found).startswith(found.verdict)


def test_the_distance_is_told_in_millimetres(panda):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((2.0, 0, 0.5)))
    found = clearance(panda, panda.home, world)
    assert found.distance == f"{1000 * panda.signed_distance(panda.home, world, self_collision=False):.1f} mm"
    assert found.verdict == "free"


def test_meshes_are_not_called_free():
    session = Session(ulna.load("ur5"))
    session.frame()
    assert session.clearance.verdict == "not checked"
    assert "Mesh" in session.unchecked


def test_the_ellipsoid_holds_every_velocity_of_unit_joint_rates_and_no_less(panda, rng):
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


def test_a_link_that_nothing_moves_has_a_flat_ellipsoid():
    robot = ulna.Robot(robots.of_chain("floating", "fixed"))
    found = mobility(robot, robot.home, robot.tip)
    assert np.array_equal(found.radii, np.zeros(3))
    assert found.singular_values.size == 0


def test_a_hand_that_is_sent_arrives_on_any_branch_and_says_afterwards_why_it_did_not(panda, rng):
    session = Session(panda)
    for q in rng.uniform(panda.lower, panda.upper, (5, 7)):
        session.q = panda.home
        T = panda.forward_kinematics(q)
        session.send(T)
        while session.target is not None:
            session.frame()
        assert np.allclose(session.hand_pose, T, atol=2e-5)
        assert session.missed == ""
    T[:3, 3] = (5.0, 0, 0)
    session.send(T)
    while session.target is not None:
        session.frame()
    assert session.missed.startswith("unreachable")
    session.q = panda.home
    assert session.missed == ""
