"""``ulna follow``: poses in, joint positions out."""

import numpy as np
import pytest

import ulna
from ulna.cli.follow import draw_joints
from ulna.cli.rows import read_poses
from ulna.description.controllers import controller_named
from ulna.ik.followed_path import FollowedPath
from ulna.ik.reason import NO_REASON
from ulna.ik.solutions import Proof

N = 40


@pytest.fixture
def line(panda, tmp_path):
    """Poses of the Panda on a line, and the file of them."""
    T = np.repeat(panda.forward_kinematics(panda.home)[None], N, axis=0)
    T[:, :3, 3] = [0.45, 0.0, 0.5]
    T[:, 1, 3] = np.linspace(-0.2, 0.2, N)
    np.save(tmp_path / "line.npy", T)
    return T, tmp_path / "line.npy"


def quaternions(T):
    return np.array([ulna.description.pose.quaternion_from_matrix(R) for R in T[:, :3, :3]])


def angles(T):
    return np.array([ulna.description.pose.rpy_from_matrix(R) for R in T[:, :3, :3]])


def test_the_rows_written_reach_the_poses(panda, line, tmp_path, run):
    T, path = line
    done = run("follow", "panda", "--path", str(path), "--csv", str(tmp_path / "q.csv"))
    assert done.exit_code == 0, done.output
    assert "followed: 40 poses" in done.stdout
    names, *rows = (tmp_path / "q.csv").read_text().splitlines()
    assert names.split(",") == list(panda.joint_names)
    q = np.array([[float(word) for word in row.split(",")] for row in rows])
    assert np.abs(panda.forward_kinematics(q) - T).max() < 3e-5
    assert np.abs(np.diff(q, axis=0)).max() <= 0.1


@pytest.mark.parametrize("form", ["rpy", "quaternion", "three rows", "four rows"])
def test_poses_may_be_written_in_any_form(line, tmp_path, ask, form):
    T, path = line
    rows = {
        "rpy": lambda: np.hstack([T[:, :3, 3], angles(T)]),
        "quaternion": lambda: np.hstack([T[:, :3, 3], quaternions(T)]),
        "three rows": lambda: T[:, :3].reshape(N, 12),
        "four rows": lambda: T.reshape(N, 16),
    }[form]()
    file = tmp_path / "poses.csv"
    file.write_text("# a line that names no column\n" + "\n".join(", ".join(map(repr, row.tolist())) for row in rows) + "\n")
    data = ask("follow", "panda", "--path", str(file))
    assert data.success
    assert np.abs(np.array(data.q) - np.array(ask("follow", "panda", "--path", str(path)).q)).max() < 1e-6


def test_where_none_leads_on_the_status_is_one_and_the_rows_end(line, tmp_path, run):
    T, path = line
    T = T.copy()
    T[30:, 0, 3] = 3.0
    np.save(path, T)
    done = run("follow", "panda", "--path", str(path), "--csv", str(tmp_path / "q.csv"))
    assert done.exit_code == 1
    assert "unreachable at pose 30 of 40" in " ".join(done.stdout.split())
    assert len((tmp_path / "q.csv").read_text().splitlines()) == 31


def test_the_turn_about_the_tool_may_be_free(line, ask, panda):
    T, path = line
    data = ask("follow", "panda", "--path", str(path), "--task", "pointing")
    assert data.success
    assert data.task == "pointing"
    hand = panda.forward_kinematics(np.array(data.q))
    assert np.abs(hand[:, :3, 2:] - T[:, :3, 2:]).max() < 3e-5
    assert np.abs(hand - T).max() > 1e-3


def test_the_joints_are_drawn(line, tmp_path, run):
    pytest.importorskip("matplotlib")
    _, path = line
    assert run("follow", "panda", "--path", str(path), "--plot", str(tmp_path / "q.svg")).exit_code == 0
    text = (tmp_path / "q.svg").read_text()
    assert text.startswith("<?xml")
    assert "</svg>" in text


def test_each_joint_is_drawn_at_the_scale_of_its_path_in_its_unit():
    pytest.importorskip("matplotlib")
    rows, limits = [(0, 0, 0, 0), (0, 0, np.pi / 2, 0)], [(-1.0, 1.0), (-3.0, 3.0)]
    robot = ulna.Robot.from_dh(rows, joint_types=["prismatic", "revolute"], limits=limits)
    q = np.column_stack([np.linspace(0.95, 1.0, 30), np.linspace(0.1, 0.3, 30)])  # the slide ends at its limit
    path = FollowedPath(q, None, 0.1, None, NO_REASON, Proof.COMPLETE, robot.joint_names)
    *joints, steps = draw_joints(robot, path).axes
    slide, turn = robot.joint_names
    assert [axes.get_ylabel() for axes in joints] == [f"{slide} [m]", f"{turn} [rad]"]
    assert (steps.get_ylabel(), steps.get_xlabel()) == ("largest step [m or rad]", "pose")
    for axes, column in zip(joints, q.T, strict=True):
        assert np.array_equal(axes.lines[0].get_ydata(), column)
        assert np.ptp(axes.get_ylim()) < 3 * np.ptp(column)  # scaled to the limits it would be flat
    assert [line.get_ydata()[0] for line in joints[0].lines[1:]] == [1.0]  # the limit that is near
    assert not joints[1].lines[1:]


def test_boxes_are_obstacles_and_a_start_is_where_the_arm_is_before(line, ask):
    _, path = line
    free = ask("follow", "--path", path, "--from", "home", "--max-step", "1.6")
    assert free.success
    blocked = ask("follow", "--path", path, "--box", "0.45,0.15,0.5,0,0,0,0.1,0.1,0.1")
    assert (blocked.success, blocked.exit_code) == (False, 1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("1,2\n", "--path: poses.csv has shape (1, 2); rows of 6, 7, 12 or 16 numbers are expected"),
        ("", "--path: poses.csv has no row of numbers"),
        ("0,0,O,0,0,0\n", "--path: poses.csv:1: '0,0,O,0,0,0' is not a row of numbers"),
        ("x,y,z,roll,pitch,yaw\n", "--path: poses.csv has no row of numbers"),
        ("0,0,0,0,0,inf\n", "--path: poses.csv: row 0 is not finite"),
        ("1,2,3\n4,5\n", "--path: poses.csv:2: 2 numbers, but 3 in the row before"),
    ],
)
def test_a_file_that_holds_no_poses_is_refused(tmp_path, refusal, content, message):
    file = tmp_path / "poses.csv"
    file.write_text(content)
    assert message in refusal("follow", "panda", "--path", str(file))


HEADS = {"no names": "", "another order": "C,B,A,X,Y,Z", "units": "X [m],Y [m],Z [m],A [rad],B [rad],C [rad]"}


@pytest.mark.parametrize("head", HEADS.values(), ids=list(HEADS))
def test_rows_of_a_controller_are_in_its_units_and_under_its_labels(line, tmp_path, head):
    T, _ = line
    numbers = ulna.pose_as(T, "KUKA")
    if "C,B" in head:
        numbers = numbers[:, [5, 4, 3, 0, 1, 2]]
    elif head:
        numbers = np.hstack([numbers[:, :3] / 1000, np.radians(numbers[:, 3:])])
    np.savetxt(tmp_path / "rows.csv", numbers, delimiter=",", header=head, comments="", fmt="%.17g")
    if not head:
        (tmp_path / "rows.csv").write_text((tmp_path / "rows.csv").read_text().lstrip("\n"))
    poses = read_poses(tmp_path / "rows.csv", controller_named("KUKA"))
    np.testing.assert_allclose(poses, T, rtol=0, atol=1e-12)
    np.save(tmp_path / "rows.npy", ulna.pose_as(T, "ABB"))
    np.testing.assert_allclose(read_poses(tmp_path / "rows.npy", controller_named("ABB")), T, rtol=0, atol=1e-12)
