"""Plans motions among the points of a depth camera: a point cloud is one object of the world.

A simulated camera sees a shelf with six compartments. The arm visits all of them. ``robot.plan_many`` plans in threads, and every
edge of a plan is certified. With ``--view`` a page shows the cloud, and the arm that moves in and out. Ctrl-C ends.
"""

import sys
import time

import numpy as np

import ulna

robot, rng = ulna.load("panda"), np.random.default_rng(0)


def seen(extents, xyz):
    """5000 points on the surface of a box at xyz, with 1 mm of noise [m], shape (5000, 3)."""
    points = rng.uniform(-0.5, 0.5, (5000, 3))
    points[np.arange(5000), rng.integers(3, size=5000)] = rng.choice([-0.5, 0.5], 5000)
    return points * extents + xyz + rng.normal(scale=1e-3, size=(5000, 3))


boards = [seen((1.2, 0.3, 0.02), (0.0, 0.75, z)) for z in (0.3, 0.6, 0.9)]
sides = [seen((0.02, 0.3, 0.6), (x, 0.75, 0.6)) for x in (-0.6, -0.2, 0.2, 0.6)]
world = ulna.World()
world.add("camera", ulna.PointCloud(np.concatenate([*boards, *sides]), radius=0.01))
print(world.shape("camera"))

# In each compartment the hand points into the shelf. Its rotation about its own axis is free.
places = np.stack([ulna.pose((x, 0.65, z), rpy=(-np.pi / 2, 0.0, 0.0)) for z in (0.45, 0.75) for x in (-0.4, 0.0, 0.4)])
before = time.perf_counter()
plans = robot.plan_many(robot.home, places, world, task="pointing", clearance=0.005)
print(f"{sum(map(bool, plans))} of {len(plans)} compartments, planned in {time.perf_counter() - before:.2f} s")
motions = []
for T, plan in zip(places, plans, strict=True):
    assert plan, plan
    shorter = plan.improve(500)
    motion = shorter.trajectory(acceleration=3.0)
    free = 1e3 * shorter.clearance
    print(f"  {T[:3, 3].round(2)} m: {len(shorter.path)} configurations, {motion.duration:.2f} s, {free:.1f} mm from the cloud")
    assert np.allclose(robot.forward_kinematics(shorter.path[-1])[:3, 3], T[:3, 3], atol=1e-4)
    assert motion.certified
    assert robot.signed_distance(motion.at(np.linspace(0, motion.duration, 500)).q, world, self_collision=False).min() > 0.005
    motions.append(motion)

if "--view" in sys.argv:
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: the arm goes in and out; Ctrl-C ends", flush=True)
        try:
            while True:
                for motion in motions:
                    for t in np.arange(0.0, 2 * motion.duration, 1 / 30):
                        view.q = motion.at(min(t, 2 * motion.duration - t)).q
                        time.sleep(1 / 30)
        except KeyboardInterrupt:
            pass
