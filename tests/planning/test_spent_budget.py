"""A search without a path says which limit ended it, and what stopped its last edges."""

import time
import warnings

import numpy as np
import pytest

import ulna
from ulna.ik.time_limit import TimeLimit
from ulna.planning.entries.search_records import MAX_REFUSED, SearchState
from ulna.planning.slices import Pace, Slices

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
CAR = f"""<robot name="car"><link name="base"/><link name="slide"/><link name="car">{BALL}</link>
<joint name="x" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="y" type="prismatic"><parent link="slide"/><child link="car"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def ur5():
    """A UR5 of hulls without its SRDF: some of its links touch wherever it is."""
    pytest.importorskip("scipy")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ulna.load("ur5", meshes="hulls", srdf=False)


def behind_a_wall():
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 4.0, 1.0)))
    return ulna.load(CAR), world


def test_hulls_that_touch_are_named_with_the_edges_that_they_stopped(ur5):
    q = ur5.random(400, seed=1)
    q = q[~ur5.in_collision(q)]
    plan = ur5.plan(q[0], q[1], max_checks=2000)
    found = plan.reason.data
    assert (plan.status, found.limit, found.effort) == ("budget spent", "max_checks", plan.effort)
    first = found.stops[0]
    assert (first.link, first.other, first.of_robot) == ("base_link", "upper_arm_link", True)
    assert found.edges == MAX_REFUSED >= first.edges > found.edges / 2
    assert [stop.edges for stop in found.stops] == sorted((stop.edges for stop in found.stops), reverse=True)
    assert f"the last 32 refused edges: base_link and upper_arm_link ({first.edges})" in str(plan)
    assert "max_checks=2000" in str(plan)
    assert "docs/self_collision.md" in str(plan)
    allowed = ur5.with_allowed_collisions([(stop.link, stop.other) for stop in found.stops])
    assert allowed.plan(q[0], q[1], max_checks=2000)  # what is named is what was in the way


def test_an_object_in_the_way_is_named_and_no_pair_of_the_robot():
    robot, world = behind_a_wall()
    plan = robot.plan([-0.5, 0], [0.5, 0], world, max_checks=500)
    assert [stop[:3] for stop in plan.reason.data.stops] == [("car", "wall", False)]
    assert plan.reason.data.stops[0].edges == plan.reason.data.edges
    assert plan.reason.data.uncertified == 0
    assert "docs/self_collision.md" not in str(plan)


def test_an_object_nearer_than_the_clearance_is_named():
    robot, world = ulna.load(CAR), ulna.World()
    for name, y in (("left", 0.65), ("right", -0.65)):  # 0.1 m beside the car on its way
        world.add(name, ulna.Box((0.1, 0.9, 1.0)), ulna.pose((0, y, 0)))
    assert robot.plan([-0.5, 0], [0.5, 0], world)
    plan = robot.plan([-0.5, 0], [0.5, 0], world, clearance=0.12, max_checks=500)
    assert {stop.other for stop in plan.reason.data.stops} == {"left", "right"}


def test_edges_that_only_the_certificate_refuses_are_counted():
    robot, world = ulna.load(CAR.replace('<sphere radius="0.1"/>', '<box size="0.2 0.2 0.2"/>')), ulna.World()
    world.add("wall", ulna.Box((2.0, 0.1, 1.0)), ulna.pose((0, -0.15 - 1e-6, 0)))  # nearer than a certificate tells from contact
    start, goal = [-0.5, 0], [0.5, 0]
    assert robot.plan(start, goal, world, held=["y"], certify=False)
    plan = robot.plan(start, goal, world, held=["y"], max_checks=200)
    assert plan.status == "budget spent"
    assert plan.reason.data.uncertified == plan.reason.data.edges > 0
    assert plan.reason.data.stops == ()
    assert "certify=False accepts them" in str(plan)
    sampled = robot.plan(start, goal, behind_a_wall()[1], certify=False, max_checks=200)
    assert sampled.reason.data.uncertified == 0


def test_the_reason_says_that_the_time_ended_the_search():
    robot, world = behind_a_wall()
    plan = robot.plan([-0.5, 0], [0.5, 0], world, max_checks=10**15, time_limit=0.05)
    assert plan.reason.data.limit == "time_limit"
    assert "time_limit=0.05" in str(plan)
    for endless in (None, np.inf):
        assert robot.plan([-0.5, 0], [0.5, 0], world, max_checks=500, time_limit=endless).reason.data.limit == "max_checks"


def test_the_time_is_counted_from_the_end_of_the_first_slice():
    limit, state = TimeLimit(1e-9), SearchState.records()[0]
    slices = Slices(10**6, limit, Pace())
    assert slices.begin_slice(state)
    time.sleep(1e-3)  # the kernels are compiled
    assert not limit.is_over()
    slices.begin_slice(state)
    time.sleep(1e-6)
    assert limit.is_over()
    assert not slices.begin_slice(state)
