"""Moves along the same path with empty fingers and with 3 kg, within the torque limits of all motors.

The load does not change the path, but the fastest motion along it. ``plan.trajectory(torque=True)`` keeps the effort limits of
the description, including gravity and the part. Without this option the load does not slow the motion, and a motor exceeds its
limit.
"""

import numpy as np

import ulna

PART = ulna.Box(extents=(0.08, 0.08, 0.12))
T_EE_PART = ulna.pose(xyz=(0.0, 0.0, 0.07))
FROM, TO = (ulna.pose(xyz=(0.68, y, 0.3), rpy=(np.pi, 0.0, 0.0)) for y in (-0.3, 0.3))
FAST = 20.0  # rad/s^2: more than the motors can deliver with the part

robot = ulna.load("panda")
world = ulna.World()
world.add("table", ulna.Box(extents=(0.7, 1.2, 0.05)), ulna.pose(xyz=(0.6, 0.0, 0.075)))
world.add("wall", ulna.Box(extents=(0.3, 0.02, 0.3)), ulna.pose(xyz=(0.6, 0.0, 0.25)))


def holding(mass):
    """The Panda with the part attached. mass: of the part [kg]."""
    return robot.with_attached("part", PART, T_EE_PART, touch_links=["panda_link7"], mass=mass)


def peak_load(motion):
    """The joint with the highest load in a motion, and its peak torque as a share of the limit."""
    t = np.arange(0.0, motion.duration, 1e-4)
    shares = np.abs(motion.torques(t)).max(axis=0) / robot.effort_limits
    return robot.joint_names[int(shares.argmax())], float(shares.max())


q_from, q_to = (robot.inverse_kinematics(T).q for T in (FROM, TO))
for name, q in (("start", q_from), ("goal", q_to)):
    print(f"the payload at the {name} is {robot.payload(q, com=T_EE_PART[:3, 3]):.1f} kg")
    assert robot.payload(q, com=T_EE_PART[:3, 3]) > 3.0

plan = holding(0.0).plan(q_from, q_to, world, seed=1)
heavy = holding(3.0).plan(q_from, q_to, world, seed=1)
assert plan
assert np.array_equal(plan.path, heavy.path)

durations = {}
for words, found, torque in (
    ("empty, within torques", plan, True),
    ("3 kg, torques ignored", heavy, None),
    ("3 kg, within torques", heavy, True),
):
    motion = found.trajectory(acceleration=FAST, torque=torque)
    joint, share = peak_load(motion)
    durations[words] = motion.duration
    print(f"{words}: {motion.duration:.3f} s; {joint} uses {share:.0%} of its limit")
    assert motion.is_free(world)
    assert (share <= 1.0) == (torque is not None)
    assert bool(motion.check(torque=True)) == (torque is not None)

print(motion.check(torque=True))
assert durations["empty, within torques"] <= durations["3 kg, within torques"]
assert durations["3 kg, torques ignored"] < durations["3 kg, within torques"]
