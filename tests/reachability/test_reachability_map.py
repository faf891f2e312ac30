"""What is in a map, against inverse kinematics, forward kinematics and arms that can be worked out in the head."""

import hashlib
import shutil
import warnings

import numpy as np
import pytest
import xarray

import ulna
from map_files import SMALL, files_of, verdicts_of
from ulna.reachability import chunk

FAR = [(5.0, 5.0, 5.0), (6.0, 6.0, 6.0)]


def targets_of(found):
    grid = found.grid
    T = grid.targets((slice(None),) * 4)
    return T.reshape(*grid.shape, grid.orientations, 4, 4)


def test_two_links_of_one_meter_reach_the_disc_of_two(planar, tmp_path):
    box = [(-2.5, -2.5, -0.25), (2.5, 2.5, 0.25)]
    found = ulna.reachability_map(planar, tmp_path / "m.zarr", voxel=0.5, orientations=1, bounds=box, task="position")
    y, x = np.meshgrid(found.grid.axes[1], found.grid.axes[2], indexing="ij")
    assert (found.share.values[0] == (np.hypot(x, y) <= 2.0)).all()
    assert found.summary.reached == (np.hypot(x, y) <= 2.0).sum()


def test_its_verdicts_are_those_of_inverse_kinematics(panda, panda_map):
    T = targets_of(panda_map)
    status = np.asarray(panda.inverse_kinematics(T, max_iterations=400).status)
    codes = panda_map.data.reached
    words = dict(zip(codes.attrs["flag_values"], codes.attrs["flag_meanings"].split(), strict=True))
    reached = codes.values == 1
    assert (reached == (status == "solved")).all()
    assert 0.05 < reached.mean() < 0.5
    assert (np.vectorize(words.get)(codes.values) == np.char.replace(status, " ", "_")).all()


def test_its_solutions_lead_to_their_poses(panda, panda_map):
    data, T = panda_map.data, targets_of(panda_map)
    reached, q = data.reached.values == 1, data.q.values.astype(float)
    assert np.isnan(q[~reached]).all()
    at = panda.forward_kinematics(np.clip(q[reached], panda.lower, panda.upper))
    assert np.abs(at - T[reached]).max() < 2e-5  # the tolerance, and the rounding of float32
    expected = panda.manipulability(q[reached])
    np.testing.assert_allclose(data.manipulability.values[reached], expected, rtol=1e-3, atol=1e-5)
    assert np.isnan(data.manipulability.values[~reached]).all()


def test_xarray_opens_it_with_units_and_without_a_warning(panda, panda_map):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xarray.open_zarr(panda_map.path)
    assert data.reached.dims == ("z", "y", "x", "orientation")
    assert data.q.dims == ("z", "y", "x", "orientation", "joint")
    assert data.reached.dtype == np.int8
    assert data.manipulability.dtype == np.float32
    assert [data[name].attrs["units"] for name in "zyx"] == ["m", "m", "m"]
    assert "quaternion" in data.coords
    for name, value in {"robot": "panda", "tool": panda.tip, "seed": 0, "voxel": 0.3, "position_tolerance": 1e-5}.items():
        assert data.attrs[name] == value
    assert data.attrs["urdf_sha256"] == hashlib.sha256(panda.description.text.encode()).hexdigest()
    assert data.attrs["joint_names"] == list(panda.joint_names)
    assert data.attrs["ulna_version"] == ulna.__version__


@pytest.mark.slow
@pytest.mark.parametrize("threads", [2, 5])
def test_the_bits_do_not_depend_on_the_threads(panda, panda_map, many_chunks, tmp_path, threads):
    path = tmp_path / "m.zarr"
    with ulna.threads(threads):
        ulna.reachability_map(panda, path, keep_solutions=True, **SMALL)
    assert files_of(path) == files_of(panda_map.path)


def test_where_nothing_is_reached_the_verdict_is_written_too(panda, many_chunks, tmp_path):
    path = tmp_path / "m.zarr"
    found = ulna.reachability_map(panda, path, voxel=0.3, orientations=8, bounds=FAR)
    assert found.summary.statuses == {"unreachable": found.grid.n_poses}
    assert len(verdicts_of(path)) == found.grid.n_chunks > 1
    assert not (path / "manipulability" / "c").exists()
    assert found.is_whole
    assert found.base_placements(np.eye(4)[None]) == ()


def a_cell():
    world = ulna.World()
    world.add("table", ulna.HalfSpace(), ulna.pose((0, 0, -0.05)))
    world.add("box", ulna.Box((0.3, 0.8, 0.4)), ulna.pose((0.45, 0, 0.15), (0, 0, 0.3)))
    return world


def test_in_a_cell_every_solution_is_free_and_keeps_its_clearance(panda, many_chunks, tmp_path):
    arm, world = panda.with_tool(ulna.pose((0, 0, 0.1)), name="gripper"), a_cell()
    box = [(0.0, -0.6, -0.2), (0.9, 0.6, 0.7)]
    path = tmp_path / "m.zarr"
    found = ulna.reachability_map(
        arm, path, voxel=0.3, orientations=8, bounds=box, world=world, keep_clearance=True, keep_solutions=True
    )
    data, reached = found.data, found.data.reached.values == 1
    q = data.q.values[reached].astype(float)
    assert not arm.in_collision(q, world).any()
    np.testing.assert_allclose(data.clearance.values[reached], arm.signed_distance(q, world), rtol=0, atol=1e-5)
    assert np.isnan(data.clearance.values[~reached]).all()
    assert "in collision" in found.summary.statuses
    free = ulna.reachability_map(arm, tmp_path / "f.zarr", voxel=0.3, orientations=8, bounds=box)
    lost = free.compare(found)
    assert lost.only_second == 0
    assert lost.only_first > 0
    assert lost.both + lost.only_first + lost.only_second + lost.neither == found.grid.n_poses
    assert float(lost.share.max()) <= 0.0


def test_a_robot_that_cannot_be_checked_is_refused_before_anything_is_written(tmp_path, planar):
    with pytest.raises(ulna.GeometryError):
        ulna.reachability_map(planar, tmp_path / "m.zarr", voxel=0.5, orientations=1, world=ulna.World())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "error", "named"),
    [
        ({"voxel": -1}, ulna.InputError, "voxel"),
        ({"orientations": 0}, ulna.InputError, "orientations"),
        ({"bounds": [0, 1]}, ulna.InputError, "bounds"),
        ({"task": "all"}, ulna.InputError, "task"),
        ({"link": "hand of god"}, ulna.UnknownNameError, "hand of god"),
        ({"seed": -1}, ulna.InputError, "seed"),
        ({"position_tolerance": 0.0}, ulna.InputError, "position_tolerance"),
        ({"path": 3}, ulna.InputError, "path"),
        ({"robot": "panda"}, ulna.InputError, "robot"),
    ],
)
def test_what_cannot_be_taken_is_refused_before_anything_is_written(panda, tmp_path, arguments, error, named):
    given = {"robot": panda, "path": tmp_path / "m.zarr", **SMALL, **arguments}
    with pytest.raises(error, match=named):
        ulna.reachability_map(given.pop("robot"), given.pop("path"), **given)
    assert list(tmp_path.iterdir()) == []


def test_several_tips_need_a_name(tmp_path):
    with pytest.raises(ulna.InputError, match=r"link: 'ur5' has several tips; name one of .*tool0") as refused:
        ulna.reachability_map(ulna.load("ur5"), tmp_path / "m.zarr", **SMALL)
    assert refused.value.argument == "link"


def test_two_robots_of_one_cell_are_compared(panda, many_chunks, tmp_path):
    """The Panda with a tool, and a UR5 of convex hulls, which its map carries."""
    world = a_cell()
    world.add("post", ulna.Cylinder(0.05, 1.0), ulna.pose((0.3, -0.5, 0.5)))
    ur5 = ulna.load("ur5", base="base_link", tip="tool0", meshes="hulls")
    world.remove("table")
    given = {"voxel": 0.4, "orientations": 6, "bounds": [(-0.8, -0.8, 0.0), (0.8, 0.8, 0.8)], "world": world}
    arms = {"panda": panda.with_tool(ulna.pose((0, 0, 0.1))), "ur5": ur5}
    maps = {
        name: ulna.reachability_map(arm, tmp_path / f"{name}.zarr", keep_solutions=True, keep_clearance=True, **given)
        for name, arm in arms.items()
    }
    for name, found in maps.items():
        reached = found.verdicts
        assert reached.any()
        q = found.data.q.values[reached].astype(float)
        assert not found.robot.in_collision(q, found.world).any()
        assert not arms[name].in_collision(q, world).any()
    difference = maps["panda"].compare(maps["ur5"])
    assert difference.both + difference.only_first == maps["panda"].summary.reached
    assert difference.both + difference.only_second == maps["ur5"].summary.reached


def test_the_branches_of_an_arm_of_six_joints_are_counted(many_chunks, tmp_path):
    """Each pose alone, and each of its solutions alone; in a cell and without one."""
    ur5 = ulna.load("ur5", base="base_link", tip="tool0", meshes="hulls")
    given = {"voxel": 0.5, "orientations": 4, "bounds": [(-1.0, -1.0, 0.0), (1.0, 1.0, 0.5)]}
    world = a_cell()
    world.remove("table")
    alone = ulna.reachability_map(ur5, tmp_path / "alone.zarr", **given)
    in_cell = ulna.reachability_map(ur5, tmp_path / "cell.zarr", world=world, **given)
    targets = alone.grid.targets((slice(None),) * 4)
    solutions = [found.q[found.valid] for found in map(ur5.all_solutions, targets)]
    assert alone.data.branches.values.ravel().tolist() == [len(q) for q in solutions]
    free = [sum(not ur5.in_collision(one, world) for one in q) for q in solutions]
    assert in_cell.data.branches.values.ravel().tolist() == free
    assert 0 < sum(free) < sum(map(len, solutions))
    for found in (alone, in_cell):
        assert ((found.data.branches.values > 0) == found.verdicts).all()


def test_without_a_closed_form_of_the_task_no_branches_are_counted(panda, tmp_path):
    path = tmp_path / "m.zarr"
    ur5 = ulna.load("ur5", base="base_link", tip="tool0")
    part = {"voxel": 1.0, "orientations": 2, "bounds": [(-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)]}
    for robot, task in ((panda, "pose"), (ur5, "position")):
        assert "branches" not in ulna.reachability_map(robot, path, task=task, **part).data
        shutil.rmtree(path)


def test_an_arm_of_three_joints_has_four_branches_within_the_shell_that_its_links_span(tmp_path):
    rows = [(0, 0.4, 0, 0), (0, 0, np.pi / 2, 0), (0.5, 0, 0, 0), (0.3, 0, 0, 0)]
    arm = ulna.Robot.from_dh(rows, joint_types=["revolute"] * 3 + ["fixed"])
    found = ulna.reachability_map(arm, tmp_path / "m.zarr", voxel=0.17, orientations=1, task="position")
    z, y, x = np.meshgrid(*found.grid.axes, indexing="ij")
    r = np.linalg.norm([x, y, z - 0.4], axis=0)
    expected = np.where((r > 0.2) & (r < 0.8), 4, 0)
    assert (found.data.branches.values[..., 0] == expected).all()


def test_a_map_of_another_version_is_not_gone_on_with(panda, many_chunks, tmp_path, monkeypatch):
    """Workers of a cluster may have another version than the client."""
    path = tmp_path / "m.zarr"
    ulna.reachability_map(panda, path, **SMALL)
    verdicts_of(path)[0].unlink()
    monkeypatch.setattr(chunk, "version", lambda _: "99.0")
    chunk._open_map.cache_clear()
    with pytest.raises(ulna.FileError, match=r"this is 99\.0"):
        ulna.reachability_map(panda, path, resume=True, **SMALL)


def test_a_slide_without_end_needs_bounds(tmp_path):
    gantry = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0)], joint_types=["prismatic", "revolute"])
    with pytest.raises(ulna.InputError, match="bounds: are needed"):
        ulna.reachability_map(gantry, tmp_path / "m.zarr", voxel=0.5, orientations=1)
