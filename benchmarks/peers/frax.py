"""Runs Frax: forward kinematics and Jacobians by JAX on the CPU, compiled for the arm, in float64.

It handles one q or a batch. It reads a file, and requires every link's inertia.
"""

import os
import re

os.environ["JAX_ENABLE_X64"] = "1"

import frax
import jax
import numpy as np

from benchmarks.peer import NotForThisArm, Peer, bare_urdf, standing_offset, urdf_file
from ulna.robot import Robot

jax.config.update("jax_enable_x64", True)  # noqa: FBT003 -- JAX's own way
_INERTIA = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def arm_of(robot: Robot, ee_offset=None) -> frax.Manipulator:
    text = re.sub(r'<link name="([^"]*)"\s*/>', rf'<link name="\1">{_INERTIA}</link>', bare_urdf(robot))
    text = re.sub(r'(<link name="[^"]*"\s*>)(?!<inertial)(?=\s*</link>)', rf"\1{_INERTIA}", text)
    with urdf_file(text) as path:
        try:
            return frax.Manipulator(path, joint_ordering=list(robot.joint_names), ee_offset=ee_offset)
        except (AssertionError, ValueError, NotImplementedError, KeyError) as error:
            message = f"it cannot read the arm: {type(error).__name__} {error}"
            raise NotForThisArm(message) from None


def make(robot: Robot) -> Peer:
    """The peer for an arm; the pose of its last joint in the tip's frame is given once."""
    bare = jax.jit(arm_of(robot).ee_transform)
    offset = np.linalg.inv(standing_offset(robot, lambda q: np.asarray(bare(q))))
    arm = arm_of(robot, offset)
    forward, jacobian = jax.jit(arm.ee_transform), jax.jit(arm.ee_jacobian)
    forward_batch, jacobian_batch = jax.jit(jax.vmap(arm.ee_transform)), jax.jit(jax.vmap(arm.ee_jacobian))
    return Peer(
        forward=lambda q: np.asarray(forward(q)),
        jacobian=lambda q: np.asarray(jacobian(q)),
        forward_batch=lambda q: np.asarray(forward_batch(q)),
        jacobian_batch=lambda q: np.asarray(jacobian_batch(q)),
    )
