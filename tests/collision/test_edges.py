"""Edges: what is called free is free at every sample, and what is called a contact is one, to the resolution."""

import numpy as np
import pytest

import ulna
from ulna.collision.entries.continuous import BREADTH, split_next
from ulna.engine.lanes import empty_rows
from ulna.errors import InputError

# A cube of 0.2 that slides along x and turns about z at the end of an arm of 0.5.
SLIDER = """<robot name="slider">
  <link name="rail"/><link name="car"/>
  <link name="cube">
    <collision name="cube"><origin xyz="0.5 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="car"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="car"/><child link="cube"/><axis xyz="0 0 1"/></joint>
</robot>"""


def crowd(rng, n, size, shape=None):
    world = ulna.World()
    for k in range(n):
        way = rng.normal(size=3)
        T = ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.5, 0.9), rng.uniform(-3, 3, 3))
        world.add(f"{k}", shape or ulna.Box(rng.uniform(0.2, 1, 3) * size), T)
    return world


def free_starts(robot, world, rng, n, spread):
    q = rng.uniform(robot.lower, robot.upper, (6 * n, robot.n_dof))
    a = q[~robot.in_collision(q, world)][:n]
    return a, np.clip(a + spread * rng.normal(size=a.shape), robot.lower, robot.upper)


@pytest.mark.parametrize(
    ("n", "size", "shape"),
    [(0, 0.0, None), (8, 0.1, None), (150, 0.03, None), (4, 0.0, ulna.Capsule(0.02, 0.1)), (4, 0.0, ulna.Cylinder(0.05, 0.02))],
    ids=["itself", "boxes", "many boxes", "capsules", "cylinders"],
)
def test_no_sample_of_a_free_edge_touches_and_none_before_the_contact(panda, rng, n, size, shape):
    world = crowd(rng, n, size, shape)
    a, b = free_starts(panda, world, rng, 60, 0.4)
    found, t = panda.edge_in_collision(a, b, world), np.linspace(0, 1, 1001)[:, None]
    assert 0 < found.in_collision.mean() < 1
    for k in range(len(a)):
        samples = a[k] + t * (b[k] - a[k])
        hits = panda.in_collision(samples, world)
        first = t[np.argmax(hits), 0] if hits.any() else 1.0
        assert found.free_until[k] <= first
        if found.in_collision[k]:
            assert panda.signed_distance(found.q[k], world) < 1e-4
        else:
            assert not hits.any()
            assert found.free_until[k] == 1.0


def test_the_contact_is_where_the_geometry_says(rng):
    robot, world = ulna.load(SLIDER), ulna.World()
    world.add("wall", ulna.Box((0.1, 4, 4)), ulna.pose((2.05, 0, 0)))  # its face at x = 2
    found = robot.edge_in_collision([0, 0], [4, 0], world)  # the cube's face is at q + 0.6
    assert found
    assert found.free_until == pytest.approx(1.4 / 4, abs=1e-4)
    assert 1.4 - 1e-4 <= found.q[0] <= 1.4
    assert str(found) == "collision at 0.3500 of the edge"


@pytest.mark.parametrize(("stop", "free"), [(1.4 - 1.1e-4, True), (1.4 + 1e-6, False)])
def test_an_edge_that_ends_before_the_contact_is_free_and_one_that_reaches_it_is_not(stop, free):
    robot, world = ulna.load(SLIDER), ulna.World()
    world.add("wall", ulna.Box((0.1, 4, 4)), ulna.pose((2.05, 0, 0)))
    assert bool(robot.edge_in_collision([0, 0], [stop, 0], world)) is not free


def test_a_thin_sheet_between_two_free_configurations_is_not_jumped_over():
    robot, world = ulna.load(SLIDER), ulna.World()
    world.add("sheet", ulna.Box((1e-9, 1e-9, 1e-9)), ulna.pose((0, 0.5, 0)))
    a, b = [0, -3.0], [0, 3.0]
    assert not robot.in_collision([a, b], world).any()
    found = robot.edge_in_collision(a, b, world)
    assert found.in_collision
    # The cube's leading edge, 0.1 ahead of the arm, meets the grain where the arm still has asin(0.1 / 0.5) to turn.
    assert found.q[1] == pytest.approx(np.pi / 2 - np.arcsin(0.1 / 0.5), abs=1e-3)


def test_a_clearance_above_the_resolution_is_no_contact():
    robot, world = ulna.load(SLIDER), ulna.World()
    world.add("ceiling", ulna.Box((8, 8, 0.1)), ulna.pose((0, 0, 0.15 + 2e-3)))  # 2 mm above the cube
    assert not robot.edge_in_collision([-1, -2], [1, 2], world, resolution=1e-3)
    world.move("ceiling", ulna.pose((0, 0, 0.15 - 1e-6)))
    assert robot.edge_in_collision([-1, -2], [1, 2], world).free_until == 0.0


def test_an_edge_of_no_length_is_the_configuration(panda, rng):
    world = crowd(rng, 8, 0.1)
    q = rng.uniform(panda.lower, panda.upper, (100, 7))
    assert np.array_equal(panda.edge_in_collision(q, q, world).in_collision, panda.in_collision(q, world))


def test_backwards_an_edge_is_as_free(panda, rng):
    world = crowd(rng, 8, 0.1)
    a, b = free_starts(panda, world, rng, 60, 0.3)
    there, back = panda.edge_in_collision(a, b, world), panda.edge_in_collision(b, a, world)
    differ = there.in_collision != back.in_collision
    for k in np.flatnonzero(differ):  # grazing only
        report = there if there.in_collision[k] else back
        assert 0 < panda.signed_distance(report.q[k], world) < 1e-4
    assert differ.mean() < 0.05


def test_batches_broadcast_and_each_row_is_that_of_one_edge(panda, rng):
    world = crowd(rng, 8, 0.1)
    ends = rng.uniform(panda.lower, panda.upper, (3, 4, 7))
    found = panda.edge_in_collision(panda.home, ends, world)
    assert found.in_collision.shape == found.free_until.shape == (3, 4)
    assert found.q.shape == (3, 4, 7)
    for place in np.ndindex(3, 4):
        one = panda.edge_in_collision(panda.home, ends[place], world)
        assert one.in_collision is bool(found.in_collision[place])
        assert one.free_until == found.free_until[place]


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        ((np.zeros((2, 7)), np.zeros((3, 7))), {}),
        ((np.zeros(7), np.full(7, np.nan)), {}),
        ((np.zeros(6), np.zeros(7)), {}),
        ((np.zeros(7), np.zeros(7)), {"resolution": 0}),
        ((np.zeros(7), np.zeros(7)), {"resolution": True}),
        ((np.zeros(7), np.zeros(7)), {"self_collision": False}),
    ],
)
def test_edges_that_make_no_sense_are_refused(panda, arguments, options):
    with pytest.raises(InputError):
        panda.edge_in_collision(*arguments, **options)


@pytest.mark.parametrize(("breadth", "parents", "left"), [(BREADTH, [0, 1, 2, 3], (4, 6)), (0, [2, 3, 4, 5], (0, 2))])
def test_the_oldest_intervals_are_split_first_or_the_newest(breadth, parents, left):
    """With the newest first an edge that passes near something for long is given up after a few looks at one place."""
    waiting, rows = np.column_stack([(np.arange(6) + 0.5) / 6, np.full(6, 1 / 12)]), empty_rows(3)
    n, oldest, newest = split_next(waiting, 0, 6, rows, breadth)
    assert (n, (oldest, newest)) == (4, left)
    np.testing.assert_allclose(np.reshape(rows[0], (4, 2)).mean(axis=1), waiting[parents, 0])
    np.testing.assert_allclose(rows[1], 1 / 24)
