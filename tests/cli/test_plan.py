"""``ulna plan``: what it prints and writes, and its exit status."""

import json
import re

import numpy as np
import pytest

import ulna

RIGHT = "-1,-pi/4,0,-3pi/4,0,pi/2,pi/4"
LEFT = "1,-pi/4,0,-3pi/4,0,pi/2,pi/4"
WEAK = "8,60,8,45,8,14,3"  # Nm


@pytest.fixture
def scene(tmp_path):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    ulna.save_world(world, tmp_path / "cell.json")
    return str(tmp_path / "cell.json")


def test_a_plan_is_printed_and_its_motion_written(run, scene, tmp_path):
    result = run("plan", "--from", LEFT, "--to", RIGHT, "--scene", scene, "--csv", str(tmp_path / "motion.csv"))
    assert result.exit_code == 0, result.output
    assert "certified free" in result.output
    rows = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert rows.shape[1] == 22
    assert np.allclose(rows[0, 1:8], [1, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
    panda = ulna.load("panda")
    assert not panda.in_collision(np.ascontiguousarray(rows[:, 1:8]), ulna.load_world(scene)).any()


def test_json_has_the_path_and_why_there_is_none(run, scene):
    found = json.loads(run("plan", "--from", LEFT, "--to", RIGHT, "--scene", scene, "--json").stdout)
    assert found["success"]
    assert np.array(found["path"]).shape[1] == 7
    assert found["duration"] > 0
    result = run("plan", "--from", LEFT, "--xyz", "3,0,0", "--scene", scene, "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["status"] == "goal unreachable"


def test_a_terminal_shows_the_time_and_the_checked_edges_of_a_search_and_a_pipe_nothing(run, scene):
    motion = "plan", "--from", LEFT, "--to", RIGHT, "--scene", scene
    run(*motion)  # what is compiled is said now
    piped = run(*motion)
    shown = run(*motion, FORCE_COLOR="1", TERM="xterm")  # rich takes standard error for a terminal then
    assert piped.stderr == ""
    assert re.search(r"planning .*0:00:\d\d.* [1-9]\d* edges checked", shown.stderr)
    assert "certified free" in piped.stdout
    assert "certified free" in shown.stdout


def test_a_motion_keeps_torques_with_what_the_arm_holds_as_it_is_mounted(run):
    motion = "plan", "--to", LEFT, "--acceleration", "15"
    part = "--payload", "3kg@0,0,0.1"
    free, limited, held = (
        json.loads(run(*motion, "--json", *more).stdout) for more in ((), ("--effort", WEAK), ("--effort", WEAK, *part))
    )
    assert "torque" not in free["check"]
    assert free["duration"] < limited["duration"] < held["duration"]
    assert all("the torque of panda_joint" in one["check"] for one in (limited, held))
    on_wall = run(*motion, "--effort", WEAK, *part, "--mount", "wall")
    assert on_wall.exit_code == 2
    assert "panda_joint1 needs" in on_wall.stderr
    panda = ulna.load("panda").with_attached(
        "part", ulna.Sphere(0.0), ulna.pose((0, 0, 0.1)), mass=3.0, touch_links=["panda_link8"]
    )
    peer = panda.plan(panda.home, held["path"][-1]).trajectory(acceleration=15.0, torque=[float(x) for x in WEAK.split(",")])
    assert held["duration"] == pytest.approx(peer.duration, rel=1e-6)


def test_loads_without_a_limit_of_torque_are_refused(run):
    for more in (("--payload", "3"), ("--mount", "wall"), ("--gravity", "0,0,-3")):
        result = run("plan", "--to", LEFT, *more)
        assert result.exit_code == 2
        assert "--torque or --effort" in result.stderr
    result = run("plan", "--to", LEFT, "--torque", "--payload", "30kg@0,0,0.1")
    assert result.exit_code == 2
    assert re.search(r"--torque: panda_joint\d needs .* to hold the robot still", result.stderr)


def test_one_goal_is_expected(run):
    assert run("plan").exit_code == 2
    assert run("plan", "--to", RIGHT, "--xyz", "0.4,0,0.4").exit_code == 2
    assert run("plan", "--goal", "panda_ee=0.4,0,0.4", "--xyz", "0.4,0,0.4").exit_code == 2


def test_a_plan_goes_home_and_around_a_box(ask):
    box = "0.35,0,0.6,0,0,0,0.1,0.1,1.6"
    around = ask("plan", "--from", LEFT, "--to", RIGHT, "--box", box)
    straight = ask("plan", "--from", LEFT, "--to", RIGHT)
    assert around.success
    assert around.length > straight.length
    assert ask("plan", "--from", LEFT, "--to", "home").path[-1] == ask("fk").q


def test_a_plan_to_a_quaternion_is_one_to_the_same_roll_pitch_and_yaw(ask):
    by_wxyz = ask("plan", "--xyz", "0.4,0.1,0.5", "--wxyz", "0,1,1,0")
    by_rpy = ask("plan", "--xyz", "0.4,0.1,0.5", "--rpy", "pi,0,pi/2")
    assert by_wxyz.success
    assert np.allclose(by_wxyz.path, by_rpy.path)


def test_limits_of_velocity_and_jerk_make_a_motion_slower(ask, run, tmp_path):
    motion = "plan", "--from", LEFT, "--to", RIGHT
    least = ask(*motion).duration
    assert ask(*motion, "--velocity", "9").duration == least  # its own limits are less
    assert ask(*motion, "--velocity", "0.5").duration > least
    assert ask(*motion, "--jerk", "20").duration > least
    run(*motion, "--velocity", "0.5", "--csv", tmp_path / "motion.csv")
    rows = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert np.abs(rows[:, 8:15]).max() == pytest.approx(0.5, abs=1e-6)


def test_the_joints_of_a_motion_are_drawn(run, tmp_path):
    pytest.importorskip("matplotlib")
    assert run("plan", "--to", RIGHT, "--plot", tmp_path / "q.svg").exit_code == 0
    assert "</svg>" in (tmp_path / "q.svg").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "hoome"], "no state of the SRDF is called 'hoome'; there are none; states are read from an SRDF: --srdf FILE"),
        (
            ["--to", "home", "--group", "arm"],
            "no group is called 'arm'; there are none; groups are read from an SRDF: --srdf",
        ),
        (["--to", RIGHT, "--velocity", "0"], "--velocity: 0.0; a number above 0, or 7 of them, is expected"),
        (["--to", RIGHT, "--jerk", "0"], "--jerk: 0.0; a number above 0, or 7 of them, is expected"),
        (["--to", RIGHT, "--clearance", "-1"], "--clearance: -1.0; a distance [m] of at least 0"),
        (["--to", RIGHT, "--wxyz", "1,0,0,0"], "--link, --rpy, --wxyz, --rotvec, --frame: require --xyz or --pose"),
    ],
)
def test_what_is_refused_is_named_in_words_of_the_command_line(refusal, arguments, message):
    assert refusal("plan", *arguments).startswith(message)


def test_a_limit_of_time_or_of_edges_ends_a_search_and_is_named(run, tmp_path):
    ball = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    slide = '<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/>'
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    robot, cell = tmp_path / "car.urdf", tmp_path / "cell.json"
    robot.write_text(f'<robot name="car"><link name="base"/><link name="car">{ball}</link>{slide}{limit}</robot>')
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 4.0, 4.0)))
    ulna.save_world(world, cell)
    command = "plan", str(robot), "--from=-0.5", "--to", "0.5", "--scene", str(cell)
    few = run(*command, "--max-checks", "50", "--time-limit", "inf")
    assert few.exit_code == 1, few.output
    assert "max_checks=50" in few.output
    assert "car and wall" in few.output
    short = run(*command, "--time-limit", "0.02", "--max-checks", "1000000000000")
    assert short.exit_code == 1
    assert "time_limit=0.02" in short.output
    assert run(*command, "--time-limit", "0").exit_code == 2


def test_the_limits_of_an_arm_serve_and_the_file_has_a_row_for_each_period(ask, run, tmp_path):
    motion = ["plan", "--from", LEFT, "--to", RIGHT]
    found = ask(*motion, "--limits", "franka")
    assert found.check.startswith("within the limits: ")
    assert found.duration < ask(*motion).duration
    assert ask(*motion, "--limits", "franka", "--acceleration", "2").duration > found.duration
    run(*motion, "--limits", "franka", "--csv", tmp_path / "motion.csv", "--period", "0.001")
    t = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)[:, 0]
    assert np.allclose(np.diff(t[:-1]), 0.001)
    for options, says in (
        (["--limits", "franca"], "no set of limits is called 'franca'; did you mean 'franka'?"),
        (["--limits", "iiwa14"], "--acceleration: iiwa14 has none"),
        (["--csv", tmp_path / "motion.csv", "--period", "0"], "--period"),
    ):
        result = run(*motion, *options)
        assert result.exit_code == 2
        assert says in " ".join(result.output.split())


def test_what_a_motion_keeps_is_certified_and_the_json_says_how_much_of_the_tolerance_is_used(run, scene):
    motion = "plan", "--from", LEFT, "--to", RIGHT, "--scene", scene, "--json"
    found = json.loads(run(*motion, "--keep", "upright=5deg").stdout)
    assert found["success"]
    assert 0 < found["worst_violation"] <= 1
    up = ulna.load("panda").forward_kinematics(np.linspace(found["path"][:-1], found["path"][1:], 101))[..., 2, :3]
    assert (up @ up[0, 0] >= np.cos(np.radians(5))).all()
    assert json.loads(run(*motion).stdout)["worst_violation"] == 0


def test_a_plan_keeps_the_positions_of_a_file_of_limits(ask, run, tmp_path):
    file = tmp_path / "joint_limits.yaml"
    file.write_text("joint_limits: {panda_joint1: {min_position: -0.5, max_position: 9, max_velocity: 0.5}}")
    home = "-pi/4,0,-3pi/4,0,pi/2,pi/4"
    found = ask("plan", "--to", f"0.4,{home}", "--limits", str(file), "--acceleration", "2")
    assert found.success
    assert found.duration > 0.4 / 0.5
    refused = run("plan", f"--to=-0.6,{home}", "--limits", str(file), "--acceleration", "2")
    assert refused.exit_code == 2
    assert "-0.6 of joint 'panda_joint1' is outside its limits, -0.5 to 2.8973" in " ".join(refused.output.split())


def test_the_hand_keeps_its_speed(ask):
    goal = "1,-pi/4,0,-3pi/4,0,pi/2,pi/4"
    slow, fast = ask("plan", "--to", goal, "--hand-speed", "0.25"), ask("plan", "--to", goal)
    robot = ulna.load("panda")
    way = np.hypot(*robot.forward_kinematics(robot.home)[:2, 3])  # of the hand, about the axis of the first joint
    assert slow.duration > way / 0.25 > fast.duration
    assert "the speed of panda_ee peaks at 0.25 m/s" in slow.check
