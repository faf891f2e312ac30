"""Loads your own robot from a folder, and draws a square with it.

The folder desk_arm has the URDF, the SRDF and the meshes (``package://desk_arm/``), which desk_arm/make_meshes.py made. The arm
draws a square 5 mm above the desk with ``robot.follow``, and touches neither the desk nor the mug. Convex hulls need the extra
``hulls``. With ``--view`` you drag the pen and the mug on a page.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

import ulna

FOLDER = Path(__file__).with_name("desk_arm")

print(ulna.inspect(FOLDER / "desk_arm.urdf"))  # lists the faults of a description
robot = ulna.load(FOLDER / "desk_arm.urdf", srdf=FOLDER / "desk_arm.srdf")
ready = robot.named_configurations["arm/ready"]
print(f"{robot} with the joints {', '.join(robot.groups['arm'].joint_names)}")

# Collision checking uses the convex hulls of meshes, on request. The SRDF lists the links that may touch; without one, samples
# can find them.
robot = robot.with_convex_hulls().with_allowed_collisions(robot.srdf.disabled_collisions)
print(robot.allowed_collisions)

world = ulna.World()
world.add("desk", ulna.HalfSpace(), touch_links=["foot"])
world.add("mug", ulna.Cylinder(radius=0.04, length=0.1), ulna.pose(xyz=(0.3, 0.16, 0.05)))

corners = np.array([(0.2, -0.05), (0.3, -0.05), (0.3, 0.05), (0.2, 0.05), (0.2, -0.05)])
square = np.concatenate([a + np.linspace(0, 1, 25)[:, None] * (b - a) for a, b in pairwise(corners)])
# The pen points down. Four joints do not reach every pose: the rotation of the pen about its axis follows from its position.
T_path = np.stack([ulna.pose((x, y, 0.005), rpy=(0.0, np.pi, np.arctan2(y, x))) for x, y in square])
path = robot.follow(T_path, world=world)
print(f"the square: {path}")
assert path.success, path
assert np.abs(robot.forward_kinematics(path.q) - T_path).max() < 1e-4

approach = robot.plan(ready, path.q[0], world)
print(f"from the configuration 'ready' to its first corner: {approach}")
assert approach, approach
assert not np.any(robot.edge_in_collision(path.q[:-1], path.q[1:], world).in_collision)
clearance = robot.signed_distance(path.q, world).min()
print(f"the smallest distance along the square is {1e3 * clearance:.1f} mm")
assert abs(clearance - 0.005) < 1e-5

if "--view" in sys.argv:
    with ulna.view(robot, world, q=path.q[0], open_browser=True) as view:
        print(f"{view.url}: drag the pen, or the mug in the tab Obstacles; Ctrl-C ends", flush=True)
        view.wait()
