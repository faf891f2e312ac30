"""A world that changes: whatever happened to it, queries find what they find in a world that is made anew."""

import pickle
import threading

import numpy as np
import pytest

import ulna
from ulna.collision import object_tables
from ulna.collision.entries import placing
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.description.pose import as_one_pose
from ulna.errors import InputError, UnknownNameError

LINKS = [(), ("panda_link0", "panda_link1"), ("panda_link7", "panda_link8"), ("cup",)]


def some_shape(rng):
    size = rng.uniform(0.02, 0.12, 3)
    points = rng.normal(size=(int(rng.integers(1, 300)), 3)) * 0.08
    return [
        lambda: ulna.Box(size),
        lambda: ulna.Box(size),
        lambda: ulna.Sphere(size[0]),
        lambda: ulna.Capsule(size[0] / 2, size[1]),
        lambda: ulna.Cylinder(size[0], size[1]),
        lambda: ulna.ConvexMesh.from_points(rng.normal(size=(12, 3)) * 0.05),
        lambda: ulna.PointCloud(points, 0.01),
        lambda: ulna.HeightMap(rng.uniform(0, 0.2, (4, 5)), 0.05),
        ulna.HalfSpace,
    ][rng.integers(9)]()


def some_pose(rng, shape):
    if isinstance(shape, ulna.HalfSpace):
        return ulna.pose((0, 0, rng.uniform(-1.0, -0.3)))
    way = rng.normal(size=3)
    return ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.4, 1.5), rng.uniform(-3, 3, 3))


def anew(world):
    other = ulna.World()
    for name, shape, T in world.items():
        other.add(name, shape, T, touch_links=world.touch_links(name))
    return other


def assert_same(robot, world, q):
    fresh = anew(world)
    assert np.array_equal(robot.in_collision(q, world), robot.in_collision(q, fresh))
    np.testing.assert_allclose(robot.signed_distance(q, world), robot.signed_distance(q, fresh), rtol=0, atol=1e-12)
    found, expected = (
        {(pair.name_a, pair.name_b): pair.signed_distance for pair in robot.check_collision(q[0], each, max_distance=0.2).pairs}
        for each in (world, fresh)
    )
    assert found == pytest.approx(expected, abs=1e-12)
    edges = [robot.edge_in_collision(q[:3], q[3:6], each) for each in (world, fresh)]
    assert np.array_equal(edges[0].in_collision, edges[1].in_collision)
    assert world.objects().farthest == pytest.approx(fresh.objects().farthest, abs=1e-12)
    assert world.objects().layout.only_boxes == fresh.objects().layout.only_boxes


def change(rng, world, count):
    """Change something, as a user might."""
    names = world.names
    what = rng.integers(6) if names else 0
    if what == 0:
        shape = some_shape(rng)
        world.add(f"{count}", shape, some_pose(rng, shape), touch_links=LINKS[rng.integers(len(LINKS))])
        return
    name = names[rng.integers(len(names))]
    if what == 1:
        world.remove(name)
    elif what == 2:
        world.reshape(name, some_shape(rng))
    else:
        world.move(name, some_pose(rng, world.shape(name)))


@pytest.mark.parametrize("seed", range(3))
def test_any_changes_leave_the_world_that_is_made_anew(panda, seed):
    rng, world = np.random.default_rng(seed), ulna.World()
    arm = panda.with_attached("cup", ulna.Cylinder(0.03, 0.1), ulna.pose((0, 0, 0.1)), touch_links=["panda_link7"])
    q, before = arm.random(6, seed=seed), []
    for count in range(150):
        change(rng, world, count)
        if rng.random() < 0.3:
            before.append((world.copy(), anew(world)))
        if count % 5 == 0:
            assert_same(arm, world, q)
    for copy, then in before[::7]:  # what came later, in the same arrays, has left them as they were
        assert np.array_equal(arm.in_collision(q, copy), arm.in_collision(q, then))
        change(rng, copy, 1000)
        assert_same(arm, copy, q)
    assert_same(arm, pickle.loads(pickle.dumps(world)), q)  # noqa: S301
    assert_same(arm, world, q)


def boxes_at(places, size=0.04):
    return [(f"{k}", ulna.Box((size, size, size)), ulna.pose(place)) for k, place in enumerate(places)]


@pytest.mark.parametrize("n", [MAX_UNINDEXED, 3 * MAX_UNINDEXED])
def test_thousands_of_moves_in_a_world_of_many_objects(panda, rng, n):
    world, q = ulna.World(), panda.random(20, seed=1)
    world.add_many(boxes_at(rng.uniform(-1, 1, (n, 3))))
    world.add("cloud", ulna.PointCloud(rng.normal(size=(500, 3)), 0.01), ulna.pose((0, 0, -1.2)))
    first = world.objects()
    for k in range(3000):
        world.move(f"{k * 7 % n}", ulna.pose(rng.uniform(-1, 1, 3)))
        objects = world.objects()
    assert len(objects.numbers) == n + 500
    assert len(objects.layout.table) < 4096 + 8 * (n + 500), "rows that are not in use are given up"
    assert sorted({objects.layout.names[int(number)] for number in objects.solids[:, 12]}) == sorted(world.names)
    fresh = anew(world)
    assert np.array_equal(panda.in_collision(q, world), panda.in_collision(q, fresh))
    np.testing.assert_allclose(panda.signed_distance(q, world), panda.signed_distance(q, fresh), rtol=0, atol=1e-12)
    assert len(first.numbers) == n + 500


def test_an_object_that_moves_beside_a_cloud_leaves_the_cloud_where_it_is(rng):
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(rng.normal(size=(1000, 3)), 0.01))
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)))
    before = world.objects()
    world.move("crate", ulna.pose((1, 0, 0)))
    after = world.objects()
    assert after is not before
    assert after.layout is before.layout


def test_several_move_at_once_or_none(panda, rng):
    world = ulna.World()
    world.add_many(boxes_at(rng.uniform(1, 2, (5, 3))))
    poses = ulna.pose(rng.uniform(1, 2, (2, 3)))
    world.move_many(["1", "3"], poses)
    assert np.array_equal(world.pose("3"), poses[1])
    before = world.pose("1")
    for names, given, error in (
        (["1", "nobody"], poses, UnknownNameError),
        (["1"], poses, InputError),
        ("13", poses, InputError),
        (["1", "3"], [np.eye(4), np.diag([1, 1, -1, 1.0])], InputError),
        (["1", "3"], np.full((2, 4, 4), np.nan), InputError),
    ):
        with pytest.raises(error):
            world.move_many(names, given)
    assert np.array_equal(world.pose("1"), before)
    assert not panda.in_collision(panda.home, world)


def test_most_of_a_tree_moves_at_once_and_others_stay_in_it(panda, rng):
    world, q = ulna.World(), panda.random(20, seed=2)
    world.add_many(boxes_at(rng.uniform(-1, 1, (5 * MAX_UNINDEXED, 3))))
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -1.5)))
    before = world.objects()
    numbers = before.numbers
    for n in (MAX_UNINDEXED, MAX_UNINDEXED + 1, 4 * MAX_UNINDEXED):
        world.move_many([f"{3 * k % (5 * MAX_UNINDEXED)}" for k in range(n)], ulna.pose(rng.uniform(-1, 1, (n, 3))))
        assert_same(panda, world, q)
    assert len(world.objects().numbers) == 5 * MAX_UNINDEXED + 1
    assert np.array_equal(before.numbers, numbers)


def test_several_are_added_at_once_or_none():
    world, box = ulna.World(), ulna.Box((1, 1, 1))
    world.add_many([("a", box), ("b", box, ulna.pose((1, 0, 0)))], touch_links=["base"])
    assert (world.names, world.touch_links("b")) == (("a", "b"), {"base"})
    for wrong in ([("c", box), ("a", box)], [("c", box), ("c", box)], [("c", box), ("d", box, np.zeros((4, 4)))]):
        with pytest.raises(InputError):
            world.add_many(wrong)
    assert world.names == ("a", "b")


@pytest.mark.parametrize("fault", [np.nan, np.inf, 1e-5, -1.0, 2e6])
@pytest.mark.parametrize("place", [(0, 0), (1, 2), (0, 3), (3, 1)])
def test_what_is_no_rigid_motion_is_refused(fault, place):
    world, T = ulna.World(), np.eye(4)
    world.add("a", ulna.Sphere(0.1))
    T[place] += fault
    if place == (0, 3) and fault in (1e-5, -1.0):
        world.move("a", T)
        assert np.array_equal(world.pose("a"), T)
        return
    with pytest.raises(InputError, match=r"^pose: "):
        world.move("a", T)


def test_a_world_contains_the_names_of_its_objects():
    world = ulna.World()
    assert world
    assert len(world) == 0
    world.add("a", ulna.Sphere(0.1))
    world.add("b", ulna.Sphere(0.1))
    assert ("a" in world, "c" in world, len(world), list(world)) == (True, False, 2, ["a", "b"])


def test_a_rounded_rotation_is_made_orthonormal_and_an_exact_one_is_kept():
    world, T = ulna.World(), ulna.pose((1, 2, 3), (0.3, -0.2, 1.0))
    world.add("a", ulna.Sphere(0.1), T)
    assert np.array_equal(world.pose("a"), T)
    T[:3, :3] = np.round(T[:3, :3], 8)
    world.move("a", T)
    R = world.pose("a")[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)


@pytest.mark.parametrize("fault", [0.0, 1e-16, 3e-15, 7e-15, 1e-12, 1e-5, -1.0, 2e6, np.nan, np.inf])
@pytest.mark.parametrize("place", [(0, 0), (2, 1), (1, 3), (3, 2), (3, 3)])
def test_a_pose_is_copied_by_machine_code_only_where_it_is_kept_as_it_is(rng, place, fault):
    for T in [np.eye(4), *ulna.pose(rng.uniform(-1, 1, (50, 3)), rng.uniform(-3, 3, (50, 3)))]:
        T[place] += fault
        out = np.full((4, 4), 7.0)
        if placing.copy_exact(T, out):
            assert np.array_equal(out, as_one_pose(T))
            assert np.array_equal(out[:3], T[:3])
        else:
            assert (out == 7.0).all()
            assert fault not in (0.0, 1e-16)


def test_a_reflection_is_not_copied_by_machine_code():
    assert not placing.copy_exact(np.diag([1.0, 1.0, -1.0, 1.0]), np.empty((4, 4)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # the others are 100 m away
@pytest.mark.parametrize("n_more", [0, 2 * MAX_UNINDEXED])
def test_queries_in_threads_find_the_world_as_it_was_at_one_moment(panda, n_more):
    """Two boxes change places, one of them always in the way: a query that found a torn world would find none, now and then."""
    world, aside, in_the_way = ulna.World(), ulna.pose((3, 0, 0)), panda.forward_kinematics(panda.home)
    world.add_many([("a", ulna.Box((0.1, 0.1, 0.1)), aside), ("b", ulna.Box((0.1, 0.1, 0.1)), in_the_way)])
    world.add_many((f"{k}", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((4, k, 0))) for k in range(n_more))
    wrong, done, q = [], threading.Event(), np.tile(panda.home, (64, 1))

    def ask():
        while not done.is_set():
            if not panda.in_collision(q, world, self_collision=False).all() or not panda.in_collision(panda.home, world):
                wrong.append("free")

    askers = [threading.Thread(target=ask) for _ in range(3)]
    for thread in askers:
        thread.start()
    for k in range(3000):
        world.move_many(["a", "b"], [in_the_way, aside] if k % 2 else [aside, in_the_way])
        if n_more:
            world.move(f"{k % n_more}", ulna.pose((5, k % 7, 0)))
    done.set()
    for thread in askers:
        thread.join()
    assert not wrong


@pytest.mark.slow
def test_a_world_and_its_copies_change_at_the_same_time_and_stay_apart(panda, rng):
    world = ulna.World()
    world.add_many(boxes_at(rng.uniform(-1, 1, (2 * MAX_UNINDEXED, 3))))
    world.objects()
    copies, q, failed = [world.copy() for _ in range(3)], panda.random(20, seed=2), []

    def go(one, seed):
        try:
            rng = np.random.default_rng(seed)
            for count in range(1500):
                change(rng, one, count + 1000)
                one.objects()
        except Exception as error:  # noqa: BLE001 - shown below
            failed.append(error)

    threads = [threading.Thread(target=go, args=(one, seed)) for seed, one in enumerate((world, *copies))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    for one in (world, *copies):
        assert_same(panda, one, q)


def test_a_plan_keeps_the_world_in_which_it_was_found(panda):
    world, end = ulna.World(), panda.home + 0.3 * np.eye(7)[0]
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((2, 0, 0)))
    plan, expected = panda.plan(panda.home, end, world), panda.plan(panda.home, end, world).clearance
    world.move("crate", panda.forward_kinematics(panda.home))
    assert panda.in_collision(panda.home, world)
    assert plan.clearance == expected > 0.5
    assert not plan.trajectory(acceleration=2.0).is_free(world)


def test_how_far_a_cloud_with_a_speed_reaches_is_computed_once(rng, monkeypatch):
    sizes, farthest = [], object_tables._farthest

    def counted(shape):
        sizes.append(len(shape.points))
        return farthest(shape)

    monkeypatch.setattr(object_tables, "_farthest", counted)
    world, cloud = ulna.World(), ulna.PointCloud(rng.uniform(-1, 1, (50, 3)), 0.01)
    world.add("seen", cloud, speed=0.1)
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), speed=0.1)
    for k in range(4):
        for name in ("crate", "seen"):
            world.move(name, ulna.pose((0.1 * k, 0, 0)))
            world.objects()
            world.copy().objects()
    reach = world.objects().moving[0].radius
    assert reach == np.linalg.norm(cloud.points, axis=1).max() + 0.01
    world.update("seen", 2 * cloud.points[:9])
    assert world.objects().moving[0].radius == farthest(ulna.PointCloud(2 * cloud.points[:9], 0.01)) != reach
    world.remove("seen")
    world.add("seen", cloud, speed=0.1)
    assert world.objects().moving[-1].radius == reach
    assert sizes == [50, 9, 50]
