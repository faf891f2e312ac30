"""The assignment's robot class, over Ulna: the same robot from its URDF and from its Denavit-Hartenberg table.

Joints may be a list, a tuple or an array, and may be longer than seven (the fingers follow); they are never changed.
"""

import warnings

import numpy as np

import ulna
from ulna.description.pose import rpy_from_matrix

FLANGE_TO_END_EFFECTOR = (0.0, 0.0, 0.1034)  # m; not in the URDF: the assignment adds it
TOLERANCES = {"position_tolerance": 1e-10, "rotation_tolerance": 1e-10}  # of inverse kinematics [m, rad]
RETRIES, AT_LIMIT = 4, 1e-9  # descents from where joints were stuck; how near to a limit that is [rad]


def parse_urdf(path):
    """The joints of a URDF in order, the end-effector last.

    Returns:
        "origin": x, y, z, roll, pitch, yaw of each joint in its parent [m, rad], shape (n + 1, 6); "axis": the axis of each joint
        in its own frame, shape (n + 1, 3), zeros where nothing turns. For the Panda n is 8.
    """
    joints = ulna.load(path).description.joints
    origin = [[*joint.origin[:3, 3], *rpy_from_matrix(joint.origin)] for joint in joints]
    axis = [joint.axis if joint.type != "fixed" else (0.0, 0.0, 0.0) for joint in joints]
    return {"origin": np.array([*origin, (*FLANGE_TO_END_EFFECTOR, 0, 0, 0)]), "axis": np.array([*axis, (0.0, 0.0, 0.0)])}


class FrankaRobot:
    """The Franka Panda with its end-effector.

    Args:
        urdf_file_path: The course's ``franka_robot.urdf``, or another description of the arm.
        dh_params: Rows a [m], d [m], alpha [rad], theta [rad], modified convention, shape (9, 4): joints, flange, end-effector.
        num_dof: How many joints turn: 7.
    """

    def __init__(self, urdf_file_path, dh_params, num_dof):
        self.num_dof = num_dof
        self.dh_params = np.array(dh_params, dtype=float)
        self.robot_params = parse_urdf(urdf_file_path)
        self.robot = ulna.load(urdf_file_path).with_tool(ulna.pose(FLANGE_TO_END_EFFECTOR))
        fixed = len(self.dh_params) - num_dof
        self.dh_robot = ulna.Robot.from_dh(self.dh_params, joint_types=["revolute"] * num_dof + ["fixed"] * fixed)
        self.boxes = ulna.load("panda")  # carries the assignment's twelve boxes

    def forward_kinematics_urdf(self, joints):
        """The poses of the joints, the flange and the end-effector in the base, from the URDF: shape (9, 4, 4)."""
        return self.robot.link_poses(self._moving(joints))[1:]

    def forward_kinematics_dh(self, joints):
        """The same from the Denavit-Hartenberg table: shape (9, 4, 4)."""
        return self.dh_robot.link_poses(self._moving(joints))[1:]

    def ee(self, joints):
        """The end-effector as [x, y, z, roll, pitch, yaw] [m, rad], R = Rz Ry Rx; angles in (-pi, pi], pi rather than -pi."""
        T = self.robot.forward_kinematics(self._moving(joints))
        rpy = rpy_from_matrix(T)
        return np.concatenate([T[:3, 3], np.where(rpy < -np.pi + 1e-9, np.pi, rpy)])

    def jacobian(self, joints):
        """The Jacobian at the end-effector in the axes of the base, linear rows first: shape (6, 7).

        The course calls it analytical, for it is derived column by column; the field calls it geometric: its lower rows are the
        angular velocity, not the rates of roll, pitch and yaw.
        """
        return self.robot.jacobian(self._moving(joints))

    def inverse_kinematics(self, desired_ee_pos, current_joints):
        """Joints that bring the end-effector to [x, y, z, roll, pitch, yaw], by Jacobian transpose from the current ones.

        1. Descend from the current joints, brought within their limits; a joint at its limit stays there while it would be pushed
           beyond, and the others go on.
        2. Where that comes to rest short of the target, begin again from there with the joints at a limit in the middle of their
           range, up to RETRIES times.
        3. Descent may creep for ever, near a singularity for one. Then the target is left to Levenberg-Marquardt with restarts.

        Warns if none of these reaches the target, with the reason.
        """
        desired = _row("desired_ee_pos", desired_ee_pos, "x, y, z, roll, pitch, yaw")
        target, start = ulna.pose(desired[:3], desired[3:]), self._moving(current_joints)
        for _ in range(1 + RETRIES):
            found = self._descend(target, start)
            if found.success:
                break
            start = self._freed(found.q)
        else:
            found = self.robot.inverse_kinematics(target, found.q, **TOLERANCES)
        if not found.success:
            warnings.warn(f"inverse kinematics: {found}", stacklevel=2)
        joints = np.array(current_joints, dtype=float)
        joints[: self.num_dof] = found.q
        return joints

    def _descend(self, target, start):
        """Where the Jacobian transpose leads from a start."""
        return self.robot.inverse_kinematics(target, start, method="jacobian_transpose", max_iterations=100_000, **TOLERANCES)

    def _freed(self, joints):
        """The joints with those at a limit put in the middle of their range."""
        lower, upper = self.robot.lower, self.robot.upper
        at_limit = (joints <= lower + AT_LIMIT) | (joints >= upper - AT_LIMIT)
        return np.where(at_limit, (lower + upper) / 2, joints)

    def check_box_collision(self, joints, box):
        """Whether any of the twelve boxes touches the box [x, y, z, roll, pitch, yaw, length, width, height]."""
        box = _row("box", box, "x, y, z, roll, pitch, yaw, length, width, height")
        world = ulna.World()
        world.add("box", ulna.Box(extents=box[6:]), ulna.pose(box[:3], box[3:6]))
        return self.boxes.in_collision(self._moving(joints), world, self_collision=False)

    def _moving(self, joints):
        joints = np.array(joints, dtype=float)
        if joints.ndim != 1 or len(joints) < self.num_dof:
            raise ValueError(f"joints: shape {joints.shape}; one configuration of at least {self.num_dof} numbers is expected")
        return joints[: self.num_dof]


def _row(name, values, parts):
    """One row of numbers, one for each of the parts."""
    row, n = np.array(values, dtype=float), len(parts.split(", "))
    if row.shape != (n,):
        raise ValueError(f"{name}: shape {row.shape}; {n} numbers are expected: {parts}")
    return row
