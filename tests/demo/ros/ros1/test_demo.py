"""``ulna ros1 demo`` starts and ends what it needs; its node survives the end of RViz, of a master, and a bad pose."""

import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress

import pytest

pytest.importorskip("rospy", reason="no ROS 1 for this Python: docs/ros.md says how to install it")
import rosgraph

from colors import count
from processes import running, wait_for
from ulna.demo.ros.screen import BACKGROUND, CONFIG, View
from ulna.demo.scenario import LIGHT_POSITION

FEEDBACK, INIT = "visualization_msgs/InteractiveMarkerFeedback", "visualization_msgs/InteractiveMarkerInit"
pytestmark = pytest.mark.filterwarnings(
    "ignore:unclosed:ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # rospy's
LIGHT = "m.ns=='light' and m.type==9"  # its word


@pytest.fixture
def node(another):
    """The demo without RViz; it starts a master."""
    with demo_without_rviz(another) as program:
        yield program


@contextmanager
def demo_without_rviz(environment):
    with running(sys.executable, "-m", "ulna", "ros1", "demo", "--no-rviz", env=environment, stdout=subprocess.PIPE) as program:
        assert "The demo runs" in program.stdout.readline()
        yield program


def rostopic(environment, *words):
    """What ``rostopic`` prints."""
    command = ["rostopic", *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=60).stdout


def publish_box(environment, x, w, name="box"):
    place = f"{{position: {{x: {x}, z: 0.1}}, orientation: {{w: {w}}}}}"
    place = f"{{header: {{frame_id: panda_link0}}, marker_name: {name}, event_type: 1, pose: {place}}}"
    rostopic(environment, "pub", "-1", "/basic_controls/feedback", FEEDBACK, place)


def word(environment):
    """The text beside the light."""
    return rostopic(environment, "echo", "-n1", "--filter", LIGHT, "/visualization_marker/text").splitlines()[0].strip('"')


def master_of(environment):
    return rosgraph.Master("/test", environment["ROS_MASTER_URI"])


def is_alive(environment):
    with suppress(OSError):
        return master_of(environment).is_online()
    return False


def end_master(environment):
    """Send SIGTERM to the master, and return its process id."""
    number = master_of(environment).getPid()
    os.kill(number, signal.SIGTERM)
    return number


def test_joint_states_have_the_names_of_the_joints(node, another):
    text = rostopic(another, "echo", "-n1", "/joint_states/name")
    names = [*(f"panda_joint{k}" for k in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]
    assert re.findall(r"\w+_joint\d", text) == names


def test_an_invalid_pose_is_ignored_and_the_node_continues(node, another):
    publish_box(another, 0.0, 1.0)
    wait_for(lambda: "collision" in word(another), "the word collision")
    publish_box(another, ".nan", 1.0)
    assert "collision" in word(another)
    publish_box(another, 2.0, 1.0)
    wait_for(lambda: word(another) == "free", "the word free")
    assert node.poll() is None


def test_an_orientation_that_is_not_set_is_none_in_a_drag_and_in_a_server_that_starts(node, another):
    publish_box(another, 0.0, 0.0)
    wait_for(lambda: "collision" in word(another), "the word collision")
    marker = "{header: {frame_id: panda_link0}, name: box, pose: {position: {x: 2.0}}}"
    rostopic(another, "pub", "-1", "/basic_controls/update_full", INIT, f"{{server_id: another, markers: [{marker}]}}")
    wait_for(lambda: word(another) == "free", "the word free")


def test_the_marker_name_of_the_course_is_accepted(node, another):
    publish_box(another, 0.0, 1.0, name="simple_6dof")
    wait_for(lambda: "collision" in word(another), "the word collision")


def test_the_demo_restarts_the_master_that_it_started(node, another):
    lost = end_master(another)
    wait_for(lambda: is_published(another), "the joints and the description at another master")
    assert master_of(another).getPid() != lost
    publish_box(another, 0.0, 1.0)
    wait_for(lambda: "collision" in word(another), "the word collision, by the new master")
    assert node.poll() is None


def test_the_demo_reconnects_to_a_master_that_was_restarted(another):
    command = ("rosmaster", "--core", "-p", another["ROS_MASTER_URI"].rsplit(":", 1)[1])
    nothing = {"env": another, "stdout": subprocess.DEVNULL}
    with running(*command, **nothing):
        wait_for(lambda: is_alive(another), "a master")
        with demo_without_rviz(another) as program:
            end_master(another)
            wait_for(lambda: not is_alive(another), "the master's end")
            with running(*command, **nothing):
                wait_for(lambda: is_published(another), "the joints and the description at another master")
                assert program.poll() is None


def is_published(environment):
    """Whether /joint_states and /tf are published and /robot_description is set."""
    with suppress(OSError, rosgraph.MasterException):
        master = master_of(environment)
        topics = dict(master.getSystemState()[0])
        return "/joint_states" in topics and "/tf" in topics and "<robot" in master.getParam("/robot_description")
    return False


def test_ros1_demo_starts_rviz_and_ends_all_that_it_started(another, display):
    environment = another | {"DISPLAY": display.name}
    with running(sys.executable, "-m", "ulna", "ros1", "demo", env=environment, stdout=subprocess.PIPE) as program:
        assert "The demo runs" in program.stdout.readline()
        wait_for(lambda: light_is_seen(display), "the light in RViz")
        (first,) = children(program.pid, "-x", "rviz")
        os.kill(first, signal.SIGSEGV)
        (second,) = wait_for(lambda: set(children(program.pid, "-x", "rviz")) - {first}, "another RViz for the one that crashed")
        wait_for(lambda: light_is_seen(display), "the light in it")
        os.kill(second, signal.SIGTERM)
        wait_for(lambda: not light_is_seen(display), "an empty screen")
        with running("rviz", "-d", str(CONFIG), env=environment, stdout=subprocess.DEVNULL):
            wait_for(lambda: light_is_seen(display), "the light in the next RViz")
        assert program.poll() is None
        started = children(program.pid)
        assert len(started) == 2  # the master and robot_state_publisher
    assert program.returncode == 0
    wait_for(lambda: not any(alive(pid) for pid in started), "the end of what it started")
    assert not is_alive(another)


def light_is_seen(display):
    image = display.pixels()
    if (image == BACKGROUND).all(axis=-1).sum() < 200_000:
        return False
    return count(View(image).around(image, LIGHT_POSITION, 12), "green") > 200


def children(pid, *named):
    run = subprocess.run(["pgrep", "-P", str(pid), *named], capture_output=True, text=True, check=False)
    return [int(word) for word in run.stdout.split()]


def alive(pid):
    return subprocess.run(["ps", "-p", str(pid)], capture_output=True, check=False).returncode == 0
