"""Makes the URDF for RViz and robot_state_publisher."""

from collections.abc import Callable

from ulna.errors import FileError
from ulna.robot import Robot

# The Panda's finger joints. These links have no shape: the bundled description draws the fingers on the flange, half open.
# Source: franka_description, hand.xacro. The drawn fingers are at the same places, at a position of 0.02 m.
_FINGERS = """
  <link name="panda_leftfinger"/>
  <link name="panda_rightfinger"/>
  <joint name="panda_finger_joint1" type="prismatic">
    <parent link="panda_link8"/>
    <child link="panda_leftfinger"/>
    <origin xyz="0 0 0.0584" rpy="0 0 -0.7853981633974483"/>
    <axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0.2" effort="20"/>
  </joint>
  <joint name="panda_finger_joint2" type="prismatic">
    <parent link="panda_link8"/>
    <child link="panda_rightfinger"/>
    <origin xyz="0 0 0.0584" rpy="0 0 2.356194490192345"/>
    <axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0.2" effort="20"/>
  </joint>
</robot>
"""


def robot_description(robot: Robot, warn: Callable[[str], object]) -> str:
    """The URDF with every joint of ``joint_states``, and ``file://`` paths of meshes.

    If meshes are missing, it contains the given paths, and ``warn`` is called.
    """
    try:
        return with_fingers(robot.to_urdf(mesh_paths="file"))
    except FileError as error:
        warn(f"only the boxes of the arm are shown, because its meshes are missing (pip install example-robot-data): {error}")
        return with_fingers(robot.to_urdf())


def with_fingers(urdf: str) -> str:
    """The Panda's URDF with its two finger joints: robot_state_publisher warns of unknown joints in ``joint_states``."""
    return urdf.rpartition("</robot>")[0].rstrip() + _FINGERS
