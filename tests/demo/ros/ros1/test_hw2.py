"""The assignment's launch file and scripts, each in its own process, with pictures of RViz."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rospy", reason="no ROS 1 for this Python: docs/ros.md says how to install it")
import rospy
import yaml
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerFeedback, Marker

import ulna
from colors import count
from processes import running, wait_for
from ulna.demo.ros import messages
from ulna.demo.ros.screen import BACKGROUND, View
from ulna.demo.scenario import BOX_START, LIGHT_POSITION
from ulna.description.names.panda import FINGER_JOINTS
from ulna.viewer.palette import FREE, MOVABLE, Solid

HW2 = Path(__file__).parents[4] / "hw2"
AT_ZERO = np.zeros(7)
ENDS = ("panda_link0", "panda_link8")
SHAPE = ulna.Box((0.1, 0.2, 0.3))
pytestmark = pytest.mark.filterwarnings(
    "ignore:unclosed:ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # rospy's


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """The file with the output of roslaunch and its nodes."""
    return tmp_path_factory.mktemp("roslaunch") / "printed.txt"


@pytest.fixture(scope="module")
def rviz(machine, display, printed):
    """``roslaunch hw2.launch`` in hw2/, and the view of RViz once it has drawn its background."""
    environment = machine | {"DISPLAY": display.name}
    with (
        printed.open("w") as output,
        running("roslaunch", "hw2.launch", cwd=HW2, env=environment, stdout=output, stderr=subprocess.STDOUT),
    ):
        wait_for(lambda: (display.pixels() == BACKGROUND).all(axis=-1).sum() > 200_000, "RViz")
        rospy.init_node("test", anonymous=True, disable_signals=True)
        yield View(display.pixels())


def light_is(display, rviz, color):
    return count(rviz.around(display.pixels(), LIGHT_POSITION, 12), color) > 200


def differs(image, rviz, point):
    """Whether something is drawn at a point of the scene: few pixels around it have the color of the background."""
    return (np.abs(rviz.around(image, point, 6) - BACKGROUND).max(axis=-1) > 20).mean() > 0.9


def test_line_5_of_the_launch_file_sets_the_path():
    assert '<arg name="path"' in (HW2 / "hw2.launch").read_text().splitlines()[4]


def test_the_path_can_be_given_on_the_command_line(machine, tmp_path):
    shutil.copy(HW2 / "hw2.launch", tmp_path)  # alone: all else is at the path
    command = ["roslaunch", "--dump-params", "hw2.launch", f"path:={HW2}"]
    dump = subprocess.run(command, cwd=tmp_path, env=machine, capture_output=True, text=True, check=True)
    arm = ulna.load(yaml.safe_load(dump.stdout)["/robot_description"])
    assert arm.joint_names == (*ulna.load("panda").joint_names, *FINGER_JOINTS)


def test_robot_description_is_the_arm_with_mesh_files(rviz):
    text = rospy.get_param("robot_description")
    assert ulna.load(text).joint_names == (*ulna.load("panda").joint_names, *FINGER_JOINTS)
    assert "file:///" in text
    assert "package://" not in text


def test_every_published_joint_has_a_frame_and_there_are_no_warnings(rviz, printed, script):
    robot, frames = ulna.load("panda"), []
    fingers = {"panda_leftfinger", "panda_rightfinger"}
    rospy.Subscriber("/tf", TFMessage, lambda message: frames.extend(t.child_frame_id for t in message.transforms))
    with script("test_collision_boxes.py"):
        wait_for(lambda: fingers | set(robot.link_names[1:8]) <= set(frames), "the frames of all moving links")
    assert "not found in URDF" not in printed.read_text()


def test_the_arm_and_the_static_boxes_are_drawn(display, rviz, script):
    robot = ulna.load("panda")
    elbow, wrist, flange = (
        robot.forward_kinematics(AT_ZERO, link=link)[:3, 3] for link in ("panda_link4", "panda_link5", "panda_link8")
    )
    with script("test_collision_boxes.py"):
        wait_for(lambda: all(differs(display.pixels(), rviz, p) for p in (elbow, wrist, flange)), "the arm at zero")
        assert "/visualization_marker" not in dict(rospy.get_published_topics())  # no light: nothing is checked
        beside = [0.0, 0.11, 0.333]  # in box 4, beside the arm
        assert not differs(display.pixels(), rviz, beside)
        with script("collision_boxes.py"):
            wait_for(lambda: differs(display.pixels(), rviz, beside), "box 4")
            wait_for(lambda: legend_colors(display.pixels(), rviz) == {MOVABLE, FREE}, "the names of both sets of boxes")
            base, hand = (rviz.around(display.pixels(), robot.forward_kinematics(AT_ZERO, link=link)[:3, 3], 90) for link in ENDS)
            assert min(pixels_of(FREE, base), pixels_of(FREE, hand), pixels_of(MOVABLE, hand)) > 300  # edges, not blended


def pixels_of(color, image):
    """How many pixels of a picture have a color."""
    return (np.abs(image.astype(int) - color).max(axis=-1) < 30).sum()


def test_a_box_has_its_twelve_edges_and_faces_unless_it_is_invisible():
    boxes = {
        name: [Solid("box", "link", ulna.pose((1, 2, 3)), SHAPE, FREE, opacity)] for name, opacity in (("a", 0.2), ("b", 0.0))
    }
    found = list(messages.edged_boxes(boxes))
    assert [(marker.ns, marker.id, marker.type) for marker in found] == [
        ("a", 0, Marker.LINE_LIST),
        ("a", 1, Marker.CUBE),
        ("b", 0, Marker.LINE_LIST),
    ]
    ends = np.array([(p.x, p.y, p.z) for p in found[0].points]).reshape(-1, 2, 3)
    assert len({frozenset(map(tuple, edge)) for edge in ends}) == len(ends) == 12
    np.testing.assert_allclose(np.abs(ends), np.broadcast_to(SHAPE.half_extents, ends.shape))
    along = np.abs(ends[:, 1] - ends[:, 0])
    assert (np.count_nonzero(along, axis=1) == 1).all()
    np.testing.assert_allclose(along.sum(axis=0), 4 * np.array(SHAPE.extents))


def legend_colors(image, rviz):
    """Which colors of solids, all but transparent in the boxes, are seen beside the light's place."""
    beside = rviz.around(image, LIGHT_POSITION, 60)
    return {color for color in (MOVABLE, FREE) if pixels_of(color, beside) > 50}


def test_the_light_is_red_while_the_mouse_drags_the_box_into_the_arm(display, rviz, script):
    feedback = []
    rospy.Subscriber("/basic_controls/feedback", InteractiveMarkerFeedback, feedback.append)
    down, moved, up = (getattr(InteractiveMarkerFeedback, name) for name in ("MOUSE_DOWN", "POSE_UPDATE", "MOUSE_UP"))

    def drag_upwards(start, way):
        """Drag the box along z by its upper arrow, from a place, by a way [m]: each step when RViz has done the one before."""
        feedback.clear()
        place = np.array(start)
        head = np.array(wait_for(lambda: arrow_up(display.pixels(), rviz, place), "the arrow that points up"))
        display.move_mouse(head)
        wait_for(lambda: says_move(display.pixels()), "the arrow under the pointer")
        mouse(display, "mousedown", 1)
        wait_for(lambda: down in {m.event_type for m in feedback}, "a held arrow")
        display.move_mouse(head + rviz.project(np.add(place, (0, 0, way))) - rviz.project(place))
        wait_for(lambda: abs(feedback[-1].pose.position.z - place[2] - way) < 0.05, "the box at the end of its way")
        mouse(display, "mouseup", 1)
        wait_for(lambda: up in {m.event_type for m in feedback}, "a released arrow")
        assert {m.marker_name for m in feedback} == {"box"}
        kinds = [m.event_type for m in feedback]
        assert moved in kinds[kinds.index(down) : kinds.index(up)]
        end = feedback[-1].pose.position
        np.testing.assert_allclose([end.x, end.y], place[:2], atol=1e-3)
        return end.x, end.y, end.z

    with script("test_collision_detection.py"), script("6DoF_Box.py"):
        wait_for(lambda: light_is(display, rviz, "green"), "a green light")
        above = drag_upwards(BOX_START, 0.3)  # to where the hand passes in each cycle
        wait_for(lambda: light_is(display, rviz, "red"), "a red light")
        drag_upwards(above, -0.3)
        wait_for(lambda: light_is(display, rviz, "green"), "a green light again")


def arrow_up(image, rviz, place):
    """The head of the upward arrow of a box at ``place`` [pixel x, y]: the highest blue pixel above it, or None."""
    x, y = rviz.project(place).astype(int)
    above = image[: y - 40, x - 20 : x + 20].astype(int)
    rows, columns = np.nonzero(above[..., 2] - above[..., :2].max(axis=-1) > 60)
    return (x - 20.0 + columns[rows.argmin()], rows.min() + 12.0) if rows.size else None


def says_move(image):
    """Whether the line at the bottom of RViz is as short as over an arrow: "Left-Click: Move."."""
    ink = (image[770:].max(axis=-1) < 100).any(axis=0)
    return ink[60:185].any() and not ink[185:730].any()


def mouse(display, *words):
    """One command of xdotool."""
    subprocess.run(["xdotool", *map(str, words)], env={**os.environ, "DISPLAY": display.name}, check=True)
