"""Runs VAMP: RRT-Connect in C++ for one robot, eight sampled configurations at a time.

Source: Thomason, Kingston and Kavraki, ICRA 2024. The package is ``vamp-planner``; it is float32, and its robots are compiled
into it. Its own clock excludes the calls from Python and the setup of the objects, so the whole call is timed too.
"""

import time
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import vamp
from numpy.typing import NDArray
from vamp.constants import POINT_RADIUS, ROBOT_FIRST_JOINT_LOCATIONS, ROBOT_MAX_RADII
from vamp.transformations import euler_from_matrix

from benchmarks.peer import NotForThisArm
from benchmarks.vamp_problems import PlanningProblem

WIDTH = 8  # configurations that it checks together
FILTER_RADIUS = 0.02  # [m], the default of its script


class Found(NamedTuple):
    """VAMP's result for a problem.

    Attributes:
        first, path: The configurations of its path, and of the simplified one; None without one.
        plan_s, whole_s: Its time for planning, and for planning and simplifying, by its own clock [s].
        call_s: The time of the two calls [s].
    """

    first: NDArray | None
    path: NDArray | None
    plan_s: float
    whole_s: float
    call_s: float


class Vamp:
    """VAMP's planner for a robot, with its own settings, and its checker."""

    def __init__(self, name: str, joints: tuple[str, ...]) -> None:
        if name not in vamp.robots:
            raise NotForThisArm(f"it has no robot {name}")
        self._name = name
        self._robot, self._plan, self._settings, self._simplify = vamp.configure_robot_and_planner_with_kwargs(name, "rrtc")
        theirs = list(self._robot.joint_names())
        self._to_theirs = [joints.index(joint) for joint in theirs]  # its order starts with the joints of Baxter's left arm
        self._to_ours = [theirs.index(joint) for joint in joints]
        self._settings.max_samples = 100_000  # it allocates memory for them: a million take longer than most plans
        self._sampler = self._robot.halton()

    def environment(self, problem: PlanningProblem):
        """The objects, made by its own reader of these problems."""
        environment = vamp.Environment()
        for _, kind, sizes, T in problem.objects:
            place, angles = T[:3, 3].tolist(), euler_from_matrix(T)
            if kind == "sphere":
                environment.add_sphere(vamp.Sphere(place, sizes[0]))
            elif kind == "box":
                environment.add_cuboid(vamp.Cuboid(place, angles, [size / 2 for size in sizes]))
            elif problem.name == "box":
                length, radius = sizes
                environment.add_cuboid(vamp.Cuboid(place, angles, [radius, radius, length / 2]))
            else:
                length, radius = sizes
                environment.add_capsule(vamp.Cylinder(place, angles, radius, length))
        return environment

    def cloud(self, points: NDArray) -> tuple[vamp.Environment, NDArray, float]:
        """Process points like its ``scripts/evaluate_mbm.py --pointcloud``.

        Returns the environment, the filtered points, and the time of the filter and of the tree by its own clock [s].
        """
        origin, reach = ROBOT_FIRST_JOINT_LOCATIONS[self._name], ROBOT_MAX_RADII[self._name]
        corners = [[x + sign * reach for x in origin] for sign in (-1, 1)]
        points = np.ascontiguousarray(points, dtype=np.float32)
        kept, filtering = vamp.filter_pointcloud(points, FILTER_RADIUS, reach, origin, *corners, True)  # noqa: FBT003
        environment = vamp.Environment()
        building = environment.add_pointcloud(kept, *self._robot.min_max_radii(), POINT_RADIUS)
        return environment, np.array(kept, dtype=float), 1e-9 * (filtering + building)

    def is_free(self, q: NDArray, environment) -> bool:
        """Whether a configuration is free."""
        return self._robot.validate(q[self._to_theirs].astype(np.float32), environment)

    def solve(self, problem: PlanningProblem, environment) -> Found:
        """Plan and simplify, with the same samples for each problem."""
        start, goal = problem.start[self._to_theirs].tolist(), [problem.goal[self._to_theirs].tolist()]
        self._sampler.reset()
        began = time.thread_time()
        result = self._plan(start, goal, environment, self._settings, self._sampler)
        if not result.solved:
            return Found(None, None, *[np.nan] * 3)
        simple = self._robot.simplify(result.path, environment, self._simplify, self._sampler)
        call = time.thread_time() - began
        plan = 1e-9 * result.nanoseconds
        paths = (np.array(each.path.numpy(), dtype=float)[:, self._to_ours] for each in (result, simple))
        return Found(*paths, plan, plan + 1e-9 * simple.nanoseconds, call)

    def touches(self, path: NDArray, environment, finer: float) -> bool:
        """Whether a path touches anything, itself or an object, by its checker; ``finer``: samples per radian."""
        for a, b in pairwise(path):
            n = max(1, int(np.ceil(np.linalg.norm(b - a) * finer / WIDTH)))
            q = (a + np.linspace(0.0, 1.0, n + 1)[:, None] * (b - a))[:, self._to_theirs].astype(np.float32)
            # It checks eight configurations, at 1/8 to 8/8 of the way, for such a short way.
            if not all(self._robot.validate_motion(q[i], q[i + 1], environment, False) for i in range(n)):  # noqa: FBT003
                return True
        return False
