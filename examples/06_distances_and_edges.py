"""Measures the distance of an arm with a cup from 200 books, follows its gradient, and certifies edges."""

import sys

import numpy as np

import ulna

robot, world, rng = ulna.load("panda"), ulna.World(), np.random.default_rng(0)
world.add("floor", ulna.HalfSpace(), ulna.pose(xyz=(0.0, 0.0, -0.4)))
for k in range(200):
    place = (rng.uniform(-0.6, 0.6), 0.75, rng.uniform(0.1, 0.9))
    world.add(f"book {k}", ulna.Box(extents=(0.03, 0.15, 0.2)), ulna.pose(place, rpy=(0.0, 0.0, rng.normal(scale=0.1))))
robot = robot.with_attached("cup", ulna.Cylinder(radius=0.03, length=0.1), ulna.pose(xyz=(0.0, 0.0, 0.05)))

start = robot.home.copy()
start[0] = np.pi / 2  # turned towards the books
nearest = robot.check_collision(start, world, max_distance=np.inf).pairs[0]
print(f"at the start {nearest.name_a} is {1000 * nearest.signed_distance:.1f} mm from {nearest.name_b}")
assert np.isclose(nearest.signed_distance, robot.signed_distance(start, world), atol=1e-9)
assert nearest.signed_distance > 0

# Gradient ascent increases the clearance from the world.
q, before = start, robot.signed_distance(start, world, self_collision=False)
for _ in range(20):
    q = np.clip(q + 0.02 * robot.distance_gradient(q, world, self_collision=False), robot.lower, robot.upper)
after = robot.signed_distance(q, world, self_collision=False)
print(f"its clearance from the world is {1000 * before:.1f} mm, and {1000 * after:.1f} mm after twenty steps")
assert after > before + 0.02

# Check every edge that is certified collision-free at a thousand samples.
goals = np.clip(q + rng.normal(scale=0.5, size=(40, 7)), robot.lower, robot.upper)
edges = robot.edge_in_collision(q, goals, world)
print(edges)
samples = q + np.linspace(0, 1, 1000)[:, None, None] * (goals - q)
assert not np.any(robot.in_collision(samples[:, ~edges.in_collision], world))
assert 0 < np.count_nonzero(edges.in_collision) < 40

if "--view" in sys.argv:
    with ulna.view(robot, world, q=start, open_browser=True) as view:
        print(f"{view.url}: drag the hand among the books; a line joins the nearest pair; Ctrl-C ends", flush=True)
        view.wait()
