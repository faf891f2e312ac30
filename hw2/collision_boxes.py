"""Shows the twelve collision boxes at q = 0 in RViz, as static markers. The arm is shown by test_collision_boxes.py.

RViz shows two sets of boxes, each with its name in its color. "drawn by hand" are the numbers below, from the course's own file,
drawn as edges. "link table" is the assignment's table of boxes in link frames, placed by forward kinematics and drawn with faces.
The sets differ by centimeters. Collisions are checked with the table.
"""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C during the imports ends the script without a traceback
    import numpy as np

    import ulna
    from ulna.demo.drawing import standing_boxes
    from ulna.demo.ros.adapter import ros1_or_exit
    from ulna.viewer.palette import MOVABLE, Solid

UPRIGHT = (1, 0, 0, 0)
TILTED = (0.951416134834, 0.307908415794, 0, 0)
TURNED = (0.882274568081, 0.0189154259861, -0.0100818071514, 0.470246970654)
# Position of the center [m], size along x, y, z [m], rotation as a quaternion w, x, y, z.
BOXES = (
    ((-0.04, 0, 0.05), (0.23, 0.2, 0.1), UPRIGHT),
    ((-0.009, 0, 0.15), (0.13, 0.12, 0.1), UPRIGHT),
    ((0, -0.0318194814026, 0.250960588455), (0.12, 0.1, 0.2), TILTED),
    ((-0.0008, 0, 0.333), (0.12, 0.27, 0.11), UPRIGHT),
    ((0, 0.042, 0.42), (0.12, 0.1, 0.2), TILTED),
    ((0.00687, 0, 0.53), (0.13, 0.12, 0.22), UPRIGHT),
    ((0.0745, 0, 0.653), (0.13, 0.23, 0.12), UPRIGHT),
    ((0.00422, 0.00367, 0.77), (0.12, 0.12, 0.22), UPRIGHT),
    ((0, 0.0745, 0.9077), (0.12, 0.12, 0.2), UPRIGHT),
    ((0.00328, 0.0176, 1.0275), (0.13, 0.23, 0.12), UPRIGHT),
    ((0.0744, -0.0092, 1.0247), (0.12, 0.12, 0.2), UPRIGHT),
    ((0.0744, -0.0092, 0.9223), (0.10, 0.23, 0.15), TURNED),
)


def drawn_by_hand(robot):
    """The boxes of BOXES, with invisible faces, so that the other set can be seen."""
    return [
        Solid(f"box {k}", robot.base, ulna.pose(position, wxyz=rotation), ulna.Box(size), MOVABLE, opacity=0.0)
        for k, (position, size, rotation) in enumerate(BOXES, start=1)
    ]


if __name__ == "__main__":
    panda = ulna.load("panda")
    at_zero = np.zeros(panda.n_dof)
    ros1_or_exit().show_boxes(lambda: {"drawn by hand": drawn_by_hand(panda), "link table": list(standing_boxes(panda, at_zero))})
