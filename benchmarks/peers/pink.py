"""Runs Pink (Apache-2.0, ``pip install pin-pink daqp``): follows a pose by a quadratic program per tick, in Pinocchio's model.

It has limits of position, velocity and acceleration; a barrier separates the nearest of the pairs that Ulna checks.
"""

import warnings
from importlib.metadata import version

import numpy as np
import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.limits import AccelerationLimit, ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask, PostureTask

import ulna
from benchmarks.peer import NotForThisArm
from benchmarks.peers.coal import Scene
from benchmarks.servo_scenes import CLEARANCE, RATE

VERSION = version("pin-pink")
MAX_PAIRS = 24  # the number of Ulna's servo
GAIN = 20.0  # of the barrier, as in pink's examples


class Follower:
    """Follows poses. ``infeasible`` counts the ticks without a solution, in which it stays in place."""

    def __init__(self, robot: ulna.Robot, world: ulna.World | None, q, acceleration: float) -> None:
        scene = Scene(robot, ulna.World() if world is None else world, itself=True)
        model = scene.model
        if list(model.names)[1:] != list(robot.joint_names):
            raise NotForThisArm("its joints are in another order")
        model.velocityLimit = np.array(robot.velocity_limits)
        self._configuration = pink.Configuration(
            model, scene.data, np.array(q), collision_model=scene.geometry, collision_data=scene.answers
        )
        self.infeasible = 0
        self._hand = FrameTask(robot.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
        posture = PostureTask(cost=1e-3)
        posture.set_target(np.array(q))
        self._tasks = [self._hand, posture]
        self._acceleration = AccelerationLimit(model, np.full(model.nv, acceleration))
        self._limits = [ConfigurationLimit(model), VelocityLimit(model), self._acceleration]
        n = min(MAX_PAIRS, scene.n_pairs)
        self._barriers = [SelfCollisionBarrier(n, gain=GAIN, safe_displacement_gain=1.0, d_min=CLEARANCE)]

    def step(self, T):
        """The next q, towards a pose of the tip."""
        self._hand.set_target(pin.SE3(T))
        try:
            with warnings.catch_warnings(action="ignore"):
                v = pink.solve_ik(
                    self._configuration,
                    self._tasks,
                    1 / RATE,
                    "daqp",
                    limits=self._limits,
                    barriers=self._barriers,
                    safety_break=False,
                )
        except pink.PinkError:
            self.infeasible += 1
            v = np.zeros(self._configuration.model.nv)
        self._acceleration.set_last_integration(v, 1 / RATE)
        self._configuration.integrate_inplace(v, 1 / RATE)
        return np.array(self._configuration.q)
