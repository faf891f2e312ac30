"""The assignment in plain NumPy: forward kinematics from a URDF and a DH table, Jacobian, inverse kinematics, box collisions.

Sections are numbered as in the assignment. Lengths are in meters, angles in radians. ``joints`` may be a list, a tuple or an
array. It may be longer than seven, since the fingers follow, and is never changed. Ulna is imported in one case: as the last
resort of inverse kinematics, for a target that the Jacobian transpose does not reach.
"""

import re
import warnings
import xml.etree.ElementTree as ET
from itertools import product
from math import pi

import numpy as np

HOME = (0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4)
# Section 2.2: the rows a, d, alpha, theta of joints 1 to 7, the flange and the end-effector.
DH_PARAMS = (
    (0, 0.333, 0, 0),
    (0, 0, -pi / 2, 0),
    (0, 0.316, pi / 2, 0),
    (0.0825, 0, pi / 2, 0),
    (-0.0825, 0.384, -pi / 2, 0),
    (0, 0, pi / 2, 0),
    (0.088, 0, pi / 2, 0),
    (0, 0.107, 0, 0),
    (0, 0.1034, 0, 0),
)
FLANGE_TO_END_EFFECTOR = (0, 0, 0.1034, 0, 0, 0)  # x, y, z, roll, pitch, yaw; not in the URDF
# Section 5: link, translation in the link's frame, rotation as a quaternion (w, x, y, z), size (length, width, height).
BOXES = (
    (1, (-0.04, 0, -0.283), (1, 0, 0, 0), (0.23, 0.2, 0.1)),
    (1, (-0.009, 0, -0.183), (1, 0, 0, 0), (0.13, 0.12, 0.1)),
    (1, (0, -0.032, -0.082), (0.9514, 0.3079, 0, 0), (0.12, 0.1, 0.2)),
    (1, (-0.008, 0, 0), (1, 0, 0, 0), (0.15, 0.27, 0.11)),
    (1, (0, 0.042, 0.067), (0.9514, 0.3079, 0, 0), (0.12, 0.1, 0.2)),
    (3, (0.00687, 0, -0.139), (1, 0, 0, 0), (0.13, 0.12, 0.25)),
    (4, (-0.008, 0.004, 0), (0.7071, -0.7071, 0, 0), (0.13, 0.23, 0.15)),
    (5, (0.00422, 0.05367, -0.121), (0.9962, -0.08715, 0, 0), (0.12, 0.12, 0.4)),
    (5, (0.00422, 0.00367, -0.263), (1, 0, 0, 0), (0.12, 0.12, 0.25)),
    (5, (0.00328, 0.0176, -0.0055), (1, 0, 0, 0), (0.13, 0.23, 0.12)),
    (7, (-0.0136, 0.0092, 0.0083), (0, 1, 0, 0), (0.12, 0.12, 0.2)),
    (7, (-0.0136, 0.0092, 0.1407), (0.9239, 0, 0, -0.3827), (0.08, 0.22, 0.17)),
)
TOLERANCE = 1e-10  # of inverse kinematics, for the position [m] and the rotation [rad]
RETRIES, MAX_STEPS = 4, 5000  # descents after the first one, and the maximum number of steps of each
PATIENCE = 500  # the error has to halve in this many steps; otherwise the descent ends
PARALLEL = 1e-9  # two edges count as parallel below this sine of their angle


# Section 2.1: the URDF.


def parse_urdf(urdf_file_path):
    """Read the joints of a URDF from the base to the flange, followed by the end-effector.

    Returns:
        "origin": x, y, z, roll, pitch, yaw of each joint in its parent [m, rad], shape (n + 1, 6).
        "axis": the axis of each joint in its own frame, shape (n + 1, 3); zeros for a fixed joint.
        For the Panda n is 8.
    """
    joints = _chain(urdf_file_path)
    origin = [_numbers(joint, "origin", "xyz", "0 0 0") + _numbers(joint, "origin", "rpy", "0 0 0") for joint in joints]
    axis = [_numbers(joint, "axis", "xyz", "1 0 0") if joint.get("type") != "fixed" else [0, 0, 0] for joint in joints]
    return {"origin": np.array([*origin, FLANGE_TO_END_EFFECTOR], dtype=float), "axis": np.array([*axis, (0, 0, 0)], dtype=float)}


def _chain(urdf_file_path):
    """The XML elements of the joints in a chain, from the base to the flange.

    The course's file defines a xacro macro and never calls it. So each ``${name}`` is replaced by the default of the macro. The
    joint to ``connected_to``, which is empty by default, is left out.
    """
    with open(urdf_file_path, encoding="utf-8") as file:  # noqa: PTH123 - the path may be a str
        text = file.read()
    for name, default in re.findall(r"(\w+):='([^']*)'", text):
        text = text.replace(f"${{{name}}}", default)
    joints, children = {}, set()
    for joint in ET.fromstring(text.encode()).iter("joint"):  # noqa: S314 - the course's file
        name, kind = joint.get("name"), joint.get("type")
        parent, child = (joint.find(tag).get("link") if joint.find(tag) is not None else None for tag in ("parent", "child"))
        if not parent:
            continue
        if parent in joints:
            raise ValueError(f"{urdf_file_path}: joint {name} is the second at link {parent}; one chain is expected")
        if kind not in {"revolute", "continuous", "fixed"}:
            raise ValueError(f"{urdf_file_path}: joint {name} is {kind}; revolute and fixed joints are expected")
        joints[parent] = joint
        children.add(child)
    link, chain = next((link for link in joints if link not in children), None), []
    while link in joints:
        chain.append(joints[link])
        link = chain[-1].find("child").get("link")
    if not chain or len(chain) < len(joints):
        raise ValueError(f"{urdf_file_path}: {len(chain)} of {len(joints)} joints are in a chain from the base; all are expected")
    return chain


def _numbers(joint, tag, attribute, default):
    """The numbers of an attribute. A number may be a xacro expression such as ``${pi/2}``."""
    element = joint.find(tag)
    words = (default if element is None else element.get(attribute, default)).split()
    return [_number(word[2:-1] if word.startswith("${") else word) for word in words]


def _number(word):
    """The value of a number, or of a multiple of pi such as ``-pi/2`` or ``3*pi/4``."""
    multiple = re.fullmatch(r"([+-]?)(?:([\d.]+)\*)?pi(?:/([\d.]+))?", word)
    if not multiple:
        return float(word)
    sign, factor, divisor = multiple.groups()
    return (-1 if sign == "-" else 1) * float(factor or 1) * pi / float(divisor or 1)


def joint_limits(urdf_file_path):
    """The lower and upper limits of the revolute joints [rad], shape (n,) each; infinite without a limit."""
    lower, upper = [], []
    for joint in _chain(urdf_file_path):
        if joint.get("type") != "fixed":
            limit = joint.find("limit")
            has_limits = limit is not None and joint.get("type") == "revolute"
            lower.append(float(limit.get("lower", 0)) if has_limits else -np.inf)
            upper.append(float(limit.get("upper", 0)) if has_limits else np.inf)
    return np.array(lower), np.array(upper)


# Rotations.


def rotation_from_rpy(roll, pitch, yaw):
    """The rotation matrix R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF, shape (3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])  # fmt: skip


def rpy_from_rotation(R):
    """Roll, pitch, yaw of a rotation, each in (-pi, pi]. At a pitch of +-90 degrees the roll is 0."""
    cos_pitch = np.hypot(R[0, 0], R[1, 0])
    roll = np.arctan2(R[2, 1], R[2, 2]) if cos_pitch > 1e-12 else 0.0
    s, c = np.sin(roll), np.cos(roll)
    yaw = np.arctan2(s * R[0, 2] - c * R[0, 1], c * R[1, 1] - s * R[1, 2])
    angles = np.array([roll, np.arctan2(-R[2, 0], cos_pitch), yaw])
    return np.where(angles < -pi + 1e-9, pi, angles)


def rotation_from_quaternion(w, x, y, z):
    """The rotation matrix of a quaternion, shape (3, 3). It is normalized, since the table has four digits."""
    w, x, y, z = np.array([w, x, y, z]) / np.linalg.norm([w, x, y, z])
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def skew(axis):
    """The skew-symmetric matrix K of an axis, shape (3, 3): K v is axis x v."""
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def rotation_vector(R):
    """The axis of a rotation times its angle in [0, pi], shape (3,)."""
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2  # sin(angle) times the axis
    angle = np.arctan2(np.linalg.norm(sine), (np.trace(R) - 1) / 2)
    if angle < pi - 1e-4:
        return sine * (angle / np.sin(angle) if angle > 1e-8 else 1.0)
    # Near pi the sine vanishes. The largest column of (R + R') / 2 + I then points along the axis.
    columns = (R + R.T) / 2 + np.eye(3)
    axis = columns[:, np.argmax(np.diag(columns))]
    return angle * axis / np.linalg.norm(axis) * (-1 if axis @ sine < 0 else 1)


def homogeneous(R, p):
    """The transformation matrix of a rotation (3, 3) and a translation (3,), shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    return T


def dh_transform(a, d, alpha, theta):
    """The transformation T = Rot_x(alpha) Trans_x(a) Trans_z(d) Rot_z(theta) of section 2.2, shape (4, 4)."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    rot_x = np.array([[1, 0, 0, 0], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
    trans = np.array([[1, 0, 0, a], [0, 1, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])  # Trans_x(a) and Trans_z(d), which commute
    rot_z = np.array([[ct, -st, 0, 0], [st, ct, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return rot_x @ trans @ rot_z


class FrankaRobot:
    """The Franka Panda with its end-effector.

    Args:
        urdf_file_path: The course's ``franka_robot.urdf``, or the URDF of another arm with one chain of revolute joints.
        dh_params: Rows a [m], d [m], alpha [rad], theta [rad] in the modified (Craig) convention, shape (9, 4).
        num_dof: The number of revolute joints: 7.
    """

    def __init__(self, urdf_file_path, dh_params, num_dof):
        self.urdf_file_path, self.num_dof = urdf_file_path, num_dof
        self.dh_params = np.array(dh_params, dtype=float)
        self.robot_params = parse_urdf(urdf_file_path)
        origin, axis = self.robot_params["origin"], self.robot_params["axis"]
        self.origins = np.array([homogeneous(rotation_from_rpy(*rpy), (x, y, z)) for x, y, z, *rpy in origin])
        self.lower, self.upper = joint_limits(urdf_file_path)
        self.turns = axis.any(axis=1)  # whether the joint of each frame is revolute
        self.axes = axis[self.turns] / np.linalg.norm(axis[self.turns], axis=1, keepdims=True)
        self.K = np.zeros((len(self.axes), 4, 4))
        self.K[:, :3, :3] = [skew(unit) for unit in self.axes]
        if len(self.lower) != num_dof or self.turns.sum() != num_dof:
            raise ValueError(f"num_dof: {num_dof}, but {self.turns.sum()} joints of {urdf_file_path} turn about an axis")
        if self.dh_params.ndim != 2 or self.dh_params.shape[1] != 4 or len(self.dh_params) < num_dof:
            raise ValueError(f"dh_params: shape {self.dh_params.shape}; rows a, d, alpha, theta are expected, one for each frame")

    # Section 2: forward kinematics.

    def forward_kinematics_urdf(self, joints):
        """The poses of the joints, the flange and the end-effector in the base, from the URDF, shape (9, 4, 4).

        T_i = T_(i-1) origin_i R_i, where R_i is the rotation about the axis of joint i by q_i. Rodrigues' formula:
        R_i = I + sin(q_i) K_i + (1 - cos(q_i)) K_i K_i.
        """
        turned, angle = self.origins.copy(), self._moving(joints)[:, None, None]
        turned[self.turns] = turned[self.turns] @ (np.eye(4) + np.sin(angle) * self.K + (1 - np.cos(angle)) * self.K @ self.K)
        frames = [turned[0]]
        for T in turned[1:]:
            frames.append(frames[-1] @ T)
        return np.array(frames)

    def forward_kinematics_dh(self, joints):
        """The same poses as products of the Denavit-Hartenberg transformations, shape (9, 4, 4)."""
        joints, T, frames = self._moving(joints), np.eye(4), []
        for i, (a, d, alpha, theta) in enumerate(self.dh_params):
            T = T @ dh_transform(a, d, alpha, theta + (joints[i] if i < self.num_dof else 0))
            frames.append(T)
        return np.array(frames)

    def ee(self, joints):
        """The end-effector's [x, y, z, roll, pitch, yaw] [m, rad]: R = Rz Ry Rx, angles in (-pi, pi]."""
        T = self.forward_kinematics_urdf(joints)[-1]
        return np.concatenate([T[:3, 3], rpy_from_rotation(T[:3, :3])])

    # Section 3: the Jacobian.

    def jacobian(self, joints):
        """The Jacobian at the end-effector in the axes of the base, linear rows first, shape (6, 7).

        Joint i turns about the axis z_i through the point p_i. Its column is the velocity z_i x (p_ee - p_i) of the end-effector
        p_ee, and the angular velocity z_i. The course calls the matrix analytical, because it is derived column by column. The
        field calls it geometric, since its lower rows are not the rates of roll, pitch and yaw.
        """
        return self._jacobian(self.forward_kinematics_urdf(joints))

    def _jacobian(self, frames):
        p_ee, columns = frames[-1, :3, 3], []
        for T, axis in zip(frames[self.turns], self.axes, strict=True):
            z = T[:3, :3] @ axis
            columns.append([*(skew(z) @ (p_ee - T[:3, 3])), *z])
        return np.transpose(columns)

    # Section 4: inverse kinematics.

    def inverse_kinematics(self, desired_ee_pos, current_joints):
        """Find joints that bring the end-effector to [x, y, z, roll, pitch, yaw], by the Jacobian transpose.

        1. Clip the current joints to their limits, and descend from them.
        2. If the descent ends before the target, put the joints at a limit in the middle of their range. Descend again, up to
           RETRIES times.
        3. If all descents fail, for example because one converges slowly near a singularity, use Ulna. This is not part of the
           assignment.

        Warns with the reason if no joints reach the target. Joints beyond ``num_dof`` are returned unchanged.
        """
        desired = _row("desired_ee_pos", desired_ee_pos, "x, y, z, roll, pitch, yaw")
        target = homogeneous(rotation_from_rpy(*desired[3:]), desired[:3])
        q = self._moving(current_joints)
        for _ in range(1 + RETRIES):
            q, has_arrived = self._descend(target, q)
            if has_arrived:
                break
            at_limit = (q <= self.lower) | (q >= self.upper)
            if not at_limit.any():
                break
            q = np.where(at_limit, (self.lower + self.upper) / 2, q)
        joints = np.array(current_joints, dtype=float)
        joints[: self.num_dof] = q if has_arrived else self._by_ulna(target, q)
        return joints

    def _descend(self, target, q):
        """Descend from q by the Jacobian transpose. Returns the last q, and whether it is at the target.

        Let e be the position error and the rotation vector from the pose to the target. g = J' e is the direction of steepest
        descent of e' e / 2. The step alpha g with alpha = <e, J g> / <J g, J g> is optimal for a linear arm. It is halved until
        the error decreases. A joint at its limit stays there if g would push it beyond. A descent ends if the error does not
        halve in PATIENCE steps.
        """
        q = np.clip(q, self.lower, self.upper)
        frames = self.forward_kinematics_urdf(q)
        e = _error(target, frames[-1])
        error_before = np.inf
        for step in range(MAX_STEPS):
            if np.linalg.norm(e[:3]) <= TOLERANCE and np.linalg.norm(e[3:]) <= TOLERANCE:
                return q, True
            if step % PATIENCE == 0:
                if np.linalg.norm(e) > error_before / 2:
                    break
                error_before = np.linalg.norm(e)
            J = self._jacobian(frames)
            g = J.T @ e
            g[(q <= self.lower) & (g < 0) | (q >= self.upper) & (g > 0)] = 0
            Jg = J @ g
            if not Jg.any():
                break
            alpha = (e @ Jg) / (Jg @ Jg)
            while True:
                tried = np.clip(q + alpha * g, self.lower, self.upper)
                tried_frames = self.forward_kinematics_urdf(tried)
                tried_e = _error(target, tried_frames[-1])
                if tried_e @ tried_e < e @ e:
                    break
                alpha /= 2
                if (q + alpha * g == q).all():
                    return q, False
            q, frames, e = tried, tried_frames, tried_e
        return q, False

    def _by_ulna(self, target, q):
        """Solve by Ulna's Levenberg-Marquardt search with restarts: the last resort, not part of the assignment."""
        import ulna  # noqa: PLC0415 - needed here only

        robot = ulna.load(self.urdf_file_path).with_tool(homogeneous(np.eye(3), FLANGE_TO_END_EFFECTOR[:3]))
        found = robot.inverse_kinematics(target, q, position_tolerance=TOLERANCE, rotation_tolerance=TOLERANCE)
        if not found.success:
            warnings.warn(f"inverse kinematics: {found}", stacklevel=3)
        return found.q

    # Section 5: collision checking.

    def check_box_collision(self, joints, box):
        """Whether any of the twelve boxes touches the box [x, y, z, roll, pitch, yaw, length, width, height]."""
        box = _row("box", box, "x, y, z, roll, pitch, yaw, length, width, height")
        if (box[6:] <= 0).any():
            raise ValueError(f"box: length, width and height {box[6:].tolist()}; positive numbers are expected")
        frames = self.forward_kinematics_urdf(joints)
        other = homogeneous(rotation_from_rpy(*box[3:6]), box[:3])
        return any(
            boxes_overlap(frames[link - 1] @ homogeneous(rotation_from_quaternion(*rotation), position), size, other, box[6:])
            for link, position, rotation, size in BOXES
        )

    def _moving(self, joints):
        """The positions of the revolute joints, as a new array."""
        joints = np.array(joints, dtype=float)
        if joints.ndim != 1 or len(joints) < self.num_dof:
            raise ValueError(f"joints: shape {joints.shape}; one configuration of at least {self.num_dof} numbers is expected")
        if not np.isfinite(joints).all():
            raise ValueError(f"joints: {joints.tolist()}; finite numbers are expected")
        return joints[: self.num_dof]


def boxes_overlap(T_a, size_a, T_b, size_b):
    """Whether two boxes touch, by the separating-axis theorem. T: pose of the center, (4, 4); size: full lengths, (3,).

    Two convex bodies are disjoint exactly if their projections onto some axis are. For boxes 15 axes suffice: the three edges of
    each, and the cross products of an edge of one with an edge of the other. The projection of a box onto an axis L extends from
    its center by the sum of |half length * (edge . L)| over its edges. Source: Gottschalk, Lin and Manocha, 1996.
    """
    edges_a, edges_b = T_a[:3, :3].T, T_b[:3, :3].T  # one edge direction per row
    between = T_b[:3, 3] - T_a[:3, 3]
    crossed = [np.cross(a, b) for a, b in product(edges_a, edges_b)]
    for L in (*edges_a, *edges_b, *(L for L in crossed if np.linalg.norm(L) > PARALLEL)):
        reach = (np.abs(edges_a @ L) @ size_a + np.abs(edges_b @ L) @ size_b) / 2
        if abs(between @ L) > reach:
            return False
    return True


def _error(target, T):
    """The pose error (p - p_T, rotation vector of R R_T') of T to a target (p, R), shape (6,)."""
    return np.concatenate([target[:3, 3] - T[:3, 3], rotation_vector(target[:3, :3] @ T[:3, :3].T)])


def _row(name, values, parts):
    """Check one row of finite numbers. parts: their names."""
    row, n = np.array(values, dtype=float), len(parts.split(", "))
    if row.shape != (n,):
        raise ValueError(f"{name}: shape {row.shape}; {n} numbers are expected: {parts}")
    if not np.isfinite(row).all():
        raise ValueError(f"{name}: {row.tolist()}; finite numbers are expected")
    return row
