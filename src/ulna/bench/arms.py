"""Names the arms that are measured: the file of each, and the links at both ends of its chain.

The files come with the data packages ``example-robot-data`` (the extra ``meshes``) and ``rtb-data``; the Panda is bundled.
"""

import sys
from pathlib import Path
from typing import NamedTuple

from ulna.errors import UlnaError
from ulna.robot import Robot, load

_ROBOTS = "cmeel.prefix/share/example-robot-data/robots"
# Made by xacro from the file beside it, which names its package otherwise than the data package does.
_IIWA = "rtbdata/xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"


class ArmFile(NamedTuple):
    """A file below a folder of ``sys.path``, the links at both ends of the chain, and the package to install for it."""

    file: str
    base: str
    tip: str
    package: str = "example-robot-data"


# Each chain holds the arm's own joints: no gripper, no torso, no wheels.
ARMS = {
    "ur5": ArmFile(f"{_ROBOTS}/ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    "ur10": ArmFile(f"{_ROBOTS}/ur_description/urdf/ur10_robot.urdf", "base_link", "tool0"),
    "jaco2": ArmFile(f"{_ROBOTS}/kinova_description/robots/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
    "baxter": ArmFile(f"{_ROBOTS}/baxter_description/urdf/baxter.urdf", "left_arm_mount", "left_gripper"),
    "pr2": ArmFile(f"{_ROBOTS}/pr2_description/urdf/pr2.urdf", "torso_lift_link", "r_gripper_tool_frame"),
    "tiago": ArmFile(f"{_ROBOTS}/tiago_description/robots/tiago.urdf", "torso_lift_link", "arm_tool_link"),
    "z1": ArmFile(f"{_ROBOTS}/z1_description/urdf/z1.urdf", "link00", "link06"),
    "xarm7": ArmFile(f"{_ROBOTS}/xarm_description/urdf/xarm7.urdf", "link_base", "link_eef"),
    "so100": ArmFile(f"{_ROBOTS}/so_arm_description/urdf/so100.urdf", "base", "gripper"),
    "so101": ArmFile(f"{_ROBOTS}/so_arm_description/urdf/so101.urdf", "base_link", "gripper_frame_link"),
    "iiwa14": ArmFile(_IIWA, "base_link", "tool0", "rtb-data"),
}
NAMES = ("panda", *ARMS)


def load_arm(name: str) -> Robot:
    """The arm of a short name; for any other name or path, what ``ulna.load`` gives.

    Raises:
        UlnaError: The file of the arm is not installed, or cannot be loaded; the message says what to install.

    Example:
        >>> load_arm("panda").tip
        'panda_ee'
    """
    arm = ARMS.get(name)
    if arm is None:
        return load(name)
    path = next((Path(entry) / arm.file for entry in sys.path if (Path(entry) / arm.file).is_file()), None)
    if path is None:
        raise UlnaError(f"{name}: its description is not installed; pip install {arm.package}")
    return load(path, base=arm.base, tip=arm.tip)
