"""Plans for two arms at one table as one robot: their hands exchange places without a collision of the arms.

A few lines of URDF make the cell of two Pandas. A goal has a pose for each hand: ``robot.plan`` moves all joints in one search.
With ``--view`` a page shows the motion, again and again. Ctrl-C ends.
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
world = ulna.World()
world.add("table top", ulna.HalfSpace(), touch_links=["left_link1", "right_link1"])
print(f"{cell}, {len(cell.collision_names)} boxes")


def hands(x_left, y_left, x_right, y_right):
    """A goal: both hands 25 cm above the table, fingers down."""
    left, right = (ulna.pose((x, y, 0.25), rpy=(np.pi, 0.0, 0.0)) for x, y in ((x_left, y_left), (x_right, y_right)))
    return {"left_ee": left, "right_ee": right}


there = cell.plan(home, hands(0.65, 0.0, 0.35, -0.1), world)  # the left hand is far out in the middle, the right one near
assert there, there
goal = hands(0.35, 0.1, 0.65, 0.0)  # now the right hand is far out, the left one near
exchange = cell.plan(there.path[-1], goal, world)
assert exchange, exchange

straight = cell.edge_in_collision(exchange.path[0], exchange.path[-1], world)
pair = cell.check_collision(straight.q, world, max_distance=1e-3).pairs[0]
print(f"on a straight line in joint space, {pair.name_a} touches {pair.name_b} after {straight.free_until:.0%} of the path")
assert straight.in_collision
print(f"planned: {exchange}")
assert exchange.certified

motion = exchange.trajectory(acceleration=4.0)
samples = motion.at(np.linspace(0.0, motion.duration, 2000)).q
nearest = cell.signed_distance(samples, world).min()
print(f"trajectory: {motion}; the smallest distance is {1e3 * nearest:.1f} mm")
assert nearest > 0
for link, T in goal.items():
    assert np.allclose(cell.forward_kinematics(samples[-1], link=link), T, atol=1e-4)

if "--view" in sys.argv:
    with ulna.view(cell, world, q=exchange.path[0], open_browser=True) as view:
        print(f"{view.url}: the arms exchange their places; Ctrl-C ends", flush=True)
        try:
            for t in itertools.cycle(np.arange(0.0, motion.duration + 1.0, 1 / 30)):
                view.q = motion.at(t).q
                time.sleep(1 / 30)
        except KeyboardInterrupt:
            pass
