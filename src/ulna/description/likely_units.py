"""Warns of lengths and angles that are more likely in another unit than meters and radians.

A size alone is never refused: there are arms of millimeters, and arms of a hundred meters. Only an impossible value raises an
error: a depth image in which even the nearest depth is beyond ``FAR``, farther than any depth camera sees.
"""

import math
import sys
import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.robot_description import Description, Joint, JointType
from ulna.description.shapes import ConvexMesh, HalfSpace, kind_of
from ulna.description.structure import joints_from_root, root_link
from ulna.errors import InputError, UnitWarning, count_of

Array = NDArray[np.floating]
FAR = 100.0  # [m]: beyond the reach of any arm and any depth camera; tables in millimeters exceed it
_LONGEST = 10_000.0  # [m]: in millimeters, longer than any arm
_DIGIT, _ROUNDING = 1e-4, 1e-8  # digits of a drawing in millimeters
_NEAR = 0.005  # [m]: closer than any camera focuses
_LARGEST_CELL = 5.0  # [m]
_LARGEST_PADDING, _LARGEST_BALL = 1.0, 1.0  # [m]
_MILLIMETERS_A_SECOND = 100.0, 5000.0  # speeds that suggest mm/s; larger ones mean "anywhere at once"
_STEEP, _HIGH = 10.0, 10.0  # heights over the width of their map, and [m]
TWO_TURNS = 4 * math.pi
_IN_MILLIMETERS = "are these millimeters? Lengths are meters"
_IN_DEGREES = "are these degrees? Angles are radians"


def warn_of_unit(name: str, message: str) -> None:
    """Give a ``UnitWarning`` about an argument, at the line outside Ulna that makes the call."""
    frame, level = sys._getframe(1), 2  # noqa: SLF001 - warnings takes a level, and no module, before Python 3.12
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "ulna":
        frame, level = frame.f_back, level + 1
    warnings.warn(f"{name}: {message}", UnitWarning, stacklevel=level)


def check_depths(z: Array) -> None:
    """Check the depths of an image [m], 0 where nothing was measured.

    Raises:
        InputError: The nearest is farther than any depth camera sees.
    """
    seen = z[z > 0]
    if not len(seen):
        return
    nearest, farthest = float(seen.min()), float(seen.max())
    if nearest > FAR:
        raise InputError(
            "depth",
            f"the nearest of {count_of(len(seen), 'depth')} is {nearest:.4g} m, and no depth camera sees as far; "
            "depth_scale=0.001 reads millimeters",
        )
    if float(np.median(seen)) > FAR:
        warn_of_unit(
            "depth",
            f"half of the depths are beyond {FAR:g} m: are these millimeters (depth_scale=0.001)? "
            "If so large a number means no measurement, max_depth= leaves it out",
        )
    elif farthest < _NEAR:
        warn_of_unit("depth", f"the farthest is {farthest:.2g} m: is it scaled twice? depth_scale=1 reads meters")


def check_points(name: str, points: Array) -> None:
    """Check the points of a cloud [m], shape (n, 3)."""
    if not len(points) or max(-points.min(), points.max()) <= FAR:
        return
    distance = float(np.median(np.linalg.norm(points, axis=1)))
    if distance > FAR:
        warn_of_unit(name, f"half of them are beyond {distance:.4g} m from the origin: {_IN_MILLIMETERS}")


def check_place(name: str, T: Array) -> None:
    """Check a pose (4, 4) of something in the arm's cell."""
    distance = math.hypot(T.item(3), T.item(7), T.item(11))
    if distance > FAR:
        warn_of_unit(name, f"{distance:.4g} m from the origin: {_IN_MILLIMETERS}")


def check_voxel(edge: float, points: Array) -> None:
    """Check the edge of the voxels [m] that each keep one point of a cloud, shape (n, 3)."""
    if edge >= _LARGEST_CELL and edge > np.ptp(points, axis=0).max():
        warn_of_unit("voxel", f"{edge:g} m, more than the whole cloud: {_IN_MILLIMETERS}")


def check_cell(edge: float) -> None:
    """Check the edge of the cells of a grid [m]."""
    if edge >= _LARGEST_CELL:
        warn_of_unit("cell", f"{edge:g} m: {_IN_MILLIMETERS}")


def check_heights(heights: Array, bottom: float, cell: float) -> None:
    """Check the columns of a height map: from ``bottom`` up [m], cells of an edge [m]."""
    width, highest = cell * max(heights.shape), float(heights.max())
    height = highest - bottom
    if (height > _HIGH and height > _STEEP * width) or (float(heights.min()) > FAR and width < FAR):
        warn_of_unit("heights", f"up to {highest:.4g} m, on a map of {width:.4g} m: {_IN_MILLIMETERS}")


def check_ball(radius: float) -> None:
    """Check the radius of the points of a cloud [m]."""
    if radius > _LARGEST_BALL:
        warn_of_unit("radius", f"each point is a ball of {radius:g} m: {_IN_MILLIMETERS}")


def check_speed(speed: float) -> None:
    """Check the speed of an object that may move by itself [m/s]."""
    least, most = _MILLIMETERS_A_SECOND
    if least < speed < most:
        warn_of_unit("speed", f"{speed:g} m/s: are these millimeters a second? Speeds are meters a second")


def check_padding(padding: float) -> None:
    """Check the distance from a robot within which points count as its own [m]."""
    if padding > _LARGEST_PADDING:
        warn_of_unit("padding", f"what is within {padding:g} m of the robot is left out: {_IN_MILLIMETERS}")


def check_object(name: str, shape: object, T: Array) -> None:
    """Check the extents and place of an object; a floor is wide but thin, and may lie aside."""
    extents = _extents(shape)
    if max(extents) >= FAR:
        if min(extents) >= FAR / 10:
            words = " x ".join(f"{extent:.4g}" for extent in extents)
            warn_of_unit("shape", f"{name!r} is {words} m: {_IN_MILLIMETERS}")
        return
    check_place(f"pose of {name!r}", T)


def _extents(shape: object) -> tuple[float, float, float]:
    """The lengths of a solid [m]; none of clouds and grids, which are checked at construction, nor of a half-space."""
    if (kind := kind_of(shape)) is not None:
        x, y, z = kind.half_extents(shape)
        return 2 * x, 2 * y, 2 * z
    match shape:
        case ConvexMesh():
            x, y, z = np.ptp(shape.vertices, axis=0).tolist()
            return x, y, z
        case HalfSpace():
            return math.inf, math.inf, 0.0
    return 0.0, 0.0, 0.0


def warn_of_rpy(largest: float) -> None:
    """Warn of a pose whose largest angle of roll, pitch and yaw exceeds three turns [rad]."""
    warn_of_unit("rpy", f"up to {largest:g} rad: {_IN_DEGREES}")


def check_dh_rows(rows: Array) -> None:
    """Check the angles of a Denavit-Hartenberg table, rows of a, d, alpha, theta_offset."""
    largest = float(np.abs(rows[:, 2:]).max(initial=0.0))
    if largest > 2 * math.pi + 1e-3:
        warn_of_unit("rows", f"alpha and theta_offset are up to {largest:g} rad: {_IN_DEGREES}")


def check_shapes(name: str, description: Description) -> None:
    """Check the extents of a robot's collision shapes."""
    bodies = ((link.name, body.name, _extents(body.shape)) for link in description.links for body in link.collisions)
    far = next((each for each in bodies if max(each[2]) >= FAR and min(each[2]) >= FAR / 10), None)
    if far is not None:
        words = " x ".join(f"{extent:.4g}" for extent in far[2])
        warn_of_unit(name, f"shape {far[1]!r} of link {far[0]!r} is {words} m: {_IN_MILLIMETERS}")


def check_description(name: str, description: Description) -> None:
    """Check a robot's shapes, the length of its longest chain with slides extended, and its joint limits.

    If a length has more digits than a drawing in millimeters, the lengths were computed, for example for an arm in another unit.
    """
    check_shapes(name, description)
    joints, far = joints_from_root(description), {root_link(description): 0.0}
    for joint in joints:
        slide = _widest(joint) if joint.type == JointType.PRISMATIC else 0.0
        far[joint.child] = far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3])) + slide
    length, offsets = max(far.values()), np.array([joint.origin[:3, 3] for joint in joints])
    if FAR < length <= _LONGEST and np.abs(offsets - _DIGIT * np.rint(offsets / _DIGIT)).max() < _ROUNDING:
        warn_of_unit(name, f"the robot reaches {length:.4g} m when stretched: {_IN_MILLIMETERS}")
    limited = [joint for joint in joints if joint.type == JointType.REVOLUTE and joint.mimic is None]
    widest = sorted(map(_widest, limited))
    if len(widest) > 1 and widest[0] > TWO_TURNS and widest[len(widest) // 2] <= 360 and widest[-1] <= 720:
        first = limited[0]
        words = f"{first.limits.lower:g} to {first.limits.upper:g} rad are the limits of {first.name!r}"
        warn_of_unit(name, f"{words}, and all joints turn more than twice: {_IN_DEGREES}")


def degrees_in_words(angles: ArrayLike) -> str:
    """The end of a sentence that refuses angles [rad]: a question, if an angle exceeds two turns."""
    return f": {_IN_DEGREES}" if np.abs(angles).max(initial=0.0) > TWO_TURNS else ""


def millimeters_in_words(distance: float, reach: float) -> str:
    """A question after a distance that is many times the reach [m]; empty otherwise."""
    return " (millimeters?)" if distance > FAR and distance > 20 * reach else ""


def _widest(joint: Joint) -> float:
    return max(abs(joint.limits.lower), abs(joint.limits.upper))
