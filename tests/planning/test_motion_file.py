"""Motions from elsewhere: messages of ROS and plans of MoveIt as their tools print them, and tables with times."""

import json
import re

import numpy as np
import pytest
import yaml

import ulna
from ulna.arms import Recorder
from ulna.errors import DescriptionError, DescriptionWarning, FileError, InputError, UnitWarning

TIMES = np.array([0.0, 0.8, 1.5, 3.0])


def points_of(robot, n=4):
    rng = np.random.default_rng(0)
    q = robot.home + np.cumsum(rng.normal(size=(n, robot.n_dof)) * 0.1, axis=0)
    qd, qdd = rng.normal(size=(2, n, robot.n_dof)) * 0.1
    qd[[0, -1]] = qdd[[0, -1]] = 0.0
    return q, qd, qdd


def message(robot, kinds=3, order=None, ros=2, times=TIMES):
    """A JointTrajectory whose points state positions, then velocities, then accelerations."""
    order = np.arange(robot.n_dof) if order is None else np.asarray(order)
    keys = ("sec", "nanosec") if ros == 2 else ("secs", "nsecs")
    names, points = ("positions", "velocities", "accelerations", "effort"), []
    for k, t in enumerate(times):
        rows = [values[k, order].tolist() if i < kinds else [] for i, values in enumerate(points_of(robot, len(times)))]
        whole, part = divmod(round(t * 1e9), 10**9)
        points.append(
            {**dict(zip(names, [*rows, []], strict=True)), "time_from_start": dict(zip(keys, (whole, part), strict=True))}
        )
    header = {"stamp": dict.fromkeys(keys, 0), "frame_id": ""}
    return {"header": header, "joint_names": [robot.joint_names[k] for k in order], "points": points}


def moveit(inner):
    """A DisplayTrajectory of MoveIt."""
    others = {"header": {"frame_id": ""}, "joint_names": [], "points": []}
    plan = {"joint_trajectory": inner, "multi_dof_joint_trajectory": others}
    return {"model_id": "panda", "trajectory": [plan], "trajectory_start": {"joint_state": {"name": ["a"], "position": [0.0]}}}


def written(path, value):
    text = json.dumps(value) if path.suffix == ".json" else yaml.safe_dump(value, sort_keys=False) + "---\n"
    path.write_text(text, encoding="utf-8")
    return path


def polynomial(t0, t1, begin, end):
    """The polynomial in t - t0 of least degree with these derivatives at both ends, by solving for its coefficients."""
    n, rows, right = 2 * len(begin), [], []
    for t, values in ((0.0, begin), (t1 - t0, end)):
        for order, value in enumerate(values):
            powers = [np.prod(np.arange(k, k - order, -1)) * t ** max(k - order, 0) * (k >= order) for k in range(n)]
            rows.append(powers)
            right.append(value)
    return np.linalg.solve(np.array(rows, dtype=float), np.array(right))


@pytest.mark.parametrize("kinds", [1, 2, 3])
@pytest.mark.parametrize("form", ["echo.yaml", "message.json", "plan.yaml", "ros1.yml"])
def test_a_message_is_the_motion_that_ros2_control_makes_of_it(panda, tmp_path, form, kinds):
    order = np.random.default_rng(1).permutation(7)
    inner = message(panda, kinds, order, ros=1 if form.startswith("ros1") else 2)
    path = written(tmp_path / form, moveit(inner) if form.startswith("plan") else inner)
    motion = ulna.Trajectory.from_file(path, panda)
    rows = points_of(panda)[:kinds]
    assert np.allclose(motion.times, TIMES, atol=1e-12)
    assert np.allclose(motion.q, rows[0], atol=1e-12)
    for k in range(3):
        coefficients = polynomial(TIMES[k], TIMES[k + 1], *(np.stack([row[i] for row in rows]) for i in (k, k + 1)))
        t = np.linspace(TIMES[k] + 1e-6, TIMES[k + 1] - 1e-6, 50)
        expected, moment = coefficients, motion.at(t)
        for values in moment:
            powers = (t - TIMES[k])[:, None] ** np.arange(len(expected))
            assert np.allclose(values, powers @ expected, atol=1e-8)
            expected = np.arange(1, len(expected))[:, None] * expected[1:] if len(expected) > 1 else 0.0 * expected
    assert motion.limits_jerk is (kinds == 3)
    assert not motion.certified


def test_what_ulna_writes_is_read_as_the_same_motion_and_an_arm_runs_it(panda, tmp_path):
    motion = panda.plan(panda.home, panda.home + 0.3).trajectory(limits="franka")
    for period, near in ((None, 1e-12), (0.001, 1e-6)):
        motion.to_csv(tmp_path / "motion.csv", period=period)
        again = ulna.Trajectory.from_file(tmp_path / "motion.csv", panda)
        t = np.linspace(0, motion.duration, 2001)
        assert again.duration == motion.duration
        assert np.abs(again.at(t).q - motion.at(t).q).max() < near
        assert np.abs(again.at(t).qd - motion.at(t).qd).max() < 1e3 * near
        assert again.limits_jerk
    motion.to_csv(tmp_path / "motion.csv")
    again = ulna.Trajectory.from_file(tmp_path / "motion.csv", panda)
    assert again.check("franka")
    assert Recorder(panda.home).run(again).arrived


def test_what_is_written_as_json_is_the_message_and_is_read_as_the_same_motion(panda, tmp_path):
    motion = panda.plan(panda.home, panda.home + 0.3).trajectory(acceleration=3.0, jerk=30.0)
    back = panda.plan(panda.home + 0.3, panda.home).trajectory(acceleration=3.0)
    for one in (motion, back, motion.then(back)):
        one.to_json(tmp_path / "motion.json", period=0.005)
        again = panda.motion_from_file(tmp_path / "motion.json")
        t = np.linspace(0.0, one.duration, 300)
        assert again.duration == pytest.approx(one.duration, abs=1e-9)
        np.testing.assert_allclose(again.at(t).q, one.at(t).q, atol=1e-4)
        assert json.loads((tmp_path / "motion.json").read_text())["joint_names"] == list(panda.joint_names)
    with pytest.raises(FileError, match="no such folder"):
        motion.to_json(tmp_path / "none" / "motion.json")
    with pytest.raises(InputError, match="period"):
        motion.to_json(tmp_path / "motion.json", period=0.0)


def test_a_table_states_its_units_and_velocities_count_where_all_joints_have_them(panda, tmp_path):
    q, qd, _ = points_of(panda)
    names = panda.joint_names

    def read(header, rows):
        (tmp_path / "a.csv").write_text("\n".join([",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]))
        return ulna.Trajectory.from_file(tmp_path / "a.csv", panda)

    whole = read(["t", *names, *(f"{name}_velocity" for name in names)], np.column_stack([TIMES, q, qd]))
    same = read(
        ["time [ms]", *(f"{name} [deg]" for name in names), *(f"velocity_{name} [deg/s]" for name in names)],
        np.column_stack([1e3 * TIMES, np.rad2deg(q), np.rad2deg(qd)]),
    )
    t = np.linspace(0, 3, 100)
    assert np.allclose(whole.at(t).q, same.at(t).q, atol=1e-12)
    numbered = read(
        ["time_s", *(f"q{k}" for k in range(1, 8)), *(f"qd{k}" for k in range(1, 8))], np.column_stack([TIMES, q, qd])
    )
    assert np.allclose(whole.at(t).q, numbered.at(t).q, atol=1e-12)
    line = read(["time", *names, f"velocity_{names[0]}"], np.column_stack([TIMES, q, qd[:, 0]]))
    assert np.allclose(line.at(t).q, np.stack([np.interp(t, TIMES, column) for column in q.T], axis=1), atol=1e-12)
    with pytest.raises(InputError, match=r"states a unit, but 'velocity of panda_joint1' states none"):
        read(
            ["t", *(f"{name} [deg]" for name in names), *(f"velocity_{name}" for name in names)], np.column_stack([TIMES, q, qd])
        )
    (tmp_path / "comma.csv").write_text('"a, b",time\n0.1,0\n0.2,1\n')
    named = ulna.load(ONE_JOINT.format(name="a, b"))
    assert ulna.Trajectory.from_file(tmp_path / "comma.csv", named).q.tolist() == [[0.1], [0.2]]


ONE_JOINT = """<robot name="one"><link name="base"/><link name="tip"/><joint name="{name}" type="revolute"><parent link="base"/>
<child link="tip"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


def test_it_is_checked_judged_slowed_and_timed_anew(panda, tmp_path):
    motion = ulna.Trajectory.from_file(written(tmp_path / "a.yaml", message(panda, 2)), panda)
    assert motion.check()
    assert motion.check(acceleration=100.0)
    assert not motion.check(acceleration=0.1)
    world = ulna.World()
    assert motion.is_free(world)
    world.add("there", ulna.Sphere(0.01), ulna.pose(panda.forward_kinematics(motion.at(0.0).q)[:3, 3]))
    assert not motion.is_free(world)
    assert motion.is_free(world, since=2.9)
    far = motion.at(np.linspace(0, 3, 100_001)).q
    assert np.allclose(motion._timed.farthest(0.0).q, [far.min(axis=0), far.max(axis=0)], atol=1e-8)
    late = far[50_000:]
    assert np.allclose(motion._timed.farthest(1.5).q, [late.min(axis=0), late.max(axis=0)], atol=1e-8)
    assert np.allclose(motion.slowed(0.5).at(2.0).q, motion.at(1.0).q)
    anew = panda.trajectory(motion, within=0.001, limits="franka", hand=ulna.HandLimits(speed=0.25))
    assert anew.check("franka")
    apart = np.abs(anew.at(np.linspace(0, anew.duration, 500)).q[:, None] - far[::50][None]).max(axis=2).min(axis=1)
    assert apart.max() < 0.003
    with pytest.raises(InputError, match=r"a motion from a file cannot be replaced; robot\.trajectory\(motion"):
        motion.replace(panda.plan(motion.at(1).q, panda.home), at=1.0)


def test_joints_that_it_does_not_name_are_refused_unless_the_caller_says_where_they_are(panda, tmp_path):
    part = message(panda, 2, [4, 0, 6])
    path = written(tmp_path / "part.yaml", part)
    with pytest.raises(DescriptionError, match=r"has no positions of panda_joint2, .*panda_joint6; give them with others=q"):
        ulna.Trajectory.from_file(path, panda)
    motion = panda.motion_from_file(path, others=panda.home)
    assert np.array_equal(motion.q[:, [1, 2, 3, 5]], np.tile(panda.home[[1, 2, 3, 5]], (4, 1)))
    assert np.allclose(motion.q[:, [4, 0, 6]], points_of(panda)[0][:, [4, 0, 6]])
    more = message(panda, 2)
    more["joint_names"].append("gripper")
    for point in more["points"]:
        point["positions"].append(0.02)
        point["velocities"].append(0.0)
    with pytest.warns(DescriptionWarning, match="gripper: the robot has no such joint"):
        again = ulna.Trajectory.from_file(written(tmp_path / "more.yaml", more), panda)
    assert np.allclose(again.q, points_of(panda)[0], atol=1e-12)


def test_a_joint_that_follows_another_one_is_not_read_and_a_file_without_the_robots_joints_is_refused(panda, tmp_path):
    part = {"joint_names": ["a", "b"], "points": [{"positions": [0.1, -0.2], "time_from_start": {"sec": 0}}]}
    path = written(tmp_path / "other.json", part)
    with pytest.raises(DescriptionError, match=r"has none of the joints panda_joint1, .*; it has a, b"):
        ulna.Trajectory.from_file(path, panda)
    follower = '<link name="end"/><joint name="b" type="revolute"><parent link="tip"/><child link="end"/><axis xyz="0 0 1"/>'
    follower += '<limit lower="-2" upper="2" velocity="1" effort="1"/><mimic joint="a" multiplier="-2"/></joint></robot>'
    robot = ulna.load(ONE_JOINT.format(name="a").replace("</robot>", follower))
    assert ulna.Trajectory.from_file(path, robot).q.tolist() == [[0.1]]


def test_one_point_is_a_motion_that_rests(panda, tmp_path):
    motion = ulna.Trajectory.from_file(written(tmp_path / "one.json", message(panda, 3, times=np.zeros(1))), panda)
    assert motion.duration == 0
    assert motion.check()


def test_a_first_point_that_comes_later_begins_the_motion(panda, tmp_path):
    motion = ulna.Trajectory.from_file(written(tmp_path / "late.json", message(panda, 2, times=TIMES + 5.0)), panda)
    assert np.allclose(motion.times, TIMES, atol=1e-12)


def test_degrees_get_a_hint(panda, tmp_path):
    inner = message(panda, 1)
    for point in inner["points"]:
        point["positions"] = np.rad2deg(point["positions"]).tolist()
    with pytest.warns(UnitWarning, match="are these degrees"):
        motion = ulna.Trajectory.from_file(written(tmp_path / "degrees.yaml", inner), panda)
    assert not motion.check()


def changed(change):
    """A message of one joint, changed."""
    point = {"positions": [0.1], "velocities": [0.0], "time_from_start": {"sec": 0, "nanosec": 0}}
    later = {"positions": [0.2], "velocities": [0.0], "time_from_start": {"sec": 1, "nanosec": 0}}
    value = {"joint_names": ["a"], "points": [point, later]}
    change(value)
    return value


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda it: it["points"][1].update(time_from_start={"sec": 0}), "point 1 is not later than the point before"),
        (lambda it: it["points"][1].update(time_from_start={"sec": 9000}), "are these milliseconds"),
        (lambda it: it["points"][1].update(time_from_start={}), "point 1: time_from_start is {}; sec and nanosec are expected"),
        (lambda it: it["points"][1].pop("time_from_start"), "point 1: time_from_start has None"),
        (lambda it: it["points"][1].update(positions=[]), "point 1 has no positions"),
        (lambda it: it["points"][1].update(positions=[0.1, 0.2]), "point 1: positions has 2 numbers, and there are 1 joint name"),
        (lambda it: it["points"][1].update(positions=[float("nan")]), "point 1: positions has nan; a finite number"),
        (lambda it: it["points"][1].update(velocities=[float("inf")]), "point 1: velocities has inf; a finite number"),
        (lambda it: it["points"][1].update(positions=[True]), "point 1: positions has True"),
        (lambda it: it["points"][1].update(positions=["0.1"]), "point 1: positions has '0.1'"),
        (lambda it: it["points"][1].update(positions=[0.1, "..."]), "--full-length"),
        (lambda it: it["points"][1].update(positions=0.1), "point 1: positions is 0.1; a list of numbers"),
        (lambda it: it.update(points=[]), "points is []; a list of at least one point"),
        (lambda it: it["points"].append(3), "point 2 is 3; a mapping with positions"),
        (lambda it: it.update(joint_names=[]), "joint_names is []; a list of names"),
        (lambda it: it.update(joint_names=["a", "a"]), "joint_names has 'a' twice"),
        (lambda it: it.pop("points"), "has no message with joint_names and points"),
    ],
)
@pytest.mark.parametrize("ending", ["yaml", "json"])
def test_a_message_that_is_not_whole_is_refused_by_its_file_and_point(tmp_path, change, said, ending):
    path = written(tmp_path / f"a.{ending}", changed(change))
    with pytest.raises(DescriptionError, match=re.escape(said)) as error:
        ulna.Trajectory.from_file(path, ulna.load(ONE_JOINT.format(name="a")))
    assert str(error.value).startswith(str(path))


def test_what_holds_no_one_trajectory_is_refused(panda, tmp_path):
    one = message(panda, 1)
    for value, said in (
        ({"trajectory": [{"joint_trajectory": one}, {"joint_trajectory": one}]}, "has 2 trajectories; keep one"),
        ({"path": [[0.0] * 7], "duration": 1.0}, "robot.trajectory(path, ...) gives times"),
        ({"multi_dof_joint_trajectory": {"joint_names": ["a"], "points": [{"transforms": []}]}}, "which are poses"),
        ([], "has no message"),
    ):
        with pytest.raises(DescriptionError, match=re.escape(said)):
            ulna.Trajectory.from_file(written(tmp_path / "a.json", value), panda)
    path = tmp_path / "two.yaml"
    path.write_text(yaml.safe_dump(one) + "---\n" + yaml.safe_dump(one), encoding="utf-8")
    with pytest.raises(DescriptionError, match="2 messages, between lines of ---; keep one"):
        ulna.Trajectory.from_file(path, panda)
    with pytest.raises(FileError, match="no such file"):
        ulna.Trajectory.from_file(tmp_path / "none.yaml", panda)
    with pytest.raises(InputError, match="path: 3"):
        ulna.Trajectory.from_file(3, panda)  # pyright: ignore[reportArgumentType]


ALIASES = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("aliases.yaml", ALIASES),
        ("sixty.yaml", "joint_names: [a]\npoints: [" + "1:" * 100_000 + "1]\n"),
        ("values.yaml", "joint_names: [a]\npoints: [" + "0, " * 300_000 + "0]\n"),
        ("deep.yaml", "[" * 100_000),
        ("deep.json", "[" * 100_000),
        ("digits.yaml", "joint_names: [a]\npoints: [{positions: [" + "9" * 500_000 + "], time_from_start: 0}]\n"),
        ("digits.json", '{"joint_names": ["a"], "points": [{"positions": [' + "9" * 4000 + '], "time_from_start": 0}]}'),
        ("names.json", json.dumps({"joint_names": ["a" * 100] * 10_000, "points": [{}]})),
        ("tag.yaml", "!!python/object/apply:os.system [echo]\n"),
        ("zeros.json", "\0" * 1_000_000),
        ("long.csv", "time,a\n" + "0" * 1_000_000),
        ("nan.csv", "time,a\n0,0\n1,nan\n"),
        ("back.csv", "time,a\n1,0\n0,0\n"),
        ("no_positions.csv", "time,velocity_a\n0,0\n1,0\n"),
        ("lies.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 8), }" + b" " * 20),
    ],
)
def test_a_strangers_file_is_refused_in_few_words(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    robot = ulna.load(ONE_JOINT.format(name="a"))
    with pytest.raises((DescriptionError, FileError, InputError)) as error:
        ulna.Trajectory.from_file(path, robot)
    assert name in str(error.value)
    assert len(str(error.value)) < 600
