"""Fixtures for ROS 1 with its real programs: the address of a master, a virtual screen for RViz, scripts of hw2."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from processes import free_port, running

NEEDED = ("rosmaster", "roslaunch", "rostopic", "rviz", "Xvfb", "xdotool")


@pytest.fixture(scope="session")
def machine(tmp_path_factory):
    """The environment of all programs: the free address of a master, and a folder for logs."""
    missing = [name for name in NEEDED if not shutil.which(name)]
    if missing:
        pytest.skip(f"not on this machine: {', '.join(missing)}; docs/ros.md says how to install them")
    folder = tmp_path_factory.mktemp("ros")
    folder.chmod(0o700)
    words = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}", "ROS_IP": "127.0.0.1", "ROS_HOME": str(folder)}
    words |= {"XDG_RUNTIME_DIR": str(folder), "ULNA": str(Path(sys.executable).with_name("ulna")), "PYTHONUNBUFFERED": "1"}
    os.environ.update(words)  # rospy of this process reads them too
    os.environ.pop("DISPLAY", None)
    return dict(os.environ)


@pytest.fixture
def another(machine):
    """The same environment with another master's address."""
    return machine | {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}"}


@pytest.fixture(scope="session")
def display(machine):
    from ulna.demo.ros.screen import virtual_screen

    with virtual_screen() as found:
        yield found


@pytest.fixture
def script(machine):
    """Starts a script of hw2 as the assignment does: ``python NAME`` in that folder."""

    def start(name, **options):
        options = {"env": machine, "cwd": HW2, "stderr": subprocess.PIPE} | options
        return running(sys.executable, name, **options)

    return start


HW2 = Path(__file__).parents[4] / "hw2"
