"""Objects of a world that some links may touch: every query leaves those pairs out, and only those."""

import pickle

import numpy as np
import pytest

import ulna
from robot_files import EXAMPLES
from ulna.collision.scene_file import world_from_json, world_to_json

FLOOR = ulna.pose((0, 0, 0.02))  # 2 cm above the base: the boxes of the first link reach into it
BASE = "panda_link1"


def add_obstacles(world, rng, n):
    """Boxes, balls and hulls around the arm."""
    for k in range(n):
        shape = (ulna.Box((0.2, 0.1, 0.3)), ulna.Sphere(0.1), ulna.ConvexMesh(rng.uniform(-0.1, 0.1, (9, 3))))[k % 3]
        world.add(f"object {k}", shape, ulna.pose(rng.uniform(-0.8, 0.8, 3), rng.uniform(-3, 3, 3)))


@pytest.fixture(params=[0, 5, 100], ids=lambda n: f"{n} others")
def worlds(request):
    """A floor and others: with the floor that the base may touch, with it untouchable, and without it."""
    rng, found = np.random.default_rng(7), []
    for touch_links in ([BASE], [], None):
        world = ulna.World()
        add_obstacles(world, np.random.default_rng(7), request.param)
        if touch_links is not None:
            world.add("floor", ulna.HalfSpace(), FLOOR, touch_links=touch_links)
            world.add(
                "post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((-0.35, 0, 0.6)), touch_links=touch_links and [BASE, "panda_link3"]
            )
        found.append(world)
    return *found, rng


def expected_pairs(panda, q, allowed, strict):
    """The slow way: every pair of the strict world, but for those that are allowed."""
    report = panda.check_collision(q, strict, max_distance=np.inf)
    return [pair for pair in report.pairs if pair.link_b is not None or pair.link_a not in allowed.get(pair.name_b, ())]


ALLOWED = {"floor": {BASE}, "post": {BASE, "panda_link3"}}


def test_every_query_leaves_the_allowed_pairs_out_and_no_other(panda, worlds):
    world, strict, _, rng = worlds
    q = rng.uniform(panda.lower, panda.upper, (40, 7))
    distances, hits, gradients = panda.signed_distance(q, world), panda.in_collision(q, world), panda.distance_gradient(q, world)
    for k in range(len(q)):
        pairs = expected_pairs(panda, q[k], ALLOWED, strict)
        assert distances[k] == pytest.approx(pairs[0].signed_distance, abs=1e-9)
        assert hits[k] == (pairs[0].signed_distance <= 0.0)
        report = panda.check_collision(q[k], world, max_distance=np.inf)
        told, known = ({(p.name_a, p.name_b): p.signed_distance for p in each} for each in (report.pairs, pairs))
        assert told.keys() == known.keys()
        assert told == pytest.approx(known, abs=1e-9)
        assert [p.signed_distance for p in report.pairs] == sorted(p.signed_distance for p in report.pairs)
        assert panda.in_collision(q[k], world) is bool(hits[k])
        assert panda.signed_distance(q[k], world) == pytest.approx(distances[k], abs=1e-12)
    ahead, behind = (panda.signed_distance(q[:, None] + side * 1e-6 * np.eye(7), world) for side in (1, -1))
    smooth = (np.abs(ahead + behind - 2 * distances[:, None]) < 1e-9).all(axis=1)
    assert smooth.sum() > 10
    np.testing.assert_allclose(gradients[smooth], ((ahead - behind) / 2e-6)[smooth], atol=1e-4)


def test_an_edge_is_free_exactly_where_no_pair_that_counts_touches(panda, worlds):
    world, _, _, rng = worlds
    a, b = rng.uniform(panda.lower, panda.upper, (2, 12, 7))
    edges = panda.edge_in_collision(a, b, world, self_collision=False)
    for k in range(len(a)):
        t = np.linspace(0.0, 1.0, 400)
        touches = panda.in_collision(a[k] + t[:, None] * (b[k] - a[k]), world, self_collision=False)
        first = t[touches.argmax()] if touches.any() else 1.0
        assert edges.free_until[k] <= first + 1e-12
        if touches.any():
            assert edges.in_collision[k]


def test_a_world_whose_objects_no_link_may_touch_keeps_its_bits(panda, worlds):
    world, strict, _, rng = worlds
    q = rng.uniform(panda.lower, panda.upper, (300, 7))
    unknown = ulna.World()
    for name, shape, T in world.items():
        unknown.add(name, shape, T, touch_links=["a link of another robot"])
    np.testing.assert_allclose(panda.signed_distance(q, unknown), panda.signed_distance(q, strict), atol=1e-9)
    np.testing.assert_array_equal(panda.in_collision(q, unknown), panda.in_collision(q, strict))


def test_what_is_carried_may_touch_an_object_by_its_name(panda):
    cup, world = ulna.Box((0.1, 0.1, 0.1)), ulna.World()
    arm = panda.with_attached("cup", cup, np.eye(4))
    world.add("table", cup, arm.forward_kinematics(arm.home), touch_links=["cup"])
    hit = {pair.link_a for pair in arm.check_collision(arm.home, world, self_collision=False).pairs}
    assert "cup" not in hit
    assert hit, "the link that holds it is still checked"


def test_a_robot_of_which_every_link_may_touch_the_only_object_is_free_of_it(panda):
    world = ulna.World()
    world.add("mist", ulna.Box((9, 9, 9)), touch_links=panda.link_names)
    assert not panda.in_collision(panda.home, world, self_collision=False)
    assert panda.signed_distance(panda.home, world, self_collision=False) == np.inf
    assert not panda.distance_gradient(panda.home, world, self_collision=False).any()
    assert panda.check_collision(panda.home, world, self_collision=False, max_distance=np.inf).pairs == ()
    assert not panda.edge_in_collision(panda.home, panda.home + 0.1, world, self_collision=False).in_collision


def test_inverse_kinematics_takes_the_allowed_pairs_as_free(panda):
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), FLOOR)
    T = panda.forward_kinematics(panda.home)
    assert panda.inverse_kinematics(T, panda.home, world=world).status == "in collision"
    world.remove("floor")
    world.add("floor", ulna.HalfSpace(), FLOOR, touch_links=[BASE])
    assert panda.inverse_kinematics(T, panda.home, world=world).success


def test_a_ur5_with_hulls_on_a_floor_that_its_base_may_touch_is_free():
    pytest.importorskip("scipy")
    robot, world = ulna.load(EXAMPLES / "ur_description" / "urdf" / "ur5_robot.urdf").with_convex_hulls(), ulna.World()
    upright = [0, -np.pi / 2, 0, 0, 0, 0]
    world.add("floor", ulna.HalfSpace())
    assert robot.in_collision(upright, world)
    world.remove("floor")
    world.add("floor", ulna.HalfSpace(), touch_links=["base_link"])
    assert not robot.in_collision(upright, world)
    assert robot.in_collision([0, 1.0, 0, 0, 0, 0], world), "the arm itself is still checked"


def test_an_object_keeps_its_links_as_it_is_moved_copied_saved_and_pickled():
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), touch_links=["b", "a"])
    world.move("floor", FLOOR)
    world.reshape("floor", ulna.Box((1, 1, 1)))
    text = world_to_json(world)
    assert '"touch_links": ["a", "b"]' in text
    for same in (world, world.copy(), world_from_json(text), pickle.loads(pickle.dumps(world))):  # noqa: S301
        assert same.touch_links("floor") == {"a", "b"}
    world.remove("floor")
    world.add("floor", ulna.HalfSpace())
    assert world.touch_links("floor") == frozenset()


def test_links_that_can_be_read_but_once_may_touch_each_of_many_objects():
    world, links = ulna.World(), ("panda_link0", "panda_link1")
    world.add_many([("a", ulna.Sphere(0.1)), ("b", ulna.Sphere(0.1))], touch_links=iter(links))
    assert world.touch_links("a") == world.touch_links("b") == set(links)


def test_a_copy_of_a_world_is_a_world_of_its_own():
    world = ulna.World()
    world.add("a", ulna.Sphere(0.1))
    other = world.copy()
    other.move("a", FLOOR)
    other.add("b", ulna.Sphere(0.2))
    assert world.names == ("a",)
    assert np.array_equal(world.pose("a"), np.eye(4))


def test_the_repr_of_a_world_is_one_line():
    world = ulna.World()
    assert repr(world) == "<World: no objects>"
    world.add("crate", ulna.Box((1, 1, 1)))
    assert repr(world) == "<World: 1 object: 'crate' Box>"
    for k in range(9):
        world.add(f"\x1b{k}", ulna.Sphere(0.1))
    assert repr(world).startswith("<World: 10 objects: 'crate' Box, '\\x1b0' Sphere, ")
    assert repr(world).endswith(" and 4 more>")


@pytest.mark.parametrize("links", ["panda_link0", None, 3, [3], ["\ud800"]])
def test_what_is_no_list_of_names_is_refused(panda, links):
    with pytest.raises(ulna.InputError):
        ulna.World().add("floor", ulna.HalfSpace(), touch_links=links)
    with pytest.raises(ulna.InputError):
        panda.with_attached("cup", ulna.Sphere(0.1), np.eye(4), touch_links=links)


def test_an_object_among_the_pairs_of_links_is_sent_to_the_world(panda):
    with pytest.raises(ulna.UnknownNameError, match=r"world\.add\(\.\.\., touch_links=\[\.\.\.\]\)"):
        panda.with_allowed_collisions(panda.allowed_collisions.plus((BASE, "floor")))


def test_a_scene_with_touch_links_that_are_no_names_is_refused():
    text = '{"ulna_scene": 1, "objects": [{"name": "a", "shape": "half_space", "touch_links": "panda_link0"}]}'
    with pytest.raises(ulna.DescriptionError, match="a list of names is expected"):
        world_from_json(text)
