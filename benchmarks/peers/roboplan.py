"""RoboPlan: RRT-Connect in C++ on Pinocchio and Coal, which test edges at samples; and its path shortcutter.

Source: https://github.com/open-planning/roboplan. It has no capsules: there it is asked among the exact cylinders.
"""

import time
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from roboplan import core, rrt

import ulna
from benchmarks.peer import NotForThisArm
from benchmarks.vamp_problems import PlanningProblem
from ulna.planning.motion import RANGE, SAMPLES_APART

Way = tuple[NDArray | None, float]
GROUP = "arm"
COLOUR = np.ones(4)


class Planner:
    """Its planner for a robot in VAMP's spheres."""

    def __init__(self, robot: ulna.Robot, folder) -> None:
        urdf = (folder / f"{folder.name}_spherized.urdf").read_text(encoding="utf-8")
        self._scene = core.Scene(folder.name, core.loadUrdfSceneDescriptionFromXml(urdf, []))
        self._scene.importSrdf((folder / f"{folder.name}.srdf").read_text(encoding="utf-8"))
        self._names = list(robot.joint_names)
        self._scene.addGroup(GROUP, self._names)
        if list(self._scene.getJointNames()) != self._names:
            raise NotForThisArm(f"it moves {self._scene.getJointNames()}")
        self._planner = rrt.RRT(
            self._scene,
            rrt.RRTOptions(
                group_name=GROUP, max_nodes=100_000, max_connection_distance=RANGE, collision_check_step_size=SAMPLES_APART,
                max_planning_time=10.0, rrt_connect=True,
            ),
        )  # fmt: skip
        self._shortcutter = core.PathShortcutter(self._scene, core.PathShortcuttingOptions(GROUP, SAMPLES_APART))
        self._objects: list[str] = []

    def solve(self, problem: PlanningProblem, world: ulna.World) -> tuple[Way, Way]:
        """The path and the shortened one, and how long each took without laying out the objects [s]."""
        self._lay_out(world)
        self._planner.setRngSeed(1)
        ends = [core.JointConfiguration(self._names, q) for q in (problem.start, problem.goal)]
        began = time.thread_time()
        try:
            first = self._planner.plan(*ends)
            planned = time.thread_time()
            path = self._shortcutter.shortcut(first)
        except RuntimeError:
            return (None, np.nan), (None, np.nan)
        ended = time.thread_time()
        return (np.array(first.positions), planned - began), (np.array(path.positions), ended - began)

    def _lay_out(self, world: ulna.World) -> None:
        for name in self._objects:
            self._scene.removeGeometry(name)
        self._objects = []
        for name, shape, T in world.items():
            place = np.asfortranarray(T)
            match shape:
                case ulna.Sphere():
                    self._scene.addSphereGeometry(name, "universe", core.Sphere(shape.radius), place, COLOUR)
                case ulna.Cylinder() | ulna.Capsule():
                    self._scene.addCylinderGeometry(name, "universe", core.Cylinder(shape.radius, shape.length), place, COLOUR)
                case _:
                    self._scene.addBoxGeometry(name, "universe", core.Box(*shape.extents), place, COLOUR)
            self._objects.append(name)
        for a, b in combinations(self._objects, 2):
            self._scene.setCollisions(a, b, enable=False)
