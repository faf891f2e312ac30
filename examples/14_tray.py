"""Carries a tray with glasses over a wall with two arms: the hands stay together and the tray stays level.

Both constraints are certified at all times. A few lines of URDF make the cell of two Pandas. Both hands hold the tray, so
``Keep.together`` closes a loop of both arms; ``Keep.upright`` keeps the glasses full. With ``--view`` a page shows the motion,
again and again. Ctrl-C ends.
"""

import itertools
import sys
import time

import numpy as np

import ulna

panda = ulna.load("panda")
text = panda.to_urdf()
text = text[text.index("<link") : text.index("</robot>")]  # the links and joints of one arm


def arm(side, y):
    """URDF of a Panda at the table, with its own names."""
    mount = f'<parent link="table"/><child link="{side}_link0"/><origin xyz="0 {y} 0"/>'
    return text.replace('"panda_', f'"{side}_') + f'<joint name="{side}_mount" type="fixed">{mount}</joint>'


cell = ulna.load(f'<robot name="cell"><link name="table"/>{arm("left", 0.3)}{arm("right", -0.3)}</robot>')
home = np.concatenate([panda.home, panda.home])  # q has the joints of the left arm first


def hands(x, y, z):
    """A goal: the hands at both ends of a tray, fingers down. x, y, z: the middle of the tray."""
    return {f"{side}_ee": ulna.pose((x, y + d, z), rpy=(np.pi, 0.0, 0.0)) for side, d in (("left", 0.2), ("right", -0.2))}


start = cell.plan(home, hands(0.35, 0.0, 0.25)).path[-1]
fingers = [f"{side}_link{k}" for side in ("left", "right") for k in (7, 8)]
loaded = cell.with_attached("tray", ulna.Box((0.2, 0.38, 0.02)), ulna.pose((0, 0.2, 0)), link="left_ee", touch_links=fingers)
for k, y in enumerate((0.13, 0.27)):  # in the frame of the left hand: its y axis points to the right hand, its z axis down
    loaded = loaded.with_attached(f"glass {k + 1}", ulna.Box((0.06, 0.06, 0.12)), ulna.pose((0, y, -0.07)), link="left_ee")
world = ulna.World()
world.add("table top", ulna.HalfSpace(), touch_links=["left_link1", "right_link1"])
world.add("wall", ulna.Box((0.03, 0.6, 0.3)), ulna.pose((0.5, 0, 0.15)))

goal = hands(0.65, 0.0, 0.25)["left_ee"]  # on the other side of the wall; ``together`` determines the right hand
together, upright = ulna.Keep.together("left_ee", "right_ee"), ulna.Keep.upright(np.radians(5), link="left_ee")
plan = loaded.plan(start, goal, world, link="left_ee", keep=(together, upright))
assert plan, plan
assert plan.certified
print(f"planned: {plan}; it uses at most {plan.worst_violation:.1%} of a tolerance")


def drift(q):
    """The displacement of the right hand in the frame of the left one, since the first configuration [mm]."""
    left, right = (loaded.forward_kinematics(q, link=link) for link in ("left_ee", "right_ee"))
    held = np.linalg.inv(left) @ right
    return 1e3 * np.linalg.norm(held[:, :3, 3] - held[0, :3, 3], axis=1)


motion = plan.trajectory(acceleration=4.0)
samples = motion.at(np.linspace(0.0, motion.duration, 2000)).q
tilt = np.degrees(np.arccos(np.clip(-loaded.forward_kinematics(samples, link="left_ee")[:, 2, 2], -1.0, 1.0)))
print(f"trajectory: {motion}; the hands drift by at most {drift(samples).max():.3f} mm, the tray tilts by {tilt.max():.2f} deg")
assert motion.certified
assert drift(samples).max() <= 0.1 * np.sqrt(3)  # 0.1 mm along each axis
assert tilt.max() <= 5
free = loaded.plan(start, plan.path[-1], world)
print(f"without constraints the hands would drift by {drift(free.at(np.linspace(0, 1, 2000))).max():.0f} mm: {free}")

if "--view" in sys.argv:
    with ulna.view(loaded, world, q=start, open_browser=True) as view:
        print(f"{view.url}: the arms carry the tray; Ctrl-C ends", flush=True)
        try:
            for t in itertools.cycle(np.arange(0.0, motion.duration + 1.0, 1 / 30)):
                view.q = motion.at(t).q
                time.sleep(1 / 30)
        except KeyboardInterrupt:
            pass
