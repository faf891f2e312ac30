"""Edges of arms of spheres: those that pass themselves closely, folding and turning, are free only if no sample touches."""

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
