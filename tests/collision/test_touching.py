"""Touching is a collision, by one rule for every query: at contact, a little short of it and a little beyond."""

import numpy as np
import pytest

import grazing
import solids
import ulna

AT, SHORT, BEYOND = 0.0, 1e-9, -1e-9  # [m] for bodies of a meter or less


def usual_solid(rng, kind):
    return solids.random_solid(rng, kind, 0.5)


def contact(rng, kinds, gap):
    """A robot, a world and q at which two bodies are a gap apart along a normal of the second."""
    shape, target = (usual_solid(rng, kind) for kind in kinds)
    robot, world, T_object = grazing.mover(shape, np.eye(4)), ulna.World(), solids.random_pose(rng, 0.3)
    world.add("target", target, T_object)
    surface, normal, _ = grazing.surface_point(rng, target)
    out, angles = T_object[:3, :3] @ normal, rng.uniform(-3, 3, 3)
    turn = robot.forward_kinematics([0, 0, 0, *angles], link="of_a")[:3, :3]
    T = np.eye(4)
    T[:3, :3] = turn
    place = T_object[:3, :3] @ surface + T_object[:3, 3] + gap * out - solids.farthest(shape, T, -out)
    return robot, world, np.array([*place, *angles])


@pytest.mark.parametrize("kinds", [(a, b) for a in solids.KINDS for b in solids.KINDS], ids="-".join)
def test_all_queries_agree_at_contact(rng, kinds):
    for gap, touches in ((AT, True), (BEYOND, True), (SHORT, False)):
        for _ in range(6):
            robot, world, q = contact(rng, kinds, gap)
            distance = robot.signed_distance(q, world, self_collision=False)
            report = robot.check_collision(q, world, self_collision=False)
            rows = robot.in_collision([q] * 3, world, self_collision=False)
            assert robot.in_collision(q, world, self_collision=False) is touches
            assert rows.tolist() == [touches] * 3
            assert (distance <= 0) is touches
            assert report.in_collision is touches
            assert (robot.signed_distance([q] * 3, world, self_collision=False) <= 0).tolist() == [touches] * 3
            if gap == AT:
                assert abs(distance) < 2e-9


def test_all_queries_agree_where_a_body_rests_on_a_half_space(rng):
    for kind in solids.KINDS:
        for gap, touches in ((AT, True), (BEYOND, True), (SHORT, False)):
            shape, angles = usual_solid(rng, kind), rng.uniform(-3, 3, 3)
            robot, world, T_floor = grazing.mover(shape, np.eye(4)), ulna.World(), solids.random_pose(rng, 0.3)
            world.add("floor", ulna.HalfSpace(), T_floor)
            T, up = robot.forward_kinematics([0, 0, 0, *angles], link="of_a"), T_floor[:3, 2]
            q = np.array([*(T_floor[:3, 3] + gap * up - solids.farthest(shape, T, -up)), *angles])
            assert robot.in_collision(q, world, self_collision=False) is touches
            assert (robot.signed_distance(q, world, self_collision=False) <= 0) is touches
            assert robot.check_collision(q, world, self_collision=False).in_collision is touches


@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # the crowd is 100 m away
@pytest.mark.parametrize("n", [0, 100])
def test_a_ball_that_touches_a_cube_collides_alone_and_in_a_crowd(n):
    """In a world of many objects the tree of bounds must not lose what touches only."""
    robot, world = grazing.mover(ulna.Sphere(0.1), np.eye(4)), ulna.World()
    world.add("cube", ulna.ConvexMesh(grazing.corners((0.2, 0.2, 0.2))), ulna.pose((0.2, 0, 0)))
    for k in range(n):
        world.add(f"{k}", ulna.Sphere(0.1), ulna.pose((10.0 + k, 0, 0)))
    q = np.zeros(6)
    assert robot.in_collision(q, world, self_collision=False)
    assert robot.signed_distance(q, world, self_collision=False) == 0
    assert robot.check_collision(q, world, self_collision=False).in_collision
