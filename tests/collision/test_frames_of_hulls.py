"""The frames in which kernels have a robot's hulls: those of small boxes. Users see the frames of the description."""

import numpy as np
import pytest

import ulna
from ulna.collision.rounded_shapes import hull_columns, tight_frame
from ulna.kernels.layout import HALF_EXTENTS, REACH

RNG = np.random.default_rng(3)
TURN = ulna.pose((0.3, -0.8, 1.1), rpy=(0.4, -0.9, 2.0))
BRICK = np.array([(x, y, z) for x in (-0.3, 0.3) for y in (-0.02, 0.02) for z in (-0.05, 0.05)])


def moved(points):
    return points @ TURN[:3, :3].T + TURN[:3, 3]


@pytest.mark.parametrize(
    "points",
    [
        moved(BRICK),
        RNG.normal(size=(40, 3)) * (0.3, 0.1, 0.02) + 1.0,
        np.array([(0.1, 0.2, 0.3)]),
        np.array([(0.1, 0.2, 0.3), (1.1, 0.2, 0.4)]),
        moved(BRICK) * (1.0, 1.0, 0.0),
        moved(BRICK) * 1e6,
    ],
    ids=["brick", "cloud", "point", "segment", "polygon", "large"],
)
def test_a_tight_frame_is_a_rigid_motion_to_the_center_of_a_box_that_is_no_larger(points):
    T = tight_frame(points)
    assert T[:3, :3] @ T[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    inside = (points - T[:3, 3]) @ T[:3, :3]
    size = max(np.abs(points).max(), 1.0)
    assert inside.max(axis=0) == pytest.approx(-inside.min(axis=0), abs=1e-12 * size)
    kept = inside @ T[:3, :3].T + T[:3, 3]
    assert kept == pytest.approx(points, abs=1e-12 * size)
    reach = hull_columns(inside, 0)[-1]
    assert reach == np.linalg.norm(inside, axis=1).max()
    assert reach <= np.linalg.norm(np.ptp(points, axis=0)) / 2 * (1 + 1e-12) + 1e-12 * size


def test_a_turned_brick_far_from_its_frame_has_its_own_half_extents_and_reach():
    robot = ulna.load(
        '<robot name="r"><link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>'
    ).with_attached("brick", ulna.ConvexMesh(moved(BRICK)), np.eye(4), link="a")
    row = robot._checker.bodies.table[1]
    assert np.sort(row[HALF_EXTENTS : HALF_EXTENTS + 3]) == pytest.approx([0.02, 0.05, 0.3])
    assert row[REACH] == pytest.approx(np.linalg.norm((0.02, 0.05, 0.3)))
    assert robot.collision_poses([])[1] == pytest.approx(np.eye(4))


def test_a_hull_is_as_far_from_a_box_as_the_box_that_it_is():
    base = ulna.load(
        '<robot name="r"><link name="a"><collision><geometry><sphere radius="0.01"/></geometry></collision></link></robot>'
    )
    as_hull = base.with_attached("brick", ulna.ConvexMesh(moved(BRICK)), np.eye(4), link="a")
    as_box = base.with_attached("brick", ulna.Box((0.6, 0.04, 0.1)), TURN, link="a")
    for seed in range(50):
        rng = np.random.default_rng(seed)
        world = ulna.World()
        place = TURN[:3, 3] + rng.uniform(-0.4, 0.4, 3)
        world.add("box", ulna.Box(rng.uniform(0.02, 0.3, 3)), ulna.pose(place, rpy=rng.uniform(-3, 3, 3)))
        expected = as_box.signed_distance([], world)
        assert as_hull.signed_distance([], world) == pytest.approx(expected, abs=1e-9)
        assert as_hull.in_collision([], world) == as_box.in_collision([], world)
