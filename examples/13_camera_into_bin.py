"""Moves into a bin that a depth camera sees, while the parts in the bin change.

Each image replaces the point cloud, and each plan is certified. ``benchmarks/depth_camera.py`` simulates the camera: it sends
rays to a table, a bin, parts and the arm, with noise. The hand moves above the highest part that it can reach between the walls.
Meanwhile the parts change. After a share of the motion the camera takes the next image, and the arm plans again from its present
configuration. Every motion is compared with the true boxes. With ``--view`` a page shows the cloud and the arm, again and again.
Ctrl-C ends.
"""

import itertools
import sys
import time
from pathlib import Path

import numpy as np

import ulna

sys.path.insert(0, str(Path(__file__).parents[1]))
from benchmarks.depth_camera import Camera, bin_on_a_table

RADIUS = 0.003  # [m] of a point: half the distance between neighbors, plus the noise
PADDING = 0.02  # [m] points within this distance of the arm count as the arm itself
FITS, T_FITS = ulna.Box((0.14, 0.09, 0.2)), ulna.pose((0.55, 0.0, 0.11))  # the space where the hand fits between the bin's walls
ABOVE = 0.06  # [m] from the highest point to the tips of the fingers, since the arm may hide other parts
SHARE = 0.6  # share of a motion after which the camera takes the next image

robot, world = ulna.load("panda"), ulna.World()
world.add("seen", ulna.PointCloud(np.empty((0, 3)), RADIUS))
camera = Camera.of_pixels(320 * 240)
arm = [body.shape for link in robot.description.links for body in link.collisions if isinstance(body.shape, ulna.Box)]


def look(boxes, q, seed):
    """Replace the cloud by a new image without the arm at q. Returns the goal: above the highest part."""
    of_arm = [(np.array(shape.half_extents), T) for shape, T in zip(arm, robot.collision_poses(q), strict=True)]
    image = camera.image([*boxes, *of_arm], np.random.default_rng(seed))
    seen = camera.cloud(image, RADIUS).cropped(ulna.Box((2, 2, 2))).without(robot, q, padding=PADDING)
    highest = max(seen.cropped(FITS, T_FITS).points, key=lambda point: point[2])
    world.update("seen", seen.thinned(0.01))
    return ulna.pose(highest + np.array([0, 0, ABOVE]), rpy=(np.pi, 0.0, -np.pi / 4))


q, clouds, motions = robot.home, [], []
for k in range(4):
    boxes = bin_on_a_table(k)  # the parts have changed
    goal = look(boxes, q, k)
    before = time.perf_counter()
    plan = robot.plan(q, goal, world)
    took = time.perf_counter() - before
    assert plan, plan
    motion = plan.improve(300).trajectory(acceleration=3.0)
    assert motion.certified

    there = ulna.World()
    there.add_many((f"box {n}", ulna.Box(tuple(2 * half)), T) for n, (half, T) in enumerate(boxes))
    rows = motion.at(np.linspace(0, motion.duration, 500)).q
    nearest = robot.signed_distance(rows, there, self_collision=False).min()
    print(f"image {k}: {world.shape('seen')}, planned to {goal[:3, 3].round(2)} m in {1e3 * took:.0f} ms")
    print(f"  {motion.duration:.2f} s, at least {1e3 * nearest:.0f} mm from the true boxes")
    assert nearest > 0
    clouds.append(world.shape("seen"))
    motions.append(motion)
    q = motion.at(SHARE * motion.duration).q  # the arm at the time of the next image

if "--view" in sys.argv:
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: the arm goes into the bin, and the parts change on its way; Ctrl-C ends", flush=True)
        try:
            for cloud, motion in itertools.cycle(zip(clouds, motions, strict=True)):
                world.update("seen", cloud)
                share = 1.0 if motion is motions[-1] else SHARE
                for t in np.arange(0.0, share * motion.duration, 1 / 30):
                    view.q = motion.at(t).q
                    time.sleep(1 / 30)
        except KeyboardInterrupt:
            pass
