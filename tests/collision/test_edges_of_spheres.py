"""Edges of arms of spheres, past themselves and past objects: those that are called free are free, also between the samples."""

import numpy as np
import pytest

import ulna

LINK = '<collision name="s{k}"><origin xyz="{x} 0 0"/><geometry><sphere radius="0.045"/></geometry></collision>'
JOINT = """<joint name="j{i}" type="revolute"><parent link="l{before}"/><child link="l{i}"/>
  <origin xyz="{x} 0 0"/><axis xyz="{axis}"/><limit lower="-6" upper="6" velocity="1" effort="1"/></joint>"""


def arm_of_spheres(axes):
    """Links of 0.4 m with five spheres each, joined at their ends."""
    shapes = "".join(LINK.format(k=k, x=0.06 + 0.07 * k) for k in range(5))
    links = "".join(f'<link name="l{i}">{shapes}</link>' for i in range(len(axes) + 1))
    joints = "".join(JOINT.format(i=i + 1, before=i, x=0.4, axis=axis) for i, axis in enumerate(axes))
    return ulna.load(f'<robot name="spheres">{links}{joints}</robot>')


@pytest.mark.parametrize("spread", [0.1, 1.0, 4.0])
@pytest.mark.parametrize(
    "axes", [("0 0 1", "0 0 1", "0 0 1", "0 0 1"), ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1")], ids=["flat", "in space"]
)
def test_no_sample_of_a_free_edge_of_spheres_touches_and_few_free_ones_are_refused(rng, axes, spread):
    arm = arm_of_spheres(axes)
    q = rng.uniform(arm.lower, arm.upper, (3000, arm.n_dof))
    a = q[~arm.in_collision(q)][:300]
    b = np.clip(a + spread * rng.normal(size=a.shape), arm.lower, arm.upper)
    refused, t = arm.edge_in_collision(a, b).in_collision, np.linspace(0, 1, 2001)[:, None]
    touches = np.array([np.any(arm.in_collision(start + t * (end - start))) for start, end in zip(a, b, strict=True)])
    assert touches.any()
    assert not touches.all()
    assert not (touches & ~refused).any()
    assert (refused & ~touches).sum() <= 3  # they come within the resolution


@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # a joint of twenty turns
@pytest.mark.parametrize(("aside", "touches"), [(0.0, True), (0.2, False)])
def test_a_sphere_that_comes_by_between_the_middles_of_all_intervals_is_found(aside, touches):
    """At each of the eight middles it is far away, and its distance hardly changes: its acceleration brings it near."""
    ball = '<collision><origin xyz="0.4 0 {z}"/><geometry><sphere radius="0.05"/></geometry></collision>'
    joint = """<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{j}"/><axis xyz="0 0 1"/>
      <limit lower="-60" upper="60" velocity="1" effort="1"/></joint>"""
    first, last = f'<link name="l0">{ball.format(z=0)}</link>', f'<link name="l2">{ball.format(z=aside)}</link>'
    arm = ulna.load(f'<robot name="wheel">{first}<link name="l1"/>{last}{joint.format(i=0, j=1)}{joint.format(i=1, j=2)}</robot>')
    a, b = np.array([0.0, 0.5]), np.array([0.0, 0.5 + 16 * np.pi])
    t = np.linspace(0, 1, 8001)[:, None]
    assert np.any(arm.in_collision(a + t * (b - a))) == touches
    assert bool(arm.edge_in_collision(a, b).in_collision) == touches


OBJECTS = {
    "sphere": ulna.Sphere(0.1),
    "box": ulna.Box((0.2, 0.3, 0.4)),
    "capsule": ulna.Capsule(0.1, 0.3),
    "cylinder": ulna.Cylinder(0.1, 0.3),
    "hull": ulna.ConvexMesh.from_points(np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.2, 0.2)])),
    "plane": ulna.HalfSpace(),
}


def next_to(kind, x):
    """A world with an object whose nearest point to the origin is at x on the first axis."""
    world = ulna.World()
    world.add(kind, OBJECTS[kind], ulna.pose((x, 0, 0), (0, -np.pi / 2, 0)) if kind == "plane" else ulna.pose((x + 0.1, 0, 0)))
    return world


@pytest.mark.parametrize("held", ["sphere", "box"])
@pytest.mark.parametrize("kind", OBJECTS)
def test_a_body_that_comes_by_an_object_between_the_middles_of_all_intervals_is_found(kind, held):
    """At each of the eight middles it is far away, and moves almost across the way to the object: its acceleration brings it."""
    shape = '<sphere radius="0.05"/>' if held == "sphere" else '<box size="0.1 0.1 0.1"/>'
    arm = ulna.load(f"""<robot name="wheel"><link name="base"/>
      <link name="rim"><collision><origin xyz="0.4 0 0"/><geometry>{shape}</geometry></collision></link>
      <joint name="axle" type="revolute"><parent link="base"/><child link="rim"/><axis xyz="0 0 1"/>
        <limit lower="-60" upper="60" velocity="1" effort="1"/></joint></robot>""")
    a, b = np.array([-0.5]), np.array([-0.5 + 16 * np.pi])
    t = np.linspace(0, 1, 8001)[:, None]
    reach = 0.45 if held == "sphere" else np.hypot(0.45, 0.05)
    for x, touches in ((reach - 0.03, True), (reach + 0.02, False)):
        world = next_to(kind, x)
        assert not arm.in_collision(a, world)
        assert np.any(arm.in_collision(a + t * (b - a), world)) == touches
        assert bool(arm.edge_in_collision(a, b, world).in_collision) == touches


@pytest.mark.parametrize("spread", [0.1, 1.0, 4.0])
@pytest.mark.parametrize("kind", OBJECTS)
def test_no_sample_of_an_edge_that_is_free_of_objects_touches_and_few_free_ones_are_refused(rng, kind, spread):
    """Of spheres among thin plates, rods and balls, or beside a wall."""
    arm = arm_of_spheres(("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1"))
    world = ulna.World()
    for k in range(6):
        T = ulna.pose(rng.normal(size=3) * (0.3, 1.0)[k % 2] + [1.5, 0, 0], rng.uniform(-3, 3, 3))
        thin = ulna.Box(rng.permutation([0.001, 0.3, 3.0])) if kind == "box" else OBJECTS[kind]
        wall = ulna.pose((0, -0.6, 0), (-np.pi / 2, 0, 0))
        if kind != "plane" or k == 0:
            world.add(f"{k}", thin, wall if kind == "plane" else T)
    q = rng.uniform(arm.lower, arm.upper, (3000, arm.n_dof))
    a = q[~arm.in_collision(q, world, self_collision=False)][:200]
    b = np.clip(a + spread * rng.normal(size=a.shape), arm.lower, arm.upper)
    refused = arm.edge_in_collision(a, b, world, self_collision=False).in_collision
    ways = a[:, None] + np.linspace(0, 1, 1001)[:, None] * (b - a)[:, None]
    touches = arm.in_collision(ways, world, self_collision=False).any(axis=1)
    assert touches.any()
    assert not touches.all()
    assert not (touches & ~refused).any()
    assert (refused & ~touches).sum() <= 3  # they come within the resolution, or touch between the samples
