"""Finds a base from which a Panda reaches five screws on a cabinet without collisions.

A reachability map ranks poses of the base. Inverse kinematics among the obstacles then proves each printed pose. Needs the extra
``reach``: pip install -e ".[reach]" in a copy of the repository.
"""

import tempfile
from pathlib import Path

import numpy as np

import ulna

DOWN = (np.pi, 0.0, 0.0)  # the hand points down
SLANTED = (0.0, 0.75 * np.pi, 0.0)  # the hand points half down, half along x
SCREWS = np.stack(
    [
        ulna.pose((0.05, -0.30, 0.40), DOWN),
        ulna.pose((0.05, 0.00, 0.40), DOWN),
        ulna.pose((0.05, 0.30, 0.40), DOWN),
        ulna.pose((-0.22, -0.20, 0.25), SLANTED),
        ulna.pose((-0.22, 0.20, 0.25), SLANTED),
    ]
)

robot = ulna.load("panda")
world = ulna.World()
world.add("cabinet", ulna.Box((0.3, 0.9, 0.35)), ulna.pose((0.05, 0.0, 0.175)))  # its top is at 0.35 m, its front at x = -0.1 m

with tempfile.TemporaryDirectory() as folder:
    found = ulna.reachability_map(robot, Path(folder) / "panda.zarr", voxel=0.1, orientations=48)
    share = found.summary.reached / found.summary.poses
    print(f"{found.summary.poses} poses, {100 * share:.0f} % of them reached")
    places = found.base_placements(SCREWS, world=world, most=3)

assert places, "there is no place for the base"
for place in places:
    x, y = place.T_world_base[:2, 3]
    print(
        f"base at x {x:.2f} m, y {y:.2f} m, turned by {np.degrees(place.yaw):.0f} deg: "
        f"score {place.score:.2f}, minimum manipulability {place.manipulability.min():.3f}"
    )
    reached = place.T_world_base @ robot.forward_kinematics(place.q)
    assert np.abs(reached - SCREWS).max() < 1e-4
    moved = ulna.World()  # the cabinet in the frame of the base
    moved.add("cabinet", world.shape("cabinet"), np.linalg.inv(place.T_world_base) @ world.pose("cabinet"))
    assert not np.any(robot.in_collision(place.q, moved))
