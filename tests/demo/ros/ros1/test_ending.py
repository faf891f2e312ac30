"""A node ends at Ctrl-C, even in the middle of publish, and while its kernels are compiled."""

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

pytest.importorskip("rospy", reason="no ROS 1 for this Python: docs/ros.md says how to install it")
import rosgraph

from processes import ends_while_it_compiles, running, wait_for

HW2 = Path(__file__).parents[4] / "hw2"
pytestmark = pytest.mark.filterwarnings(
    "ignore:unclosed:ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # rospy's
# Ctrl-C during publish(): the main thread itself holds the lock of the connection to a subscriber.
DURING_PUBLISH = """
import os, signal, sys
import numpy as np
from ulna.demo.ros.adapter import load_ros
ros1 = load_ros(1)
from rospy.impl.tcpros_pubsub import QueuedConnection

def write_data(self, data):
    with self._lock:
        print("signaled", flush=True)
        os.kill(os.getpid(), signal.SIGINT)

        QueuedConnection.write_data = lambda self, data: None  # a second signal would be another thing

QueuedConnection.write_data = write_data
"""
NODES = {
    "/joint_states": ("ros1.hold_arm(np.zeros(7))", "ros1.play_arm()"),
    "/visualization_marker": (
        """
import ulna
from ulna.demo.drawing import standing_boxes
ros1.show_boxes(lambda: {"a": list(standing_boxes(ulna.load("panda"), np.zeros(7)))})
""",
    ),
}


def is_online(uri):
    with suppress(OSError):
        return rosgraph.Master("/test", uri).is_online()
    return False


@pytest.fixture
def master(another):
    """The environment of a master that runs."""
    port = another["ROS_MASTER_URI"].rsplit(":", 1)[1]
    with running("rosmaster", "--core", "-p", port, env=another, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
        wait_for(lambda: is_online(another["ROS_MASTER_URI"]), "a master")
        yield another


@pytest.mark.parametrize(("topic", "call"), [(topic, call) for topic, calls in NODES.items() for call in calls])
def test_a_signal_during_publish_ends_the_node(master, topic, call):
    with running("rostopic", "echo", topic, env=master, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
        command = [sys.executable, "-c", DURING_PUBLISH + call]
        done = subprocess.run(command, env=master, capture_output=True, text=True, check=False, timeout=300)
    assert done.stdout.startswith("signaled")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("program", ["test_collision_detection.py", "collision_boxes.py", "-m ulna ros1 demo --no-rviz"])
def test_ctrl_c_does_not_wait_for_the_compiler_which_is_announced_in_a_pipe(master, tmp_path, program):
    environment = {**master}
    environment.pop("PYTHONUNBUFFERED")
    ends_while_it_compiles(program.split(), environment, tmp_path, cwd=HW2)
