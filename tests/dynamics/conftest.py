"""Robots that have inertias, and random motions of them."""

import numpy as np
import pytest

import ulna

# A trunk that slides and turns with two arms, one joint of which follows another; links beside each other that no joint moves.
TREE = """<robot name="tree">
  <link name="base"/><link name="lift"/><link name="trunk"/><link name="box"/>
  <link name="left1"/><link name="left2"/><link name="right1"/><link name="right2"/>
  <joint name="up" type="prismatic"><parent link="base"/><child link="lift"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint>
  <joint name="turn" type="revolute"><parent link="lift"/><child link="trunk"/><origin xyz="0 0.1 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9" velocity="1"/></joint>
  <joint name="fixed" type="fixed"><parent link="trunk"/><child link="box"/><origin xyz="0.2 0 0.1" rpy="1 2 3"/></joint>
  <joint name="l1" type="revolute"><parent link="trunk"/><child link="left1"/><origin xyz="0 0.3 0.3" rpy="1 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="9" velocity="1"/></joint>
  <joint name="l2" type="revolute"><parent link="left1"/><child link="left2"/><origin xyz="0 0 0.4" rpy="0 1 0"/>
    <axis xyz="0 1 0"/><mimic joint="l1" multiplier="-0.7" offset="0.2"/><limit lower="-2" upper="2" effort="9"
    velocity="1"/></joint>
  <joint name="r1" type="revolute"><parent link="trunk"/><child link="right1"/><origin xyz="0 -0.3 0.3" rpy="-1 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="9" velocity="1"/></joint>
  <joint name="r2" type="prismatic"><parent link="right1"/><child link="right2"/><origin xyz="0 0 0.4" rpy="0 1 0"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint>
</robot>"""


def random_inertia(random: np.random.Generator) -> ulna.Inertia:
    """That of twenty point masses, so one that a body can have."""
    masses, points = random.uniform(0.1, 1.0, 20), random.normal(scale=0.2, size=(20, 3))
    center = masses @ points / masses.sum()
    r = points - center
    tensor = (masses[:, None, None] * ((r * r).sum(1)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :])).sum(0)
    return ulna.Inertia(masses.sum(), center, tensor)


@pytest.fixture(scope="session", params=["arm", "tree"])
def robot(request):
    """A Panda, or a tree with slides and a joint that follows, with random inertias."""
    made = ulna.load("panda" if request.param == "arm" else TREE)
    random = np.random.default_rng(3)
    return made.with_inertias({link.name: random_inertia(random) for link in made.description.links})


@pytest.fixture(scope="session")
def motion(robot):
    """q, qd and qdd of nineteen random motions: two blocks of lanes and a part of one."""
    return robot.random(19, seed=0), *np.random.default_rng(1).normal(size=(2, 19, robot.n_dof))
