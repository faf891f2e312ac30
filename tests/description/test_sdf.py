"""SDF against the frames, axes and limits that libsdformat resolves: ``sdf/judged.json``, which ``sdf/judge.cpp`` printed."""

import json
from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna.description.robot_description import JointType
from ulna.inspection.result import NOTE

FOLDER = Path(__file__).parent / "sdf"
JUDGED = json.loads((FOLDER / "judged.json").read_text().replace('"arm_joint"', '"arm"'))  # a joint called as a link is renamed there
FILES = [name for name in JUDGED if name != "libsdformat"]
LIMIT = 1e-12
pytestmark = pytest.mark.filterwarnings("ignore:.*is static, and not the robot")
PRISMATIC, REVOLUTE, CONTINUOUS, FIXED = 5, 6, 2, 3  # of libsdformat's enum JointType


def moved(joint, q):
    """The motion of a joint in its frame, by the exponential of its axis."""
    T, axis = np.eye(4), np.array(joint["axis"])
    if joint["type"] == PRISMATIC:
        T[:3, 3] = q * axis
    else:
        K = np.cross(np.eye(3), axis)
        T[:3, :3] += np.sin(q) * K + (1 - np.cos(q)) * K @ K
    return T


def judged_poses(judged, q):
    """The pose of each link and frame where each joint is at its entry of q."""
    zero = {name: np.array(T) for name, T in judged["links"].items()} | {"world": np.eye(4)}
    carriers = {joint["child"]: (name, joint) for name, joint in judged["joints"].items()}

    def pose(link):
        if link not in carriers:
            return zero[link]
        name, joint = carriers[link]
        J, parent = np.array(joint["pose"]), joint["parent"]
        motion = moved(joint, q[name]) if "axis" in joint else np.eye(4)
        return pose(parent) @ np.linalg.inv(zero[parent]) @ J @ motion @ np.linalg.inv(J) @ zero[link]

    frames = {
        name: pose(one["body"]) @ np.linalg.inv(zero[one["body"]]) @ np.array(one["pose"]) for name, one in judged["frames"].items()
    }
    return {name: pose(name) for name in judged["links"]} | frames


@pytest.mark.parametrize("file", FILES)
def test_every_link_and_frame_is_where_libsdformat_has_it(file):
    robot, judged = ulna.load(FOLDER / file), JUDGED[file]
    for q in robot.random(20, seed=1):
        poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
        for name, T in judged_poses(judged, dict(zip(robot.joint_names, q, strict=True))).items():
            assert np.abs(poses.pop(name) - T).max() < LIMIT, name
        assert all(name == "world" or "_at_" in name for name in poses)


@pytest.mark.parametrize("file", FILES)
def test_every_shape_is_where_libsdformat_has_it(file):
    found = {
        f"{link.name}/{body.name}": body.pose
        for link in ulna.load(FOLDER / file).description.links
        for body in (*link.visuals, *link.collisions)
    }
    assert found.keys() == JUDGED[file]["shapes"].keys()
    assert all(np.abs(found[name] - np.array(T)).max() < LIMIT for name, T in JUDGED[file]["shapes"].items())


@pytest.mark.parametrize("file", FILES)
def test_types_and_limits_are_libsdformats(file):
    joints = {joint.name: joint for joint in ulna.load(FOLDER / file).description.joints}
    for name, judged in JUDGED[file]["joints"].items():
        joint = joints[name]
        if judged["type"] == FIXED:
            assert joint.type == JointType.FIXED
            continue
        judge = {key: judged[key] if abs(judged[key]) < 1e16 else np.copysign(np.inf, judged[key]) for key in ("lower", "upper")}
        is_endless = judged["type"] == CONTINUOUS or (judged["type"] == REVOLUTE and np.isinf([*judge.values()]).all())
        expected = JointType.CONTINUOUS if is_endless else JointType.PRISMATIC if judged["type"] == PRISMATIC else JointType.REVOLUTE
        assert joint.type == expected
        assert (joint.limits.lower, joint.limits.upper) == ((-np.inf, np.inf) if is_endless else (judge["lower"], judge["upper"]))
        for mine, its in ((joint.limits.effort, judged["effort"]), (joint.limits.velocity, judged["velocity"])):
            assert mine == (its if 0 <= its < 1e16 else np.inf)
