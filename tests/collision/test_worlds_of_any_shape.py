"""Queries over every shape, in worlds of few and of many objects: what is met in a tree is what is met one by one."""

import numpy as np
import pytest

import ulna
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.errors import GeometryError

MIXED = """<robot name="mixed">
  <link name="base"><collision name="ball"><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="arm"><collision name="rod"><origin xyz="0 0 0.3" rpy="0 0 0.2"/>
    <geometry><cylinder radius="0.05" length="0.5"/></geometry></collision></link>
  <link name="hand"><collision name="palm"><geometry><box size="0.1 0.15 0.2"/></geometry></collision></link>
  <joint name="a" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0.6 0.8 0"/></joint>
  <joint name="b" type="continuous"><parent link="arm"/><child link="hand"/><origin xyz="0 0 0.6"/><axis xyz="1 0 0"/></joint>
</robot>"""


def shapes(rng):
    size = rng.uniform(0.02, 0.08)
    return [
        ulna.Sphere(size),
        ulna.Box((size, 2 * size, size)),
        ulna.Capsule(size / 2, 2 * size),
        ulna.Cylinder(size, size),
        ulna.ConvexMesh(rng.uniform(-size, size, (8, 3))),
    ]


def crowd(rng, n, reach=1.4):
    """Objects of every kind, by name."""
    found = {}
    for k in range(n):
        way = rng.normal(size=3)
        T = ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.45, reach), rng.uniform(-3, 3, 3))
        found[f"{k}"] = shapes(rng)[k % 5], T
    return found


def world_of(objects):
    world = ulna.World()
    for name, (shape, T) in objects.items():
        world.add(name, shape, T)
    return world


@pytest.fixture(scope="module")
def mixed():
    robot = ulna.load(MIXED)
    return robot.with_attached("cup", ulna.Capsule(0.03, 0.1), ulna.pose((0, 0, 0.2)), link="hand")


@pytest.mark.parametrize("n", [MAX_UNINDEXED, 3 * MAX_UNINDEXED])
def test_what_a_crowd_touches_is_what_each_of_it_touches(mixed, rng, n):
    objects = crowd(rng, n)
    world, q = world_of(objects), rng.uniform(-3, 3, (40, 2))
    verdicts = mixed.in_collision(q, world, self_collision=False)
    assert 0 < verdicts.mean() < 1
    for row, verdict in zip(q, verdicts, strict=True):
        assert mixed.in_collision(row, world, self_collision=False) == verdict
        touched = {pair.name_b for pair in mixed.check_collision(row, world, self_collision=False).pairs}
        assert bool(touched) == verdict
    alone = np.array([mixed.in_collision(q, world_of({name: one}), self_collision=False) for name, one in objects.items()])
    assert np.array_equal(alone.any(axis=0), verdicts)


def test_a_floor_is_met_among_many_objects(mixed, rng):
    world = world_of(crowd(rng, 2 * MAX_UNINDEXED, reach=30.0))
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -0.5)))
    q = rng.uniform(-3, 3, (50, 2))
    lowest = []
    for row in q:
        report = mixed.check_collision(row, world, self_collision=False)
        lowest.append("floor" in {pair.name_b for pair in report.pairs})
    assert 0.1 < np.mean(lowest) < 0.9
    assert mixed.in_collision(q, world, self_collision=False).tolist() == lowest


def test_objects_may_come_move_and_go_in_a_tree(mixed, rng):
    world = world_of(crowd(rng, 2 * MAX_UNINDEXED, reach=30.0))
    q = np.zeros(2)
    before = mixed.in_collision(q, world)
    world.add("rock", ulna.Sphere(0.1), ulna.pose((0, 0, 0.4)))
    assert mixed.in_collision(q, world) is True
    assert {pair.name_b for pair in mixed.check_collision(q, world).pairs} == {"rock"}
    world.move("rock", ulna.pose((9, 9, 9)))
    assert mixed.in_collision(q, world) == before
    world.move("rock", ulna.pose((0, 0, 0.4)))
    world.remove("rock")
    assert mixed.in_collision(q, world) == before


def test_meshes_are_refused_and_half_spaces_cannot_be_held(panda):
    mesh = ulna.Mesh("package://somewhere/part.stl")
    with pytest.raises(GeometryError, match="ConvexMesh"):
        ulna.World().add("part", mesh)  # type: ignore[arg-type]
    for shape in (mesh, ulna.HalfSpace()):
        with pytest.raises(GeometryError, match="cannot be attached"):
            panda.with_attached("part", shape, np.eye(4))
    with pytest.raises(GeometryError, match=r"link 'l': collision shape .* a Mesh has no collision kernel"):
        ulna.load(
            '<robot name="r"><link name="l"><collision><geometry><mesh filename="a.stl"/></geometry></collision></link></robot>'
        ).in_collision([])
