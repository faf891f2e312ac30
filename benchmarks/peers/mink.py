"""Runs mink (Apache-2.0, ``pip install "mink[daqp]"``): follows a pose by a quadratic program per tick, in MuJoCo's model.

It has limits of position and velocity, and of collisions for the pairs that Ulna checks, but none of acceleration.
"""

from importlib.metadata import version
from itertools import product

import mink
import mujoco
import numpy as np

import ulna
from benchmarks.peer import NotForThisArm, bare_urdf
from benchmarks.servo_scenes import CLEARANCE, RATE

VERSION = version("mink")
WITHIN = 0.05  # [m]: beyond the clearance; pairs farther apart have no constraint


class Follower:
    """Follows poses. ``infeasible`` counts the ticks without a solution, in which it stays in place."""

    def __init__(self, robot: ulna.Robot, world: ulna.World | None, q, _acceleration: float) -> None:
        spec = mujoco.MjSpec.from_string(bare_urdf(robot))
        spec.compiler.fusestatic = False
        spec.compiler.boundmass = spec.compiler.boundinertia = 1e-3
        bodies = []
        for link in robot.description.links:
            body = spec.body(link.name) or spec.worldbody  # the base is welded to the world
            bodies += [_add(spec, body, f"own {len(bodies) + k}", one.shape, one.pose) for k, one in enumerate(link.collisions)]
        things = [] if world is None else [_add(spec, spec.worldbody, f"world {n}", s, T) for n, s, T in world.items()]
        pairs = [([a], [b]) for a, b in product(bodies, things)]
        pairs += [([bodies[i]], [bodies[j]]) for i, j in robot._checker.pairs]  # noqa: SLF001 - so that both avoid the same
        model = spec.compile()
        if [model.joint(k).name for k in range(model.njnt)] != list(robot.joint_names):
            raise NotForThisArm("its joints are in another order")
        self._configuration, self.infeasible = mink.Configuration(model, np.array(q)), 0
        self._hand = mink.FrameTask(robot.tip, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
        posture = mink.PostureTask(model, cost=1e-3)
        posture.set_target(np.array(q))
        self._tasks = [self._hand, posture]
        velocities = dict(zip(robot.joint_names, robot.velocity_limits, strict=True))
        near = mink.CollisionAvoidanceLimit(
            model, pairs, minimum_distance_from_collisions=CLEARANCE, collision_detection_distance=CLEARANCE + WITHIN
        )
        self._limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, velocities), near]

    def step(self, T):
        """The next q, towards a pose of the tip."""
        self._hand.set_target(mink.SE3.from_matrix(T))
        try:
            v = mink.solve_ik(self._configuration, self._tasks, 1 / RATE, "daqp", damping=1e-6, limits=self._limits)
            self._configuration.integrate_inplace(v, 1 / RATE)
        except mink.NoSolutionFound:
            self.infeasible += 1
        return self._configuration.q.copy()


def _add(spec, body, name: str, shape, T) -> str:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(T[:3, :3]).ravel())
    place = {"name": name, "pos": T[:3, 3], "quat": quaternion}
    match shape:
        case ulna.Box(extents):
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=np.array(extents) / 2, **place)
        case ulna.Sphere(radius):
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], **place)
        case ulna.Cylinder(radius, length):
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, length / 2, 0], **place)
        case ulna.ConvexMesh():
            spec.add_mesh(name=name, uservert=np.asarray(shape.vertices).ravel())
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **place)
        case _:
            raise NotForThisArm(f"{type(shape).__name__} is not compared")
    return name
