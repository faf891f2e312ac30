"""Finds the boxes of the arm that touch an obstacle, and the share of 100,000 configurations in collision."""

import sys

import numpy as np

import ulna

robot = ulna.load("panda")
world = ulna.World()
world.add("crate", ulna.Box(extents=(0.15, 0.09, 0.126)), ulna.pose(xyz=(0.3, 0.0, 0.5)))

report = robot.check_collision(robot.home, world)
print(report)
for pair in report.pairs:
    print(f"  {pair.name_a} is {-pair.signed_distance * 1e3:.1f} mm inside {pair.name_b}, along {pair.normal.round(3)}")
assert report.touching == ("box 12",)

# Moving the crate along the normal by the penetration depth separates the deepest pair.
deepest = report.pairs[0]
world.move("crate", ulna.pose(xyz=np.array([0.3, 0.0, 0.5]) + deepest.normal * (1e-6 - deepest.signed_distance)))
assert deepest.name_a not in robot.check_collision(robot.home, world).touching

q = robot.random(100_000, seed=0)
share = np.mean(robot.in_collision(q, world, self_collision=False))
print(f"{share:.1%} of random configurations touch the crate")
assert 0.02 < share < 0.2

if "--view" in sys.argv:
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: drag the hand, or the crate in the tab Obstacles; Ctrl-C ends", flush=True)
        view.wait()
