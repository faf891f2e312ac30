"""Computes the pose of one joint from its row of the table of joints. Used by ``chain``, ``tree`` and ``jacobian``."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load
from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import constant_pose, slide_along_z, turn_about_z


@kernel
def joint_pose(table, i, q_rows):
    """T_parent_joint of row i at the configuration q."""
    kind = int(table[i, KIND])
    origin = constant_pose(table, i, load(q_rows, 0))
    if kind == FIXED:
        return origin
    x = load(q_rows, int(table[i, COLUMN])) * table[i, RATIO] + table[i, OFFSET]
    if kind == PRISMATIC:
        return slide_along_z(origin, x)
    return turn_about_z(origin, x)
