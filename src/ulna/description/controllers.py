"""Converts poses from and to the notation of robot controllers: units, and the angle convention of each maker."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import (
    as_pose,
    matrix_from_rpy,
    pose,
    quaternion_from_matrix,
    rotation_vector_from_matrix,
    rpy_from_matrix,
)
from ulna.errors import InputError, did_you_mean

Array = NDArray[np.float64]
_DEGREES, _NO_UNIT = 180.0 / np.pi, 1.0


class Controller(NamedTuple):
    """The notation of a controller for poses.

    Attributes:
        name: Its maker, or its family.
        labels: Its names of the numbers, in order: three for the position, then those of the orientation.
        turns: ``"rpy"``: about fixed x, y, z; ``"ZYX"``, ``"XYZ"``, ``"ZYZ"``: about moving axes; ``"rotvec"``: a rotation
            vector; ``"wxyz"``: a quaternion.
        per_meter: Units of length per meter.
        per_radian: Units of angle per radian.
    """

    name: str
    labels: tuple[str, ...]
    turns: str
    per_meter: float = 1000.0
    per_radian: float = _DEGREES

    @property
    def units(self) -> str:
        """Its units in words, such as "mm, deg"."""
        turns = {_DEGREES: ", deg", _NO_UNIT: ", rad"}[self.per_radian] if self.turns != "wxyz" else ""
        return ("mm" if self.per_meter > 1.0 else "m") + turns


CONTROLLERS = {
    one.name: one
    for one in (
        Controller("ABB", ("x", "y", "z", "q1", "q2", "q3", "q4"), "wxyz", 1000.0, _NO_UNIT),
        Controller("Doosan", ("X", "Y", "Z", "A", "B", "C"), "ZYZ"),
        Controller("Fanuc", ("X", "Y", "Z", "W", "P", "R"), "rpy"),
        Controller("Kawasaki", ("X", "Y", "Z", "O", "A", "T"), "ZYZ"),
        Controller("Kinova", ("x", "y", "z", "theta_x", "theta_y", "theta_z"), "rpy", 1.0),
        Controller("KUKA", ("X", "Y", "Z", "A", "B", "C"), "ZYX"),
        Controller("Staubli", ("X", "Y", "Z", "Rx", "Ry", "Rz"), "XYZ"),
        Controller("UR", ("x", "y", "z", "rx", "ry", "rz"), "rotvec", 1.0, _NO_UNIT),
        Controller("Yaskawa", ("X", "Y", "Z", "Rx", "Ry", "Rz"), "rpy"),
    )
}


def controller_named(name: object, argument: str = "controller") -> Controller:
    """The controller of a name, in capital or small letters, with or without the dots of an umlaut."""
    plain = str(name).casefold().replace("\u00e4", "a") if isinstance(name, str) else ""
    found = next((one for key, one in CONTROLLERS.items() if key.casefold() == plain), None)
    if found is None:
        raise InputError(argument, f"{name!r} is not known{did_you_mean(str(name), CONTROLLERS, most=len(CONTROLLERS))}")
    return found


def pose_from(numbers: ArrayLike, controller: str) -> Array:
    """The homogeneous matrix of a pose in the units and angle convention of a robot's controller.

    Args:
        numbers: The position and the orientation, shape (..., 6), or (..., 7) for ABB.
        controller: The controller: ``"ABB"`` (mm, quaternion q1 q2 q3 q4); ``"Doosan"``, ``"Fanuc"``, ``"Kawasaki"``, ``"KUKA"``,
            ``"Staubli"`` or ``"Yaskawa"`` (mm, deg); ``"Kinova"`` (m, deg); ``"UR"`` (m, rad: a rotation vector, as in URScript).

    Returns:
        T, shape (..., 4, 4), in the frame of the numbers.

    Raises:
        InputError: The name is unknown, the shape is wrong, or an entry is not finite.

    Example:
        >>> pose_from([280, 0, -10, 30, 90, 0], "KUKA")[:3, 3]
        array([ 0.28,  0.  , -0.01])
    """
    said = controller_named(controller)
    values = as_floats("numbers", numbers)
    if values.shape[-1:] != (len(said.labels),):
        raise InputError("numbers", f"shape {values.shape}; {said.name} states {', '.join(said.labels)} [{said.units}]")
    if not np.isfinite(values).all():
        raise InputError("numbers", "has an entry that is not finite")
    xyz, turn = values[..., :3] / said.per_meter, values[..., 3:] / said.per_radian
    match said.turns:
        case "wxyz":
            return pose(xyz, wxyz=turn)
        case "rotvec":
            return pose(xyz, rotvec=turn)
        case "rpy":
            return pose(xyz, turn)
        case "ZYX":
            return pose(xyz, turn[..., ::-1])
    T = pose(xyz)
    if said.turns == "XYZ":  # the inverse turns by the negative angles in reverse order
        T[..., :3, :3] = np.swapaxes(matrix_from_rpy(-turn), -1, -2)
    else:
        first, second, third = np.moveaxis(turn, -1, 0)
        zero = np.zeros_like(first)
        R_zy, R_z = matrix_from_rpy(np.stack([zero, second, first], -1)), matrix_from_rpy(np.stack([zero, zero, third], -1))
        T[..., :3, :3] = R_zy @ R_z
    return T


def pose_as(T: ArrayLike, controller: str) -> Array:
    """Express a pose in the notation of a robot's controller: the inverse of ``pose_from``.

    Args:
        T: Poses, shape (..., 4, 4).
        controller: The controller, as for ``pose_from``.

    Returns:
        The numbers, shape (..., 6), or (..., 7) for ABB, in the controller's units. Angles lie in [-180, 180] deg. The second of
        three angles about x, y and z lies in [-90, 90], of ZYZ in [0, 180]. If only a sum of the first and the last angle is
        defined, the angle about x is 0, of ZYZ the last one. A rotation vector is at most pi long.

    Raises:
        InputError: The name is unknown, or T is not a pose.

    Example:
        >>> pose_as(pose((0.4, 0.0, 0.6), (0, 0, 0)), "Fanuc")
        array([400.,   0., 600.,   0.,   0.,   0.])
    """
    said = controller_named(controller)
    poses = as_pose(T)
    R = poses[..., :3, :3]
    match said.turns:
        case "wxyz":
            turn = quaternion_from_matrix(R)
        case "rotvec":
            turn = rotation_vector_from_matrix(R)
        case "rpy":
            turn = rpy_from_matrix(R)
        case "ZYX":
            turn = rpy_from_matrix(R)[..., ::-1]
        case "XYZ":
            turn = -rpy_from_matrix(np.swapaxes(R, -1, -2))
        case _:
            turn = _zyz(R)
    return np.concatenate([poses[..., :3, 3] * said.per_meter, turn * said.per_radian], axis=-1) + 0.0


def _zyz(R: Array) -> Array:
    """The angles of Rz Ry Rz; the third one is 0 if the second one is 0 or pi."""
    across = np.hypot(R[..., 0, 2], R[..., 1, 2])
    first = np.arctan2(R[..., 1, 2], R[..., 0, 2])
    alone = np.where(R[..., 2, 2] > 0.0, np.arctan2(R[..., 1, 0], R[..., 0, 0]), np.arctan2(-R[..., 1, 0], -R[..., 0, 0]))
    first = np.where(across < 1e-12, alone, first)
    s, c = np.sin(first), np.cos(first)  # the second row of Rz(-first) R is (sin(third), cos(third), 0)
    third = np.arctan2(c * R[..., 1, 0] - s * R[..., 0, 0], c * R[..., 1, 1] - s * R[..., 0, 1])
    return np.stack([first, np.arctan2(across, R[..., 2, 2]), np.where(across < 1e-12, 0.0, third)], axis=-1)
