"""How many kilograms an arm holds at the poses of a map."""

from dataclasses import replace

import numpy as np
import pytest

import ulna
from map_files import SMALL
from ulna.reachability.model import robot_from_json, robot_to_json


@pytest.fixture(scope="module")
def upright(planar):
    """The two links of one meter in a vertical plane, with 2 kg each in its middle, and motors of 60 and 30 Nm."""
    bar = ulna.Inertia(2.0, (0.5, 0, 0), np.zeros((3, 3)))
    arm = planar.with_gravity((0, -10, 0)).with_inertias({"link1": bar, "link2": bar})
    joints = [
        replace(joint, limits=replace(joint.limits, effort=effort))
        for joint, effort in zip(arm.description.joints, (60.0, 30.0, np.inf), strict=True)
    ]
    return ulna.Robot(replace(arm.description, joints=tuple(joints)), gravity=arm.gravity)


def test_of_two_elbows_the_one_that_holds_more_counts(upright, tmp_path):
    """By the levers: the motors hold 10 (x1 + (x1 + x)) of the bars, and 10 x a kilogram; the second one 10 (x - x1)."""
    box = [(-2.25, -2.25, -0.25), (2.25, 2.25, 0.25)]
    task = {"voxel": 0.5, "orientations": 1, "bounds": box, "task": "position", "link": "link3"}
    found = ulna.reachability_map(upright, tmp_path / "m.zarr", **task, keep_payload=True)
    data = found.data.sel(z=0.0).compute()
    for place in data.payload[..., 0].stack(p=("y", "x")):
        x, y = float(place.x), float(place.y)
        reach = np.hypot(x, y)
        if reach > 2.01:
            assert np.isnan(place.item())
        if not 0.2 < reach < 1.99:  # stretched the arm has one branch, and folded infinitely many
            continue
        masses = []
        for side in (1, -1):
            x1 = np.cos(np.arctan2(y, x) + side * np.arccos(reach / 2))
            own = np.array([10 * (x1 + x1 + x), 10 * (x - x1)])
            arm = np.array([10 * x, 10 * (x - x1)])
            room = np.array([60, 30]) - np.sign(arm) * own
            masses.append(0.0 if (np.abs(own) > [60, 30]).any() else (room / np.maximum(np.abs(arm), 1e-12)).min())
        assert place.item() == pytest.approx(max(masses), rel=2e-3)
    assert data.payload.attrs["units"] == "kg"
    assert found.attributes["payload_kept"] is True


def test_it_is_that_of_the_solution_where_only_one_is_known(panda, tmp_path):
    """The Panda is searched. In another gravity it is another, and the map knows how its robot is mounted."""
    box = {**SMALL, "bounds": [(0.2, -0.3, 0.1), (0.8, 0.3, 0.7)]}
    for robot in (panda, panda.with_gravity((9.81, 0, 0))):
        path = tmp_path / f"{robot.gravity[0]:.0f}.zarr"
        found = ulna.reachability_map(robot, path, **box, keep_payload=True, keep_solutions=True)
        reached = found.verdicts
        expected = robot.payload(np.clip(found.data.q.values[reached].astype(float), robot.lower, robot.upper))
        assert np.allclose(found.data.payload.values[reached], expected, rtol=1e-3, atol=1e-3)
        assert np.isnan(found.data.payload.values[~reached]).all()
        assert np.array_equal(found.robot.gravity, robot.gravity)
        assert ulna.ReachabilityMap.open(path, robot=robot).summary.reached == reached.sum()
    with pytest.raises(ulna.InputError, match="another robot"):
        ulna.ReachabilityMap.open(path, robot=panda)
    with pytest.raises(ulna.InputError, match="payload: True and False"):
        ulna.reachability_map(robot, path, **box, keep_solutions=True, resume=True)


def test_what_has_no_payload_is_refused_before_anything_is_written(planar, panda, tmp_path):
    with pytest.raises(ulna.InputError, match="no effort limit above 0 for joint1, joint2"):
        ulna.reachability_map(planar, tmp_path / "m.zarr", voxel=0.5, orientations=1, keep_payload=True)
    with pytest.raises(ulna.InertiaError, match="panda_link3"):
        ulna.reachability_map(panda.with_inertias({"panda_link3": None}), tmp_path / "m.zarr", **SMALL, keep_payload=True)
    with pytest.raises(ulna.InputError, match="keep_payload"):
        ulna.reachability_map(panda, tmp_path / "m.zarr", **SMALL, keep_payload="yes")
    assert list(tmp_path.iterdir()) == []


def test_masses_and_gravity_are_in_the_text_of_a_robot_that_is_weighed(panda):
    robot = panda.with_gravity((1, 2, 3)).with_attached("ball", ulna.Sphere(0.1), np.eye(4), mass=2.0)
    copy, q = robot_from_json(robot_to_json(robot, checked=False, weighed=True)), panda.random(20, seed=2)
    assert (copy.gravity_torque(q) == robot.gravity_torque(q)).all()
    lighter = robot.with_inertias({"panda_link3": ulna.Inertia(1.0, (0, 0, 0), np.eye(3))})
    assert robot_to_json(lighter, checked=True) == robot_to_json(robot.with_gravity((0, 0, 1)), checked=True)
    assert robot_to_json(lighter, checked=True, weighed=True) != robot_to_json(robot, checked=True, weighed=True)
