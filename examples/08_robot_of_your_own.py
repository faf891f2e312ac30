"""A robot of your own: the folder desk_arm has its URDF, its SRDF and its meshes, which are addressed as ``package://desk_arm/``.

It draws a square 5 mm above the desk, and touches neither that nor the mug. Convex hulls need the extra ``hulls``. The meshes are
made by desk_arm/make_meshes.py. With ``--view`` you drag the pen and the mug on a page.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

import ulna

FOLDER = Path(__file__).with_name("desk_arm")

print(ulna.inspect(FOLDER / "desk_arm.urdf"))  # what is wrong with a description, before it is used
robot = ulna.load(FOLDER / "desk_arm.urdf", srdf=FOLDER / "desk_arm.srdf")
ready = robot.named_configurations["arm/ready"]
print(f"{robot} with the joints {', '.join(robot.groups['arm'].joint_names)}")

# Meshes are checked as their convex hulls, and only on request. Which links may touch is found from samples, or said by the SRDF.
robot = robot.with_convex_hulls().with_allowed_collisions(robot.srdf.disabled_collisions)
print(robot.allowed_collisions)

world = ulna.World()
world.add("desk", ulna.HalfSpace(), touch_links=["foot"])
world.add("mug", ulna.Cylinder(radius=0.04, length=0.1), ulna.pose(xyz=(0.3, 0.16, 0.05)))

corners = [(0.2, -0.05), (0.3, -0.05), (0.3, 0.05), (0.2, 0.05), (0.2, -0.05)]
line = [(1 - s) * np.array(a) + s * np.array(b) for a, b in pairwise(corners) for s in np.linspace(0, 1, 25)]
path = [ready]
for x, y in line:
    target = ulna.pose(
        xyz=(x, y, 0.005), rpy=(np.pi, 0.0, 0.0)
    )  # the pen points down; the turn about it is free: there are four joints
    solved = robot.inverse_kinematics(target, path[-1], task="pointing", world=world)
    assert solved.success, solved
    path.append(solved.q)

path = np.array(path)
edges = robot.edge_in_collision(path[:-1], path[1:], world)
clearance = robot.signed_distance(path[1:], world).min()
print(f"the square: {edges}, and {1e3 * clearance:.1f} mm of clearance at least")
assert not np.any(edges.in_collision)
assert 0 < clearance < 0.005 + 1e-6  # the tip is 5 mm above the desk

if "--view" in sys.argv:
    with ulna.view(robot, world, q=ready, open_browser=True) as view:
        print(f"{view.url}: drag the pen, or the mug in the tab Obstacles; Ctrl-C ends", flush=True)
        view.wait()
