"""What a robot is."""

from dataclasses import asdict

from ulna.answers.entries import entries_of_q
from ulna.answers.plain import Data
from ulna.model.description import JointType
from ulna.robot import Robot

INFO_KEYS = (
    "name; base; tip: null if there are several; leaves; n_dof; joints: one for each entry of q, with name, type, lower, upper, "
    "soft_lower, soft_upper, velocity_limit, home, unit; fixed_joints; mimic_joints: name, joint, multiplier, offset; links; "
    "collision_shapes: name, link, kind, and extents, or radius and length, or uri and scale."
)


def info_data(robot: Robot) -> Data:
    """What a robot is; see ``INFO_KEYS``."""
    joints = robot.description.joints
    columns = robot.lower, robot.upper, robot.soft_lower, robot.soft_upper, robot.velocity_limits, robot.home
    keys = ("lower", "upper", "soft_lower", "soft_upper", "velocity_limit", "home")
    return {
        "name": robot.name,
        "base": robot.base,
        "tip": robot.tip,
        "leaves": list(robot.tree.leaves),
        "n_dof": robot.n_dof,
        "joints": [
            {"name": entry.name, "type": entry.type, **dict(zip(keys, row, strict=True)), "unit": entry.unit}
            for entry, row in zip(entries_of_q(robot), zip(*columns, strict=True), strict=True)
        ],
        "fixed_joints": [j.name for j in joints if j.type == JointType.FIXED],
        "mimic_joints": [{"name": j.name, **asdict(j.mimic)} for j in joints if j.mimic is not None],
        "links": list(robot.link_names),
        "collision_shapes": [
            {"name": body.name, "link": link.name, "kind": type(body.shape).__name__.lower(), **asdict(body.shape)}
            for link in robot.description.links
            for body in link.collisions
        ],
    }
