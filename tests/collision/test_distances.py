"""Signed distances, their gradients, and what a report tells: each against the others, against differences, and in trees."""

import numpy as np
import pytest

import ulna
from assertions import assert_close
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.errors import InputError


@pytest.fixture(params=[3, 3 * MAX_UNINDEXED], ids=["few", "many"])
def world(request, rng):
    world = ulna.World()
    for k in range(request.param):
        way = rng.normal(size=3)
        T = ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.6, 1.5), rng.uniform(-3, 3, 3))
        world.add(f"{k}", ulna.Box(rng.uniform(0.01, 0.1, 3)), T)
    return world


def random_positions(panda, rng, n):
    return rng.uniform(panda.lower, panda.upper, (n, 7))


@pytest.mark.parametrize("self_collision", [True, False])
def test_the_distance_is_that_of_the_nearest_pair_of_the_report(panda, world, rng, self_collision):
    q = random_positions(panda, rng, 30)
    distances = panda.signed_distance(q, world, self_collision=self_collision)
    for row, distance in zip(q, distances, strict=True):
        report = panda.check_collision(row, world, self_collision=self_collision, max_distance=np.inf)
        assert len(report.pairs) == 12 * len(world.names) + (37 if self_collision else 0)
        assert_close(report.pairs[0].signed_distance, distance, atol=1e-12)
        assert panda.signed_distance(row, world, self_collision=self_collision) == distance


def test_its_sign_agrees_with_in_collision(panda, world, rng):
    q = random_positions(panda, rng, 500)
    assert np.array_equal(panda.signed_distance(q, world) <= 0, panda.in_collision(q, world))


def test_witness_points_stand_on_the_shapes_as_far_apart_as_they_say(panda, world, rng):
    shapes = {body.name: body.shape for link in panda.description.links for body in link.collisions}
    for q in random_positions(panda, rng, 5):
        poses = dict(zip(panda.collision_names, panda.collision_poses(q), strict=True))
        for pair in panda.check_collision(q, world, max_distance=0.3).pairs:
            assert_close(pair.witness_b - pair.witness_a, pair.signed_distance * pair.normal, atol=1e-9)
            of_world = pair.link_b is None
            T_b = world.pose(pair.name_b) if of_world else poses[pair.name_b]
            shape_b = world.shape(pair.name_b) if of_world else shapes[pair.name_b]
            for point, T, shape in ((pair.witness_a, poses[pair.name_a], shapes[pair.name_a]), (pair.witness_b, T_b, shape_b)):
                at = T[:3, :3].T @ (point - T[:3, 3])
                assert np.abs(np.abs(at) - shape.half_extents).min() < 1e-9  # on a face
                assert (np.abs(at) <= np.array(shape.half_extents) + 1e-9).all()


def test_a_report_has_the_pairs_up_to_the_given_distance(panda, world, rng):
    q = random_positions(panda, rng, 1)[0]
    everything = [pair.signed_distance for pair in panda.check_collision(q, world, max_distance=np.inf).pairs]
    assert everything == sorted(everything)
    for limit in (0.0, 0.05, 0.4):
        near = [pair.signed_distance for pair in panda.check_collision(q, world, max_distance=limit).pairs]
        assert near == [distance for distance in everything if distance <= limit]


def test_pairs_that_are_only_near_are_no_collision(panda):
    report = panda.check_collision(panda.home, max_distance=0.2)
    assert report.pairs
    assert not report.in_collision
    assert report.touching == ()
    assert str(report) == "free"


def test_a_batch_of_reports_is_an_array_of_them(panda, world, rng):
    q = random_positions(panda, rng, 6).reshape(2, 3, 7)
    reports = panda.check_collision(q, world)
    assert reports.shape == (2, 3)
    touching = panda.in_collision(q, world)
    assert [[report.in_collision for report in row] for row in reports] == touching.tolist()


class Restless(ulna.World):
    """Between any two looks at it the object has gone, and another stands in its place."""

    def objects(self):
        found = super().objects()
        for name in self.names:
            pose = self.pose(name)
            self.remove(name)
            self.add(f"{name}'", ulna.Box((0.1, 0.2, 0.3)), ulna.pose((0, 0, 0.5)) @ pose)
        return found


def test_a_report_is_of_one_moment_of_the_world(panda):
    restless, still = Restless(), ulna.World()
    for world in (restless, still):
        world.add("a", ulna.Sphere(0.1), ulna.pose((0.5, 0, 0.2)))
    found, expected = (
        panda.check_collision(panda.home, world, self_collision=False, max_distance=np.inf) for world in (restless, still)
    )
    assert str(found.pairs) == str(expected.pairs)
    assert restless.names == ("a'",), "it was looked at once"


@pytest.mark.parametrize("self_collision", [True, False])
def test_the_gradient_is_that_of_differences_away_from_ties(panda, world, rng, self_collision):
    q, h, judged = random_positions(panda, rng, 60), 1e-6, 0
    gradient = panda.distance_gradient(q, world, self_collision=self_collision)
    steps = h * np.eye(7)
    ahead, behind = (panda.signed_distance(q[:, None] + side * steps, world, self_collision=self_collision) for side in (1, -1))
    here = panda.signed_distance(q, world, self_collision=self_collision)[:, None]
    smooth = (np.abs(ahead + behind - 2 * here) < 1e-9).all(axis=1)  # no kink between: another pair or feature is not taken over
    assert_close(gradient[smooth], ((ahead - behind) / (2 * h))[smooth], atol=1e-4)
    judged = np.count_nonzero(smooth)
    assert judged > 40
    assert np.abs(gradient).max() > 0.01


def test_the_gradient_of_a_slider_is_known():
    robot = ulna.load("""<robot name="slider"><link name="rail"/>
      <link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="rail"/><child link="ball"/><axis xyz="1 0 0"/>
        <limit lower="-5" upper="5" velocity="1" effort="1"/></joint></robot>""")
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -1)))
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((2, 0, 0)))
    assert_close(robot.signed_distance([[0.0], [1.2], [1.6]], world), [0.9, 0.2, -0.2], atol=1e-12)
    assert_close(robot.distance_gradient([[0.0], [1.2], [1.6]], world), [[0], [-1], [-1]], atol=1e-12)


def test_where_there_is_nothing_the_distance_is_infinite_and_its_gradient_zero(panda):
    q = np.zeros((3, 7))
    assert np.isposinf(panda.signed_distance(q, ulna.World(), self_collision=False)).all()
    assert not panda.distance_gradient(q, ulna.World(), self_collision=False).any()


def test_rows_are_the_same_bit_for_bit_however_a_batch_is_cut(panda, world, rng):
    q = random_positions(panda, rng, 5000)
    for query in (panda.signed_distance, panda.distance_gradient, panda.in_collision):
        whole = query(q, world)
        for start, stop in ((0, 1), (3, 20), (4990, 5000)):
            assert np.array_equal(query(q[start:stop], world), whole[start:stop])


@pytest.mark.parametrize("limit", [-1, np.nan, "far", True])
def test_a_value_that_is_not_a_distance_is_refused(panda, limit):
    with pytest.raises(InputError, match="max_distance"):
        panda.check_collision(panda.home, max_distance=limit)


@pytest.mark.parametrize("query", ["signed_distance", "distance_gradient", "check_collision", "in_collision"])
def test_positions_out_of_range_are_refused(panda, world, query):
    q = np.zeros((2, 7))
    q[1, 2] = np.inf
    with pytest.raises(InputError, match=r"q\[0\]"):
        getattr(panda, query)(np.full(7, np.nan), world)
    with pytest.raises(InputError, match=r"q\[1, 2\]"):
        getattr(panda, query)(q, world)
