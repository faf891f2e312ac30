"""Compares a robot read from MJCF with MuJoCo's own compiled model."""

import mujoco
import numpy as np

from pinocchio_peer import random_positions
from ulna.description.robot_description import JointType
from ulna.description.shapes import Box, Capsule, ConvexMesh, Cylinder, Sphere, UnknownShape

_GEOM, _JOINT = mujoco.mjtGeom, mujoco.mjtJoint
_KINDS = {
    _JOINT.mjJNT_FREE: {JointType.FLOATING},
    _JOINT.mjJNT_SLIDE: {JointType.PRISMATIC},
    _JOINT.mjJNT_HINGE: {JointType.REVOLUTE, JointType.CONTINUOUS},
}


class Peer:
    """A compiled model that takes the q of a robot."""

    def __init__(self, robot, model) -> None:
        self.robot, self.model, self.data = robot, model, mujoco.MjData(model)
        # What is within 1e-6 of another frame MuJoCo takes for it, instead of the model's numbers, unless it is told not to.
        model.geom_sameframe[:] = model.body_sameframe[:] = 0
        self.bodies, self.geoms, self.joints = (
            {mujoco.mj_id2name(model, kind, k) or f"{word}_{k}": k for k in range(count)}
            for word, kind, count in (
                ("body", mujoco.mjtObj.mjOBJ_BODY, model.nbody),
                ("geom", mujoco.mjtObj.mjOBJ_GEOM, model.ngeom),
                ("joint", mujoco.mjtObj.mjOBJ_JOINT, model.njnt),
            )
        )
        self.slices = dict(zip(robot.joint_names, robot.joint_slices, strict=True))
        self.mimics = {joint.name: joint.mimic for joint in robot.description.joints if joint.mimic is not None}

    def position(self, name, q):
        if name in self.slices:
            return q[self.slices[name]]
        mimic = self.mimics[name]
        return mimic.multiplier * self.position(mimic.joint, q) + mimic.offset

    def set(self, q):
        """Compute the poses of MuJoCo at a q of the robot."""
        for name, k in self.joints.items():
            value, start = self.position(name, q), self.model.jnt_qposadr[k]
            if self.model.jnt_type[k] == _JOINT.mjJNT_FREE:
                turn = np.empty(4)
                mujoco.mju_euler2Quat(turn, value[3:], "XYZ")  # about the fixed axes: roll, pitch, yaw
                value = [*value[:3], *turn]
            self.data.qpos[start : start + len(value)] = value
        mujoco.mj_kinematics(self.model, self.data)

    def farthest(self, q):
        """The largest difference of any entry of the pose of any body and geom at q, shape (n_dof,)."""
        self.set(q)
        poses, data, apart = dict(zip(self.robot.link_names, self.robot.link_poses(q), strict=True)), self.data, [0.0]
        apart += [_apart(poses[name], data.xpos[k], data.xmat[k]) for name, k in self.bodies.items()]
        for link in self.robot.description.links:
            for body in (*link.visuals, *link.collisions):
                k = self.geoms[body.name]
                apart.append(_apart(poses[link.name] @ body.pose, data.geom_xpos[k], data.geom_xmat[k]))
        return max(apart)

    def others(self):
        """What differs besides poses: the names of joints with other types or limits, and of geoms with other shapes."""
        model, wrong = self.model, []
        joints = {joint.name: joint for joint in self.robot.description.joints}
        for name, k in self.joints.items():
            limits = joints[name].limits
            expected = tuple(model.jnt_range[k]) if model.jnt_limited[k] else (-np.inf, np.inf)
            is_free = model.jnt_type[k] == _JOINT.mjJNT_FREE
            if joints[name].type not in _KINDS[_JOINT(int(model.jnt_type[k]))] or not (
                is_free or (limits.lower, limits.upper) == expected
            ):
                wrong.append(name)
        bodies = {body.name: body for link in self.robot.description.links for body in (*link.visuals, *link.collisions)}
        left_out = {message for one in self.robot.description.left_out for message in [one.message]}
        for name, k in self.geoms.items():
            if name in bodies:
                wrong += [] if _same_shape(bodies[name].shape, model, k) else [name]
            elif not any(repr(name) in message for message in left_out):
                wrong.append(name)
        return wrong


def farthest(robot, model, n):
    """The largest difference of any entry of the pose of any body and geom, over n random configurations."""
    peer = Peer(robot, model)
    return max(peer.farthest(q) for q in random_positions(robot, n))


def _apart(T, position, rotation):
    return max(np.abs(T[:3, 3] - position).max(), np.abs(T[:3, :3] - np.reshape(rotation, (3, 3))).max())


def _same_shape(shape, model, k):
    """Whether a shape is geom k: MuJoCo has half sizes, and of a mesh the points."""
    a, b, c = model.geom_size[k]
    match shape:
        case Sphere():
            kind, same = _GEOM.mjGEOM_SPHERE, shape.radius == a
        case Capsule():
            kind, same = _GEOM.mjGEOM_CAPSULE, (shape.radius, shape.length) == (a, 2 * b)
        case Cylinder():
            kind, same = _GEOM.mjGEOM_CYLINDER, (shape.radius, shape.length) == (a, 2 * b)
        case Box():
            kind, same = _GEOM.mjGEOM_BOX, shape.extents == (2 * a, 2 * b, 2 * c)
        case ConvexMesh():
            first = model.mesh_vertadr[model.geom_dataid[k]]
            points = model.mesh_vert[first : first + model.mesh_vertnum[model.geom_dataid[k]]]
            kind, same = _GEOM.mjGEOM_MESH, np.array_equal(shape.vertices, np.unique(points.astype(float), axis=0))
        case UnknownShape():
            return int(model.geom_type[k]) in {_GEOM.mjGEOM_PLANE, _GEOM.mjGEOM_HFIELD, _GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_SDF}
    return bool(model.geom_type[k] == kind and same)
