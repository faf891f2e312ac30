"""Makes the messages for RViz, whose classes and fields have the same names in ROS 1 and 2."""

# pyright: reportMissingImports=false
# ROS is installed with the system, not by pip; without it pyright cannot check these imports.

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerFeedback, Marker

from ulna.collision.report import Report
from ulna.demo.drawing import WORD_POSITION_IN_BASE, joint_positions, light, movable_box
from ulna.demo.scenario import BOX_NAME, LIGHT_POSITION, light_word
from ulna.description.pose import pose, quaternion_from_matrix
from ulna.description.shapes import Box, Cylinder
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.viewer.palette import INK, Solid, collision_solids

SERVER = "basic_controls"  # prefix of the interactive-marker server's topics
LIFETIME_S = 3  # [s], lifetime of a marker, which is sent ten times per second
_HANDLE_SCALE = 0.22  # [m], size of arrows and rings
_WORD_HEIGHT = 0.06  # [m]
_EDGE = 0.004  # [m], thickness of a box's edges
# RViz draws a control along its own x axis: the quaternions (x, y, z, w) that turn x to x, y and z.
_AXES = {"x": (1.0, 0.0, 0.0, 1.0), "y": (0.0, 0.0, 1.0, 1.0), "z": (0.0, 1.0, 0.0, 1.0)}


def joint_state(robot: Robot, q: NDArray[np.float64], stamp: Any) -> JointState:
    """The positions of the joints and of the fingers at a time."""
    positions = joint_positions(robot, q)
    return JointState(header=Header(stamp=stamp), name=list(positions), position=list(positions.values()))


def markers(robot: Robot, report: Report | None) -> Iterator[Marker]:
    """The light with its text, and the arm's boxes, which move with its links. ``report`` is None while unknown."""
    yield solid_marker(light(robot, report), "light", 0)
    yield text_marker(light_word(report), robot.base, WORD_POSITION_IN_BASE, INK, ("light", 1))
    for k, solid in enumerate(collision_solids(robot, report.touching if report is not None else ())):
        yield solid_marker(solid, "boxes", k)


def solid_marker(solid: Solid[Box] | Solid[Cylinder], namespace: str, number: int) -> Marker:
    """The marker of one solid. RViz moves it with the frame of its link."""
    if isinstance(solid.shape, Box):
        kind, size = Marker.CUBE, solid.shape.extents
    else:
        kind, size = Marker.CYLINDER, (2 * solid.shape.radius, 2 * solid.shape.radius, solid.shape.length)
    marker = Marker(header=Header(frame_id=solid.link), ns=namespace, id=number, type=kind, frame_locked=True)
    marker.pose, marker.scale, marker.color = pose_message(solid.pose), Vector3(**_xyz(size)), _color(solid.color, solid.opacity)
    return _short_lived(marker)


def edged_boxes(groups: Mapping[str, Sequence[Solid[Box]]]) -> Iterator[Marker]:
    """The boxes of each group, in a namespace of its name: edges, and faces unless invisible."""
    for name, solids in groups.items():
        for k, solid in enumerate(solids):
            yield _edges(solid, name, 2 * k)
            if solid.opacity > 0.0:
                yield solid_marker(solid, name, 2 * k + 1)


def _edges(solid: Solid[Box], namespace: str, number: int) -> Marker:
    """The twelve edges of a box as opaque lines."""
    marker = Marker(header=Header(frame_id=solid.link), ns=namespace, id=number, type=Marker.LINE_LIST, frame_locked=True)
    marker.pose, marker.scale, marker.color = pose_message(solid.pose), Vector3(x=_EDGE), _color(solid.color, 1.0)
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    ends = ((a, b) for a, b in combinations(corners, 2) if np.count_nonzero(a - b) == 1)
    marker.points = [Point(**_xyz(end * solid.shape.half_extents)) for edge in ends for end in edge]
    return _short_lived(marker)


def legend(groups: Mapping[str, Sequence[Solid]]) -> Iterator[Marker]:
    """The name of each group in the color of its solids, above one another near the light."""
    for k, (name, (solid, *_)) in enumerate(groups.items()):
        x, y, z = LIGHT_POSITION
        yield text_marker(name, solid.link, (x, y, z + 1.5 * k * _WORD_HEIGHT), solid.color, ("legend", k))


def text_marker(
    text: str, link: str, position: tuple[float, float, float], color: tuple[int, int, int], key: tuple[str, int]
) -> Marker:
    """A text that faces the camera, at a position [m] in a link's frame; ``key``: its namespace and number."""
    marker = Marker(header=Header(frame_id=link), ns=key[0], id=key[1], type=Marker.TEXT_VIEW_FACING, text=text)
    marker.pose = pose_message(pose(position))
    marker.scale, marker.color = Vector3(z=_WORD_HEIGHT), _color(color, 1.0)
    return _short_lived(marker)


def interactive_box(robot: Robot, T_base_box: NDArray[np.float64]) -> InteractiveMarker:
    """The movable box with an arrow and a ring for each axis."""
    solid = movable_box(robot, T_base_box)
    handles = InteractiveMarker(header=Header(frame_id=solid.link), name=BOX_NAME, scale=_HANDLE_SCALE)
    handles.pose = pose_message(solid.pose)
    body = solid_marker(movable_box(robot, np.eye(4)), "box", 0)
    body.header, body.frame_locked, body.lifetime = Header(), False, type(body.lifetime)()  # its pose is in the handles' frame
    handles.controls = [InteractiveMarkerControl(name="box", always_visible=True, markers=[body])]
    for axis, xyzw in _AXES.items():
        turn = Quaternion(**dict(zip("xyzw", (v / np.sqrt(sum(u * u for u in xyzw)) for v in xyzw), strict=True)))
        for name, mode in (("move", InteractiveMarkerControl.MOVE_AXIS), ("rotate", InteractiveMarkerControl.ROTATE_AXIS)):
            handles.controls.append(InteractiveMarkerControl(name=f"{name}_{axis}", orientation=turn, interaction_mode=mode))
    return handles


def drag(robot: Robot, T_base_box: NDArray[np.float64], control: str, event: str) -> InteractiveMarkerFeedback:
    """Make the message that RViz publishes while a handle of the box is dragged.

    Args:
        robot: The arm.
        T_base_box: The pose of the box, shape (4, 4).
        control: The name of the handle: "move_x".
        event: Its name in the message's type: "MOUSE_DOWN", "POSE_UPDATE" or "MOUSE_UP".
    """
    message = InteractiveMarkerFeedback(client_id="/ulna", marker_name=BOX_NAME, control_name=control)
    message.header.frame_id, message.pose = robot.base, pose_message(T_base_box)
    message.event_type = getattr(InteractiveMarkerFeedback, event)
    return message


def pose_message(T: NDArray[np.float64]) -> Pose:
    """A pose, shape (4, 4), as a message."""
    w, x, y, z = map(float, quaternion_from_matrix(T))
    return Pose(position=Point(**_xyz(T[:3, 3])), orientation=Quaternion(x=x, y=y, z=z, w=w))


def pose_of(message: Pose) -> NDArray[np.float64]:
    """The pose of a message, shape (4, 4). As in RViz, a zero quaternion means no rotation."""
    p, r = message.position, message.orientation
    wxyz = (r.w, r.x, r.y, r.z)
    return pose((p.x, p.y, p.z), wxyz=wxyz if any(wxyz) else None)


def feedback_pose(feedback: InteractiveMarkerFeedback, base: str) -> NDArray[np.float64]:
    """T_base_box of a drag, shape (4, 4)."""
    frame = feedback.header.frame_id.removeprefix("/")
    if frame not in ("", base):
        raise InputError("frame_id", f"the pose of the box is in {frame!r}; {base!r} is expected")
    return pose_of(feedback.pose)


def _short_lived(marker: Marker) -> Marker:
    """Give a marker a lifetime of LIFETIME_S: when the node has ended, RViz removes its markers."""
    setattr(marker.lifetime, "secs" if hasattr(marker.lifetime, "secs") else "sec", LIFETIME_S)
    return marker


def _xyz(values) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _color(rgb: tuple[int, int, int], opacity: float) -> ColorRGBA:
    r, g, b = (channel / 255 for channel in rgb)
    return ColorRGBA(r=r, g=g, b=b, a=opacity)
