"""Names the arms that are measured (the name of each, both ends of its chain), and samples their targets.

The Panda is bundled; the others come with the data package ``example-robot-data`` (the extra ``meshes``), one with ``rtb-data``.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import UlnaError
from ulna.kernels.layout import COLUMN, KIND, OFFSET, PRISMATIC, RATIO
from ulna.kinematics import sample
from ulna.robot import Robot, load

Array = NDArray[np.float64]
_WAVES = 5.0  # periods of the quickest joint along a path
_SWING = 0.25  # of a joint's range, to each side of its middle
# Made by xacro from the file beside it. It names its package otherwise than the data package does.
_IIWA = "rtbdata/xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"


class Chain(NamedTuple):
    """A robot's name, as ``ulna.load`` takes it, and the links at both ends of its arm."""

    robot: str
    base: str
    tip: str


# Each chain holds the arm's own joints: no gripper, no torso, no wheels.
ARMS = {
    "ur5": Chain("ur5", "base_link", "tool0"),
    "ur10": Chain("ur10", "base_link", "tool0"),
    "jaco2": Chain("kinova", "j2s6s200_link_base", "j2s6s200_end_effector"),
    "baxter": Chain("baxter", "left_arm_mount", "left_gripper"),
    "pr2": Chain("pr2", "torso_lift_link", "r_gripper_tool_frame"),
    "tiago": Chain("tiago", "torso_lift_link", "arm_tool_link"),
    "z1": Chain("z1", "link00", "link06"),
    "xarm7": Chain("xarm", "link_base", "link_eef"),
    "so100": Chain("so100", "base", "gripper"),
    "so101": Chain("so101", "base_link", "gripper_frame_link"),
    "iiwa14": Chain(_IIWA, "base_link", "tool0"),  # a file below a folder of ``sys.path``
}
NAMES = ("panda", *ARMS)


def load_arm(name: str) -> Robot:
    """The arm of a short name; for any other name or path, what ``ulna.load`` gives.

    Example:
        >>> load_arm("panda").tip
        'panda_ee'
    """
    if name not in ARMS:
        return load(name)
    robot, base, tip = ARMS[name]
    if robot != _IIWA:
        return load(robot, base=base, tip=tip)
    path = next((Path(entry, robot) for entry in sys.path if Path(entry, robot).is_file()), None)
    if path is None:
        raise UlnaError(f"{name}: its description is not installed; pip install rtb-data")
    text = path.read_text(encoding="utf-8").replace("kuka_lbr_iiwa_support", "kuka_lbr_iiwa")  # as its package is named
    return load(text, base=base, tip=tip, package_dirs=[path.parents[2]])


def middle(robot: Robot) -> Array:
    """The middle of each joint's range [rad or m], shape (n_dof,)."""
    lower, upper = sample.usual_range(robot.lower, robot.upper)
    return (lower + upper) / 2


def random_positions(robot: Robot, n: int, seed: int) -> Array:
    """Configurations drawn uniformly from the usual range [rad or m], shape (n, n_dof); their poses are reachable targets."""
    return sample.random_positions(robot.tree, n, seed)


def path_positions(robot: Robot, n: int, seed: int) -> Array:
    """A smooth path about the middle of the range [rad or m], shape (n, n_dof): sines of random period and phase."""
    lower, upper = sample.usual_range(robot.lower, robot.upper)
    rng = np.random.default_rng(seed)
    waves, phases = rng.uniform(1.0, _WAVES, robot.n_dof), rng.uniform(0.0, 2 * np.pi, robot.n_dof)
    time = np.linspace(0.0, 1.0, n)[:, None]
    return middle(robot) + _SWING * (upper - lower) * np.sin(2 * np.pi * waves * time + phases)


def longest_reach(robot: Robot, link: str | None = None) -> float:
    """An upper bound on the distance of a link, the tip unless given, from the base [m]: the sum of the lengths of the chain."""
    chain = robot.tree.chain(str(link or robot.tip))
    slides = chain[chain[:, KIND] == PRISMATIC]
    ends = robot.tree.limits[:, slides[:, COLUMN].astype(int)] * slides[:, RATIO] + slides[:, OFFSET]
    return float(np.linalg.norm(chain[:, (3, 7, 11)], axis=1).sum() + np.abs(ends).max(axis=0).sum())


def out_of_reach(robot: Robot, n: int, seed: int) -> Array:
    """Poses whose position lies 1 % to 50 % beyond the longest reach, in all directions, shape (n, 4, 4)."""
    T = robot.forward_kinematics(random_positions(robot, n, seed))
    rng = np.random.default_rng(seed + 1)
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    T[:, :3, 3] = directions * longest_reach(robot) * rng.uniform(1.01, 1.5, (n, 1))
    return T
