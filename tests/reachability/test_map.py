"""What is read from a map: scores, slices, what differs, where a base may stand."""

import numpy as np
import pytest

import ulna
from ulna.description.pose import inverse


def all_targets(found):
    grid = found.grid
    return grid.targets((slice(None),) * 4).reshape(*grid.shape, grid.orientations, 4, 4)


def test_its_own_poses_are_reached_as_it_says(panda_map):
    T, verdicts = all_targets(panda_map), panda_map.data.reached.values == 1
    assert (panda_map.reached(T) == verdicts).all()
    np.testing.assert_allclose(panda_map.score(T), np.broadcast_to(verdicts.mean(axis=-1)[..., None], T.shape[:-2]), atol=1e-6)
    assert (panda_map.verdicts == verdicts).all()


def test_a_pose_near_the_center_of_a_voxel_is_that_of_the_voxel(panda_map, rng):
    T = all_targets(panda_map)
    moved = T @ ulna.pose(rng.uniform(-0.1, 0.1, (*T.shape[:-2], 3)), rng.uniform(-0.05, 0.05, (*T.shape[:-2], 3)))
    assert (panda_map.reached(moved) == panda_map.verdicts).mean() > 0.999  # but where the nearest orientation is another


def test_one_pose_has_plain_values(panda, panda_map):
    T = panda.forward_kinematics(panda.home)
    assert type(panda_map.score(T)) is float
    assert 0.5 < panda_map.score(T) <= 1.0
    assert type(panda_map.reached(T)) is bool
    assert panda_map.score(ulna.pose((9, 9, 9))) == 0.0
    assert panda_map.reached(ulna.pose((9, 9, 9))) is False
    assert panda_map.reached(np.empty((0, 4, 4))).shape == (0,)
    with pytest.raises(ulna.InputError, match="T: "):
        panda_map.score(np.zeros((4, 4)))


def test_a_slice_is_a_plane_of_shares(panda_map):
    z = panda_map.grid.axes[0][3]
    cut = panda_map.slice(z=z + 0.1)
    assert cut.dims == ("y", "x")
    assert (cut.values == panda_map.share.values[3]).all()
    for wrong in ({}, {"z": 0.1, "x": 0.2}, {"yaw": 1.0}, {"z": 99.0}):
        with pytest.raises(ulna.InputError):
            panda_map.slice(**wrong)


def test_the_solutions_of_a_voxel_are_those_of_the_map(panda_map):
    z, y, x = np.unravel_index(panda_map.share.values.argmax(), panda_map.grid.shape)
    center = [panda_map.grid.axes[2][x], panda_map.grid.axes[1][y], panda_map.grid.axes[0][z]]
    result = panda_map.solutions_at(center)
    assert (result.success == panda_map.verdicts[z, y, x]).all()
    stored = panda_map.data.q.values[z, y, x][result.success]
    assert (stored == result.q[result.success].astype(np.float32)).all()
    with pytest.raises(ulna.InputError, match="not within the map"):
        panda_map.solutions_at((9, 9, 9))


def test_it_carries_its_robot_and_refuses_another(panda, panda_map):
    opened = ulna.ReachabilityMap.open(panda_map.path)
    assert (opened.robot.forward_kinematics(panda.home) == panda.forward_kinematics(panda.home)).all()
    assert opened.world is None
    assert repr(opened) == "<ReachabilityMap of 'panda': 7 x 7 x 7 voxels of 0.3 m, 8 orientations>"
    with pytest.raises(ulna.InputError, match="another robot"):
        ulna.ReachabilityMap.open(panda_map.path, robot=panda.with_tool(np.eye(4)))


def test_a_map_is_no_different_from_itself(panda_map):
    difference = panda_map.compare(panda_map)
    assert (difference.only_first, difference.only_second) == (0, 0)
    assert difference.both == panda_map.summary.reached
    assert difference.both + difference.neither == panda_map.grid.n_poses
    assert not difference.share.values.any()


def test_maps_of_other_grids_are_not_compared(planar, panda_map, tmp_path):
    other = ulna.reachability_map(planar, tmp_path / "m.zarr", voxel=1.0, orientations=2, task="position")
    with pytest.raises(ulna.InputError, match="its grid differs"):
        panda_map.compare(other)


# ---- where a base may stand --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def targets(panda):
    """Three poses that the Panda reaches where it stands, seen from a world in which its base is elsewhere."""
    q = panda.home + np.array([[0.3], [-0.2], [0.1]]) * np.array([1, 0.5, 0, 0.3, 0, 0.4, 1])
    return T_BASE @ panda.forward_kinematics(q)


T_BASE = ulna.pose((2.0, -1.0, 0.4), (0, 0, 0.7))


def errors(robot, placement, targets):
    reached = placement.T_world_base @ robot.forward_kinematics(placement.q)
    return np.abs(reached - targets).max()


def test_from_every_placement_all_targets_are_reached(panda, panda_map, targets):
    found = panda_map.base_placements(targets, T_world_base=ulna.pose((0, 0, 0.4)), most=5)
    assert len(found) == 5
    for one in found:
        assert errors(panda, one, targets) < 2e-5
        assert one.T_world_base[2, 3] == 0.4
        np.testing.assert_allclose(one.T_world_base, ulna.pose(one.T_world_base[:3, 3], (0, 0, one.yaw)), atol=1e-12)
        np.testing.assert_allclose(one.manipulability, panda.manipulability(one.q))
        assert ((one.q >= panda.lower) & (one.q <= panda.upper)).all()
    assert [one.score for one in found] == sorted((one.score for one in found), reverse=True)


def test_what_is_not_free_stays(panda, panda_map, targets):
    found = panda_map.base_placements(targets, free_dofs=("x",), T_world_base=T_BASE)
    assert found
    for one in found:
        assert (one.T_world_base[1:] == T_BASE[1:]).all()
    (here,) = panda_map.base_placements(targets, free_dofs=(), T_world_base=T_BASE)
    assert (here.T_world_base == T_BASE).all()
    assert panda_map.base_placements(targets, free_dofs=(), T_world_base=ulna.pose((9, 0, 0))) == ()


def test_targets_that_are_too_far_apart_have_no_placement(panda_map):
    assert panda_map.base_placements([ulna.pose((0, 0, 0.5)), ulna.pose((5, 0, 0.5))]) == ()


def test_in_a_world_every_placement_is_free(panda, panda_map, targets):
    world = ulna.World()
    world.add("pillar", ulna.Box((0.12, 0.12, 3.0)), ulna.pose((1.95, -1.05, 0.4)))  # where the base was
    found = panda_map.base_placements(targets, world=world, T_world_base=ulna.pose((0, 0, 0.4)), most=3)
    assert found
    for one in found:
        around = ulna.World()
        around.add("pillar", world.shape("pillar"), inverse(one.T_world_base) @ world.pose("pillar"))
        assert not panda.in_collision(one.q, around).any()
        assert errors(panda, one, targets) < 2e-5
    assert panda_map.base_placements(targets, free_dofs=(), world=world, T_world_base=T_BASE) == ()


def test_bounds_hold_the_base(panda_map, targets):
    box = np.array([(1.8, -1.2, 0.0), (2.2, -0.6, 1.0)])
    found = panda_map.base_placements(targets, T_world_base=ulna.pose((0, 0, 0.4)), bounds=box)
    assert found
    for one in found:
        assert ((one.T_world_base[:2, 3] >= box[0, :2]) & (one.T_world_base[:2, 3] <= box[1, :2])).all()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"targets": np.eye(4)}, "targets"),
        ({"targets": np.zeros((2, 4, 4))}, "targets"),
        ({"targets": np.empty((0, 4, 4))}, "targets"),
        ({"free_dofs": ("x", "roll")}, "free_dofs"),
        ({"bounds": [1, 2]}, "bounds"),
        ({"yaw_steps": -1}, "yaw_steps"),
        ({"tries": 1.5}, "tries"),
    ],
)
def test_what_cannot_be_placed_is_refused(panda_map, arguments, named):
    given = {"targets": np.eye(4)[None], **arguments}
    with pytest.raises(ulna.InputError) as refused:
        panda_map.base_placements(given.pop("targets"), **given)
    assert refused.value.argument.startswith(named)
