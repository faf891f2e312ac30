"""Runs RoboPlan: RRT-Connect in C++ on Pinocchio and Coal, which test edges at samples; and its path shortcutter.

Source: https://github.com/open-planning/roboplan. It has no capsules, so it gets the exact cylinders. It gets a cloud as an
octree, whose cells are as wide as a ball.
"""

import time
from collections.abc import Iterable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from roboplan import core, rrt

import ulna
from benchmarks.peer import NotForThisArm
from benchmarks.vamp_problems import PlanningProblem
from ulna.planning.entries.search_records import RANGE, SAMPLES_APART

Way = tuple[NDArray | None, float]
GROUP = "arm"
COLOR = np.ones(4)


class Planner:
    """RoboPlan's planner for a robot, from the text of its URDF and its SRDF, if any.

    may_touch: pairs of links whose contact is allowed too.
    """

    def __init__(self, robot: ulna.Robot, urdf: str, srdf: str | None = None, may_touch: Iterable[tuple[str, str]] = ()) -> None:
        self._scene = core.Scene(robot.name, core.loadUrdfSceneDescriptionFromXml(urdf, []))
        if srdf is not None:
            self._scene.importSrdf(srdf)
        for pair in may_touch:
            self._scene.setCollisions(*pair, enable=False)
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
        """The path and the shortened one, and their times without the setup of the objects [s]."""
        self.lay_out(world)
        return self.search(problem.start, problem.goal)

    def touches(self, q: NDArray) -> bool:
        """Whether anything touches at q, shape (n_dof,)."""
        return self._scene.hasCollisions(self._positions(q))

    def _positions(self, q: NDArray) -> NDArray:
        """Joint positions in its form: cosine and sine for a joint without limits."""
        endless = [self._scene.getJointInfo(name).num_position_dofs == 2 for name in self._names]
        return np.array(
            [part for x, turns in zip(q, endless, strict=True) for part in ((np.cos(x), np.sin(x)) if turns else (x,))]
        )

    def search(self, start: NDArray, goal: NDArray) -> tuple[Way, Way]:
        """Plan like ``solve``, in the current world."""
        self._planner.setRngSeed(1)
        ends = [core.JointConfiguration(self._names, self._positions(q)) for q in (start, goal)]
        began = time.thread_time()
        try:
            first = self._planner.plan(*ends)
            planned = time.thread_time()
            path = self._shortcutter.shortcut(first)
        except RuntimeError:
            return (None, np.nan), (None, np.nan)
        ended = time.thread_time()
        return (np.array(first.positions), planned - began), (np.array(path.positions), ended - began)

    def lay_out(self, world: ulna.World) -> None:
        """Replace its objects by those of a world."""
        for name in self._objects:
            self._scene.removeGeometry(name)
        self._objects = []
        for name, shape, T in world.items():
            place = np.asfortranarray(T)
            match shape:
                case ulna.Sphere():
                    self._scene.addSphereGeometry(name, "universe", core.Sphere(shape.radius), place, COLOR)
                case ulna.Cylinder() | ulna.Capsule():
                    self._scene.addCylinderGeometry(name, "universe", core.Cylinder(shape.radius, shape.length), place, COLOR)
                case ulna.PointCloud():
                    self._scene.addOcTreeGeometry(name, "universe", _octree(shape), place, COLOR)
                case _:
                    self._scene.addBoxGeometry(name, "universe", core.Box(*shape.extents), place, COLOR)
            self._objects.append(name)
        for a, b in combinations(self._objects, 2):
            self._scene.setCollisions(a, b, enable=False)


def _octree(cloud: ulna.PointCloud) -> core.OcTree:
    """Cells, each with its center, edge, occupancy and the occupancy threshold."""
    edge = 2.0 * cloud.radius
    middles = (np.unique(np.floor(cloud.points / edge), axis=0) + 0.5) * edge
    return core.OcTree([np.array([*middle, edge, 0.97, 0.5]) for middle in middles], edge)
