"""Starts and ends all programs of ROS 1 that the demo needs."""

# pyright: reportMissingImports=false

import os
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import rosgraph
import rospy

from ulna.demo.ros.children import Children, Ended
from ulna.demo.ros.description import robot_description
from ulna.demo.ros.ros1 import ArmAndLight, MovableBox, beat, node
from ulna.demo.scenario import Demo
from ulna.errors import MissingROSError

_MASTER_WITHIN_S = 20.0
_HERE = ("localhost", "127.0.0.1", "::1")
_PUBLISHER, _RVIZ = "robot_state_publisher", "RViz"
_MAX_CRASHES = 3  # after this number, another start will not help


def run(ask: Callable[..., Any], *, rviz: bool = True) -> None:
    """Run robot_state_publisher, the nodes, RViz, and a master if none runs, until Ctrl-C; ``ask`` is ``Compiler.ask``."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # SIGTERM too ends the children of this process
    demo = Demo()
    with ExitStack() as stack:
        master = stack.enter_context(Children())
        have_master(master)
        ended = stack.enter_context(node("ulna_demo"))
        config = str(stack.enter_context(as_file(files("ulna.demo.ros") / "demo.rviz"))) if rviz else None
        programs = stack.enter_context(MasterPrograms(demo, config))
        programs.meet_master()
        arm, _box = ArmAndLight(demo, ask), MovableBox(demo.robot)
        print("The demo runs in ROS 1  (Ctrl-C ends it)", flush=True)  # noqa: T201 - without RViz nothing else is visible

        def step(seconds: float) -> None:
            arm.player.advance(seconds)
            restart_ended(master, programs)

        beat(step, ended, programs.meet_master)


def restart_ended(master: Children, programs: "MasterPrograms") -> None:
    """Restart programs that ended by themselves: the master, and RViz if it has crashed."""
    for ended in programs.ended():
        rospy.logwarn(f"{ended}; {'it is started again' if programs.restart(ended) else 'the demo continues'}")
    for ended in master.ended():
        rospy.logwarn(f"{ended}; it is started again")
        have_master(master)


class MasterPrograms(Children):
    """The parameters of a master, and programs that register only once: both are renewed for each new master."""

    def __init__(self, demo: Demo, config: str | None) -> None:
        super().__init__()
        self._demo, self._config, self._crashes = demo, config, 0

    def meet_master(self) -> None:
        """Set robot_description; start robot_state_publisher, and RViz if there is a configuration for it."""
        self.end_all()
        rospy.set_param("robot_description", robot_description(self._demo.robot, rospy.logwarn))
        self.start(_PUBLISHER, _find_state_publisher())
        if self._config:
            _open_rviz(self, self._config)

    def restart(self, ended: Ended) -> bool:
        """Restart RViz if it has crashed, at most _MAX_CRASHES times; not if the user closed it."""
        if not (ended.name == _RVIZ and ended.crashed and self._config and self._crashes < _MAX_CRASHES):
            return False
        self._crashes += 1
        _open_rviz(self, self._config)
        return True


def have_master(master: Children) -> None:
    """Start a master at ROS_MASTER_URI, unless one is running there."""
    if rosgraph.is_master_online():
        return
    uri = urlsplit(rosgraph.get_master_uri())
    if uri.hostname not in _HERE:
        raise MissingROSError(f"the master at {uri.geturl()} does not answer, and only a master on this machine can be started")
    port = str(uri.port or 11311)
    master.start("rosmaster", "rosmaster", "--core", "-p", port)
    end = time.monotonic() + _MASTER_WITHIN_S
    while not rosgraph.is_master_online():
        if time.monotonic() > end or any(master.ended()):
            raise MissingROSError(f"the master did not start; rosmaster --core -p {port} shows why")
        time.sleep(0.05)


def _find_state_publisher() -> str:
    """The path of robot_state_publisher: under a prefix of ROS's setup script, or Debian's."""
    prefixes = [*filter(None, os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)), "/usr"]
    for prefix in prefixes:
        path = Path(prefix, "lib", _PUBLISHER, _PUBLISHER)
        if path.exists():
            return str(path)
    raise MissingROSError(f"no {_PUBLISHER} under {' or '.join(prefixes)}; docs/ros.md explains its installation")


def _open_rviz(programs: Children, config: str) -> None:
    """Start RViz with the demo's configuration; without RViz or a display, log the command to run elsewhere."""
    if os.environ.get("DISPLAY"):
        try:
            programs.start(_RVIZ, "rviz", "-d", config)
        except MissingROSError as error:
            rospy.logwarn(f"{error}; the demo continues without RViz")
    else:
        rospy.logwarn(f"there is no screen for RViz; on a machine with one: rviz -d {config}")
