"""Rows of joint positions, motions and poses from files: columns by their names, in the units that they state."""

import numpy as np
import pytest

import ulna
from ulna.cli.rows import read_motion, read_poses, read_trajectory
from ulna.description.file_bytes import write_table

Q = np.array([[0.1, -0.2, 0.3, -1.5, 0.5, 1.6, 0.7], [0.2, -0.3, 0.4, -1.6, 0.6, 1.7, 0.8]])
QUARTER = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])  # a quarter turn about z at (1, 2, 3)


@pytest.fixture
def read(tmp_path):
    """A function that reads the text of a table by one of the readers."""

    def read(reader, names, rows, *robot):
        path = tmp_path / "rows.csv"
        lines = [names] if isinstance(names, str) else [",".join(names)]
        path.write_text("\n".join([*lines, *(",".join(map(str, row)) for row in rows)]) + "\n", encoding="utf-8")
        return reader(path, *robot)

    return read


@pytest.mark.parametrize(
    ("write", "factor"),
    [
        ("{}", 1.0),
        ("{} [rad]", 1.0),
        ("{} (deg)", np.rad2deg(1.0)),
        ("{}_deg", np.rad2deg(1.0)),
        ("/joint_states/{}/position", 1.0),
        ("position_{}", 1.0),
    ],
)
def test_joints_are_found_by_their_names_in_any_order(panda, read, rng, write, factor):
    order = rng.permutation(7)
    names = [write.format(panda.joint_names[k]) for k in order]
    assert np.allclose(read(read_trajectory, names, Q[:, order] * factor, panda), Q, atol=1e-15)
    beside = ["time", *names, f"velocity_{panda.joint_names[0]}", "effort"]
    rows = np.column_stack([[5, 6], Q[:, order] * factor, [7, 8], [9, 9]])
    assert np.allclose(read(read_trajectory, beside, rows, panda), Q, atol=1e-15)
    duration, even = read(read_motion, beside, rows, panda)
    assert duration == 1
    assert np.allclose(even[[0, -1]], Q, atol=1e-15)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("word", ["q{}", "joint_{}", "J{}"])
def test_numbered_joints_are_the_entries_of_q(panda, read, word, first):
    order = [3, 1, 0, 2, 6, 5, 4]
    assert np.array_equal(read(read_trajectory, [word.format(k + first) for k in order], Q[:, order], panda), Q)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda names: [*names[:6], "wrist"], "no column is named panda_joint7"),
        (lambda names: [*names[:6], names[0]], "both panda_joint1"),
        (lambda _: list("abcdefg"), "the names are 'a', 'b', 'c'"),
        (lambda _: [f"q{k}" for k in range(2, 9)], "numbered, but not from 0 or from 1 as 7 joints"),
        (lambda names: [f"{names[0]} [mm]", *names[1:]], "is not known; of panda_joint1 it may be rad"),
        (lambda names: [*names[:6], "q7"], "some columns have the names of joints, others numbers"),
    ],
)
def test_names_that_are_not_those_of_the_joints_are_refused(panda, read, change, message):
    with pytest.raises(ulna.InputError, match=message):
        read(read_trajectory, change(list(panda.joint_names)), Q, panda)


def test_a_follower_may_have_a_column_and_another_robots_joint_may_not(read):
    robot = ulna.load("panda")
    names = [*robot.joint_names, "wheel"]
    with pytest.raises(ulna.InputError, match="'wheel' is unknown among panda_joint1"):
        read(read_trajectory, names, np.column_stack([Q, [0, 0]]), robot)
    fixed = next(joint.name for joint in robot.description.joints if joint.name not in robot.joint_names)
    assert np.array_equal(read(read_trajectory, [*robot.joint_names, fixed], np.column_stack([Q, [0, 0]]), robot), Q)


def test_the_time_of_a_motion_has_its_unit(panda, read):
    for time, factor in (("time [ms]", 1e3), ("t (s)", 1.0), ("%time", 1e9)):
        duration, _ = read(read_motion, [*panda.joint_names, time], np.column_stack([Q, [0, int(2 * factor)]]), panda)
        assert duration == pytest.approx(2)
    with pytest.raises(ulna.InputError, match="no column is named time"):
        read(read_motion, panda.joint_names, Q, panda)


ROS = "field.pose.position.{0},field.pose.position.{1},field.pose.position.{2}"


@pytest.mark.parametrize(
    ("names", "row"),
    [
        ("x,y,z,qx,qy,qz,qw", (1, 2, 3, 0, 0, 1, 1)),
        ("x,y,z,qw,qx,qy,qz", (1, 2, 3, 1, 0, 0, 1)),
        ("# timestamp tx ty tz qx qy qz qw", (9, 1, 2, 3, 0, 0, 1, 1)),
        (
            "%time,field.header.seq," + ROS.format(*"xyz") + "".join(f",field.pose.orientation.{x}" for x in "xyzw"),
            (9, 0, 1, 2, 3, 0, 0, 1, 1),
        ),
        ("x,y,z,roll_deg,pitch_deg,yaw_deg", (1, 2, 3, 0, 0, 90)),
        ("x [mm],y [mm],z [mm],Roll [\u00b0],Pitch [\u00b0],Yaw [\u00b0]", (1000, 2000, 3000, 0, 0, 90)),
        ("yaw,pitch,roll,z,y,x", (np.pi / 2, 0, 0, 3, 2, 1)),
        ("r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z", (0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3)),
        ("m00,m10,m20,m01,m11,m21,m02,m12,m22,m03,m13,m23", (0, 1, 0, -1, 0, 0, 0, 0, 1, 1, 2, 3)),
        ("# 12 numbers", (0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3)),
    ],
)
def test_a_pose_is_that_of_the_names_whatever_their_order_and_unit(read, names, row):
    assert np.abs(read(read_poses, names, [row]) - QUARTER).max() < 1e-15


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ("x,y,z,rx,ry,rz", "give no orientation; roll, pitch, yaw or qw, qx, qy, qz"),
        ("x,y,z,w,x,y,z", "are both x"),
        ("x,y,z,qx,qy,qz", "no column is named qw"),
        ("x,y,z,roll,pitch,yaw,qw", "the orientation in two ways"),
        ("x,y,z,roll,pitch,yaw,force", "'force' is unknown among x, y, z, roll"),
        ("x [deg],y,z,roll,pitch,yaw", "of x it may be m"),
    ],
)
def test_names_that_are_not_of_a_pose_are_refused(read, names, message):
    with pytest.raises(ulna.InputError, match=message):
        read(read_poses, names, [range(1, 2 + names.count(","))])


def test_records_of_numpy_are_read_by_the_names_of_their_fields(panda, tmp_path):
    records = np.zeros(2, dtype=[(name, float) for name in panda.joint_names[::-1]])
    for name, column in zip(panda.joint_names, Q.T, strict=True):
        records[name] = column
    np.save(tmp_path / "rows.npy", records)
    assert np.array_equal(read_trajectory(tmp_path / "rows.npy", panda), Q)


def test_a_table_that_is_written_is_read_whatever_its_names(tmp_path):
    joints = ["left, upper", 'the "hand"', "third joint"]
    text = '<robot name="r"><link name="0"/>' + "".join(
        f"<link name='{k + 1}'/><joint name='{name}' type='continuous'><parent link='{k}'/><child link='{k + 1}'/></joint>"
        for k, name in enumerate(joints)
    )
    robot = ulna.load(text + "</robot>")
    rows = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    write_table(tmp_path / "rows.csv", robot.joint_names[::-1], rows[:, ::-1])
    assert np.array_equal(read_trajectory(tmp_path / "rows.csv", robot), rows)
