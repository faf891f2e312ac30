"""A way through several goals, and what is kept of it: files, a program, commands."""

import json
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import ulna
from ulna.cli.app import app
from ulna.viewer.session.changes import Changes
from ulna.viewer.session.export import as_commands, as_program, motion_file
from ulna.viewer.session.planned_motion import Planning
from ulna.viewer.session.session import Session
from ulna.viewer.session.waypoints import MotionSettings, gripper_of

FINGER = """<link name="finger{k}"/><joint name="finger_joint{k}" type="prismatic"><parent link="panda_link8"/>
<child link="finger{k}"/><axis xyz="0 {sign} 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="1"/></joint>"""


@pytest.fixture
def world():
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 0.9)), ulna.pose((0.45, 0.25, 0.45)))
    return world


def planning_of(robot, world):
    planning = Planning(Session(robot, world))
    planning.turn(on=True)
    return planning


def aim(planning, xyz):
    T = planning.hand_pose
    T[:3, 3] = xyz
    planning.send(T)


@pytest.fixture
def planning(panda, world):
    planning = planning_of(panda, world)
    aim(planning, (0.4, -0.2, 0.3))
    planning.add_waypoint(approach=0.08, retract=0.05)
    aim(planning, (0.35, -0.3, 0.5))
    planning.frame(0.0)
    return planning


def test_a_way_point_is_approached_and_left_straight_along_the_hand_s_axis(planning, panda, world):
    motion, legs = planning.shown.motion, planning.shown.legs
    assert motion.certified
    assert planning.sentence.startswith("solved: ")
    assert [leg.line is not None for leg in legs] == [False, True, True, False]
    rests = panda.forward_kinematics(motion.at(motion.rests).q)[:, :3, 3]
    at = next(k for k, xyz in enumerate(rests) if np.allclose(xyz, (0.4, -0.2, 0.3), atol=1e-4))
    begins = np.cumsum([0.0, *(leg.motion.duration for leg in legs)])
    for k, above in ((1, 0.08), (2, 0.05)):
        hand = panda.forward_kinematics(motion.at(np.linspace(begins[k], begins[k + 1], 100)).q)[:, :3, 3]
        assert np.abs(hand[:, :2] - (0.4, -0.2)).max() < 5e-3
        assert np.ptp(hand[:, 2]) == pytest.approx(above, abs=5e-3)
    assert at >= 1
    assert not panda.in_collision(motion.at(np.linspace(0.0, motion.duration, 500)).q, world).any()
    np.testing.assert_allclose(panda.forward_kinematics(motion.q[-1])[:3, 3], (0.35, -0.3, 0.5), atol=1e-4)


def test_the_gripper_opens_at_a_way_point(panda, world):
    text = panda.to_urdf().replace("</robot>", "".join(FINGER.format(k=k, sign=s) for k, s in ((1, 1), (2, -1))) + "</robot>")
    robot = ulna.load(text)
    planning = planning_of(robot, world)
    assert list(gripper_of(robot, planning.settings.link)) == [7, 8]
    aim(planning, (0.4, -0.2, 0.3))
    planning.add_waypoint(opening=1.0)
    planning.add_waypoint(opening=0.5)
    planning.frame(0.0)
    motion = planning.shown.motion
    opened = [leg.motion.q[-1][7:] for leg in planning.shown.legs]
    assert any(np.allclose(each, 0.04) for each in opened)
    np.testing.assert_allclose(motion.q[-1][7:], 0.02)
    for leg in planning.shown.legs:
        moved = np.ptp(leg.motion.q, axis=0) > 1e-12
        assert not (moved[:7].any() and moved[7:].any()), "the fingers move while the arm rests"
    assert motion.duration == pytest.approx(sum(leg.motion.duration for leg in planning.shown.legs))
    assert len(gripper_of(panda, "panda_ee")) == 0


def test_a_way_point_that_is_not_reached_is_named(panda, world):
    planning = planning_of(panda, world)
    for xyz in ((0.4, -0.2, 0.3), (0.45, 0.25, 0.4)):
        aim(planning, xyz)
        planning.add_waypoint()
    planning.frame(0.0)
    assert planning.shown.motion is None
    assert planning.sentence.startswith("waypoint 2: goal in collision: ")
    planning.remove_waypoint()
    assert len(planning.waypoints) == 1
    assert planning.hand_pose[0, 3] == 0.45


@pytest.mark.parametrize("ending", ["csv", "json"])
def test_a_saved_motion_is_read_back(planning, panda, tmp_path, ending):
    motion, path = planning.shown.motion, tmp_path / f"motion.{ending}"
    path.write_bytes(motion_file(motion, ending))
    again = panda.motion_from_file(path)
    assert again.duration == pytest.approx(motion.duration, abs=1e-9)
    t = np.linspace(0.0, motion.duration, 300)
    np.testing.assert_allclose(again.at(t).q, motion.at(t).q, atol=1e-3)


def test_the_program_makes_the_motion_again(planning, panda, world, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    changes = Changes(allowed=(("panda_link1", "panda_link7"),), limits={"velocity": {"panda_joint1": 1.5}})
    planning.upright, planning.jerk = True, 30.0
    planning.frame(0.0)
    shown = planning.shown
    lines = [f"robot = {changes.as_expression()}"]
    made = {}
    exec(as_program(panda, lines, world, shown.legs, planning.settings), made)  # noqa: S102 - what a person would paste
    assert made["motion"].certified
    assert made["motion"].stops == shown.motion.stops
    np.testing.assert_allclose(made["motion"].q[-1], shown.motion.q[-1], atol=1e-6)
    np.testing.assert_array_equal(made["world"].pose("post"), world.pose("post"))
    assert made["robot"].velocity_limits[0] == 1.5
    assert panda.motion_from_file("motion.csv").duration == pytest.approx(made["motion"].duration)


def test_the_commands_make_the_motion_again(planning, panda, world, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ulna.save_world(world, "scene.json")
    for line, leg in zip(
        as_commands(panda, world, planning.shown.legs, planning.settings).splitlines()[1:], planning.shown.legs, strict=True
    ):
        program, *words = shlex.split(line)
        assert program == "ulna"
        found = CliRunner().invoke(app, [*words, "--json"], catch_exceptions=False)
        assert found.exit_code == 0, found.output
        assert json.loads(found.stdout)["certified"]
        assert json.loads(found.stdout)["duration"] == pytest.approx(leg.motion.duration, rel=1e-3)
    assert (tmp_path / "motion4.csv").exists()


def test_changes_are_of_the_robot_as_it_was_and_none_is_the_robot_itself(panda):
    none = Changes()
    assert none.apply_to(panda) is panda
    narrow = none.with_limit(panda, "upper", "panda_joint1", 1.0)
    assert narrow.apply_to(panda).upper[0] == 1.0
    wider = narrow.with_limit(panda, "upper", "panda_joint1", 2.0)
    assert wider.apply_to(panda).upper[0] == 2.0
    assert wider.with_limit(panda, "upper", "panda_joint1", panda.upper[0]) == none
    with pytest.raises(ulna.InputError, match="upper"):
        none.with_limit(panda, "upper", "panda_joint1", 9.0).apply_to(panda)
    held = ulna.load("panda").with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), ulna.pose((0, 0, 0.1), (0.1, 0.2, 0.3))).attached
    changes = Changes((("panda_link1", "panda_link7"),), {"lower": {"panda_joint2": -1.0}}, held)
    made = eval(changes.as_expression(), {"robot": panda, "ulna": ulna})  # noqa: S307 - what a person would paste
    assert ("panda_link1", "panda_link7") in made.allowed_collisions
    assert made.lower[1] == -1.0
    assert made.attached[0].name == "cup"
    np.testing.assert_allclose(made.attached[0].T_link_object, held[0].T_link_object, atol=1e-12)
    assert (
        changes.describe()
        == "These links may touch: panda_link1 and panda_link7. Narrower limits: panda_joint2. Attached: cup to panda_ee"
    )


def test_a_program_of_a_robot_that_has_no_file_loads_none(panda):
    for robot in (ulna.load(panda.to_urdf()), panda.with_tool(ulna.pose((0.0, 0.0, 0.1)))):
        program = as_program(robot, [], ulna.World(), [], MotionSettings(robot.tip))
        assert "robot = ..." in program
        assert "ulna.load" not in program
    assert "robot = ulna.load('panda')" in as_program(panda, [], ulna.World(), [], MotionSettings(panda.tip))
